# SPDX-License-Identifier: Apache-2.0
"""Error against time of what streams geometry: pool and chunk size. Bits do not depend on them, so curves differ in time only."""

from bench.curves import CurveChart, CurveTable
from bench.sceneRun import REFERENCE_SEED, Curve, Scene
from hdstream import _core
from stages import streaming


def Run(bench) -> list:
    width = bench.Pick(240, 48)
    samples = bench.Pick((4, 16, 64), (1, 4))
    path = bench.Stage("overlap", lambda path: streaming.WriteOverlap(path, rings=bench.Pick(120, 24)))
    stages = {"overlap": (path, "/World/Camera"), **bench.Real("chess", "coffee")}
    items = []
    for name, (path, camera) in stages.items():
        def Open(chunkBytes):
            return Scene(path, camera, imageWidth=width, imageHeight=width * 9 // 16, chunkBytes=chunkBytes)

        chunks = bench.Pick((1 << 14, 1 << 16, 1 << 18, 1 << 20), (1 << 14, 1 << 16))
        scene = Open(chunks[-2])
        reference, _ = scene.Render(bench.Pick(256, 16), seed=REFERENCE_SEED, residency="resident")
        pools = {"resident": dict(residency="resident", traversal="simd8"), "resident, flat": dict(residency="resident")}
        for pool in bench.Pick((100, 79, 30, 5), (30,)):
            pools[f"{pool} %"] = dict(residency="stream", geometryMemory=f"{pool}%")
        curves = {}
        for label, settings in pools.items():
            try:
                curves[label] = Curve(scene, reference, samples, **settings)
            except _core.Error as error:  # a pool that cannot hold the largest chunk
                print(f"LEFT OUT: {name}, pool of {label}: {error}", flush=True)
        items += [f"Pool, {name}, chunks of {chunks[-2] >> 10} KiB:", CurveTable(f"knob-pool-{name}", curves),
                  (f"knob-pool-{name}", CurveChart(f"pool of geometry, {name}", curves))]
        if name != "overlap":
            continue
        curves = {f"{chunk >> 10} KiB": Curve(Open(chunk), reference, samples, residency="stream", geometryMemory="30%")
                  for chunk in chunks}
        items += ["Chunk size, a pool of 30 %:", CurveTable(f"knob-chunk-{name}", curves),
                  (f"knob-chunk-{name}", CurveChart(f"chunk size, {name}", curves))]
    return items
