# SPDX-License-Identifier: Apache-2.0
"""Equal-error time against other renderers: testenv/bench/rivals.py as a program; its CSV as tables, its SVG as charts."""

import csv
import pathlib
import shutil
import statistics
import subprocess

from bench import rivalsLadder
from bench.performancePage import LeftOut, Table

_PROGRAM = pathlib.Path(__file__).resolve().parents[1] / "rivals.py"
_SIZES = ("--width", "240", "--reference", "256", "--repeat", "3", "--longest", "20", "--limit", "300")
_RENDERERS = ("hdstream", "mitsuba scalar", "mitsuba llvm", "mitsuba preview", "cycles")  # streaming has a section of its own
_MINE = _RENDERERS[0]
_ERRORS = (0.01, 0.001)


def _Rows(path: pathlib.Path) -> list:
    """(stage, renderer, its ladder, what it costs besides) of each renderer on each stage."""
    rungs = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            rungs.setdefault((row["stage"], row["renderer"]), {}).setdefault(int(row["repeat"]), []).append(row)
    rows = []
    for (stage, renderer), repeats in rungs.items():
        first = repeats[0]
        ladder = rivalsLadder.Ladder([float(row["samples"]) for row in first], [float(row["relMSE"]) for row in first],
                                     [[float(row["seconds"]) for row in repeat] for repeat in repeats.values()])
        rows.append((stage, renderer, ladder, first[0]))
    return rows


def _Interval(ratio: tuple | None) -> str | None:
    return None if ratio is None else f"{ratio[0]:.2f} ({ratio[1]:.2f} to {ratio[2]:.2f})"


def _Ratios(rows: list, error: float, name: str, seconds) -> Table:
    """Our seconds to the error over the others'."""
    others = [renderer for renderer in dict.fromkeys(renderer for _, renderer, *_ in rows) if renderer != _MINE]
    shown = []
    for stage in dict.fromkeys(row[0] for row in rows):
        own = {renderer: seconds(ladder, error) for at, renderer, ladder, _ in rows if at == stage}
        shown.append([stage, *(_Interval(rivalsLadder.Ratio(own.get(_MINE), own.get(other))) for other in others)])
    return Table(f"{name}{error:g}".replace(".", ""), ["stage", *others], shown)


def _Median(values: list | None) -> float | None:
    return None if values is None else statistics.median(values)


def _Costs(rows: list) -> Table:
    """What a sample, the errors, the first picture and memory cost."""
    head = ["stage", "renderer", "ms a sample of all pixels", "fixed s a render",
            *(f"{what} to {error:g}" for error in _ERRORS for what in ("samples", "seconds")), "first picture s", "peak MB"]
    shown = []
    for stage, renderer, ladder, cost in rows:
        to = [value for error in _ERRORS for value in (ladder.SamplesTo(error), _Median(ladder.SecondsTo(error)))]
        shown.append([stage, renderer, 1e3 * statistics.median(ladder.perSample), statistics.median(ladder.fixed), *to,
                      float(cost["build seconds"]) + float(cost["first render seconds"]), float(cost["peak bytes"]) / 1e6])
    return Table("rivals", head, shown)


def Items(out: pathlib.Path, images: pathlib.Path) -> list:
    """Tables and charts of what rivals.py has written to a folder."""
    images.mkdir(parents=True, exist_ok=True)
    charts = sorted(out.glob("*.svg"))
    for path in charts:
        shutil.copy(path.with_suffix(".csv"), images)
    rows = _Rows(out / "rivals.csv")
    ratios = []
    for error in _ERRORS:
        ratios += [f"Our seconds of sampling to relMSE {error:g} over the others' (below 1: hdStream is faster), without what a render "
                   "costs whatever its samples; median, least and largest of the repeats:",
                   _Ratios(rows, error, "rivalsSampling", rivalsLadder.Ladder.SamplingSecondsTo),
                   "The same of the seconds as measured:", _Ratios(rows, error, "rivalsMeasured", rivalsLadder.Ladder.SecondsTo)]
    return [*ratios, _Costs(rows), *(pathlib.Path(shutil.copy(path, images)) for path in charts)]


def Run(bench) -> list:
    if subprocess.run([bench.rivalsPython, "-c", "import mitsuba, bpy"], capture_output=True).returncode != 0:
        raise LeftOut("Mitsuba and bpy are not in the Python that --rivalsPython names")
    out = bench.folder / "rivals"
    scenes = ["--scenes", bench.scenes] if bench.scenes else []
    done = subprocess.run([bench.rivalsPython, _PROGRAM, "--out", out, "--renderers", ",".join(_RENDERERS),
                           *(["--short"] if bench.isShort else _SIZES), *scenes],
                          capture_output=True, text=True)
    if done.returncode != 0:
        last = (done.stderr.strip() or "no output").splitlines()[-1]
        raise LeftOut(f"rivals.py ended with exit code {done.returncode}: {last}")
    return Items(out, bench.images)
