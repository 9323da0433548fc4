# SPDX-License-Identifier: Apache-2.0
"""Render products of a UsdRenderSettings prim: which files they are, and what is in each (docs/command-line.md)."""

import dataclasses
from typing import Dict, List, Optional, Tuple

from pxr import Gf, UsdRender

from hdstream import _core
from hdstream.errors import UsageError
from hdstream.renderSettings import AovOfVar, FindRenderSettings, TargetsOf

_NAME_OF_VAR = "driver:parameters:aov:name"      # as hosts author them
_FORMAT_OF_VAR = "driver:parameters:aov:format"
_COMPRESSION = "driver:parameters:OpenEXR:compression"
_DWA_LEVEL = "driver:parameters:OpenEXR:dwaCompressionLevel"
_MOST_TILE = 65536
_LONGEST_NAME = 240  # of a layer: names of channels have 255 bytes, the end of which is the channel's own
_COMPRESSIONS = ("none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab")
_CHANGES_FLOATS = ("pxr24", "dwaa", "dwab")  # b44 and b44a keep them
_TILE_SIZE = "driver:parameters:OpenEXR:tileSize"  # ours
_HEADER_PREFIX = "driver:parameters:OpenEXR:"
# By what names OpenImageIO knows them; the latter is `comments` in the header.
_TEXTS_OF_PRODUCT = {"driver:parameters:artist": "Artist", "driver:parameters:comment": "ImageDescription"}
# What a deep file has beside its colour, under names of its own.
_IN_DEEP_FILES = ("color", "alpha", "depth", "cameraDepth")
# Attributes of a product that decide its picture: products that agree in all of them share a render.
_OF_PICTURE = ("resolution", "pixelAspectRatio", "aspectRatioConformPolicy", "dataWindowNDC", "disableDepthOfField",
               "disableMotionBlur", "instantaneousShutter")


@dataclasses.dataclass(frozen=True)
class Layer:
    """An AOV in a file."""

    aov: str
    name: str
    isHalf: bool


@dataclasses.dataclass
class Output:
    """A file and its layers."""

    file: str
    layers: Optional[Tuple[Layer, ...]]  # None: all that was rendered
    texts: Dict[str, str] = dataclasses.field(default_factory=dict)  # of an EXR's header, and its compression
    isDeep: bool = False
    tileSize: Tuple[int, int] = (0, 0)  # of an EXR; 0: scan lines


@dataclasses.dataclass
class Picture:
    """What one render makes: the product whose camera and size hold, and the product of each file."""

    product: str
    prims: List
    outputs: List[Output]  # their files are those of a frame

    def OutputsAt(self, timeCode):
        """The files of a frame. Raises UsageError for a product without a name."""
        outputs = []
        for prim, output in zip(self.prims, self.outputs):
            name = prim.GetAttribute("productName").Get(timeCode)
            if not name:
                raise UsageError(f"{prim.GetPath()}: the product has no productName to write to")
            outputs.append(dataclasses.replace(output, file=str(name)))
        return outputs


def IsMatte(aov):
    """Whether an AOV, or a layer, is a Cryptomatte: its floats are bits of ids and no numbers."""
    return aov.startswith("crypto_")


def HasProducts(stage, path, session):
    """Whether the render settings at `path`, or the stage's own, have products."""
    settings = FindRenderSettings(stage, path, session)
    return settings is not None and bool(TargetsOf(settings, "products", session))


def FindPictures(stage, path, session):
    """What the raster and the deep products of the render settings at `path`, or of the stage's own, need. Raises UsageError without any."""
    settings = FindRenderSettings(stage, path, session)
    if settings is None:
        raise UsageError("OUT is missing, and the stage has no render settings whose products could be written")
    pictures = {}
    for target in TargetsOf(settings, "products", session):
        prim = stage.GetPrimAtPath(target)
        if not prim or not prim.IsA(UsdRender.Product):
            session.Warn(str(target), "is no render product; left out")
            continue
        kind = prim.GetAttribute("productType").Get()
        if kind not in ("raster", "deepRaster"):
            session.Warn(str(target), f"products of type {kind!r} are not supported; left out")
            continue
        key = tuple(str(prim.GetAttribute(name).Get()) if prim.GetAttribute(name).HasAuthoredValue() else None
                    for name in _OF_PICTURE) + tuple(TargetsOf(prim, "camera", session))
        picture = pictures.setdefault(key, Picture(str(target), [], []))
        picture.prims.append(prim)
        layers = _LayersOf(stage, prim, session)
        if kind == "deepRaster":
            layers = _LayersOfDeep(layers, prim, session)
        texts = _TextsOf(prim, session)
        if any(IsMatte(layer.aov) for layer in layers) and texts.get("compression", "").startswith(_CHANGES_FLOATS):
            session.Warn(str(prim.GetPath()), f"{_COMPRESSION} {texts['compression']!r} would change the ids of its Cryptomattes; zip is used")
            texts["compression"] = "zip"
        picture.outputs.append(Output("", layers, texts, kind == "deepRaster", _TileSizeOf(prim, session)))
    if not pictures:
        raise UsageError(f"OUT is missing, and {settings.GetPath()} has no products")
    return list(pictures.values())


def _LayersOfDeep(layers, product, session):
    """The colour, which a deep file holds alone."""
    left = [layer.aov for layer in layers if layer.aov not in _IN_DEEP_FILES]
    if left:
        session.Warn(str(product.GetPath()), f"a deep product holds colour and depth alone; left out: {', '.join(left)}")
    return tuple(layer for layer in layers if layer.aov == "color") or (Layer("color", "color", False),)


def _TileSizeOf(product, session):
    """One number or two."""
    value = product.GetAttribute(_TILE_SIZE).Get() if product.GetAttribute(_TILE_SIZE) else None
    if value is None:
        return (0, 0)
    size = (value, value) if isinstance(value, int) else tuple(value) if isinstance(value, Gf.Vec2i) else ()
    if len(size) != 2 or not all(1 <= side <= _MOST_TILE for side in size):
        session.Warn(str(product.GetPath()), f"{_TILE_SIZE} {value!r} is no size of 1 to {_MOST_TILE} pixels; scan lines are "
                     "written")
        return (0, 0)
    return size


def _TextsOf(product, session):
    """What a product says of the header of its EXR file, and of its compression."""
    texts = {}
    for attribute in product.GetAuthoredAttributes():
        name, value = attribute.GetName(), attribute.Get()
        if name in (_COMPRESSION, _DWA_LEVEL, _TILE_SIZE) or value is None:
            continue
        if name in _TEXTS_OF_PRODUCT:
            texts[_TEXTS_OF_PRODUCT[name]] = str(value)
        elif name.startswith(_HEADER_PREFIX):
            texts[name[len(_HEADER_PREFIX):]] = str(value)
    compression = product.GetAttribute(_COMPRESSION).Get() if product.GetAttribute(_COMPRESSION) else None
    if compression and compression not in _COMPRESSIONS:
        session.Warn(str(product.GetPath()), f"{_COMPRESSION} {compression!r} is none of {', '.join(_COMPRESSIONS)}; zip is used")
    elif compression:
        level = product.GetAttribute(_DWA_LEVEL).Get() if product.GetAttribute(_DWA_LEVEL) else None
        isLevel = compression.startswith("dwa") and isinstance(level, (int, float))
        texts["compression"] = f"{compression}:{level:g}" if isLevel else str(compression)
    return texts


def _LayersOf(stage, product, session):
    layers = {}
    for target in TargetsOf(product, "orderedVars", session):
        var = stage.GetPrimAtPath(target)
        aov = AovOfVar(var, target, session)
        if aov is None:
            continue
        authored = var.GetAttribute(_NAME_OF_VAR).Get() if var.GetAttribute(_NAME_OF_VAR) else None
        if not authored and aov.startswith("lpe:"):
            authored = var.GetName()  # the name that husk gives a layer; expressions are none to type
        if len(str(authored or "").encode()) > _LONGEST_NAME:
            session.Warn(str(target), f"the name of its layer has more than {_LONGEST_NAME} bytes, which no EXR file holds; {aov!r} is used")
            authored = None
        kind = var.GetAttribute(_FORMAT_OF_VAR).Get() if var.GetAttribute(_FORMAT_OF_VAR) else var.GetAttribute("dataType").Get()
        isHalf = str(kind).startswith("half") or (str(kind).startswith("color") and str(kind).endswith("h"))
        if isHalf and IsMatte(aov):
            session.Warn(str(target), "ids of a Cryptomatte are 32 bits, which no half holds; its layers are written as floats")
            isHalf = False
        for name in _core.LayersOf(aov):
            layer = Layer(name, str(authored) if authored and name == aov else name, isHalf)
            if len(layer.name.encode()) > _LONGEST_NAME:
                session.Warn(str(target), f"its layer {layer.name[:40]!r}... has a name of more than {_LONGEST_NAME} bytes; left out")
            elif layer.name in layers:
                session.Warn(str(target), f"a second layer {layer.name!r} of {product.GetPath()}; left out")
            else:
                layers[layer.name] = layer
    return tuple(layers.values()) or (Layer("color", "color", False),)
