# SPDX-License-Identifier: Apache-2.0
"""What the benches of generated islands (testenv/stages/island.py) share: the stage, options, a render and its figures."""

import argparse
import contextlib
import json
import pathlib
import tempfile

from bench.recordRun import AnonymousPeak, Record, RunFailed
from stages import island


def Parser(description: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cameras", type=lambda text: text.split(","), default=["Camera", "Inside"])
    parser.add_argument("--width", type=int, default=1024)
    parser.add_argument("--samples", type=int, default=1)
    parser.add_argument("--geometryMemory", default="512M")
    parser.add_argument("--hostMemory", default="4G")
    parser.add_argument("--limit", type=float, default=3600, help="seconds for one render")
    parser.add_argument("--mostMemory", type=float, default=1e6, help="MB without pages of files at which a render is ended")
    parser.add_argument("--scratch", type=pathlib.Path, help="folder that keeps stages and caches")
    return parser


@contextlib.contextmanager
def Scratch(args):
    """The folder for stages and caches."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.scratch or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        yield folder


def Stage(folder: pathlib.Path, size: float) -> tuple[pathlib.Path, dict]:
    """(the stage of this size, what it has by name); written when it is not there."""
    stage = folder / f"island-{size:g}.usdc"
    about = stage.with_suffix(".json")
    if not about.exists():
        about.write_text(json.dumps(island.WriteIsland(stage, size)))
    counts = json.loads(about.read_text())
    print(f"\nsize {size:g}: " + ", ".join(f"{count:,} {what}" for what, count in counts.items()) + "\n", flush=True)
    return stage, counts


def Render(stage, cache, camera: str, args, **options) -> tuple[dict, dict]:
    """(statistics, figures that both benches print). Raises RunFailed."""
    anonymous = AnonymousPeak()

    def Watch(process: int) -> None:
        anonymous(process)
        if anonymous.bytes > 1e6 * args.mostMemory:
            raise RunFailed(f"more than {args.mostMemory:.0f} MB without pages of files")

    run = Record(stage, cache, args.limit, onPoll=Watch, camera=f"/World/{camera}", imageWidth=args.width, samples=args.samples,
                 residency="stream", geometryMemory=args.geometryMemory, hostMemory=args.hostMemory, **options)
    rays = sum(run["rays"][name] for name in ("camera", "indirect", "shadow"))
    return run, {
        "without pages of files MB": f"{anonymous.bytes / 1e6:.0f}",
        "device peak MB": f"{run['memory']['devicePeak'] / 1e6:.0f}",
        "always resident MB": f"{run['geometry']['alwaysResidentBytes'] / 1e6:.0f}",
        "prepare s": f"{run['time']['prepare']:.1f}",
        "CPU s": f"{run['cpuSeconds']:.1f}",
        "ns a ray": f"{1e9 * run['time']['trace'] / rays:.0f}",
        "loaded MB": f"{run['geometry']['uploadedBytes'] / 1e6:.0f}",
    }


class Table:
    """Rows of figures by name; the first one brings the head."""

    def __init__(self):
        self._hasHead = False

    def Add(self, row: dict) -> None:
        if not self._hasHead:
            print("| " + " | ".join(row) + " |\n" + "|---" * len(row) + "|", flush=True)
            self._hasHead = True
        print("| " + " | ".join(row.values()) + " |", flush=True)

    @staticmethod
    def AddFailure(what: str, error: RunFailed) -> None:
        print(f"<!-- {what}: {error} -->", flush=True)
