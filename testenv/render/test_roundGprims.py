# SPDX-License-Identifier: Apache-2.0
"""Implicit gprims have the size that they say: areas of their outlines in closed form.

OpenUSD makes cages of ten sides of them, and the limit surface of a cage is smaller than the cage.
"""

import math

import numpy as np
import pytest
from pxr import UsdGeom

pytest.importorskip("hdstream._core")

import ours
from stages import author

RADIUS, HEIGHT = 0.7, 1.2
# Type -> (what is seen from the side, what is left to the dicing and to the curvature of capsules)
OUTLINES = {
    "Sphere": (math.pi * RADIUS**2, 0.004),
    "Cylinder": (2 * RADIUS * HEIGHT, 0.004),
    "Cone": (RADIUS * HEIGHT, 0.004),
    "Capsule": (math.pi * RADIUS**2 + 2 * RADIUS * HEIGHT, 0.03),
}


def _AreaOf(path) -> float:
    """Of what an orthographic camera of 4 x 3 units sees."""
    return float(ours.Render(path, 160, 120, samples=64, maxDepth=0).layers["color"][..., 3].mean()) * 12


@pytest.mark.parametrize("kind", sorted(OUTLINES))
@pytest.mark.parametrize("axis", ("X", "Z"))
def test_outlines_have_their_area(kind, axis, tmp_path):
    stage = author.NewStage(f"{tmp_path}/a.usda")
    gprim = getattr(UsdGeom, kind).Define(stage, "/World/Gprim")
    gprim.CreateRadiusAttr(RADIUS)
    if kind != "Sphere":
        gprim.CreateHeightAttr(HEIGHT)
        gprim.CreateAxisAttr(axis)
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-90, 0, 0)), intensity=1.0)  # a dome would be seen
    author.AddCamera(stage, eye=(0, 5, 0), up=(0, 0, -1), width=40.0, orthographic=True)
    stage.GetRootLayer().Save()
    area, tolerance = OUTLINES[kind]
    assert _AreaOf(f"{tmp_path}/a.usda") == pytest.approx(area, rel=tolerance)


def test_balls_look_like_points(tmp_path):
    """A Sphere and a point of its width have one picture, but for the facets of the diced ball."""
    pictures = []
    for kind in ("Sphere", "Points"):
        path = f"{tmp_path}/{kind}.usda"
        stage = author.NewStage(path)
        if kind == "Sphere":
            UsdGeom.Sphere.Define(stage, "/World/Ball").CreateRadiusAttr(RADIUS)
        else:
            points = UsdGeom.Points.Define(stage, "/World/Ball")
            points.CreatePointsAttr([(0, 0, 0)])
            points.CreateWidthsAttr([2 * RADIUS])
        author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)
        author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 30, 0)), intensity=2000.0, angle=2.0)
        author.AddCamera(stage, eye=(0, 1, 6), target=(0, 0, 0), width=18.0)
        stage.GetRootLayer().Save()
        pictures.append(ours.Render(path, 120, 90, samples=64).rgb)
    ball, point = pictures
    assert ball.mean() == pytest.approx(point.mean(), rel=2e-3)
    assert np.sqrt(np.mean((ball - point) ** 2)) < 0.05 * point.mean()
