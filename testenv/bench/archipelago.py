# SPDX-License-Identifier: Apache-2.0
"""Many islands (testenv/stages/island.py) by one more level of instancing: archipelago.py [--counts 1,4,26,256] [options]

Renders one sample with a budget of 512 MiB for geometry, one process a render, each twice with one cache, and prints the
second: what the stage places, the memory of the process without pages of files, the most that the device's allocator
has given out, CPU seconds of the process, seconds to prepare, nanoseconds a ray and bytes loaded. Stages and caches are kept in --scratch, where
they are found again.
"""

import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench import islandRun  # noqa: E402
from bench.recordRun import RunFailed  # noqa: E402
from stages import island  # noqa: E402


def Row(size: float, count: int, camera: str, placed: dict, run: dict, figures: dict) -> dict:
    return {"size": f"{size:g}", "islands": str(count), "camera": camera, "instances placed": f"{run['geometry']['instances']:.3g}",
            "quads placed": f"{count * placed['quads placed']:.3g}", **figures}


def main() -> None:
    parser = islandRun.Parser(__doc__)
    parser.add_argument("--size", type=float, default=0.01)
    parser.add_argument("--counts", type=lambda text: [int(word) for word in text.split(",")], default=[1, 4, 26, 256])
    parser.add_argument("--instanceChunks", default=str(1 << 16), help="as of hdstream record; 0: records in tables")
    args = parser.parse_args()
    with islandRun.Scratch(args) as folder:
        one, placed = islandRun.Stage(folder, args.size)
        table = islandRun.Table()
        for camera in args.cameras:
            for count in args.counts:
                stage = folder / f"archipelago-{args.size:g}-{count}.usdc"
                island.WriteArchipelago(stage, one, count, args.size)
                cache = folder / f"cache-archipelago-{args.size:g}"
                try:
                    islandRun.Render(stage, cache, camera, args, instanceChunks=args.instanceChunks)
                    run, figures = islandRun.Render(stage, cache, camera, args, instanceChunks=args.instanceChunks)
                except RunFailed as error:
                    table.AddFailure(f"{count} {camera}", error)
                    break
                table.Add(Row(args.size, count, camera, placed, run, figures))


if __name__ == "__main__":
    main()
