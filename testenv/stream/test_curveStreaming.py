# SPDX-License-Identifier: Apache-2.0
"""Curves, ribbons and points stream beside meshes and below instancers, with the bits of resident geometry."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import UsdGeom
from stages import author, curves, hair, shapes
from streamCase import Case


@pytest.fixture(scope="module")
def Scene(tmp_path_factory):
    path = str(tmp_path_factory.mktemp("curves") / "stage.usda")
    stage = author.NewStage(path)
    curves.AddLightsAndGround(stage, 12.0, -1.6)
    glass = author.AddMaterial(stage, "/World/Glass", diffuseColor=(0.6, 0.4, 0.3), opacity=0.6)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(1.0, 24, 48), color=(0.25, 0.16, 0.1))
    points, widths, colours = curves.HairBall(300)
    author.Bind(curves.AddCurves(stage, "/World/Hair", list(points.reshape(300, -1, 3)), 3 * widths, wrap="pinned",
                                 color=colours).GetPrim(), glass)
    rng = np.random.default_rng(2)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
    curves.AddPoints(stage, "/World/Many/Cloud", rng.normal(size=(300, 3)) * 0.3, rng.uniform(0.03, 0.12, 300),
                     color=rng.uniform(0.2, 0.9, (300, 3)))
    ribbons = [rng.normal(size=3) * 0.3 + np.cumsum(rng.normal(size=(6, 3)) * 0.15, 0) for _ in range(40)]
    curves.AddCurves(stage, "/World/Many/Ribbons", ribbons, 0.08, wrap="pinned", normals=[(0, 1, 0.2)],
                     normalInterpolation="constant", color=(0.3, 0.7, 0.3))
    instancer.CreatePrototypesRel().SetTargets(["/World/Many/Cloud", "/World/Many/Ribbons"])
    instancer.CreateProtoIndicesAttr([0, 1, 0, 1])
    instancer.CreatePositionsAttr([(-2.2, 0, 0), (2.2, 0, 0), (2.0, 1.4, -1), (-2.0, 1.4, -1)])
    author.AddCamera(stage, eye=(0, 0.9, 6.5), target=(0, 0, 0), focalLength=45.0, width=36.0)
    stage.GetRootLayer().Save()
    return Case(path).RenderResident()


@pytest.mark.parametrize("pool", ["100%", "20%", "5%"])
def test_any_pool_gives_the_same_bits(Scene, pool):
    geometry = Scene.AssertStreams(geometryMemory=pool)
    assert geometry["curves"] == 300 + 40 and geometry["points"] == 300


@pytest.fixture(scope="module")
def Hair(tmp_path_factory):
    path = str(tmp_path_factory.mktemp("hair") / "stage.usda")
    stage = author.NewStage(path)
    curves.AddLightsAndGround(stage, 12.0, -1.6)
    look = hair.AddHair(stage, "/World/Look", hair.OfMelanin(stage, "/World/Melanin", 0.3, 0.7), cuticle=0.52)
    hair.AddBall(stage, "/World/Hair", look, 400, (0, 0, 0))
    author.AddCamera(stage, eye=(0, 0.9, 5.6), target=(0, -0.1, 0), focalLength=45.0, width=36.0)
    stage.GetRootLayer().Save()
    return Case(path).RenderResident()


@pytest.mark.parametrize("settings", [{}, dict(traversal="scalar"), dict(request="first")], ids=["simd8", "scalar", "report"])
def test_hair_streams(Hair, settings):
    Hair.AssertStreams(geometryMemory="15%", **settings)


def test_scalar_traversal_gives_the_same_bits(Scene):
    Scene.AssertStreams(geometryMemory="20%", traversal="scalar")
