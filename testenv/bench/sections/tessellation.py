# SPDX-License-Identifier: Apache-2.0
"""Error against time of the tessellation rate: cage, uniform levels, adaptive (testenv/bench/subdivisionError.py)."""

import argparse

from bench import subdivisionError
from bench.performancePage import Table
from stages import subdivided


def Run(bench) -> list:
    width = bench.Pick(640, 64)
    stage = bench.Stage("subdivided", lambda path: subdivided.WriteSubdivided(path, copies=bench.Pick(3, 1)))
    rows = subdivisionError.Measure(argparse.Namespace(
        stage=stage, camera="/World/Camera", folder=bench.folder / "subdivision", levels=bench.Pick([1, 2, 3, 4, 6], [1, 2]),
        width=width, height=width * 9 // 16, samples=bench.Pick(16, 1), maxDepth=2, geometryMemory="1G", autobump=False))
    table = Table("knob-tessellation", ["surfaces", "triangles", "prepare s", "render s", "relMSE", "mean error of normals, degrees"],
                  [[row["name"], row["triangles"], row["prepare"], row["render"], row["error"], row["angle"]] for row in rows])
    return [f"The last row is the reference; two renders with equal seeds each, {bench.Pick(16, 1)} samples:", table,
            ("knob-tessellation", subdivisionError.ErrorChart(rows, "render", "seconds")),
            ("knob-tessellation-triangles", subdivisionError.ErrorChart(rows, "triangles", "triangles"))]
