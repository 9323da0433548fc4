# SPDX-License-Identifier: Apache-2.0
"""Bench scenes: a bumpy terrain, many instances of one object, many separate meshes.

Sizes are parameters, so that tests use small ones. Deterministic.
"""

import numpy as np
from pxr import Gf, Sdf, UsdGeom, Vt

from . import author, shapes


def Bumps(x, z):
    """A sum of octaves of sines: rough enough for incoherent rays, cheap and free of data."""
    height = np.zeros_like(x)
    for octave in range(6):
        f = 0.13 * 2.03**octave
        height += 1.1 / 1.9**octave * np.sin(f * x + 1.7 * octave) * np.cos(f * 0.91 * z - 0.6 * octave + 0.5 * np.sin(f * x))
    return height


def _Finish(stage, eye, target) -> None:
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 30, 0)), intensity=2.0, angle=1.0, normalize=True)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.4, color=(0.7, 0.85, 1.0))
    author.AddCamera(stage, eye=eye, target=target, aspect=16 / 9)
    stage.GetRootLayer().Save()


def WriteTerrain(path, cells: int = 800) -> None:
    """2 * cells^2 triangles of terrain with three balls on it (1.28 M triangles by default)."""
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Terrain", shapes.HeightField(60.0, cells, Bumps), color=(0.45, 0.5, 0.3))
    for i, x in enumerate((-6.0, 0.0, 6.0)):
        author.AddMesh(stage, f"/World/Ball{i}", shapes.Sphere(1.5, 64, 128), color=(0.7, 0.5, 0.3), translate=(x, 3.5, 0))
    _Finish(stage, (0, 9, 26), (0, 1, 0))


def _Tree(rng, leaves: int = 1400) -> shapes.Shape:
    """A trunk and a crown of random leaves of two triangles: about 3000 triangles."""
    trunk = shapes.Lathe([0.12, 0.07, 0.0], [0.0, 1.2, 2.2], 12, [1, 1, 1], [0.05, 0.05, 0.05])
    leaf = np.array([[-0.06, 0, 0], [0, 0, 0.03], [0.06, 0, 0], [0, 0.16, 0.02]])
    parts = [trunk]
    for _ in range(leaves):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        centre = np.array([0, 1.9, 0]) + direction * np.array([0.8, 1.0, 0.8]) * rng.random() ** (1 / 3)
        parts.append(shapes.Shape(leaf @ frame + centre, np.array([3, 3]), np.array([0, 1, 3, 1, 2, 3])))
    return shapes.Merged([shapes.Shape(p.points, p.counts, p.indices) for p in parts])


def WriteForest(path, instances: int = 1_000_000, species: int = 1, leaves: int = 1400) -> None:
    """`instances` of one tree, or of several, in a PointInstancer over a ground."""
    stage = author.NewStage(path)
    rng = np.random.default_rng(3)
    side = 1.6 * np.sqrt(instances)
    author.AddMesh(stage, "/World/Ground", shapes.Plane(side + 40, side + 40), color=(0.3, 0.25, 0.2))
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Forest")
    trees = [f"/World/Forest/Prototypes/Tree{i}" for i in range(species)]
    for tree in trees:
        author.AddMesh(stage, tree, _Tree(rng, leaves), color=(0.2, 0.4, 0.12), doubleSided=True)
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path(tree) for tree in trees])
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy((np.arange(instances) % species).astype(np.int32)))
    place = rng.uniform(-side / 2, side / 2, (instances, 2))
    positions = np.stack([place[:, 0], np.zeros(instances), place[:, 1]], 1).astype(np.float32)
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(positions))
    turn = rng.uniform(0, np.pi, instances)
    quaternions = np.zeros((instances, 4), np.float16)  # numpy order of GfQuath: imaginary, real
    quaternions[:, 1], quaternions[:, 3] = np.sin(turn), np.cos(turn)
    instancer.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(quaternions))
    scale = rng.uniform(0.7, 1.4, instances).astype(np.float32)
    instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(np.repeat(scale[:, None], 3, 1)))
    _Finish(stage, (0, side * 0.03 + 6, side / 2 + 12), (0, 0, 0))


def WriteMeshes(path, meshes: int = 100_000) -> None:
    """`meshes` small mesh prims of their own on a square, below groups of 1000."""
    stage = author.NewStage(path)
    rng = np.random.default_rng(5)
    side = int(np.ceil(np.sqrt(meshes)))
    layer = stage.GetRootLayer()
    box = shapes.Box(0.7, 1.0, 0.7)
    counts, indices = Vt.IntArray([int(c) for c in box.counts]), Vt.IntArray([int(i) for i in box.indices])
    heights, colors = rng.uniform(0.3, 2.5, meshes), rng.uniform(0.1, 0.8, (meshes, 3))
    with Sdf.ChangeBlock():
        for start in range(0, meshes, 1000):
            group = Sdf.CreatePrimInLayer(layer, f"/World/Group{start // 1000}")
            group.specifier, group.typeName = Sdf.SpecifierDef, "Xform"
            for i in range(start, min(start + 1000, meshes)):
                points = box.points * [1, heights[i], 1] + [i % side - side / 2, heights[i] / 2, i // side - side / 2]
                _AddMeshSpec(layer, f"{group.path}/Mesh{i}", points, counts, indices, colors[i])
    _Finish(stage, (0, side * 0.25, side * 0.7), (0, 0, 0))


def _AddMeshSpec(layer, path: str, points, counts, indices, color) -> None:
    """A mesh by Sdf alone: about ten times as fast as the schema."""
    prim = Sdf.CreatePrimInLayer(layer, path)
    prim.specifier, prim.typeName = Sdf.SpecifierDef, "Mesh"
    for name, kind, value in (
            ("points", Sdf.ValueTypeNames.Point3fArray, Vt.Vec3fArray.FromNumpy(points.astype(np.float32))),
            ("faceVertexCounts", Sdf.ValueTypeNames.IntArray, counts), ("faceVertexIndices", Sdf.ValueTypeNames.IntArray, indices),
            ("primvars:displayColor", Sdf.ValueTypeNames.Color3fArray, Vt.Vec3fArray([Gf.Vec3f(*map(float, color))]))):
        Sdf.AttributeSpec(prim, name, kind).default = value
    scheme = Sdf.AttributeSpec(prim, "subdivisionScheme", Sdf.ValueTypeNames.Token, Sdf.VariabilityUniform)
    scheme.default = "none"
