# SPDX-License-Identifier: Apache-2.0
"""Scene properties made from the core's table of settings: names, defaults, limits and tooltips are the table's."""

import json
import math
import pathlib

import bpy

TABLE = json.loads((pathlib.Path(__file__).absolute().parent / "settings.json").read_text(encoding="utf-8"))
# Blender decides these: Film > Transparent, Film > Exposure, and a camera that sees no lamp.
BLENDERS = frozenset({"opaqueBackground", "exposure", "lightsVisible"})
ROWS = tuple(row for row in TABLE if row["name"] not in BLENDERS)
# What may change the picture may differ between viewport and final render; the rest is of the machine.
PICTURE_GROUPS = ("Quality", "Picture")
_LARGEST = 2**31 - 1  # of Blender's whole numbers


def IsOfPicture(row):
    return row["group"] in PICTURE_GROUPS


def _Property(row):
    kind, default = row["kind"], row["default"]
    words = {"name": row["label"], "description": row["description"]}
    if kind == "Bool":
        return bpy.props.BoolProperty(default=default, **words)
    if kind == "Choice":
        return bpy.props.EnumProperty(items=[(choice, choice, "") for choice in row["choices"]], default=default, **words)
    if kind == "Integer":
        return bpy.props.IntProperty(default=default, min=int(row["minimum"]), max=min(int(row["maximum"]), _LARGEST), **words)
    if kind == "Number":
        return bpy.props.FloatProperty(default=default, min=row["minimum"], max=row["maximum"], precision=4, **words)
    # Sizes are text: no whole number of Blender's holds them, and the plug-in takes 2G and 25 %.
    return bpy.props.StringProperty(default=str(default), **words)


def _Group(name, rows):
    properties = {row["name"]: _Property(row) for row in rows}
    return type(name, (bpy.types.PropertyGroup,), {"__annotations__": properties})


StreamPictureSettings = _Group("StreamPictureSettings", [row for row in ROWS if IsOfPicture(row)])
StreamMachineSettings = _Group("StreamMachineSettings", [row for row in ROWS if not IsOfPicture(row)])


class StreamSceneSettings(bpy.types.PropertyGroup):
    final: bpy.props.PointerProperty(type=StreamPictureSettings)
    viewport: bpy.props.PointerProperty(type=StreamPictureSettings)
    machine: bpy.props.PointerProperty(type=StreamMachineSettings)


class StreamViewLayerSettings(bpy.types.PropertyGroup):
    use_denoising_data: bpy.props.BoolProperty(
        name="Denoising Data", default=False,
        description="Store what compositing nodes denoise with: the first hit's normal and albedo, and the picture before it "
                    "was denoised")


def Values(scene, isViewport):
    """What the plug-in is to use, by name: all of it, since a value that is as before changes nothing."""
    groups = scene.hdstream
    picture = groups.viewport if isViewport else groups.final
    values = {}
    for row in ROWS:
        value = getattr(picture if IsOfPicture(row) else groups.machine, row["name"])
        if row["kind"] == "Number":
            value = float(f"{value:.7g}")  # Blender keeps single precision
        elif row["kind"] == "Bytes" and value.isdigit():
            value = int(value)
        values[row["name"]] = value
    isOpaque = not scene.render.film_transparent
    values["opaqueBackground"] = isOpaque
    values["domeVisible"] = values["domeVisible"] and isOpaque
    values["lightsVisible"] = False
    values["exposure"] = _FilmStops(scene)
    return values


def _FilmStops(scene):
    """Cycles' exposure of the film, a factor that may be 0. Blender without Cycles has none."""
    least = next(row["minimum"] for row in TABLE if row["name"] == "exposure")
    factor = getattr(getattr(scene, "cycles", None), "film_exposure", 1.0)
    return max(math.log2(factor), least) if factor > 0.0 else least


_CLASSES = (StreamPictureSettings, StreamMachineSettings, StreamSceneSettings, StreamViewLayerSettings)


def register():
    for item in _CLASSES:
        bpy.utils.register_class(item)
    bpy.types.Scene.hdstream = bpy.props.PointerProperty(type=StreamSceneSettings)
    bpy.types.ViewLayer.hdstream = bpy.props.PointerProperty(type=StreamViewLayerSettings)


def unregister():
    del bpy.types.ViewLayer.hdstream
    del bpy.types.Scene.hdstream
    for item in reversed(_CLASSES):
        bpy.utils.unregister_class(item)
