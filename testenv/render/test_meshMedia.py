# SPDX-License-Identifier: Apache-2.0
"""Homogeneous volumes in meshes, against closed forms and quadrature: Beer's law, furnaces, single scattering, what glows."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import compare
import ours
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt
from stages import author, shapes
from stages.materialX import AddNode, AddSurface

_TOKEN = Sdf.ValueTypeNames.Token
_CLEAR = dict(base=0.0, specular_IOR=1.0, specular_roughness=0.0, transmission=1.0)  # a boundary that neither bends nor reflects
_BALL = shapes.Sphere(1.0, 48, 96)
_DARK = (("Sphere", dict(intensity=0.0, placement=dict(translate=(0, 50, 0)))),)  # else a stage is lit by a dome


def _Color(value) -> tuple:
    return tuple(float(v) for v in np.broadcast_to(value, 3))


def AddVolume(stage, path, absorption=0.0, scattering=0.0, anisotropy=0.0, emission=None, surface=None):
    """A material with a MaterialX volume, and where `surface` says so, a Standard Surface."""
    material = UsdShade.Material.Define(stage, path) if surface is None else AddSurface(stage, path, **surface)
    vdf = AddNode(stage, f"{path}/Vdf", "ND_anisotropic_vdf", _TOKEN, absorption=_Color(absorption), scattering=_Color(scattering),
                  anisotropy=anisotropy)
    inputs = dict(vdf=vdf)
    if emission is not None:
        inputs["edf"] = AddNode(stage, f"{path}/Edf", "ND_uniform_edf", _TOKEN, color=_Color(emission))
    volume, _ = AddNode(stage, f"{path}/Volume", "ND_volume", _TOKEN, **inputs)
    material.CreateOutput("mtlx:volume", _TOKEN).ConnectToSource(volume.GetOutput("out"))
    return material


def _Stage(path, bodies, lights=(("Dome", {}),), width=1.0, add=None, eye=(0, 0, 10), target=(0, 0, 0), orthographic=True):
    """\\param bodies: (shape, medium, placement): each a mesh with a volume. Seen along -z unless eye and target say otherwise."""
    stage = author.NewStage(str(path))
    for number, (shape, medium, placement) in enumerate(bodies):
        material = AddVolume(stage, f"/World/Look{number}", **medium)
        author.AddMesh(stage, f"/World/Body{number}", shape, material=material, **placement)
    for number, (kind, options) in enumerate(lights):
        author.AddLight(stage, f"/World/Light{number}", kind, **options)
    if add is not None:
        add(stage)
    author.AddCamera(stage, eye=eye, target=target, width=10.0 * width, aspect=1.0, orthographic=orthographic)
    stage.GetRootLayer().Save()
    return stage.GetRootLayer().realPath


def _Mean(path, samples=64, **settings):
    picture = ours.Render(path, 16, 16, samples=samples, **{"russianRoulette": True, "maxDepth": 24, **settings})
    assert not picture.warnings
    return picture.rgb.reshape(-1, 3).mean(0)


@pytest.mark.parametrize("medium", [
    dict(scattering=3.0), dict(scattering=(0.5, 3.0, 9.0), anisotropy=0.7),
    dict(scattering=3.0, surface=dict(_CLEAR)), dict(scattering=(1.0, 3.0, 0.0), surface=dict(_CLEAR, specular_IOR=1.5))],
    ids=["bare", "colours", "clear", "glass"])
def test_what_absorbs_nothing_is_invisible_in_a_furnace(tmp_path, medium):
    # Light that is reflected within glass at a grazing angle meets its wall many times between two events.
    glass = medium.get("surface", {}).get("specular_IOR", 1.0) > 1.0
    left = _Mean(_Stage(tmp_path / "s.usda", [(_BALL, medium, {})]), 2048 if glass else 512, maxDepth=200 if glass else 24)
    assert left == pytest.approx(np.ones(3), abs=0.005)


def test_overlapping_bodies_are_invisible_in_a_furnace(tmp_path):
    bodies = [(_BALL, dict(scattering=(2.0, 1.0, 5.0)), {}), (_BALL, dict(scattering=4.0, anisotropy=0.6), dict(translate=(0.4, 0, 0.7))),
              (shapes.Sphere(0.3, 24, 48), dict(scattering=0.0), {})]
    assert _Mean(_Stage(tmp_path / "s.usda", bodies), 512) == pytest.approx(np.ones(3), abs=0.005)


_SIGMA = np.array((0.4, 1.0, 2.5))


@pytest.mark.parametrize("medium, samples, tolerance", [
    (dict(absorption=_SIGMA), 4, 1e-3), (dict(absorption=_SIGMA, surface=dict(_CLEAR)), 64, 1e-3),
    (dict(absorption=_SIGMA, scattering=1e-6), 4096, 4e-3)], ids=["bare", "clear", "sampled"])
def test_light_through_a_slab_follows_beers_law(tmp_path, medium, samples, tolerance):
    # By 1e-6 of scattering distances are sampled.
    left = _Mean(_Stage(tmp_path / "s.usda", [(shapes.Box(4, 4, 0.75), medium, {})]), samples)
    assert left == pytest.approx(np.exp(-0.75 * _SIGMA), rel=tolerance)


def test_walks_that_end_for_their_length_are_counted(tmp_path):
    """1023 events are not enough for light that comes deep into a body of a thousand mean free paths."""
    ended = lambda name, scattering: ours.Render(
        _Stage(tmp_path / name, [(shapes.Box(2, 2, 2), dict(scattering=scattering), {})]), 4, 4, samples=64,
        maxDepth=24).statistics["accuracy"]["endedWalks"]
    assert ended("thin.usda", 2.0) == 0
    assert ended("dense.usda", 500.0) > 10  # of 1024 paths; 3.5 % of those in a half-space


def _LeftOfVeiledBox(sigma, opacity, count=60_000):
    """What is left of light from all sides behind a box of 2^3 that scatters alike in all directions, halved by a veil at z = 0
    that absorbs: walks by brute force, in double precision. (mean, its deviation)"""
    rng = np.random.default_rng(1)
    position = np.stack([rng.uniform(-0.05, 0.05, count), rng.uniform(-0.05, 0.05, count), np.full(count, 1.0)], 1)
    direction = np.tile([0.0, 0.0, -1.0], (count, 1))
    weight, left, index = np.ones(count), np.zeros(count), np.arange(count)
    while len(index):
        way = -np.log(1.0 - rng.random(len(index))) / sigma
        with np.errstate(divide="ignore", invalid="ignore"):
            out = np.min(np.where(direction > 0, (1 - position) / direction, np.where(direction < 0, (-1 - position) / direction, np.inf)), 1)
            veil = -position[:, 2] / direction[:, 2]
        weight = np.where((veil > 1e-12) & (veil < np.minimum(way, out)), weight * (1.0 - opacity), weight)
        leaves = way >= out
        left[index[leaves]] = weight[leaves]
        stays = ~leaves & (weight > 1e-4)
        position, weight, index = (position + way[:, None] * direction)[stays], weight[stays], index[stays]
        z, turn = rng.uniform(-1, 1, len(index)), rng.uniform(0, 2 * np.pi, len(index))
        radius = np.sqrt(1 - z * z)
        direction = np.stack([radius * np.cos(turn), radius * np.sin(turn), z], 1)
    return left.mean(), left.std() / np.sqrt(count)


def test_veils_in_a_body_that_scatters_are_chosen_anew_after_each_event(tmp_path):
    def AddVeil(stage):
        veil = AddSurface(stage, "/World/Veil", base=0.0, specular=0.0, opacity=(0.5,) * 3)
        author.AddMesh(stage, "/World/Card", shapes.Plane(1.998, 1.998), material=veil, doubleSided=True, rotate=(90, 0, 0))

    expected, deviation = _LeftOfVeiledBox(6.0, 0.5)  # 0.882; 0.918 were all crossings of a path alike
    left = _Mean(_Stage(tmp_path / "s.usda", [(shapes.Box(2, 2, 2), dict(scattering=6.0), {})], width=0.1, add=AddVeil), 1024)
    assert left == pytest.approx(np.full(3, expected), abs=0.003 + 4 * deviation)


@pytest.mark.parametrize("name, inputs, sigma", [
    ("arnold:standard_volume", dict(density=2.0, transparent=(0.5, 0.25, 0.1), transparent_depth=2.0, scatter=0.0, emission_mode="none"),
     -np.log((0.5, 0.25, 0.1))),
    ("PxrVolume", dict(densityFloat=0.5, densityColor=(1.0, 2.0, 3.0), diffuseColor=(0.0, 0.0, 0.0)), np.array((0.5, 1.0, 1.5)))])
def test_volumes_of_other_renderers_fill_meshes(tmp_path, name, inputs, sigma):
    def Add(stage):
        material = UsdShade.Material.Define(stage, "/World/Look")
        shader, _ = AddNode(stage, "/World/Look/V", name, _TOKEN, **inputs)
        material.CreateVolumeOutput().ConnectToSource(shader.GetOutput("out"))
        author.AddMesh(stage, "/World/Slab", shapes.Box(4, 4, 0.5), material=material)

    assert _Mean(_Stage(tmp_path / "s.usda", [], add=Add), 4) == pytest.approx(np.exp(-0.5 * sigma), rel=1e-3)


def test_what_is_inside_of_a_medium_takes_its_place(tmp_path):
    """A slab in a slab, each with its own colour, and within them clear glass that keeps no account of its own."""
    inner, outer = np.array((2.0, 0.1, 1.0)), _SIGMA
    glass = lambda stage: author.AddMesh(stage, "/World/Glass", shapes.Box(4, 4, 0.1), translate=(0, 0, -0.3),
                                         material=AddSurface(stage, "/World/Clear", **_CLEAR))
    bodies = [(shapes.Box(4, 4, 1.0), dict(absorption=outer), {}), (shapes.Box(4, 4, 0.25), dict(absorption=inner), {})]
    left = _Mean(_Stage(tmp_path / "s.usda", bodies, add=glass), 64)
    assert left == pytest.approx(np.exp(-0.65 * outer - 0.25 * inner), rel=1e-3)


def test_a_volume_takes_the_place_of_what_the_surface_says_of_its_inside(tmp_path):
    ink = dict(_CLEAR, transmission_color=(0.5, 0.1, 0.3), transmission_depth=0.2)
    assert _Mean(_Stage(tmp_path / "s.usda", [(shapes.Box(4, 4, 0.5), dict(surface=ink), {})]), 64) == pytest.approx(np.ones(3), rel=1e-3)


def test_bodies_may_be_left_in_the_order_in_which_they_were_entered(tmp_path):
    """From +z: slab A from 1 to -0.5, slab B from 0.5 to -1: where both are, B, which was entered last."""
    a, b = np.array((2.0, 0.1, 1.0)), _SIGMA
    bodies = [(shapes.Box(4, 4, 1.5), dict(absorption=a), dict(translate=(0, 0, 0.25))),
              (shapes.Box(4, 4, 1.5), dict(absorption=b), dict(translate=(0, 0, -0.25)))]
    assert _Mean(_Stage(tmp_path / "s.usda", bodies), 4) == pytest.approx(np.exp(-0.5 * a - 1.5 * b), rel=1e-3)


def test_faces_in_one_place_are_both_crossed(tmp_path):
    bodies = [(shapes.Box(4, 4, 0.5), dict(absorption=_SIGMA), dict(translate=(0, 0, z))) for z in (0.0, 0.5, -0.5)]
    assert _Mean(_Stage(tmp_path / "s.usda", bodies), 4) == pytest.approx(np.exp(-1.5 * _SIGMA), rel=1e-3)


def test_instances_are_bodies(tmp_path):
    def Add(stage):
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
        author.AddMesh(stage, "/World/Many/Slab", shapes.Box(4, 4, 0.2), material=AddVolume(stage, "/World/Look", absorption=_SIGMA))
        instancer.CreatePrototypesRel().SetTargets(["/World/Many/Slab"])
        instancer.CreateProtoIndicesAttr(Vt.IntArray(3, 0))
        instancer.CreatePositionsAttr([Gf.Vec3f(0, 0, z) for z in (-1.0, 0.0, 0.1)])

    assert _Mean(_Stage(tmp_path / "s.usda", [], add=Add), 4) == pytest.approx(np.exp(-0.5 * _SIGMA), rel=1e-3)


def _AddFloor(stage):
    author.AddMesh(stage, "/World/Floor", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5), rotate=(90, 0, 0), translate=(0, 0, -1))


def test_shadows_follow_beers_law(tmp_path):
    """A floor below two slabs, one in the other, that the sun and the view come through."""
    sun, inner = ("Distant", dict(angle=0.0)), np.array((2.0, 0.1, 1.0))
    bodies = [(shapes.Box(4, 4, 0.5), dict(absorption=_SIGMA), {}), (shapes.Box(4, 4, 0.1), dict(absorption=inner), {})]
    dark, bright = (_Mean(_Stage(tmp_path / f"{len(some)}.usda", some, (sun,), add=_AddFloor), 4) for some in (bodies, []))
    assert bright.min() > 0.01
    assert dark / bright == pytest.approx(np.exp(-2 * (0.4 * _SIGMA + 0.1 * inner)), rel=1e-3)


def _AddVeil(stage):
    """What is cut out entirely, in the middle."""
    veil = AddSurface(stage, "/World/Veil", opacity=(0.0, 0.0, 0.0))
    author.AddMesh(stage, "/World/Card", shapes.Plane(8, 8), material=veil, rotate=(90, 0, 0))


@pytest.mark.parametrize("add", [None, _AddVeil], ids=["bare", "veil"])
def test_what_glows_is_its_integral(tmp_path, add):
    """(1 - exp(-sigma d)) emission / sigma, and where nothing is absorbed, emission d; what lets rays pass is not seen."""
    sigma, emission = np.array((0.0, 1.0, 4.0)), np.array((1.0, 2.0, 3.0))
    body = (shapes.Box(4, 4, 0.75), dict(absorption=sigma, emission=emission), {})
    expected = emission * np.array([0.75, *((1 - np.exp(-0.75 * sigma[1:])) / sigma[1:])])
    assert _Mean(_Stage(tmp_path / "s.usda", [body], lights=_DARK, add=add), 4) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("others", [{}, dict(anisotropy=0.5)])
def test_what_glows_and_scatters_keeps_its_power(tmp_path, others):
    """From far away all directions are alike: the sum of the picture is emission times the volume, whatever scatters it."""
    emission = np.array((1.0, 2.0, 3.0))
    medium = dict(scattering=(0.3, 2.0, 6.0), emission=emission, **others)
    volume = _BallVolume()
    glow = _Mean(_Stage(tmp_path / "s.usda", [(_BALL, medium, {})], lights=_DARK, width=2.1), 2048)
    assert glow == pytest.approx(emission * volume / 2.1**2, rel=0.01)


def _BallVolume() -> float:
    corners = _BALL.points[_BALL.indices.reshape(-1, 4) if np.all(_BALL.counts == 4) else _Triangles(_BALL)]
    fans = [corners[:, (0, k, k + 1)] for k in range(1, corners.shape[1] - 1)]
    return sum(np.einsum("ni,ni->n", fan[:, 0], np.cross(fan[:, 1], fan[:, 2])).sum() for fan in fans) / 6


def _Triangles(shape) -> np.ndarray:
    starts = np.concatenate([[0], np.cumsum(shape.counts)[:-1]])
    return np.array([shape.indices[[s, s + k, s + k + 1]] for s, n in zip(starts, shape.counts) for k in range(1, n - 1)])


def test_single_scattering_of_the_sun(tmp_path):
    """A cube of fog that scatters little, lit from above and seen from the side: scattering times the phase function, the way of the
    light and that of the view."""
    sigma, albedo, g = 1.5, 1e-3, 0.4
    sun = ("Distant", dict(angle=0.0, placement=dict(rotate=(-90, 0, 0))))
    ground = _Stage(tmp_path / "g.usda", [], lights=(sun,), eye=(0, 10, 0.001), add=lambda stage: author.AddMesh(
        stage, "/World/Floor", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5)))
    irradiance = np.pi * _Mean(ground, 4) / 0.5
    medium = dict(absorption=sigma * (1 - albedo), scattering=sigma * albedo, anisotropy=g)
    fog = ours.Render(_Stage(tmp_path / "s.usda", [(shapes.Box(2, 2, 2), medium, {})], lights=(sun,)), 16, 16, samples=8192).rgb
    phase = (1 - g * g) / (4 * np.pi * (1 + g * g) ** 1.5)
    height = 0.5 - (np.arange(16 * 8) + 0.5) / (16 * 8)
    way = np.exp(-sigma * (1 - height)).reshape(16, 8).mean(1)
    expected = irradiance * albedo * phase * (1 - np.exp(-2 * sigma))
    assert fog.mean(1) == pytest.approx(way[:, None] * expected[None, :], rel=0.02)
    assert fog.mean((0, 1)) == pytest.approx(way.mean() * expected, rel=0.005)


def test_single_scattering_of_a_lamp_around_the_camera(tmp_path):
    """The camera and a small lamp are both in the fog: by quadrature along the view and over the lamp. With so small an albedo what
    scatters twice is 1e-5 of it."""
    sigma, albedo, radius, at = 0.8, 1e-5, 0.01, np.array((0.5, 0.0, -1.0))
    lamp = ("Sphere", dict(radius=radius, intensity=1000.0, placement=dict(translate=tuple(at))))
    medium = dict(absorption=sigma * (1 - albedo), scattering=sigma * albedo)
    body = (shapes.Box(6, 6, 6), medium, {})
    path = _Stage(tmp_path / "s.usda", [body], lights=(lamp,), eye=(0, 0, 1), width=0.02)
    t = (np.arange(200000) + 0.5) / 200000 * 4.0  # from z = 1 to the wall at z = -3
    distance = np.linalg.norm(np.stack([0 * t, 0 * t, 1 - t], -1) - at, axis=-1)
    light = np.zeros_like(t)  # from the solid angle of the lamp, whose near side the light comes from
    for u in (np.arange(16) + 0.5) / 16:
        cosine = 1 - u * (1 - np.sqrt(1 - (radius / distance) ** 2))
        toSurface = distance * cosine - np.sqrt(radius**2 - distance**2 * (1 - cosine**2))
        light += 1000.0 * 2 * np.pi * (1 - np.sqrt(1 - (radius / distance) ** 2)) * np.exp(-sigma * toSurface) / 16
    expected = np.mean(sigma * albedo / (4 * np.pi) * light * np.exp(-sigma * t)) * 4.0
    fog = _Mean(path, 4096)
    assert fog == pytest.approx(np.full(3, expected), rel=1e-3)


@pytest.mark.parametrize("orthographic", [True, False], ids=["orthographic", "perspective"])
def test_the_camera_may_be_in_media(tmp_path, orthographic):
    """In a slab that is in a slab, with one behind the camera that does not count."""
    inner = np.array((2.0, 0.1, 1.0))
    bodies = [(shapes.Box(4, 4, 3.0), dict(absorption=_SIGMA), {}), (shapes.Box(4, 4, 1.0), dict(absorption=inner), {}),
              (shapes.Box(4, 4, 0.5), dict(absorption=5.0), dict(translate=(0, 0, 1.0)))]
    path = _Stage(tmp_path / "s.usda", bodies, eye=(0, 0, 0.25), target=(0, 0, -1), width=0.02, orthographic=orthographic)
    assert _Mean(path, 4) == pytest.approx(np.exp(-0.75 * inner - 1.0 * _SIGMA), rel=1e-3)


def test_media_that_the_camera_does_not_see_are_not_around_it(tmp_path):
    bodies = [(shapes.Box(4, 4, 3.0), dict(absorption=_SIGMA), {}), (shapes.Box(6, 6, 6.0), dict(absorption=9.0), {})]
    path = _Stage(tmp_path / "s.usda", bodies, eye=(0, 0, 0.5), target=(0, 0, -1), width=0.02)
    stage = Usd.Stage.Open(path)
    unseen = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/Body1"))
    unseen.CreatePrimvar("hdstream:visibility:camera", Sdf.ValueTypeNames.Bool).Set(False)
    stage.Save()
    assert _Mean(path, 4) == pytest.approx(np.exp(-2.0 * _SIGMA), rel=1e-3)


def test_the_camera_may_be_in_ten_media(tmp_path):
    sigmas = [0.1 * (k + 1) for k in range(10)]
    bodies = [(shapes.Box(6 - k / 2, 6 - k / 2, 6 - k / 2), dict(absorption=s), {}) for k, s in enumerate(sigmas)]
    path = _Stage(tmp_path / "s.usda", bodies, eye=(0.1, 0.1, 0.1), target=(0.1, 0.1, -1), width=0.02)
    halves = np.array([3 - k / 4 for k in range(10)])
    ways = np.append(halves[:-1] - halves[1:], halves[-1] + 0.1)
    assert _Mean(path, 4) == pytest.approx(np.full(3, np.exp(-np.dot(ways, sigmas))), rel=1e-3)


@pytest.mark.parametrize("fromInside", [False, True], ids=["outside", "inside"])
def test_bodies_beyond_the_twelfth_are_not_there(tmp_path, fromInside):
    """Fifteen of them, one in the other: what a path comes into when it is in twelve changes nothing, nor does leaving it."""
    sigmas = np.linspace(0.1, 0.4, 15)
    bodies = [(shapes.Box(6 - k / 4, 6 - k / 4, 6 - k / 4), dict(absorption=float(s)), {}) for k, s in enumerate(sigmas)]
    eye = (0.1, 0.1, 0.1) if fromInside else (0.1, 0.1, 10.0)
    path = _Stage(tmp_path / "s.usda", bodies, eye=eye, target=(0.1, 0.1, -1), width=0.02)
    halves = np.array([3 - k / 8 for k in range(12)])
    shells = np.append(halves[:-1] - halves[1:], 0.0)
    ways = shells + np.append(np.zeros(11), halves[-1] + 0.1) if fromInside else 2 * shells + np.append(np.zeros(11), 2 * halves[-1])
    assert _Mean(path, 4) == pytest.approx(np.full(3, np.exp(-np.dot(ways, sigmas[:12]))), rel=1e-3)


def test_the_camera_in_fog_that_absorbs_nothing_sees_a_furnace(tmp_path):
    body = (_BALL, dict(scattering=(0.5, 2.0, 8.0), anisotropy=0.3), {})
    path = _Stage(tmp_path / "s.usda", [body], eye=(0.2, 0.1, 0.3), target=(0, 0, -5), width=2.0, orthographic=False)
    assert _Mean(path, 512) == pytest.approx(np.ones(3), abs=0.005)


@pytest.mark.parametrize("z", [10.0, 1.0], ids=["outside", "inside"])
@pytest.mark.parametrize("scattering, samples, tolerance", [(0.0, 4, 1e-3), (1e-6, 4096, 4e-3)], ids=["absorbs", "sampled"])
def test_media_end_where_the_camera_sees_no_further(tmp_path, scattering, samples, tolerance, z):
    """A slab that ends at z = -2, and that the far plane cuts at z = 0: the dome behind is dimmed by one unit of it."""
    slab = shapes.Box(4, 4, 3.0 if z == 10.0 else 6.0)
    body = (slab, dict(absorption=_SIGMA, scattering=scattering), dict(translate=(0, 0, -0.5 if z == 10.0 else 1.0)))
    path = _Stage(tmp_path / "s.usda", [body], eye=(0, 0, z), target=(0, 0, -5))
    stage = Usd.Stage.Open(path)
    stage.GetPrimAtPath("/World/Camera").GetAttribute("clippingRange").Set(Gf.Vec2f(0.1, z))
    stage.Save()
    assert _Mean(path, samples) == pytest.approx(np.exp(-_SIGMA), rel=tolerance)


def test_alpha_is_what_is_in_the_way(tmp_path):
    for sigma, scattering, samples in ((1.0, 0.0, 4), (0.7, 0.3, 4096)):
        body = (shapes.Box(4, 4, 1.0), dict(absorption=sigma, scattering=scattering), {})
        path = _Stage(tmp_path / f"{scattering}.usda", [body], lights=_DARK)
        alpha = ours.Render(path, 8, 8, samples=samples).layers["color"][..., 3]
        assert alpha.mean() == pytest.approx(1 - np.exp(-1), rel=0.01)


def test_first_hits_are_those_behind_bare_boundaries(tmp_path):
    path = _Stage(tmp_path / "s.usda", [(shapes.Box(4, 4, 1.0), dict(absorption=_SIGMA), {})], add=_AddFloor)
    plain = _Stage(tmp_path / "p.usda", [], add=_AddFloor)
    depths = [ours.Render(one, 8, 8, ("color", "cameraDepth"), samples=1).layers["cameraDepth"] for one in (path, plain)]
    assert np.array_equal(*depths)


def test_subsets_have_media_of_their_own(tmp_path):
    def Add(stage):
        slab = author.AddMesh(stage, "/World/Slab", shapes.Box(4, 4, 0.5), material=AddVolume(stage, "/World/Look", absorption=_SIGMA))
        slab.GetPrim().SetMetadata("comment", "all faces in one subset")
        subset = UsdGeom.Subset.CreateGeomSubset(slab, "All", "face", Vt.IntArray(range(6)), "materialBind")
        author.Bind(subset.GetPrim(), AddVolume(stage, "/World/Other", absorption=2 * _SIGMA))

    assert _Mean(_Stage(tmp_path / "s.usda", [], add=Add), 4) == pytest.approx(np.exp(-_SIGMA), rel=1e-3)


def test_open_meshes_are_finite_with_one_warning(tmp_path):
    kept = _BALL.counts.cumsum() < _BALL.indices.size * 2 // 3
    half = shapes.Shape(_BALL.points, _BALL.counts[kept], _BALL.indices[:int(_BALL.counts[kept].sum())])
    body = (half, dict(scattering=3.0, absorption=0.5, emission=0.1), {})
    picture = ours.Render(_Stage(tmp_path / "s.usda", [body], width=2.2), 16, 16, samples=16)
    assert np.isfinite(picture.rgb).all() and picture.rgb.max() < 2.0
    assert len(picture.warnings) == 1 and "/World/Body0: its mesh is not closed" in str(picture.warnings[0])
    assert picture.statistics["accuracy"]["nanSamples"] == 0


@pytest.mark.parametrize("medium", [dict(absorption=-1.0), dict(scattering=float("nan")), dict(emission=float("inf"))], ids=str)
def test_numbers_that_make_no_sense_are_left_out(tmp_path, medium):
    picture = ours.Render(_Stage(tmp_path / "s.usda", [(_BALL, medium, {})]), 8, 8, samples=4)
    assert np.all(picture.rgb == 1)
    assert len(picture.warnings) == 1 and "makes no sense" in str(picture.warnings[0])


def test_curves_have_no_inside(tmp_path):
    def Add(stage):
        curves = UsdGeom.BasisCurves.Define(stage, "/World/Hair")
        curves.CreatePointsAttr([(-1, 0, 0), (1, 0, 0)])
        curves.CreateCurveVertexCountsAttr([2])
        curves.CreateTypeAttr("linear")
        curves.CreateWidthsAttr([0.2, 0.2])
        author.Bind(curves.GetPrim(), AddVolume(stage, "/World/Look", absorption=9.0))

    picture = ours.Render(_Stage(tmp_path / "s.usda", [], add=Add), 8, 8, samples=4)
    assert np.all(picture.rgb == 1)
    assert len(picture.warnings) == 1 and "only meshes have an inside" in str(picture.warnings[0])


def test_fields_count_as_one(tmp_path):
    def Add(stage):
        material = UsdShade.Material.Define(stage, "/World/Look")
        field = AddNode(stage, "/World/Look/F", "ND_geompropvalue_float", Sdf.ValueTypeNames.Float, geomprop="smoke")
        sigma = AddNode(stage, "/World/Look/M", "ND_multiply_vector3FA", Sdf.ValueTypeNames.Vector3f, in1=_Color(_SIGMA), in2=field)
        vdf = AddNode(stage, "/World/Look/Vdf", "ND_absorption_vdf", _TOKEN, absorption=sigma)
        volume, _ = AddNode(stage, "/World/Look/V", "ND_volume", _TOKEN, vdf=vdf)
        material.CreateOutput("mtlx:volume", _TOKEN).ConnectToSource(volume.GetOutput("out"))
        author.AddMesh(stage, "/World/Slab", shapes.Box(4, 4, 0.5), material=material)

    picture = ours.Render(_Stage(tmp_path / "s.usda", [], add=Add), 8, 8, samples=4)
    assert picture.rgb.reshape(-1, 3).mean(0) == pytest.approx(np.exp(-0.5 * _SIGMA), rel=1e-3)
    assert len(picture.warnings) == 1 and "follows the field smoke, which counts as 1" in str(picture.warnings[0])


@pytest.fixture(scope="module")
def Mixed(tmp_path_factory):
    """The camera in a haze with a lamp, a ball of fog that glows, glass of fog, wax, plain glass, a cut-out and instances in it."""
    def Add(stage):
        fog = AddVolume(stage, "/World/Fog", scattering=(2.0, 3.0, 1.0), anisotropy=0.4, emission=(0.2, 0.0, 0.1))
        ink = AddVolume(stage, "/World/Ink", absorption=(0.5, 2.0, 3.0), surface=dict(_CLEAR, specular_IOR=1.5))
        wax = AddSurface(stage, "/World/Wax", subsurface=0.8, subsurface_color=(0.9, 0.5, 0.3), subsurface_radius=(0.5, 0.2, 0.1))
        glass = AddSurface(stage, "/World/Glass", **dict(_CLEAR, specular_IOR=1.4))
        veil = AddSurface(stage, "/World/Veil", opacity=(0.5, 0.5, 0.5))
        ball = shapes.Sphere(0.5, 12, 24)
        for number, (material, place) in enumerate(((fog, (-1, 0.5, 0)), (ink, (0.3, 0.5, 0)), (wax, (1.5, 0.5, 0)),
                                                    (glass, (-0.6, 0.5, 0.3)))):
            author.AddMesh(stage, f"/World/Ball{number}", ball, material=material, translate=place)
        author.AddMesh(stage, "/World/Card", shapes.Plane(3, 3), material=veil, rotate=(70, 0, 0), translate=(-0.5, 0.6, 1.5))
        author.AddMesh(stage, "/World/Floor", shapes.Plane(6, 6), color=(0.5, 0.5, 0.5))
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
        author.AddMesh(stage, "/World/Many/Puff", shapes.Sphere(0.2, 8, 16), material=fog)
        instancer.CreatePrototypesRel().SetTargets(["/World/Many/Puff"])
        instancer.CreateProtoIndicesAttr(Vt.IntArray(3, 0))
        instancer.CreatePositionsAttr([Gf.Vec3f(x, 1.2, 0.5) for x in (-1.2, 0.0, 1.2)])

    lights = (("Sphere", dict(radius=0.1, intensity=40.0, placement=dict(translate=(0.6, 1.6, 1.2)))), ("Dome", dict(intensity=0.3)),
              ("Rect", dict(width=2.0, height=2.0, intensity=5.0, placement=dict(translate=(0, 5, 2), rotate=(-90, 0, 0)))))
    haze = (shapes.Box(16, 8, 16), dict(absorption=0.02, scattering=(0.03, 0.05, 0.08)), {})
    return _Stage(tmp_path_factory.mktemp("mixed") / "s.usda", [haze], lights, eye=(0, 2.5, 6), target=(0, 0.5, 0), width=2.0,
                  add=Add, orthographic=False)


_AOVS = ("color", "alpha", "albedo", "volumeDepth", "normal", "primId", "variance")
_SIZE = (41, 29)  # odd: no wave ends with a row


@pytest.fixture(scope="module")
def Expected(Mixed):
    picture = ours.Render(Mixed, *_SIZE, _AOVS, samples=5, russianRoulette=True, residency="resident")
    assert picture.rgb.mean() > 0.05 and not picture.warnings
    return picture.layers


@pytest.mark.parametrize("settings", [
    dict(waveSize=3001), dict(traversal="scalar"), dict(chunkBytes=4096),
    dict(chunkBytes=4096, residency="stream", geometryMemory="30%"), dict(chunkBytes=4096, residency="stream", geometryMemory="6%"),
    dict(chunkBytes=4096, residency="stream", geometryMemory="60%", request="first", geometryEviction="flush"),
], ids=["waves", "scalar", "chunks", "stream30", "stream6", "report"])
def test_bits_do_not_depend_on_how_media_are_traced(Mixed, Expected, settings):
    picture = ours.Render(Mixed, *_SIZE, _AOVS, samples=5, russianRoulette=True, **settings)
    for name, layer in Expected.items():
        assert layer.tobytes() == picture.layers[name].tobytes(), name


def test_threads_do_not_matter(Mixed, Expected):
    layers = ours.RenderApart(Mixed, *_SIZE, {"POCL_MAX_PTHREAD_COUNT": "5"}, aovs=list(_AOVS), samples=5, russianRoulette=True,
                              residency="resident")
    for name, layer in Expected.items():
        assert layer.tobytes() == layers[name].tobytes(), name


def test_light_path_expressions_know_media(Mixed, Expected):
    parts = ("emission", "diffuse", "specular", "transmission", "volume")
    layers = ours.Render(Mixed, *_SIZE, ("color", *parts), samples=5, russianRoulette=True).layers
    assert np.array_equal(layers["color"], Expected["color"])
    total = sum(layers[name].astype(np.float64) for name in parts)
    assert total == pytest.approx(layers["color"][..., :3], rel=1e-4, abs=1e-4)
    assert layers["volume"].max() > 0.01 and layers["emission"].max() > 0.01


def test_stages_without_media_in_meshes_have_no_state_of_them(tmp_path):
    walk = lambda stage: author.AddMesh(stage, "/World/Wax", _BALL, material=AddSurface(
        stage, "/World/Look", subsurface=1.0, opacity=(0.5, 0.5, 0.5)))
    paths = [_Stage(tmp_path / "a.usda", [], add=walk), _Stage(tmp_path / "b.usda", [(_BALL, dict(absorption=1.0), {})], add=None)]
    plain, filled = (ours.Render(path, 16, 16, samples=1, waveSize=1024, kernels="own").statistics["memory"]["pathState"]
                     for path in paths)
    assert filled - plain == 1024 * 4 * 16  # kernels/shared/pathState.def


def test_fog_below_a_lamp_equals_mitsubas(tmp_path):
    pytest.importorskip("mitsuba")
    import mitsubaScene
    from test_media import _MitsubaFog

    mitsubaScene.UseVariant("scalar_rgb")  # see test_media.py
    albedo = np.array((0.95, 0.8, 0.5))
    lamp = ("Rect", dict(width=6.0, height=6.0, intensity=1.0, placement=dict(translate=(0, 3, 0), rotate=(-90, 0, 0))))
    medium = dict(absorption=3.0 * (1 - albedo), scattering=3.0 * albedo, anisotropy=0.4)
    path = _Stage(tmp_path / "s.usda", [(shapes.Box(2, 2, 2), medium, {})], (lamp,), width=2.4)
    picture = ours.Render(path, 16, 16, samples=4096, maxDepth=24, russianRoulette=True).rgb
    reference = _MitsubaFog(3.0, albedo, 0.4, 1024)
    assert picture.mean((0, 1)) == pytest.approx(reference.mean((0, 1)), rel=0.01)
    assert compare.RelMse(picture, reference) <= 1e-3
