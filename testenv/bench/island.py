# SPDX-License-Identifier: Apache-2.0
"""An island (testenv/stages/island.py) in little memory: island.py [--sizes 0.01,0.1] [options]

Renders one sample at 1024 x 429 with a budget of 512 MiB for geometry, cold (an empty cache, but for kernels) and warm,
one process a render. Prints what the stage has, the memory of the process without pages of files, the most that the
device's allocator has given out, seconds to the first pixel, CPU seconds of the process, nanoseconds a ray and bytes
loaded. Stages and caches are kept in --scratch, where they are found again.
"""

import argparse
import json
import pathlib
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import AnonymousPeak, FreshCache, Record, RunFailed  # noqa: E402
from stages import island  # noqa: E402

HEAD = ("| size | camera | cache | without pages of files MB | device peak MB | always resident MB | first pixel s | read USD s | prepare s | "
        "render s | CPU s | ns a ray | pages MB | loaded MB | loads of each byte |\n" + "|---" * 15 + "|")


def Stage(folder: pathlib.Path, size: float) -> pathlib.Path:
    """The stage of this size; written when it is not there."""
    stage = folder / f"island-{size:g}.usdc"
    about = stage.with_suffix(".json")
    if not about.exists():
        about.write_text(json.dumps(island.WriteIsland(stage, size)))
    counts = json.loads(about.read_text())
    print(f"\nsize {size:g}: " + ", ".join(f"{count:,} {what}" for what, count in counts.items()) + "\n", flush=True)
    return stage


def Row(size: float, camera: str, kind: str, run: dict, anonymous: int) -> str:
    time, memory, geometry, rays = run["time"], run["memory"], run["geometry"], run["rays"]
    nanoseconds = 1e9 * time["trace"] / sum(rays[name] for name in ("camera", "indirect", "shadow"))
    loads = geometry["uploadedBytes"] / max(1, geometry["uniqueBytesLoaded"])
    megabytes = [value / 1e6 for value in (anonymous, memory["devicePeak"], geometry["alwaysResidentBytes"])]
    seconds = [time["firstPixel"], time["load"] + time["translate"], time["prepare"], time["render"]]
    cells = [f"{size:g}", camera, kind, *(f"{value:.0f}" for value in megabytes), *(f"{value:.1f}" for value in seconds),
             f"{run['cpuSeconds']:.0f}", f"{nanoseconds:.0f}", f"{geometry['bytesTotal'] / 1e6:.0f}", f"{geometry['uploadedBytes'] / 1e6:.0f}", f"{loads:.2f}"]
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=lambda text: [float(word) for word in text.split(",")], default=[0.01, 0.1])
    parser.add_argument("--cameras", type=lambda text: text.split(","), default=["Camera", "Inside"])
    parser.add_argument("--width", type=int, default=1024)
    parser.add_argument("--samples", type=int, default=1)
    parser.add_argument("--geometryMemory", default="512M")
    parser.add_argument("--hostMemory", default="4G")
    parser.add_argument("--instanceChunks", default=str(1 << 16), help="as of hdstream record; 0: records in tables")
    parser.add_argument("--limit", type=float, default=3600, help="seconds for one render")
    parser.add_argument("--scratch", type=pathlib.Path, help="folder that keeps stages and caches")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.scratch or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for size in args.sizes:
            stage = Stage(folder, size)
            print(HEAD, flush=True)
            for camera in args.cameras:
                cache = FreshCache(folder / f"cache-{size:g}", folder / "kernels")
                for kind in ("cold", "warm"):
                    anonymous = AnonymousPeak()
                    try:
                        run = Record(stage, cache, args.limit, onPoll=anonymous, camera=f"/World/{camera}", imageWidth=args.width,
                                     samples=args.samples, residency="stream", geometryMemory=args.geometryMemory,
                                     hostMemory=args.hostMemory, instanceChunks=args.instanceChunks)
                    except RunFailed as error:
                        print(f"<!-- {size:g} {camera} {kind}: {error} -->", flush=True)
                        break
                    print(Row(size, camera, kind, run, anonymous.bytes), flush=True)


if __name__ == "__main__":
    main()
