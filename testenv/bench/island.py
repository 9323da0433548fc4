# SPDX-License-Identifier: Apache-2.0
"""An island (testenv/stages/island.py) in little memory: island.py [--sizes 0.01,0.1] [options]

Renders one sample at 1024 x 429 with a budget of 512 MiB for geometry, cold (an empty cache, but for kernels) and warm,
one process a render. Prints what the stage has, the memory of the process without pages of files, the most that the
device's allocator has given out, seconds to the first pixel, CPU seconds of the process, nanoseconds a ray and bytes
loaded. Stages and caches are kept in --scratch, where they are found again.
"""

import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench import islandRun  # noqa: E402
from bench.recordRun import FreshCache, RunFailed  # noqa: E402


def Row(size: float, camera: str, kind: str, run: dict, figures: dict) -> dict:
    time, geometry = run["time"], run["geometry"]
    return {"size": f"{size:g}", "camera": camera, "cache": kind, **figures, "first pixel s": f"{time['firstPixel']:.1f}",
            "read USD s": f"{time['load'] + time['translate']:.1f}", "render s": f"{time['render']:.1f}",
            "pages MB": f"{geometry['bytesTotal'] / 1e6:.0f}",
            "loads of each byte": f"{geometry['uploadedBytes'] / max(1, geometry['uniqueBytesLoaded']):.2f}"}


def main() -> None:
    parser = islandRun.Parser(__doc__)
    parser.add_argument("--sizes", type=lambda text: [float(word) for word in text.split(",")], default=[0.01, 0.1])
    parser.add_argument("--instanceChunks", default=str(1 << 16), help="as of hdstream record; 0: records in tables")
    args = parser.parse_args()
    with islandRun.Scratch(args) as folder:
        for size in args.sizes:
            stage, _ = islandRun.Stage(folder, size)
            table = islandRun.Table()
            for camera in args.cameras:
                cache = FreshCache(folder / f"cache-{size:g}", folder / "kernels")
                for kind in ("cold", "warm"):
                    try:
                        run, figures = islandRun.Render(stage, cache, camera, args, instanceChunks=args.instanceChunks)
                    except RunFailed as error:
                        table.AddFailure(f"{size:g} {camera} {kind}", error)
                        break
                    table.Add(Row(size, camera, kind, run, figures))


if __name__ == "__main__":
    main()
