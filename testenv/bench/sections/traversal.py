# SPDX-License-Identifier: Apache-2.0
"""Rays against Embree, same rays, one core: benchTraversal (testenv/bench/traversal.cpp) over sizes, and on interiors where they are
found (traversalStage.py)."""

import pathlib
import re
import subprocess
import sys
import tempfile

from bench.performancePage import Table
from support.svgChart import Chart

_RATES = re.compile(r"^  (\w+ \w+(?: hit)?) +flat ([\d.]+)  simd8 ([\d.]+)  scalar ([\d.]+)  Embree default ([\d.]+)  compact\+robust ([\d.]+).*"
                    r"differing (\d+) of (\d+)", re.MULTILINE)
_BYTES = re.compile(r"ours nodes [\d.]+, nodes \+ leaves ([\d.]+); Embree default ([\d.]+), compact\+robust ([\d.]+)")
_FLAT = re.compile(r"flat hierarchy +([\d.]+) bytes a triangle, ([\d.]+) Mtriangles a CPU second")
_BUILD = re.compile(r"build +ours ([\d.]+) Mtriangles/s wall, ([\d.]+) a CPU second.*default ([\d.]+), compact\+robust ([\d.]+)")
_INTERIORS = ("coffee", "bookstore")
_STAGE = pathlib.Path(__file__).parents[1] / "traversalStage.py"
_FORMS = ("flat", "simd8", "scalar", "Embree default", "Embree compact+robust")


def Measure(program, triangles: int, scene: str, numRays: int, threads: int = 1) -> tuple[dict, list]:
    """({kind of rays: (rates of _FORMS..., differing, rays)}, figures): bytes a triangle of ours, Embree default, compact+robust;
    million triangles built: pages a second and a CPU second, Embree default, compact+robust; bytes and builds of flat."""
    return _Run(program, "--rays", numRays, "--repeat", 1, "--triangles", triangles, "--scene", scene, "--threads", threads)


def _Run(program, *arguments) -> tuple:
    """As Measure."""
    text = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=True).stdout
    rates = {match[1]: (*map(float, match.groups()[1:6]), int(match[7]), int(match[8])) for match in _RATES.finditer(text)}
    return rates, [float(value) for line in (_BYTES, _BUILD, _FLAT) for value in line.search(text).groups()]


def _Interiors(bench, program, numRays: int):
    """(name, triangles, what Measure returns) of the interiors that run.py was given."""
    for name in _INTERIORS:
        if name not in bench.real:
            continue
        stage, camera = bench.real[name]
        with tempfile.TemporaryDirectory() as folder:
            file = str(pathlib.Path(folder) / f"{name}.triangles")
            count = subprocess.run([sys.executable, _STAGE, stage, file, "--camera", camera], capture_output=True, text=True, check=True)
            yield name, int(count.stdout), _Run(program, "--rays", numRays, "--repeat", 1, "--stage", file)


def Run(bench) -> list:
    program = bench.Program("testenv/bench/benchTraversal")
    sizes = bench.Pick((10_000, 100_000, 1_000_000, 4_000_000), (2_000, 10_000))
    numRays = bench.Pick(1 << 20, 1 << 14)
    measured, rows, memory, builds, items = [], [], [], [], []
    for scene in ("sphere", "foliage", "instances"):
        chart = Chart(f"{scene}: diffuse rays, closest hit, one core", "triangles", "million rays a second")
        found = [Measure(program, size, scene, numRays) for size in sizes]
        for index, form in enumerate(_FORMS):
            chart.Add(form, sizes, [rates["diffuse closest"][index] for rates, _ in found])
        measured += [(scene, size, *results) for size, results in zip(sizes, found)]
        items.append((f"traversal-{scene}", chart))
    measured += [(name, size, *results) for name, size, results in _Interiors(bench, program, numRays)]
    for scene, size, rates, figures in measured:
        memory.append([scene, size, figures[0], figures[7], *figures[1:3]])
        builds.append([scene, size, *figures[3:5], figures[8], *figures[5:7]])
        for kind, (flat, simd8, scalar, default, compact, differing, count) in rates.items():
            rows.append([scene, size, kind, flat, simd8, scalar, default, compact, flat / default, flat / compact, simd8 / default,
                         f"{differing} of {count}"])
    shown = [row for row in rows if row[0] in _INTERIORS or row[1] == bench.Pick(1_000_000, sizes[-1])]
    head = ["scene", "triangles", "rays", *_FORMS, "flat / default", "flat / compact+robust", "simd8 / default", "differ"]
    return ["Million rays a second of one core (CPU time).", Table("traversal", head, rows, shown),
            "Bytes a triangle, nodes and leaves, shared vertices left out:",
            Table("traversal-bytes", ["scene", "triangles", "ours", "flat, beside it", "Embree default", "Embree compact+robust"], memory),
            "Million triangles built: pages on all cores a second, and a CPU second of each; the flat hierarchy is made of finished pages:",
            Table("traversal-build", ["scene", "triangles", "pages, all cores", "pages", "flat", "Embree default", "Embree compact+robust"], builds,
                  [row for row in builds if row[0] in _INTERIORS or row[1] == bench.Pick(1_000_000, sizes[-1])]), *items]
