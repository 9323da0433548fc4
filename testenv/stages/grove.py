# SPDX-License-Identifier: Apache-2.0
"""A grove: as many different trees as the wanted number of triangles takes, none of them an instance.

Each tree is one mesh of about 50 000 triangles: a bent trunk, branches, curled leaves. Two cameras: /World/Camera
looks at the grove from outside, /World/Inside stands among the trees. Light reaches nearly every tree, so that both
touch nearly all of it; with walls, higher than trees, around gardens the inner one touches one garden. Deterministic;
numpy does the work, so that 20 million triangles take a minute.
"""

import numpy as np
from pxr import Gf, Vt

from . import author, bench, shapes

TREE_TRIANGLES = 50_000
_SPACING = 7.0
_LANE = 8.0  # further apart stand trees on two sides of a wall
_WALL_HEIGHT = 12.0


def _GridQuads(rows: int, columns: int, copies: int) -> np.ndarray:
    """Corners [copies * quads * 4] of `copies` grids of rows x columns points."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing="ij")
    first = (i * columns + j).reshape(-1, 1)
    quads = first + np.array([0, 1, columns + 1, columns])
    return (np.arange(copies)[:, None, None] * rows * columns + quads).reshape(-1)


def _Frames(directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across each direction."""
    helper = np.where(np.abs(directions[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    across = np.cross(directions, helper)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(directions, across)


def _Tubes(rng, starts, directions, lengths, radii, rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and corners of bent, tapered, bumpy tubes."""
    s = np.linspace(0, 1, rows)
    angle = 2 * np.pi * np.arange(columns) / (columns - 1)
    across, other = _Frames(directions)
    bend = rng.normal(0, 0.12, (len(starts), 1, 3)) * lengths[:, None, None]
    spine = starts[:, None] + directions[:, None] * (s[:, None] * lengths[:, None, None]) + bend * s[:, None] ** 2
    bumps = 1.0 + 0.15 * rng.random((len(starts), rows, columns))
    bumps[..., -1] = bumps[..., 0]
    radius = radii[:, None, None] * (1.0 - 0.85 * s[:, None]) * bumps
    ring = np.cos(angle)[:, None] * across[:, None, None] + np.sin(angle)[:, None] * other[:, None, None]
    points = spine[:, :, None] + radius[..., None] * ring
    return points.reshape(-1, 3), _GridQuads(rows, columns, len(starts))


def _Leaves(rng, centres) -> tuple[np.ndarray, np.ndarray]:
    """Points and corners of curled leaves of 4 x 2 quads."""
    count = len(centres)
    along = rng.normal(size=(count, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across, up = _Frames(along)
    u, v = np.linspace(0, 1, 5), np.linspace(-1, 1, 3)
    width = 0.05 * np.sin(np.pi * (0.08 + 0.9 * u))
    curl = rng.uniform(-0.08, 0.08, (count, 1, 1, 1))
    points = centres[:, None, None] + along[:, None, None] * (0.22 * u[:, None, None]) \
        + across[:, None, None] * (width[:, None] * v)[..., None] + up[:, None, None] * curl * (u**2)[:, None, None]
    return points.reshape(-1, 3), _GridQuads(5, 3, count)


def _Tree(rng, triangles: int) -> shapes.Shape:
    """A tree of about `triangles`, 4 to 7 units high, its foot at the origin."""
    height = rng.uniform(4.0, 7.0)
    numBranches, numLeaves = max(4, triangles // 1250), max(8, triangles // 30)
    up = np.array([[0.0, 1.0, 0.0]])
    parts = [_Tubes(rng, np.zeros((1, 3)), up, np.array([height]), np.array([0.05 * height]), 81, 25)]
    at = rng.uniform(0.3, 0.95, numBranches)
    directions = rng.normal(size=(numBranches, 3)) * [1.0, 0.35, 1.0] + [0, 0.5, 0]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    lengths = (1.15 - at) * 0.55 * height
    parts.append(_Tubes(rng, up * (at * height)[:, None], directions, lengths, 0.02 * height * (1.1 - at), 21, 13))
    branch = rng.integers(0, numBranches, numLeaves)
    reach = rng.uniform(0.35, 1.05, (numLeaves, 1))
    centres = (up * (at * height)[:, None] + 0 * directions)[branch] + directions[branch] * lengths[branch, None] * reach
    parts.append(_Leaves(rng, centres + rng.normal(0, 0.16, (numLeaves, 3))))
    offsets = np.cumsum([0] + [len(points) for points, _ in parts[:-1]])
    indices = np.concatenate([corners + offset for (_, corners), offset in zip(parts, offsets)])
    return shapes.Shape(np.concatenate([points for points, _ in parts]), np.full(len(indices) // 4, 4), indices)


def _AddWalls(stage, at: np.ndarray) -> None:
    """Walls along both axes at these coordinates."""
    length = at[-1] - at[0]
    middle = (at[-1] + at[0]) / 2
    for i, place in enumerate(at):
        for axis, size, where in (("X", (0.4, _WALL_HEIGHT, length), (place, 0, middle)),
                                  ("Z", (length, _WALL_HEIGHT, 0.4), (middle, 0, place))):
            author.AddMesh(stage, f"/World/Walls/{axis}{i}", shapes.Box(*size), color=(0.5, 0.45, 0.4),
                           translate=(where[0], _WALL_HEIGHT / 2 - 2, where[2]))


def WriteGrove(path, triangles: int = 20_000_000, treeTriangles: int = TREE_TRIANGLES, gardens: int = 0) -> None:
    """About `triangles` unique triangles in trees of about `treeTriangles`, on uneven ground. `gardens`: so many
    walled gardens a side; 0: no walls."""
    stage = author.NewStage(path)
    rng = np.random.default_rng(17)
    count = max(1, round(triangles / treeTriangles))
    columns = int(np.ceil(np.sqrt(count)))
    perGarden = -(-columns // max(1, gardens))
    lines = _SPACING * np.arange(columns) + _LANE * (np.arange(columns) // perGarden)  # of trees
    lines -= (lines[0] + lines[-1]) / 2
    side = lines[-1] - lines[0] + _SPACING
    ground = shapes.HeightField(side + 60, max(2, min(400, 8 * columns)), bench.Bumps)
    ground.points[:, 1] *= 0.2
    author.AddMesh(stage, "/World/Ground", ground, color=(0.25, 0.2, 0.12))
    for i in range(count):
        x = lines[i % columns] + rng.uniform(-2, 2)
        z = lines[i // columns] + rng.uniform(-2, 2)
        shade = rng.uniform(0.7, 1.3)
        mesh = author.AddMesh(stage, f"/World/Trees/Tree{i}", _Tree(rng, treeTriangles), doubleSided=True,
                              color=(0.16 * shade, 0.34 * shade, 0.1), translate=(x, 0.2 * bench.Bumps(x, z), z))
        mesh.CreateExtentAttr(Vt.Vec3fArray([Gf.Vec3f(-8, -1, -8), Gf.Vec3f(8, 9, 8)]))
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-40, 30, 0)), intensity=2.0, angle=1.0, normalize=True)
    author.AddLight(stage, "/World/Dome", "Dome", intensity=0.6, color=(0.7, 0.85, 1.0))
    inside, height = _SPACING / 2, 5.0
    if gardens > 0:
        firsts = lines[::perGarden]
        halfGap = (_SPACING + _LANE) / 2
        _AddWalls(stage, np.append(firsts, lines[-1] + 2 * halfGap) - halfGap)
        inside, height = firsts[len(firsts) // 2] + _SPACING / 2, 1.5 * _WALL_HEIGHT
    author.AddCamera(stage, "/World/Camera", eye=(0, height, side / 2 + 9), target=(0, 2.5, 0), aspect=16 / 9)
    author.AddCamera(stage, "/World/Inside", eye=(inside, 2.2, inside), target=(inside - 0.5, 2.6, inside - 12.5), aspect=16 / 9)
    stage.GetRootLayer().Save()
