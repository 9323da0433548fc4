#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bytes and time of hair as curves, and of points as spheres, beside meshes of the same shapes.

`primitives.py FOLDER [--curves N] [--points N] [--width W] [--samples S]` writes the stages to FOLDER, renders each with
resident geometry, and prints a table: a hair ball of N curves of 8 segments (B-splines), the same as tubes of 6 sides and
as many rings as vertices; a cloud of N points, and the same as instanced spheres of 8 x 16 quads. Correctness is not judged.
"""

import argparse
import json
import pathlib
import sys

import numpy as np
from pxr import UsdGeom

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

from stages import author, curves, shapes  # noqa: E402

_SIDES = 6


def _SplinePoints(points):
    """The joints of pinned B-splines [count][n][3 or more]."""
    first = 2 * points[:, :1] - points[:, 1:2]
    last = 2 * points[:, -1:] - points[:, -2:-1]
    run = np.concatenate([first, points, last], 1)
    return (run[:, :-2] + 4 * run[:, 1:-1] + run[:, 2:]) / 6


def _Tubes(points, widths):
    """The hairs as one mesh of open tubes around their joints."""
    rings = _SplinePoints(np.concatenate([points, widths[..., None]], -1))
    centres, radii = rings[..., :3], rings[..., 3:] / 2
    along = np.gradient(centres, axis=1)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    aside = np.cross(along, np.where(np.abs(along[..., :1]) < 0.7, (1.0, 0, 0), (0, 1.0, 0)))
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    other = np.cross(along, aside)
    angle = np.arange(_SIDES) * 2 * np.pi / _SIDES
    around = np.cos(angle)[:, None] * aside[..., None, :] + np.sin(angle)[:, None] * other[..., None, :]
    vertices = centres[..., None, :] + radii[..., None] * around
    count, numRings = centres.shape[:2]
    index = np.arange(count * numRings * _SIDES).reshape(count, numRings, _SIDES)
    low, high = index[:, :-1], index[:, 1:]
    quads = np.stack([low, np.roll(low, -1, 2), np.roll(high, -1, 2), high], -1).reshape(-1)
    return shapes.Shape(vertices.reshape(-1, 3), np.full(quads.size // 4, 4), quads, around.reshape(-1, 3))


def _WriteHairMesh(path, count):
    stage = author.NewStage(path)
    curves.AddLightsAndGround(stage, 12.0, -1.6)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 48, 96), color=(0.25, 0.16, 0.1))
    points, widths, _ = curves.HairBall(count)
    author.AddMesh(stage, "/World/Hair", _Tubes(points.reshape(count, -1, 3), widths.reshape(count, -1)), color=(0.56, 0.34, 0.15))
    author.AddCamera(stage, eye=(0, 0.9, 5.6), target=(0, -0.1, 0), focalLength=45.0, width=36.0)
    stage.GetRootLayer().Save()
    return str(path)


def _WriteCloudMesh(path, cloudPath):
    from pxr import Usd

    source = Usd.Stage.Open(cloudPath)
    cloud = UsdGeom.Points(source.GetPrimAtPath("/World/Cloud"))
    points, widths = np.array(cloud.GetPointsAttr().Get()), np.array(cloud.GetWidthsAttr().Get())
    stage = author.NewStage(path)
    curves.AddLightsAndGround(stage, 12.0, -1.0)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Cloud")
    author.AddMesh(stage, "/World/Cloud/Ball", shapes.Sphere(1.0, 8, 16), color=(0.5, 0.5, 0.5))
    instancer.CreatePrototypesRel().SetTargets(["/World/Cloud/Ball"])
    instancer.CreateProtoIndicesAttr([0] * len(points))
    instancer.CreatePositionsAttr(points.tolist())
    instancer.CreateScalesAttr([(float(width) / 2,) * 3 for width in widths])
    author.AddCamera(stage, eye=(0, 2.2, 4.6), target=(0, -0.2, 0), focalLength=40.0, width=36.0)
    stage.GetRootLayer().Save()
    return str(path)


def _Measure(path, arguments):
    """Statistics of a render in this process; a first one has compiled the kernels and prepared the pages."""
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    session = _core.Session()
    TranslateStage(Usd.Stage.Open(path), session, Usd.TimeCode.Default())
    for samples in (1, arguments.samples):
        options = _core.Settings()
        options.camera, options.imageWidth, options.imageHeight = "/World/Camera", arguments.width, arguments.width * 9 // 16
        options.samples, options.residency = samples, "resident"
        session.Render(options)
    return json.loads(session.Statistics())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--curves", type=int, default=100000)
    parser.add_argument("--points", type=int, default=100000)
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--samples", type=int, default=8)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    paths = {name: str(arguments.folder / f"{name}.usdc") for name in ("hairCurves", "hairMesh", "pointCloud", "instancedBalls")}
    curves.WriteHair(paths["hairCurves"], arguments.curves)
    _WriteHairMesh(paths["hairMesh"], arguments.curves)
    curves.WritePointCloud(paths["pointCloud"], arguments.points)
    _WriteCloudMesh(paths["instancedBalls"], paths["pointCloud"])
    print("| stage | primitives | pages MB | always resident MB | bytes a curve or point | trace s | render s | Mrays/s |")
    print("|---|---|---|---|---|---|---|---|")
    for name, path in paths.items():
        statistics = _Measure(path, arguments)
        geometry, time = statistics["geometry"], statistics["time"]
        count = arguments.curves if name.startswith("hair") else arguments.points
        what = max(("curves", "points", "triangles"), key=lambda kind: geometry[kind] if kind != "triangles" else 0)
        primitives = f"{geometry[what]} {what}" if geometry[what] else f"{geometry['triangles']} triangles"
        total = geometry["bytesTotal"] + geometry["alwaysResidentBytes"]
        print(f"| {name} | {primitives} | {geometry['bytesTotal'] / 1e6:.1f} | {geometry['alwaysResidentBytes'] / 1e6:.1f} | "
              f"{total / count:.0f} | {time['trace']:.2f} | {time['render']:.2f} | {statistics['rays']['perSecond'] / 1e6:.2f} |",
              flush=True)


if __name__ == "__main__":
    main()
