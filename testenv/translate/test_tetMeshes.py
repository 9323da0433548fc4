# SPDX-License-Identifier: Apache-2.0
"""Tetrahedral meshes are the faces that belong to one tetrahedron alone, turned outwards."""

import collections
import itertools

import numpy as np
import pytest
from pxr import Usd, UsdGeom, Vt

from hdstream.translate import meshes
from translateCase import Translate


def _Kuhn(n):
    """A cube of n^3 cells, each cut into 6 tetrahedra of positive volume (Kuhn): points, tetrahedra."""
    grid = np.stack(np.meshgrid(*[np.arange(n + 1)] * 3, indexing="ij"), -1).reshape(-1, 3)
    index = {tuple(point): i for i, point in enumerate(grid.tolist())}
    tets = []
    for cell in itertools.product(range(n), repeat=3):
        for order in itertools.permutations(range(3)):
            corners = [np.array(cell)]
            for axis in order:
                corners.append(corners[-1] + np.eye(3, dtype=int)[axis])
            a, b, c, d = corners
            tet = [index[tuple(corner.tolist())] for corner in corners]
            tets.append(tet if np.linalg.det([b - a, c - a, d - a]) > 0 else [tet[0], tet[2], tet[1], tet[3]])
    return grid.astype(float), tets


class _Still:
    """The motion of a closed shutter."""

    @staticmethod
    def PointSamplesOf(prim, names, count, warn, topology):
        return []


@pytest.mark.parametrize("n", [1, 3])
def test_faces_are_those_of_one_tetrahedron(n):
    points, tets = _Kuhn(n)
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.TetMesh.Define(stage, "/T")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    mesh.CreateTetVertexIndicesAttr(Vt.Vec4iArray.FromNumpy(np.array(tets, np.int32)))
    assert Translate(stage).Warnings() == []
    read = meshes.ReadTetMesh(mesh.GetPrim(), mesh.GetPrim().GetPropertyNames(), {}, Usd.TimeCode.Default(), _Still,
                             lambda *_: pytest.fail("a warning"))
    faces = np.array(read.faceVertexIndices).reshape(-1, 3)
    assert list(read.faceVertexCounts) == [3] * len(faces)
    uses = collections.Counter(frozenset(face) for tet in tets for face in itertools.combinations(tet, 3))
    alone = {face for face, count in uses.items() if count == 1}
    assert len(faces) == len(alone) == 12 * n * n
    assert {frozenset(face.tolist()) for face in faces} == alone
    volumes = [np.linalg.det(points[face]) / 6 for face in faces]  # divergence theorem: outwards is positive
    assert sum(volumes) == pytest.approx(n**3)
