# SPDX-License-Identifier: Apache-2.0
"""Lines loaded over the lines that footprints touch: textureFootprints.py FOLDER [--count 962] [--size 2048] [--height 720]

A brute-force tracer in double precision, which shares no code with the renderer: each sample of each pixel of the stress stage
(testenv/stages/textureStress.py, made in FOLDER when it is not there) is put on every card that it may hit; the pixel's corners
give the footprint; the filter's definition (docs/texturing.md: trilinear, mip by the minor axis, 8 times finer than the major
axis at most) gives the texels, and those the lines. Camera rays alone, `maxDepth 0`. Bar: 1.5 times as many at most.
"""

import argparse
import pathlib
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.recordRun import Record  # noqa: E402
from pxr import Usd, UsdGeom  # noqa: E402
from stages import textureStress  # noqa: E402

_LINE = 16  # texels a side of a line of RGB at 8 bits
_SHARED = 8  # mips of this size and smaller are in a texture's last line
_ANISOTROPY = 8.0


class _Camera:
    """Rays of a perspective camera: origin + direction(x, y), with x and y in pixels from the top left."""

    def __init__(self, stage, width: int, height: int):
        camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera")).GetCamera(Usd.TimeCode.Default())
        matrix = np.array(camera.transform)
        window = camera.frustum.GetWindow()
        (left, bottom), (right, top) = window.GetMin(), window.GetMax()
        across, up, back = matrix[0, :3], matrix[1, :3], matrix[2, :3]
        self.origin = matrix[3, :3]
        self._base = left * across + top * up - back
        self._dx, self._dy = (right - left) / width * across, (bottom - top) / height * up

    def Directions(self, x, y):
        return self._base + x[..., None] * self._dx + y[..., None] * self._dy


class _Card:
    """A parallelogram with texture coordinates 0 to 1 along its sides."""

    def __init__(self, points, origin):
        self.corners = points
        first, second = points[1] - points[0], points[3] - points[0]
        normal = np.cross(first, second)
        self._plane = (points[0] - origin) @ normal
        self._normal, self._offset = normal, origin - points[0]
        self._dual = np.stack([np.cross(second, normal), np.cross(normal, first)]) / (normal @ normal)

    def Hit(self, directions):
        """Distances (in lengths of the directions) and texture coordinates [..., 2]."""
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = self._plane / (directions @ self._normal)
            return distance, (self._offset + distance[..., None] * directions) @ self._dual.T


def _Pixels(camera, card, width: int, height: int):
    """The pixels that a card's summary may reach, or None."""
    matrix = np.stack([camera._dx, camera._dy, camera._base], axis=1)
    projected = np.linalg.solve(matrix, (card.corners - camera.origin).T).T
    assert (projected[:, 2] > 0).all(), "a card is behind the camera"
    place = projected[:, :2] / projected[:, 2:]
    low = np.clip(np.floor(place.min(axis=0)).astype(int), 0, (width, height))
    high = np.clip(np.ceil(place.max(axis=0)).astype(int), 0, (width, height))
    if (low >= high).any():
        return None
    return np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))


def _Levels(camera, card, x, y, size: int):
    """Fractional mips of footprints one pixel wide about (x, y)."""
    st = [card.Hit(camera.Directions(x + dx, y + dy))[1] for dx, dy in ((0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5))]
    jacobian = np.stack([st[0] - st[1], st[2] - st[3]], axis=-1) * size
    axes = np.linalg.svd(jacobian, compute_uv=False)
    minor = np.maximum(axes[..., 1], axes[..., 0] / _ANISOTROPY)
    return np.clip(np.log2(np.maximum(minor, 1e-30)), 0.0, np.log2(size))


def _Lines(levels, st, size: int) -> set:
    """(mip, y, x) of the lines that trilinear look-ups read; (-1, 0, 0) is the shared one."""
    lines = set()
    base = np.floor(levels).astype(int)
    for mip in np.unique(np.concatenate([base, base[levels > base] + 1])):
        isRead = (base == mip) | ((base == mip - 1) & (levels > base))
        side = max(1, size >> int(mip))
        if side <= _SHARED:
            lines.add((-1, 0, 0))
            continue
        texel = np.floor(np.stack([st[isRead, 0], 1.0 - st[isRead, 1]], axis=-1) * side - 0.5).astype(int)
        for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
            place = np.clip(texel + (dx, dy), 0, side - 1) // _LINE
            lines |= {(int(mip), int(row), int(column)) for column, row in np.unique(place, axis=0)}
    return lines


def _TouchedLines(stage, width: int, height: int, samples: int, size: int) -> int:
    """Lines of all cards, each with its last one, which is loaded when a texture is opened."""
    camera = _Camera(stage, width, height)
    meshes = [UsdGeom.Mesh(prim) for prim in stage.GetPrimAtPath("/World/Cards").GetChildren()]
    cards = [_Card(np.array(mesh.GetPointsAttr().Get(), dtype=float), camera.origin) for mesh in meshes]
    mirror = stage.GetPrimAtPath("/World/Mirror")
    centre = np.array(UsdGeom.Xformable(mirror).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))[3, :3] - camera.origin
    radius = np.linalg.norm(np.array(UsdGeom.Mesh(mirror).GetPointsAttr().Get()), axis=1).max()
    lines, random = [set() for _ in cards], np.random.default_rng(1)
    for _ in range(samples):
        jitter = random.random((2, height, width))
        nearest, owner = np.full((height, width), np.inf), np.full((height, width), -1)
        y, x = np.mgrid[0:height, 0:width] + jitter[::-1]
        directions = camera.Directions(x, y)
        along = directions @ centre
        square = (directions ** 2).sum(axis=-1)
        under = along ** 2 - square * (centre @ centre - radius ** 2)
        nearest[under > 0] = ((along - np.sqrt(np.maximum(under, 0))) / square)[under > 0]
        found = []
        for index, card in enumerate(cards):
            pixels = _Pixels(camera, card, width, height)
            if pixels is None:
                continue
            at = (pixels[1], pixels[0])
            distance, st = card.Hit(directions[at])
            isHit = (distance > 0) & (distance < nearest[at]) & (st >= 0).all(axis=-1) & (st <= 1).all(axis=-1)
            where = (at[0][isHit], at[1][isHit])
            nearest[where], owner[where] = distance[isHit], index
            found.append((index, where, st[isHit]))
        for index, where, st in found:
            isSeen = owner[where] == index
            if isSeen.any():
                levels = _Levels(camera, cards[index], x[where][isSeen], y[where][isSeen], size)
                lines[index] |= _Lines(levels, st[isSeen], size)
    return sum(len(touched | {(-1, 0, 0)}) for touched in lines if touched)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=textureStress.COUNT)
    parser.add_argument("--size", type=int, default=textureStress.SIZE)
    parser.add_argument("--height", type=int, default=720)
    parser.add_argument("--samples", type=int, default=20)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    path = args.folder / f"stress{args.count}x{args.size}.usda"
    if not path.exists():
        textureStress.WriteTextureStress(path, args.count, args.size)
    width = args.height * 16 // 9
    touched = _TouchedLines(Usd.Stage.Open(str(path)), width, args.height, args.samples, args.size)
    run = Record(path, args.folder / "cache", camera="/World/Camera", imageWidth=width, samples=args.samples, maxDepth=0,
                 residency="stream")["texture"]
    print("| height | samples | lines that footprints touch | lines loaded | ratio | misses per look-up |")
    print("|---" * 6 + "|")
    unique = run["uniqueBytesLoaded"] // 512
    print(f"| {args.height} | {args.samples} | {touched} | {unique} | {unique / touched:.3f} | "
          f"{run['misses'] / run['lookups']:.1e} |")


if __name__ == "__main__":
    main()
