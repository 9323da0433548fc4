# SPDX-License-Identifier: Apache-2.0
"""Voxels that stream: volumeStreaming.py FOLDER [--size 768] [--total] [--short]

A generated cloud (testenv/stages/denseCloud.py; made in FOLDER, about 1.1 GB of bricks at 800^3) below a sun, in this process,
resident and then with --volumeMemory at several shares and at 64 MiB. Of each: whether it has the bits of resident, its time
over resident's (median of --repeats, in turns; seconds of the CPU too, which other work disturbs less), bytes loaded, and these
over the bytes that a brute-force tracker touches. Each pool begins empty, and so does resident, which loads all bricks; the CPU's
seconds are also compared with those of a resident render that has them from before. The tracker shares no code with the renderer:
it works on the dense array in double precision, with the bounds of 8^3 voxels from their definition, and thins collisions that
are as dense as the greatest bound (Lewis and Shedler 1979) in place of walking cells. `--total`: the same cloud with a terrain
and photographs, under 256 MiB of device memory in all. Bars: time 1.1 at 30 %, bytes 1.5. `--short` measures nothing.
"""

import argparse
import pathlib
import resource
import statistics
import sys

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1])]

from bench.sceneRun import Scene, TracingSeconds  # noqa: E402
from stages import denseCloud  # noqa: E402

_BRICK = 8
_LINE_VOXELS = 128  # two planes of a brick: 512 bytes
_LINE_BYTES = 512
_MIB = 1 << 20
_SHARES = ("100%", "50%", "30%", "15%", "64M", "5%", "2%")
_REPEATS = 3
_TOTAL = 256 * _MIB


class _Tracker:
    """Delta tracking in the dense cloud, which notes the lines that it reads. Positions are in voxels."""

    def __init__(self, voxels: np.ndarray):
        self.voxels, self.size = voxels, voxels.shape[0]  # [z][y][x]
        self.voxel = denseCloud.SIZE / self.size
        self.cells = -(-self.size // _BRICK) + 1
        self.bounds = self._Bounds()
        self.extinction = (denseCloud.SCATTERING + denseCloud.ABSORPTION) * self.voxel  # a voxel, at density 1
        self.most = self.bounds.max() * self.extinction
        self.touched = np.zeros((self.cells**3 * 4 + 7) // 8 * 8, bool)
        self.isStored = self._IsStored()
        self.random = np.random.default_rng(5)

    def _Bounds(self):
        """The greatest of the voxels that interpolation in a cell reads: its own, and the next along each axis. The first
        cell of each axis holds what is before voxel 0."""
        n, size = self.cells, self.size
        bounds = np.zeros((n + 1,) * 3, np.float32)
        for z in range(n):
            slab = self.voxels[z * _BRICK:min(size, (z + 1) * _BRICK + 1)]
            if len(slab) == 0:
                continue
            flat = slab.max(0)
            for y in range(n):
                row = flat[y * _BRICK:min(size, (y + 1) * _BRICK + 1)]
                if len(row) == 0:
                    continue
                line = row.max(0)
                for x in range(n):
                    cell = line[x * _BRICK:min(size, (x + 1) * _BRICK + 1)]
                    bounds[z + 1, y + 1, x + 1] = cell.max(initial=0)
        for axis in range(3):  # before voxel 0 it interpolates to voxel 0
            first = [slice(None)] * 3
            first[axis] = 0
            source = [slice(None)] * 3
            source[axis] = 1
            bounds[tuple(first)] = bounds[tuple(source)]
        return bounds

    def _IsStored(self):
        """Whether a brick's voxels differ, [z][y][x]."""
        n = self.size // _BRICK
        stored = np.zeros((self.cells,) * 3, bool)
        for z in range(n):
            slab = self.voxels[z * _BRICK:(z + 1) * _BRICK].reshape(_BRICK, n, _BRICK, n, _BRICK)
            stored[z, :n, :n] = slab.max((0, 2, 4)) > slab.min((0, 2, 4))
        return stored

    def _Exit(self, at, to):
        """Length to where a ray leaves [-1, size]^3."""
        with np.errstate(divide="ignore"):
            ends = np.where(to > 0, (self.size - at) / to, np.where(to < 0, (-1 - at) / to, np.inf))
        return ends.min(-1)

    def _Read(self, at):
        """A voxel of the eight around each point by the weights of interpolation, and marks its line."""
        voxel = np.floor(at + self.random.random(at.shape)).astype(int)
        inside = ((voxel >= 0) & (voxel < self.size)).all(-1)
        x, y, z = np.where(inside[:, None], voxel, 0).T
        brick = ((z // _BRICK) * self.cells + y // _BRICK) * self.cells + x // _BRICK
        isRead = inside & self.isStored.reshape(-1)[brick]
        self.touched[(brick * 4 + z % _BRICK // 2)[isRead]] = True
        return np.where(inside, self.voxels[z, y, x], 0.0)

    def _Walk(self, at, to, isShadow: bool):
        """Up to an event or the end of each ray. Returns (points, which have an event)."""
        at, end = at.copy(), self._Exit(at, to)
        length, rays = np.zeros(len(at)), np.arange(len(at))
        hasEvent, left = np.zeros(len(at), bool), np.ones(len(at))
        while len(rays):
            length[rays] -= np.log(1 - self.random.random(len(rays))) / self.most
            rays = rays[length[rays] < end[rays]]
            points = at[rays] + length[rays, None] * to[rays]
            x, y, z = (np.floor(points).astype(int) // _BRICK + 1).T
            bound = self.bounds[z, y, x] * self.extinction
            isCollision = self.random.random(len(rays)) * self.most < bound
            collided = rays[isCollision]
            part = self._Read(points[isCollision]) * self.extinction / np.maximum(bound[isCollision], 1e-30)
            if isShadow:  # ratio tracking, with roulette below a tenth
                left[collided] *= 1 - part
                isLow = left[collided] < 0.1
                survives = self.random.random(len(collided)) * 0.1 < left[collided]
                left[collided] = np.where(isLow, np.where(survives, 0.1, 0.0), left[collided])
                rays = rays[left[rays] > 0]
            else:
                hasEvent[collided[self.random.random(len(collided)) < part]] = True
                rays = rays[~hasEvent[rays]]
        return at + length[:, None] * to, hasEvent

    def _Scattered(self, to):
        """Directions of Henyey and Greenstein's phase function."""
        g = denseCloud.ANISOTROPY
        u, phi = self.random.random(len(to)), 2 * np.pi * self.random.random(len(to))
        cosine = (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * u)) ** 2) / (2 * g)
        sine = np.sqrt(np.maximum(0, 1 - cosine**2))
        other = np.where(np.abs(to[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
        across = np.cross(to, other)
        across /= np.linalg.norm(across, axis=-1, keepdims=True)
        along = np.cross(to, across)
        return cosine[:, None] * to + (sine * np.cos(phi))[:, None] * across + (sine * np.sin(phi))[:, None] * along

    def Trace(self, width: int, height: int, samples: int) -> int:
        """Bytes of the lines that are touched by paths with a ray to the sun at each event, and roulette below a tenth."""
        albedo = denseCloud.SCATTERING / (denseCloud.SCATTERING + denseCloud.ABSORPTION)
        y, x = np.mgrid[0:height, 0:width]
        for _ in range(samples):
            jitter = self.random.random((2, height, width))
            across = ((x + jitter[0]) / width - 0.5) * denseCloud.SIZE
            down = (0.5 - (y + jitter[1]) / height) * denseCloud.SIZE * height / width
            at = np.stack([across.ravel(), down.ravel(), np.full(across.size, 0.5 * denseCloud.SIZE)], -1)
            at = at / self.voxel + 0.5 * (self.size - 1)
            at[:, 2] = self.size - 1e-6
            to = np.tile([0.0, 0.0, -1.0], (len(at), 1))
            weight = 1.0
            while len(at):
                at, hasEvent = self._Walk(at, to, False)
                at, to = at[hasEvent], to[hasEvent]
                self._Walk(at, np.tile([0.0, 1.0, 0.0], (len(at), 1)), True)
                weight *= albedo
                if weight < 0.1:
                    goesOn = self.random.random(len(at)) < weight / 0.1
                    at, to, weight = at[goesOn], to[goesOn], 0.1
                to = self._Scattered(to)
        return int(self.touched.sum()) * _LINE_BYTES


def _Row(values) -> None:
    print("| " + " | ".join(str(value) for value in values) + " |", flush=True)


class _Timed:
    """A render: seconds on the clock and of the CPU, without preparing."""

    def __init__(self, scene: Scene, samples: int, **settings):
        before = resource.getrusage(resource.RUSAGE_SELF)
        self.picture, self.statistics = scene.Render(samples, **settings)
        after = resource.getrusage(resource.RUSAGE_SELF)
        self.seconds = TracingSeconds(self.statistics)
        self.processor = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def _Medians(pairs) -> list:
    seconds, ratios = zip(*pairs)
    return [f"{statistics.median(seconds):.1f}", f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"]


def MeasureCloud(stage, voxels, args) -> None:
    size = dict(imageWidth=args.width, imageHeight=args.width * 9 // 16, pixelFilter="box", pixelFilterWidth=1.0,
                maxDepth=8)
    scene = Scene(stage, "/World/Camera", cacheDirectory=str(args.folder / "cache"), **size)
    scene.Render(1, residency="resident")  # prepares the voxels, builds kernels
    scene.Render(1, residency="stream", volumeMemory="50%")
    touched = _Tracker(voxels).Trace(args.width, args.width * 9 // 16, args.samples)
    expected, first = scene.Render(args.samples, residency="resident")
    volume = first["volume"]
    print(f"{first['device']['name']}; {volume['bricks']} bricks, {volume['bytesTotal'] / 2**30:.3f} GiB, and "
          f"{volume['alwaysResidentBytes'] / _MIB:.1f} MiB of cells; {args.width} x {args.width * 9 // 16}, {args.samples} "
          f"samples; the tracker touches {touched / _MIB:.1f} MiB\n")
    _Row(["--volumeMemory", "MiB", "bits", "seconds", "over resident", "CPU seconds", "over resident", "over resident that is loaded",
          "MiB loaded once", "over touched", "MiB loaded", "over touched"])
    _Row(["---"] * 12)
    for budget in args.shares:
        walls, processors, loaded = [], [], []
        for _ in range(args.repeats):  # in turns, so that other work on the machine meets both
            scene.Render(1, residency="stream", volumeMemory=budget)  # leaves nothing of what is resident
            base = _Timed(scene, args.samples, residency="resident")
            warm = _Timed(scene, args.samples, residency="resident")
            run = _Timed(scene, args.samples, residency="stream", volumeMemory=budget)
            walls.append((run.seconds, run.seconds / base.seconds))
            processors.append((run.processor, run.processor / base.processor))
            loaded.append((run.processor, run.processor / warm.processor))
            isEqual = np.array_equal(run.picture, expected)
        about = run.statistics["volume"]
        _Row([budget, f"{about['budget'] / _MIB:.1f}", "equal" if isEqual else "DIFFER", *_Medians(walls), *_Medians(processors),
              _Medians(loaded)[1],
              f"{about['uniqueBytesLoaded'] / _MIB:.1f}", f"{about['uniqueBytesLoaded'] / touched:.2f}",
              f"{about['uploadedBytes'] / _MIB:.1f}", f"{about['uploadedBytes'] / touched:.2f}"])


def MeasureTotal(folder, args) -> None:
    stage = folder / "all.usdc"
    if not stage.exists():
        denseCloud.WriteAll(stage, args.size, *((20, 2, 64) if args.short else (1500, 12, 1024)))
    settings = dict(cacheDirectory=str(args.folder / "cache"), imageWidth=args.width, imageHeight=args.width * 9 // 16,
                    waveSize=1 << 15, maxDepth=8)
    parts = dict(geometryMemory="64M", textureMemory="24M", volumeMemory="64M")
    # Streamed first: the device's peak is that of all renders so far.
    picture, run = Scene(stage, "/World/All", **settings).Render(args.samples, residency="stream", **parts)
    expected, whole = Scene(stage, "/World/All", **settings).Render(args.samples, residency="resident")
    _Row(["", "resident", "streamed"])
    _Row(["---"] * 3)
    for name in ("geometry", "texture", "volume"):
        _Row([f"{name}: MiB there are", f"{run[name]['bytesTotal'] / _MIB:.1f}", ""])
        _Row([f"{name}: pool, MiB", "all", f"{run[name]['budget'] / _MIB:.1f}"])
        _Row([f"{name}: MiB loaded", "", f"{run[name]['uploadedBytes'] / _MIB:.1f}"])
    for name in ("devicePeak", "pathState", "film", "tables"):
        _Row([f"memory.{name}, MiB", *(f"{about['memory'][name] / _MIB:.1f}" for about in (whole, run))])
    _Row(["seconds", *(f"{TracingSeconds(about):.1f}" for about in (whole, run))])
    print("bits:", "equal" if np.array_equal(picture, expected) else "DIFFER")
    peak = run["memory"]["devicePeak"]
    print(f"device memory {peak / _MIB:.1f} MiB, {'within' if peak <= _TOTAL else 'OVER'} {_TOTAL // _MIB}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--size", type=int, default=800, help="voxels an edge of the cloud, a multiple of 8")
    parser.add_argument("--width", type=int, default=320)
    parser.add_argument("--samples", type=int, default=4)
    parser.add_argument("--repeats", type=int, default=_REPEATS)
    parser.add_argument("--shares", type=lambda text: text.split(","), default=list(_SHARES))
    parser.add_argument("--total", action="store_true")
    parser.add_argument("--short", action="store_true")
    args = parser.parse_args()
    if args.short:
        args.size, args.width, args.samples, args.repeats, args.shares = 64, 32, 1, 1, ["100%", "30%"]
    args.folder = args.folder.resolve()
    args.folder.mkdir(parents=True, exist_ok=True)
    if args.total:
        MeasureTotal(args.folder, args)
        return
    stage = args.folder / f"cloud{args.size}.usda"
    raw = denseCloud.WriteCloud(stage, args.size)
    MeasureCloud(stage, np.memmap(raw, np.float32, "r", shape=(args.size,) * 3), args)


if __name__ == "__main__":
    main()
