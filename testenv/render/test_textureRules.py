# SPDX-License-Identifier: Apache-2.0
"""UsdUVTexture, UsdPrimvarReader and UsdTransform2d by the rules of the UsdPreviewSurface text, version 2.5: a card for
each rule, all in one picture. docs/shading.md lists them.

A card glows with what it reads and reflects nothing. Where its look-up must be exact all of it has the coordinates of
one texel's centre, so that a pixel is that texel; images are such that the codec keeps them (flat, or 16 codes a
channel), but for 16 bits in sRGB, which are kept as halves.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from pxr import Gf, Sdf

pytest.importorskip("hdstream._core")

from cardStrip import Strip
from stages import author, imageFile
from textureCases import AddReader, AddTexture, AddTransform, Connect, FromSrgb

_T = Sdf.ValueTypeNames
_STEP = np.arange(16).reshape(4, 4)
_RAMP = np.stack([100 + _STEP, 200 + 15 - _STEP, 20 + _STEP * 7 % 16], -1).astype(np.uint8)  # row 0 on top
_RGBA = np.array([51, 102, 204, 64])
_DEEP = np.array([4660, 22136, 39612])
_FLOATS = np.array([0.25, 1.5, 3.0, 0.625])
_FALLBACK = (0.25, 0.5, 0.75, 0.125)
_TILES = {1001: (200, 10, 30), 1002: (20, 110, 40), 1010: (30, 60, 150), 1011: (90, 70, 50), 1100: (10, 210, 60),
          1101: (250, 250, 250)}


@dataclass
class Rule:
    """A card, and the colour that it must have."""

    expected: np.ndarray
    build: object
    st: tuple | None = None
    atol: float = 1e-5


_RULES: dict[str, Rule] = {}


def _At(column, row) -> tuple:
    """Coordinates of the centre of a texel of the ramp, also outside of it."""
    return (column + 0.5) / 4, 1 - (row + 0.5) / 4


def _Ramp(column, row) -> np.ndarray:
    return FromSrgb(_RAMP[row, column] / 255)


def _Look(name, expected, output="rgb", st=_At(1, 1), atol=1e-5, **inputs) -> None:
    """A rule of one UsdUVTexture; `inputs` as AddTexture takes them."""
    def Build(card):
        Connect(card.material, "emissiveColor", AddTexture(card.material, "T", **inputs), output)

    _RULES[name] = Rule(np.broadcast_to(expected, 3), Build, st, atol)


def _Flat(pixel, dtype=np.uint8) -> np.ndarray:
    return np.broadcast_to(np.atleast_1d(pixel), (4, 4, np.size(pixel))).astype(dtype)


def _WriteImages(folder) -> None:
    png = lambda name, image, **more: imageFile.WritePng(f"{folder}/{name}.png", image, **more)
    exr = lambda name, channels, **more: imageFile.WriteExr(
        f"{folder}/{name}.exr", {c: np.full((4, 4), v, np.float32) for c, v in channels.items()}, half=False, **more)
    png("ramp", _RAMP)
    png("wraps", _RAMP, texts={"wrapS": "repeat", "wrapT": "mirror"})
    for channels, name in ((_RGBA[:1], "gray"), (_RGBA[[0, 3]], "grayAlpha"), (_RGBA[:3], "rgb"), (_RGBA, "rgba")):
        png(name, _Flat(channels))
    png("deepGray", _Flat(_DEEP[:1], np.uint16))
    png("deep", _Flat(_DEEP, np.uint16))
    png("rgbGamma1", _Flat(_RGBA[:3]), gamma=1.0)
    png("deepGamma", _Flat(_DEEP, np.uint16), gamma=1 / 2.2)
    png("grayGamma", _Flat(_RGBA[:1]), gamma=1 / 2.2)
    for number, color in _TILES.items():
        png(f"tile.{number}", _Flat(color))
    exr("rgb", dict(zip("RGB", _FLOATS)))
    exr("rgba", dict(zip("RGBA", _FLOATS)))
    exr("gray", {"height": _FLOATS[1]})
    exr("grayAlpha", {"R": _FLOATS[1], "G": _FLOATS[3]})
    dot = np.full((4, 4), 0.25, np.float32)
    dot[2, 2] = 0.75
    for name, texts in (("wrapModes", dict(wrapmodes="periodic,mirror")), ("wrapST", dict(wrapS="repeat", wrapT="mirror"))):
        imageFile.WriteExr(f"{folder}/{name}.exr", dict.fromkeys("RGB", dot), half=False, texts=texts)


# --- UsdUVTexture ------------------------------------------------------------------------------------


def _AddFileRules() -> None:
    _Look("file", _Ramp(1, 1), file="./ramp.png")
    _Look("fileEmpty", _FALLBACK[:3], fallback=_FALLBACK)

    def FromInterface(card):
        public = card.material.CreateInput("image", _T.Asset)
        public.Set("./ramp.png")
        texture = AddTexture(card.material, "T")
        texture.CreateInput("file", _T.Asset).ConnectToSource(public)
        Connect(card.material, "emissiveColor", texture, "rgb")

    _RULES["fileOfInterface"] = Rule(_Ramp(1, 1), FromInterface, _At(1, 1))
    _Look("stLowerLeft", _Ramp(0, 3), st=(0.125, 0.125), file="./ramp.png")
    _Look("stLowerRight", _Ramp(3, 3), st=(0.875, 0.125), file="./ramp.png")
    _Look("stUpperLeft", _Ramp(0, 0), st=(0.125, 0.875), file="./ramp.png")
    _Look("stUpperRight", _Ramp(3, 0), st=(0.875, 0.875), file="./ramp.png")

    def WithoutSt(card):
        texture = AddTexture(card.material, "T", file="./ramp.png", wrapS="clamp", wrapT="clamp")
        texture.GetInput("st").ClearSources()
        Connect(card.material, "emissiveColor", texture, "rgb")

    _RULES["stDefault"] = Rule(_Ramp(0, 3), WithoutSt, _At(1, 1))
    for number, st in ((1001, (0.5, 0.5)), (1002, (1.5, 0.5)), (1010, (9.5, 0.5)), (1011, (0.5, 1.5)), (1100, (9.5, 9.5))):
        _Look(f"udim{number}", np.array(_TILES[number]) / 255, st=st, file="./tile.<UDIM>.png", sourceColorSpace="raw")
    for name, st in (("Hole", (2.5, 0.5)), ("RightOf10", (10.5, 0.5)), ("Negative", (-0.5, 0.5)), ("Below", (0.5, -0.5)),
                     ("1101", (0.5, 10.5))):
        _Look(f"udim{name}", _FALLBACK[:3], st=st, file="./tile.<UDIM>.png", fallback=_FALLBACK)
    _Look("udimDoesNotWrap", np.array(_TILES[1002]) / 255, st=(1.0, 0.5), file="./tile.<UDIM>.png", sourceColorSpace="raw",
          wrapS="black", wrapT="black")


def _AddWrapRules() -> None:
    texels = {"clamp": (0, 3), "repeat": (2, 1), "mirror": (1, 2), "black": (None, None)}  # of columns -2 and 5
    for mode, found in texels.items():
        for side, index, texel in (("Before", -2, found[0]), ("Behind", 5, found[1])):
            value = lambda x, y: 0.0 if texel is None else _Ramp(x, y)
            _Look(f"wrapS_{mode}{side}", value(texel, 1), st=_At(index, 1), file="./ramp.png", wrapS=mode, wrapT="clamp")
            _Look(f"wrapT_{mode}{side}", value(1, texel), st=_At(1, index), file="./ramp.png", wrapS="clamp", wrapT=mode)
    _Look("wrap_mirrorOfMirror", _Ramp(1, 2), st=_At(9, -6), file="./ramp.png", wrapS="mirror", wrapT="mirror")
    _Look("wrap_independent", _Ramp(2, 2), st=_At(-2, 5), file="./ramp.png", wrapS="repeat", wrapT="mirror")
    _Look("wrap_blackInside", _Ramp(3, 0), st=_At(3, 0), file="./ramp.png", wrapS="black", wrapT="black")
    _Look("wrap_blackAlpha", 0.0, "a", st=_At(5, 1), file="./ramp.png", wrapS="black", wrapT="black")
    _Look("wrap_blackScaled", 0.375, st=_At(5, 1), file="./ramp.png", wrapS="black", wrapT="black", scale=(2, 2, 2, 2),
          bias=(0.375,) * 4)
    _Look("wrap_defaultIsBlack", 0.0, st=_At(5, 1), file="./ramp.png", wrapS=None, wrapT=None)
    metadata = dict(wrapS="useMetadata", wrapT="useMetadata")
    _Look("wrap_metadataNone", 0.0, st=_At(5, 1), file="./ramp.png", **metadata)
    _Look("wrap_metadataOfText", _Ramp(2, 2), st=_At(-2, 5), file="./wraps.png", **metadata)
    _Look("wrap_metadataByDefault", _Ramp(2, 2), st=_At(-2, 5), file="./wraps.png", wrapS=None, wrapT=None)
    _Look("wrap_metadataOverruled", _Ramp(0, 2), st=_At(-2, 5), file="./wraps.png", wrapS="clamp", wrapT=None)
    _Look("wrap_metadataOfExr", 0.75, st=_At(-2, 5), file="./wrapModes.exr", **metadata)
    _Look("wrap_metadataByNames", 0.75, st=_At(-2, 5), file="./wrapST.exr", **metadata)


def _AddValueRules() -> None:
    unit, alpha = _RGBA[:3] / 255, _RGBA[3] / 255
    _Look("fallback", _FALLBACK[:3], file="./missing.png", fallback=_FALLBACK, scale=(2, 2, 2, 2), bias=(1, 1, 1, 1))
    _Look("fallbackAlpha", _FALLBACK[3], "a", file="./missing.png", fallback=_FALLBACK)
    _Look("fallbackDefault", 0.0, file="./missing.png")
    _Look("fallbackDefaultAlpha", 1.0, "a", file="./missing.png")
    scale, bias = (0.5, 2.0, -1.0, 0.75), (0.25, 0.125, 1.0, 0.5)
    for output, expected in (("rgb", unit * scale[:3] + bias[:3]), ("a", alpha * scale[3] + bias[3])):
        _Look(f"scaleAndBias_{output}", expected, output, file="./rgba.png", sourceColorSpace="raw", scale=scale, bias=bias)
    _Look("scaleAndBias_missingAlpha", scale[3] + bias[3], "a", file="./rgb.png", scale=scale, bias=bias)
    _Look("scaleAndBias_afterDecoding", FromSrgb(unit) * 2 + 0.5, file="./rgb.png", scale=(2,) * 4, bias=(0.5,) * 4)
    for i, output in enumerate("rgba"):
        _Look(f"output_{output}", _RGBA[i] / 255, output, file="./rgba.png", sourceColorSpace="raw")
    _Look("output_rgb", unit, file="./rgba.png", sourceColorSpace="raw")
    _Look("integers16", _DEEP / 65535, file="./deep.png", sourceColorSpace="raw")
    _Look("floats", _FLOATS[:3], file="./rgb.exr")
    for kind, gray, second in (("png", _RGBA[0] / 255, alpha), ("exr", _FLOATS[1], _FLOATS[3])):
        more = dict(sourceColorSpace="raw")
        _Look(f"oneChannel_rgb_{kind}", gray, file=f"./gray.{kind}", **more)
        _Look(f"oneChannel_b_{kind}", gray, "b", file=f"./gray.{kind}", **more)
        _Look(f"oneChannel_a_{kind}", 1.0, "a", file=f"./gray.{kind}", **more)
        _Look(f"twoChannels_rgb_{kind}", gray, file=f"./grayAlpha.{kind}", **more)
        _Look(f"twoChannels_g_{kind}", gray, "g", file=f"./grayAlpha.{kind}", **more)
        _Look(f"twoChannels_a_{kind}", second, "a", file=f"./grayAlpha.{kind}", **more)
        _Look(f"threeChannels_a_{kind}", 1.0, "a", file=f"./rgb.{kind}", **more)
    _Look("fourChannels_a_exr", _FLOATS[3], "a", file="./rgba.exr")


def _AddColorSpaceRules() -> None:
    unit, deep = _RGBA[:3] / 255, _DEEP / 65535
    half = 2.0**-10  # relative to 1: what is kept as halves
    _Look("raw", unit, file="./rgb.png", sourceColorSpace="raw")
    _Look("sRGB", FromSrgb(unit), file="./rgb.png", sourceColorSpace="sRGB")
    _Look("sRGB_gray", FromSrgb(unit[0]), file="./gray.png", sourceColorSpace="sRGB")
    _Look("sRGB_16", FromSrgb(deep), atol=half, file="./deep.png", sourceColorSpace="sRGB")
    _Look("sRGB_floats", FromSrgb(_FLOATS[0]), "r", atol=half, file="./rgb.exr", sourceColorSpace="sRGB")
    _Look("sRGB_alphaIsLinear", _RGBA[3] / 255, "a", file="./rgba.png", sourceColorSpace="sRGB")
    _Look("sRGB_alphaOfTwoIsLinear", _RGBA[3] / 255, "a", file="./grayAlpha.png", sourceColorSpace="sRGB")
    _Look("sRGB_grayBesideAlpha", FromSrgb(unit[0]), file="./grayAlpha.png", sourceColorSpace="sRGB")
    for name, expected, file in (
            ("8x3", FromSrgb(unit), "rgb.png"), ("8x4", FromSrgb(unit), "rgba.png"), ("8x1", unit[0], "gray.png"),
            ("8x2", unit[0], "grayAlpha.png"), ("16x3", deep, "deep.png"), ("16x1", deep[0], "deepGray.png"),
            ("float", _FLOATS[:3], "rgb.exr"), ("metadataLinear", unit, "rgbGamma1.png"),
            ("metadataSrgb1", FromSrgb(unit[0]), "grayGamma.png"), ("metadataSrgb16", FromSrgb(deep), "deepGamma.png")):
        _Look(f"auto_{name}", expected, atol=half if name == "metadataSrgb16" else 1e-5, file=f"./{file}",
              sourceColorSpace="auto")
    _Look("auto_isDefault", FromSrgb(unit), file="./rgb.png")


# --- UsdPrimvarReader --------------------------------------------------------------------------------


def _Read(name, expected, kind, valueType, primvar=None, value=None, fallback=None, prefix="") -> None:
    """A rule of one reader, of the primvar "data" or of what `primvar` names; `prefix` begins its id."""
    def Build(card):
        if value is not None:
            author.AddPrimvar(card.mesh, "data", valueType.arrayType, "constant", [value])
        reader = AddReader(card.material, "R", kind, "data" if primvar is None else primvar)
        reader.GetIdAttr().Set(prefix + reader.GetIdAttr().Get())
        if fallback is not None:
            reader.CreateInput("fallback", valueType).Set(fallback)
        reader.CreateOutput("result", valueType)
        Connect(card.material, "emissiveColor", reader, "result")

    _RULES[name] = Rule(np.broadcast_to(expected, 3), Build)


def _AddReaderRules() -> None:
    triple, quad = Gf.Vec3f(0.5, 0.25, 2.0), Gf.Vec4f(0.5, 0.25, 2.0, 0.75)
    other = Gf.Vec3f(0.125, 0.375, 0.625)
    types = {"float": (_T.Float, 0.625, 0.375), "int": (_T.Int, 3, 2), "float3": (_T.Float3, triple, other),
             "float4": (_T.Float4, quad, Gf.Vec4f(0.125, 0.375, 0.625, 1.0)), "normal": (_T.Normal3f, triple, other),
             "point": (_T.Point3f, triple, other), "vector": (_T.Vector3f, triple, other)}
    for kind, (valueType, value, fallback) in types.items():
        rgb = lambda v: tuple(v)[:3] if hasattr(v, "__len__") else v
        _Read(f"reader_{kind}", rgb(value), kind, valueType, value=value, fallback=fallback)
        _Read(f"reader_{kind}_fallback", rgb(fallback), kind, valueType, fallback=fallback)
        _Read(f"reader_{kind}_default", 0.0, kind, valueType)
    _Read("reader_float3_ofColor", tuple(triple), "float3", _T.Color3f, value=triple)
    _Read("reader_float4_ofColor", tuple(triple), "float4", _T.Color4f, value=quad)
    _Read("reader_varnameEmpty", tuple(other), "float3", _T.Float3, primvar="", value=triple, fallback=other)

    def Float2(card, fallback=None, **how):
        texture = AddTexture(card.material, "T", file="./ramp.png", wrapS="clamp", wrapT="clamp", st=None)
        reader = AddReader(card.material, "R", "float2", how.get("primvar", "uv"))
        if fallback is not None:
            reader.CreateInput("fallback", _T.Float2).Set(Gf.Vec2f(*fallback))
        if how.get("interface"):
            public = card.material.CreateInput("frame:stPrimvarName", how["interface"])
            public.Set("uv")
            reader.GetInput("varname").ConnectToSource(public)
        texture.GetInput("st").ConnectToSource(reader.CreateOutput("result", _T.Float2))
        author.AddPrimvar(card.mesh, "uv", _T.TexCoord2fArray, "constant", [Gf.Vec2f(*_At(2, 0))])
        Connect(card.material, "emissiveColor", texture, "rgb")

    _RULES["reader_float2"] = Rule(_Ramp(2, 0), lambda card: Float2(card, (0.5, 0.5)))
    _RULES["reader_float2_fallback"] = Rule(_Ramp(1, 2), lambda card: Float2(card, _At(1, 2), primvar="none"))
    _RULES["reader_float2_default"] = Rule(_Ramp(0, 3), lambda card: Float2(card, primvar="none"))
    _RULES["reader_varnameOfInterface"] = Rule(_Ramp(2, 0), lambda card: Float2(card, primvar="x", interface=_T.String))
    _RULES["reader_varnameIsToken"] = Rule(_Ramp(2, 0), lambda card: Float2(card, primvar="x", interface=_T.Token))

    for kind, valueType in (("string", _T.String), ("matrix", _T.Matrix4d)):
        _Read(f"reader_{kind}_showsNothing", 0.0, kind, valueType)


# --- UsdTransform2d ----------------------------------------------------------------------------------


def _Transform(name, texel, st=None, **inputs) -> None:
    """A look-up at transformed coordinates that hits a texel's centre."""
    def Build(card):
        source = AddReader(card.material, "R", "float2", "st")
        transform = AddTransform(card.material, "X", source, **inputs)
        for key in ("rotation", "scale", "translation"):
            if key not in inputs:  # not even its default is authored
                transform.GetPrim().RemoveProperty("inputs:" + key)
        if st is None:
            transform.GetInput("in").ClearSources()
        Connect(card.material, "emissiveColor", AddTexture(card.material, "T", st=transform, file="./ramp.png"), "rgb")

    _RULES[name] = Rule(_Ramp(*texel), Build, st or _At(3, 3))


def _AddTransformRules() -> None:
    _Transform("transform_default", (2, 1), st=_At(2, 1))
    _Transform("transform_inDefault", (2, 1), translation=_At(2, 1))
    _Transform("transform_scale", (2, 1), st=(5 / 16, 5 / 4), scale=(2, 0.5))
    _Transform("transform_translation", (2, 1), st=(0.125, 0.375), translation=(0.5, 0.25))
    # (s, t) = (5/8, 1/8) turned counter-clockwise by 90 degrees: (-1/8, 5/8).
    _Transform("transform_rotation", (3, 1), st=(0.625, 0.125), rotation=90.0)
    _Transform("transform_rotationNegative", (0, 2), st=(0.625, 0.125), rotation=-90.0)  # (1/8, -5/8)
    # Scaled (3/8, 1/8), turned (-1/8, 3/8), moved (5/8, 5/8); any other order ends elsewhere.
    _Transform("transform_order", (2, 1), st=(0.125, 0.0625), scale=(3, 2), rotation=90.0, translation=(0.75, 0.25))


# --- MaterialX's definitions of these nodes ----------------------------------------------------------


def _AddMaterialXRules() -> None:
    """What differs in the library's usd_preview_surface.mtlx: names of types and of one wrap mode, and defaults."""
    def Texture(name, texel, st=None, space="", reader=False, expected=None, **inputs):
        def Build(card):
            texture = AddTexture(card.material, "T", **{"file": "./ramp.png", "wrapS": None, "wrapT": None, **inputs})
            texture.GetIdAttr().Set("ND_UsdUVTexture_23")
            texture.GetInput("st").ClearSources()
            if space:
                texture.GetInput("file").GetAttr().SetColorSpace(space)
            if reader:
                source = AddReader(card.material, "R", "vector2", "uv")
                source.GetIdAttr().Set("ND_UsdPrimvarReader_vector2")
                texture.GetInput("st").ConnectToSource(source.CreateOutput("out", _T.Float2))
                author.AddPrimvar(card.mesh, "uv", _T.TexCoord2fArray, "constant", [Gf.Vec2f(*_At(*texel))])
            Connect(card.material, "emissiveColor", texture, "rgb")

        _RULES[f"materialX_{name}"] = Rule(_Ramp(*texel) if expected is None else expected, Build, st)

    Texture("stDefault", (2, 1), st=_At(2, 1))
    Texture("readerOfSt", (1, 2), st=_At(0, 0), reader=True)
    Texture("wrapDefault", (2, 1), st=_At(-2, 5))
    Texture("wrapPeriodic", (2, 2), st=_At(-2, 5), wrapS="periodic", wrapT="mirror")
    Texture("wrapClamp", (0, 1), st=_At(-2, 5), wrapS="clamp", wrapT="periodic")
    unit = _RGBA[:3] / 255
    Texture("srgb", None, st=_At(1, 1), space="srgb_texture", file="./gray.png", expected=np.full(3, FromSrgb(unit[0])))
    Texture("linear", None, st=_At(1, 1), space="lin_rec709", file="./rgb.png", expected=unit)

    triple = Gf.Vec3f(0.5, 0.25, 2.0)
    types = {"float": (_T.Float, 0.625, 0.375), "integer": (_T.Int, 3, 2), "boolean": (_T.Bool, True, False),
             "vector3": (_T.Float3, triple, Gf.Vec3f(0.125, 0.375, 0.625)),
             "vector4": (_T.Float4, Gf.Vec4f(0.5, 0.25, 2.0, 0.75), Gf.Vec4f(0.125, 0.375, 0.625, 1.0))}
    for kind, (valueType, value, fallback) in types.items():
        rgb = lambda v: tuple(v)[:3] if hasattr(v, "__len__") else float(v)
        _Read(f"materialX_{kind}", rgb(value), kind, valueType, value=value, fallback=fallback, prefix="ND_")
        _Read(f"materialX_{kind}Fallback", rgb(fallback), kind, valueType, fallback=fallback, prefix="ND_")


for _add in (_AddFileRules, _AddWrapRules, _AddValueRules, _AddColorSpaceRules, _AddReaderRules, _AddTransformRules,
             _AddMaterialXRules):
    _add()


# --- Tests -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def Cards(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rules")
    _WriteImages(folder)
    strip = Strip(folder / "stage.usda")
    for name, rule in _RULES.items():
        strip.Add(name, rule.build, rule.st, diffuseColor=(0.0, 0.0, 0.0), metallic=1.0)
    author.AddLight(strip.stage, "/World/Dark", "Sphere", dict(translate=(0, 50, 0)), intensity=0.0, radius=0.01)
    return strip.Render(samples=4)


@pytest.mark.parametrize("name", _RULES)
def test_rule(name, Cards):
    pixels, rule = Cards.Pixels(name)[:, :3], _RULES[name]
    np.testing.assert_allclose(pixels, np.broadcast_to(rule.expected, pixels.shape), atol=rule.atol)


def test_only_what_cannot_be_read_is_warned_of(Cards):
    unreadable = [name for name in _RULES if name.startswith("fallback") or name in (
        "fileEmpty", "reader_varnameEmpty", "reader_string_showsNothing", "reader_matrix_showsNothing")]
    numbers = sorted(Cards.cards[name].number for name in unreadable)
    assert sorted(int(line.split(":")[0].removeprefix("/World/M")) for line in Cards.picture.warnings) == numbers


def test_tiles_do_not_bleed_into_each_other(tmp_path):
    """Minified, at the border of two tiles: the same noise in both keeps its mean in every column, in tiles of whatever
    size; a tile that is black leaves its neighbour alone."""
    rng = np.random.default_rng(6)
    means = {}
    for number, size in ((1001, 256), (1002, 200)):
        image = rng.random((size, size, 3)).astype(np.float32) * 0.5 + 0.25
        means[number] = image.mean((0, 1))
        imageFile.WriteExr(f"{tmp_path}/a.{number}.exr", dict(zip("RGB", np.moveaxis(image, -1, 0))))
    imageFile.WriteExr(f"{tmp_path}/a.1003.exr", dict.fromkeys("RGB", np.zeros((64, 64), np.float32)))
    strip = Strip(tmp_path / "a.usda")
    build = lambda card: Connect(card.material, "emissiveColor", AddTexture(card.material, "T", file="./a.<UDIM>.exr"), "rgb")
    # The inner two pixels of a card show s from its quarter to its three quarters: a border in the middle of it.
    for name, low in (("equal", 0.0), ("black", 1.0), ("inside", 0.25)):
        card = strip.Add(name, build, diffuseColor=(0.0, 0.0, 0.0), metallic=1.0)
        st = np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) * (2.0 if name != "inside" else 0.5, 1.0) + (low, 0)
        author.AddPrimvar(card.mesh, "st", _T.TexCoord2fArray, "vertex", [Gf.Vec2f(*map(float, row)) for row in st])
    author.AddLight(strip.stage, "/World/Dark", "Sphere", dict(translate=(0, 50, 0)), intensity=0.0, radius=0.01)
    strip.Render(samples=256)
    row = lambda name: strip.Pixels(name)[:, :3].reshape(2, 2, 3).mean(0)
    np.testing.assert_allclose(row("equal"), np.stack([means[1001], means[1002]]), atol=0.02)
    np.testing.assert_allclose(row("black"), np.stack([means[1002], 0 * means[1002]]), atol=0.02)
    np.testing.assert_allclose(row("inside"), np.stack([means[1001]] * 2), atol=0.02)
