# SPDX-License-Identifier: Apache-2.0
"""What leaving out saves: a terrain, and the same with one prim that no ray sees and that needs a feature (testenv/stages/
economies.py). Seconds to the first picture with empty kernel caches, and of a picture with warm ones, each beside the plain
terrain in turns."""

import statistics

import numpy as np
from bench.performancePage import Table
from bench.recordRun import FreshCache, Record
from stages import economies

_PLAIN = "nothing"


def _Picture(path, cache, bench, **options) -> dict:
    width = bench.Pick(480, 96)  # batches of fewer rays are not timed by stages
    return Record(path, cache, camera="/World/Camera", imageWidth=width, imageHeight=width * 9 // 16, **options)


def _ColdSeconds(path, bench) -> float:
    """To the first pixel, caches of ours and of the OpenCL driver empty."""
    folder = bench.folder / "economies"
    driver = FreshCache(folder / "driver")
    return _Picture(path, FreshCache(folder / "cold"), bench, samples=1,
                    environment={"POCL_CACHE_DIR": str(driver)})["time"]["firstPixel"]


def Run(bench) -> list:
    cells = bench.Pick(300, 20)
    samples, repeats = bench.Pick((16, 5), (2, 1))
    paths = {name: bench.Stage(f"economy {name}", lambda path, name=name: economies.WriteEconomies(path, name, cells))
             for name in bench.Pick(list(economies.ADDITIONS), [_PLAIN, "curves"])}
    rows = []
    for name, path in paths.items():
        # The short form builds no kernels from nothing.
        cold = bench.Pick(lambda: _ColdSeconds(path, bench), lambda: None)()
        runs, ratios = [], []
        _Picture(path, bench.cache, bench, samples=1)
        for _ in range(repeats):
            plain = _Picture(paths[_PLAIN], bench.cache, bench, samples=samples)
            runs.append(_Picture(path, bench.cache, bench, samples=samples))
            ratios.append([runs[-1]["time"][key] / plain["time"][key] for key in ("trace", "shade", "render")])
        differs = "no" if runs[-1]["pictureBytes"] == plain["pictureBytes"] else "yes"
        rows.append([name, cold, *np.median(ratios, axis=0).tolist(), statistics.median(run["time"]["total"] for run in runs),
                     runs[-1]["memory"]["pathState"] / 1e6, runs[-1]["geometry"]["bytesTotal"] / 1e6, differs])
    return [Table("economies", ["a hidden prim needs", "first pixel, nothing cached, s", "trace / without", "shade / without",
                                "render / without", "picture s", "path state MB", "geometry MB", "picture differs"], rows)]
