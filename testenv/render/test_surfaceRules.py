# SPDX-License-Identifier: Apache-2.0
"""UsdPreviewSurface by the rules of its text, version 2.5: a card for each rule, all in one picture, each against the
formula in double precision (closedForm.PreviewReflected). docs/shading.md lists them.

One light from one direction: a pixel is one value of the BSDF, without noise. View and light are 150 degrees apart, so
that Schlick's term is a fifth; cards face the half vector, or miss it by 5 degrees.
"""

from dataclasses import dataclass, field

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdShade

pytest.importorskip("hdstream._core")

import ours
from cardStrip import Strip
from closedForm import PreviewReflected
from stages import author, imageFile, shapes
from textureCases import AddReader, AddTexture, Connect

_VIEW = np.array([0.0, 0.0, 1.0])
_LIGHT = np.array([0.0, np.sin(np.radians(150)), np.cos(np.radians(150))])
_IRRADIANCE = 10.0
_FACING, _MISSING = 75.0, 70.0
_COLOR = (0.8, 0.4, 0.1)
_TILT = np.array([128, 105, 240])  # 8 bits: a normal that leans down the card


@dataclass
class Rule:
    """A card with inputs, and the inputs that the formula must see; they are the same where `seen` is None."""

    inputs: dict
    seen: dict | None = None
    tilt: float = _FACING
    build: object = None
    normal: np.ndarray = field(default_factory=lambda: _VIEW)  # in the card's tangent space


def _FromInterface(card):
    public = card.material.CreateInput("ior", Sdf.ValueTypeNames.Float)
    public.Set(1.9)
    surface = author.UsdShade.Shader(card.material.GetPrim().GetChild("Surface"))
    surface.CreateInput("ior", Sdf.ValueTypeNames.Float).ConnectToSource(public)


def _FromGlossiness(card):
    texture = AddTexture(card.material, "T", file="./gloss.png", sourceColorSpace="raw", scale=(-1,) * 4, bias=(1,) * 4)
    Connect(card.material, "roughness", texture, "r")


def _WithNormals(card):
    """As the text says for 8 bits: raw, scale 2, bias -1."""
    texture = AddTexture(card.material, "N", file="./normal.png", sourceColorSpace="raw", scale=(2, 2, 2, 1), bias=(-1, -1, -1, 0))
    Connect(card.material, "normal", texture, "rgb")


def _WithReader(name, kind, valueType, value):
    def Build(card):
        author.AddPrimvar(card.mesh, "data", valueType.arrayType, "constant", [value])
        reader = AddReader(card.material, "R", kind, "data")
        reader.CreateOutput("result", valueType)
        Connect(card.material, name, reader, "result")
    return Build


_SPECULAR = dict(useSpecularWorkflow=1, diffuseColor=_COLOR, specularColor=(0.1, 0.3, 0.6), roughness=0.4)
_METAL = dict(diffuseColor=_COLOR, metallic=1.0, roughness=0.4)
_COATED = dict(diffuseColor=_COLOR, clearcoat=0.75, clearcoatRoughness=0.3, roughness=0.6)
_NORMAL = 2 * _TILT / 255 - 1

_RULES = {
    "defaults": Rule({}),
    "diffuseColor": Rule(dict(diffuseColor=_COLOR)),
    "useSpecularWorkflow_0_ignoresSpecularColor": Rule(
        dict(diffuseColor=_COLOR, specularColor=(1, 0, 0), useSpecularWorkflow=0), dict(diffuseColor=_COLOR)),
    "useSpecularWorkflow_1_ignoresMetallic": Rule(dict(_SPECULAR, metallic=1.0), _SPECULAR),
    "useSpecularWorkflow_1_ignoresIor": Rule(dict(_SPECULAR, ior=3.0), _SPECULAR),
    "specularColor": Rule(_SPECULAR),
    "specularColor_default": Rule(dict(useSpecularWorkflow=1, diffuseColor=_COLOR)),
    "specularColor_edgeIsWhite": Rule(dict(useSpecularWorkflow=1, diffuseColor=(0, 0, 0), specularColor=(0, 0, 0))),
    "metallic_0": Rule(dict(diffuseColor=_COLOR, metallic=0.0, roughness=0.4)),
    "metallic_1": Rule(_METAL),
    "metallic_1_ignoresIor": Rule(dict(_METAL, ior=3.0), _METAL),
    "metallic_between": Rule(dict(_METAL, metallic=0.5)),
    "roughness": Rule(dict(_METAL, roughness=0.8), tilt=_MISSING),
    "roughness_small": Rule(dict(_METAL, roughness=0.2), tilt=_MISSING),
    "roughness_isSquared": Rule(dict(_METAL, roughness=0.3)),
    "roughness_ofGlossiness": Rule(_METAL, dict(_METAL, roughness=1 - 153 / 255), build=_FromGlossiness),
    "clearcoat": Rule(_COATED),
    "clearcoat_isWhite": Rule(dict(_METAL, clearcoat=1.0, clearcoatRoughness=0.3)),
    "clearcoat_default": Rule(dict(clearcoatRoughness=0.3, diffuseColor=_COLOR), dict(diffuseColor=_COLOR)),
    "clearcoatRoughness": Rule(dict(_COATED, clearcoatRoughness=0.7), tilt=_MISSING),
    "clearcoat_usesIor": Rule(dict(_METAL, clearcoat=1.0, clearcoatRoughness=0.4, ior=2.5)),
    "ior": Rule(dict(diffuseColor=_COLOR, ior=2.5)),
    "ior_1": Rule(dict(diffuseColor=_COLOR, ior=1.0)),
    "ior_ofInterface": Rule(dict(diffuseColor=_COLOR), dict(diffuseColor=_COLOR, ior=1.9), build=_FromInterface),
    "normal_default": Rule(dict(_METAL, normal=(0, 0, 1)), _METAL),
    "normal": Rule(_METAL, tilt=80.0, build=_WithNormals, normal=_NORMAL),
    "normal_ofDiffuse": Rule(dict(diffuseColor=_COLOR), tilt=80.0, build=_WithNormals, normal=_NORMAL),
    "clearcoat_usesNormal": Rule(_COATED, tilt=80.0, build=_WithNormals, normal=_NORMAL),
    "opacityThreshold_above": Rule(dict(_METAL, opacity=0.75, opacityThreshold=0.5), _METAL),
    "opacityThreshold_equal": Rule(dict(_METAL, opacity=0.5, opacityThreshold=0.5), _METAL),
    "occlusion_isIgnored": Rule(dict(_METAL, occlusion=0.0), _METAL),
    "connected_color": Rule(_METAL, dict(_METAL, diffuseColor=(0.25, 0.5, 0.75)), build=_WithReader(
        "diffuseColor", "float3", Sdf.ValueTypeNames.Color3f, Gf.Vec3f(0.25, 0.5, 0.75))),
    "connected_metallic": Rule(dict(_METAL, metallic=0.0), dict(_METAL, metallic=0.25), build=_WithReader(
        "metallic", "float", Sdf.ValueTypeNames.Float, 0.25)),
    "connected_specularColor": Rule(_SPECULAR, dict(_SPECULAR, specularColor=(0.25, 0.5, 0.75)), build=_WithReader(
        "specularColor", "float3", Sdf.ValueTypeNames.Color3f, Gf.Vec3f(0.25, 0.5, 0.75))),
    "connected_clearcoat": Rule(_COATED, dict(_COATED, clearcoat=0.25), build=_WithReader(
        "clearcoat", "float", Sdf.ValueTypeNames.Float, 0.25)),
    "connected_clearcoatRoughness": Rule(_COATED, dict(_COATED, clearcoatRoughness=0.5), build=_WithReader(
        "clearcoatRoughness", "float", Sdf.ValueTypeNames.Float, 0.5)),
    "connected_ior": Rule(_COATED, dict(_COATED, ior=2.0), build=_WithReader("ior", "float", Sdf.ValueTypeNames.Float, 2.0)),
}
_REMOVED = {"opacityThreshold_below": dict(opacity=0.4375, opacityThreshold=0.5),
            "opacityThreshold_transparent": dict(opacity=0.0, opacityThreshold=0.125)}


@pytest.fixture(scope="module")
def Cards(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rules")
    imageFile.WritePng(f"{folder}/gloss.png", np.full((4, 4, 1), 153, np.uint8))
    imageFile.WritePng(f"{folder}/normal.png", np.broadcast_to(_TILT.astype(np.uint8), (4, 4, 3)))
    strip = Strip(folder / "stage.usda")
    for name, rule in _RULES.items():
        strip.Add(name, rule.build, tilt=rule.tilt, **rule.inputs)
    for name, inputs in _REMOVED.items():
        strip.Add(name, tilt=_FACING, **_METAL, **inputs)
    strip.Add("displacement", displacement=0.25)
    strip.Add("displacement_default")
    # Light runs along the light's -z.
    author.AddLight(strip.stage, "/World/Sun", "Distant", dict(rotate=(210, 0, 0)), angle=0.0, intensity=_IRRADIANCE)
    strip.Render(("color", "position", "alpha"), samples=4)
    assert not strip.picture.warnings
    return strip


def _WorldNormal(tilt, tangentSpace) -> np.ndarray:
    """Of a tilted card, whose s runs along x and whose t runs up."""
    angle = np.radians(tilt)
    frame = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    return np.asarray(tangentSpace) @ frame


@pytest.mark.parametrize("name", _RULES)
def test_rule(name, Cards):
    rule, pixels = _RULES[name], Cards.Pixels(name)[:, :3]
    seen = rule.inputs if rule.seen is None else rule.seen
    expected = _IRRADIANCE * PreviewReflected(_WorldNormal(rule.tilt, rule.normal), _VIEW, _LIGHT, **seen)
    assert expected.max() > 0.05
    np.testing.assert_allclose(pixels, np.broadcast_to(expected, pixels.shape), rtol=1e-4)


@pytest.mark.parametrize("name", _REMOVED)
def test_what_is_below_the_threshold_is_not_there(name, Cards):
    assert not Cards.Pixels(name).any() and not Cards.Pixels(name, "alpha").any()


def test_displacement_moves_along_the_normal(Cards):
    np.testing.assert_allclose(Cards.Pixels("displacement", "position")[:, 2], 0.25, atol=1e-6)
    np.testing.assert_allclose(Cards.Pixels("displacement_default", "position")[:, 2], 0.0, atol=1e-6)


# --- Opacity: what shows through ---------------------------------------------------------------------

_BEHIND = np.array([4.0, 2.0, 1.0])
_CLEAR = dict(diffuseColor=(0.0, 0.0, 0.0))
# Inputs, and the part of the light behind that passes: (1 - opacity)(1 - F) at normal incidence.
_THROUGH = {
    "opacity_default": (_CLEAR, 0.0),
    "opacity_1": (dict(_CLEAR, opacity=1.0), 0.0),
    "opacity_0": (dict(_CLEAR, opacity=0.0, ior=1.0), 1.0),
    "opacity_between": (dict(_CLEAR, opacity=0.25, ior=1.0), 0.75),
    "opacity_0_reflects": (dict(_CLEAR, opacity=0.0), 1 - 0.04),
    "opacity_usesIor": (dict(_CLEAR, opacity=0.0, ior=3.0), 1 - 0.25),
    "opacity_0_reflectsByTheCoat": (dict(_CLEAR, opacity=0.0, clearcoat=1.0, ior=3.0), (1 - 0.25) ** 2),
    "opacity_specularWorkflow": (dict(_CLEAR, opacity=0.0, useSpecularWorkflow=1, specularColor=(0.5, 0.5, 0.5)), 0.5),
    "opacity_roughnessIsNoMatter": (dict(_CLEAR, opacity=0.5, ior=1.0, roughness=1.0), 0.5),
    "opacityThreshold_0_doesNotMask": (dict(_CLEAR, opacity=0.5, ior=1.0, opacityThreshold=0.0), 0.5),
    "opacityThreshold_below": (dict(_CLEAR, opacity=0.25, opacityThreshold=0.5), 1.0),
    "opacityThreshold_above": (dict(_CLEAR, opacity=0.75, opacityThreshold=0.5), 0.0),
}


@pytest.fixture(scope="module")
def Glass(tmp_path_factory):
    """Cards in front of others that glow."""
    strip = Strip(tmp_path_factory.mktemp("glass") / "stage.usda")
    glow = author.AddMaterial(strip.stage, "/World/Glow", diffuseColor=(0.0, 0.0, 0.0), metallic=1.0, emissiveColor=tuple(_BEHIND))
    for name, (inputs, _) in _THROUGH.items():
        card = strip.Add(name, **inputs)
        strip.AddPlate(f"/World/Behind{card.number}", card.number, glow, depth=1.0)
    card = strip.Add("emissiveColor", diffuseColor=(0.0, 0.0, 0.0), metallic=1.0, emissiveColor=(0.5, 2.0, 8.0))
    return strip.Render(samples=1024)


@pytest.mark.parametrize("name", _THROUGH)
def test_what_is_behind_shows_through(name, Glass):
    pixels, expected = Glass.Pixels(name)[:, :3], _THROUGH[name][1] * _BEHIND
    np.testing.assert_allclose(pixels, np.broadcast_to(expected, pixels.shape), rtol=5e-3, atol=1e-6)


def test_emissiveColor(Glass):
    np.testing.assert_allclose(Glass.Pixels("emissiveColor")[:, :3], np.broadcast_to([0.5, 2.0, 8.0], (4, 3)), rtol=1e-6)


def test_opacityMode(tmp_path):
    """presence: so much of the surface is there, reflection included; transparent: reflection stays."""
    found = {}
    for name, opacity, mode in [("opaque", 1.0, None), ("presence", 0.5, "presence"), ("absent", 0.0, "presence"),
                                ("transparent", 0.0, "transparent"), ("materialX1", 0.5, 1), ("materialX0", 0.0, 0)]:
        stage = author.NewStage(str(tmp_path / f"{name}.usda"))
        material = author.AddMaterial(stage, "/World/Look", diffuseColor=(0.2, 0.1, 0.0), ior=2.0, opacity=opacity)
        if mode is not None:
            shader = UsdShade.Shader.Get(stage, "/World/Look/Surface")
            isNumber = isinstance(mode, int)  # as in MaterialX's definition
            shader.CreateInput("opacityMode", Sdf.ValueTypeNames.Int if isNumber else Sdf.ValueTypeNames.Token).Set(mode)
            shader.GetIdAttr().Set("ND_UsdPreviewSurface_surfaceshader" if isNumber else "UsdPreviewSurface")
        author.AddMesh(stage, "/World/Plate", shapes.Plane(4, 4), material=material, rotate=(90, 0, 0))
        author.AddLight(stage, "/World/Light", "Distant", dict(rotate=(-20, 0, 0)), angle=10.0, intensity=3.0)
        author.AddCamera(stage, eye=(0, 0, 9), width=20.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        found[name] = ours.Render(stage.GetRootLayer().realPath, 8, 8, samples=256).rgb.mean((0, 1))
    assert found["presence"] == pytest.approx(0.5 * found["opaque"], rel=0.02)
    assert not found["absent"].any() and found["transparent"].all()
    np.testing.assert_array_equal(found["materialX1"], found["presence"])
    np.testing.assert_array_equal(found["materialX0"], found["transparent"])


def test_what_passes_goes_straight(tmp_path):
    """A lamp behind a tilted pane of opacity 0 lies where it lies without the pane, whatever the index, and loses 1 - F
    (docs/decisions/0022-opacity-goes-straight.md). An index of 2 that bent what passes would move it by its own width."""
    found, angle, ior = [], 55.0, 2.0
    for hasPane in (False, True):
        stage = author.NewStage(str(tmp_path / f"{hasPane}.usda"))
        lamp = author.AddMaterial(stage, "/World/Lamp", diffuseColor=(0, 0, 0), emissiveColor=(1, 1, 1), ior=1.0)
        author.AddMesh(stage, "/World/Patch", shapes.Plane(2, 2), material=lamp, rotate=(90, 0, 0), translate=(0, 0, -3))
        if hasPane:
            glass = author.AddMaterial(stage, "/World/Glass", diffuseColor=(0, 0, 0), ior=ior, opacity=0.0)
            author.AddMesh(stage, "/World/Pane", shapes.Plane(20, 20), material=glass, rotate=(90 - angle, 0, 0), doubleSided=True)
        author.AddCamera(stage, eye=(0, 0, 20), width=60.0, aspect=1.0, orthographic=True)
        stage.GetRootLayer().Save()
        found.append(ours.Render(stage.GetRootLayer().realPath, 24, 24, samples=256).rgb[..., 0])
    without, behind = found
    assert (without == 0).sum() > 300 and (without > 0.99).sum() > 30
    np.testing.assert_array_equal(behind == 0, without == 0)
    normal = ((1 - ior) / (1 + ior)) ** 2
    fresnel = normal + (1 - normal) * (1 - np.cos(np.radians(angle))) ** 5
    assert behind[without > 0.99].mean() == pytest.approx((1 - fresnel) * without[without > 0.99].mean(), rel=0.02)
