# SPDX-License-Identifier: Apache-2.0
"""Colours in other spaces than Rec. 709, and a working space of other primaries (docs/color.md).

Oracles: OpenUSD's own Gf.ColorSpace, which shares no code with OpenColorIO; the Academy's matrix; two pictures of one stage
in two working spaces, which differ by that matrix where light meets one colour only, and by the product of both colours in
either space where it meets two. Cards glow, or are lit by one light from one direction: no noise.
"""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

pytest.importorskip("hdstream._core")
if not hasattr(Gf, "ColorSpace") or not hasattr(Usd, "ColorSpaceAPI"):
    pytest.skip("this usd-core has no colour spaces", allow_module_level=True)

import ours
import volumeCase
from cardStrip import Strip
from hdstream import _core
from hdstream.translate import colorSpaces
from stages import author, imageFile, shapes
from stages.materialX import AddNode, AddSurface
from textureCases import AddReader, AddTexture, Connect, FromSrgb

_T = Sdf.ValueTypeNames
_COLOR = (0.8, 0.3, 0.1)
_OTHER = (0.2, 0.6, 0.9)
_DARK = (0.4, 0.3, 0.2)  # of ACEScg, inside of Rec. 709
_SPACES = ("lin_ap1_scene", "lin_ap0_scene", "lin_rec2020_scene", "lin_p3d65_scene", "lin_adobergb_scene",
           "lin_ciexyzd65_scene", "lin_rec709_scene", "srgb_rec709_scene", "srgb_ap1_scene", "srgb_p3d65_scene",
           "g18_rec709_scene", "g22_rec709_scene", "g24_rec709_scene", "g22_ap1_scene", "g22_adobergb_scene")
_AP1 = "lin_ap1_scene"
# Linear Rec. 709 from ACEScg as the Academy publishes it, with Bradford's adaptation.
_REC709_FROM_AP1 = np.array([[1.7050509927, -0.6217921207, -0.0832588720], [-0.1302564175, 1.1408047366, -0.0105483191],
                             [-0.0240033568, -0.1289689761, 1.1529723329]])
_BLACK = dict(diffuseColor=(0, 0, 0), metallic=1.0)


def _Rec709(space, rgb=_COLOR):
    return np.array(Gf.ColorSpace("lin_rec709_scene").Convert(Gf.ColorSpace(space), Gf.Vec3f(*rgb)).GetRGB())


def _Apply(prim, space):
    Usd.ColorSpaceAPI.Apply(prim).CreateColorSpaceNameAttr(space)


def _Emission(card):
    return UsdShade.Shader(card.material.GetPrim().GetChild("Surface")).GetInput("emissiveColor").GetAttr()


def _FromInterface(card):
    public = card.material.CreateInput("glow", _T.Color3f)
    public.Set(Gf.Vec3f(*_COLOR))
    public.GetAttr().SetColorSpace(_AP1)
    surface = UsdShade.Shader(card.material.GetPrim().GetChild("Surface"))
    surface.GetInput("emissiveColor").ConnectToSource(public)


def _WithPrimvar(interpolation, values, indices=None):
    def Build(card):
        author.AddPrimvar(card.mesh, "glow", _T.Color3fArray, interpolation, values, indices)
        UsdGeom.PrimvarsAPI(card.mesh).GetPrimvar("glow").GetAttr().SetColorSpace(_AP1)
        reader = AddReader(card.material, "R", "float3", "glow")
        reader.CreateOutput("result", _T.Float3)
        Connect(card.material, "emissiveColor", reader, "result")
    return Build


def _WithMaterialX(card):
    """A surface that glows with a constant that goes through a node."""
    path = f"{card.material.GetPath()}X"
    stage = card.material.GetPrim().GetStage()
    node = AddNode(stage, f"{path}_C", "ND_constant_color3", value=_COLOR)
    node[0].GetInput("value").GetAttr().SetColorSpace("lin_ap1")  # as MaterialX names it
    author.Bind(card.mesh, AddSurface(stage, path, "ND_surface_unlit", emission_color=node))


def _Lit(color=None, space=None):
    """A card that only reflects."""
    def Build(card):
        UsdShade.MaterialBindingAPI(card.mesh.GetPrim()).UnbindAllBindings()
        attribute = card.mesh.CreateDisplayColorAttr([Gf.Vec3f(*(color or (1, 1, 1)))])
        if space:
            attribute.SetColorSpace(space)
    return Build


def _WithImage(file, **inputs):
    def Build(card):
        Connect(card.material, "emissiveColor", AddTexture(card.material, "T", file=f"./{file}", **inputs), "rgb")
    return Build


def _WithImageX(file, identifier, space):
    def Build(card):
        path, stage = f"{card.material.GetPath()}X", card.material.GetPrim().GetStage()
        output = _T.Color3f if "color" in identifier else _T.Float3
        node = AddNode(stage, f"{path}_I", identifier, output, file=Sdf.AssetPath(f"./{file}"))
        node[0].GetInput("file").GetAttr().SetColorSpace(space)
        if output == _T.Float3:
            node = AddNode(stage, f"{path}_V", "ND_convert_vector3_color3", **{"in": node})
        author.Bind(card.mesh, AddSurface(stage, path, "ND_surface_unlit", emission_color=node))
    return Build


def _BuildLit(folder, lightInputs=None, lightSpace=""):
    """Cards that reflect the light of one sun."""
    folder.mkdir(exist_ok=True)
    strip = Strip(folder / "lit.usda")
    strip.Add("displayColor", _Lit(_DARK, _AP1))
    strip.Add("displayColor709", _Lit(_COLOR))
    strip.Add("white", _Lit())
    light = author.AddLight(strip.stage, "/World/Sun", "Distant", dict(rotate=(0, 0, 0)), angle=0.0, intensity=np.pi,
                            **(lightInputs or {}))
    if lightSpace:
        light.GetColorAttr().SetColorSpace(lightSpace)
    return strip


def _Build(folder):
    """Cards that glow."""
    strip = Strip(folder / "cards.usda")
    for space in _SPACES:
        strip.Add(space, emissiveColor=_COLOR, **_BLACK)
        _Emission(strip.cards[space]).SetColorSpace(space)
    strip.Add("none", emissiveColor=_COLOR, **_BLACK)
    strip.Add("raw", emissiveColor=_COLOR, **_BLACK)
    _Emission(strip.cards["raw"]).SetColorSpace("raw")
    strip.Add("unknown", emissiveColor=_COLOR, **_BLACK)
    _Emission(strip.cards["unknown"]).SetColorSpace("noSuchSpace")
    strip.Add("ofMaterial", emissiveColor=_COLOR, **_BLACK)
    _Apply(strip.cards["ofMaterial"].material.GetPrim(), _AP1)
    strip.Add("ownBeforeMaterial", emissiveColor=_COLOR, **_BLACK)
    _Apply(strip.cards["ownBeforeMaterial"].material.GetPrim(), "lin_rec2020_scene")
    _Emission(strip.cards["ownBeforeMaterial"]).SetColorSpace(_AP1)
    strip.Add("interface", _FromInterface, emissiveColor=(0, 0, 0), **_BLACK)
    strip.Add("primvar", _WithPrimvar("constant", [_COLOR]), **_BLACK)
    strip.Add("primvarOfPoints", _WithPrimvar("vertex", [(9, 9, 9), _COLOR], [1, 1, 1, 1]), **_BLACK)
    strip.Add("constantX", _WithMaterialX, **_BLACK)
    pixels = np.tile(np.uint8([200, 90, 30]), (8, 8, 1))
    imageFile.WritePng(folder / "codes.png", pixels)
    imageFile.WriteExr(folder / "linear.exr", {c: np.full((8, 8), v) for c, v in zip("RGB", (0.75, 0.25, 0.125))})
    strip.Add("png", _WithImage("codes.png", sourceColorSpace="auto"), **_BLACK)
    strip.Add("exr", _WithImage("linear.exr", sourceColorSpace="auto"), **_BLACK)
    strip.Add("exrOfAp1", _WithImage("linear.exr", sourceColorSpace="lin_ap1"), **_BLACK)
    strip.Add("colorX", _WithImageX("codes.png", "ND_image_color3", "srgb_texture"), **_BLACK)
    strip.Add("linearX", _WithImageX("linear.exr", "ND_image_color3", "lin_rec709"), **_BLACK)
    strip.Add("vectorX", _WithImageX("codes.png", "ND_image_vector3", "srgb_texture"), **_BLACK)
    return strip


_LINEAR = _SPACES + ("none", "ofMaterial", "ownBeforeMaterial", "interface", "primvar", "primvarOfPoints", "constantX",
                     "png", "exrOfAp1", "colorX", "linearX")
_IMAGES = ("png", "exrOfAp1", "colorX", "linearX")
_HALF = 6e-4  # converted images are stored as halves, whose rounding the matrix scales
_NUMBERS = ("exr", "raw", "unknown", "vectorX")  # no colours: the same in any working space


@pytest.fixture(scope="module")
def rec709(tmp_path_factory):
    return _Build(tmp_path_factory.mktemp("rec709")).Render(samples=1)


@pytest.fixture(scope="module")
def acescg(tmp_path_factory):
    return _Build(tmp_path_factory.mktemp("acescg")).Render(samples=1, workingSpace="ACEScg")


def _Value(strip, name):
    pixels = strip.Pixels(name)[:, :3]
    assert np.ptp(pixels, axis=0).max() <= 1e-6
    return pixels.mean(0)


@pytest.mark.parametrize("space", _SPACES)
def test_constants_are_converted_as_by_openUsd(rec709, space):
    # Negative light of colours outside of Rec. 709 is black.
    expected = np.maximum(_Rec709(space), 0)
    assert _Value(rec709, space) == pytest.approx(expected, abs=3e-4 if space.startswith(("srgb", "g")) else 2e-5)


@pytest.mark.parametrize("name", ["ofMaterial", "ownBeforeMaterial", "interface", "primvar", "primvarOfPoints", "constantX"])
def test_spaces_are_found_where_they_are_said(rec709, name):
    assert _Value(rec709, name) == pytest.approx(_Rec709(_AP1), abs=2e-5)


@pytest.fixture(scope="module")
def lit(tmp_path_factory):
    return _BuildLit(tmp_path_factory.mktemp("lit")).Render(samples=1)


def test_displayColor_has_its_space(lit):
    assert _Value(lit, "white") == pytest.approx((1, 1, 1), abs=1e-5)
    assert _Value(lit, "displayColor") == pytest.approx(_Rec709(_AP1, _DARK), abs=2e-5)


def test_what_is_no_colour_stays_and_the_unknown_is_named(rec709):
    for name in ("none", "raw", "unknown"):
        assert _Value(rec709, name) == pytest.approx(_COLOR, abs=1e-7)
    lines = [line for line in rec709.picture.warnings if "noSuchSpace" in line]
    assert len(lines) == 1 and "emissiveColor" in lines[0]
    assert _Value(rec709, "vectorX") == pytest.approx(np.array([200, 90, 30]) / 255, abs=1e-6)
    assert _Value(rec709, "colorX") == pytest.approx(FromSrgb(np.array([200, 90, 30]) / 255), abs=1e-5)


@pytest.mark.parametrize("name", _LINEAR)
def test_pictures_of_two_working_spaces_differ_by_a_matrix(rec709, acescg, name):
    ours709, oursAp1 = _Value(rec709, name), _Value(acescg, name)
    if ours709.min() <= 0:  # cut off at the border of Rec. 709, which is narrower
        assert oursAp1 == pytest.approx(np.maximum(np.linalg.solve(_REC709_FROM_AP1, _Rec709(name)), 0), abs=1e-3)
    else:
        assert _REC709_FROM_AP1 @ oursAp1 == pytest.approx(ours709, abs=_HALF if name in _IMAGES else 2e-5)


@pytest.mark.parametrize("name", _NUMBERS)
def test_numbers_are_the_same_in_any_working_space(rec709, acescg, name):
    assert _Value(acescg, name).tolist() == _Value(rec709, name).tolist()


def test_what_is_said_to_be_of_the_working_space_is_not_touched(acescg):
    assert _Value(acescg, _AP1) == pytest.approx(_COLOR, abs=1e-7)
    assert _Value(acescg, "exrOfAp1") == pytest.approx((0.75, 0.25, 0.125), abs=1e-7)


def test_rec709_by_name_has_the_bits_of_the_default(tmp_path, rec709):
    named = _Build(tmp_path).Render(samples=1, workingSpace="lin_rec709")
    for name in _LINEAR + _NUMBERS:
        assert named.Pixels(name).tolist() == rec709.Pixels(name).tolist() or name in _IMAGES, name
    assert _Value(named, "png") == pytest.approx(_Value(rec709, "png"), abs=_HALF)


@pytest.mark.parametrize("lightSpace", ["", _AP1])
def test_light_meets_surfaces_in_the_working_space(tmp_path, lightSpace):
    """Each channel of the light times that of the surface, in either space."""
    light = np.array(_OTHER) if lightSpace else np.linalg.solve(_REC709_FROM_AP1, _OTHER)
    strip = _BuildLit(tmp_path, dict(color=_OTHER), lightSpace).Render(samples=1, workingSpace="ACEScg")
    assert _Value(strip, "displayColor709") == pytest.approx(light * np.linalg.solve(_REC709_FROM_AP1, _COLOR), abs=3e-5)
    assert _Value(strip, "displayColor") == pytest.approx(light * _DARK, abs=3e-5)
    assert _Value(strip, "white") == pytest.approx(light, abs=3e-5)


def test_colours_of_lights_have_their_space(tmp_path):
    strip = _BuildLit(tmp_path, dict(color=_DARK), _AP1).Render(samples=1)
    assert _Value(strip, "white") == pytest.approx(_Rec709(_AP1, _DARK), abs=2e-5)


def test_blackbodies_are_converted(tmp_path):
    inputs = dict(enableColorTemperature=True, colorTemperature=3000.0)
    glow = _Value(_BuildLit(tmp_path / "a", inputs).Render(samples=1), "white")
    ofAp1 = _Value(_BuildLit(tmp_path / "b", inputs).Render(samples=1, workingSpace="ACEScg"), "white")
    assert glow[0] > 1.5 * glow[2]
    assert _REC709_FROM_AP1 @ ofAp1 == pytest.approx(glow, rel=1e-4)


def _Dome(folder, file, space=None, **settings):
    stage = author.NewStage(folder / "dome.usda")
    dome = author.AddLight(stage, "/World/Dome", "Dome", textureFile=Sdf.AssetPath(f"./{file}"))
    if space:
        dome.GetTextureFileAttr().SetColorSpace(space)
    author.AddMesh(stage, "/World/Far", shapes.Plane(0.01, 0.01), translate=(0, -500, 0))
    author.AddCamera(stage)
    stage.GetRootLayer().Save()
    return ours.Render(folder / "dome.usda", 4, 3, samples=1, maxDepth=0, **settings).rgb.reshape(-1, 3)


def test_images_of_domes_are_colours(tmp_path):
    imageFile.WriteExr(tmp_path / "sky.exr", {c: np.full((8, 16), v) for c, v in zip("RGB", (0.75, 0.5, 0.25))})
    imageFile.WritePng(tmp_path / "sky.png", np.tile(np.uint8([200, 150, 60]), (8, 16, 1)))
    for file in ("sky.exr", "sky.png"):
        plain = _Dome(tmp_path, file)
        converted = _Dome(tmp_path, file, workingSpace="ACEScg")
        assert plain[0].tolist() == plain[-1].tolist()
        assert converted @ _REC709_FROM_AP1.T == pytest.approx(plain, abs=_HALF)
    assert _Dome(tmp_path, "sky.exr", _AP1) == pytest.approx(
        np.tile(_REC709_FROM_AP1 @ (0.75, 0.5, 0.25), (12, 1)), abs=5e-4)
    assert _Dome(tmp_path, "sky.exr", _AP1, workingSpace="ACEScg") == pytest.approx(np.tile((0.75, 0.5, 0.25), (12, 1)), abs=2e-4)


def test_spaces_of_prims_are_those_that_openUsd_finds():
    stage = Usd.Stage.CreateInMemory()
    paths = ["/A", "/A/B", "/A/B/C", "/A/D", "/E"]
    for path in paths:
        UsdGeom.Mesh.Define(stage, path).CreateDisplayColorAttr([Gf.Vec3f(1)])
    _Apply(stage.GetPrimAtPath("/A"), "lin_rec2020_scene")
    _Apply(stage.GetPrimAtPath("/A/B"), _AP1)
    stage.GetPrimAtPath("/A/D").GetAttribute("primvars:displayColor").SetColorSpace("g22_ap1_scene")
    colorSpaces.Forget()
    found = []
    for path in paths:
        attribute = stage.GetPrimAtPath(path).GetAttribute("primvars:displayColor")
        found.append(colorSpaces.ColorSpaceOf(attribute))
        assert found[-1] == Usd.ColorSpaceAPI.ComputeColorSpaceName(attribute, Usd.ColorSpaceHashCache()), path
    assert found == ["lin_rec2020_scene", _AP1, _AP1, "g22_ap1_scene", ""]


def test_an_edit_of_a_space_is_seen(tmp_path):
    import hdstream

    path = tmp_path / "edit.usda"
    stage = author.NewStage(path)
    mesh = author.AddMesh(stage, "/World/Card", shapes.Plane(2, 2), color=_COLOR, rotate=(90, 0, 0))
    author.AddLight(stage, "/World/Sun", "Distant", angle=0.0)
    author.AddCamera(stage, eye=(0, 0, 5))
    settings = dict(imageWidth=1, imageHeight=1, samples=1, maxDepth=0, noCache=True, pixelFilter="box", pixelFilterWidth=1.0)
    renderer = hdstream.Renderer(stage)
    plain = renderer.Render(**settings).aovs["color"][0, 0, :3]
    _Apply(stage.GetPrimAtPath("/World"), _AP1)
    edited = renderer.Render(**settings).aovs["color"][0, 0, :3]
    mesh.GetDisplayColorAttr().SetColorSpace("lin_rec709_scene")
    own = renderer.Render(**settings).aovs["color"][0, 0, :3]
    assert edited / plain == pytest.approx(np.clip(_Rec709(_AP1), 0, 1) / _COLOR, rel=1e-4)
    # The sun's white is that of ACEScg too, which is Rec. 709's after adaptation.
    assert own == pytest.approx(plain, rel=1e-5)


def test_glow_of_volumes_is_converted(tmp_path):
    """It only absorbs and glows, so that both pictures have the same paths."""
    stage = volumeCase.Stage(tmp_path / "s.usda", lights=())
    pictures = []
    for space in ("", "ACEScg"):
        ball = volumeCase.Volume(volumeCase.Grid(volumeCase.Cloud()), temperature=volumeCase.Grid(volumeCase.Cloud(24, 6)),
                                 absorption=1.0, kelvin=4000.0, blackbody=0.02)
        layers, *_ = volumeCase.Render(stage, {"/V": ball}, samples=4, workingSpace=space)
        pictures.append(layers["color"][..., :3].astype(float))
    assert pictures[0].max() > 0.1
    reddest = pictures[0].min(-1) > 1e-3 * pictures[0].max()  # where no channel was cut off
    assert reddest.sum() > 20
    assert (pictures[1] @ _REC709_FROM_AP1.T)[reddest] == pytest.approx(pictures[0][reddest], rel=2e-3)


def test_files_say_their_primaries_and_displays_show_the_same(tmp_path):
    import hdstream

    stage = author.NewStage(tmp_path / "glow.usda")
    author.AddMesh(stage, "/World/Card", shapes.Plane(20, 20), rotate=(90, 0, 0),
                   material=author.AddMaterial(stage, "/World/M", emissiveColor=(0.5, 0.4, 0.2), **_BLACK))
    author.AddCamera(stage, eye=(0, 0, 5))
    settings = stage.DefinePrim("/Render/Settings", "RenderSettings")
    stage.SetMetadata("renderSettingsPrimPath", "/Render/Settings")
    common = dict(imageWidth=2, imageHeight=2, samples=1, noCache=True)
    images = {"": hdstream.Renderer(stage).Render(**common),
              "ACEScg": hdstream.Renderer(stage).Render(workingSpace="ACEScg", **common)}
    settings.CreateAttribute("renderingColorSpace", _T.Token).Set(_AP1)
    images["settings"] = hdstream.Renderer(stage).Render(**common)
    assert images["settings"].aovs["color"].tolist() == images["ACEScg"].aovs["color"].tolist()
    primaries = {}
    for name, image in images.items():
        image.Write(tmp_path / f"{name}.exr")
        image.Write(tmp_path / f"{name}.png")
        data = (tmp_path / f"{name}.exr").read_bytes()
        at = data.index(b"chromaticities\0chromaticities\0") + len(b"chromaticities\0chromaticities\0") + 4
        primaries[name] = np.frombuffer(data[at:at + 32], "<f4")
        assert (b"hdStream:workingSpace" in data) == bool(name)
    assert primaries[""] == pytest.approx([0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329])
    assert primaries["ACEScg"] == pytest.approx([0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767])
    shown = _core.CompareImages(str(tmp_path / ".png"), str(tmp_path / "ACEScg.png"))
    assert not shown.error and max(layer.maxAbs for layer in shown.layers) <= 1.01 / 255
    linear = _core.CompareImages(str(tmp_path / ".exr"), str(tmp_path / "ACEScg.exr"))
    assert max(layer.maxAbs for layer in linear.layers) > 0.01  # the colour is none that both write alike
    with pytest.raises(_core.UsageError, match="noSuchSpace"):
        hdstream.Renderer(stage).Render(workingSpace="noSuchSpace", **common)


# Chromaticities of red, green, blue and white, gamma, linear bias.
_DEFINED = {
    "studio": ((0.7, 0.3), (0.2, 0.7), (0.14, 0.05), (0.3127, 0.329), 1.0, 0.0),
    "warm": ((0.66, 0.33), (0.28, 0.62), (0.15, 0.07), (0.345, 0.358), 1.0, 0.0),
    "power": ((0.66, 0.33), (0.28, 0.62), (0.15, 0.07), (0.3127, 0.329), 1.9, 0.0),
    "curve": ((0.66, 0.33), (0.28, 0.62), (0.15, 0.07), (0.3127, 0.329), 2.2, 0.05),
    "xyz": ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0), (0.3127, 0.329), 1.0, 0.0),
}


def _Define(prim, instance, name, numbers):
    definition = Usd.ColorSpaceDefinitionAPI.Apply(prim, instance)
    definition.CreateNameAttr(name)
    for create, pair in zip(("Red", "Green", "Blue"), numbers[:3]):
        getattr(definition, f"Create{create}ChromaAttr")(Gf.Vec2f(*pair))
    definition.CreateWhitePointAttr(Gf.Vec2f(*numbers[3]))
    definition.CreateGammaAttr(numbers[4])
    definition.CreateLinearBiasAttr(numbers[5])


@pytest.mark.skipif(not hasattr(Usd, "ColorSpaceDefinitionAPI"), reason="this usd-core knows no definitions")
def test_spaces_that_a_stage_defines_are_those_of_openUsd(tmp_path):
    """On ancestors and on the prim itself, by the name of the definition; OpenUSD's own names cannot be defined anew."""
    strip, glow = Strip(tmp_path / "defined.usda"), (0.5, 0.4, 0.3)
    world = strip.stage.GetPrimAtPath("/World") or strip.stage.DefinePrim("/World")
    for number, (name, numbers) in enumerate(_DEFINED.items()):
        _Define(world, f"d{number}", name, numbers)
        strip.Add(name, emissiveColor=glow, **_BLACK)
        _Emission(strip.cards[name]).SetColorSpace(name)
    _Define(world, "again", "lin_rec709_scene", _DEFINED["studio"])
    for name, space in (("builtIn", "lin_rec709_scene"), ("nearer", "studio"), ("ofPrim", ""), ("instance", "d0")):
        strip.Add(name, emissiveColor=glow, **_BLACK)
        if space:
            _Emission(strip.cards[name]).SetColorSpace(space)
    _Define(strip.cards["nearer"].material.GetPrim(), "own", "studio", _DEFINED["warm"])
    _Apply(strip.cards["ofPrim"].material.GetPrim(), "warm")
    _Define(world, "broken", "broken", ((0.3, 0.3), (0.3, 0.3), (0.3, 0.3), (0.3127, 0.329), 1.0, 0.0))
    strip.Add("broken", emissiveColor=glow, **_BLACK)
    _Emission(strip.cards["broken"]).SetColorSpace("broken")
    strip.Render(samples=1)
    rec709 = Gf.ColorSpace("lin_rec709_scene")
    for name in (*_DEFINED, "builtIn", "nearer", "ofPrim"):
        space = Usd.ColorSpaceAPI.ComputeColorSpace(_Emission(strip.cards[name]), None)
        expected = np.maximum(rec709.Convert(space, Gf.Vec3f(*glow)).GetRGB(), 0)
        assert _Value(strip, name) == pytest.approx(expected, abs=5e-4 if name in ("power", "curve") else 2e-5), name
    assert np.abs(_Value(strip, "nearer") - _Value(strip, "studio")).max() > 0.01
    for name in ("instance", "broken"):
        assert _Value(strip, name) == pytest.approx(glow, abs=1e-6)
    said = [line for line in strip.picture.warnings if "colour space" in line]
    assert len(said) == 2 and sum("'d0'" in line for line in said) == 1 and sum("cannot be computed with" in line for line in said) == 1
