# SPDX-License-Identifier: Apache-2.0
"""Materials of hair (MaterialX's chiang_hair_bsdf), and a stage with three balls of hair."""

import numpy as np
from pxr import Sdf, UsdShade

from . import author, curves, shapes
from .materialX import AddNode, AddSurface

_TYPES = Sdf.ValueTypeNames


def AddHair(stage, path: str, absorption=(0.0, 0.0, 0.0), roughness=(0.3, 0.3), cuticle=0.5, ior=1.55, opacity=1.0,
            **inputs) -> UsdShade.Material:
    """A material of hair below `path`. `absorption` is three numbers or a pair (shader, output). `roughness` is a pair for node
    chiang_hair_roughness, or three pairs for R, TT and TRT. `inputs`: of the closure besides."""
    UsdShade.Material.Define(stage, path)
    hair, _ = AddNode(stage, f"{path}/Hair", "ND_chiang_hair_bsdf", _TYPES.Token, ior=ior, cuticle_angle=cuticle, **inputs)
    target = hair.CreateInput("absorption_coefficient", _TYPES.Float3)
    if isinstance(absorption[0], UsdShade.Shader):
        target.ConnectToSource(absorption[0].GetOutput(absorption[1]))
    else:
        target.Set(tuple(map(float, absorption)))
    lobes = ("roughness_R", "roughness_TT", "roughness_TRT")
    if isinstance(roughness[0], tuple):
        for name, pair in zip(lobes, roughness):
            hair.CreateInput(name, _TYPES.Float2).Set(pair)
    else:
        helper, _ = AddNode(stage, f"{path}/Roughness", "ND_chiang_hair_roughness", longitudinal=roughness[0], azimuthal=roughness[1])
        for name in lobes:
            source = helper.CreateOutput(name, _TYPES.Float2)
            hair.CreateInput(name, _TYPES.Float2).ConnectToSource(source)
    return AddSurface(stage, path, "ND_surface", bsdf=(hair, "out"), opacity=float(opacity))


def OfMelanin(stage, path: str, concentration, redness):
    """The absorption of hair with melanin, as a pair (shader, output)."""
    node, _ = AddNode(stage, path, "ND_deon_hair_absorption_from_melanin", melanin_concentration=concentration, melanin_redness=redness)
    node.CreateOutput("absorption", _TYPES.Float3)
    return node, "absorption"


def OfColor(stage, path: str, color, azimuthal=0.3):
    """The absorption of hair of a colour: three numbers, or a pair (shader, output)."""
    node, _ = AddNode(stage, path, "ND_chiang_hair_absorption_from_color", color=color, azimuthal_roughness=azimuthal)
    node.CreateOutput("absorption", _TYPES.Float3)
    return node, "absorption"


def OfDisplayColor(stage, path: str, azimuthal=0.3):
    """The same of the primvar displayColor."""
    return OfColor(stage, path, AddNode(stage, f"{path}Primvar", "ND_geompropvalue_color3", geomprop="displayColor"), azimuthal)


def AddBall(stage, path: str, material, count: int, place, colours=None, seed=5):
    """A ball with hair of a material; `colours` are three numbers a hair, or none."""
    skull = author.AddMaterial(stage, f"{path}Skull", diffuseColor=(0.02, 0.015, 0.01), roughness=1.0)
    author.AddMesh(stage, f"{path}Ball", shapes.Sphere(1.0, 48, 96), material=skull, translate=place)
    points, widths, _ = curves.HairBall(count, seed=seed)
    perVertex = None if colours is None else np.repeat(colours, len(points) // count, axis=0)
    hairs = curves.AddCurves(stage, path, list(points.reshape(count, -1, 3)), widths, wrap="pinned", color=perVertex, translate=place)
    author.Bind(hairs.GetPrim(), material)


def WriteHairBalls(path, count: int = 12000) -> str:
    """Three balls: dark and red melanin, and hair in bands of colours of a primvar."""
    stage = author.NewStage(path)
    UsdShade.Material.Define(stage, "/World/Looks")
    author.AddMesh(stage, "/World/Ground", shapes.Plane(24, 24), color=(0.3, 0.3, 0.3), translate=(0, -1.6, 0))
    brown = AddHair(stage, "/World/Looks/Brown", OfMelanin(stage, "/World/Looks/Dark", 0.8, 0.3), (0.25, 0.3), cuticle=0.52)
    red = AddHair(stage, "/World/Looks/Red", OfMelanin(stage, "/World/Looks/Reddish", 0.6, 0.95), (0.25, 0.3), cuticle=0.52)
    dyed = AddHair(stage, "/World/Looks/Dyed", OfDisplayColor(stage, "/World/Looks/Colour"), (0.25, 0.3), cuticle=0.52)
    heights = curves.HairBall(count, seed=7)[0].reshape(count, -1, 3)[:, 0, 1]
    bands = np.array([(0.05, 0.25, 0.7), (0.9, 0.9, 0.9), (0.8, 0.05, 0.1), (0.9, 0.55, 0.05)])
    colours = bands[np.clip((heights + 1.0) * 2.0, 0, 3).astype(int)]
    for index, (name, material, colour) in enumerate((("Brown", brown, None), ("Red", red, None), ("Dyed", dyed, colours))):
        AddBall(stage, f"/World/{name}", material, count, (3.2 * (index - 1), 0, 0), colour, seed=5 + index)
    author.AddLight(stage, "/World/Key", "Rect", dict(translate=(-4, 5, 5), rotate=(-40, -38, 0)), width=2.5, height=2.5, intensity=16.0)
    author.AddLight(stage, "/World/Rim", "Rect", dict(translate=(1.5, 4.5, -5), rotate=(-138, 0, 0)), width=5.0, height=1.5, intensity=16.0)
    author.AddLight(stage, "/World/Sky", "Dome", intensity=0.25)
    author.AddCamera(stage, eye=(0, 1.1, 9.6), target=(0, -0.15, 0), focalLength=40.0, width=44.0, aspect=2.4)
    stage.GetRootLayer().Save()
    return str(path)
