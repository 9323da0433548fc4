# SPDX-License-Identifier: Apache-2.0
"""A terrain, and with it one prim below the ground that needs a feature: what the feature costs is what leaving it out saves
every scene that has no such prim."""

import pathlib

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from . import author, bench, curves, imageFile, materialX, shapes, textured

_BELOW = (0, -30, 0)
_NUM_UNREAD = 6


def _AddTriangle(stage, material=None) -> None:
    author.AddMesh(stage, "/World/Below", shapes.Plane(0.1, 0.1), material=material, translate=_BELOW)


def _Plain(stage, folder) -> None:
    _AddTriangle(stage)


def _Curves(stage, folder) -> None:
    points = np.array([(0, 0, 0), (0, 0.1, 0), (0, 0.2, 0), (0, 0.3, 0)]) + _BELOW
    curves.AddCurves(stage, "/World/Below", [points], 0.01)


def _Cutout(stage, folder) -> None:
    _AddTriangle(stage, author.AddMaterial(stage, "/World/Glass", opacity=0.5))


def _Texture(stage, folder) -> None:
    path = folder / "texture.png"
    imageFile.WritePng(path, np.full((4, 4, 3), 128, np.uint8))
    _AddTriangle(stage, textured.AddTexturedMaterial(stage, "/World/Textured", {"diffuseColor": (str(path), "rgb")}))


def _Lobes(stage, folder) -> None:
    every = dict(base_color=(0.5, 0.4, 0.3), diffuse_roughness=0.5, specular_anisotropy=0.5, coat=0.5, sheen=0.5, transmission=0.5)
    _AddTriangle(stage, materialX.AddSurface(stage, "/World/Layered", **every))


def _Patterns(stage, folder) -> None:
    noise = materialX.AddNode(stage, "/World/Pattern/Noise", "ND_noise3d_float", Sdf.ValueTypeNames.Float)
    _AddTriangle(stage, materialX.AddSurface(stage, "/World/Pattern", base=noise))


def _Lamp(stage):
    return stage.GetPrimAtPath("/World/Lamp")


def _Shaping(stage, folder) -> None:
    _AddTriangle(stage)
    author.ShapeLight(_Lamp(stage), coneAngle=60.0, focus=1.0)


def _Controls(stage, folder) -> None:
    _AddTriangle(stage)
    author.LinkLight(_Lamp(stage), "lightLink", excludes=["/World/Below"])


def _Groups(stage, folder) -> None:
    for level, inner in (("Outer", "/World/Outer/Inner"), ("Outer/Inner", "/World/Outer/Inner/Mesh")):
        instancer = UsdGeom.PointInstancer.Define(stage, f"/World/{level}")
        instancer.CreatePrototypesRel().SetTargets([Sdf.Path(inner)])
        instancer.CreatePositionsAttr([Gf.Vec3f(*map(float, _BELOW if level == "Outer" else (0, 0, 0)))])
        instancer.CreateProtoIndicesAttr([0])
    author.AddMesh(stage, "/World/Outer/Inner/Mesh", shapes.Plane(0.1, 0.1))


def _Tinted(stage, folder) -> None:
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Tinted")
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path("/World/Tinted/Mesh")])
    instancer.CreatePositionsAttr([Gf.Vec3f(*map(float, _BELOW)), Gf.Vec3f(0.0, -32.0, 0.0)])
    instancer.CreateProtoIndicesAttr([0, 0])
    author.AddMesh(stage, "/World/Tinted/Mesh", shapes.Plane(0.1, 0.1))
    author.AddPrimvar(instancer, "displayColor", Sdf.ValueTypeNames.Color3fArray, "vertex",
                      Vt.Vec3fArray([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)]))


def _AddColours(stage) -> list:
    """Primvars of all points of the terrain."""
    mesh = UsdGeom.Mesh.Get(stage, "/World/Terrain")
    count = len(mesh.GetPointsAttr().Get())
    names = [f"colour{i}" for i in range(_NUM_UNREAD)]
    for name in names:
        author.AddPrimvar(mesh, name, Sdf.ValueTypeNames.Color3fArray, "vertex", Vt.Vec3fArray(count, Gf.Vec3f(0.5)))
    return names


def _Unread(stage, folder) -> None:
    _AddTriangle(stage)
    _AddColours(stage)


def _Read(stage, folder) -> None:
    """A material on the terrain's faces looks at all of them."""
    inputs = ("diffuseColor", "emissiveColor", "specularColor", "roughness", "metallic", "clearcoat")
    kinds = ("float3", "float3", "float3", "float", "float", "float")
    fallbacks = ((0.5, 0.5, 0.5), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5, 0.0, 0.0)
    readers = {name: (primvar, kind, fallback)
               for name, primvar, kind, fallback in zip(inputs, _AddColours(stage), kinds, fallbacks)}
    _AddTriangle(stage)
    author.Bind(UsdGeom.Mesh.Get(stage, "/World/Terrain"), author.AddMaterial(stage, "/World/Reads", readers))


def _Everything(stage, folder) -> None:
    for add in (_Texture, _Lobes, _Patterns, _Cutout):
        stage.RemovePrim("/World/Below")
        add(stage, folder)
        Sdf.CopySpec(stage.GetRootLayer(), "/World/Below", stage.GetRootLayer(), f"/World/Of{add.__name__}")
    stage.RemovePrim("/World/Below")
    _Curves(stage, folder)
    _Groups(stage, folder)
    _Tinted(stage, folder)
    author.LinkLight(_Lamp(stage), "lightLink", excludes=["/World/Below"])


# `nothing` first: what the others are compared with. Those of UNSEEN make the same picture.
UNSEEN = {"nothing": _Plain, "curves": _Curves, "cut-outs": _Cutout, "textures": _Texture, "layered lobes": _Lobes,
          "patterns": _Patterns, "light links": _Controls, "nested instances": _Groups, "colours by instance": _Tinted,
          "all of these": _Everything, "six unread primvars": _Unread}
ADDITIONS = {**UNSEEN, "six primvars, read": _Read, "light shaping": _Shaping}


def WriteEconomies(path, addition: str, cells: int = 300) -> None:
    """`addition`: of ADDITIONS. The camera is /World/Camera."""
    bench.WriteTerrain(str(path), cells)
    stage = Usd.Stage.Open(str(path))
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(0, -20, 0)), intensity=1e-3, radius=0.1)
    ADDITIONS[addition](stage, pathlib.Path(path).parent)
    stage.GetRootLayer().Save()
