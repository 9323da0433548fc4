# SPDX-License-Identifier: Apache-2.0
"""Surfaces whose closures are put together by hand: what fits one layered surface has its bits, a hit takes one of the others by
chance, and MaterialX's own node graphs of its surfaces look like our built-in ones."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Sdf, UsdShade
from stages import author, shapes
from stages.materialX import OPEN_PBR, STANDARD, AddNode, AddSurface, Ball

GLTF = "ND_gltf_pbr_surfaceshader"
DISNEY = "ND_disney_principled"
RED, BLUE, GOLD, EDGE = (0.7, 0.1, 0.08), (0.1, 0.2, 0.9), (0.95, 0.7, 0.35), (0.9, 0.8, 0.7)
GRAY, WHITE = (0.4, 0.4, 0.4), (1.0, 1.0, 1.0)
DOME = (("Dome", {}),)
LAMP = (("Sphere", dict(placement=dict(translate=(3, 3, 3)), intensity=20.0)), ("Dome", dict(intensity=0.3)))


class Closures:
    """Closures below one material, each a node of its own; calls give (shader, output) to be connected."""

    def __init__(self, stage):
        self._stage, self._count = stage, 0

    def __call__(self, kind, **inputs):
        self._count += 1
        return AddNode(self._stage, f"/World/Look/Node{self._count}", f"ND_{kind}", Sdf.ValueTypeNames.Token, **inputs)

    def Diffuse(self, color=RED, **inputs):
        return self("oren_nayar_diffuse_bsdf", color=color, **inputs)

    def Reflection(self, alpha=0.25, **inputs):
        return self("dielectric_bsdf", roughness=(alpha, alpha), **inputs)

    def Metal(self, color=GOLD, edge=EDGE, alpha=0.25):
        return self("generalized_schlick_bsdf", color0=color, color82=edge, roughness=(alpha, alpha))

    def Conductor(self, color=GOLD, edge=EDGE, alpha=0.25):
        index, _ = self("artistic_ior", reflectivity=color, edge_color=edge)
        for output in ("ior", "extinction"):
            index.CreateOutput(output, Sdf.ValueTypeNames.Color3f)
        return self("conductor_bsdf", ior=(index, "ior"), extinction=(index, "extinction"), roughness=(alpha, alpha))

    def Layer(self, top, base):
        return self("layer_bsdf", top=top, base=base)

    def Mix(self, bg, fg, mix):
        return self("mix_bsdf", bg=bg, fg=fg, mix=mix)


def _Surface(bsdf, edf=None, **inputs):
    """A function that adds a surface of closures to a stage. bsdf, edf: functions of Closures."""
    def Add(stage):
        UsdShade.Material.Define(stage, "/World/Look")
        closures = Closures(stage)
        connected = {name: make(closures) for name, make in (("bsdf", bsdf), ("edf", edf)) if make is not None}
        return AddSurface(stage, "/World/Look", "ND_surface", **connected, **inputs)
    return Add


def _Standard(**inputs):
    return lambda stage: AddSurface(stage, "/World/Look", STANDARD, **inputs)


def _OpenPbr(**inputs):
    return lambda stage: AddSurface(stage, "/World/Look", OPEN_PBR, **inputs)


def _Picture(tmp_path, addMaterial, lights=LAMP, samples=64, size=32, shape=None, degrees=0, aovs=("color",), **settings):
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    rotate = (0, 0, 0) if shape is None else (90 + degrees, 0, 0)  # a plane, by its angle to the viewer
    author.AddMesh(stage, "/World/Shape", shape or shapes.Sphere(1.0, 32, 64), material=addMaterial(stage), doubleSided=True,
                   rotate=rotate)
    for index, (kind, inputs) in enumerate(lights):
        author.AddLight(stage, f"/World/Light{index}", kind, **inputs)
    author.AddCamera(stage, eye=(0, 0, 10), width=2.4, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return ours.Render(stage.GetRootLayer().realPath, size, size, samples=samples, aovs=aovs, **settings)


FITS = {
    "diffuse": (_Surface(lambda c: c.Diffuse()), _Standard(base=1.0, base_color=RED, specular=0.0)),
    "plastic": (_Surface(lambda c: c.Layer(c.Reflection(), c.Diffuse())),
                _Standard(base=1.0, base_color=RED, specular_roughness=0.5)),
    "metal": (_Surface(lambda c: c.Metal()),
              _OpenPbr(base_color=GOLD, specular_color=EDGE, base_metalness=1.0, specular_roughness=0.5)),
    "conductor": (_Surface(lambda c: c.Conductor()),
                  _Standard(base=1.0, base_color=GOLD, specular_color=EDGE, metalness=1.0, specular_roughness=0.5)),
    "metalBesidePlastic": (
        _Surface(lambda c: c.Mix(c.Layer(c.Reflection(tint=EDGE), c.Diffuse(GOLD)), c.Conductor(), 0.5)),
        _Standard(base=1.0, base_color=GOLD, specular_color=EDGE, metalness=0.5, specular_roughness=0.5)),
    "coat": (_Surface(lambda c: c.Layer(c.Reflection(0.0625), c.Layer(c.Reflection(), c.Diffuse()))),
             _Standard(base=1.0, base_color=RED, specular_roughness=0.5, coat=1.0, coat_roughness=0.25)),
    "glass": (_Surface(lambda c: c.Reflection(scatter_mode="RT")),
              _Standard(base=0.0, specular_roughness=0.5, transmission=1.0)),
    "glassBesideDiffuse": (
        _Surface(lambda c: c.Layer(c.Reflection(), c.Mix(c.Diffuse(), c.Reflection(scatter_mode="T"), 0.5))),
        _Standard(base=1.0, base_color=RED, specular_roughness=0.5, transmission=0.5)),
    "sheen": (_Surface(lambda c: c.Layer(c("sheen_bsdf", roughness=0.5), c.Diffuse())),
              _Standard(base=1.0, base_color=RED, specular=0.0, sheen=1.0, sheen_roughness=0.5)),
    "emission": (_Surface(lambda c: c.Diffuse(), lambda c: c("uniform_edf", color=BLUE)),
                 _Standard(base=1.0, base_color=RED, specular=0.0, emission=1.0, emission_color=BLUE)),
}


@pytest.mark.parametrize("name", FITS)
def test_what_fits_one_layered_surface_has_its_bits(tmp_path, name):
    byHand, builtIn = (_Picture(tmp_path, surface, samples=4).rgb for surface in FITS[name])
    assert np.array_equal(byHand, builtIn)


def _FresnelOfMetal(n, k, cosine):
    """Fresnel's amplitudes with a complex index, for both polarisations, averaged."""
    index = np.asarray(n) + 1j * np.asarray(k)
    within = np.sqrt(1 - (1 - cosine ** 2) / index ** 2)
    s = (cosine - index * within) / (cosine + index * within)
    p = (within - index * cosine) / (within + index * cosine)
    return 0.5 * (abs(s) ** 2 + abs(p) ** 2)


@pytest.mark.parametrize("degrees", [0, 45, 75])
def test_a_smooth_conductor_reflects_by_fresnels_equations(tmp_path, degrees):
    n, k = (0.183, 1.2, 1.373), (3.424, 0.7, 1.770)
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    mirror = _Surface(lambda c: c("conductor_bsdf", ior=n, extinction=k, roughness=(0.0, 0.0)))(stage)
    author.AddMesh(stage, "/World/Shape", shapes.Plane(4, 4), material=mirror, doubleSided=True, rotate=(90 + degrees, 0, 0))
    author.AddLight(stage, "/World/Sky", "Dome")
    author.AddCamera(stage, eye=(0, 0, 10), width=1.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    color = ours.Render(stage.GetRootLayer().realPath, 8, 8, samples=16).rgb.mean((0, 1))
    assert color == pytest.approx(_FresnelOfMetal(n, k, np.cos(np.radians(degrees))), rel=2e-3)


def test_metals_of_both_kinds_are_mixed(tmp_path):
    def Schlick(c):
        return c.Metal(GRAY, WHITE)

    def Conductor(c):
        return c.Conductor(GRAY, WHITE)

    # At 80 degrees: they have the same reflectance seen along the normal.
    schlick, conductor, mixed = (_Picture(tmp_path, _Surface(part), DOME, samples=256, size=8, shape=shapes.Plane(40, 40), degrees=80,
                                          maxDepth=0).rgb.mean((0, 1))
                                 for part in (Schlick, Conductor, lambda c: c.Mix(Schlick(c), Conductor(c), 0.5)))
    assert abs(schlick - conductor).min() > 0.02
    assert mixed == pytest.approx(0.5 * (schlick + conductor), abs=2e-3)


def _Dull(c):
    return c.Diffuse((0.8, 0.2, 0.1))


def _Shiny(c):
    return c.Metal((0.9, 0.9, 0.3), WHITE, 0.3)


def _Plastic(c):
    return c.Layer(c.Reflection(0.09), c.Diffuse(BLUE))


def _Sum(c):
    return c("add_bsdf", in1=c("multiply_bsdfF", in1=_Shiny(c), in2=0.25), in2=c("multiply_bsdfC", in1=_Plastic(c), in2=EDGE))


CHOSEN = {
    "mix": (lambda c: c.Mix(_Shiny(c), _Plastic(c), 0.3), (0.0, 0.7, 0.3)),
    "mixOfMixes": (lambda c: c.Mix(c.Mix(_Dull(c), _Shiny(c), 0.5), _Plastic(c), 0.4), (0.3, 0.3, 0.4)),
    "sum": (_Sum, (0.0, 0.25, np.array(EDGE))),
}


@pytest.mark.parametrize("name", CHOSEN)
def test_a_mixture_looks_like_the_weighed_sum_of_its_parts(tmp_path, name):
    # Without bounces pictures are linear in the BSDF.
    closure, weights = CHOSEN[name]
    parts = [_Picture(tmp_path, _Surface(part), samples=256, maxDepth=1).rgb for part in (_Dull, _Shiny, _Plastic)]
    mixed = _Picture(tmp_path, _Surface(closure), samples=256, maxDepth=1).rgb
    difference = mixed - sum(weight * part for weight, part in zip(weights, parts))
    assert abs(difference.mean((0, 1))).max() < 5e-4  # of 0.1 to 0.25; the noise of one render is 1e-4
    assert abs(difference.reshape(8, 4, 8, 4, 3).mean((1, 3))).max() < 4e-3


def test_what_absorbs_nothing_is_invisible_in_a_furnace(tmp_path):
    def White(c):
        plastic = c.Layer(c.Reflection(), c.Diffuse(WHITE))
        return c.Mix(c.Diffuse(WHITE, roughness=1.0), c.Mix(c.Metal(WHITE, WHITE, 0.64), plastic, 0.5), 0.6)
    color = _Picture(tmp_path, _Surface(White), DOME, samples=64, maxDepth=24).rgb.mean((0, 1))
    assert color == pytest.approx(np.ones(3), abs=5e-3)


@pytest.mark.parametrize("bsdf, expected", [
    (lambda c: c.Layer(c("sheen_bsdf", weight=0.05, roughness=0.5), c.Reflection(1e-4, scatter_mode="RT")), 1.0),
    (lambda c: c("add_bsdf", in1=c.Reflection(1e-4, scatter_mode="T", tint=(0.9,) * 3), in2=c.Diffuse((0.05,) * 3)), 0.95)],
    ids=["sheenOnGlass", "glassAndDiffuse"])
def test_clear_walls_that_are_chosen_seldom_let_pass_what_they_would(tmp_path, bsdf, expected):
    """Each closure counts by the inverse of its chance: then more than all of a ray may pass the one that is clear."""
    picture = _Picture(tmp_path, _Surface(bsdf, thin_walled=True), lights=DOME, samples=1024, size=4, shape=shapes.Plane(8, 8), maxDepth=4)
    assert picture.rgb.mean() == pytest.approx(expected, abs=0.005)


@pytest.mark.parametrize("light", [DOME, (("Distant", dict(angle=0.0, intensity=1.0, placement=dict(rotate=(180, 0, 0)))),)],
                         ids=["dome", "sun"])
def test_each_thin_wall_on_a_way_chooses_for_itself(tmp_path, light):
    # Two walls in front of a dome, or of a diffuse leaf that a sun lights through both: half of each is black.
    def Picture(mix):
        def Wall(c):
            return c.Mix(c.Reflection(1e-4, ior=1.0005, scatter_mode="RT"), c.Diffuse((0.0, 0.0, 0.0)), mix)
        stage = author.NewStage(str(tmp_path / "stage.usda"))
        wall = _Surface(Wall, thin_walled=True)(stage)
        for index in range(2):
            author.AddMesh(stage, f"/World/Wall{index}", shapes.Plane(4, 4), material=wall, doubleSided=True,
                           translate=(0, 0, index), rotate=(90, 0, 0))
        if light is not DOME:
            leaf = AddSurface(stage, "/World/LeafLook", base=0.0, specular=0.0, subsurface=1.0, subsurface_color=WHITE,
                              thin_walled=True)
            author.AddMesh(stage, "/World/Leaf", shapes.Plane(4, 4), material=leaf, doubleSided=True,
                           translate=(0, 0, 5), rotate=(90, 0, 0))
        for index, (kind, inputs) in enumerate(light):
            author.AddLight(stage, f"/World/Light{index}", kind, **inputs)
        author.AddCamera(stage, eye=(0, 0, 10), width=1.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        return ours.Render(stage.GetRootLayer().realPath, 16, 16, samples=256, maxDepth=8).rgb.mean()
    assert Picture(0.5) / Picture(0.0) == pytest.approx(0.25, rel=0.03)


def test_surfaces_are_mixed_with_what_shows_them(tmp_path):
    def Mixed(stage):
        UsdShade.Material.Define(stage, "/World/Look")
        back, front = (AddNode(stage, f"/World/Look/{name}", STANDARD, Sdf.ValueTypeNames.Token, base=1.0, specular=0.0, **inputs)
                       for name, inputs in (("Back", dict(base_color=RED, emission=1.0, emission_color=(0.0, 0.0, 0.4))),
                                            ("Front", dict(base_color=RED, opacity=(0.5, 0.5, 0.5)))))
        return AddSurface(stage, "/World/Look", "ND_mix_surfaceshader", bg=back, fg=front, mix=0.5)
    color = _Picture(tmp_path, Mixed, DOME, shape=shapes.Plane(4, 4), samples=256, maxDepth=1).rgb.mean((0, 1))
    # Present by 3/4: all of the back, which emits, and half of the front. The rest shows the dome.
    assert color == pytest.approx(0.75 * np.array(RED) + np.array([0.0, 0.0, 0.2]) + 0.25, abs=0.01)


# Sheens in three places, and what they are of the surface's own.
SHEENS = {
    "diffuse": (STANDARD, dict(base=0.5, base_color=RED, specular=0.8, metalness=0.4, sheen=0.9, sheen_color=BLUE, sheen_roughness=0.5)),
    "over": (GLTF, dict(base_color=GOLD, metallic=1.0, roughness=0.5, sheen_color=(0.7, 0.5, 0.6), sheen_roughness=0.7)),
    "rougherThanAny": (STANDARD, dict(base=0.5, base_color=RED, metalness=0.8, sheen=0.9, sheen_color=BLUE, sheen_roughness=9.0)),
    "fuzz": (OPEN_PBR, dict(base_color=GRAY, fuzz_weight=0.8, fuzz_color=GOLD, fuzz_roughness=0.4, coat_weight=0.5)),
}


@pytest.mark.parametrize("one, other", [("over", "diffuse"), ("diffuse", "over"), ("fuzz", "over"), ("over", "fuzz"),
                                        ("over", "rougherThanAny")])
def test_mixed_surfaces_keep_the_places_of_their_sheens(tmp_path, one, other):
    def Mixed(stage):
        UsdShade.Material.Define(stage, "/World/Look")
        back, front = (AddNode(stage, f"/World/Look/{name}", SHEENS[name][0], Sdf.ValueTypeNames.Token, **SHEENS[name][1])
                       for name in (one, other))
        return AddSurface(stage, "/World/Look", "ND_mix_surfaceshader", bg=back, fg=front, mix=0.5)
    first, second = (_Picture(tmp_path, lambda stage: AddSurface(stage, "/World/Look", SHEENS[name][0], **SHEENS[name][1]), DOME,
                              samples=256).rgb.mean((0, 1)) for name in (one, other))
    mixed = _Picture(tmp_path, Mixed, DOME, samples=512).rgb.mean((0, 1))
    assert mixed == pytest.approx(0.5 * (first + second), rel=3e-3)


def test_albedo_is_the_mean_of_what_is_chosen(tmp_path):
    surface = _Surface(lambda c: c.Mix(c.Diffuse(RED, roughness=0.5), c.Diffuse(BLUE), 0.25))
    albedo = _Picture(tmp_path, surface, samples=1, aovs=("color", "albedo")).layers["albedo"][16, 16, :3]
    assert albedo == pytest.approx(0.75 * np.array(RED) + 0.25 * np.array(BLUE), abs=0.02)


def test_bits_do_not_depend_on_pools_and_waves(tmp_path):
    surface = _Surface(CHOSEN["mixOfMixes"][0])
    streams = dict(residency="stream", chunkBytes=1 << 14, geometryMemory="30%")
    whole, streamed, small = (_Picture(tmp_path, surface, samples=8, **settings).rgb
                              for settings in (dict(residency="resident"), streams, dict(residency="resident", waveSize=1024)))
    assert np.array_equal(whole, streamed) and np.array_equal(whole, small)


def _Schlick(color0, color90, exponent, cosine):
    return np.array(color0) + (np.array(color90) - np.array(color0)) * (1 - cosine) ** exponent


def _Cone(inner, outer, cosine):
    inner, outer = np.cos(np.radians(inner) / 2), np.cos(np.radians(outer) / 2)
    if outer >= inner:
        return (cosine >= inner) * 1.0
    x = np.clip((cosine - outer) / (inner - outer), 0, 1)
    return x * x * (3 - 2 * x)


# A surface that emits, and its radiance towards a viewer whose direction has that cosine with the normal.
EDFS = {
    "schlick": (_Surface(None, lambda c: c("generalized_schlick_edf", base=c("uniform_edf", color=GOLD), color0=(0.9, 0.5, 0.1),
                                           color90=(0.1, 0.8, 0.0), exponent=3.0)),
                lambda cosine: np.array(GOLD) * _Schlick((0.9, 0.5, 0.1), (0.1, 0.8, 0.0), 3.0, abs(cosine))),
    "cone": (_Surface(None, lambda c: c("conical_edf", color=GOLD, inner_angle=50.0, outer_angle=140.0)),
             lambda cosine: np.array(GOLD) * _Cone(50.0, 140.0, cosine)),
    "hardCone": (_Surface(None, lambda c: c("conical_edf", color=GOLD, inner_angle=100.0)),
                 lambda cosine: np.array(GOLD) * _Cone(100.0, 0.0, cosine)),
    "coatOfStandardSurface": (_Standard(base=0.0, specular=0.0, emission=2.0, emission_color=GOLD, coat=0.8, coat_IOR=1.8,
                                        coat_color=RED),
                              lambda cosine: 2.0 * np.array(GOLD) * (0.2 + 0.8 * np.array(RED) * (
                                  1 - (0.8 / 2.8) ** 2) * (1 - (1 - abs(cosine)) ** 5))),
    "coatOfOpenPbr": (_OpenPbr(base_weight=0.0, specular_weight=0.0, emission_luminance=2.0, emission_color=GOLD, coat_weight=1.0,
                               coat_ior=1.6, coat_color=RED),
                      lambda cosine: 2.0 * np.array(GOLD) * np.array(RED) * (1 - (0.6 / 2.6) ** 2) * (1 - (1 - abs(cosine)) ** 5)),
}


@pytest.mark.parametrize("name", EDFS)
def test_what_is_emitted_depends_on_the_viewer(tmp_path, name):
    surface, radiance = EDFS[name]
    dark = [("Distant", dict(intensity=0.0))]
    for degrees in (0, 20, 45, 75, 120):
        seen = _Picture(tmp_path, surface, dark, samples=1, size=8, shape=shapes.Plane(4, 4), degrees=degrees,
                        maxDepth=0).rgb[4, 4]
        assert seen == pytest.approx(radiance(np.cos(np.radians(degrees))), abs=1e-5), degrees


@pytest.mark.parametrize("name", ["schlick", "cone"])
def test_light_samples_see_what_is_emitted_towards_them(tmp_path, name):
    """The irradiance of a floor below a panel, by the panel's radiance in the direction of each point, summed."""
    surface, radiance = EDFS[name]
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    white = author.AddMaterial(stage, "/World/White", diffuseColor=(1, 1, 1), specularColor=(0, 0, 0), useSpecularWorkflow=1)
    author.AddMesh(stage, "/World/Floor", shapes.Plane(6, 6), material=white)
    author.AddMesh(stage, "/World/Panel", shapes.Plane(1, 1), material=surface(stage), doubleSided=True, translate=(0, 1.5, 0),
                   rotate=(180, 0, 0))
    author.AddCamera(stage, eye=(2, 1, 0), target=(2, 0, 0), up=(0, 0, 1), width=10, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, 8, 8, samples=1024, maxDepth=1, pixelFilter="box", pixelFilterWidth=1.0).rgb
    points = (np.arange(64) + 0.5) / 64 - 0.5
    px, pz = np.meshgrid(points, points)
    pixels = (np.arange(64) + 0.5) / 64 - 0.5  # of the picture's width, which is 1
    fx, fz = np.meshgrid(pixels + 2.0, pixels)
    dx, dz = fx[..., None] - px.reshape(-1), fz[..., None] - pz.reshape(-1)
    squares = dx * dx + dz * dz + 1.5 ** 2
    cosine = 1.5 / np.sqrt(squares)
    expected = np.stack([(radiance(cosine[..., None])[..., c] * cosine ** 2 / squares).mean(-1) / np.pi for c in range(3)], -1)
    expected = expected.reshape(8, 8, 8, 8, 3).mean((1, 3))
    assert picture.mean((0, 1)) == pytest.approx(expected.mean((0, 1)), rel=0.005)


def test_what_is_not_supported_is_said(tmp_path):
    surface = _Surface(lambda c: c.Mix(c.Diffuse(), c("ours_bsdf"), 0.5), lambda c: c("measured_edf", color=BLUE))
    warnings = " ".join(_Picture(tmp_path, surface, samples=1, size=8).warnings)
    assert "ND_ours_bsdf" in warnings and "emits alike in all directions" in warnings


GRAPHS = {
    STANDARD: [dict(base=1.0, base_color=RED, specular_roughness=0.4),
               dict(base=1.0, base_color=GOLD, metalness=0.5, specular_roughness=0.4),
               dict(base=1.0, base_color=GOLD, metalness=1.0, specular_roughness=0.4, specular_anisotropy=0.5),
               dict(base=1.0, base_color=RED, transmission=0.5, specular_roughness=0.3),
               dict(base=1.0, base_color=RED, coat=0.7, coat_roughness=0.2, coat_anisotropy=0.6, specular_roughness=0.5),
               dict(base=1.0, base_color=RED, sheen=1.0, sheen_roughness=0.4, specular=0.5),
               dict(base=0.5, emission=1.0, emission_color=(0.1, 0.2, 0.3)),
               dict(base=0.5, emission=1.0, emission_color=(0.1, 0.2, 0.3), coat=0.8, coat_color=BLUE),
               dict(base=1.0, base_color=RED, subsurface=0.5, subsurface_color=GOLD, subsurface_radius=(0.2, 0.1, 0.05)),
               dict(base=1.0, base_color=GOLD, metalness=1.0, coat=1.0, coat_color=BLUE, specular_roughness=0.4)],
    OPEN_PBR: [dict(base_color=RED, specular_roughness=0.4), dict(base_color=GOLD, base_metalness=1.0, specular_roughness=0.4),
               dict(base_color=RED, coat_weight=0.7, coat_roughness=0.2, coat_roughness_anisotropy=0.6),
               dict(base_color=RED, fuzz_weight=0.8),
               dict(base_weight=0.6, base_color=GOLD, subsurface_weight=0.5, subsurface_color=BLUE, coat_weight=1.0, coat_ior=1.8),
               dict(base_weight=0.6, base_color=GOLD, base_metalness=1.0, specular_weight=0.5, coat_weight=1.0, coat_ior=1.8),
               dict(transmission_weight=1.0, specular_roughness=0.3),
               dict(transmission_weight=0.7, transmission_color=(0.8, 0.4, 0.1), transmission_depth=1.0,
                    transmission_scatter=(0.6, 0.6, 0.6), transmission_scatter_anisotropy=0.5)],
    DISNEY: [dict(baseColor=RED, roughness=0.4, specularTint=0.5), dict(baseColor=GOLD, metallic=0.5, roughness=0.4, anisotropic=0.3),
             dict(baseColor=RED, clearcoat=1.0, clearcoatGloss=0.8, sheen=0.5), dict(baseColor=RED, specTrans=0.5, ior=1.3),
             dict(baseColor=RED, subsurface=0.5, subsurfaceDistance=(0.2, 0.1, 0.05), specular=1.0)],
    GLTF: [dict(base_color=RED, metallic=0.0, roughness=0.4), dict(base_color=GOLD, metallic=0.5, roughness=0.4),
           dict(base_color=GOLD, metallic=0.5, roughness=0.4, anisotropy_strength=0.7),
           dict(base_color=GOLD, metallic=1.0, roughness=0.4, sheen_color=(0.8, 0.4, 0.2), sheen_roughness=0.6),
           dict(base_color=RED, metallic=0.5, roughness=0.4, sheen_color=(0.3, 0.1, 0.2), sheen_roughness=0.8, clearcoat=0.8),
           dict(base_color=RED, metallic=0.0, roughness=0.4, ior=1.9, specular=0.7, specular_color=BLUE),
           dict(base_color=GRAY, metallic=0.0, roughness=0.4, ior=1.9, specular=0.4, iridescence=1.0, iridescence_ior=1.6,
                iridescence_thickness=400.0)],
}


def _GraphLayer(identifier, inputs):
    """A layer with a material whose surface is MaterialX's own node graph of a surface shader, down to nodes without graphs."""
    materialX = pytest.importorskip("MaterialX")
    from stages import surfaceGraphs
    document = surfaceGraphs.NewDocument()
    surface = document.addNode(document.getNodeDef(identifier).getNodeString(), "Surface", "surfaceshader")
    for name, value in inputs.items():
        surface.setInputValue(name, materialX.Color3(*value) if isinstance(value, tuple) else float(value))
    document.addMaterialNode("Look", surface)
    document.flattenSubgraphs()
    assert not document.getNode("Surface") and any(node.getType() == "BSDF" for node in document.getNodes())
    return surfaceGraphs.ReadLayer(document)


@pytest.mark.parametrize("identifier, index", [(key, index) for key, rows in GRAPHS.items() for index in range(len(rows))])
def test_node_graphs_of_surfaces_look_like_the_built_in_ones(tmp_path, identifier, index):
    inputs = GRAPHS[identifier][index]
    layer = _GraphLayer(identifier, inputs)

    def Graph(stage):
        from stages import surfaceGraphs
        return surfaceGraphs.CopyMaterial(layer, "Look", stage, "/World/Look")
    graph = _Picture(tmp_path, Graph)
    builtIn = _Picture(tmp_path, lambda stage: AddSurface(stage, "/World/Look", identifier, **inputs))
    assert not graph.warnings
    blocks = [picture.rgb.reshape(4, 8, 4, 8, 3).mean((1, 3)) for picture in (graph, builtIn)]
    assert blocks[0] == pytest.approx(blocks[1], rel=0.02)


def _VaryingGlass():
    """Layers with glass whose roughness is a ramp: by its surface shader, and by that shader's node graph."""
    pytest.importorskip("MaterialX")
    from stages import surfaceGraphs
    document = surfaceGraphs.NewDocument()
    ramp = document.addNode("ramplr", "Ramp", "float")
    surface = document.addNode("standard_surface", "Surface", "surfaceshader")
    for node, inputs in ((ramp, dict(valuel=0.1, valuer=0.7)), (surface, dict(base=0.0, transmission=1.0))):
        for name, value in inputs.items():
            node.setInputValue(name, value)
    surface.addInput("specular_roughness", "float").setConnectedNode(ramp)
    document.addMaterialNode("Look", surface)
    builtIn = surfaceGraphs.ReadLayer(document)
    surfaceGraphs.ReplaceSurfaces(document)
    assert not document.getNode("Surface") and document.getNode("Ramp")
    return builtIn, surfaceGraphs.ReadLayer(document)


def test_glass_of_varying_roughness_is_one_surface_in_its_node_graph(tmp_path):
    """Its reflection and its refraction have roughnesses of their own, of which one is clamped."""
    from stages import surfaceGraphs
    ball = Ball(1.0)  # it has coordinates, over which the roughness varies
    pictures = [_Picture(tmp_path, lambda stage: surfaceGraphs.CopyMaterial(layer, "Look", stage, "/World/Look"), maxDepth=12, shape=ball)
                for layer in _VaryingGlass()]
    assert not any(picture.warnings for picture in pictures)
    blocks = [picture.rgb.reshape(4, 8, 4, 8, 3).mean((1, 3)) for picture in pictures]
    assert blocks[1] == pytest.approx(blocks[0], rel=2e-3)  # the same paths but for rounding; of a coat others
