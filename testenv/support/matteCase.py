# SPDX-License-Identifier: Apache-2.0
"""A stage whose mattes overlap, and a decoder of Cryptomattes that shares nothing with the writer."""

import json

import exrFile
import numpy as np
from pxr import Sdf, UsdGeom, UsdShade, Vt

from stages import author, shapes

WIDTH, HEIGHT, SAMPLES = 48, 36, 24
ALL = ("crypto_object", "crypto_material", "crypto_instance")


def _Rotated(value, bits):
    return (value << bits | value >> (32 - bits)) & 0xffffffff


def Murmur(text):
    """MurmurHash3_x86_32 of the bytes of a text, after Appleby's description."""
    data, state = text.encode("utf-8"), 0
    for begin in range(0, len(data), 4):
        word = int.from_bytes(data[begin:begin + 4], "little")
        state ^= _Rotated(word * 0xcc9e2d51 & 0xffffffff, 15) * 0x1b873593 & 0xffffffff
        if begin + 4 <= len(data):
            state = (_Rotated(state, 13) * 5 + 0xe6546b64) & 0xffffffff
    state ^= len(data)
    for shift, factor in ((16, 0x85ebca6b), (13, 0xc2b2ae35)):
        state = (state ^ state >> shift) * factor & 0xffffffff
    return state ^ state >> 16


class Cryptomatte:
    """One Cryptomatte of a file, as the specification (1.2) says that it is read."""

    def __init__(self, file, name):
        texts, channels = exrFile.Read(file)
        key = next(entry[:-len("/name")] for entry, text in texts.items()
                   if entry.startswith("cryptomatte/") and entry.endswith("/name") and text == name)
        assert key == f"cryptomatte/{Murmur(name):08x}"[:-1]
        assert texts[f"{key}/hash"] == "MurmurHash3_32" and texts[f"{key}/conversion"] == "uint32_to_float32"
        self.manifest = json.loads(texts[f"{key}/manifest"])
        self.ranks = []  # (ids, coverages), the largest first
        for layer in sorted({channel.split(".")[0] for channel in channels if channel.startswith(name)}):
            for ids, coverage in (("R", "G"), ("B", "A")):
                self.ranks.append((channels[f"{layer}.{ids}"].view("<u4"), channels[f"{layer}.{coverage}"]))

    def Matte(self, name):
        wanted = int(self.manifest[name], 16)
        return sum(np.where(ids == wanted, coverage, 0.0) for ids, coverage in self.ranks)

    def Total(self):
        return sum(coverage for _, coverage in self.ranks)


def _Material(stage, path, opacity=1.0):
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def WriteMatteStage(path, names=("Card", "Mover", "Many", "Wall")):
    """A half transparent card before a moving box, instances and a wall of two materials; out of focus, the shutter open."""
    stage = author.NewStage(str(path))
    stage.SetStartTimeCode(1)
    materials = {name: _Material(stage, f"/Looks/{name}", opacity) for name, opacity in (("Veil", 0.5), ("Red", 1.0), ("Blue", 1.0))}
    if "Card" in names:
        card = author.AddMesh(stage, "/World/Card", shapes.Box(1.6, 1.6, 0.02), translate=(-0.8, 0.3, 2.5))
        UsdShade.MaterialBindingAPI.Apply(card.GetPrim()).Bind(materials["Veil"])
    if "Mover" in names:
        mover = author.AddMesh(stage, "/World/Mover", shapes.Box(0.8, 0.8, 0.8))
        translate = UsdGeom.Xformable(mover).AddTranslateOp(opSuffix="way")
        translate.Set((-1.5, 0.0, 1.0), 1)
        translate.Set((-0.7, 0.4, 1.0), 2)
        UsdShade.MaterialBindingAPI.Apply(mover.GetPrim()).Bind(materials["Red"])
    if "Many" in names:
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
        author.AddMesh(stage, "/World/Many/Prototypes/Small", shapes.Box(0.5, 0.5, 0.5))
        instancer.CreatePrototypesRel().SetTargets(["/World/Many/Prototypes/Small"])
        instancer.CreateProtoIndicesAttr([0, 0, 0])
        instancer.CreatePositionsAttr([(0.6, -0.6, 1.0), (1.2, 0.5, 0.8), (1.0, 0.2, 0.2)])
    if "Wall" in names:
        wall = author.AddMesh(stage, "/World/Wall", shapes.Shape(
            np.array([[-2.0, -2, -1], [0, -2, -1], [0, 1, -1], [-2, 1, -1], [2, -2, -1], [2, 1, -1]]), np.array([4, 4]),
            np.array([0, 1, 2, 3, 1, 4, 5, 2])))
        for face, name in enumerate(("Red", "Blue")):
            subset = UsdGeom.Subset.CreateGeomSubset(UsdGeom.Imageable(wall), name, UsdGeom.Tokens.face, Vt.IntArray([face]),
                                                             UsdShade.Tokens.materialBind)
            UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(materials[name])
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    camera = author.AddCamera(stage, eye=(0.0, 0.0, 8.0), target=(0, 0, 0), focalLength=40.0)
    camera.CreateFStopAttr(8.0)
    camera.CreateFocusDistanceAttr(4.0)
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(0.8)
    stage.GetRootLayer().Save()
    return str(path)


def RenderMattes(stage, aovs, **settings):
    values = {"imageWidth": WIDTH, "imageHeight": HEIGHT, "samples": SAMPLES, "aovs": list(aovs), "noCache": True, "maxDepth": 1, "domeVisible": False,
              "camera": "/World/Camera", **settings}
    import hdstream
    return hdstream.Renderer(stage).Render(1, **values)
