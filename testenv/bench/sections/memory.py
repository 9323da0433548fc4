# SPDX-License-Identifier: Apache-2.0
"""Memory against time while rendering, resident and streamed (the report's figure 4), and texture cache used against samples
(its figure 6)."""

import argparse
import pathlib
import time

from bench import textureStress
from bench.performancePage import Table
from bench.recordRun import FreshCache, Record, RunFailed
from stages import bench as benchStages
from stages import textureStress as textureStressStage
from support.svgChart import Chart

_WAVE = 1 << 16  # by default waves grow with the memory that the pool saves
_MAX_POINTS = 200


class _Sampler:
    """Anonymous memory of a process against seconds; on a CPU device that holds the device's memory, too."""

    def __init__(self):
        self.start, self.points = time.monotonic(), []

    def __call__(self, process: int) -> None:
        try:
            lines = pathlib.Path(f"/proc/{process}/status").read_text().splitlines()
        except OSError:
            return
        for line in lines:
            if line.startswith("RssAnon:"):
                self.points.append((time.monotonic() - self.start, int(line.split()[1]) * 1024 / 1e6))


def _AgainstTime(bench, name: str, path: str, camera: str) -> list:
    cache = FreshCache(bench.folder / f"memory-{name}", bench.cache)
    width = bench.Pick(480, 64)
    options = dict(camera=camera, imageWidth=width, imageHeight=width * 9 // 16, hostMemory="16M", waveSize=_WAVE)
    modes = {"resident": dict(residency="resident")}
    for pool in bench.Pick((79, 30, 10), (30,)):
        modes[f"pool of {pool} %"] = dict(residency="stream", geometryMemory=f"{pool}%")
    chart = Chart(f"memory while rendering, {name}", "seconds since the start", "MB of anonymous memory", isLinear=True)
    rows = []
    for label, mode in modes.items():
        try:
            Record(path, cache, samples=1, **options, **mode)  # kernels and pages are in the cache afterwards
        except RunFailed as error:  # a pool that cannot hold the largest chunk
            print(f"LEFT OUT: {name}, {label}: {error}", flush=True)
            continue
        sampler = _Sampler()
        run = Record(path, cache, samples=bench.Pick(32, 4), onPoll=sampler, **options, **mode)
        points = sampler.points[:: -(-len(sampler.points) // _MAX_POINTS)]
        chart.Add(label, *zip(*points))
        geometry, memory = run["geometry"], run["memory"]
        seconds = run["time"]["render"]
        rows.append([label, seconds, seconds / (rows[0][1] if rows else seconds), geometry["bytesTotal"] / 1e6,
                     geometry["budget"] / 1e6, memory["devicePeak"] / 1e6, max(megabytes for _, megabytes in points)])
    return [f"{name}: time of a render and its memory; files of pages and kernels are in the cache:",
            Table(f"memory-{name}", ["geometry", "render s", "over resident", "MB of pages", "MB of the pool", "MB, device peak",
                                     "MB, anonymous peak of the process"], rows), (f"memory-{name}", chart)]


def _CacheAgainstSamples(bench) -> list:
    count, size, heights, samples = bench.Pick((962, 256, [180, 360, 720], [1, 2, 5, 10, 20, 40]), (4, 64, [36, 72], [1, 2]))
    keys = ("height", "samples", "lines", "megabytes", "percent", "fallback", "misses", "missesSince")
    stage = bench.Stage(f"tunnel{count}x{size}", lambda path: textureStressStage.WriteTextureStress(path, count, size))
    args = argparse.Namespace(cache=bench.cache, count=count, size=size, heights=heights, samples=samples, maxDepth=2,
                              textureMemory="1G")
    rows = list(textureStress.Grow(args, stage))
    table = Table("memory-textures", ["height", "samples", "lines", "MB", "% of all lines", "texels from coarser mips",
                                      "misses per look-up", "since the row before"], [[row[key] for key in keys] for row in rows])
    return [f"Texture cache used against samples: the report's stress scene with {count} textures of {size} x {size}, two bounces:",
            table,
            ("memory-textures", textureStress.GrowthChart(args, rows, "megabytes", "MB loaded"))]


def Run(bench) -> list:
    path = bench.Stage("largeTerrain", lambda path: benchStages.WriteTerrain(path, cells=bench.Pick(1400, 60)))
    items = []
    for name, (path, camera) in {"terrain": (path, "/World/Camera"), **bench.Real("chess", "coffee")}.items():
        items += _AgainstTime(bench, name, path, camera)
    return [*items, *_CacheAgainstSamples(bench)]
