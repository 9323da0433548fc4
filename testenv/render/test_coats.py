# SPDX-License-Identifier: Apache-2.0
"""Reflections that lie on other surfaces: coats with normals and stretches of their own, and generalised Schlick terms."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Gf, Sdf, UsdShade
from stages import author, shapes
from stages.materialX import OPEN_PBR, STANDARD, AddNode, AddSurface, Ball

GLTF = "ND_gltf_pbr_surfaceshader"
RED = (0.7, 0.1, 0.08)
LAMP = (("Sphere", dict(placement=dict(translate=(3, 3, 3)), intensity=20.0)),)
DOME = (("Dome", {}),)
# Of each model: what makes a coat alone, the normals of the surface and of the coat.
MODELS = {
    STANDARD: (dict(base=0.0, specular=0.0, coat=1.0, coat_roughness=0.3), "normal", "coat_normal"),
    OPEN_PBR: (dict(base_weight=0.0, base_metalness=1.0, specular_weight=0.0, coat_weight=1.0, coat_roughness=0.3),
               "geometry_normal", "geometry_coat_normal"),
    GLTF: (dict(base_color=(0.0, 0.0, 0.0), specular=0.0, metallic=0.0, clearcoat=1.0, clearcoat_roughness=0.3), "normal",
           "clearcoat_normal"),
}
TILTED = Gf.Vec3f(0.5, 0.3, np.sqrt(1 - 0.25 - 0.09))  # in tangent space


def _Map(stage, right=TILTED):
    """A normal map from TILTED to another normal."""
    left, right = (Gf.Vec3f(*(0.5 * x + 0.5 for x in normal)) for normal in (TILTED, right))
    vector = Sdf.ValueTypeNames.Vector3f
    ramp = AddNode(stage, "/World/Look/Ramp", "ND_ramplr_vector3", vector, valuel=left, valuer=right)
    return AddNode(stage, "/World/Look/Map", "ND_normalmap", vector, **{"in": ramp})


def _Render(tmp_path, addMaterial, lights=LAMP, samples=64, size=32, shape=None, degrees=0, **settings):
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    rotate = (0, 0, 0) if shape is None else (90 + degrees, 0, 0)  # a plane, by its angle to the viewer
    author.AddMesh(stage, "/World/Shape", shape or Ball(1.0), material=addMaterial(stage), doubleSided=True, rotate=rotate)
    for index, (kind, inputs) in enumerate(lights):
        author.AddLight(stage, f"/World/Light{index}", kind, **inputs)
    author.AddCamera(stage, eye=(0, 0, 10), width=2.4, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return ours.Render(stage.GetRootLayer().realPath, size, size, samples=samples, **settings)


def _Picture(*arguments, **settings):
    picture = _Render(*arguments, **settings)
    assert picture.warnings == []
    return picture.rgb


def _Blocks(picture):
    return picture.reshape(4, 8, 4, 8, 3).mean((1, 3))


@pytest.mark.parametrize("identifier", MODELS)
def test_a_coat_has_its_own_normal(tmp_path, identifier):
    inputs, surfaces, coats = MODELS[identifier]

    def Look(*mapped):
        def Add(stage):
            UsdShade.Material.Define(stage, "/World/Look")
            node = _Map(stage, Gf.Vec3f(-0.2, 0.4, 0.9))
            return AddSurface(stage, "/World/Look", identifier, **inputs, **dict.fromkeys(mapped, node))
        return _Blocks(_Picture(tmp_path, Add, samples=256, maxDepth=1))

    plain, tilted = Look(), Look(surfaces, coats)
    assert abs(plain - tilted).mean() > 0.2 * plain.mean()
    # Nothing but the coat reflects, so the normal of the rest does not show.
    assert Look(surfaces) == pytest.approx(plain, rel=5e-3, abs=2e-3 * plain.mean())
    assert Look(coats) == pytest.approx(tilted, rel=5e-3, abs=2e-3 * tilted.mean())


def _Fresnel(cosine, index):
    within = np.sqrt(1 - (1 - cosine ** 2) / index ** 2)
    s = (cosine - index * within) / (cosine + index * within)
    p = (within - index * cosine) / (within + index * cosine)
    return 0.5 * (s * s + p * p)


@pytest.mark.parametrize("degrees", [30, 45, 75])
def test_what_lies_below_a_smooth_coat_has_the_other_normal(tmp_path, degrees):
    """A sun along the surface's normal: the base has the cosine of its own, the coat takes what it reflects to the viewer."""
    def Add(stage):
        UsdShade.Material.Define(stage, "/World/Look")
        return AddSurface(stage, "/World/Look", base=1.0, base_color=RED, specular=0.0, coat=1.0, coat_roughness=0.0, coat_IOR=1.6,
                          normal=_Map(stage))
    sun = (("Distant", dict(angle=0.0, intensity=1.0, placement=dict(rotate=(degrees, 0, 0)))),)
    color = _Picture(tmp_path, Add, sun, 16, 8, shapes.Plane(4, 4), degrees, maxDepth=1).mean((0, 1))
    left = 1 - _Fresnel(np.cos(np.radians(degrees)), 1.6)
    assert color == pytest.approx(left * np.array(RED) * TILTED[2] / np.pi, rel=0.01)


@pytest.mark.parametrize("identifier, stretched", [(STANDARD, dict(coat_anisotropy=0.9)),
                                                   (OPEN_PBR, dict(coat_roughness_anisotropy=0.9))])
def test_a_coat_is_stretched_as_a_reflection_is(tmp_path, identifier, stretched):
    """As the reflection of the same index that a surface without a coat has."""
    coat = MODELS[identifier][0]
    if identifier == STANDARD:
        base = dict(base=0.0, specular_roughness=0.3, specular_IOR=1.5, specular_anisotropy=0.9)
    else:
        base = dict(base_weight=0.0, specular_roughness=0.3, specular_ior=1.6, specular_roughness_anisotropy=0.9)
    coated, plain, bare = (_Blocks(_Picture(tmp_path, lambda stage: AddSurface(stage, "/World/Look", identifier, **inputs), samples=256,
                                            maxDepth=1)) for inputs in (dict(coat, **stretched), coat, base))
    assert abs(coated - plain).mean() > 0.2 * plain.mean()
    # The other reflection has the light that bounces more than once, too.
    assert coated == pytest.approx(bare, rel=0.02, abs=5e-3 * bare.mean())


SCHLICK = dict(color0=(0.04, 0.5, 0.9), color82=(1.0, 0.7, 0.9), color90=(1.0, 0.2, 0.6))


def _Schlick(exponent, cosine, f0=np.array(SCHLICK["color0"]), f82=np.array(SCHLICK["color82"]), f90=np.array(SCHLICK["color90"])):
    """MaterialX 1.39: mx_fresnel_hoffman_schlick."""
    at = 1 / 7
    a = (f0 + (f90 - f0) * (1 - at) ** exponent) * (1 - f82) / (at * (1 - at) ** 6)
    return f0 + (f90 - f0) * (1 - cosine) ** exponent - a * cosine * (1 - cosine) ** 6


def _Closure(stage, bsdf):
    UsdShade.Material.Define(stage, "/World/Look")
    return AddSurface(stage, "/World/Look", "ND_surface", bsdf=bsdf(stage))


def _Mirror(stage, exponent, **inputs):
    return AddNode(stage, "/World/Look/Mirror", "ND_generalized_schlick_bsdf", Sdf.ValueTypeNames.Token, roughness=(0.0, 0.0),
                   exponent=exponent, **SCHLICK, **inputs)


@pytest.mark.parametrize("exponent", [1.0, 3.0, 5.0])
@pytest.mark.parametrize("degrees", [0, 45, 75, 85])
def test_a_generalised_schlick_reflects_by_its_formula(tmp_path, degrees, exponent):
    def Bare(stage):
        return _Closure(stage, lambda stage: _Mirror(stage, exponent))

    def Layered(stage):
        def Both(stage):
            base = AddNode(stage, "/World/Look/Base", "ND_oren_nayar_diffuse_bsdf", Sdf.ValueTypeNames.Token, color=RED)
            return AddNode(stage, "/World/Look/Layer", "ND_layer_bsdf", Sdf.ValueTypeNames.Token, top=_Mirror(stage, exponent),
                           base=base)
        return _Closure(stage, Both)

    def Glass(stage):
        return _Closure(stage, lambda stage: _Mirror(stage, exponent, scatter_mode="RT"))
    reflected = _Schlick(exponent, np.cos(np.radians(degrees)))
    plane = shapes.Plane(60, 60)
    colors = [_Picture(tmp_path, look, DOME, 64, 8, plane, degrees, maxDepth=4).mean((0, 1)) for look in (Bare, Layered, Glass)]
    assert colors[0] == pytest.approx(reflected, abs=3e-3)
    assert colors[1] == pytest.approx(reflected + (1 - reflected) * np.array(RED), abs=6e-3)
    assert colors[2] == pytest.approx(np.ones(3), abs=6e-3)  # what is not reflected is refracted


@pytest.mark.parametrize("degrees", [0, 60, 85])
def test_a_metal_by_schlicks_term_lets_through_what_it_does_not_reflect(tmp_path, degrees):
    front, edge = np.array((0.3, 0.6, 0.8)), np.array((1.0, 0.8, 0.9))

    def Layered(stage):
        def Both(stage):
            token = Sdf.ValueTypeNames.Token
            base = AddNode(stage, "/World/Look/Base", "ND_oren_nayar_diffuse_bsdf", token, color=RED)
            top = AddNode(stage, "/World/Look/Top", "ND_generalized_schlick_bsdf", token, roughness=(0.0, 0.0),
                          color0=tuple(front), color82=tuple(edge))
            return AddNode(stage, "/World/Look/Layer", "ND_layer_bsdf", token, top=top, base=base)
        return _Closure(stage, Both)
    color = _Picture(tmp_path, Layered, DOME, 64, 8, shapes.Plane(60, 60), degrees, maxDepth=2).mean((0, 1))
    reflected = _Schlick(5.0, np.cos(np.radians(degrees)), front, edge, np.ones(3))
    assert color == pytest.approx(reflected + (1 - reflected) * np.array(RED), abs=6e-3)


def _Node(stage, name, kind, **inputs):
    return AddNode(stage, f"/World/Look/{name}", f"ND_{kind}", Sdf.ValueTypeNames.Token, **inputs)


def _Layered(*bsdfs):
    """A function that adds a surface of closures, each on those after it. bsdfs: (kind, inputs)."""
    def Add(stage):
        def Stack(stage):
            below = None
            for index, (kind, inputs) in reversed(list(enumerate(bsdfs))):
                given = {name: value(stage) if callable(value) else value for name, value in inputs.items()}
                node = _Node(stage, f"Node{index}", f"{kind}_bsdf", **given)
                below = node if below is None else _Node(stage, f"Layer{index}", "layer_bsdf", top=node, base=below)
            return below
        return _Closure(stage, Stack)
    return Add


@pytest.mark.parametrize("front, exponent, index", [((1 / 9, 1 / 9, 1 / 9), 5.0, 2.0), ((0.04, 0.04, 0.04), 3.0, 2.0),
                                                    ((0.3, 0.6, 0.8), 5.0, 1.5)])
def test_glass_below_a_schlicks_term_refracts_by_its_own_index(tmp_path, front, exponent, index):
    """A wall that begins where what comes in at the middle of the picture arrives by Snell's law."""
    theta = np.radians(45)
    away = np.tan(theta - np.arcsin(np.sin(theta) / index))  # per depth of the wall

    def Look(stage, begin=5 * away):
        wall = AddSurface(stage, "/World/Wall", base=0.0, specular=0.0, emission=1.0, emission_color=(1.0, 1.0, 1.0))
        author.AddMesh(stage, "/World/Emitter", shapes.Plane(40, 40), material=wall, doubleSided=True, rotate=(90, 0, 0),
                       translate=(0, begin + 20, -5))
        return _Layered(("generalized_schlick", dict(color0=front, exponent=exponent, roughness=(0.0, 0.0))),
                        ("dielectric", dict(ior=index, scatter_mode="T", roughness=(0.0, 0.0))))(stage)
    dark = (("Distant", dict(intensity=0.0)),)
    half, whole = (_Picture(tmp_path, look, dark, 256, 16, shapes.Plane(60, 60), 45, maxDepth=4).mean((0, 1))
                   for look in (Look, lambda stage: Look(stage, -5.0)))
    assert whole == pytest.approx(1 - _Schlick(exponent, np.cos(theta), np.array(front), np.ones(3), np.ones(3)), abs=4e-3)
    assert half / whole == pytest.approx(0.5, abs=0.01)


def test_a_coat_stays_smooth_below_a_sheen_with_a_normal(tmp_path):
    """Nothing but the coat reflects: the sheen is almost not there, and the index of what lies below is 1."""
    def Look(**sheen):
        layers = _Layered(("sheen", dict(weight=1e-6, **sheen)), ("dielectric", dict(roughness=(0.1, 0.1))),
                          ("dielectric", dict(ior=1.0)), ("oren_nayar_diffuse", dict(color=(0.0, 0.0, 0.0))))
        return _Blocks(_Render(tmp_path, layers, samples=256, maxDepth=1).rgb)
    plain = Look()
    assert Look(normal=_Map) == pytest.approx(plain, rel=5e-3, abs=2e-3 * plain.mean())


@pytest.mark.parametrize("mapped", ["top", "base", "both"])
def test_a_reflection_by_hand_has_its_own_normal(tmp_path, mapped):
    """As the coat of a surface that we have built in, to the bit; where both have one normal, as its reflection."""
    def Inputs(layer, name):
        return {name: _Map} if mapped in (layer, "both") else {}

    def Coat(stage):
        UsdShade.Material.Define(stage, "/World/Look")
        maps = {name: value(stage) for name, value in {**Inputs("base", "normal"), **Inputs("top", "coat_normal")}.items()}
        if mapped == "both":
            return AddSurface(stage, "/World/Look", base=1.0, base_color=RED, specular_roughness=0.5, normal=maps["normal"])
        return AddSurface(stage, "/World/Look", base=1.0, base_color=RED, specular=0.0, coat=1.0, coat_roughness=0.5, **maps)
    byHand = _Layered(("dielectric", dict(roughness=(0.25, 0.25), **Inputs("top", "normal"))),
                      ("oren_nayar_diffuse", dict(color=RED, **Inputs("base", "normal"))))
    assert np.array_equal(_Picture(tmp_path, byHand, samples=4), _Picture(tmp_path, Coat, samples=4))


@pytest.mark.parametrize("degrees", [0, 60, 80])
def test_a_film_on_a_metal_is_the_same_over_what_it_covers(tmp_path, degrees):
    """Alone the metal is a metal, and over black a dielectric with Schlick's term."""
    film = ("generalized_schlick", dict(color0=(0.3, 0.6, 0.8), color82=(1.0, 0.7, 0.9), thinfilm_thickness=380.0, thinfilm_ior=1.7,
                                        roughness=(0.0, 0.0)))
    bare = ("generalized_schlick", {key: value for key, value in film[1].items() if "film" not in key})
    black = ("oren_nayar_diffuse", dict(color=(0.0, 0.0, 0.0)))
    white = ("oren_nayar_diffuse", dict(color=(1.0, 1.0, 1.0)))
    alone, layered, both, without = (
        _Picture(tmp_path, _Layered(*bsdfs), DOME, 64, 8, shapes.Plane(60, 60), degrees, maxDepth=2).mean((0, 1))
        for bsdfs in ((film,), (film, black), (film, white), (bare,)))
    assert abs(alone - without).max() > 0.02
    assert layered == pytest.approx(alone, abs=2e-3)
    assert both == pytest.approx(np.ones(3), abs=6e-3)  # what the film reflects is not there below it


def test_the_albedo_below_a_coat_is_that_of_its_own_normal(tmp_path):
    """Of a plane at 70 degrees, seen along the normal of its map or far from it: a reflection with a coat that is almost not there."""
    def Look(coat):
        def Add(stage):
            UsdShade.Material.Define(stage, "/World/Look")
            return AddSurface(stage, "/World/Look", base=0.0, specular_roughness=0.0, coat=coat, normal=_Map(stage))
        return Add
    bare, coated = (_Render(tmp_path, Look(coat), DOME, 1, 8, shapes.Plane(60, 60), 70,
                            aovs=("color", "albedo")).layers["albedo"][4, 4, :3] for coat in (0.0, 1e-6))
    assert abs(bare - _Fresnel(np.cos(np.radians(70)), 1.5)).min() > 0.01
    assert coated == pytest.approx(bare, rel=2e-3)
