# SPDX-License-Identifier: Apache-2.0
"""Error of filtered textures against bytes loaded and time: textureQuality.py FOLDER [--out STEM] [options]

Cards of the stress scene glow, so that a picture has no noise but that of where samples fall in a pixel. The reference has
1024 samples a pixel that each read the nearest texels of the finest mip (mipBias -16). They are the same compressed texels:
what the codec loses is in none of the figures (textureCodec.py has it). Error is relMSE: the mean of
(a - b)^2 / (b^2 + 0.01), with mip biases; each run is a session of its own, textures prepared before; times are without
preparing and compiling. The charts have error against megabytes loaded and against seconds.
"""

import argparse
import pathlib
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.sceneRun import RelMse, Scene, TracingSeconds  # noqa: E402
from stages import textureStress  # noqa: E402
from support.svgChart import Chart  # noqa: E402

_BIASES = (-1.0, -0.5, 0.0, 0.5, 1.0)


def Measure(folder: pathlib.Path, width: int, count: int, size: int, sampleCounts, referenceSamples: int, biases=_BIASES):
    """Yields rows; textures are made in the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    stage = folder / f"glowing{count}x{size}.usda"
    if not stage.exists():
        textureStress.WriteTextureStress(stage, count, size, glows=True)

    def Render(samples, **settings):
        scene = Scene(stage, "/World/Camera", imageWidth=width, imageHeight=width * 9 // 16, maxDepth=1,
                      cacheDirectory=str(folder / "cache"))
        return scene.Render(samples, **settings)

    reference, _ = Render(referenceSamples, mipBias=-16.0, residency="resident")
    for samples in sampleCounts:
        for bias in biases:
            picture, statistics = Render(samples, mipBias=bias, residency="stream")
            texture = statistics["texture"]
            yield dict(samples=samples, bias=bias, error=RelMse(picture, reference), lines=texture["linesLoaded"],
                       megabytes=texture["uniqueBytesLoaded"] / 1e6, seconds=TracingSeconds(statistics))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=208)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--width", type=int, default=640)
    parser.add_argument("--samples", type=lambda text: [int(word) for word in text.split(",")], default=[16, 64])
    parser.add_argument("--referenceSamples", type=int, default=1024)
    parser.add_argument("--out", help="stem of the charts")
    args = parser.parse_args()
    rows = []
    print("| samples | mip bias | relMSE | lines | MB loaded | render s |")
    print("|---" * 6 + "|", flush=True)
    for row in Measure(args.folder, args.width, args.count, args.size, args.samples, args.referenceSamples):
        rows.append(row)
        print(f"| {row['samples']} | {row['bias']:+.1f} | {row['error']:.3e} | {row['lines']} | {row['megabytes']:.2f} | "
              f"{row['seconds']:.2f} |", flush=True)
    byBytes = Chart("filtering error", "MB loaded", "relMSE")
    byTime = Chart("filtering error", "seconds", "relMSE")
    for samples in args.samples:
        curve = [row for row in rows if row["samples"] == samples]
        errors = [row["error"] for row in curve]
        byBytes.Add(f"{samples} spp", [row["megabytes"] for row in curve], errors)
        byTime.Add(f"{samples} spp", [row["seconds"] for row in curve], errors)
    if args.out:
        byBytes.Save(f"{args.out}-bytes")
        byTime.Save(f"{args.out}-time")


if __name__ == "__main__":
    main()
