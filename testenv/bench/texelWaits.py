# SPDX-License-Identifier: Apache-2.0
"""What waiting for texels costs: seconds of a render by the size of its texture pool (docs/decisions/0015-texels-wait-in-place.md).

    texelWaits.py STAGE POOL... [--samples 16] [--imageWidth 640] [--repeats 3]

Prints a row for each pool and repeat, interleaved: seconds of the render, of requests and of shading, launches of shading over those
that textures in device memory need, and look-ups that missed. The first pool should hold all that the picture takes. Run it with
PYTHONPATH=build/release/python."""

import argparse
import pathlib
import sys
import tempfile

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import Record  # noqa: E402


def Main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stage")
    parser.add_argument("pools", nargs="+", metavar="POOL")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--imageWidth", type=int, default=640)
    parser.add_argument("--repeats", type=int, default=3)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as cache:
        Record(args.stage, cache, residency="stream", samples=1, imageWidth=args.imageWidth)  # kernels and pages are warm then
        print("pool      render  requests  shade  launches      missed")
        for _ in range(args.repeats):
            for pool in args.pools:
                values = Record(args.stage, cache, residency="stream", textureMemory=pool, samples=args.samples,
                                imageWidth=args.imageWidth)
                time, texture = values["time"], values["texture"]
                print(f"{pool:8}  {time['render']:6.2f}  {time['requests']:8.2f}  {time['shade']:5.2f}  "
                      f"{texture['shadeIterations']:4} / {texture['shadePasses']:4}  {texture['misses'] / texture['lookups']:6.1%}",
                      flush=True)


if __name__ == "__main__":
    Main()
