# SPDX-License-Identifier: Apache-2.0
"""Whole paths against other renderers: testenv/bench/rivals.py as a program; its CSV as a table, its SVG as charts."""

import csv
import pathlib
import shutil
import subprocess

from bench.performancePage import LeftOut, Table

_PROGRAM = pathlib.Path(__file__).resolve().parents[1] / "rivals.py"


def _Value(text: str):
    try:
        return int(text) if text.isdecimal() else float(text)
    except ValueError:
        return text


def _Table(path: pathlib.Path) -> Table:
    """All rungs; shown is the last one of a renderer on a stage."""
    with open(path, newline="") as file:
        head, *rows = csv.reader(file)
    rows = [[_Value(cell) for cell in row] for row in rows]
    return Table("rivals", head, rows, list({tuple(row[:2]): row for row in rows}.values()))


def Run(bench) -> list:
    if "--out" not in subprocess.run([bench.rivalsPython, _PROGRAM, "--help"], capture_output=True, text=True).stdout:
        raise LeftOut("rivals.py has no option --out")
    if subprocess.run([bench.rivalsPython, "-c", "import mitsuba, bpy"], capture_output=True).returncode != 0:
        raise LeftOut("Mitsuba and bpy are not in the Python that --rivalsPython names")
    out = bench.folder / "rivals"
    scenes = ["--scenes", bench.scenes] if bench.scenes else []
    done = subprocess.run([bench.rivalsPython, _PROGRAM, "--out", out, *(["--short"] if bench.isShort else []), *scenes],
                          capture_output=True, text=True)
    if done.returncode != 0:
        last = (done.stderr.strip() or "no output").splitlines()[-1]
        raise LeftOut(f"rivals.py ended with exit code {done.returncode}: {last}")
    bench.images.mkdir(parents=True, exist_ok=True)
    charts = sorted(out.glob("*.svg"))
    for path in charts:
        shutil.copy(path.with_suffix(".csv"), bench.images)
    return [_Table(out / "rivals.csv"), *(pathlib.Path(shutil.copy(path, bench.images)) for path in charts)]
