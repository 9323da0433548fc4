# SPDX-License-Identifier: Apache-2.0
"""Shadow rays that pass smooth glass: what arrives behind a slab, that no light counts twice, and that nothing changes elsewhere."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Gf, Sdf, UsdShade
from stages import author, shapes
from stages.materialX import AddNode, AddSurface
from test_meshMedia import AddVolume

_GLASS = dict(base=0.0, transmission=1.0, specular_IOR=1.5, specular_roughness=0.0)
_INK = np.array((0.8, 0.5, 0.2))  # is left after a unit of length


def _Fresnel(cosine: float, eta: float = 1.5) -> float:
    inside = np.sqrt(1 - (1 - cosine**2) / eta**2)
    s, p = (cosine - eta * inside) / (cosine + eta * inside), (eta * cosine - inside) / (eta * cosine + inside)
    return (s * s + p * p) / 2


def _Stage(path, surface, lights, thickness=0.25, shape=None, add=None, rotate=(0, 0, 0)) -> str:
    """A floor at y = 0 below a slab at y = 1, seen from below the slab."""
    stage = author.NewStage(str(path))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(20, 20), color=(0.5, 0.5, 0.5))
    if surface is not None:
        slab = shapes.Box(20, thickness, 20) if shape is None else shape
        author.AddMesh(stage, "/World/Slab", slab, material=AddSurface(stage, "/World/Look", **surface), translate=(0, 1, 0), rotate=rotate)
    if add is not None:
        add(stage)
    for number, (kind, options) in enumerate(lights):
        author.AddLight(stage, f"/World/Light{number}", kind, **options)
    author.AddCamera(stage, eye=(0, 0.5, 0.4), target=(0, 0, 0), width=4.0, aspect=1.0)
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def _Mean(path, samples=16, glassShadows=True, **settings):
    picture = ours.Render(path, 8, 8, samples=samples, glassShadows=glassShadows, **{"maxDepth": 8, "russianRoulette": True, **settings})
    assert not picture.warnings
    return picture.rgb.reshape(-1, 3).mean(0)


def _Sun(degrees=0.0, **others):
    return ("Distant", dict(angle=0.0, placement=dict(rotate=(degrees - 90, 0, 0)), **others))


@pytest.mark.parametrize("degrees", [0.0, 60.0])
def test_a_slab_below_the_sun_lets_pass_what_it_does_not_reflect_and_absorb(tmp_path, degrees):
    """(1 - F)^2 exp(-sigma d), straight on: directly, without what floor and slab send to and fro."""
    cosine = np.cos(np.radians(degrees))
    surface = dict(_GLASS, transmission_color=tuple(_INK), transmission_depth=1.0)
    through = _Mean(_Stage(tmp_path / "s.usda", surface, [_Sun(degrees)]), maxDepth=0)
    alone = _Mean(_Stage(tmp_path / "a.usda", None, [_Sun(degrees)]), maxDepth=0)
    assert through / alone == pytest.approx((1 - _Fresnel(cosine)) ** 2 * _INK ** (0.25 / cosine), rel=0.002)


def test_what_has_no_depth_is_tinted_where_it_is_entered_and_left(tmp_path):
    surface = dict(_GLASS, transmission_color=tuple(_INK))
    through = _Mean(_Stage(tmp_path / "s.usda", surface, [_Sun()]), maxDepth=0)
    alone = _Mean(_Stage(tmp_path / "a.usda", None, [_Sun()]), maxDepth=0)
    assert through / alone == pytest.approx((1 - _Fresnel(1.0)) ** 2 * _INK**2, rel=0.002)


@pytest.mark.parametrize("light", [
    _Sun(), ("Sphere", dict(radius=0.01, intensity=1e5, treatAsPoint=True, placement=dict(translate=(0, 6, 0))))], ids=["sun", "point"])
def test_lights_without_extent_are_not_black_behind_glass(tmp_path, light):
    path = _Stage(tmp_path / "s.usda", _GLASS, [light])
    assert _Mean(path, glassShadows=False).max() < 1e-6
    alone = _Mean(_Stage(tmp_path / "a.usda", None, [light]), maxDepth=0)
    assert _Mean(path, maxDepth=0) / alone == pytest.approx(np.full(3, (1 - _Fresnel(1.0)) ** 2), rel=0.002)


_MILK = dict(_GLASS, transmission_color=(0.3, 0.4, 0.5), transmission_depth=0.5, transmission_scatter=(0.4, 0.3, 0.5))


_WINDOW = ("Rect", dict(width=3.0, height=3.0, placement=dict(translate=(0, 3, 0), rotate=(-90, 0, 0))))


@pytest.mark.parametrize("surface, lights, samples, tolerance", [
    (_GLASS, [("Dome", {})], 1024, 0.01), (_GLASS, [_WINDOW], 4096, 0.015),
    (dict(_GLASS, transmission_color=tuple(_INK), transmission_depth=1.0), [("Dome", {})], 1024, 0.015),
    (_MILK, [("Dome", {})], 4096, 0.015)], ids=["dome", "window", "ink", "milk"])
def test_no_light_counts_twice(tmp_path, surface, lights, samples, tolerance):
    """Behind a thin slab, where rays come out as and almost where they went in, the means are those of an unbiased render."""
    path = _Stage(tmp_path / "s.usda", surface, lights, thickness=0.02)
    assert _Mean(path, samples) == pytest.approx(_Mean(path, samples, glassShadows=False), rel=tolerance)


def test_light_through_a_tilted_pane_does_not_count_twice(tmp_path):
    """Where the pane's normal is not the floor's, on which the density of a dome's samples depends."""
    path = _Stage(tmp_path / "s.usda", _GLASS, [("Dome", {})], shape=shapes.Box(1.5, 0.02, 1.5), rotate=(50, 0, 0))
    assert _Mean(path, 1024) == pytest.approx(_Mean(path, 1024, glassShadows=False), rel=0.006)


def test_a_lamp_inside_of_milk_lights_what_is_outside(tmp_path):
    """Light leaves the scattering inside of glass by its own shadow rays; what walks on in it is not lost."""
    lamp = [("Sphere", dict(radius=0.2, intensity=50.0, placement=dict(translate=(0, 1, 0))))]
    path = _Stage(tmp_path / "s.usda", dict(_MILK, specular_IOR=1.01), lamp, shape=shapes.Sphere(0.45, 24, 48))
    assert _Mean(path, 4096) == pytest.approx(_Mean(path, 4096, glassShadows=False), rel=0.03)


def test_rough_glass_stays_opaque_to_shadow_rays(tmp_path):
    path = _Stage(tmp_path / "s.usda", dict(_GLASS, specular_roughness=0.3), [_Sun()])
    assert _Mean(path, maxDepth=0).max() == 0.0


def test_a_volume_in_glass_dims_shadow_rays_once(tmp_path):
    def Add(stage):
        ink = AddVolume(stage, "/World/Ink", absorption=tuple(-np.log(_INK)), surface=dict(_GLASS, transmission_color=(0.1, 0.1, 0.1),
                                                                                          transmission_depth=1.0))
        author.AddMesh(stage, "/World/Slab", shapes.Box(20, 0.25, 20), material=ink, translate=(0, 1, 0))

    through = _Mean(_Stage(tmp_path / "s.usda", None, [_Sun()], add=Add), maxDepth=0)
    alone = _Mean(_Stage(tmp_path / "a.usda", None, [_Sun()]), maxDepth=0)
    assert through / alone == pytest.approx((1 - _Fresnel(1.0)) ** 2 * _INK**0.25, rel=0.002)


def test_stages_without_glass_neither_change_nor_pay(tmp_path):
    """Nor do stages with glass when the option is off: it is off by default."""
    lights = [_Sun(), ("Dome", dict(intensity=0.2))]
    for number, surface in enumerate((dict(base_color=(0.2, 0.5, 0.8)), dict(_GLASS, thin_walled=True))):
        path = _Stage(tmp_path / f"{number}.usda", surface, lights)
        on, off = (ours.Render(path, 16, 16, samples=4, waveSize=1024, kernels="own", glassShadows=value) for value in (True, False))
        assert on.layers["color"].tobytes() == off.layers["color"].tobytes()
        assert on.statistics["memory"]["pathState"] == off.statistics["memory"]["pathState"]


@pytest.fixture(scope="module")
def Mixed(tmp_path_factory):
    """Glass of all kinds before lamps of all kinds: clear, tinted, milk, of fog, cut out, a mirror beside it, and light linking."""
    def Add(stage):
        for number, (surface, place) in enumerate((
                (_GLASS, (-0.4, 0.3, 0)), (dict(_GLASS, transmission_color=tuple(_INK), transmission_depth=0.3), (0.0, 0.3, -0.3)),
                (_MILK, (0.4, 0.3, 0)), (dict(base=1.0, metalness=1.0, specular_roughness=0.05), (0.0, 0.2, 0.3)),
                (dict(_GLASS, opacity=(0.5, 0.5, 0.5), subsurface=0.3), (0.0, 0.6, 0.0)))):
            author.AddMesh(stage, f"/World/Ball{number}", shapes.Sphere(0.2, 12, 24), translate=place,
                           material=AddSurface(stage, f"/World/Ball{number}Look", **surface))
        fog = AddVolume(stage, "/World/Fog", scattering=(1.0, 2.0, 3.0), surface=_GLASS)
        author.AddMesh(stage, "/World/Fogged", shapes.Box(0.2, 0.2, 0.2), material=fog, translate=(-0.3, 0.15, 0.3))

    lamp = ("Sphere", dict(radius=0.05, intensity=60.0, placement=dict(translate=(0.4, 0.75, 0.4))))
    return _Stage(tmp_path_factory.mktemp("mixed") / "s.usda", _GLASS, [_Sun(30.0), lamp, ("Dome", dict(intensity=0.3))], add=Add)


_AOVS = ("color", "alpha", "albedo", "variance")
_SIZE = (41, 29)  # odd: no wave ends with a row


@pytest.fixture(scope="module")
def Expected(Mixed):
    return ours.Render(Mixed, *_SIZE, _AOVS, samples=5, russianRoulette=True, residency="resident", glassShadows=True).layers


@pytest.mark.parametrize("settings", [
    dict(waveSize=3001), dict(traversal="scalar"), dict(chunkBytes=4096, residency="stream", geometryMemory="30%"),
    dict(chunkBytes=4096, residency="stream", geometryMemory="6%"),
    dict(chunkBytes=4096, residency="stream", geometryMemory="60%", request="first", geometryEviction="flush"),
], ids=["waves", "scalar", "stream30", "stream6", "report"])
def test_bits_do_not_depend_on_how_glass_is_traced(Mixed, Expected, settings):
    picture = ours.Render(Mixed, *_SIZE, _AOVS, samples=5, russianRoulette=True, glassShadows=True, **settings)
    for name, layer in Expected.items():
        assert layer.tobytes() == picture.layers[name].tobytes(), name


def test_the_form_of_eight_paths_has_the_bits_of_one(Mixed, Expected):
    """Light path expressions shade path by path."""
    layers = ours.Render(Mixed, *_SIZE, ("color", "diffuse"), samples=5, russianRoulette=True, glassShadows=True).layers
    assert layers["color"].tobytes() == Expected["color"].tobytes()


def test_light_is_found_and_finite(Mixed, Expected):
    off = ours.Render(Mixed, *_SIZE, samples=5, russianRoulette=True, residency="resident").rgb
    on = Expected["color"][..., :3]
    assert np.isfinite(on).all() and on.mean() > 1.2 * off.mean()  # the sun, which was black


def test_glass_below_a_coat_passes_by_its_own_normal(tmp_path):
    """A coat that is almost not there, with the normal of the slab, changes nothing; the glass has another."""
    def Through(coat, isBumped=True):
        def Bump(stage):
            UsdShade.Material.Define(stage, "/World/Look")
            return AddNode(stage, "/World/Look/Bump", "ND_normalmap", Sdf.ValueTypeNames.Vector3f, **{"in": Gf.Vec3f(0.9, 0.5, 0.8)})

        def Slab(stage):
            normal = dict(normal=Bump(stage)) if isBumped else {}
            look = AddSurface(stage, "/World/Look", **_GLASS, coat=coat, **normal)
            author.AddMesh(stage, "/World/Pane", shapes.Plane(20, 20), material=look, translate=(0, 1, 0))
        return _Mean(_Stage(tmp_path / "s.usda", None, [_Sun(60.0)], add=Slab), maxDepth=0)
    bare = Through(0.0)
    assert abs(bare / Through(0.0, False) - 1).min() > 0.02
    assert Through(1e-4) == pytest.approx(bare, rel=2e-3)
