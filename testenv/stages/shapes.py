# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes as numpy arrays, made from formulas.

Invariant: counter-clockwise winding seen from outside (right handed), normals of unit length where
present, every quad planar except where a function says otherwise. Object space, Y up.
"""

from dataclasses import dataclass, field, replace

import numpy as np


@dataclass(frozen=True)
class Shape:
    """A polygon mesh: points [n][3], counts [faces], indices [corners], normals [n][3] or None."""

    points: np.ndarray
    counts: np.ndarray
    indices: np.ndarray
    normals: np.ndarray | None = None
    texcoords: np.ndarray | None = None  # [n][2], by point
    extra: dict = field(default_factory=dict)

    @property
    def numTriangles(self) -> int:
        return int(np.sum(self.counts - 2))

    def Moved(self, offset, scale=1.0) -> "Shape":
        """The shape scaled uniformly, then translated."""
        return replace(self, points=self.points * scale + np.asarray(offset, float))


def _GridIndices(rows: int, columns: int, wrapColumns: bool) -> np.ndarray:
    """Quads between `rows` x `columns` points (row major), counter-clockwise for u right, v up."""
    numColumns = columns if wrapColumns else columns - 1
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(numColumns), indexing="ij")
    i, j = i.ravel(), j.ravel()
    k = (j + 1) % columns
    return np.stack([i * columns + j, i * columns + k, (i + 1) * columns + k, (i + 1) * columns + j], 1)


def Plane(width: float = 1.0, depth: float = 1.0, rows: int = 1, columns: int = 1) -> Shape:
    """The xz plane at y = 0, normal +y, with texture coordinates (0..1, v along -z)."""
    x = np.linspace(-0.5, 0.5, columns + 1)
    z = np.linspace(0.5, -0.5, rows + 1)
    gz, gx = np.meshgrid(z, x, indexing="ij")
    points = np.stack([gx * width, np.zeros_like(gx), gz * depth], -1).reshape(-1, 3)
    quads = _GridIndices(rows + 1, columns + 1, False)
    texcoords = np.stack([gx + 0.5, 0.5 - gz], -1).reshape(-1, 2)
    normals = np.tile([0.0, 1.0, 0.0], (len(points), 1))
    return Shape(points, np.full(len(quads), 4), quads.ravel(), normals, texcoords)


def Box(width: float = 1.0, height: float = 1.0, depth: float = 1.0) -> Shape:
    """An axis-aligned box about the origin; 8 points, flat faces, no normals."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return Shape(corners * np.array([width, height, depth]) / 2, np.full(6, 4), quads.ravel())


def Lathe(radii, heights, segments: int, normalsRadial, normalsUp) -> Shape:
    """A profile (radius, height, normal) from bottom to top, turned about y. Rings of radius 0 are
    poles: their quads become triangles."""
    radii, heights = np.asarray(radii, float), np.asarray(heights, float)
    angle = -2 * np.pi * np.arange(segments) / segments  # clockwise from above: outside is in front
    c, s = np.cos(angle), np.sin(angle)
    ring = lambda r, y: np.stack([np.outer(r, c), np.repeat(y[:, None], segments, 1), np.outer(r, s)], -1)
    points = ring(radii, heights).reshape(-1, 3)
    normals = ring(np.asarray(normalsRadial, float), np.asarray(normalsUp, float)).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    counts, indices = [], []
    for quad in _GridIndices(len(radii), segments, True):
        rowLow, rowHigh = quad[0] // segments, quad[3] // segments
        corners = list(quad)
        if radii[rowLow] == 0:
            corners = [quad[0], quad[2], quad[3]]
        elif radii[rowHigh] == 0:
            corners = [quad[0], quad[1], quad[2]]
        counts.append(len(corners))
        indices.extend(corners)
    return Shape(points, np.array(counts), np.array(indices), normals)


def Sphere(radius: float = 1.0, rings: int = 64, segments: int = 128) -> Shape:
    """A dense sphere with exact normals."""
    theta = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    radii = np.cos(theta)
    radii[[0, -1]] = 0.0
    return Lathe(radius * radii, radius * np.sin(theta), segments, np.cos(theta), np.sin(theta))


def Torus(radius: float, tube: float, segments: int = 96, sides: int = 48) -> Shape:
    """A torus about the y axis with exact normals."""
    phi = -2 * np.pi * np.arange(segments + 1) / segments
    theta = 2 * np.pi * np.arange(sides + 1) / sides
    p, t = np.meshgrid(phi[:-1], theta[:-1], indexing="ij")
    normals = np.stack([np.cos(t) * np.cos(p), np.sin(t), np.cos(t) * np.sin(p)], -1)
    centres = radius * np.stack([np.cos(p), np.zeros_like(p), np.sin(p)], -1)
    points = (centres + tube * normals).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(segments), np.arange(sides), indexing="ij")
    i, j, ii, jj = i.ravel(), j.ravel(), (i.ravel() + 1) % segments, (j.ravel() + 1) % sides
    quads = np.stack([i * sides + j, ii * sides + j, ii * sides + jj, i * sides + jj], 1)
    return Shape(points, np.full(len(quads), 4), quads.ravel(), normals.reshape(-1, 3))


def Prism(summary: np.ndarray, height: float) -> Shape:
    """A polygon summary [n][2] in xz (counter-clockwise seen from above, may be concave) extruded
    upwards from y = 0: two n-gons and n quads, no normals."""
    n = len(summary)
    base = np.stack([summary[:, 0], np.zeros(n), -summary[:, 1]], 1)
    points = np.concatenate([base, base + [0.0, height, 0.0]])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    indices = list(range(n - 1, -1, -1)) + list(range(n, 2 * n)) + [k for side in sides for k in side]
    return Shape(points, np.array([n, n] + [4] * n), np.array(indices))


def StarOutline(spikes: int, outer: float, inner: float) -> np.ndarray:
    """A star polygon [2 * spikes][2], concave at every second corner."""
    angle = np.pi * np.arange(2 * spikes) / spikes + np.pi / 2
    radius = np.where(np.arange(2 * spikes) % 2 == 0, outer, inner)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)


def HeightField(size: float, cells: int, height) -> Shape:
    """A square of 2 * cells^2 triangles over xz with y = height(x, z) and no normals."""
    axis = np.linspace(-size / 2, size / 2, cells + 1)
    z, x = np.meshgrid(-axis, axis, indexing="ij")
    points = np.stack([x, height(x, z), z], -1).reshape(-1, 3)
    quads = _GridIndices(cells + 1, cells + 1, False)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], 1).reshape(-1, 3)
    return Shape(points, np.full(len(triangles), 3), triangles.ravel())


def Merged(shapes: list[Shape]) -> Shape:
    """All shapes as one (normals are kept when all have them)."""
    offsets = np.cumsum([0] + [len(s.points) for s in shapes[:-1]])
    normals = np.concatenate([s.normals for s in shapes]) if all(s.normals is not None for s in shapes) else None
    return Shape(np.concatenate([s.points for s in shapes]), np.concatenate([s.counts for s in shapes]),
                 np.concatenate([s.indices + o for s, o in zip(shapes, offsets)]), normals)
