# SPDX-License-Identifier: Apache-2.0
"""Many islands (testenv/stages/island.py) by one more level of instancing: archipelago.py [--counts 1,4,26,256] [options]

Renders one sample with a budget of 512 MiB for geometry, one process a render, each twice with one cache, and prints the
second: what the stage places, the memory of the process without pages of files, the most that the device's allocator
has given out, CPU seconds of the process, seconds to prepare, nanoseconds a ray and bytes loaded. Stages and caches are kept in --scratch, where
they are found again.
"""

import argparse
import json
import pathlib
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.island import Stage  # noqa: E402
from bench.recordRun import AnonymousPeak, Record, RunFailed  # noqa: E402
from stages import island  # noqa: E402

HEAD = ("| size | islands | camera | instances placed | quads placed | without pages of files MB | device peak MB | always resident MB | "
        "prepare s | CPU s | ns a ray | loaded MB |\n" + "|---" * 12 + "|")


def Row(size: float, count: int, camera: str, placed: dict, run: dict, anonymous: int) -> str:
    time, memory, geometry, rays = run["time"], run["memory"], run["geometry"], run["rays"]
    nanoseconds = 1e9 * time["trace"] / sum(rays[name] for name in ("camera", "indirect", "shadow"))
    megabytes = [value / 1e6 for value in (anonymous, memory["devicePeak"], geometry["alwaysResidentBytes"])]
    cells = [f"{size:g}", str(count), camera, f"{geometry['instances']:.3g}", f"{count * placed['quads placed']:.3g}",
             *(f"{value:.0f}" for value in megabytes), f"{time['prepare']:.1f}", f"{run['cpuSeconds']:.1f}", f"{nanoseconds:.0f}",
             f"{geometry['uploadedBytes'] / 1e6:.0f}"]
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=float, default=0.01)
    parser.add_argument("--counts", type=lambda text: [int(word) for word in text.split(",")], default=[1, 4, 26, 256])
    parser.add_argument("--cameras", type=lambda text: text.split(","), default=["Camera", "Inside"])
    parser.add_argument("--width", type=int, default=1024)
    parser.add_argument("--samples", type=int, default=1)
    parser.add_argument("--geometryMemory", default="512M")
    parser.add_argument("--hostMemory", default="4G")
    parser.add_argument("--limit", type=float, default=3600, help="seconds for one render")
    parser.add_argument("--scratch", type=pathlib.Path, help="folder that keeps stages and caches")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.scratch or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        one = Stage(folder, args.size)
        placed = json.loads(one.with_suffix(".json").read_text())
        print(HEAD, flush=True)
        for camera in args.cameras:
            for count in args.counts:
                stage = folder / f"archipelago-{args.size:g}-{count}.usdc"
                island.WriteArchipelago(stage, one, count, args.size)
                try:
                    for _ in range(2):
                        anonymous = AnonymousPeak()
                        run = Record(stage, folder / f"cache-archipelago-{args.size:g}", args.limit, onPoll=anonymous,
                                     camera=f"/World/{camera}", imageWidth=args.width, samples=args.samples, residency="stream",
                                     geometryMemory=args.geometryMemory, hostMemory=args.hostMemory)
                except RunFailed as error:
                    print(f"<!-- {count} {camera}: {error} -->", flush=True)
                    break
                print(Row(args.size, count, camera, placed, run, anonymous.bytes), flush=True)


if __name__ == "__main__":
    main()
