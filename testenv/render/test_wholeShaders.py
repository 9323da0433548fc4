# SPDX-License-Identifier: Apache-2.0
"""MaterialX nodes that take and give whole shaders: mixes with UsdPreviewSurface, colours as surfaces, what only hands a shader
on, mixes of displacements and of volumes."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import ours
from pxr import Gf, Sdf, UsdShade
from stages import author, imageFile, shapes
from stages.materialX import STANDARD, AddNode, AddSurface

_T = Sdf.ValueTypeNames
_ROOT = "/World/Look"
PREVIEW = "ND_UsdPreviewSurface_surfaceshader"
RED, BLUE, GOLD = (0.7, 0.1, 0.08), (0.1, 0.2, 0.9), (0.95, 0.7, 0.35)
SKY = (("Dome", dict(intensity=0.7)), ("Distant", dict(placement=dict(rotate=(-30, 20, 0)), angle=40.0, intensity=3.0)))


def _Node(stage, name, identifier, **inputs):
    return AddNode(stage, f"{_ROOT}/{name}", identifier, _T.Token, **inputs)


def _Material(stage, **terminals):
    """A material whose terminals are those nodes."""
    material = UsdShade.Material.Define(stage, _ROOT)
    for name, (shader, output) in terminals.items():
        getattr(material, f"Create{name.capitalize()}Output")("mtlx").ConnectToSource(shader.GetOutput(output))
    return material


def _Quad(side):
    """A square that the camera sees from above."""
    half = side / 2
    corners = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], float)
    return shapes.Shape(corners, np.array([4]), np.arange(4), None, np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float))


def _Picture(tmp_path, addMaterial, lights=SKY, samples=64, size=16, shape=None, aovs=("color",), **settings):
    stage = author.NewStage(str(tmp_path / "stage.usda"))
    UsdShade.Material.Define(stage, _ROOT)
    author.AddMesh(stage, "/World/Shape", shape or shapes.Sphere(1.0, 32, 64), material=addMaterial(stage), doubleSided=True)
    for index, (kind, inputs) in enumerate(lights):
        author.AddLight(stage, f"/World/Light{index}", kind, **inputs)
    author.AddCamera(stage, eye=(0, 0, 10), width=24.0, aspect=1.0, orthographic=True)
    stage.GetRootLayer().Save()
    return ours.Render(stage.GetRootLayer().realPath, size, size, samples=samples, aovs=aovs, **settings)


PREVIEWS = {
    "plastic": dict(diffuseColor=RED, roughness=0.4),
    "metal": dict(diffuseColor=GOLD, metallic=1.0, roughness=0.2),
    "partlyMetal": dict(diffuseColor=GOLD, metallic=0.6, roughness=0.2),
    "specular": dict(diffuseColor=RED, useSpecularWorkflow=1, specularColor=(0.3, 0.1, 0.2), roughness=0.2),
    "coat": dict(diffuseColor=RED, roughness=0.2, clearcoat=1.0, clearcoatRoughness=0.2, ior=1.8),
    "glow": dict(diffuseColor=RED, emissiveColor=(0.0, 0.5, 0.2)),
    "cutOut": dict(diffuseColor=RED, opacity=0.4, opacityThreshold=0.5),
    "shown": dict(diffuseColor=RED, opacity=0.8, opacityThreshold=0.5),
    "presence": dict(diffuseColor=RED, opacity=0.6, opacityMode=1),
}


def _Mixed(identifier, inputs, isHandedOn=False, front=dict(base=1.0, base_color=BLUE, specular=0.0), mix=0.25):
    def Add(stage):
        back = _Node(stage, "Back", identifier, **inputs)
        back = _Node(stage, "Dot", "ND_dot_surfaceshader", **{"in": back}) if isHandedOn else back
        return AddSurface(stage, _ROOT, "ND_mix_surfaceshader", bg=back, fg=_Node(stage, "Front", STANDARD, **front), mix=mix)
    return Add


@pytest.mark.parametrize("name", PREVIEWS)
def test_a_preview_surface_is_mixed_as_it_is_drawn(tmp_path, name):
    """The mix is the weighed sum of the pictures of both, of which that of UsdPreviewSurface is by its own formula."""
    inputs = PREVIEWS[name]
    shape = _Quad(4.0) if "opacity" in inputs else None  # through a ball its other side is seen
    mixed, own, front = (_Picture(tmp_path, surface, samples=512, maxDepth=1, shape=shape) for surface in (
        _Mixed(PREVIEW, inputs), lambda stage: AddSurface(stage, _ROOT, PREVIEW, **inputs),
        lambda stage: AddSurface(stage, _ROOT, STANDARD, base=1.0, base_color=BLUE, specular=0.0)))
    assert mixed.warnings == []
    expected = 0.75 * own.rgb + 0.25 * front.rgb
    # Towards the rim the formula's layers leave more to those below: they are coupled by 1 - F, closures by their albedo.
    assert mixed.rgb.mean((0, 1)) == pytest.approx(expected.mean((0, 1)), rel=0.025)
    # At a roughness of 0.2 hardly any light bounces between facets, which closures count and the formula does not.
    middle = slice(5, 11)
    assert mixed.rgb[middle, middle].mean((0, 1)) == pytest.approx(expected[middle, middle].mean((0, 1)), rel=0.01)


def test_a_preview_surface_is_mixed_behind_what_hands_it_on(tmp_path):
    inputs = PREVIEWS["plastic"]
    assert np.array_equal(_Picture(tmp_path, _Mixed(PREVIEW, inputs, isHandedOn=True), samples=4).rgb,
                          _Picture(tmp_path, _Mixed(PREVIEW, inputs), samples=4).rgb)
    assert np.array_equal(_Picture(tmp_path, _Mixed("UsdPreviewSurface", inputs), samples=4).rgb,
                          _Picture(tmp_path, _Mixed(PREVIEW, inputs), samples=4).rgb)


def _Tilted(tmp_path, stage):
    """A normal map of one normal, 30 degrees towards +x."""
    imageFile.WriteExr(tmp_path / "map.exr", {name: np.full((4, 4), number) for name, number in zip("RGB", (0.75, 0.5, 0.933))})
    reader, _ = AddNode(stage, f"{_ROOT}/St", "UsdPrimvarReader_float2", varname="st")
    reader.CreateOutput("result", _T.Float2)
    image, _ = AddNode(stage, f"{_ROOT}/Map", "UsdUVTexture", file=Sdf.AssetPath(str(tmp_path / "map.exr")), sourceColorSpace="raw",
                       scale=(2.0, 2.0, 2.0, 1.0), bias=(-1.0, -1.0, -1.0, 0.0), st=(reader, "result"))
    image.CreateOutput("rgb", _T.Float3)
    return image, "rgb"


def test_a_preview_surface_keeps_its_normal_map_in_a_mix(tmp_path):
    inputs, shape = PREVIEWS["plastic"], _Quad(4.0)
    lights = (("Distant", dict(placement=dict(rotate=(0, 50, 0)), angle=5.0, intensity=100.0)),)
    mixed, own, flat, front = (_Picture(tmp_path, surface, lights, samples=256, maxDepth=1, shape=shape).rgb.mean((0, 1)) for surface in (
        lambda stage: _Mixed(PREVIEW, dict(inputs, normal=_Tilted(tmp_path, stage)))(stage),
        lambda stage: AddSurface(stage, _ROOT, PREVIEW, **inputs, normal=_Tilted(tmp_path, stage)),
        lambda stage: AddSurface(stage, _ROOT, PREVIEW, **inputs),
        lambda stage: AddSurface(stage, _ROOT, STANDARD, base=1.0, base_color=BLUE, specular=0.0)))
    assert np.abs(own / flat - 1).min() > 0.2
    assert mixed == pytest.approx(0.75 * own + 0.25 * front, rel=0.015)


COLORS = {  # type -> (value, colour, opacity)
    "color3": ((0.1, 0.2, 0.9), (0.1, 0.2, 0.9), 1.0), "color4": ((0.1, 0.2, 0.9, 0.25), (0.1, 0.2, 0.9), 0.25),
    "float": (0.5, (0.5, 0.5, 0.5), 1.0), "vector2": ((0.3, 0.6), (0.3, 0.6, 0.0), 1.0),
    "vector3": (Gf.Vec3f(0.3, 0.6, 0.2), (0.3, 0.6, 0.2), 1.0), "vector4": ((0.1, 0.2, 0.9, 0.5), (0.1, 0.2, 0.9), 0.5),
    "integer": (2, (2.0, 2.0, 2.0), 1.0), "boolean": (True, (1.0, 1.0, 1.0), 1.0)}


@pytest.mark.parametrize("kind", COLORS)
def test_a_colour_as_a_surface_is_what_is_seen(tmp_path, kind):
    value, color, opacity = COLORS[kind]
    picture = _Picture(tmp_path, lambda stage: AddSurface(stage, _ROOT, f"ND_convert_{kind}_surfaceshader", **{"in": value}),
                       lights=(("Dome", {}),), shape=_Quad(4.0), samples=512, size=8)
    assert picture.warnings == []
    assert picture.rgb.mean((0, 1)) == pytest.approx(opacity * np.array(color) + (1 - opacity), abs=0.01 if opacity < 1 else 1e-5)


def test_what_hands_a_surface_on_changes_no_bit(tmp_path):
    def Handed(stage):
        inner = _Node(stage, "Dot0", "ND_dot_surfaceshader", **{"in": _Node(stage, "Inner", STANDARD, base=1.0, base_color=RED)})
        whole = _Node(stage, "Whole", "ND_surfacematerial", surfaceshader=inner)
        return _Material(stage, surface=whole)
    plain = _Picture(tmp_path, lambda stage: AddSurface(stage, _ROOT, STANDARD, base=1.0, base_color=RED), samples=4)
    handed = _Picture(tmp_path, Handed, samples=4)
    assert handed.warnings == [] and np.array_equal(handed.rgb, plain.rgb)


def test_a_cycle_of_what_hands_on_is_no_surface(tmp_path):
    def Cycle(stage):
        one = _Node(stage, "One", "ND_dot_surfaceshader")
        other = _Node(stage, "Other", "ND_dot_surfaceshader", **{"in": one})
        one[0].CreateInput("in", _T.Token).ConnectToSource(other[0].GetOutput("out"))
        return _Material(stage, surface=other)
    picture = _Picture(tmp_path, Cycle, samples=1)
    assert any("displayColor is used" in text for text in picture.warnings)


def _Moves(stage, name, amount, kind="float", **inputs):
    return _Node(stage, name, f"ND_displacement_{kind}", displacement=amount, **inputs)


def _Vector(stage, name, amount, **inputs):
    return _Moves(stage, name, Gf.Vec3f(*amount), "vector3", space="object", **inputs)


def _Mix(stage, name, bg, fg, mix):
    return _Node(stage, name, "ND_mix_displacementshader", **{k: v for k, v in dict(bg=bg, fg=fg, mix=mix).items() if v is not None})


DISPLACEMENTS = {  # name -> (function that makes the shader, way of the plane's points)
    "float": (lambda s: _Mix(s, "Mix", _Moves(s, "A", 0.4), _Moves(s, "B", -0.2, scale=2.0), 0.25), (0, 0, 0.2)),
    "one side": (lambda s: _Mix(s, "Mix", None, _Moves(s, "B", 0.4), 0.5), (0, 0, 0.2)),
    "nested": (lambda s: _Mix(s, "Mix", _Moves(s, "A", 0.4), _Mix(s, "In", _Moves(s, "B", 0.0), _Moves(s, "C", 0.8), 0.5), 0.5), (0, 0, 0.4)),
    "vector": (lambda s: _Mix(s, "Mix", _Vector(s, "A", (0.1, 0.0, 0.2)), _Vector(s, "B", (0.0, 0.2, 0.4), scale=0.5), 0.5),
               (0.05, 0.05, 0.2)),
    "dot": (lambda s: _Node(s, "Dot", "ND_dot_displacementshader", **{"in": _Moves(s, "A", 0.3)}), (0, 0, 0.3)),
}


@pytest.mark.parametrize("isInput", [False, True], ids=["terminal", "surfacematerial"])
@pytest.mark.parametrize("name", DISPLACEMENTS)
def test_displacements_are_mixed(tmp_path, name, isInput):
    make, way = DISPLACEMENTS[name]

    def Add(stage):
        surface, moves = _Node(stage, "Surface", STANDARD, base=1.0), make(stage)
        if isInput:
            return _Material(stage, surface=_Node(stage, "Whole", "ND_surfacematerial", surfaceshader=surface, displacementshader=moves))
        return _Material(stage, surface=surface, displacement=moves)
    # A quad of one unit: where it ends tells of the way along x and y.
    picture = _Picture(tmp_path, Add, samples=1, size=256, shape=_Quad(1.0), aovs=("position",))
    assert picture.warnings == []
    points = picture.layers["position"].reshape(256 * 256, -1)[:, :3]
    points = points[np.any(points != 0.0, 1)]  # the others see the sky
    assert points[:, 2] == pytest.approx(way[2], abs=1e-5)
    assert 0.5 * (points.min(0) + points.max(0))[:2] == pytest.approx(way[:2], abs=0.011)  # a pixel


def test_what_cannot_be_mixed_or_does_not_displace_is_told(tmp_path):
    def Kinds(stage):
        return _Material(stage, surface=_Node(stage, "Surface", STANDARD), displacement=_Mix(
            stage, "Mix", _Moves(stage, "A", 0.4), _Vector(stage, "B", (0.0, 0.2, 0.4)), 0.5))

    def Unknown(stage):
        return _Material(stage, surface=_Node(stage, "Surface", STANDARD), displacement=_Node(stage, "Moves", "ND_of_another_renderer"))
    for make, text in ((Kinds, "has displacements of two kinds; ignored"), (Unknown, "is not supported; ignored")):
        picture = _Picture(tmp_path, make, samples=1, shape=_Quad(1.0))
        assert len(picture.warnings) == 1 and text in picture.warnings[0]


def _Fills(stage, name, absorption, scattering=None, glow=None):
    inputs = dict(absorption=Gf.Vec3f(*absorption), **({"scattering": Gf.Vec3f(*scattering)} if scattering else {}))
    vdf = _Node(stage, f"{name}Vdf", "ND_anisotropic_vdf" if scattering else "ND_absorption_vdf", **inputs)
    edf = dict(edf=_Node(stage, f"{name}Edf", "ND_uniform_edf", color=glow)) if glow else {}
    return _Node(stage, name, "ND_volume", vdf=vdf, **edf)


def _MixedVolumes(stage):
    return _Node(stage, "Mix", "ND_mix_volumeshader", mix=0.25, bg=_Fills(stage, "A", (1.0, 0.0, 0.5), (0.0, 0.5, 1.0), (0.5, 0.0, 0.25)),
                 fg=_Node(stage, "Dot", "ND_dot_volumeshader", **{"in": _Fills(stage, "B", (0.0, 1.0, 0.5), (2.0, 0.5, 1.0), (0.5, 1.0, 0.0))}))


def _MixedParts(stage):
    sides = [[_Node(stage, f"{name}Vdf", "ND_anisotropic_vdf", absorption=Gf.Vec3f(*absorption), scattering=Gf.Vec3f(*scattering)),
              _Node(stage, f"{name}Edf", "ND_uniform_edf", color=glow)]
             for name, absorption, scattering, glow in (("A", (1.0, 0.0, 0.5), (0.0, 0.5, 1.0), (0.5, 0.0, 0.25)),
                                                        ("B", (0.0, 1.0, 0.5), (2.0, 0.5, 1.0), (0.5, 1.0, 0.0)))]
    vdf, edf = (_Node(stage, f"Mix{kind}", f"ND_mix_{kind}", bg=sides[0][i], fg=sides[1][i], mix=0.25) for i, kind in enumerate(("vdf", "edf")))
    volume = _Node(stage, "Volume", "ND_volume", vdf=vdf, edf=edf)
    return _Node(stage, "Whole", "ND_volumematerial", volumeshader=volume)


@pytest.mark.parametrize("make", [_MixedVolumes, _MixedParts])
def test_volumes_are_mixed(tmp_path, make):
    """As the volume whose coefficients are the sums, which floats hold exactly."""
    mixed, summed = (_Picture(tmp_path, lambda stage, make=make: _Material(stage, volume=make(stage)), samples=8) for make in (
        make, lambda stage: _Fills(stage, "Sum", (0.75, 0.25, 0.5), (0.5, 0.5, 1.0), (0.5, 0.25, 0.1875))))
    assert mixed.warnings == summed.warnings == []
    assert np.array_equal(mixed.rgb, summed.rgb)
