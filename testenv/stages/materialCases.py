# SPDX-License-Identifier: Apache-2.0
"""Verification cases of UsdPreviewSurface: a row of balls for each parameter.

Balls are dense meshes with authored normals, so both renderers see the same geometry.
"""

import numpy as np
from pxr import Sdf, Vt

from . import author, shapes
from .cases import AddBallRow, AddCase, AddStudio


def _Row(stage, variants: list[dict], **common) -> None:
    AddStudio(stage)
    AddBallRow(stage, [author.AddMaterial(stage, f"/World/Material{i}", **{**common, **v}) for i, v in enumerate(variants)])


@AddCase()
def SurfaceDiffuse(stage, folder):
    _Row(stage, [dict(diffuseColor=c) for c in [(0.8, 0.1, 0.1), (0.18, 0.18, 0.18), (0.1, 0.3, 0.8), (0.9, 0.9, 0.9)]])


@AddCase(samples=256)
def SurfaceMetallic(stage, folder):
    _Row(stage, [dict(metallic=m) for m in (0.0, 0.35, 0.7, 1.0)], diffuseColor=(0.9, 0.6, 0.25), roughness=0.35)


@AddCase()
def SurfaceRoughness(stage, folder):
    _Row(stage, [dict(roughness=r) for r in (0.12, 0.3, 0.6, 1.0)], diffuseColor=(0.05, 0.15, 0.1), ior=1.8)


@AddCase(samples=512)
def SurfaceRoughMetal(stage, folder):
    _Row(stage, [dict(roughness=r) for r in (0.1, 0.3, 0.6, 1.0)], diffuseColor=(0.85, 0.85, 0.8), metallic=1.0)


@AddCase(samples=512)
def SurfaceSmooth(stage, folder):
    """Roughness down to 0 (metal and dielectric) and the default clearcoat roughness. A dim key light: its
    caustics would need more samples than a test has."""
    AddStudio(stage, key=1.0)
    AddBallRow(stage, [author.AddMaterial(stage, f"/World/Material{i}", **inputs) for i, inputs in enumerate([
        dict(diffuseColor=(0.9, 0.8, 0.7), metallic=1.0, roughness=0.0), dict(diffuseColor=(0.4, 0.1, 0.1), roughness=0.0),
        dict(diffuseColor=(0.1, 0.2, 0.4), roughness=0.03, ior=2.0),
        dict(diffuseColor=(0.2, 0.4, 0.2), roughness=0.7, clearcoat=1.0)])])


@AddCase(samples=256)
def SurfaceSpecularWorkflow(stage, folder):
    _Row(stage, [dict(specularColor=c, roughness=r) for c, r in
                 [((0, 0, 0), 0.5), ((0.04, 0.04, 0.04), 0.3), ((0.5, 0.2, 0.05), 0.3), ((0.9, 0.8, 0.6), 0.5)]],
         diffuseColor=(0.2, 0.2, 0.4), useSpecularWorkflow=1)


@AddCase(samples=256)
def SurfaceClearcoat(stage, folder):
    _Row(stage, [dict(clearcoat=c, clearcoatRoughness=r) for c, r in [(0.0, 0.1), (0.5, 0.15), (1.0, 0.15), (1.0, 0.5)]],
         diffuseColor=(0.6, 0.08, 0.05), roughness=0.6)


@AddCase()
def SurfaceIor(stage, folder):
    _Row(stage, [dict(ior=i) for i in (1.0, 1.33, 1.8, 2.6)], diffuseColor=(0.1, 0.1, 0.12), roughness=0.3)


@AddCase(passThrough=True, maxDepth=12)
def SurfaceOpacity(stage, folder):
    """Straight-through transparency: cards of opacity 1/4, 1/2 and 3/4 before a Lambert set, and a ball."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(14, 14), color=(0.3, 0.3, 0.3))
    author.AddMesh(stage, "/World/Box", shapes.Box(4.6, 0.5, 0.5), color=(0.4, 0.1, 0.08), translate=(0, 0.25, -0.9))
    for i, opacity in enumerate((0.25, 0.5, 0.75)):
        card = author.AddMaterial(stage, f"/World/Material{i}", diffuseColor=(0.3, 0.4, 0.15), opacity=opacity, roughness=0.5)
        author.AddMesh(stage, f"/World/Card{i}", shapes.Plane(1.1, 1.4), material=card, doubleSided=True,
                       translate=(-1.9 + 1.3 * i, 0.75, 0), rotate=(80, 0, 0))
    ball = author.AddMaterial(stage, "/World/MaterialBall", diffuseColor=(0.1, 0.2, 0.4), opacity=0.5, roughness=0.4)
    author.AddMesh(stage, "/World/Ball", shapes.Sphere(0.6, 96, 192), material=ball, doubleSided=True, translate=(2.0, 0.65, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.8)
    author.AddCamera(stage, eye=(0, 1.7, 6.2), target=(0, 0.62, 0))


@AddCase(passThrough=True, maxDepth=12)
def SurfaceCutout(stage, folder):
    """opacityThreshold with displayOpacity through a primvar reader: per face and per vertex."""
    AddStudio(stage)
    leaf = author.AddMaterial(stage, "/World/Leaf", readers={"opacity": ("displayOpacity", "float", 1.0)},
                              diffuseColor=(0.2, 0.45, 0.1), roughness=0.8, opacityThreshold=0.5)
    grid = shapes.Plane(2.2, 1.8, 6, 8)
    i, j = np.divmod(np.arange(48), 8)
    mesh = author.AddMesh(stage, "/World/Faces", grid, material=leaf, doubleSided=True, translate=(-1.4, 1.0, 0), rotate=(75, 15, 0))
    author.AddPrimvar(mesh, "displayOpacity", Sdf.ValueTypeNames.FloatArray, "uniform",
                      Vt.FloatArray.FromNumpy(((i + j) % 2).astype(np.float32)))
    y, x = np.divmod(np.arange(63), 9)
    mesh = author.AddMesh(stage, "/World/Vertices", grid, material=leaf, doubleSided=True, translate=(1.4, 1.0, 0), rotate=(75, -15, 0))
    author.AddPrimvar(mesh, "displayOpacity", Sdf.ValueTypeNames.FloatArray, "vertex",
                      Vt.FloatArray.FromNumpy((0.5 + 0.5 * np.sin(1.3 * x) * np.cos(1.1 * y)).astype(np.float32)))


@AddCase(samples=384)
def SurfaceEmissive(stage, folder):
    """Emissive surfaces that also reflect, next to others that only receive."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(14, 14), color=(0.35, 0.35, 0.35))
    materials = [author.AddMaterial(stage, f"/World/Material{i}", diffuseColor=(0.4, 0.4, 0.4), emissiveColor=e, roughness=0.4)
                 for i, e in enumerate([(3, 0.6, 0.2), (0, 0, 0), (0.2, 1.2, 4), (0, 0, 0)])]
    AddBallRow(stage, materials)
    author.AddCamera(stage, eye=(0, 1.7, 6.2), target=(0, 0.62, 0))
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.1)


@AddCase()
def SurfaceReaders(stage, folder):
    """Every kind of input from primvars: colour by vertex, roughness and metallic by face."""
    AddStudio(stage)
    grid = shapes.Plane(5.0, 1.8, 4, 10)
    readers = {"diffuseColor": ("tint", "float3", (1.0, 0.0, 1.0)), "roughness": ("rough", "float", 0.5),
               "metallic": ("metal", "float", 0.0), "ior": ("missing", "float", 1.7)}
    material = author.AddMaterial(stage, "/World/Patch", readers=readers)
    mesh = author.AddMesh(stage, "/World/Grid", grid, material=material, doubleSided=True, translate=(0, 1.0, 0), rotate=(65, 0, 0))
    y, x = np.divmod(np.arange(55), 11)
    tint = np.stack([x / 10, 0.2 + 0.15 * y, 1 - x / 10], 1).astype(np.float32)
    author.AddPrimvar(mesh, "tint", Sdf.ValueTypeNames.Color3fArray, "vertex", Vt.Vec3fArray.FromNumpy(tint))
    i, j = np.divmod(np.arange(40), 10)
    author.AddPrimvar(mesh, "rough", Sdf.ValueTypeNames.FloatArray, "uniform",
                      Vt.FloatArray.FromNumpy((0.25 + 0.2 * i).astype(np.float32)))
    author.AddPrimvar(mesh, "metal", Sdf.ValueTypeNames.FloatArray, "uniform", Vt.FloatArray([0.0, 1.0]), indices=j % 2)


@AddCase()
def SurfaceNormalInput(stage, folder):
    """A constant tangent-space normal on a tilted plane whose `st` fixes the tangent frame."""
    AddStudio(stage)
    for i, normal in enumerate([(0.0, 0.0, 1.0), (0.35, 0.0, 0.94), (0.0, 0.35, 0.94)]):
        material = author.AddMaterial(stage, f"/World/Material{i}", diffuseColor=(0.5, 0.4, 0.3), roughness=0.35, normal=normal)
        author.AddMesh(stage, f"/World/Tile{i}", shapes.Plane(1.3, 1.6), material=material, doubleSided=True,
                       translate=(-1.6 + 1.6 * i, 0.9, 0), rotate=(60, 0, 0))


@AddCase(samples=512)
def SurfaceInterior(stage, folder):
    """Glossy and metal things in a lit box: several bounces between all of them."""
    AddRoom(stage)
    gloss = author.AddMaterial(stage, "/World/Gloss", diffuseColor=(0.5, 0.15, 0.1), roughness=0.25)
    metal = author.AddMaterial(stage, "/World/Metal", diffuseColor=(0.9, 0.8, 0.6), metallic=1.0, roughness=0.4)
    author.AddMesh(stage, "/World/Ball0", shapes.Sphere(0.5, 96, 192), material=gloss, translate=(-0.5, 0.52, 0.3))
    author.AddMesh(stage, "/World/Ball1", shapes.Sphere(0.5, 96, 192), material=metal, translate=(0.7, 0.52, -0.2))


def AddRoom(stage) -> None:
    """A 3 x 2.5 x 3 Lambert box open toward the camera, lit by one panel in a hole of the ceiling: what
    passes the panel meets nothing, so that it does not matter whether lights occlude."""
    white, red, green = (0.73, 0.73, 0.73), (0.65, 0.06, 0.05), (0.12, 0.45, 0.1)
    for name, color, width, depth, move, turn in [
            ("Floor", white, 3, 3, (0, 0, 0), (0, 0, 0)), ("Ceiling", white, 3, 3, (0, 2.5, 0), (180, 0, 0)),
            ("Back", white, 3, 2.5, (0, 1.25, -1.5), (90, 0, 0)), ("Left", red, 2.5, 3, (-1.5, 1.25, 0), (0, 0, -90)),
            ("Right", green, 2.5, 3, (1.5, 1.25, 0), (0, 0, 90))]:
        wall = shapes.Plane(width, depth, 3, 3) if name == "Ceiling" else shapes.Plane(width, depth)
        mesh = author.AddMesh(stage, f"/World/{name}", wall, color=color, translate=move, rotate=turn)
        if name == "Ceiling":
            mesh.CreateHoleIndicesAttr([4])
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(0, 2.5, 0), rotate=(-90, 0, 0)), width=1.0, height=1.0,
                    intensity=6.4)
    author.AddCamera(stage, eye=(0, 1.25, 5.2), target=(0, 1.2, 0), focalLength=38)


@AddCase(lambert=True, maxDepth=8, samples=256)
def LambertRoom(stage, folder):
    AddRoom(stage)
    author.AddMesh(stage, "/World/Box", shapes.Box(0.8, 1.3, 0.8), color=(0.73, 0.73, 0.73), translate=(-0.5, 0.651, -0.4),
                   rotate=(0, 20, 0))
    author.AddMesh(stage, "/World/Cube", shapes.Box(0.7, 0.7, 0.7), color=(0.3, 0.4, 0.7), translate=(0.6, 0.351, 0.4),
                   rotate=(0, -18, 0))
