# SPDX-License-Identifier: Apache-2.0
"""Verification cases of geometry: instancing, primvar interpolation, normals, subsets, polygons.

Also the pair of a stage near the origin and its twin 10^7 units away.
"""

import numpy as np
from pxr import Gf, Sdf, UsdGeom, UsdShade, Vt

from . import author, shapes
from .cases import AddBlocks, AddCase

FAR_OFFSET = (1.0e7, -1.0e7, 1.0e7)


def _AddSun(stage) -> None:
    author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(-2.5, 5.2, 3.0), rotate=(-55, -35, 0)), width=2.0, height=1.6,
                    intensity=8.0)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.3)


@AddCase(lambert=True)
def Instancing(stage, folder):
    """Native instances (one of them mirrored) and a PointInstancer that places another one."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.6, 0.55, 0.5))
    tower = stage.CreateClassPrim("/Tower")
    author.AddMesh(stage, "/Tower/Base", shapes.Box(0.6, 0.3, 0.4), color=(0.6, 0.3, 0.2), translate=(0.1, 0.15, 0))
    author.AddMesh(stage, "/Tower/Top", shapes.Prism(shapes.StarOutline(5, 0.3, 0.12), 0.4), color=(0.2, 0.5, 0.6),
                   translate=(0, 0.3, 0))
    for i in range(4):
        prim = UsdGeom.Xform.Define(stage, f"/World/Native{i}").GetPrim()
        prim.GetReferences().AddInternalReference(tower.GetPath())
        prim.SetInstanceable(True)
        author.Place(prim, translate=(-2.1 + 1.4 * i, 0, -0.9), rotate=(0, 40 * i, 0),
                     scale=(-1.2, 1.5, 1.2) if i == 2 else 1.0 + 0.2 * i)
    inner = UsdGeom.PointInstancer.Define(stage, "/World/Outer/Prototypes/Inner")
    author.AddMesh(stage, "/World/Outer/Prototypes/Inner/Prototypes/Pin", shapes.Box(0.1, 0.5, 0.1), color=(0.7, 0.65, 0.2),
                   translate=(0, 0.25, 0))
    author.AddMesh(stage, "/World/Outer/Prototypes/Inner/Prototypes/Bead", shapes.Sphere(0.11, 24, 48), color=(0.6, 0.2, 0.5),
                   translate=(0, 0.11, 0))
    inner.CreatePrototypesRel().SetTargets(["/World/Outer/Prototypes/Inner/Prototypes/Pin",
                                            "/World/Outer/Prototypes/Inner/Prototypes/Bead"])
    inner.CreateProtoIndicesAttr([0, 1, 1, 0, 1])
    inner.CreatePositionsAttr([(-0.2, 0, -0.2), (0.2, 0, -0.2), (-0.2, 0, 0.2), (0.2, 0, 0.2), (0, 0.4, 0)])
    outer = UsdGeom.PointInstancer.Define(stage, "/World/Outer")
    outer.CreatePrototypesRel().SetTargets(["/World/Outer/Prototypes/Inner"])
    outer.CreateProtoIndicesAttr([0] * 5)
    outer.CreatePositionsAttr([(-1.9 + 0.95 * i, 0, 1.2) for i in range(5)])
    half = Gf.Quath(float(np.cos(0.3)), 0, float(np.sin(0.3)), 0)
    outer.CreateOrientationsAttr([Gf.Quath(1, 0, 0, 0), half, half * half, half, Gf.Quath(1, 0, 0, 0)])
    outer.CreateScalesAttr([(1, 1, 1), (1, 1.5, 1), (1.3, 1, 1.3), (0.8, 0.8, 0.8), (1, 2, 1)])
    outer.CreateInvisibleIdsAttr([3])
    _AddSun(stage)
    author.AddCamera(stage, eye=(0, 2.4, 6.0), target=(0, 0.5, 0))


@AddCase(lambert=True)
def PrimvarColors(stage, folder):
    """displayColor of every interpolation, indexed and not, on tilted grids."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5))
    grid = shapes.Plane(1.2, 1.5, 3, 2)
    rng = np.random.default_rng(7)
    colors = lambda n: Vt.Vec3fArray.FromNumpy(rng.uniform(0.05, 0.85, (n, 3)).astype(np.float32))
    layouts = [("constant", 1, None), ("uniform", 6, None), ("vertex", 12, None), ("faceVarying", 24, None),
               ("faceVarying", 5, np.arange(24) % 5)]
    for i, (interpolation, count, indices) in enumerate(layouts):
        mesh = author.AddMesh(stage, f"/World/Grid{i}", grid, doubleSided=True, translate=(-2.7 + 1.35 * i, 0.8, 0), rotate=(70, 0, 0))
        author.AddPrimvar(mesh, "displayColor", Sdf.ValueTypeNames.Color3fArray, interpolation, colors(count), indices)
    _AddSun(stage)
    author.AddCamera(stage, eye=(0, 1.8, 6.2), target=(0, 0.6, 0))


@AddCase()
def AuthoredNormals(stage, folder):
    """Authored normals that differ from the geometry: vertex, faceVarying, uniform; and left handed."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.4, 0.4, 0.4))
    gloss = author.AddMaterial(stage, "/World/Gloss", diffuseColor=(0.45, 0.4, 0.3), roughness=0.4)
    grid = shapes.Plane(1.2, 1.5, 3, 2)
    bend = lambda p: np.stack([0.7 * p[:, 0], np.ones(len(p)), -0.5 * p[:, 2]], 1)
    centres = grid.points[grid.indices.reshape(-1, 4)].mean(1)
    for i, interpolation in enumerate(("vertex", "faceVarying", "uniform", "vertex")):
        source = {"vertex": grid.points, "faceVarying": grid.points[grid.indices] * 1.5, "uniform": centres}[interpolation]
        shape = grid
        if i == 3:  # the same surface with reversed winding and leftHanded orientation
            shape = shapes.Shape(grid.points, grid.counts, grid.indices.reshape(-1, 4)[:, ::-1].ravel())
        mesh = author.AddMesh(stage, f"/World/Grid{i}", shapes.Shape(shape.points, shape.counts, shape.indices), material=gloss,
                              doubleSided=True, translate=(-2.0 + 1.35 * i, 0.8, 0), rotate=(70, 0, 0))
        normals = bend(source)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals.astype(np.float32)))
        mesh.SetNormalsInterpolation(interpolation)
        if i == 3:
            mesh.CreateOrientationAttr("leftHanded")
    _AddSun(stage)
    author.AddCamera(stage, eye=(0, 1.8, 6.2), target=(0, 0.6, 0))


@AddCase(lambert=True)
def Polygons(stage, folder):
    """Concave n-gons, holes and triangles of both orientations, flat shaded."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.6, 0.55, 0.5))
    author.AddMesh(stage, "/World/Star", shapes.Prism(shapes.StarOutline(7, 0.9, 0.35), 0.6), color=(0.7, 0.3, 0.2),
                   translate=(-1.7, 0.9, 0), rotate=(50, 0, 10))
    letter = np.array([[0, 0], [1.2, 0], [1.2, 0.3], [0.3, 0.3], [0.3, 0.7], [0.9, 0.7], [0.9, 1.0], [0.3, 1.0], [0.3, 1.6], [0, 1.6]])
    prism = shapes.Prism(letter, 0.35)
    left = author.AddMesh(stage, "/World/Letter", shapes.Shape(prism.points, prism.counts, _Reversed(prism)), color=(0.2, 0.5, 0.6),
                          translate=(-0.5, 0.05, 0.3), rotate=(90, 0, 0))
    left.CreateOrientationAttr("leftHanded")
    grid = author.AddMesh(stage, "/World/Lattice", shapes.Plane(1.6, 1.6, 5, 5), color=(0.65, 0.6, 0.25), doubleSided=True,
                          translate=(1.8, 0.85, 0), rotate=(70, -20, 0))
    grid.CreateHoleIndicesAttr([6, 8, 12, 16, 18])
    _AddSun(stage)
    author.AddCamera(stage, eye=(0, 2.0, 6.0), target=(0, 0.6, 0))


def _Reversed(shape: shapes.Shape) -> np.ndarray:
    ends = np.cumsum(shape.counts)
    return np.concatenate([shape.indices[e - c : e][::-1] for e, c in zip(ends, shape.counts)])


@AddCase()
def Subsets(stage, folder):
    """GeomSubsets with materials of their own over a bound mesh."""
    author.AddMesh(stage, "/World/Ground", shapes.Plane(8, 8), color=(0.5, 0.5, 0.5))
    base = author.AddMaterial(stage, "/World/Base", diffuseColor=(0.5, 0.5, 0.45), roughness=0.6)
    paint = author.AddMaterial(stage, "/World/Paint", diffuseColor=(0.7, 0.1, 0.05), roughness=0.3)
    brass = author.AddMaterial(stage, "/World/Brass", diffuseColor=(0.8, 0.6, 0.2), metallic=1.0, roughness=0.45)
    box = author.AddMesh(stage, "/World/Box", shapes.Box(1.6, 1.6, 1.6), material=base, translate=(-1.1, 0.81, 0), rotate=(0, 35, 0))
    grid = author.AddMesh(stage, "/World/Grid", shapes.Plane(1.8, 1.6, 6, 6), material=base, doubleSided=True,
                          translate=(1.3, 0.8, 0), rotate=(70, 0, 0))
    for mesh, name, faces, material in [(box, "paint", [1], paint), (box, "brass", [3, 5], brass),
                                        (grid, "paint", list(range(0, 36, 3)), paint), (grid, "brass", list(range(1, 36, 5)), brass)]:
        faces = [f for f in faces if name != "brass" or mesh is box or f % 3]
        subset = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).CreateMaterialBindSubset(name, Vt.IntArray(faces))
        author.Bind(subset, material)
    _AddSun(stage)
    author.AddCamera(stage, eye=(0, 2.0, 6.0), target=(0, 0.6, 0))


@AddCase(lambert=True)
def UpAxisZ(stage, folder):
    """A z-up stage: geometry, light and dome turn with the data, nothing is rotated by the renderer."""
    UsdGeom.SetStageUpAxis(stage, "Z")
    author.Place(stage.GetPrimAtPath("/World"), rotate=(90, 0, 0))
    AddBlocks(stage)
    _AddSun(stage)


def WriteFarPair(folder: str, hasStray: bool = False) -> tuple[str, str]:
    """The blocks at the origin and 10^7 units from it: (near path, far path). A stray lies at the origin of the far ones."""
    paths = []
    for name, offset in (("near", (0.0, 0.0, 0.0)), ("far", FAR_OFFSET)):
        stage = author.NewStage(f"{folder}/{name}.usda")
        author.Place(stage.GetPrimAtPath("/World"), translate=offset)
        AddBlocks(stage)
        _AddSun(stage)
        if hasStray:
            author.AddMesh(stage, "/Stray", shapes.Box(1.0, 1.0, 1.0), translate=np.subtract(offset, FAR_OFFSET))
        stage.GetRootLayer().Save()
        paths.append(f"{folder}/{name}.usda")
    return paths[0], paths[1]
