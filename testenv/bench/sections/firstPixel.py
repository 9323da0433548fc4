# SPDX-License-Identifier: Apache-2.0
"""Seconds from the start of the process to the first complete sample, and what they are spent on, against the size of the
scene: with empty caches (ours and the OpenCL driver's), with all but kernels there, and with everything there."""

import shutil

from bench.performancePage import Table
from bench.recordRun import FreshCache, Record
from stages import grove
from support.svgChart import Chart

_PARTS = {"read USD": ("load",), "translate": ("translate",), "prepare": ("prepare",), "kernels": ("compile",),
          "trace and shade": ("trace", "shade", "requests", "transfer")}


def _Cells(run: dict) -> list:
    parts = [sum(run["time"][key] for key in keys) for keys in _PARTS.values()]
    return [run["time"]["firstPixel"], *parts, max(0.0, run["time"]["firstPixel"] - sum(parts))]


def _ForgetKernels(cache, driver) -> None:
    """Pages stay."""
    for file in cache.glob("kernel-*"):
        file.unlink()
    shutil.rmtree(driver)
    driver.mkdir()


def Run(bench) -> list:
    sizes = bench.Pick((100_000, 1_000_000, 5_000_000, 20_000_000), (60_000, 120_000))
    stages = [(size, bench.Stage(f"grove{size}", lambda path, size=size: grove.WriteGrove(path, size)), "/World/Inside")
              for size in sizes]
    stages += [(name, *place) for name, place in bench.real.items()]
    rows, found = [], {"cold": [], "kernels cold": [], "warm": []}
    for name, path, camera in stages:
        # Building kernels takes longer than the short form may.
        cache = FreshCache(bench.folder / "first", bench.Pick("", bench.cache))
        driver = FreshCache(bench.folder / "firstDriver")
        environment = bench.Pick({"POCL_CACHE_DIR": str(driver)}, {})
        width = bench.Pick(480, 64)
        for state in found:
            if state == "kernels cold" and environment:
                _ForgetKernels(cache, driver)
            cells = _Cells(Record(path, cache, camera=camera, imageWidth=width, imageHeight=width * 9 // 16, samples=1,
                                  environment=environment))
            rows.append([name, state, *cells])
            found[state].append(cells)
    items = [Table("firstPixel", ["triangles", "caches", "first pixel s", *_PARTS, "rest: Python, device, film"], rows)]
    for state, cells in found.items():
        chart = Chart(f"first pixel, {state} caches", "triangles", "seconds")
        for index, label in enumerate(("first pixel", *_PARTS, "rest")):
            chart.Add(label, sizes, [values[index] for values in cells])
        items.append((f"firstPixel-{state.replace(' ', '-')}", chart))
    return items
