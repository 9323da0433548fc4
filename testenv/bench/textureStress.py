# SPDX-License-Identifier: Apache-2.0
"""The report's stress scene (its figures 5 and 6): lines and bytes of textures loaded against samples per pixel.

    textureStress.py FOLDER [--count 962] [--size 2048] [--heights 720,1080,2160] [--samples 1,2,5,10,20,40,64] [--out STEM]
    textureStress.py FOLDER --budgets 100%,10%,1%,... [--heights 720]
    textureStress.py FOLDER --firstPixel [--heights 720]

The first form renders the stage of testenv/stages/textureStress.py, which it makes in FOLDER, once for each height and
number of samples, in processes of their own, and draws the charts STEM-lines.svg and STEM-share.svg. The report: 3592 MB of
textures, all that is needed is loaded after about 20 samples. Bars: at most 0.5 % of bytesTotal at 720p, 2160p loads
more, no texel falls back. The second form compares budgets with resident textures: pictures have the same bits; times are
over the resident one's. The third has an empty cache but for kernels and a small pool, and looks at a part of the wall without bounces,
which would see all the others: seconds to the first complete sample, with textures prepared when they are asked for and with all of them
prepared before.
"""

import argparse
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import FreshCache, Record, Segments  # noqa: E402
from stages import textureStress  # noqa: E402
from support.svgChart import Chart  # noqa: E402


def _Integers(text: str) -> list:
    return [int(word) for word in text.split(",")]


def _Render(args, stage, height: int, samples: int, **options) -> dict:
    return Record(stage, args.cache, camera="/World/Camera", imageWidth=height * 16 // 9, samples=samples,
                  maxDepth=args.maxDepth, **options)


def Grow(args, stage):
    """Yields a row for each height and number of samples."""
    for height in args.heights:
        before = (0, 0)
        for samples in args.samples:
            run = _Render(args, stage, height, samples, residency="stream", textureMemory=args.textureMemory)
            texture = run["texture"]
            assert texture["fallbackTexels"] == 0 and texture["peakBytes"] <= texture["budget"]
            counts = (texture["misses"], texture["lookups"])
            yield dict(height=height, samples=samples, lines=texture["linesLoaded"], megabytes=texture["uniqueBytesLoaded"] / 1e6,
                       percent=100 * texture["uniqueBytesLoaded"] / texture["bytesTotal"], fallback=texture["fallbackTexels"],
                       misses=counts[0] / counts[1], missesSince=(counts[0] - before[0]) / max(1, counts[1] - before[1]),
                       pool=texture["peakBytes"] / 1e6, seconds=run["time"]["render"], total=texture["bytesTotal"],
                       source=texture["bytesSource"])
            before = counts


def GrowthChart(args, rows: list, key: str, label: str) -> Chart:
    """A curve for each height."""
    chart = Chart(f"{args.count} textures of {args.size} x {args.size}", "samples per pixel", label)
    for height in args.heights:
        curve = [row for row in rows if row["height"] == height]
        chart.Add(f"{height}p", [row["samples"] for row in curve], [row[key] for row in curve])
    return chart


def _PrintGrowth(args, stage) -> None:
    """Lines loaded against samples."""
    print("| height | samples | lines | MB | % of bytesTotal | fallback texels | misses per look-up | in samples since the row before "
          "| pool MB | time.render s |")
    print("|---" * 10 + "|", flush=True)
    rows = []
    for row in Grow(args, stage):
        rows.append(row)
        print(f"| {row['height']} | {row['samples']} | {row['lines']} | {row['megabytes']:.2f} | {row['percent']:.3f} | "
              f"{row['fallback']} | {row['misses']:.2e} | {row['missesSince']:.2e} | {row['pool']:.0f} | {row['seconds']:.1f} |",
              flush=True)
    print(f"<!-- bytesTotal {row['total'] / 1e6:.0f} MB, bytesSource {row['source'] / 1e6:.0f} MB -->")
    if args.out:
        GrowthChart(args, rows, "megabytes", "MB loaded").Save(f"{args.out}-lines")
        GrowthChart(args, rows, "percent", "% of all lines").Save(f"{args.out}-share")


def _CompareBudgets(args, stage) -> None:
    """Time and bytes at budgets, over resident textures."""
    height, samples = args.heights[0], args.samples[-1]
    resident = _Render(args, stage, height, samples, residency="resident")
    print("| pool | MB | render s | over resident | CPU s over resident | MB loaded | evictions | shading launches over passes | "
          "misses per look-up |")
    print("|---" * 9 + "|", flush=True)
    print(f"| resident | {resident['texture']['peakBytes'] / 1e6:.1f} | {resident['time']['render']:.2f} | 1 | 1 | | | | |",
          flush=True)
    for budget in args.budgets:
        run = _Render(args, stage, height, samples, residency="stream", textureMemory=budget)
        assert run["pictureBytes"] == resident["pictureBytes"], f"the picture at {budget} differs"
        texture = run["texture"]
        assert texture["fallbackTexels"] == 0 and texture["peakBytes"] <= texture["budget"]
        print(f"| {budget} | {texture['peakBytes'] / 1e6:.1f} | {run['time']['render']:.2f} | "
              f"{run['time']['render'] / resident['time']['render']:.2f} | {run['cpuSeconds'] / resident['cpuSeconds']:.2f} | "
              f"{texture['uploadedBytes'] / 1e6:.1f} | {texture['evictions']} | "
              f"{texture['shadeIterations'] / texture['shadePasses']:.2f} | {texture['misses'] / texture['lookups']:.1e} |",
              flush=True)


def _MeasureFirstPixel(args, stage) -> None:
    print("| textures | first pixel s | MB loaded | cache MB |")
    print("|---" * 4 + "|", flush=True)
    warm = args.folder / "kernels"
    for name, options in (("on demand, 64 MB", dict(residency="stream", textureMemory="64M")),
                          ("on demand, warm", dict(residency="stream", textureMemory="64M")),
                          ("all before", dict(residency="stream", textureMemory="1%"))):  # a share opens all textures
        if not warm.exists():
            Record(stage, FreshCache(warm), camera="/World/Wall", imageWidth=64, samples=1, maxDepth=0, residency="stream")
        cache = args.folder / "first"
        if "warm" not in name:
            FreshCache(cache, warm)
        run = Record(stage, cache, camera="/World/Wall", imageWidth=args.heights[0] * 16 // 9, samples=1,
                     maxDepth=0, **options)
        texture = run["texture"]
        used = sum(path.stat().st_blocks * 512 for path in Segments(cache))
        print(f"| {name} | {run['time']['firstPixel']:.1f} | "
              f"{texture['uploadedBytes'] / 1e6:.1f} | {used / 1e6:.0f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--firstPixel", action="store_true")
    parser.add_argument("--count", type=int, default=textureStress.COUNT)
    parser.add_argument("--size", type=int, default=textureStress.SIZE)
    parser.add_argument("--heights", type=_Integers, default=[720, 1080, 2160])
    parser.add_argument("--samples", type=_Integers, default=[1, 2, 5, 10, 20, 40, 64])
    parser.add_argument("--maxDepth", type=int, default=4)
    parser.add_argument("--textureMemory", default="1G", help="the report's cache")
    parser.add_argument("--budgets", type=lambda text: text.split(","), default=[])
    parser.add_argument("--out", help="stem of the charts")
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    args.cache = args.folder / "cache"
    stage = args.folder / f"stress{args.count}x{args.size}.usda"
    if not stage.exists():
        textureStress.WriteTextureStress(stage, args.count, args.size)
    if args.firstPixel:
        _MeasureFirstPixel(args, stage)
    elif args.budgets:
        _CompareBudgets(args, stage)
    else:
        _PrintGrowth(args, stage)


if __name__ == "__main__":
    main()
