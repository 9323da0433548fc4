# SPDX-License-Identifier: Apache-2.0
"""Reflections and sheens on each other, whatever their number, colours, films and normals, and closures that send light back."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Gf, Sdf, UsdShade
from stages import author, shapes
from stages.materialX import AddNode, AddSurface, Ball

RED, WHITE, TINT = (0.7, 0.1, 0.08), (1.0, 1.0, 1.0), (0.9, 0.5, 0.2)
DOME = (("Dome", {}),)
SMOOTH = dict(roughness=(0.0, 0.0))


def _Sun(degrees):
    return (("Distant", dict(angle=0.0, intensity=1.0, placement=dict(rotate=(degrees, 0, 0)))),)


def _Map(stage, name, normal):
    """A map of one normal, in texels: a constant has no frame."""
    texel = Gf.Vec3f(*(0.5 * np.asarray(normal) / np.linalg.norm(normal) + 0.5))
    vector = Sdf.ValueTypeNames.Vector3f
    texels = AddNode(stage, f"/World/Look/{name}Texels", "ND_splitlr_vector3", vector, valuel=texel, valuer=texel, center=0.5)
    return AddNode(stage, f"/World/Look/{name}Map", "ND_normalmap", vector, **{"in": texels})


class Stage:
    """Closures below a material; layers are (kind, inputs), those after it below each."""

    def __init__(self, stage):
        self._stage, self._count = stage, 0

    def Node(self, kind, **inputs):
        self._count += 1
        name = f"Node{self._count}"
        if "normal" in inputs:
            inputs["normal"] = _Map(self._stage, name, inputs["normal"])
        return AddNode(self._stage, f"/World/Look/{name}", f"ND_{kind}", Sdf.ValueTypeNames.Token, **inputs)

    def Split(self, value):
        """A number or a colour that is the same on both sides of a line."""
        self._count += 1
        kind, output = ("color3", Sdf.ValueTypeNames.Color3f) if isinstance(value, tuple) else ("float", Sdf.ValueTypeNames.Float)
        return AddNode(self._stage, f"/World/Look/Split{self._count}", f"ND_splitlr_{kind}", output, valuel=value, valuer=value)

    def Stack(self, *layers):
        below = None
        for layer in reversed(layers):
            node = layer(self) if callable(layer) else self.Node(f"{layer[0]}_bsdf", **layer[1])
            below = node if below is None else self.Node("layer_bsdf", top=node, base=below)
        return below


def _Render(tmp_path, make, lights, samples=256, size=8, degrees=0, shape=None, maxDepth=1, surface=None, isTilted=False, warnings=None,
            **settings):
    """make: a closure of a Stage. A plane, by its angle to the viewer, unless a shape is given that is not tilted so. `warnings` takes what is told,
    which is nothing otherwise."""
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    UsdShade.Material.Define(stage, "/World/Look")
    material = AddSurface(stage, "/World/Look", "ND_surface", bsdf=make(Stage(stage)), **(surface or {}))
    rotate = (90 + degrees, 0, 0) if shape is None or isTilted else (0, 0, 0)
    author.AddMesh(stage, "/World/Shape", shape or shapes.Plane(60, 60), material=material, doubleSided=True, rotate=rotate)
    for index, (kind, inputs) in enumerate(lights):
        author.AddLight(stage, f"/World/Light{index}", kind, **inputs)
    author.AddCamera(stage, eye=(0, 0, 10), width=2.4, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    picture = ours.Render(stage.GetRootLayer().realPath, size, size, samples=samples, maxDepth=maxDepth, **settings)
    if warnings is None:
        assert picture.warnings == []
    else:
        warnings += picture.warnings
    return picture.rgb


def _Color(*arguments, **settings):
    return _Render(*arguments, **settings).mean((0, 1))


def _Stack(*layers):
    return lambda stage: stage.Stack(*layers)


DIFFUSE = ("oren_nayar_diffuse", dict(color=RED))
GRAY = ("oren_nayar_diffuse", dict(color=(0.5, 0.5, 0.5)))
PLAIN = ("dielectric", dict(roughness=(0.2, 0.2)))
DENSE = ("dielectric", dict(roughness=(0.3, 0.3), ior=2.2))
TINTED = ("dielectric", dict(roughness=(0.25, 0.25), ior=1.8, tint=TINT))
FILMED = ("dielectric", dict(roughness=(0.3, 0.3), ior=1.6, thinfilm_thickness=380.0, thinfilm_ior=1.9))
SCHLICK = ("generalized_schlick", dict(roughness=(0.3, 0.3), color0=(0.1, 0.4, 0.7), color90=(1.0, 0.8, 0.9), exponent=3.0))
GOLD = ("generalized_schlick", dict(roughness=(0.3, 0.3), color0=(0.9, 0.6, 0.2)))
BACK = ("dielectric", dict(roughness=(0.3, 0.3), ior=2.0, retroreflective=True))
SHEEN = ("sheen", dict(roughness=0.5, color=TINT))
FUZZ = ("sheen", dict(roughness=0.4, mode="zeltner"))
TURNED = dict(normal=(0.4, 0.2, 0.8))
METAL = ("conductor", dict(roughness=(0.3, 0.3)))
HAIR = ("chiang_hair", dict(absorption_coefficient=Gf.Vec3f(0.3, 0.6, 0.9)))

STACKS = {
    "threeReflections": (PLAIN, DENSE, PLAIN, DIFFUSE),
    "tinted": (TINTED, PLAIN, DIFFUSE),
    "filmed": (FILMED, DENSE, DIFFUSE),
    "schlicksOnDielectric": (SCHLICK, PLAIN, DIFFUSE),
    "goldOnPlastic": (GOLD, PLAIN, DIFFUSE),
    "sentBackOnPlastic": (BACK, PLAIN, DIFFUSE),
    "sheenOnPlastic": (SHEEN, PLAIN, DIFFUSE),
    "sheenOnMetal": (SHEEN, METAL),
    "sheenOnFuzz": (SHEEN, FUZZ, DIFFUSE),
    "fuzzOnSheen": (FUZZ, SHEEN, PLAIN, DIFFUSE),
    "reflectionOnFuzz": (PLAIN, FUZZ, DIFFUSE),
    "turnedSheen": (("sheen", dict(SHEEN[1], **TURNED)), DIFFUSE),
    "turnedFilm": (("dielectric", dict(FILMED[1], **TURNED)), DIFFUSE),
    "sheenOnTurned": (SHEEN, ("oren_nayar_diffuse", dict(color=RED, **TURNED))),
    "reflectionOnHair": (PLAIN, HAIR),
}


@pytest.mark.parametrize("degrees", [20, 65])
@pytest.mark.parametrize("name", STACKS)
def test_layers_take_what_they_reflect(tmp_path, name, degrees):
    """A stack in the sun is the sum of its layers alone, each times what each layer above it leaves of a gray base."""
    layers = STACKS[name]
    sun = _Sun(degrees - 40)
    gray = _Color(tmp_path, _Stack(GRAY), sun, 4, degrees=degrees)
    left, expected = np.ones(3), np.zeros(3)
    for layer in layers:
        alone = _Color(tmp_path, _Stack(layer), sun, 64, degrees=degrees)
        expected += left * alone
        if layer is not layers[-1]:
            on = _Color(tmp_path, _Stack(layer, GRAY), sun, 1024, degrees=degrees)
            left = left * (on - alone) / gray
    seen = _Color(tmp_path, _Stack(*layers), sun, 4096, degrees=degrees)
    assert seen == pytest.approx(expected, rel=0.012, abs=1e-4)


@pytest.mark.parametrize("degrees", [0, 60, 75])
def test_smooth_reflections_on_each_other_have_a_closed_form(tmp_path, degrees):
    """Four of them, one with a tint and one of a metal, under a sky: mirrors over a diffuse base."""
    cosine = np.cos(np.radians(degrees))

    def Fresnel(index):
        within = np.sqrt(1 - (1 - cosine ** 2) / index ** 2)
        s, p = (cosine - index * within) / (cosine + index * within), (within - index * cosine) / (within + index * cosine)
        return 0.5 * (s * s + p * p)
    f0 = np.array((0.3, 0.6, 0.8))
    layers = [(("dielectric", dict(ior=1.5, tint=TINT, **SMOOTH)), Fresnel(1.5), np.array(TINT)),
              (("generalized_schlick", dict(color0=tuple(f0), **SMOOTH)), f0 + (1 - f0) * (1 - cosine) ** 5, 1.0),
              (("dielectric", dict(ior=1.9, **SMOOTH)), Fresnel(1.9), 1.0), (("dielectric", dict(ior=1.3, **SMOOTH)), Fresnel(1.3), 1.0)]
    left, expected = np.ones(3), np.zeros(3)
    for _, reflected, tint in layers:
        expected = expected + left * reflected * tint
        left = left * (1 - reflected)
    expected = expected + left * np.array(RED)
    seen = _Color(tmp_path, _Stack(*(layer for layer, _, _ in layers), DIFFUSE), DOME, 4096, degrees=degrees, maxDepth=2)
    assert seen == pytest.approx(expected, abs=6e-3)


@pytest.mark.parametrize("name", ["threeReflections", "filmed", "sentBackOnPlastic", "sheenOnPlastic", "reflectionOnFuzz"])
def test_stacks_that_absorb_nothing_are_invisible_in_a_furnace(tmp_path, name):
    layers = [(kind, {key: value for key, value in inputs.items() if kind != "sheen" or key != "color"})
              for kind, inputs in STACKS[name][:-1]]
    white = ("oren_nayar_diffuse", dict(color=WHITE))
    color = _Render(tmp_path, _Stack(*layers, white), DOME, 256, 16, shape=shapes.Sphere(1.0, 48, 96), maxDepth=24).mean((0, 1))
    assert color == pytest.approx(np.ones(3), abs=0.02)


def test_what_lies_on_a_sum_lies_on_all_of_it(tmp_path):
    """A coat over a metal that is added to plastic: neither is dimmed twice, and the coat counts once."""
    def Sum(stage):
        return stage.Node("add_bsdf", in1=stage.Node("multiply_bsdfF", in1=stage.Stack(METAL), in2=0.25), in2=stage.Stack(TINTED, DIFFUSE))
    parts = {}
    for name, layers in dict(coat=(PLAIN,), metal=(METAL,), plastic=(TINTED, DIFFUSE), onGray=(PLAIN, GRAY), gray=(GRAY,),
                             whole=(PLAIN, Sum)).items():
        parts[name] = _Color(tmp_path, _Stack(*layers), _Sun(-10), 1024, degrees=30)
    left = (parts["onGray"] - parts["coat"]) / parts["gray"]
    assert parts["whole"] == pytest.approx(parts["coat"] + left * (0.25 * parts["metal"] + parts["plastic"]), rel=0.01)


@pytest.mark.parametrize("below", [DIFFUSE, METAL], ids=["diffuse", "metal"])
def test_layers_of_layers_are_layers(tmp_path, below):
    """((a on b) on c) is (a on (b on c))."""
    def Grouped(stage):
        return stage.Node("layer_bsdf", top=stage.Stack(SHEEN, FILMED, TINTED), base=stage.Stack(below))
    grouped, flat = (_Color(tmp_path, make, _Sun(-10), 4096, degrees=30) for make in (Grouped, _Stack(SHEEN, FILMED, TINTED, below)))
    assert grouped == pytest.approx(flat, rel=0.01)


def _Mirrors(number):
    return [("dielectric", dict(ior=1.1 + 0.8 / number * index, tint=TINT, **SMOOTH)) for index in range(number)]


def _Varying(kind, inputs):
    """The layer with an index and a tint that may vary for all that a program knows."""
    return lambda stage: stage.Node(f"{kind}_bsdf", **inputs | dict(ior=stage.Split(inputs["ior"]), tint=stage.Split(inputs["tint"])))


@pytest.mark.parametrize("number, varies", [(6, False), (31, False), (6, True), (20, True)])
def test_each_of_many_mirrors_takes_its_part(tmp_path, number, varies):
    """Along the normal each reflects what its index says, times the tint, whatever their number and whether they vary."""
    left, expected = 1.0, np.zeros(3)
    for _, inputs in _Mirrors(number):
        reflected = ((inputs["ior"] - 1) / (inputs["ior"] + 1)) ** 2
        expected = expected + left * reflected * np.array(TINT)
        left *= 1 - reflected
    layers = [_Varying(*layer) for layer in _Mirrors(number)] if varies else _Mirrors(number)
    seen = _Color(tmp_path, _Stack(*layers, GRAY), DOME, 4096, 16, maxDepth=2)
    assert seen == pytest.approx(expected + 0.5 * left, abs=8e-3)


def test_too_many_mirrors_are_told_once(tmp_path):
    """One line names the closure from which on they are left out."""
    warnings = []
    _Render(tmp_path, _Stack(*_Mirrors(40), GRAY), DOME, 1, warnings=warnings)
    assert len(warnings) == 1 and warnings[0].startswith("/World/Look: ") and "only the first 32 of its 33 closures" in warnings[0]


def test_layers_of_layers_cover_what_is_beside_a_metal(tmp_path):
    """Sheen on half a metal, on diffuse: the sheen covers both halves."""
    half = ("conductor", dict(METAL[1], weight=0.5))

    def Grouped(stage):
        return stage.Node("layer_bsdf", top=stage.Stack(SHEEN, half), base=stage.Stack(DIFFUSE))
    grouped, flat = (_Color(tmp_path, make, _Sun(-10), 4096, degrees=30) for make in (Grouped, _Stack(SHEEN, half, DIFFUSE)))
    assert grouped == pytest.approx(flat, rel=0.01)


@pytest.mark.parametrize("mode", ["T", "RT"])
def test_layers_of_layers_on_glass_are_not_met_from_inside(tmp_path, mode):
    """A ball of glass below two tinted reflections in a furnace: as grouped either way, and never brighter than it."""
    tops = [("dielectric", dict(roughness=(0.25, 0.25), ior=ior, tint=TINT)) for ior in (1.8, 2.4)]
    glass = ("dielectric", dict(ior=1.5, scatter_mode=mode, **SMOOTH))

    def Grouped(stage):
        return stage.Node("layer_bsdf", top=stage.Stack(*tops), base=stage.Stack(glass))
    grouped, flat = (_Render(tmp_path, make, DOME, 1024, 16, shape=shapes.Sphere(1.0, 48, 96), maxDepth=24).mean((0, 1))
                     for make in (Grouped, _Stack(*tops, glass)))
    assert grouped.max() <= 1.001
    assert grouped == pytest.approx(flat, rel=0.01)


GLASS = ("dielectric", dict(ior=1.5, scatter_mode="T", **SMOOTH))
ON_GLASS = (TINTED, ("dielectric", dict(roughness=(0.3, 0.3), ior=2.2)), GLASS)


def test_what_lies_on_glass_is_there_whatever_its_normals_say(tmp_path):
    """Normals that point to the other side of the mesh than its winding are those of the side that is seen."""
    plane = shapes.Plane(60, 60)
    turned = shapes.Shape(plane.points, plane.counts, plane.indices, -plane.normals, plane.texcoords)
    seen, expected = (_Render(tmp_path, _Stack(*ON_GLASS), DOME, 256, degrees=30, shape=shape, isTilted=True)
                      for shape in (turned, plane))
    assert np.array_equal(seen, expected)


def test_thin_walls_of_layers_have_two_sides_alike(tmp_path):
    front, back = (_Color(tmp_path, _Stack(*ON_GLASS), DOME, 4096, degrees=degrees, maxDepth=4, surface=dict(thin_walled=True))
                   for degrees in (60, 240))
    assert front[0] > front[2] + 0.05 and back == pytest.approx(front, rel=0.01)


def test_what_is_nowhere_glass_is_covered_from_behind(tmp_path):
    """A mixture of glass and diffuse reflection, all of which is the latter by a pattern, is that alone from both sides."""
    def Mixture(stage):
        none = AddNode(stage._stage, "/World/Look/None", "ND_splitlr_float", Sdf.ValueTypeNames.Float, valuel=0.0, valuer=0.0, center=0.5)
        white = stage.Stack(("oren_nayar_diffuse", dict(color=WHITE)))
        return stage.Node("mix_bsdf", fg=stage.Stack(GLASS), bg=white, mix=none)
    seen, expected = (_Color(tmp_path, _Stack(*ON_GLASS[:2], below), _Sun(-10), 4096, degrees=210)
                      for below in (Mixture, ("oren_nayar_diffuse", dict(color=WHITE))))
    assert seen == pytest.approx(expected, rel=0.01)


def test_what_is_opaque_hides_all_that_it_lies_on(tmp_path):
    """Two metals mixed, on layers on glass: nothing of these is left, but that shares ask which side is seen."""
    def Metals(stage):
        rough = (METAL[0], {**METAL[1], "roughness": (0.5, 0.5)})
        return stage.Node("mix_bsdf", fg=stage.Stack(METAL), bg=stage.Stack(rough), mix=0.5)

    def OnGlass(stage):
        return stage.Node("layer_bsdf", top=Metals(stage), base=stage.Stack(*ON_GLASS))
    seen, expected = (_Render(tmp_path, make, DOME, 64, degrees=30) for make in (OnGlass, Metals))
    assert np.array_equal(seen, expected)


def test_many_closures_are_mixed(tmp_path):
    """Twelve that no layered surface has side by side."""
    def Part(index):
        return ("generalized_schlick", dict(color0=(0.05 * index, 0.5, 1 - 0.05 * index), roughness=(0.1 + 0.05 * index,) * 2))

    def Mix(stage):
        mixed = stage.Stack(Part(0))
        for index in range(1, 12):
            mixed = stage.Node("mix_bsdf", bg=mixed, fg=stage.Stack(Part(index)), mix=1 / (index + 1))
        return mixed
    sun = _Sun(-20)
    expected = np.mean([_Color(tmp_path, _Stack(Part(index)), sun, 4, degrees=30) for index in range(12)], 0)
    assert _Color(tmp_path, Mix, sun, 4096, degrees=30) == pytest.approx(expected, rel=0.01)


def test_a_layer_over_absorbing_glass_leaves_the_way_inside_alone(tmp_path):
    """A ball of index 1 that absorbs, below a film that is almost not there."""
    def Glass(stage):
        glass = stage.Node("dielectric_bsdf", ior=1.0, scatter_mode="RT", **SMOOTH)
        absorption, _ = AddNode(stage._stage, "/World/Look/Inside", "ND_absorption_vdf", Sdf.ValueTypeNames.Token)
        absorption.CreateInput("absorption", Sdf.ValueTypeNames.Vector3f).Set(Gf.Vec3f(0.7, 0.3, 0.0))
        return stage.Node("layer_vdf", top=glass, base=(absorption, "out"))

    def Covered(stage):
        return stage.Stack(("dielectric", dict(ior=1.001, tint=TINT, **SMOOTH)), Glass)
    color = _Render(tmp_path, Covered, DOME, 1024, 16, shape=shapes.Sphere(1.0, 96, 192), maxDepth=8)[7:9, 7:9].mean((0, 1))
    assert color == pytest.approx(np.exp(-2 * np.array((0.7, 0.3, 0.0))), rel=0.02)


@pytest.mark.parametrize("name", ["threeReflections", "goldOnPlastic", "fuzzOnSheen", "reflectionOnHair"])
def test_bits_do_not_depend_on_pools_and_waves(tmp_path, name):
    streams = dict(residency="stream", chunkBytes=1 << 14, geometryMemory="30%")
    whole, streamed, small = (_Render(tmp_path, _Stack(*STACKS[name]), DOME, 8, 16, shape=Ball(1.0), **settings)
                              for settings in (dict(residency="resident"), streams, dict(residency="resident", waveSize=1024)))
    assert np.array_equal(whole, streamed) and np.array_equal(whole, small)


MIRRORED = {  # {closure: its inputs}
    "dielectric": dict(ior=1.8), "conductor": {}, "generalized_schlick": dict(color0=(0.3, 0.5, 0.9), color90=TINT, exponent=2.0),
    "metal": dict(color0=(0.9, 0.6, 0.2)),
}


@pytest.mark.parametrize("degrees", [20, 60])
@pytest.mark.parametrize("sun", [-60, -25, 10])
@pytest.mark.parametrize("name", MIRRORED)
def test_what_sends_light_back_mirrors_its_reflection(tmp_path, name, sun, degrees):
    """By its definition it is a reflection of the viewer's mirror image: that of a sun on the other side of the normal."""
    kind = "generalized_schlick" if name == "metal" else name
    inputs = dict(MIRRORED[name], roughness=(0.3, 0.15))
    back = _Color(tmp_path, _Stack((kind, dict(inputs, retroreflective=True))), _Sun(sun + degrees), 4, degrees=degrees)
    plain = _Color(tmp_path, _Stack((kind, inputs)), _Sun(degrees - sun), 4, degrees=degrees)
    other = _Color(tmp_path, _Stack((kind, inputs)), _Sun(sun + degrees), 4, degrees=degrees)
    assert abs(back - other).max() > 0.05 * other.max()
    assert back == pytest.approx(plain, rel=1e-3)


def test_a_closure_sends_light_back_by_the_formula(tmp_path):
    """Walter's reflection of a white metal, with Turquin's factor, where V is mirrored as MaterialX's text does."""
    alpha, tilt, sun = 0.16, np.radians(50), np.radians(35)  # of the viewer and of the sun, on one side of the normal
    color = _Color(tmp_path, _Stack(("generalized_schlick", dict(color0=WHITE, roughness=(alpha, alpha), retroreflective=True))),
                   _Sun(15), 4, degrees=50)
    v = np.array((-np.sin(tilt), 0, np.cos(tilt)))
    normal = np.array((0.0, 0.0, 1.0))
    mirrored = 2 * np.dot(normal, v) * normal - v  # reflect(-V, N)

    def Value(wo, wi):
        h = (wo + wi) / np.linalg.norm(wo + wi, axis=-1, keepdims=True)
        tan2 = lambda w: 1.0 / w[..., 2] ** 2 - 1.0  # noqa: E731
        distribution = alpha ** 2 / (np.pi * h[..., 2] ** 4 * (alpha ** 2 + tan2(h)) ** 2)
        smith = lambda w: 0.5 * (np.sqrt(1.0 + alpha ** 2 * tan2(w)) - 1.0)  # noqa: E731
        return distribution / (4.0 * wo[..., 2] * (1.0 + smith(wo) + smith(wi)))
    theta, phi = np.meshgrid((np.arange(800) + 0.5) / 800 * np.pi / 2, (np.arange(800) + 0.5) / 800 * 2 * np.pi, indexing="ij")
    around = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    kept = (Value(mirrored, around) * np.sin(theta)).sum() * np.pi ** 2 / 800 ** 2
    expected = Value(mirrored, np.array((-np.sin(sun), 0, np.cos(sun)))) / kept
    assert color == pytest.approx(np.full(3, expected), rel=0.015)
