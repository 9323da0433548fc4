# SPDX-License-Identifier: Apache-2.0
"""The AOV ambientOcclusion against form factors (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors"): what a point
does not see of its hemisphere, weighed by the cosine, is the form factor of what stands before it."""

import math

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

pytest.importorskip("hdstream._core")

import ours
from stages import author, shapes

SIZE = (32, 24)
_AOV = "ambientOcclusion"


def _Save(stage):
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def _Unseen(mesh):
    UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("hdstream:visibility:camera", Sdf.ValueTypeNames.Bool, "constant").Set(False)
    return mesh


def _Floor(path, add=lambda stage: None, eye=(0, 5, 0)):
    """A wide floor from above."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(2000, 2000), color=(0.1, 0.5, 0.4))
    add(stage)
    author.AddCamera(stage, eye=eye, target=(eye[0], 0, eye[2]), up=(0, 0, -1), focalLength=40.0)
    return _Save(stage)


def _Render(path, samples=256, size=SIZE, **settings):
    layers = ours.Render(path, *size, (_AOV, "position", "alpha", "color"), samples=samples, maxDepth=0, **settings).layers
    return layers[_AOV][..., 0].astype(np.float64), layers["position"].astype(np.float64), layers


def _Ceiling(height, opacity=1.0):
    def Add(stage):
        mesh = _Unseen(author.AddMesh(stage, "/World/Ceiling", shapes.Plane(2e4, 2e4), translate=(0, height, 0)))
        author.AddPrimvar(mesh, "displayOpacity", Sdf.ValueTypeNames.FloatArray, "constant", [opacity])

    return Add


@pytest.mark.parametrize("distance, expected", [(0.0, 0.0), (1.9, 1.0), (2.5, (2.0 / 2.5) ** 2), (8.0, 1 / 16)])
def test_a_ceiling_within_a_distance(tmp_path, distance, expected):
    """Below a wide ceiling at height 2, rays of a cosine above 2 / distance are occluded."""
    found, _, layers = _Render(_Floor(tmp_path / "a.usda", _Ceiling(2.0)), occlusionDistance=distance)
    assert (layers["alpha"] == 1).all()
    assert found.mean() == pytest.approx(expected, abs=4 * math.sqrt(expected * (1 - expected) / found.size / 256) + 1e-5)


def test_a_long_wall(tmp_path):
    """A point at a distance x from a wall of height H, of any length: (1 - x / sqrt(x^2 + H^2)) / 2 is hidden."""
    height = 1.5

    def AddWall(stage):
        _Unseen(author.AddMesh(stage, "/World/Wall", shapes.Box(0.2, height, 4000.0), translate=(-3.1, height / 2, 0)))

    found, position, _ = _Render(_Floor(tmp_path / "a.usda", AddWall), samples=1024)
    x = position[..., 0] + 3.0
    beside = x[12] > 0.05
    expected = 1 - (1 - x / np.hypot(x, height)) / 2
    assert beside.sum() > 20
    assert np.abs((found - expected).mean(0)[beside]).max() < 0.012


def test_a_ball(tmp_path):
    """A ball of radius r whose centre is at a distance d hides cos (r / d)^2."""
    radius, centre = 0.8, np.array([0.3, 2.0, -0.2])

    def AddBall(stage):
        _Unseen(author.AddMesh(stage, "/World/Ball", shapes.Sphere(radius, 64, 128), translate=tuple(centre)))

    found, position, _ = _Render(_Floor(tmp_path / "a.usda", AddBall), samples=1024)
    to = centre - position
    distance = np.linalg.norm(to, axis=-1)
    expected = 1 - to[..., 1] / distance * (radius / distance) ** 2
    difference = (found - expected).reshape(4, 6, 4, 8).mean((1, 3))
    assert np.abs(difference).max() < 0.006
    assert expected.min() < 0.86


def test_surfaces_let_rays_pass_by_their_opacity(tmp_path):
    found, _, _ = _Render(_Floor(tmp_path / "a.usda", _Ceiling(2.0, 0.25)))
    assert found.mean() == pytest.approx(0.75, abs=0.01)


def test_nothing_is_there_in_the_background(tmp_path):
    stage = author.NewStage(str(tmp_path / "a.usda"))
    author.AddMesh(stage, "/World/Square", shapes.Plane(1, 1), rotate=(0, 20, 0))
    author.AddCamera(stage, eye=(0, 3, 0), target=(0, 0, 0), up=(0, 0, -1), focalLength=30.0)
    found, _, layers = _Render(_Save(stage), samples=16, domeVisible=False)
    alpha = layers["alpha"][..., 0]
    assert ((alpha > 0) & (alpha < 1)).any()
    assert np.array_equal(found.astype(np.float32), alpha)  # a square alone is not occluded; shares of pixels count as in alpha


def test_colour_is_as_without(tmp_path):
    path = _Floor(tmp_path / "a.usda", lambda stage: author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0))
    with_ = ours.Render(path, *SIZE, ("color", _AOV), samples=8).layers["color"]
    assert with_.tobytes() == ours.Render(path, *SIZE, ("color",), samples=8).layers["color"].tobytes() and with_.any()


def _Rough(stage):
    for i in range(12):
        author.AddMesh(stage, f"/World/Ball{i:02}", shapes.Sphere(0.4, 12, 24), translate=(i % 4 - 1.5, 0.3, i // 4 - 1))


@pytest.mark.parametrize("settings", [
    {"waveSize": 3001}, {"traversal": "scalar"}, {"traversal": "simd8"},
    {"residency": "stream", "geometryMemory": "16K", "chunkBytes": 1 << 12},
], ids=lambda settings: "-".join(str(value) for value in settings.values()))
def test_bits_depend_on_nothing_else(tmp_path, settings):
    path = _Floor(tmp_path / "a.usda", _Rough)
    expected, found = (_Render(path, samples=20, occlusionDistance=2.0, **of)[2] for of in ({}, settings))
    for name in expected:
        assert expected[name].tobytes() == found[name].tobytes(), name
    assert 0 < expected[_AOV].min() < 0.5


def test_parts_of_a_farm_have_the_same_bits(tmp_path):
    import hdstream
    from hdstream import filmSums
    renderer = hdstream.Renderer(_Floor(tmp_path / "a.usda", _Rough))

    def Prepare(samples=40):
        renderer.Prepare(aovs=["color", _AOV, "direct"], samples=samples, imageWidth=48, imageHeight=32, camera="/World/Camera")

    def Sums(end, start):
        Prepare(end)
        return renderer.RenderSums(None, start)

    Prepare()
    whole = renderer.RenderPrepared(None)
    blocks = [filmSums.Unpack(filmSums.Pack(Sums(end, [filmSums.BlackSums(48, 32, begin)])))
              for begin, end in ((0, 16), (16, 32), (32, 40))]
    Prepare()
    joined = renderer.RenderPrepared(None, blocks)
    for name, pixels in whole.aovs.items():
        assert pixels.tobytes() == joined.aovs[name].tobytes(), name
    assert 0 < whole.aovs[_AOV].min() < 1
