# SPDX-License-Identifier: Apache-2.0
"""An island in the shape of the figures that Disney publishes of Moana's: a few huge meshes, thousands of trees of their
own, up to a million small meshes of their own, grass as curves, and instancers below instancers.

Of size 1 it has 260 million unique quads, 39 million instances that are stored, and more than 8 * 10^10 quads as placed.
All counts grow with the size and the ground's area does too, so that what a camera sees of a square metre stays the same.
The parts are files of their own beside the root layer, so that writing one needs the memory of one part. Deterministic.
"""

import math
import os
import pathlib

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from . import author, bench, curves, grove, shapes

TILES = 16                # of the ground, in quads 80 million * size together
TREE_QUADS = 50_000       # 2400 * size trees of their own, placed a million * size times
TREES_A_FILE = 40
PLANTS = 20               # groups of a stem and LEAVES instances, placed 400 000 * size times
LEAVES = 1000
LEAF_QUADS = 100
PEBBLE_QUADS = 60         # a million * size meshes of their own, placed once
PEBBLES_A_FILE = 20_000
SCATTERED = 40            # small meshes of about 150 quads, placed 37.7 million * size times by 10 instancers
BLADES_A_PATCH = 20_000   # of grass: 250 * size patches of their own, each placed four times
_SIDE = 6200.0            # of the ground at size 1


def _Height(x, z, side):
    """The ground: a mountain and rough country around it."""
    inner = np.exp(-(x * x + z * z) / (0.3 * side) ** 2)
    return 0.06 * side * inner + 0.6 * bench.Bumps(0.35 * x, 0.35 * z)


def _Part(folder: pathlib.Path, name: str):
    """A stage for a part, and the asset path by which the root refers to it."""
    stage = Usd.Stage.CreateNew(str(folder / f"{name}.usdc"))
    UsdGeom.SetStageUpAxis(stage, "Y")
    stage.SetDefaultPrim(UsdGeom.Scope.Define(stage, f"/{name}").GetPrim())
    return stage


def _Refer(root, folder: pathlib.Path, name: str, parent="/World"):
    prim = root.DefinePrim(f"{parent}/{name}")
    prim.GetReferences().AddReference(f"./{folder.name}/{name}.usdc")
    return prim


def _Instancer(stage, path, prototypes, positions, rng, scales=(0.7, 1.4)):
    """A point instancer whose instances are turned about the vertical and scaled."""
    count = len(positions)
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path(prototype) for prototype in prototypes])
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(rng.integers(0, len(prototypes), count).astype(np.int32)))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(positions, np.float32)))
    turn = rng.uniform(0, np.pi, count)
    quaternions = np.zeros((count, 4), np.float16)  # numpy order of GfQuath: imaginary, real
    quaternions[:, 1], quaternions[:, 3] = np.sin(turn), np.cos(turn)
    instancer.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(quaternions))
    scale = rng.uniform(*scales, count).astype(np.float32)
    instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(np.repeat(scale[:, None], 3, 1)))
    return instancer


def _OnGround(rng, count, side):
    place = rng.uniform(-side / 2, side / 2, (count, 2))
    return np.stack([place[:, 0], _Height(place[:, 0], place[:, 1], side), place[:, 1]], 1)


def _Leaf(quads: int) -> shapes.Shape:
    """A curled leaf 0.3 long."""
    rows = max(1, quads // 4)
    leaf = shapes.Plane(0.3, 0.08, 4, rows)
    points = leaf.points.copy()
    points[:, 1] += 0.4 * points[:, 0] ** 2 - points[:, 2] ** 2
    return shapes.Shape(points, leaf.counts, leaf.indices)


class _Writer:
    def __init__(self, path, size: float):
        self.path = pathlib.Path(path)
        self.size = size
        self.side = _SIDE * size**0.5
        self.folder = self.path.with_suffix("")
        self.folder.mkdir(parents=True, exist_ok=True)
        self.counts = {name: 0 for name in ("meshes", "unique quads", "grass blades", "instancers", "instances stored",
                                            "instances placed", "quads placed")}

    def Count(self, count: float, least: int = 1) -> int:
        return max(least, round(count * self.size))

    def _Mesh(self, stage, path, shape, placed=1, **options):
        author.AddMesh(stage, path, shape, **options)
        self.counts["meshes"] += 1
        self.counts["unique quads"] += len(shape.counts)
        self.counts["quads placed"] += placed * len(shape.counts)

    def _Placed(self, stage, path, prototypes, positions, rng, **options):
        _Instancer(stage, path, prototypes, positions, rng, **options)
        self.counts["instancers"] += 1
        self.counts["instances stored"] += len(positions)

    def Ground(self, root) -> None:
        cells = max(8, round(self.Count(80e6 / TILES) ** 0.5))
        edge = int(TILES**0.5)
        width = self.side / edge
        for i in range(TILES):
            x0, z0 = (i % edge - edge / 2 + 0.5) * width, (i // edge - edge / 2 + 0.5) * width
            stage = _Part(self.folder, f"Ground{i}")
            tile = shapes.Plane(width, width, cells, cells)
            points = tile.points + [x0, 0, z0]
            points[:, 1] = _Height(points[:, 0], points[:, 2], self.side)
            self._Mesh(stage, f"/Ground{i}/Mesh", shapes.Shape(points, tile.counts, tile.indices), color=(0.3, 0.24, 0.15))
            stage.GetRootLayer().Save()
            _Refer(root, self.folder, f"Ground{i}")

    def Trees(self, root) -> None:
        rng = np.random.default_rng(1)
        count, placed = self.Count(2400, 4), self.Count(1e6, 100)
        numFiles = -(-count // TREES_A_FILE)
        for file in range(numFiles):
            stage = _Part(self.folder, f"Trees{file}")
            names = []
            for i in range(file * TREES_A_FILE, min(count, (file + 1) * TREES_A_FILE)):
                shade = rng.uniform(0.7, 1.3)
                names.append(f"/Trees{file}/Forest/Prototypes/Tree{i}")
                self._Mesh(stage, names[-1], grove._Tree(rng, round(2.1 * TREE_QUADS)), placed / count,
                           color=(0.16 * shade, 0.34 * shade, 0.1), doubleSided=True)
            share = placed * (file + 1) // numFiles - placed * file // numFiles
            self._Placed(stage, f"/Trees{file}/Forest", names, _OnGround(rng, share, self.side), rng)
            stage.GetRootLayer().Save()
            _Refer(root, self.folder, f"Trees{file}")
        self.counts["instances placed"] += placed

    def Plants(self, root) -> None:
        rng = np.random.default_rng(2)
        placed = self.Count(4e5, 100)
        stage = _Part(self.folder, "Plants")
        names = []
        each = placed / PLANTS
        for i in range(PLANTS):
            path = f"/Plants/Field/Prototypes/Plant{i}"
            UsdGeom.Xform.Define(stage, path)
            names.append(path)
            self._Mesh(stage, f"{path}/Stem", shapes.Lathe([0.05, 0.03, 0.0], [0.0, 1.0, 2.0], 12, [1, 1, 1], [0, 0, 0]), each,
                       color=(0.25, 0.16, 0.08))
            leaf = f"{path}/Leaves/Prototypes/Leaf"
            at = rng.normal(0, 0.5, (LEAVES, 3)) * [1, 0.7, 1] + [0, 1.4, 0]
            self._Placed(stage, f"{path}/Leaves", [leaf], at, rng)
            self._Mesh(stage, leaf, _Leaf(LEAF_QUADS), each * LEAVES, color=(0.12, 0.3 + 0.01 * i, 0.08), doubleSided=True)
        self._Placed(stage, "/Plants/Field", names, _OnGround(rng, placed, self.side), rng)
        stage.GetRootLayer().Save()
        _Refer(root, self.folder, "Plants")
        self.counts["instances placed"] += placed * LEAVES + placed

    def Pebbles(self, root) -> None:
        """Small meshes of their own, in world space."""
        rng = np.random.default_rng(3)
        count = self.Count(1e6, 100)
        ball = shapes.Sphere(0.2, 6, PEBBLE_QUADS // 6)
        counts, indices = (Vt.IntArray.FromNumpy(np.ascontiguousarray(a, np.int32)) for a in (ball.counts, ball.indices))
        for start in range(0, count, PEBBLES_A_FILE):
            name = f"Pebbles{start // PEBBLES_A_FILE}"
            stage = _Part(self.folder, name)
            end = min(count, start + PEBBLES_A_FILE)
            places = _OnGround(rng, end - start, self.side)
            colors = rng.uniform(0.2, 0.6, (end - start, 3))
            with Sdf.ChangeBlock():
                for i in range(end - start):
                    points = ball.points * rng.uniform(0.5, 1.5, 3) + rng.normal(0, 0.01, ball.points.shape) + places[i]
                    bench._AddMeshSpec(stage.GetRootLayer(), f"/{name}/Mesh{i}", points, counts, indices, colors[i])
            stage.GetRootLayer().Save()
            _Refer(root, self.folder, name)
        self.counts["meshes"] += count
        self.counts["unique quads"] += count * len(ball.counts)
        self.counts["quads placed"] += count * len(ball.counts)

    def Scattered(self, root) -> None:
        rng = np.random.default_rng(4)
        placed = self.Count(37.7e6, 1000)
        numFiles = 10
        for file in range(numFiles):
            stage = _Part(self.folder, f"Scattered{file}")
            share = placed * (file + 1) // numFiles - placed * file // numFiles
            names = []
            for i in range(SCATTERED // numFiles):
                names.append(f"/Scattered{file}/Things/Prototypes/Thing{i}")
                self._Mesh(stage, names[-1], shapes.Sphere(0.1 + 0.01 * file, 10, 15), share / (SCATTERED // numFiles),
                           color=tuple(rng.uniform(0.2, 0.7, 3)))
            self._Placed(stage, f"/Scattered{file}/Things", names, _OnGround(rng, share, self.side), rng, scales=(0.3, 1.5))
            stage.GetRootLayer().Save()
            _Refer(root, self.folder, f"Scattered{file}")
        self.counts["instances placed"] += placed

    def Grass(self, root) -> None:
        rng = np.random.default_rng(5)
        patches = self.Count(250, 2)
        stage = _Part(self.folder, "Grass")
        names = []
        along = np.linspace(0, 1, 4)
        for i in range(patches):
            roots = rng.uniform(-6, 6, (BLADES_A_PATCH, 1, 3)) * [1, 0, 1]
            lean = rng.normal(0, 0.15, (BLADES_A_PATCH, 1, 3)) * [1, 0, 1]
            tall = rng.uniform(0.2, 0.6, (BLADES_A_PATCH, 1, 1))
            points = roots + along[:, None] * tall * [0, 1, 0] + along[:, None] ** 2 * lean
            names.append(f"/Grass/Meadows/Prototypes/Patch{i}")
            prim = UsdGeom.BasisCurves.Define(stage, names[-1])
            prim.CreateTypeAttr("cubic")
            prim.CreateBasisAttr("bspline")
            prim.CreateWrapAttr("pinned")
            prim.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(BLADES_A_PATCH, 4, np.int32)))
            prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.reshape(-1, 3).astype(np.float32)))
            prim.CreateWidthsAttr(Vt.FloatArray([0.012]))
            prim.SetWidthsInterpolation("constant")
            prim.CreateDisplayColorAttr([Gf.Vec3f(0.2, 0.4, 0.1)])
        self._Placed(stage, "/Grass/Meadows", names, _OnGround(rng, 4 * patches, self.side), rng, scales=(0.9, 1.1))
        stage.GetRootLayer().Save()
        _Refer(root, self.folder, "Grass")
        self.counts["grass blades"] += patches * BLADES_A_PATCH
        self.counts["instances placed"] += 4 * patches

    def Write(self) -> dict:
        root = author.NewStage(str(self.path))
        for part in (self.Ground, self.Trees, self.Plants, self.Pebbles, self.Scattered, self.Grass):
            part(root)
        author.AddLight(root, "/World/Sun", "Distant", dict(rotate=(-40, 30, 0)), intensity=2.0, angle=1.0, normalize=True)
        author.AddLight(root, "/World/Dome", "Dome", intensity=0.5, color=(0.7, 0.85, 1.0))
        at = 0.45 * self.side
        ground = float(_Height(np.array(0.0), np.array(at), self.side))
        author.AddCamera(root, "/World/Camera", eye=(0, ground + 0.03 * self.side, at), target=(0, 0.03 * self.side, 0), aspect=1024 / 429)
        author.AddCamera(root, "/World/Inside", eye=(3, ground + 3, at), target=(3, ground + 2.5, at - 10), aspect=1024 / 429)
        root.GetRootLayer().Save()
        return {name: int(round(value)) for name, value in self.counts.items()}


def WriteArchipelago(path, islandPath, count: int, size: float) -> None:
    """Writes PATH: `count` islands of that size, all of them the one at islandPath (WriteIsland), placed by one point instancer on
    a square grid. /World/Camera sees all of them from above, /World/Inside stands on one."""
    path, parts = pathlib.Path(path), sorted(pathlib.Path(islandPath).with_suffix("").glob("*.usdc"))
    side = _SIDE * size**0.5
    edge = math.ceil(count**0.5)
    extent = edge * side
    root = author.NewStage(str(path))
    prototype = "/World/Sea/Prototypes/Island"
    for part in parts:
        root.DefinePrim(f"{prototype}/{part.stem}").GetReferences().AddReference(os.path.relpath(part, path.parent))
    instancer = UsdGeom.PointInstancer.Define(root, "/World/Sea")
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path(prototype)])
    instancer.CreateProtoIndicesAttr(Vt.IntArray(count, 0))
    at = np.array([((i % edge - (edge - 1) / 2) * side, 0, (i // edge - (edge - 1) / 2) * side) for i in range(count)], np.float32)
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(at))
    author.AddLight(root, "/World/Sun", "Distant", dict(rotate=(-40, 30, 0)), intensity=2.0, angle=1.0, normalize=True)
    author.AddLight(root, "/World/Dome", "Dome", intensity=0.5, color=(0.7, 0.85, 1.0))
    author.AddCamera(root, "/World/Camera", eye=(0, 0.5 * extent, 0.9 * extent), target=(0, 0, 0), aspect=1024 / 429)
    x, _, z = (float(value) for value in at[0])
    ground = float(_Height(np.array(3.0), np.array(0.45 * side), side))
    author.AddCamera(root, "/World/Inside", eye=(x + 3, ground + 3, z + 0.45 * side), target=(x + 3, ground + 2.5, z + 0.45 * side - 10),
                     aspect=1024 / 429)
    for camera in ("Camera", "Inside"):
        UsdGeom.Camera(root.GetPrimAtPath(f"/World/{camera}")).GetClippingRangeAttr().Set(Gf.Vec2f(0.01, 10 * extent))
    root.GetRootLayer().Save()


def WriteIsland(path, size: float = 0.01) -> dict:
    """Writes PATH and a folder of its name with the parts. Returns what is in it, by name."""
    return _Writer(path, size).Write()
