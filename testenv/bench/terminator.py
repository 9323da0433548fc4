# SPDX-License-Identifier: Apache-2.0
"""Shadow terminators of coarse meshes with smooth normals against the fine meshes that they stand for.

    python testenv/bench/terminator.py [FOLDER] [--samples N]

A sphere and a torus at several tessellations under a narrow sun, with smoothTerminator off and on. Error: root mean
square of the difference from the finest mesh over pixels that all meshes cover and that lie away from silhouettes, over
the mean of the finest. Prints a table; pictures go to FOLDER.
"""

import argparse
import os
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import builtPackage  # noqa: E402

builtPackage.PutOnPath()
import numpy as np  # noqa: E402
from pxr import Usd, UsdGeom  # noqa: E402

import hdstream  # noqa: E402
from stages import author, imageFile, shapes  # noqa: E402

SIZE = 160
SHAPES = {
    "sphere": (lambda n: shapes.Sphere(1.0, n, 2 * n), (8, 16, 32, 64)),
    "torus": (lambda n: shapes.Torus(0.75, 0.35, 2 * n, n), (8, 16, 32, 64)),
}
FINEST = 384
SETTINGS = dict(imageWidth=SIZE, imageHeight=SIZE, camera="/World/Camera", pixelFilter="box", pixelFilterWidth=1.0, maxDepth=0)


def MakeStage(shape, angle=1.0):
    """The shape, lit from the side."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/World")
    mesh = author.AddMesh(stage, "/World/Shape", shape, color=(0.8, 0.8, 0.8), rotate=(35, 20, 0))
    assert mesh.GetNormalsAttr().HasAuthoredValue(), "smooth normals"
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-20, 75, 0)), intensity=3.0, angle=angle, normalize=True)
    author.AddCamera(stage, eye=(0, 0, 6), width=36.0, focalLength=80.0, aspect=1.0)
    return stage


def Render(stage, smooth, samples):
    begin = time.perf_counter()
    renderer = hdstream.Renderer(stage, onWarning=lambda line: None)
    aovs = renderer.Render(1.0, **SETTINGS, samples=samples, aovs=["color", "alpha"], smoothTerminator=smooth).aovs
    return aovs["color"][..., :3].astype(np.float64), aovs["alpha"][..., 0] == 1.0, time.perf_counter() - begin


def Inner(masks):
    """Where all masks hold, and a ring of pixels around them."""
    inner = np.logical_and.reduce(masks)
    for _ in range(3):
        grown = inner.copy()
        grown[1:] &= inner[:-1]
        grown[:-1] &= inner[1:]
        grown[:, 1:] &= inner[:, :-1]
        grown[:, :-1] &= inner[:, 1:]
        inner = grown
    return inner


def Measure(name, samples, folder=None):
    """{(tessellation, smooth): error}."""
    make, sizes = SHAPES[name]
    finest, mask, _ = Render(MakeStage(make(FINEST)), False, samples)
    pictures = {(n, smooth): Render(MakeStage(make(n)), smooth, samples) for n in sizes for smooth in (False, True)}
    inner = Inner([mask] + [one[1] for one in pictures.values()])
    if folder is not None:
        row = np.concatenate([pictures[sizes[0], False][0], pictures[sizes[0], True][0], finest], 1)
        folder.mkdir(parents=True, exist_ok=True)
        imageFile.WritePng(folder / f"terminator-{name}.png", (255.0 * np.clip(row, 0.0, 1.0) ** (1 / 2.2)).astype(np.uint8))
    scale = finest[inner].mean()
    return {key: float(np.sqrt(((one[0] - finest)[inner] ** 2).mean()) / scale) for key, one in pictures.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=pathlib.Path)
    parser.add_argument("--samples", type=int, default=64)
    options = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f}")
    print("| shape | rings | error, off | error, on |\n|---|---|---|---|")
    for name in SHAPES:
        errors = Measure(name, options.samples, options.folder)
        for n in SHAPES[name][1]:
            print(f"| {name} | {n} | {errors[n, False]:.4f} | {errors[n, True]:.4f} |")


if __name__ == "__main__":
    main()
