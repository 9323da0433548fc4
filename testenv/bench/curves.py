# SPDX-License-Identifier: Apache-2.0
"""Error against time as a chart with a curve for each setting, and as a table."""

from bench.performancePage import Table
from bench.sceneRun import SecondsAt
from support.svgChart import Chart

HEAD = ["setting", "samples", "s", "over the first", "relMSE", "s for equal error, over the first"]


def CurveChart(title: str, curves: dict) -> Chart:
    """\\param curves {setting: points}."""
    chart = Chart(title, "seconds", "relMSE")
    for name, points in curves.items():
        chart.Add(name, [point.seconds for point in points], [point.error for point in points])
    return chart


def CurveTable(stem: str, curves: dict) -> Table:
    """The last point of each curve; CSV has all. The first curve is what the others are compared with."""
    first = next(iter(curves.values()))

    def Row(name, point):
        same = next((other for other in first if other.samples == point.samples), None)
        equal = SecondsAt(first, point.error)
        equal = same.seconds if same and same.error == point.error else equal
        return [name, point.samples, point.seconds, point.seconds / same.seconds if same else None, point.error,
                point.seconds / equal if equal else None]

    rows = {name: [Row(name, point) for point in points] for name, points in curves.items()}
    return Table(stem, HEAD, sum(rows.values(), []), [found[-1] for found in rows.values()])
