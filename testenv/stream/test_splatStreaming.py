# SPDX-License-Identifier: Apache-2.0
"""Gaussian splats stream beside meshes, below instancers and while they move, with the bits of resident ones."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import Gf, UsdGeom
from stages import author, curves, shapes, splats
from streamCase import Case


@pytest.fixture(scope="module")
def Scene(tmp_path_factory):
    path = str(tmp_path_factory.mktemp("splats") / "stage.usda")
    stage = author.NewStage(path)
    curves.AddLightsAndGround(stage, 12.0, -1.6)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.8, 24, 48), color=(0.25, 0.16, 0.1))
    splats.AddSplats(stage, "/World/Cloud", splats.RandomCloud(800, 3, 1, size=(0.02, 0.12)))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
    splats.AddSplats(stage, "/World/Many/Small", splats.RandomCloud(300, 1, 2, reach=0.4, size=(0.02, 0.1)))
    instancer.CreatePrototypesRel().SetTargets(["/World/Many/Small"])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([(-2.2, 0, 0), (2.2, 0, 0)])
    author.AddCamera(stage, eye=(0, 0.9, 6.5), target=(0, 0, 0), focalLength=45.0, width=36.0)
    stage.GetRootLayer().Save()
    return Case(path).RenderResident()


@pytest.mark.parametrize("pool", ["100%", "20%", "5%"])
def test_any_pool_gives_the_same_bits(Scene, pool):
    geometry = Scene.AssertStreams(geometryMemory=pool)
    assert geometry["splats"] == 800 + 300 and geometry["points"] == 0


@pytest.mark.parametrize("settings", [dict(traversal="scalar"), dict(request="first")], ids=["scalar", "report"])
def test_other_forms_give_the_same_bits(Scene, settings):
    Scene.AssertStreams(geometryMemory="20%", **settings)


@pytest.mark.parametrize("shapesMove", [False, True], ids=["centres", "shapes"])
def test_splats_that_move_stream(shapesMove, tmp_path):
    path = str(tmp_path / "stage.usda")
    stage = author.NewStage(path)
    cloud = splats.RandomCloud(400, 2, 3, size=(0.03, 0.15))
    prim = splats.AddSplats(stage, "/World/Cloud", cloud)
    if shapesMove:
        splats.SetArrays(prim, {name: cloud[name] for name in ("orientations", "scales", "opacities")}, timeCode=0.0)
        splats.SetArrays(prim, splats.OtherShapes(cloud, 4), timeCode=0.7)
    positions = prim.GetAttribute("positions")
    for time, way in ((0.0, 0.0), (0.5, 0.3), (1.0, 0.4)):
        turned = cloud["positions"] + np.outer(way * np.arange(400) / 400, (1.0, 0.5, -0.2))
        positions.Set([Gf.Vec3f(*map(float, p)) for p in turned], time)
    camera = author.AddCamera(stage, eye=(0, 0.9, 6.5), target=(0, 0, 0), focalLength=45.0, width=36.0)
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(1.0)
    stage.GetRootLayer().Save()
    Case(path, timeCode=0.0, shutter=(0.0, 1.0)).RenderResident().AssertStreams(geometryMemory="15%")
