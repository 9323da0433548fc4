# SPDX-License-Identifier: Apache-2.0
"""What a large dome image takes: largeDome.py FOLDER [--width 16384] [--memory 16M,1M]

Writes a sky with a sun of half a degree and a stage into the folder, and renders it with streamed textures and pools of
those sizes, each in a process of its own. Prints a row of a Markdown table for each: lines loaded, bytes uploaded and
device memory; whether the picture is that of the largest pool.
"""

import argparse
import pathlib
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import Record  # noqa: E402
from stages import author, imageFile, lightCases, shapes  # noqa: E402

SUN = (0.30, 0.70)  # rows from the top, columns from the left
SUN_RADIANCE = 20000.0


def WriteSky(path: pathlib.Path, width: int) -> None:
    """A smooth sky of halves with noise from texel to texel, and the sun."""
    scale = max(1, width // 1024)
    coarse = lightCases.SkyImage(width // scale)
    random = np.random.default_rng(1)
    channels = {}
    for i, name in enumerate("RGB"):
        plane = np.kron(coarse[..., i].astype(np.float16), np.ones((scale, scale), np.float16))
        plane *= 0.75 + 0.5 * random.random(plane.shape, np.float32).astype(np.float16)
        height = plane.shape[0]
        y, x = np.ogrid[:height, :width]
        across = np.pi / height
        isSun = ((y - SUN[0] * height) ** 2 + ((x - SUN[1] * width) * np.sin(np.pi * SUN[0])) ** 2) * across**2 < np.radians(0.25) ** 2
        plane[isSun] = SUN_RADIANCE
        channels[name] = plane
    imageFile.WriteExr(path, channels)


def WriteStage(folder: pathlib.Path, width: int) -> pathlib.Path:
    image = folder / f"sky{width}.exr"
    if not image.exists():
        WriteSky(image, width)
    path = folder / "largeDome.usda"
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 48, 96), color=(0.5, 0.5, 0.5))
    author.AddMesh(stage, "/World/Plate", shapes.Plane(10, 10), color=(0.5, 0.5, 0.5), translate=(0, -1, 0))
    mirror = author.AddMaterial(stage, "/World/Mirror", metallic=1.0, roughness=0.0, diffuseColor=(0.9, 0.9, 0.9))
    author.AddMesh(stage, "/World/Shiny", shapes.Sphere(0.7, 48, 96), material=mirror, translate=(1.8, -0.3, 0.5))
    author.AddLight(stage, "/World/Dome", "Dome", textureFile=f"./{image.name}")
    author.AddCamera(stage, eye=(0, 0.5, 6))
    stage.GetRootLayer().Save()
    return path


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--width", type=int, default=16384, help="of the image; a multiple of 1024")
    parser.add_argument("--memory", default="100%,16M,1M")
    parser.add_argument("--samples", type=int, default=16)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    stage = WriteStage(args.folder, args.width)
    print("| pool | lines loaded | % of all | MB uploaded | misses per texel read | texture pool MB | all tables MB | same picture |")
    print("|---" * 8 + "|", flush=True)
    first = None
    for memory in args.memory.split(","):
        run = Record(stage, args.folder / "cache", imageWidth=1280, imageHeight=720, samples=args.samples, residency="stream",
                     textureMemory=memory)
        texture = run["texture"]
        first = first or run["pictureBytes"]
        print(f"| {memory} | {texture['linesLoaded']} | {100 * texture['linesLoaded'] / texture['linesTotal']:.2f} | "
              f"{texture['uploadedBytes'] / 1e6:.1f} | {texture['misses'] / texture['lookups']:.1e} | {texture['peakBytes'] / 1e6:.1f} | "
              f"{run['memory']['tables'] / 1e6:.1f} | {'yes' if run['pictureBytes'] == first else 'no'} |", flush=True)


if __name__ == "__main__":
    main()
