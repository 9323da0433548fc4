# SPDX-License-Identifier: Apache-2.0
"""Error of filtered textures against bytes loaded and time: textureQuality.py FOLDER [--out STEM] [options]

Cards of the stress scene glow, so that a picture has no noise but that of where samples fall in a pixel. The reference has
1024 samples a pixel that each read the nearest texels of the finest mip (mipBias -16, uncompressed). Error is
relMSE: the mean of (a - b)^2 / (b^2 + 0.01). With and without compression, with mip biases; each run is a session of its own,
textures prepared before; times are without preparing and compiling. The charts have error against megabytes loaded and against seconds.
"""

import argparse
import json
import pathlib
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from hdstream import _core  # noqa: E402
from hdstream.translate import TranslateStage  # noqa: E402
from pxr import Usd  # noqa: E402
from stages import textureStress  # noqa: E402
from support.svgChart import Chart  # noqa: E402

_BIASES = (-1.0, -0.5, 0.0, 0.5, 1.0)


def _Render(args, stage, **settings):
    session = _core.Session()
    TranslateStage(stage, session, Usd.TimeCode.Default())
    options = _core.Settings()
    options.camera, options.imageWidth, options.imageHeight = "/World/Camera", args.width, args.width * 9 // 16
    options.maxDepth, options.cacheDirectory = 1, str(args.folder / "cache")
    for name, value in settings.items():
        setattr(options, name, value)
    session.Render(options)
    color = next(np.array(layer.pixels) for layer in session.Layers() if layer.name == "color")
    return color[..., :3].astype(np.float64), json.loads(session.Statistics())


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
    args.folder.mkdir(parents=True, exist_ok=True)
    path = args.folder / f"glowing{args.count}x{args.size}.usda"
    textureStress.WriteTextureStress(path, args.count, args.size, glows=True)
    stage = Usd.Stage.Open(str(path))
    reference, _ = _Render(args, stage, samples=args.referenceSamples, plainTextures=True, mipBias=-16.0, residency="resident")
    byBytes = Chart("filtering error", "MB loaded", "relMSE")
    byTime = Chart("filtering error", "seconds", "relMSE")
    print("| textures | samples | mip bias | relMSE | lines | MB loaded | render s |")
    print("|---" * 7 + "|", flush=True)
    for samples in args.samples:
        for name, settings in (("streamed", dict(residency="stream")),
                               ("plain", dict(residency="resident", plainTextures=True))):
            megabytes, seconds, errors = [], [], []
            for bias in _BIASES:
                picture, statistics = _Render(args, stage, samples=samples, mipBias=bias, **settings)
                error = float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01)))
                lines, loaded = statistics["texture"]["linesLoaded"], statistics["texture"]["uniqueBytesLoaded"] / 1e6
                errors.append(error)
                time = statistics["time"]
                seconds.append(time["render"] - time["prepare"] - time["compile"])
                megabytes.append(loaded)
                print(f"| {name} | {samples} | {bias:+.1f} | {error:.3e} | {lines or 'all'} | "
                      f"{f'{loaded:.2f}' if lines else 'all'} | {seconds[-1]:.2f} |", flush=True)
            if name != "plain":
                byBytes.Add(f"{name}, {samples} spp", megabytes, errors)
            byTime.Add(f"{name}, {samples} spp", seconds, errors)
    if args.out:
        byBytes.Save(f"{args.out}-bytes")
        byTime.Save(f"{args.out}-time")


if __name__ == "__main__":
    main()
