# SPDX-License-Identifier: Apache-2.0
"""Preparation before the first complete image, lazy against eager, and from the persistent cache.

    lazyPreparation.py [grove] [gardens] [--triangles N] [--maxDepth 8,0] [--stage FILE:CAMERA ...]

One sample of a small picture, each in a process of its own: eager with an empty cache, lazy with an empty cache, lazy
with the cache that the run before left (its files in memory, and again after they were dropped from it, where that
works). `prepare` is time.prepare: plans and top trees, and the pages that were built or read. Target: lazy over eager at
most 1.2 x the touched part of the bytes + 0.02; from the cache at most twice the time of plainly reading the bytes.
"""

import argparse
import pathlib
import shutil
import sys
import tempfile
import time

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import DropFromMemory, FreshCache, Record, Segments  # noqa: E402
from stages import grove  # noqa: E402

_GENERATED = {
    "grove": lambda path, triangles: grove.WriteGrove(path, triangles),
    "gardens": lambda path, triangles: grove.WriteGrove(path, triangles, gardens=5),
}
_BLOCK = 1 << 20


def ReadSeconds(cache, numBytes: int) -> float:
    """Seconds of reading so many bytes of the segments in order."""
    start = time.perf_counter()
    left = numBytes
    for path in Segments(cache):
        with open(path, "rb", buffering=0) as file:
            buffer = bytearray(_BLOCK)
            while left > 0 and (count := file.readinto(buffer)) > 0:
                left -= count
    return time.perf_counter() - start


def Measure(stage: str, camera: str, maxDepth: int, args, folder: pathlib.Path) -> list:
    """The cells of a row."""
    options = dict(camera=camera, imageWidth=args.width, samples=1, maxDepth=maxDepth, residency="stream",
                   geometryMemory=args.geometryMemory)
    eager = Record(stage, FreshCache(folder / "eager"), prepare="eager", **options)
    cache = FreshCache(folder / "lazy", kernelsFrom=folder / "eager")
    shutil.rmtree(folder / "eager")
    lazy = Record(stage, cache, **options)
    warm = Record(stage, cache, **options)
    needed = lazy["geometry"]["uniqueBytesLoaded"]
    readWarm = ReadSeconds(cache, needed)
    cold = readCold = None
    if DropFromMemory(cache):
        cold = Record(stage, cache, **options)
        DropFromMemory(cache)
        readCold = ReadSeconds(cache, needed)
    assert len({run["pictureBytes"] for run in (eager, lazy, warm)}) == 1, "the pictures differ"
    chunks = lazy["geometry"]["chunksTouched"] / lazy["geometry"]["chunks"]
    touched = needed / eager["geometry"]["bytesTotal"]
    seconds = {name: run["time"]["prepare"] for name, run in (("eager", eager), ("lazy", lazy), ("warm", warm))}
    print(f"<!-- {camera} depth {maxDepth}: built {eager['geometry']['chunksBuilt']} {lazy['geometry']['chunksBuilt']} "
          f"{warm['geometry']['chunksBuilt']}, of {lazy['geometry']['chunks']}; render {eager['time']['render']:.1f} "
          f"{lazy['time']['render']:.1f} {warm['time']['render']:.1f} s -->", file=sys.stderr, flush=True)
    cells = [camera, str(maxDepth), f"{eager['geometry']['bytesTotal'] / 1e6:.0f}", f"{chunks:.3f}", f"{touched:.3f}",
             f"{seconds['eager']:.2f}", f"{seconds['lazy']:.2f}", f"{seconds['lazy'] / seconds['eager']:.3f}",
             f"{1.2 * touched + 0.02:.3f}", f"{seconds['warm']:.2f}", f"{readWarm:.2f}"]
    cells += [f"{cold['time']['prepare']:.2f}", f"{readCold:.2f}"] if cold else ["not measured", ""]
    cells.append(" ".join(f"{run['cpuSeconds']:.1f}" for run in (eager, lazy, warm)))
    return cells


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", default=list(_GENERATED), help="of generated stages")
    parser.add_argument("--stage", action="append", default=[], help="FILE:CAMERA[,CAMERA]")
    parser.add_argument("--triangles", type=int, default=20_000_000)
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--geometryMemory", default="8G", help="a pool in which all has room")
    parser.add_argument("--maxDepth", type=lambda text: [int(word) for word in text.split(",")], default=[8, 0])
    args = parser.parse_args()
    print("| stage, camera | bounces | MB | touched: chunks | bytes | eager s | lazy s | ratio | target | warm s | "
          "read s | files not in memory: s | read s | CPU s of the processes |\n" + "|---" * 14 + "|", flush=True)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        stages = [(stage.rpartition(":")[0], stage.rpartition(":")[2].split(",")) for stage in args.stage]
        for generated in args.names if not args.stage else ():
            _GENERATED[generated](f"{folder}/{generated}.usdc", args.triangles)
            stages.append((f"{folder}/{generated}.usdc", ["/World/Camera", "/World/Inside"]))
        for path, cameras in stages:
            for camera in cameras:
                for maxDepth in args.maxDepth:
                    cells = Measure(path, camera, maxDepth, args, folder)
                    cells[0] = f"{pathlib.Path(path).stem}, {cells[0]}"
                    print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
