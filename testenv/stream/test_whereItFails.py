# SPDX-License-Identifier: Apache-2.0
"""Where streaming is at its worst: one chunk for all rays, very many objects, nothing to see, rays that start inside
chunks, surfaces at one place, edits while the pool is full. Streamed geometry has the bits of resident geometry."""

import itertools

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import Sdf, Vt
from stages import author, bench, shapes, streaming
from streamCase import Case, MovedMesh

_MESH_CHUNK = 256 << 20  # a mesh is one chunk


def _Light(stage):
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(2, 3, 2)), intensity=20.0, radius=0.4)


def _Ball(rings=24, radius=1.0):
    ball = shapes.Sphere(radius, rings, 2 * rings)
    bumps = 1.0 + 0.2 * np.sin(5 * ball.points / radius).prod(1, keepdims=True)
    return shapes.Shape(ball.points * bumps, ball.counts, ball.indices)


def test_all_rays_ask_for_one_chunk(tmp_path):
    bench.WriteTerrain(str(tmp_path / "stage.usda"), cells=120)
    case = Case(tmp_path / "stage.usda").RenderResident(noCache=True, chunkBytes=_MESH_CHUNK)
    settings = dict(noCache=True, chunkBytes=_MESH_CHUNK)
    geometry = case.Fresh().AssertStreams(geometryMemory="64M", **settings)
    assert geometry["chunks"] == 4 and geometry["evictions"] == 0
    with pytest.raises(case.core.Error, match="which takes") as error:
        case.Fresh().Render(residency="stream", geometryMemory="4K", **settings)
    largest = str(error.value).split("which takes ")[1].split()[0]
    for eviction in ("lru", "flush"):
        geometry = case.Fresh().AssertStreams(geometryMemory=largest, geometryEviction=eviction, **settings)
        assert geometry["chunksTouched"] == 4


def test_very_many_tiny_objects(tmp_path):
    bench.WriteMeshes(str(tmp_path / "stage.usdc"), meshes=20_000)
    case = Case(tmp_path / "stage.usdc").RenderResident(noCache=True)
    assert case.statistics["geometry"]["chunks"] == 20_000
    for settings in (dict(geometryMemory="64M"), dict(geometryMemory="100K", geometryEviction="flush")):
        geometry = case.AssertStreams(noCache=True, **settings)
        assert 0 < geometry["chunksTouched"] < geometry["chunks"]


def test_all_rays_miss(tmp_path):
    """Nothing is loaded and nothing is built."""
    stage = author.NewStage(tmp_path / "stage.usda")
    for i in range(6):
        author.AddMesh(stage, f"/World/Ball{i}", _Ball(), translate=(3 * i, 0, 20))
    _Light(stage)
    author.AddCamera(stage, eye=(0, 0, 5))
    stage.GetRootLayer().Save()
    case = Case(tmp_path / "stage.usda").RenderResident(noCache=True)
    geometry = case.Fresh().AssertStreams(noCache=True, geometryMemory="64M")
    assert geometry["chunksTouched"] == geometry["chunksBuilt"] == geometry["uploadedBytes"] == 0 < geometry["chunks"]
    assert geometry["iterations"] == geometry["rayBatches"]


@pytest.mark.parametrize("chunkBytes", [4096, _MESH_CHUNK], ids=["manyChunks", "oneChunk"])
def test_camera_inside_chunks(tmp_path, chunkBytes):
    stage = author.NewStage(tmp_path / "stage.usda")
    for i in range(4):
        author.AddMesh(stage, f"/World/Ball{i}", _Ball(radius=1.0 + i), doubleSided=True, color=(0.8, 0.2 * i, 0.3))
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(0.2, 0.3, 0)), intensity=20.0, radius=0.1)
    author.AddCamera(stage, eye=(0, 0, 0.3), target=(1, 0.2, 0))
    stage.GetRootLayer().Save()
    case = Case(tmp_path / "stage.usda").RenderResident(noCache=True, chunkBytes=chunkBytes)
    for pool in ("100%", "30%"):  # a ball is more than a quarter
        geometry = case.Fresh().AssertStreams(noCache=True, chunkBytes=chunkBytes, geometryMemory=pool)
        assert geometry["chunksTouched"] > 0


def _WriteTies(path):
    """The same grid in three meshes of several colours, and in a mesh that has it twice."""
    stage = author.NewStage(path)
    grid = shapes.HeightField(4.0, 24, bench.Bumps)
    colors = [(0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.9)]
    for i, color in enumerate(colors):
        author.AddMesh(stage, f"/World/Grid{2 - i}", grid, color=color, doubleSided=True)
    twice = shapes.Merged([grid, grid])
    mesh = author.AddMesh(stage, "/World/Twice", twice, doubleSided=True, translate=(4, 0, 0))
    faces = len(grid.counts)
    values = np.repeat(np.array([[0.9, 0.9, 0.1], [0.1, 0.9, 0.9]], np.float32), faces, 0)
    author.AddPrimvar(mesh, "displayColor", Sdf.ValueTypeNames.Color3fArray, "uniform", Vt.Vec3fArray.FromNumpy(values))
    _Light(stage)
    author.AddCamera(stage, eye=(1, 4, 6), target=(1.5, 0, 0))
    stage.GetRootLayer().Save()


def test_equal_distances(tmp_path):
    """Which of several surfaces at one place is seen does not depend on what was loaded first."""
    _WriteTies(tmp_path / "stage.usda")
    case = Case(tmp_path / "stage.usda").RenderResident(noCache=True)
    assert len(np.unique(case.layers["primId"])) == 3, "none, one of three, and the one with two faces at one place"
    fresh = case.Fresh()
    for pool, eviction, request in itertools.product(("100%", "15%"), ("lru", "flush"), ("list", "first")):
        fresh.AssertStreams(noCache=True, geometryMemory=pool, geometryEviction=eviction, request=request)


def test_meshes_of_few_triangles(tmp_path):
    """No points, no faces, faces that are not drawn, and 1, 2 and 3 triangles."""
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 2, 0.0]])
    faces = {"None": ([], []), "One": ([3], [0, 1, 2]), "Two": ([3, 3], [0, 1, 2, 0, 2, 3]), "Quad": ([4], [0, 1, 2, 3]),
             "Three": ([4, 3], [0, 1, 2, 3, 3, 2, 4]), "Flat": ([3], [0, 0, 1]), "Thin": ([2], [0, 1]), "Wrong": ([3], [0, 1, 99])}
    stage = author.NewStage(tmp_path / "stage.usda")
    for i, (name, (counts, indices)) in enumerate(faces.items()):
        shape = shapes.Shape(points, np.array(counts, int), np.array(indices, int))
        author.AddMesh(stage, f"/World/{name}", shape, doubleSided=True, translate=(2.5 * (i % 4) - 4, 3 * (i // 4) - 2, 0))
    stage.DefinePrim("/World/Nothing", "Mesh")
    _Light(stage)
    author.AddCamera(stage, eye=(0, 0, 12))
    stage.GetRootLayer().Save()
    case = Case(tmp_path / "stage.usda").RenderResident(noCache=True)
    assert case.statistics["geometry"]["chunks"] == 4 and case.statistics["geometry"]["triangles"] == 8
    for pool in ("100%", "40%"):
        case.Fresh().AssertStreams(noCache=True, geometryMemory=pool)
    only = author.NewStage(tmp_path / "empty.usda")
    author.AddMesh(only, "/World/None", shapes.Shape(points, np.array([], int), np.array([], int)))
    _Light(only)
    author.AddCamera(only)
    only.GetRootLayer().Save()
    nothing = Case(tmp_path / "empty.usda").RenderResident(noCache=True)
    for settings in (dict(geometryMemory="64M"), dict(geometryMemory="30%"), dict(geometryMemory="64M", prepare="eager")):
        nothing.Fresh().AssertStreams(noCache=True, **settings)


# --- Edits ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("eviction", ["lru", "flush"])
@pytest.mark.parametrize("stopsAt", [0, 3], ids=["complete", "stopped"])
def test_edits_between_renders(tmp_path, eviction, stopsAt):
    """Meshes change, go, come back and hide while the pool is full, also after a render that was stopped in the middle.
    A session that has seen all edits gives the picture of one that knows only their result."""
    path = tmp_path / "stage.usda"
    streaming.WriteOverlap(str(path), meshes=8, rings=16)
    case, other = Case(path), Case(path)
    meshes = dict(case.session.Scene().geometry)
    settings = dict(noCache=True, geometryMemory="150K", geometryEviction=eviction, hostMemory=1 << 18)
    moved = MovedMesh(case.core, meshes["/World/Ball3"], (0.3, 0.2, 0.1))
    hidden = meshes["/World/Ball5"]
    edits = [
        lambda session: session.SetGeometry("/World/Ball3", moved),
        lambda session: session.Remove("/World/Ball0"),
        lambda session: session.SetGeometry("/World/New", MovedMesh(case.core, meshes["/World/Ball1"], (0.5, 0.5, 0.5))),
        lambda session: (setattr(hidden.placement, "visible", False), session.SetGeometry("/World/Ball5", hidden)),
        lambda session: session.SetGeometry("/World/Ball0", MovedMesh(case.core, meshes["/World/Ball2"], (-0.2, 0.4, 0.0))),
        lambda session: (setattr(hidden.placement, "visible", True), session.SetGeometry("/World/Ball5", hidden)),
    ]
    case.RenderResident(noCache=True)
    case.AssertStreams(**settings)
    for edit in edits:
        if stopsAt > 0:
            reports = iter(range(1000))
            result = case.Start(lambda progress: next(reports) < stopsAt, residency="stream", samples=64, **settings)
            assert result == case.core.RenderResult.Stopped
        edit(case.session)
        edit(other.session)
        other.RenderResident(noCache=True)
        case.layers, case.statistics = other.layers, other.statistics
        geometry = case.AssertStreams(**settings)
        assert geometry["budget"] <= 150 << 10
