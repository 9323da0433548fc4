# SPDX-License-Identifier: Apache-2.0
"""Bodies that refract and overlap, by priority: Snell's and Fresnel's laws between two of them, and boundaries that are not there."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Sdf, Usd, UsdGeom
from stages import author, shapes
from stages.materialX import AddSurface
from test_meshMedia import _BALL, AddVolume

_CLEAR = dict(base=0.0, transmission=1.0, specular_roughness=0.0)
_WATER, _GLASS = 1.33, 1.5


def _AddBody(stage, name, shape, ior, priority, by="hdstream", **placement):
    """\\param by: where the priority is written; of "shader" it is Arnold's input."""
    surface = dict(_CLEAR, specular_IOR=ior, **({"dielectric_priority": int(priority)} if by == "shader" else {}))
    mesh = author.AddMesh(stage, f"/World/{name}", shape, material=AddSurface(stage, f"/World/{name}Look", **surface), **placement)
    primvar = {"hdstream": "hdstream:dielectricPriority", "ri": "ri:attributes:trace:intersectpriority"}.get(by)
    if primvar is not None and priority is not None:
        UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(primvar, Sdf.ValueTypeNames.Float, UsdGeom.Tokens.constant).Set(float(priority))


def _AddCard(stage, name, emission, width, depth, **placement):
    look = AddSurface(stage, f"/World/{name}Look", base=0.0, specular=0.0, emission=float(emission > 0), emission_color=(emission,) * 3)
    author.AddMesh(stage, f"/World/{name}", shapes.Plane(width, depth), material=look, doubleSided=True, **placement)


def _Fresnel(cosine: float, eta: float) -> float:
    sine = np.sqrt(1 - cosine**2) / eta
    if sine >= 1:
        return 1.0
    inside = np.sqrt(1 - sine**2)
    s, p = (cosine - eta * inside) / (cosine + eta * inside), (eta * cosine - inside) / (eta * cosine + inside)
    return (s * s + p * p) / 2


def _View(stage, degrees, distance, width, down=True):
    """An orthographic camera that looks at the origin, `degrees` from the normal of the plane y = 0."""
    angle = np.radians(degrees)
    eye = distance * np.array((-np.sin(angle), np.cos(angle) if down else -np.cos(angle), 0.0))
    author.AddCamera(stage, eye=tuple(eye), target=(0, 0, 0), up=(0, 0, 1), width=10.0 * width, aspect=1.0, orthographic=True)
    author.AddLight(stage, "/World/None", "Sphere", intensity=0.0, placement=dict(translate=(0, 500, 0)))


def _Mean(stage, samples=4096, **settings):
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=samples, maxDepth=8, **settings)
    assert not picture.warnings
    return picture.rgb.mean()


def _GlassInWater(path, waterTop, waterBottom, by="hdstream"):
    """Glass below the plane y = 0; water from waterTop down to waterBottom, which may reach into the glass: it has the lesser priority."""
    stage = author.NewStage(str(path))
    _AddBody(stage, "Glass", shapes.Box(60, 4, 60), _GLASS, 2, by, translate=(0, -2, 0))
    _AddBody(stage, "Water", shapes.Box(50, waterTop - waterBottom, 50), _WATER, 1, by, translate=(0, (waterTop + waterBottom) / 2, 0))
    return stage


@pytest.mark.parametrize("waterBottom", [-0.5, -10.0], ids=["reaches into", "around"])
@pytest.mark.parametrize("degrees", [60.0, 75.0])
def test_glass_in_water_reflects_by_fresnels_law(tmp_path, degrees, waterBottom):
    """What is reflected meets a card that glows, in the water; what is refracted, a black one in the glass."""
    stage = _GlassInWater(tmp_path / "s.usda", 10.0, waterBottom)
    angle = np.radians(degrees)
    _AddCard(stage, "Bright", 1.0, 4, 4, translate=(3 * np.sin(angle), 3 * np.cos(angle), 0), rotate=(0, 0, -degrees))
    _AddCard(stage, "Black", 0.0, 40, 40, translate=(0, -1, 0))
    _View(stage, degrees, 4.0, 0.2)
    assert _Mean(stage, 16384) == pytest.approx(_Fresnel(np.cos(angle), _GLASS / _WATER), rel=1e-3)


@pytest.mark.parametrize("degrees", [40.0, 60.0, 65.0])
def test_glass_reflects_inside_by_fresnels_law_of_the_water_around_it(tmp_path, degrees):
    """The camera is in the glass: from 62.5 degrees on, all is reflected."""
    stage = _GlassInWater(tmp_path / "s.usda", 10.0, -0.5)
    angle = np.radians(degrees)
    _AddCard(stage, "Bright", 1.0, 1, 1, translate=(1.2 * np.sin(angle), -1.2 * np.cos(angle), 0), rotate=(0, 0, degrees))
    _AddCard(stage, "Black", 0.0, 40, 40, translate=(0, 5, 0))
    _View(stage, degrees, 2.0, 0.05, down=False)
    assert _Mean(stage, 16384) == pytest.approx(_Fresnel(np.cos(angle), _WATER / _GLASS), rel=1e-3)


@pytest.mark.parametrize("by", ["hdstream", "ri", "shader"])
def test_light_from_water_into_glass_refracts_by_snells_law(tmp_path, by):
    """Where the edge of a card in the glass is seen."""
    degrees, depth, width = 60.0, 1.0, 0.2
    stage = _GlassInWater(tmp_path / "s.usda", 10.0, -0.5, by)
    inside = np.arcsin(np.sin(np.radians(degrees)) * _WATER / _GLASS)
    landing = depth * np.tan(inside)
    # All to the right of a point a third of the way to the edge of the picture glows.
    edge = landing + width / 6 / np.cos(np.radians(degrees))
    _AddCard(stage, "Bright", 1.0, 4, 4, translate=(edge + 2, -depth, 0))
    _AddCard(stage, "Black", 0.0, 40, 40, translate=(0, -depth - 0.1, 0))
    _View(stage, degrees, 4.0, width)
    expected = (1 - _Fresnel(np.cos(np.radians(degrees)), _GLASS / _WATER)) / 3
    seen = _Mean(stage, 16384)
    assert seen == pytest.approx(expected, rel=1e-3)
    # A hundredth of an index is more than that.
    other = np.arcsin(np.sin(np.radians(degrees)) * _WATER / (_GLASS + 0.01))
    assert abs(depth * (np.tan(other) - np.tan(inside)) * np.cos(np.radians(degrees)) / width) > 0.01


@pytest.mark.parametrize("priorities, left", [
    ((2, 1), (1.5, 0.5)), ((1, 2), (0.5, 1.5)), ((1, 1), (0.5, 1.5)), ((-1, -2), (1.5, 0.5))], ids=["first", "second", "equal", "negative"])
def test_where_bodies_overlap_the_greater_priority_is_there(tmp_path, priorities, left):
    """From +z: slab A from 1 to -0.5, slab B from 0.5 to -1; of equal ones B, which was entered last."""
    a, b = np.array((2.0, 0.1, 1.0)), np.array((0.4, 1.0, 2.5))
    stage = author.NewStage(str(tmp_path / "s.usda"))
    for name, sigma, priority, z in (("A", a, priorities[0], 0.25), ("B", b, priorities[1], -0.25)):
        mesh = author.AddMesh(stage, f"/World/{name}", shapes.Box(4, 4, 1.5), material=AddVolume(stage, f"/World/{name}Look", sigma),
                              translate=(0, 0, z))
        UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("hdstream:dielectricPriority", Sdf.ValueTypeNames.Int).Set(priority)
    author.AddLight(stage, "/World/Sky", "Dome")
    author.AddCamera(stage, eye=(0, 0, 10), width=10.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 8, 8, samples=4)
    assert not picture.warnings
    assert picture.rgb.reshape(-1, 3).mean(0) == pytest.approx(np.exp(-left[0] * a - left[1] * b), rel=1e-3)


@pytest.mark.parametrize("first, second", [
    (((0.2, 0.5, 0.8), 2, 1.5), ((0.9, 0.7, 0.6), 1, 0.5)), (((0.2, 0.5, 0.8), 1, 0.5), ((1.0, 1.0, 1.0), 2, 1.5))], ids=["ink", "clear"])
def test_the_inside_of_a_surface_absorbs_where_it_is(tmp_path, first, second):
    """(color after a unit, priority, how much of it is left) of two slabs that overlap, by transmission_color and transmission_depth."""
    stage = author.NewStage(str(tmp_path / "s.usda"))
    for name, (color, priority, _), z in (("First", first, 0.25), ("Second", second, -0.25)):
        look = AddSurface(stage, f"/World/{name}Look", **_CLEAR, specular_IOR=1.0, transmission_color=color, transmission_depth=1.0,
                          dielectric_priority=priority)
        author.AddMesh(stage, f"/World/{name}", shapes.Box(4, 4, 1.5), material=look, translate=(0, 0, z))
    author.AddLight(stage, "/World/Sky", "Dome")
    author.AddCamera(stage, eye=(0, 0, 10), width=10.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 8, 8, samples=64)
    expected = np.array(first[0]) ** first[2] * np.array(second[0]) ** second[2]
    assert picture.rgb.reshape(-1, 3).mean(0) == pytest.approx(expected, rel=1e-3)


def test_a_camera_in_ink_needs_its_priority(tmp_path):
    """A body of ink around the camera and around a card that glows, which is seen beside the ink's own wall: without a priority what
    is within the body is seen as through air; the wall is dimmed either way."""
    ink = np.array((0.2, 0.5, 0.8))
    expected = {None: np.ones(3), 0: ink**1.5}
    for priority, card in expected.items():
        stage = author.NewStage(str(tmp_path / f"{priority}.usda"))
        written = {} if priority is None else dict(dielectric_priority=priority)
        look = AddSurface(stage, "/World/Look", **_CLEAR, specular_IOR=1.0, transmission_color=tuple(ink), transmission_depth=1.0,
                          **written)
        author.AddMesh(stage, "/World/Ink", shapes.Box(6, 6, 6), material=look)
        _AddCard(stage, "Card", 1.0, 2.0, 6.0, rotate=(90, 0, 0), translate=(1.0, 0, -1.0))
        author.AddLight(stage, "/World/Sky", "Dome")
        author.AddCamera(stage, eye=(0, 0, 0.5), target=(0, 0, -1), width=10.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        picture = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=64).rgb
        assert picture[:, 8:].reshape(-1, 3).mean(0) == pytest.approx(card, rel=1e-3)
        assert picture[:, :8].reshape(-1, 3).mean(0) == pytest.approx(ink**3.5, rel=1e-3)


def test_nested_bodies_are_invisible_in_a_furnace(tmp_path):
    """Ice in water in a bowl, with air in it: what absorbs nothing changes nothing, whatever overlaps."""
    stage = author.NewStage(str(tmp_path / "s.usda"))
    for number, (radius, place, ior, priority) in enumerate((
            (1.0, (0, 0, 0), 1.5, 3), (0.95, (0, 0, 0), 1.33, 4), (0.4, (0.3, 0.2, 0.3), 1.31, 5), (0.3, (-0.9, 0, 0.3), 1.7, 2),
            (0.2, (0.0, -0.4, 0.6), 1.0005, 6))):
        _AddBody(stage, f"Body{number}", shapes.Sphere(radius, 24, 48), ior, priority, translate=place)
    author.AddLight(stage, "/World/Sky", "Dome")
    author.AddCamera(stage, eye=(0, 0, 10), width=22.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=1024, maxDepth=64, russianRoulette=True)
    assert not picture.warnings
    assert picture.rgb.mean() == pytest.approx(1.0, abs=0.01)


def test_shadows_of_glass_know_of_the_water_around_it(tmp_path):
    """A sun above water that reaches into a slab of glass, straight down: what is left at each surface that is there."""
    stage = author.NewStage(str(tmp_path / "s.usda"))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), color=(0.5, 0.5, 0.5))
    author.AddLight(stage, "/World/Sun", "Distant", angle=0.0, placement=dict(rotate=(-90, 0, 0)))
    author.AddCamera(stage, eye=(0, 0.5, 0.4), target=(0, 0, 0), width=4.0, aspect=1.0)
    alone = _Mean(stage, 16, glassShadows=True)
    _AddBody(stage, "Water", shapes.Box(20, 1, 20), _WATER, 1, translate=(0, 1.5, 0))
    _AddBody(stage, "Glass", shapes.Box(20, 0.3, 20), _GLASS, 2, translate=(0, 1.0, 0))
    stage.GetRootLayer().Save()
    through = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=16, maxDepth=0, glassShadows=True).rgb.mean()
    expected = (1 - _Fresnel(1.0, _WATER)) * (1 - _Fresnel(1.0, _GLASS / _WATER)) * (1 - _Fresnel(1.0, _GLASS))
    assert through / alone == pytest.approx(expected, rel=1e-3)


def _FirstHits(stage, y):
    """cameraDepth and primId from a height, straight down."""
    author.AddCamera(stage, eye=(0, y, 0), target=(0, 0, 0), up=(0, 0, 1), width=5.0, aspect=1.0, orthographic=True)
    author.AddLight(stage, "/World/Sky", "Dome")
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 8, 8, ("color", "cameraDepth", "primId"), samples=1)
    assert not picture.warnings
    return picture.layers["cameraDepth"][..., 0], picture.layers["primId"]


@pytest.mark.parametrize("priority, depth", [(1, 4.0), (3, 2.0)], ids=["less", "more"])
def test_first_hits_are_of_boundaries_that_are_there(tmp_path, priority, depth):
    """Glass in a body without a surface: of a lesser priority it is not there, and the floor below both is what is seen first."""
    stage = author.NewStage(str(tmp_path / "s.usda"))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20))
    fog = author.AddMesh(stage, "/World/Fog", shapes.Box(10, 2, 10), material=AddVolume(stage, "/World/FogLook", (0.1, 0.1, 0.1)),
                         translate=(0, 2, 0))
    UsdGeom.PrimvarsAPI(fog).CreatePrimvar("hdstream:dielectricPriority", Sdf.ValueTypeNames.Int).Set(2)
    _AddBody(stage, "Glass", shapes.Box(5, 0.5, 5), _GLASS, priority, translate=(0, 1.75, 0))
    depths, prims = _FirstHits(stage, 4.0)
    assert depths == pytest.approx(np.full((8, 8), depth), rel=1e-5)
    assert len(np.unique(prims)) == 1


@pytest.mark.parametrize("priority, depth", [(1, 3.0), (3, 0.75)], ids=["less", "more"])
def test_first_hits_know_what_the_camera_is_in(tmp_path, priority, depth):
    """The camera in water, above glass: of a lesser priority that is not there, and the bottom of the water is what is seen first."""
    stage = author.NewStage(str(tmp_path / "s.usda"))
    _AddBody(stage, "Water", shapes.Box(10, 4, 10), _WATER, 2, translate=(0, 2, 0))
    _AddBody(stage, "Glass", shapes.Box(5, 0.5, 5), _GLASS, priority, translate=(0, 2, 0))
    depths, _ = _FirstHits(stage, 3.0)
    assert depths == pytest.approx(np.full((8, 8), depth), rel=1e-5)


def test_open_meshes_with_priorities_are_finite_with_one_warning(tmp_path):
    kept = _BALL.counts.cumsum() < _BALL.indices.size * 2 // 3
    half = shapes.Shape(_BALL.points, _BALL.counts[kept], _BALL.indices[:int(_BALL.counts[kept].sum())])
    stage = author.NewStage(str(tmp_path / "s.usda"))
    _AddBody(stage, "Half", half, _GLASS, 1)
    author.AddLight(stage, "/World/Sky", "Dome")
    author.AddCamera(stage, eye=(0, 0, 10), width=22.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=16)
    assert np.isfinite(picture.rgb).all() and picture.rgb.max() < 1.1
    assert len(picture.warnings) == 1 and "/World/Half: its mesh is not closed" in str(picture.warnings[0])


@pytest.mark.parametrize("priority, surface", [(None, dict(_CLEAR)), (2, dict(base=1.0)), (2, dict(_CLEAR, thin_walled=True))],
                         ids=["without", "opaque", "thin"])
def test_what_has_no_priority_or_no_inside_keeps_no_account(tmp_path, priority, surface):
    stage = author.NewStage(str(tmp_path / "s.usda"))
    mesh = author.AddMesh(stage, "/World/Ball", _BALL, material=AddSurface(stage, "/World/Look", **surface))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.5)
    author.AddCamera(stage, eye=(0, 0, 10), width=22.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    path = stage.GetRootLayer().realPath
    plain = ours.Render(path, 16, 16, samples=4, waveSize=1024, kernels="own")
    if priority is not None:
        UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("hdstream:dielectricPriority", Sdf.ValueTypeNames.Int).Set(priority)
        stage.GetRootLayer().Save()
    given = ours.Render(path, 16, 16, samples=4, waveSize=1024, kernels="own")
    assert given.layers["color"].tobytes() == plain.layers["color"].tobytes()
    assert given.statistics["memory"]["pathState"] == plain.statistics["memory"]["pathState"]


def test_one_body_with_a_priority_has_the_bits_of_one_without_but_for_its_ways(tmp_path):
    """In air a priority means nothing: the same surfaces, and the same light within what roundings of ways make of it."""
    pictures = []
    for priority in (None, 3):
        stage = author.NewStage(str(tmp_path / f"{priority}.usda"))
        _AddBody(stage, "Ball", _BALL, _GLASS, priority)
        author.AddMesh(stage, "/World/Floor", shapes.Plane(8, 8), color=(0.6, 0.3, 0.2), translate=(0, -1.5, 0))
        author.AddLight(stage, "/World/Sky", "Dome")
        author.AddCamera(stage, eye=(0, 1, 10), width=22.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        pictures.append(ours.Render(stage.GetRootLayer().realPath, 32, 32, samples=16).rgb)
    assert np.allclose(*pictures, rtol=1e-4, atol=1e-5)
