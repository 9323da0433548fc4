# SPDX-License-Identifier: Apache-2.0
"""Rays a second of whole renders: against triangles and instances, pool, cores and wave size."""

import argparse
import os

from bench import geometryStreaming, growth, waveSize
from bench.performancePage import LeftOut, Table
from bench.recordRun import Record
from bench.sceneRun import Scene, TracingSeconds
from bench.sections import traversal
from hdstream import _core
from stages import bench as benchStages
from stages import streaming
from support.svgChart import Chart

_POOLS = (100, 79, 50, 30, 15, 5)


def _Growth(bench) -> list:
    items = []
    args = argparse.Namespace(scratch=str(bench.folder), width=bench.Pick(320, 64), samples=1, prepare="eager", limit=3600,
                              residentLimit=2.5e7)
    for kind, sizes in (("triangles", bench.Pick((100_000, 1_000_000, 5_000_000, 20_000_000), (60_000, 120_000))),
                        ("instances", bench.Pick((1000, 10_000, 100_000, 1_000_000), (100, 1000)))):
        rows = growth.Measure(kind, sizes, args)
        head = [kind, "prepare s", "render s", "us a ray, streamed", "us a ray, resident", "MB of pages", "MB of the pool",
                "MB always resident", "MB, device peak", "MB, host peak"]
        items.append(Table(f"growth-{kind}", head, [
            [row["size"], row["prepare"], row["render"], row["perRay"], row["perRayResident"],
             *(row[name] / 1e6 for name in ("bytes", "pool", "alwaysResident", "devicePeak", "hostPeak"))] for row in rows]))
        items += [(f"growth-{kind}-{name}", chart) for name, chart in growth.Charts(kind, rows).items()]
    return items


def _Terrain(bench) -> str:
    return bench.Stage("terrain", lambda path: benchStages.WriteTerrain(path, cells=bench.Pick(600, 60)))


def _Pools(bench) -> list:
    pools = bench.Pick(_POOLS, (100, 30))
    chart = Chart("rays against the pool", "pool, % of all pages", "rays a second")
    stages = {"huge mesh": (_Terrain(bench), "/World/Camera")}
    if not bench.isShort:
        stages["overlap"] = (bench.Stage("overlap120", lambda path: streaming.WriteOverlap(path, rings=120)), "/World/Camera")
        stages.update(bench.real)
    rows = []
    for name, (path, camera) in stages.items():
        width = bench.Pick(480, 64)
        scene = Scene(path, camera, imageWidth=width, imageHeight=width * 9 // 16, chunkBytes=bench.Pick(_core.Settings().chunkBytes, 1 << 14))
        variants = {"resident": dict(residency="resident", traversal="simd8"), "resident, flat": dict(residency="resident")}
        variants.update({pool: dict(residency="stream", geometryMemory=f"{pool}%") for pool in pools})
        runs = geometryStreaming.Measure(scene, variants, 1, bench.Pick(16, 1))
        resident = runs["resident"]
        for pool, run in runs.items():
            geometry, memory = run["geometry"], run["memory"]
            seconds = run["time"]["render"]
            rows.append([name, pool if isinstance(pool, str) else f"{pool} %", seconds, seconds / resident["time"]["render"],
                         run["rays"]["perSecond"] / 1e6, geometry["uploadedBytes"] / max(1, geometry["uniqueBytesLoaded"]),
                         (geometry["budget"] + memory["pathState"] + memory["tables"]) / 1e6])
        streamed = [pool for pool in runs if not isinstance(pool, str)]
        chart.Add(name, streamed, [runs[pool]["rays"]["perSecond"] for pool in streamed])
        chart.Add(f"{name}, resident", streamed, [resident["rays"]["perSecond"]] * len(streamed))
    return ["Pools of a share of all pages; every picture has the bits of the resident one:",
            Table("rays-pools", ["stage", "pool", "s", "over resident", "million rays/s", "loaded / unique",
                                 "MB: pool, path state, tables"], rows),
            ("rays-pools", chart)]


def _Cores(bench) -> list:
    """PoCL's threads are set when the driver starts, so each run is a process."""
    stage = _Terrain(bench)
    cores = sorted({1, 2, os.cpu_count() or 1})
    chart = Chart("rays against cores", "cores", "million rays a second", isLinear=True)
    rows = []
    for name, options in (("resident", dict(residency="resident")), ("30 % pool", dict(residency="stream", geometryMemory="30%"))):
        rates = []
        for threads in cores:
            run = Record(stage, bench.cache, camera="/World/Camera", imageWidth=bench.Pick(480, 64), samples=bench.Pick(16, 1),
                         environment={"POCL_MAX_PTHREAD_COUNT": str(threads)}, **options)
            rates.append(sum(run["rays"][kind] for kind in ("camera", "indirect", "shadow")) / TracingSeconds(run) / 1e6)
        rows += [[name, threads, rate, rate / rates[0]] for threads, rate in zip(cores, rates)]
        chart.Add(name, cores, rates)
    try:
        program = bench.Program("testenv/bench/benchTraversal")
        size, numRays = bench.Pick((1_000_000, 1 << 20), (2_000, 1 << 14))
        found = [traversal.Measure(program, size, "foliage", numRays, threads)[0]["diffuse closest"] for threads in cores]
        for index in (0, 2):
            rates = [rates[index] for rates in found]
            name = ("kernel alone", "Embree alone")[index // 2]
            rows += [[name, threads, rate, rate / rates[0]] for threads, rate in zip(cores, rates)]
            chart.Add(name, cores, rates)
    except LeftOut as error:
        print(f"LEFT OUT: Embree against cores: {error}", flush=True)
    return ["Cores (`POCL_MAX_PTHREAD_COUNT`): whole renders of the huge mesh; diffuse rays through a million triangles of foliage by "
            "our kernel and by Embree:",
            Table("rays-cores", ["what", "cores", "million rays/s", "over one core"], rows), ("rays-cores", chart)]


def _Waves(bench) -> list:
    width = bench.Pick(480, 64)
    scene = Scene(_Terrain(bench), "/World/Camera", imageWidth=width, imageHeight=width * 9 // 16)
    best, isSame = waveSize.Measure(scene, bench.Pick(16, 1), bench.Pick(2, 1), bench.Pick(waveSize.SIZES, (1024, 32768)))
    assert isSame, "the pictures differ"
    least = min(run["time"]["render"] for run in best.values())
    rows = [[size, run["time"]["render"], run["time"]["render"] / least, run["rays"]["perSecond"] / 1e6, run["time"]["trace"],
             run["time"]["shade"], run["memory"]["pathState"] / 1e6] for size, run in best.items()]
    chart = Chart("rays against the wave size", "paths of a wave", "million rays a second")
    chart.Add("resident", list(best), [row[3] for row in rows])
    head = ["paths", "s", "over the fastest", "million rays/s", "trace s", "shade s", "MB of path state"]
    return ["Wave sizes, the huge mesh, resident, equal bits:", Table("rays-waves", head, rows), ("rays-waves", chart)]


def Run(bench) -> list:
    return [*_Growth(bench), *_Pools(bench), *_Cores(bench), *_Waves(bench)]
