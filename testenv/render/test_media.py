# SPDX-License-Identifier: Apache-2.0
"""Media and subsurface scattering in pictures, against closed forms: furnaces, half-spaces, Beer's law, the power of a light.

A medium that absorbs nothing is invisible in a furnace. A half-space that scatters alike in all directions and has no reflecting
boundary is Chandrasekhar's (Radiative Transfer, 1960): its albedo for light at the cosine mu is 1 - H(mu) sqrt(1 - a), by his H.
"""

import functools

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import compare
import ours
from ballWalk import AlbedoOf, BallAlbedo
from stages import author, shapes
from stages.materialX import OPEN_PBR, STANDARD, AddSurface

_CLEAR = dict(base=0.0, specular_IOR=1.0, specular_roughness=0.0, transmission=1.0)  # a boundary that neither bends nor reflects
_BALL = functools.partial(shapes.Sphere, 1.0, 48, 96)


def _Medium(extinction, albedo, **others) -> dict:
    """Of an interior with an extinction, by which transmission_color and transmission_scatter are defined."""
    extinction, albedo = (np.broadcast_to(value, 3).astype(float) for value in (extinction, albedo))
    return dict(_CLEAR, transmission_color=tuple(np.exp(-extinction)), transmission_depth=1.0,
                transmission_scatter=tuple(extinction * albedo), **others)


def _Below(color, radius, **others) -> dict:
    return dict(base=0.0, specular=0.0, subsurface=1.0, subsurface_color=tuple(np.broadcast_to(color, 3)),
                subsurface_radius=tuple(np.broadcast_to(radius, 3)), **others)


def _Stage(path, shape, surface, identifier=STANDARD, light=("Dome", {}), width=1.0, eye=(0, 0, 10)):
    stage = author.NewStage(str(path))
    material = AddSurface(stage, "/World/Look", identifier, **surface)
    author.AddMesh(stage, "/World/Shape", shape, material=material, doubleSided=True,
                   rotate=(90, 0, 0) if len(shape.points) == 4 else (0, 0, 0))
    if light is not None:
        author.AddLight(stage, "/World/Light", light[0], **light[1])
    author.AddCamera(stage, eye=eye, width=10.0 * width, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def _Mean(tmp_path, shape, surface, samples=256, maxDepth=24, **stage):
    """Mean colour [3] of a picture of a shape with a surface, seen along -z, or from an `eye`."""
    path = _Stage(tmp_path / "stage.usda", shape, surface, **stage)
    return ours.Render(path, 16, 16, samples=samples, maxDepth=maxDepth, russianRoulette=True).rgb.reshape(-1, 3).mean(0)


def _H(mu: float, albedo: float) -> float:
    """Chandrasekhar's H of isotropic scattering, by iteration of its integral equation."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    nodes, weights = (nodes + 1) / 2, weights / 2
    h = np.ones_like(nodes)
    for _ in range(4000):
        h = 1 / (np.sqrt(1 - albedo) + albedo / 2 * np.sum(weights * nodes * h / (nodes[:, None] + nodes), 1))
    return 1 / (np.sqrt(1 - albedo) + albedo / 2 * np.sum(weights * nodes * h / (mu + nodes)))


@pytest.mark.parametrize("surface, identifier", [
    (_Medium(3.0, 1.0), STANDARD),
    (_Medium(3.0, 1.0, transmission_scatter_anisotropy=0.7), STANDARD),
    (dict(_Medium(3.0, 1.0), specular_IOR=1.5), STANDARD),
    (_Below(1.0, 0.3), STANDARD),
    (_Below(1.0, (1.0, 0.4, 0.2), subsurface_anisotropy=0.5), STANDARD),
    (dict(_Below(1.0, 0.3), transmission=0.5, specular_IOR=1.0), STANDARD),
    (dict(specular_weight=0.0, subsurface_weight=0.5, subsurface_color=(1, 1, 1), base_color=(1, 1, 1)), OPEN_PBR),
], ids=["medium", "forward", "glass", "below", "belowOfColours", "belowAndGlass", "openPbr"])
def test_what_absorbs_nothing_is_invisible_in_a_furnace(tmp_path, surface, identifier):
    assert _Mean(tmp_path, _BALL(), surface, identifier=identifier) == pytest.approx(np.ones(3), abs=0.005)


@pytest.mark.parametrize("albedo, expected", [(0.5, 0.11523), (0.9, 0.41495), (0.99, 0.75272)])
def test_a_half_space_has_chandrasekhars_albedo(tmp_path, albedo, expected):
    assert 1 - _H(1.0, albedo) * np.sqrt(1 - albedo) == pytest.approx(expected, abs=1e-4)
    color = _Mean(tmp_path, shapes.Plane(100, 100), _Medium(1.0, albedo), samples=1024)
    assert color == pytest.approx(np.full(3, expected), rel=0.005)


def test_a_half_space_has_chandrasekhars_spherical_albedo(tmp_path):
    # What it gives back of light from all sides: the mean over directions by their cosines. Gauss's rule of four nodes.
    albedos, expected = (0.5, 0.9, 0.99), np.array([0.14654, 0.47802, 0.79456])
    nodes, weights = np.polynomial.legendre.leggauss(4)
    cosines, weights = (nodes + 1) / 2, weights * (nodes + 1) / 2
    exact = [sum(w * (1 - _H(mu, a) * np.sqrt(1 - a)) for mu, w in zip(cosines, weights)) for a in albedos]
    assert exact == pytest.approx(expected, rel=5e-4)
    seen = [_Mean(tmp_path, shapes.Plane(100, 100), _Medium(1.0, albedos), samples=2048,
                  eye=(10 * np.sqrt(1 - mu * mu), 0, 10 * mu)) for mu in cosines]
    assert weights @ np.array(seen) == pytest.approx(expected, rel=0.005)


def test_channels_have_the_albedos_they_have_alone(tmp_path):
    color = _Mean(tmp_path, shapes.Plane(100, 100), _Medium((1.0, 3.0, 0.5), (0.5, 0.9, 0.99)), samples=1024)
    assert color == pytest.approx(np.array([0.11523, 0.41495, 0.75272]), rel=0.01)


@pytest.mark.parametrize("scattering, tolerance", [(0.0, 1e-3), (1e-6, 4e-3)], ids=["absorbs", "scatters"])
def test_light_through_a_slab_follows_beers_law(tmp_path, scattering, tolerance):
    # By 1e-6 of scattering the medium is on the path, and its distances are sampled.
    color = np.array([0.3, 0.5, 0.9])
    surface = dict(_CLEAR, transmission_color=tuple(color), transmission_depth=0.5, transmission_scatter=(scattering,) * 3)
    left = _Mean(tmp_path, shapes.Box(4, 4, 0.75), surface, samples=64 if scattering == 0.0 else 4096)
    assert left == pytest.approx(color**1.5, rel=tolerance)


@pytest.mark.parametrize("identifier, names", [(STANDARD, ("subsurface", "subsurface_anisotropy", "specular")),
                                               (OPEN_PBR, ("subsurface_weight", "subsurface_scatter_anisotropy", "specular_weight"))],
                         ids=["standard", "openPbr"])
@pytest.mark.parametrize("asymmetry", [0.0, 0.6])
def test_a_thick_body_has_its_subsurface_color(tmp_path, identifier, names, asymmetry):
    color = np.array([0.2, 0.5, 0.8])
    surface = {names[0]: 1.0, names[1]: asymmetry, names[2]: 0.0, "subsurface_color": tuple(color)}
    shape = shapes.Plane(100, 100)
    assert _Mean(tmp_path, shape, surface, samples=256, identifier=identifier) == pytest.approx(color, rel=0.02)


@pytest.mark.parametrize("medium", [_Medium(2.0, 1.0), _Medium(2.0, 1.0, transmission_scatter_anisotropy=-0.5)], ids=["even", "backward"])
def test_a_light_in_fog_that_absorbs_nothing_keeps_its_power(tmp_path, medium):
    # Seen from far away, all directions are alike: the sum of the picture is the light's intensity, as if there were no fog.
    light = ("Sphere", dict(radius=0.1, intensity=100.0))
    fog = _Mean(tmp_path, _BALL(), medium, light=light, width=2.1, samples=4096)
    assert fog == pytest.approx(np.full(3, 100.0 * np.pi * 0.1**2 / 2.1**2), rel=0.01)


@pytest.mark.parametrize("radius", [0.03, 0.4])
def test_a_ball_below_a_uniform_sky_gives_back_what_walks_in_it_do(tmp_path, radius):
    # All of its points are alike, and leave by Lambert's law: so are all pixels. The smaller it is beside the mean free path, the
    # more does it give back than a half-space, whose part is subsurface_color.
    color = np.array([0.8, 0.5, 0.3])
    expected = np.array([BallAlbedo(AlbedoOf(one), radius) for one in color])
    assert (expected > color * (1.005 if radius < 0.1 else 1.08)).all()
    assert _Mean(tmp_path, shapes.Sphere(1.0, 96, 192), _Below(color, radius), samples=512) == pytest.approx(expected, rel=0.01)


def test_an_object_inside_of_another_does_not_stop_a_walk(tmp_path):
    path = _Stage(tmp_path / "stage.usda", _BALL(), _Below(0.8, 0.2))
    alone = ours.Render(path, 16, 16, samples=64).rgb
    from pxr import Usd
    stage = Usd.Stage.Open(path)
    author.AddMesh(stage, "/World/Core", shapes.Sphere(0.95, 24, 48), color=(0, 0, 0))
    stage.GetRootLayer().Save()
    assert ours.Render(path, 16, 16, samples=64).rgb.mean() == pytest.approx(alone.mean(), rel=0.01)


@pytest.mark.parametrize("surface", [
    _Below(0.8, (float("nan"), -1.0, 0.1)), _Below((float("nan"), -1.0, 2.0), 0.1), _Below(0.8, (1e30, 1e-30, 0.0)),
    _Below(0.8, 0.1, subsurface_anisotropy=-3.0), dict(_CLEAR, transmission_color=(0, 0, 0), transmission_depth=1e-30,
                                                       transmission_scatter=(1e30, 0, float("nan"))),
], ids=["radius", "color", "extremes", "anisotropy", "scatter"])
def test_numbers_that_make_no_sense_give_pixels_that_do(tmp_path, surface):
    path = _Stage(tmp_path / "stage.usda", _BALL(), surface, width=2.2)
    picture = ours.Render(path, 16, 16, samples=4)
    assert np.isfinite(picture.rgb).all() and picture.rgb.min() >= 0.0 and picture.rgb.max() < 2.0
    assert picture.statistics["accuracy"]["nanSamples"] == 0


@pytest.mark.parametrize("surface", [_Medium(3.0, 0.9), _Below(0.8, 0.2)], ids=["medium", "below"])
def test_open_meshes_are_finite_with_one_warning(tmp_path, surface):
    half = _BALL()
    kept = half.counts.cumsum() < half.indices.size * 2 // 3
    indices = half.indices[:int(half.counts[kept].sum())]
    path = _Stage(tmp_path / "stage.usda", shapes.Shape(half.points, half.counts[kept], indices), surface, width=2.2)
    picture = ours.Render(path, 16, 16, samples=16)
    assert np.isfinite(picture.rgb).all() and picture.rgb.max() < 1.1
    assert len(picture.warnings) == 1 and "/World/Shape: its mesh is not closed" in str(picture.warnings[0])
    whole = ours.Render(_Stage(tmp_path / "whole.usda", half, surface), 8, 8, samples=1)
    assert not whole.warnings


@pytest.fixture(scope="module")
def Mixed(tmp_path_factory):
    """Subsurface of instances, a glass of milk with a light and a ball in it, a cut-out, a card with walks below it."""
    from pxr import Gf, Usd, UsdGeom, Vt
    path = str(tmp_path_factory.mktemp("mixed") / "stage.usda")
    stage = author.NewStage(path)
    skin = AddSurface(stage, "/World/Skin", subsurface=0.8, subsurface_color=(0.9, 0.5, 0.3), subsurface_radius=(0.5, 0.2, 0.1))
    milk = AddSurface(stage, "/World/Milk", **_Medium(2.0, (0.99, 0.9, 0.7), subsurface=0.5, subsurface_color=(0.4, 0.8, 0.9)))
    veil = AddSurface(stage, "/World/Veil", OPEN_PBR, subsurface_weight=1.0, geometry_opacity=0.5, subsurface_radius=0.3)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
    author.AddMesh(stage, "/World/Many/Ball", shapes.Sphere(0.5, 12, 24), material=skin)
    author.AddMesh(stage, "/World/Many/Core", shapes.Sphere(0.3, 8, 16), color=(0.1, 0.1, 0.1), translate=(0, 0.1, 0))
    group = stage.DefinePrim("/World/Many/Both", "Xform")
    for name in ("Ball", "Core"):
        stage.DefinePrim(f"/World/Many/Both/{name}").GetReferences().AddInternalReference(f"/World/Many/{name}")
    instancer.CreatePrototypesRel().SetTargets([group.GetPath()])
    instancer.CreateProtoIndicesAttr(Vt.IntArray(3, 0))
    instancer.CreatePositionsAttr([Gf.Vec3f(x, 0.5, 0) for x in (-1.2, 0.0, 1.2)])
    author.AddMesh(stage, "/World/Glass", shapes.Sphere(0.6, 12, 24), material=milk, translate=(0.6, 0.6, 1.2))
    author.AddMesh(stage, "/World/Stone", shapes.Sphere(0.2, 8, 16), color=(0.7, 0.2, 0.1), translate=(0.6, 0.5, 1.2))
    author.AddMesh(stage, "/World/Veiled", shapes.Plane(3, 3), material=veil, rotate=(70, 0, 0), translate=(-0.5, 0.6, 1.5))
    author.AddMesh(stage, "/World/Floor", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5))
    author.AddLight(stage, "/World/Lamp", "Sphere", radius=0.1, intensity=20.0, placement=dict(translate=(0.6, 0.9, 1.2)))
    author.AddLight(stage, "/World/Key", "Rect", width=2.0, height=2.0, intensity=5.0, placement=dict(translate=(0, 3, 2), rotate=(-60, 0, 0)))
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.3)
    author.AddCamera(stage, eye=(0, 2.5, 6), target=(0, 0.5, 0), width=20.0)
    stage.GetRootLayer().Save()
    return path


_AOVS = ("color", "alpha", "albedo", "normal", "primId", "variance")
_SIZE = (41, 29)  # odd: no wave ends with a row


@pytest.fixture(scope="module")
def Expected(Mixed):
    return ours.Render(Mixed, *_SIZE, _AOVS, samples=5, russianRoulette=True, residency="resident").layers


@pytest.mark.parametrize("settings", [
    dict(waveSize=3001), dict(traversal="scalar"), dict(chunkBytes=4096),
    dict(chunkBytes=4096, residency="stream", geometryMemory="30%"), dict(chunkBytes=4096, residency="stream", geometryMemory="6%"),
    dict(chunkBytes=4096, residency="stream", geometryMemory="60%", request="first", geometryEviction="flush"),
], ids=["waves", "scalar", "chunks", "stream30", "stream6", "report"])
def test_bits_do_not_depend_on_how_media_are_traced(Mixed, Expected, settings):
    picture = ours.Render(Mixed, *_SIZE, _AOVS, samples=5, russianRoulette=True, **settings)
    for name, layer in Expected.items():
        assert layer.tobytes() == picture.layers[name].tobytes(), name


def test_threads_do_not_matter_to_media(Mixed, Expected):
    layers = ours.RenderApart(Mixed, *_SIZE, {"POCL_MAX_PTHREAD_COUNT": "5"}, aovs=list(_AOVS), samples=5, russianRoulette=True,
                              residency="resident")
    for name, layer in Expected.items():
        assert layer.tobytes() == layers[name].tobytes(), name


def test_stages_without_media_have_no_state_of_them(tmp_path):
    plain, walked = (ours.Render(_Stage(tmp_path / f"{k}.usda", _BALL(), surface), 16, 16, samples=1, waveSize=1024, kernels="own")
                     .statistics["memory"]["pathState"] for k, surface in enumerate([dict(_CLEAR), _Below(0.8, 0.2)]))
    assert walked - plain == 1024 * 3 * 16  # kernels/shared/pathState.def


def test_the_albedo_is_that_of_the_subsurface_color(tmp_path):
    path = _Stage(tmp_path / "stage.usda", _BALL(), _Below((0.2, 0.5, 0.8), 0.2))
    albedo = ours.Render(path, 16, 16, ("albedo",), samples=1).layers["albedo"]
    assert albedo.reshape(-1, 3).mean(0) == pytest.approx(np.array([0.2, 0.5, 0.8]), abs=1e-3)


def _MitsubaFog(extinction: float, albedo, asymmetry: float, samples: int) -> np.ndarray:
    """A cube of fog below a lamp by Mitsuba's volpath, which samples lights through boundaries that do not refract."""
    import mitsuba as mi

    color = lambda values: dict(type="rgb", value=list(values))
    place = mi.ScalarTransform4f
    medium = dict(type="homogeneous", sigma_t=float(extinction), albedo=color(albedo), phase=dict(type="hg", g=asymmetry))
    film = dict(type="hdrfilm", width=16, height=16, rfilter=dict(type="box"), pixel_format="rgb")
    view = place().look_at(origin=[0, 0, 10], target=[0, 0, 0], up=[0, 1, 0]) @ place().scale([1.2, 1.2, 1])
    lamp = place().translate([0, 3, 0]) @ place().rotate([1, 0, 0], 90) @ place().scale([3, 3, 1])
    scene = mi.load_dict(dict(
        type="scene", integrator=dict(type="volpath", max_depth=1000, rr_depth=1000),
        sensor=dict(type="orthographic", to_world=view, film=film, sampler=dict(type="independent")),
        fog=dict(type="cube", bsdf=dict(type="null"), interior=medium),
        lamp=dict(type="rectangle", to_world=lamp, emitter=dict(type="area", radiance=color((1.0,) * 3)))))
    return np.array(mi.render(scene, spp=samples, seed=3)).astype(np.float64)


def test_fog_below_a_lamp_equals_mitsubas(tmp_path):
    pytest.importorskip("mitsuba")
    import mitsubaScene

    mitsubaScene.UseVariant("scalar_rgb")  # LLVM cannot compile volpath for every CPU, and ends the process
    albedo = (0.95, 0.8, 0.5)
    light = ("Rect", dict(width=6.0, height=6.0, intensity=1.0, placement=dict(translate=(0, 3, 0), rotate=(-90, 0, 0))))
    fog = _Medium(3.0, albedo, transmission_scatter_anisotropy=0.4)
    path = _Stage(tmp_path / "stage.usda", shapes.Box(2, 2, 2), fog, light=light, width=2.4)
    picture = ours.Render(path, 16, 16, samples=4096, maxDepth=24, russianRoulette=True).rgb
    reference = _MitsubaFog(3.0, albedo, 0.4, 1024)
    assert picture.mean((0, 1)) == pytest.approx(reference.mean((0, 1)), rel=0.01)
    assert compare.RelMse(picture, reference) <= 1e-3
