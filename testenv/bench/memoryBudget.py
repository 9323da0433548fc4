# SPDX-License-Identifier: Apache-2.0
"""Is the budget kept, by the process's own memory? memoryBudget.py [STAGE.usd] [--camera NAME] [--budgets 32M,96M,160M]

On a CPU device all device memory is the process's memory. So the memory of two processes that differ only in
--geometryMemory (RssAnon of /proc/self/status after the render, with the pool still there and what the allocator of the
C library keeps given back) must differ by what the budgets do; and what the allocator of the device says it has given
out must differ by exactly that. The wave size is fixed, since by default waves grow with the memory that the pool
saves. Without a stage: a terrain of 8 M triangles.
"""

import argparse
import ctypes
import json
import pathlib
import subprocess
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import FreshCache  # noqa: E402
from stages import bench  # noqa: E402

_CELLS = 2000
_WAVE = 1 << 16


def AnonymousBytes() -> int:
    ctypes.CDLL(None).malloc_trim(0)
    lines = pathlib.Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("RssAnon:"))


def RenderHere(stage: str, settings: dict) -> None:
    """Prints statistics and memory of this process as JSON."""
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    session = _core.Session()
    TranslateStage(Usd.Stage.Open(stage), session, Usd.TimeCode.Default())
    options = _core.Settings()
    for name, value in settings.items():
        setattr(options, name, value)
    session.Render(options)
    statistics = json.loads(session.Statistics())
    statistics["anonymous"] = AnonymousBytes()
    print(json.dumps(statistics))


def Render(stage: str, **settings) -> dict:
    """The same in a process of its own."""
    command = [sys.executable, __file__, stage, "--child", json.dumps(settings)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[-1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage", nargs="?")
    parser.add_argument("--camera", default="/World/Camera")
    parser.add_argument("--budgets", type=lambda text: text.split(","), default=["32M", "96M", "160M"])
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--child", type=json.loads, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.child:
        RenderHere(args.stage, args.child)
        return
    with tempfile.TemporaryDirectory() as folder:
        stage = args.stage or f"{folder}/terrain.usdc"
        if not args.stage:
            bench.WriteTerrain(stage, cells=_CELLS)
        settings = dict(camera=args.camera, imageWidth=args.width, imageHeight=args.width * 9 // 16, samples=1,
                        residency="stream", hostMemory=16 << 20, waveSize=_WAVE, cacheDirectory=str(FreshCache(f"{folder}/cache")))
        Render(stage, prepare="eager", geometryMemory=args.budgets[-1], **settings)  # fills the cache
        runs = [Render(stage, geometryMemory=budget, **settings) for budget in args.budgets]
    first = runs[0]
    print("| budget | pool MB | device peak MB | process MB | more than the first: pool | device peak | process |\n" + "|---" * 7 + "|")
    for budget, run in zip(args.budgets, runs):
        values = (run["geometry"]["budget"], run["memory"]["devicePeak"], run["anonymous"],
                  run["geometry"]["budget"] - first["geometry"]["budget"],
                  run["memory"]["devicePeak"] - first["memory"]["devicePeak"], run["anonymous"] - first["anonymous"])
        print("| " + " | ".join([budget, *(f"{value / 1e6:.2f}" for value in values)]) + " |")
    assert len({run["memory"]["devicePeak"] - run["geometry"]["budget"] for run in runs}) == 1, "not only the pool differs"
    geometry = first["geometry"]
    allowed = 0.005 * geometry["bytesTotal"] + 100 * geometry["instances"]
    print(f"\n{geometry['bytesTotal'] / 1e6:.1f} MB of pages, {geometry['chunks']} chunks; always resident "
          f"{geometry['alwaysResidentBytes'] / 1e6:.3f} MB, {geometry['alwaysResidentBytes'] / allowed:.2f} of what is allowed "
          "(0.5 % of the pages and 100 bytes an instance)")


if __name__ == "__main__":
    main()
