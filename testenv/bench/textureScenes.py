# SPDX-License-Identifier: Apache-2.0
"""How much of its textures a picture takes, the report's table 1: textureScenes.py CACHE STAGE[:CAMERA]... [--width 1280]

Renders each stage with streamed textures, in a process of its own, and prints a row of a Markdown table: textures,
bytes as the files hold them decoded (base level) and as prepared with all mips, bytes the picture's lines take, and
the same as parts of both. The report's eight scenes took 0.7 to 11 % of their textures.
"""

import argparse
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import Record  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cache", type=pathlib.Path)
    parser.add_argument("stages", nargs="+")
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=720)
    parser.add_argument("--samples", type=int, default=32)
    args = parser.parse_args()
    print("| scene | textures | MB decoded | MB prepared | lines loaded | MB loaded | % of prepared | % of decoded | misses per look-up |")
    print("|---" * 9 + "|", flush=True)
    for word in args.stages:
        stage, _, camera = word.partition(":")
        run = Record(stage, args.cache, imageWidth=args.width, imageHeight=args.height, samples=args.samples,
                     residency="stream", **(dict(camera=camera) if camera else {}))
        texture = run["texture"]
        loaded = texture["uniqueBytesLoaded"]
        print(f"| {pathlib.Path(stage).stem} {camera.rpartition('/')[2]} | {texture['textures']} | {texture['bytesSource'] / 1e6:.1f} | "
              f"{texture['bytesTotal'] / 1e6:.1f} | {texture['linesLoaded']} | {loaded / 1e6:.2f} | "
              f"{100 * loaded / texture['bytesTotal']:.2f} | {100 * loaded / texture['bytesSource']:.2f} | "
              f"{texture['misses'] / texture['lookups']:.1e} |", flush=True)


if __name__ == "__main__":
    main()
