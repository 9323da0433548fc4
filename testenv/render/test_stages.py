# SPDX-License-Identifier: Apache-2.0
"""The generated stages and the tests' own tools hold what they promise. Needs no renderer."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom

import compare
import stageReader
from stages import bench, demo, imageFile, shapes
from stages.verify import CASES


@pytest.mark.parametrize("half", [True, False])
def test_exr_round_trip(half, tmp_path):
    """What is written is read back exactly (half floats: as rounded by numpy)."""
    rng = np.random.default_rng(1)
    channels = {name: rng.normal(size=(37, 23)).astype(np.float32) for name in ("R", "G", "depth.Z")}
    imageFile.WriteExr(f"{tmp_path}/a.exr", channels, half)
    back = imageFile.ReadExr(f"{tmp_path}/a.exr")
    assert set(back) == set(channels)
    for name, plane in channels.items():
        np.testing.assert_array_equal(back[name], plane.astype(np.float16).astype(np.float32) if half else plane)


def _IsClosed(shape: shapes.Shape) -> bool:
    """Every directed edge between positions has its opposite: closed and consistently wound."""
    keys = np.unique(np.round(shape.points, 9), axis=0, return_inverse=True)[1].ravel()[shape.indices]
    edges, start = {}, 0
    for count in shape.counts:
        face = keys[start : start + count]
        for a, b in zip(face, np.roll(face, -1)):
            edges[(a, b)] = edges.get((a, b), 0) + 1
        start += count
    return all(edges.get((b, a)) == n for (a, b), n in edges.items())


@pytest.mark.parametrize("shape,volume", [
    (shapes.Box(1, 2, 3), 6.0), (shapes.Sphere(1, 64, 128), 4 / 3 * np.pi), (shapes.Torus(1, 0.3), 2 * np.pi**2 * 0.09),
    (shapes.Prism(shapes.StarOutline(5, 1.0, 0.4), 0.5), 0.5 * 5 * np.sin(np.pi / 5) * 0.4)], ids=["box", "sphere", "torus", "prism"])
def test_closed_shapes_face_outward(shape, volume):
    """Closed, with the volume of the formula (divergence theorem; tessellation loses at most 1 %)."""
    assert _IsClosed(shape)
    corners, _ = stageReader.Triangulate(shape.points, shape.counts, shape.indices, [])
    p = shape.points[shape.indices[corners]]
    assert np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])).sum() / 6 == pytest.approx(volume, rel=0.01)
    if shape.normals is not None:
        n = shape.normals[shape.indices[corners]].mean(1)
        assert (np.einsum("ij,ij->i", n, np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])) >= -1e-12).all()


@pytest.mark.parametrize("name", sorted(CASES))
def test_case_composes_and_is_read(name, tmp_path):
    """Every case opens without composition errors and the tests' reader understands it."""
    path = CASES[name].Write(f"{tmp_path}/stage.usda")
    assert not Usd.Stage.Open(path).GetCompositionErrors()
    scene = stageReader.ReadStage(path)
    assert scene.parts or scene.lights
    for part in scene.parts:
        assert np.isfinite(part.positions).all()


def _CountTriangles(path: str) -> int:
    stage = Usd.Stage.Open(path)
    return sum(int(np.sum(np.array(UsdGeom.Mesh(p).GetFaceVertexCountsAttr().Get()) - 2)) for p in stage.Traverse() if p.IsA(UsdGeom.Mesh))


def test_demo_keeps_its_budget(tmp_path):
    demo.WriteDemo(f"{tmp_path}/demo.usdc")
    assert 50_000 < _CountTriangles(f"{tmp_path}/demo.usdc") <= 200_000


def test_bench_scenes_have_their_sizes(tmp_path):
    bench.WriteTerrain(f"{tmp_path}/terrain.usdc", 20)
    assert _CountTriangles(f"{tmp_path}/terrain.usdc") == 800 + 3 * (64 * 128 * 2 - 2 * 128)
    bench.WriteForest(f"{tmp_path}/forest.usdc", 50)
    stage = Usd.Stage.Open(f"{tmp_path}/forest.usdc")
    assert len(UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/Forest")).GetPositionsAttr().Get()) == 50
    bench.WriteMeshes(f"{tmp_path}/meshes.usdc", 30)
    stage = Usd.Stage.Open(f"{tmp_path}/meshes.usdc")
    assert sum(p.IsA(UsdGeom.Mesh) for p in stage.Traverse()) == 30


def test_measures_can_fail():
    """relMSE and the block test see a small bias and pass pure noise."""
    rng = np.random.default_rng(2)
    truth, deviation = np.full((90, 120), 0.5), 0.05
    a, b = (truth + rng.normal(0, deviation, truth.shape) for _ in range(2))
    variance = np.full(truth.shape, deviation**2)
    limit = compare.ZLimit(9 * 12)
    assert compare.BlockZ(a, variance, b, variance).max() < limit
    biased = a.copy()
    biased[10:20, 10:20] *= 1.1
    assert compare.BlockZ(biased, variance, b, variance).max() > limit
    assert compare.RelMse(1.1 * truth, truth) == pytest.approx(0.0025 / 0.26)
