# SPDX-License-Identifier: Apache-2.0
"""What lights are linked to where they light volumes and the media of meshes: against the same scenes without links, against lights
that are linked to parts, and, of shadows that something of the light passes, against closed forms."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
import volumeCase
from hdstream import _core
from pxr import Gf, Usd, UsdGeom
from stages import author, shapes
from test_meshMedia import _BALL, _Stage

_LAMP = dict(intensity=3000.0, radius=0.4, placement=dict(translate=(0, 4, 4)))
_CATEGORY = "/World/Light0.collection:lightLink"


def _Links(stage, number, collection="lightLink", **links):
    author.LinkLight(UsdGeom.Xformable(stage.GetPrimAtPath(f"/World/Light{number}")), collection, **links)


def _Other(stage):
    author.AddMesh(stage, "/World/Other", shapes.Box(0.1, 0.1, 0.1), translate=(0, 50, 0))


# --- Volumes ---------------------------------------------------------------------------------------


def _Smoke(x=0.0):
    place = np.eye(4)
    place[3, 0] = x
    volume = _core.VolumePrim(_core.Placement(place))
    volume.SetShading((0.1,) * 3, (2.0, 3.0, 1.0), 0.3, (0.0,) * 3, (0.0,) * 3, 1.0, "density", "", "")
    volume.SetGrid("density", volumeCase.Grid(volumeCase.Cloud(8)))
    return volume


def _Session(path, volumes, categories, size=16, samples=64, **settings):
    """\\param categories: of volumes, by path, as front ends hand them over when all lights are known."""
    session = _core.Session()
    volumeCase.TranslateStage(Usd.Stage.Open(str(path)), session, Usd.TimeCode.Default())
    for name, volume in volumes.items():
        session.SetVolume(name, volume)
    for name, names in categories.items():
        session.SetCategories(name, names)
    options = _core.Settings()
    options.camera, options.imageWidth, options.imageHeight = "/World/Camera", size, size
    options.aovs, options.pixelFilter, options.pixelFilterWidth = ["color"], "box", 1.0
    options.russianRoulette, options.noCache, options.maxDepth, options.samples = False, True, 4, samples
    for name, value in settings.items():
        setattr(options, name, value)
    session.Render(options)
    assert not session.Warnings()
    return np.array(session.Layers()[0].pixels)[..., :3]


def test_volumes_are_lit_by_what_is_linked_to_them(tmp_path):
    """Two clouds and a light that leaves out something else, or one of them: its light on both is that on each, together."""
    def Picture(name, categories, **links):
        def Add(stage):
            _Other(stage)
            if links:
                _Links(stage, 0, **links)

        path = volumeCase.Stage(tmp_path / f"{name}.usda", lights=(("Sphere", _LAMP),), width=3.0, add=Add)
        return _Session(path, {"/World/A": _Smoke(-0.6), "/World/B": _Smoke(0.6)}, categories)

    free = Picture("free", {})
    assert free.mean() > 0.01
    both = Picture("both", {"/World/A": {_CATEGORY}, "/World/B": {_CATEGORY}}, excludes=["/World/Other"])
    assert both == pytest.approx(free, rel=1e-5, abs=1e-7)
    first = Picture("first", {"/World/A": {_CATEGORY}}, excludes=["/World/B"])
    second = Picture("second", {"/World/B": {_CATEGORY}}, excludes=["/World/A"])
    assert min(first.mean(), second.mean()) > 0.1 * free.mean()
    assert first[:, :8].mean() > 5 * first[:, 8:].mean() and second[:, 8:].mean() > 5 * second[:, :8].mean()
    assert first + second == pytest.approx(free, rel=1e-4, abs=1e-6)
    assert Picture("none", {}, includes=["/World/Other"]).max() == 0.0


# --- Media of meshes -------------------------------------------------------------------------------


def _Lit(folder, name, bodies, camera=None, **links):
    def Add(stage):
        _Other(stage)
        if links:
            _Links(stage, 0, **links)

    path = _Stage(folder / f"{name}.usda", bodies, lights=(("Sphere", _LAMP),), add=Add, **(camera or {}))
    picture = ours.Render(path, 16, 16, samples=64, russianRoulette=False, maxDepth=8)
    assert not picture.warnings
    return picture.rgb


_INSIDE = dict(eye=(0, 0, 0.9), target=(0, 0, -1), width=0.05)
_SMALL = shapes.Sphere(0.4, 24, 48)


@pytest.mark.parametrize("side, most", [(1, 2.0), (-1, 0.8)])  # the lamp is on the side of +z
def test_bodies_of_one_medium_that_overlap_keep_their_own_links(tmp_path, side, most):
    """Seen along both of them: behind the wall of the one that was entered first there is the other one alone."""
    bodies = [(shapes.Box(1, 1, 1), dict(scattering=0.5), dict(translate=(0, 0, z))) for z in (0.3, -0.3)]
    camera = dict(eye=(0, 0, 10 * side), width=0.8)
    free = _Lit(tmp_path, "free", bodies, camera)
    first = _Lit(tmp_path, "first", bodies, camera, excludes=["/World/Body1"])
    second = _Lit(tmp_path, "second", bodies, camera, excludes=["/World/Body0"])
    near, far = (first, second) if side > 0 else (second, first)  # where both are, the one that was entered last counts
    assert near + far == pytest.approx(free, rel=1e-4, abs=1e-6)
    assert 0.2 * far.mean() < near.mean() < most * far.mean()  # 0.6 of the way, and 1.0; 3.2 and more by the other's links


@pytest.mark.parametrize("camera", [None, _INSIDE], ids=["outside", "inside"])
def test_media_of_meshes_are_lit_by_what_is_linked_to_their_bodies(tmp_path, camera):
    """A body in a body: what leaves neither out lights both, and light on both is that on each, together."""
    bodies = [(_BALL, dict(scattering=(2.0, 1.0, 3.0)), {}), (_SMALL, dict(scattering=(1.0, 4.0, 2.0)), dict(translate=(0, 0, -0.2)))]
    free = _Lit(tmp_path, "free", bodies, camera)
    assert free.mean() > 0.01
    assert _Lit(tmp_path, "both", bodies, camera, excludes=["/World/Other"]) == pytest.approx(free, rel=1e-5, abs=1e-7)
    outer = _Lit(tmp_path, "outer", bodies, camera, excludes=["/World/Body1"])
    inner = _Lit(tmp_path, "inner", bodies, camera, excludes=["/World/Body0"])
    assert min(outer.mean(), inner.mean()) > 0.01 * free.mean()
    assert outer + inner == pytest.approx(free, rel=1e-4, abs=1e-6)
    assert _Lit(tmp_path, "none", bodies, camera, includes=["/World/Other"]).max() == 0.0


def test_who_leaves_a_body_is_in_what_it_was_in_before(tmp_path):
    """The inner body scatters nothing: all that is lit belongs to the outer one, before the inner one and behind it."""
    bodies = [(_BALL, dict(scattering=(2.0, 1.0, 3.0)), {}), (_SMALL, dict(absorption=(0.5, 0.0, 1.0)), dict(translate=(0, 0, 0.3)))]
    free = _Lit(tmp_path, "free", bodies)
    assert _Lit(tmp_path, "outer", bodies, excludes=["/World/Body1"]) == pytest.approx(free, rel=1e-5, abs=1e-7)
    assert _Lit(tmp_path, "inner", bodies, excludes=["/World/Body0"]).max() == 0.0


# --- Shadows with colours --------------------------------------------------------------------------


_BLOCKERS = ["nothing", "opaque", "half", "fading"]


def _Shadowed(folder, blocker, hasSmoke, density=np.ones((4, 4, 4)), **settings):
    """A floor and a sun at 45 degrees, whose light comes through two slabs of even smoke, before and behind a wall."""
    def Add(stage):
        author.AddMesh(stage, "/World/Floor", shapes.Plane(1, 1), rotate=(90, 0, 0))
        fade = dict(distance=30.0, falloff=20.0) if blocker == "fading" else {}
        author.ShadowLight(UsdGeom.Xformable(stage.GetPrimAtPath("/World/Light0")), color=(0.5, 0.25, 0.0), **fade)
        if blocker != "nothing":
            material = author.AddMaterial(stage, "/World/Half", opacity=0.5) if blocker == "half" else None
            author.AddMesh(stage, "/World/Wall", shapes.Box(8, 8, 0.1), material=material, translate=(8, 0, 8), rotate=(0, 45, 0))

    sun = ("Distant", dict(intensity=3.0, angle=0.0, placement=dict(rotate=(0, 45, 0))))
    path = volumeCase.Stage(folder / f"{blocker}{hasSmoke}.usda", lights=(sun,), add=Add, width=0.1)
    volumes = {}
    for at in (2.0, 12.0) if hasSmoke else ():
        place = Gf.Matrix4d().SetScale(Gf.Vec3d(2, 2, 1)) * Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 1, 0), 45))
        place.SetTranslateOnly(Gf.Vec3d(at, 0, at))
        volume = _core.VolumePrim(_core.Placement(np.array(place)))
        volume.SetShading((_SIGMA,) * 3, (0.0,) * 3, 0.0, (0.0,) * 3, (0.0,) * 3, 1.0, "density", "", "")
        volume.SetGrid("density", volumeCase.Grid(density))
        volumes[f"/World/Smoke{at:.0f}"] = volume
    return _Session(path, volumes, {}, **{"size": 16, "samples": 256, "maxDepth": 0, **settings})


_SIGMA = 0.7


def test_light_through_shadows_with_colours_passes_volumes(tmp_path):
    """Beer's law, and whatever the light has passed, volumes leave the same share of it: by the same random numbers."""
    clear = _Shadowed(tmp_path, "nothing", False).mean((0, 1))
    smoky = _Shadowed(tmp_path, "nothing", True, samples=1024).mean((0, 1))
    assert smoky == pytest.approx(clear * np.exp(-2 * _SIGMA), rel=0.02)
    left = _Shadowed(tmp_path, "nothing", True) / clear
    for blocker in _BLOCKERS[1:]:
        clear = _Shadowed(tmp_path, blocker, False)
        red, green, blue = clear.mean((0, 1))
        assert blue < green < red and green > 0.05
        smoky = _Shadowed(tmp_path, blocker, True)
        assert smoky == pytest.approx(left * clear, rel=3e-3, abs=1e-6), blocker


@pytest.mark.parametrize("blocker", _BLOCKERS[1:])
def test_bits_of_shadows_with_colours_are_the_same_at_any_budget(tmp_path, blocker):
    resident, *others = (_Shadowed(tmp_path, blocker, True, volumeCase.Cloud(40), size=4, samples=64, **settings) for settings in (
        dict(residency="resident"), dict(residency="stream", volumeMemory="20%"), dict(residency="stream", textureMemory="16K"),
        dict(residency="stream", waveSize=64), dict(residency="resident", traversal="scalar")))
    assert resident.mean() > 0.01
    for other in others:
        assert np.array_equal(other, resident)
