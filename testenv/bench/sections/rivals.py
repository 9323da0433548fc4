# SPDX-License-Identifier: Apache-2.0
"""Equal-error time against other renderers: testenv/bench/rivals.py as a program; its CSV as tables, its SVG as charts."""

import csv
import pathlib
import shutil
import subprocess

from bench.performancePage import LeftOut, Table

_PROGRAM = pathlib.Path(__file__).resolve().parents[1] / "rivals.py"
_SIZES = ("--width", "320", "--reference", "96", "--ladder", "2,8,32", "--limit", "600")
_MINE = "hdstream"
_ERROR = "seconds to 0.01"


def _Rows(path: pathlib.Path) -> list:
    """(stage, renderer, {column: number}) of each renderer on each stage, which rungs share."""
    with open(path, newline="") as file:
        rows = {(row.pop("stage"), row.pop("renderer")): row for row in csv.DictReader(file)}
    return [(*key, {name: float(value) for name, value in row.items()}) for key, row in rows.items()]


def _Ratios(rows: list) -> Table:
    """Our seconds to the error, and those over the others'."""
    renderers = list(dict.fromkeys(renderer for _, renderer, _ in rows))
    seconds = {(stage, renderer): row[_ERROR] for stage, renderer, row in rows}
    shown = []
    for stage in dict.fromkeys(stage for stage, _, _ in rows):
        mine = seconds.get((stage, _MINE))
        if mine is not None:
            shown.append([stage, mine, *(mine / seconds[stage, other] if (stage, other) in seconds else None
                                         for other in renderers if other != _MINE)])
    return Table("rivalsRatios", ["stage", f"{_MINE}: {_ERROR}", *(f"/ {name}" for name in renderers if name != _MINE)], shown)


def _Costs(rows: list) -> Table:
    """What a sample, the first picture and memory cost."""
    head = ["stage", "renderer", "ms a sample of all pixels", _ERROR, "seconds to 0.001", "fixed s a render", "first picture s", "peak MB"]
    return Table("rivals", head,
                 [[stage, renderer, 1e3 * row["seconds a sample"], row[_ERROR], row["seconds to 0.001"], row["fixed seconds"],
                   row["build seconds"] + row["first render seconds"], row["peak bytes"] / 1e6] for stage, renderer, row in rows])


def Items(out: pathlib.Path, images: pathlib.Path) -> list:
    """Tables and charts of what rivals.py has written to a folder."""
    images.mkdir(parents=True, exist_ok=True)
    charts = sorted(out.glob("*.svg"))
    for path in charts:
        shutil.copy(path.with_suffix(".csv"), images)
    rows = _Rows(out / "rivals.csv")
    return ["Our seconds to relMSE 0.01 over the others' (below 1: hdStream is faster):", _Ratios(rows), _Costs(rows),
            *(pathlib.Path(shutil.copy(path, images)) for path in charts)]


def Run(bench) -> list:
    if subprocess.run([bench.rivalsPython, "-c", "import mitsuba, bpy"], capture_output=True).returncode != 0:
        raise LeftOut("Mitsuba and bpy are not in the Python that --rivalsPython names")
    out = bench.folder / "rivals"
    scenes = ["--scenes", bench.scenes] if bench.scenes else []
    done = subprocess.run([bench.rivalsPython, _PROGRAM, "--out", out, *(["--short"] if bench.isShort else _SIZES), *scenes],
                          capture_output=True, text=True)
    if done.returncode != 0:
        last = (done.stderr.strip() or "no output").splitlines()[-1]
        raise LeftOut(f"rivals.py ended with exit code {done.returncode}: {last}")
    return Items(out, bench.images)
