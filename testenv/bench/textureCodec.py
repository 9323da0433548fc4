# SPDX-License-Identifier: Apache-2.0
"""What the texture codec loses at 1:2, and how fast it is: textureCodec.py SCENES [--program P] [--out STEM] [--rows FILE]

All images of 8 bits below the folder SCENES, each content once. Prints per image PSNR and speed, then the summary: images
above 70 dB, which have next to no detail, are left out of it. The chart is the mean error against the rate: of plainly
rounded codes, of the report's scheme with differences of 2 to 6 bits, and of ours, which has one rate. Needs
HDSTREAM_BUILD_BENCH=ON.
"""

import argparse
import csv
import hashlib
import io
import pathlib
import statistics
import subprocess
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from support.svgChart import Chart  # noqa: E402

_EXTENSIONS = {".png", ".jpg", ".jpeg", ".tga", ".tif", ".tiff", ".bmp"}
_LOSSLESS = 70.0  # dB: above it an image has next to no detail, and would lift every mean
_CURVE = (2, 3, 4, 5, 6)
_HEAD_BITS = 11  # of a channel of a block in the report's scheme: base and shift


def Images(folder: str) -> list:
    """Files, one of each content."""
    known, files = set(), []
    for path in sorted(pathlib.Path(folder).rglob("*")):
        if path.suffix.lower() in _EXTENSIONS and path.is_file():
            content = hashlib.sha256(path.read_bytes()).digest()
            if content not in known:
                known.add(content)
                files.append(str(path))
    return files


def Measure(program: str, files: list) -> list:
    text = subprocess.run([program, *files], capture_output=True, text=True, check=True).stdout
    return [{key: value if key == "file" else float(value) for key, value in row.items()}
            for row in csv.DictReader(io.StringIO(text))]


def RootMeanSquare(rows: list, key: str) -> float:
    """Of the errors in codes, by the mean of the PSNR."""
    return 255.0 * 10.0 ** (-statistics.mean(row[key] for row in rows) / 20.0)


def PrintRows(rows: list, folder: str) -> None:
    print("| image | texels | channels | ours dB | report's scheme dB | encode MB/s | prepare MB/s |\n" + "|---" * 7 + "|")
    for row in sorted(rows, key=lambda r: r["ours"]):
        size = f"{row['width']:.0f}x{row['height']:.0f}"
        print(f"| {pathlib.Path(row['file']).relative_to(folder)} | {size} | {row['channels']:.0f} | {row['ours']:.1f} | "
              f"{row['report']:.1f} | {row['encodeMBps']:.0f} | {row['prepareMBps']:.0f} |")


def PrintSummary(rows: list) -> None:
    rated = [row for row in rows if row["ours"] <= _LOSSLESS]
    normals = [row for row in rows if "normal" in pathlib.Path(row["file"]).stem.lower()]
    print(f"\n{len(rows)} images, {len(rated)} of them at most {_LOSSLESS:.0f} dB; {len(normals)} normal maps\n")
    print("| scheme | rate | median dB | mean dB | worst dB | normal maps, mean error in degrees: mean, worst |\n" + "|---" * 6 + "|")
    for name, key in (("report's", "report"), ("ours", "ours"), ("4 bits a channel", "plain4")):
        values = [row[key] for row in rated]
        angles = [row[f"{key}Degrees"] for row in normals if row["channels"] == 4] if f"{key}Degrees" in rows[0] else []
        text = f"{statistics.mean(angles):.3f}, {max(angles):.3f}" if angles else "-"
        print(f"| {name} | 1:2 | {statistics.median(values):.1f} | {statistics.mean(values):.1f} | {min(values):.1f} | {text} |")
    print("| none | 1:1 | exact | exact | exact | 0 |")
    for channels in sorted({row["channels"] for row in rated}):
        group = [row for row in rated if row["channels"] == channels]
        print(f"\n{channels:.0f} channels, {len(group)} images: median {statistics.median(r['ours'] for r in group):.1f} dB, "
              f"encode {statistics.median(r['encodeMBps'] for r in group):.0f} MB/s, "
              f"prepare {statistics.median(r['prepareMBps'] for r in group):.0f} MB/s", end="")
    print()


def Draw(rows: list, stem: str) -> None:
    """Error against rate, of the opaque colours."""
    colors = [row for row in rows if row["channels"] == 4 and row["ours"] <= _LOSSLESS]
    chart = Chart(f"Error against rate, {len(colors)} colour textures", "bits a texel (RGB)", "root mean square error, codes of 255")
    chart.Add("rounded", [3 * bits for bits in _CURVE], [RootMeanSquare(colors, f"plain{bits}") for bits in _CURVE])
    chart.Add("report's", [3 * (bits + _HEAD_BITS / 16) for bits in _CURVE],
              [RootMeanSquare(colors, f"report{bits}") for bits in _CURVE])
    chart.Add("ours", [16], [RootMeanSquare(colors, "ours")])
    chart.Save(stem)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", help="folder of textures")
    parser.add_argument("--program", default="build/release/testenv/bench/benchTextureCodec")
    parser.add_argument("--out", help="stem of the chart (SVG) and its numbers (CSV)")
    parser.add_argument("--rows", help="CSV of all measurements")
    args = parser.parse_args()
    rows = Measure(args.program, Images(args.scenes))
    PrintRows(rows, args.scenes)
    PrintSummary(rows)
    if args.out:
        Draw(rows, args.out)
    if args.rows:
        with open(args.rows, "w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(dict(row, file=pathlib.Path(row["file"]).relative_to(args.scenes)) for row in rows)


if __name__ == "__main__":
    main()
