# SPDX-License-Identifier: Apache-2.0
"""Budgets by the process's own memory: RssAnon of processes that differ in one budget alone differs by what the budgets do.
On a CPU device the pool is memory of the process. testenv/bench/memoryBudget.py does the same in the large."""

import pytest

pytest.importorskip("hdstream._core")

from bench import memoryBudget
from stages import bench

_MEGA = 1 << 20
_SETTINGS = dict(camera="/World/Camera", imageWidth=640, imageHeight=480, samples=1, residency="stream", waveSize=1 << 15,
                 noCache=True)


@pytest.fixture(scope="module")
def Terrain(tmp_path_factory):
    path = tmp_path_factory.mktemp("terrain") / "stage.usdc"
    bench.WriteTerrain(str(path), cells=900)
    return str(path)


def test_the_process_has_the_pool_that_was_asked_for(Terrain):
    """What builds pages comes and goes by some MiB: the lesser of two runs counts, and three eighths of what the budgets differ
    by are asked for. A process that ignored the budget would have about the same memory at both."""
    budgets = [8 * _MEGA, 40 * _MEGA]
    runs = [min((memoryBudget.Render(Terrain, **_SETTINGS, hostMemory=_MEGA, geometryMemory=str(budget)) for _ in range(2)),
                key=lambda run: run["anonymous"]) for budget in budgets]
    more = runs[1]["anonymous"] - runs[0]["anonymous"]
    difference = budgets[1] - budgets[0]
    assert difference * 3 / 8 < more < difference * 9 / 8, f"{more / _MEGA:.2f} MiB more, not {difference / _MEGA:.2f}"
    for run, budget in zip(runs, budgets):
        assert run["geometry"]["budget"] == budget and run["geometry"]["evictions"] > 0, "all of the pool is used"
        assert 0.9 * budget < run["geometry"]["peakBytes"] <= budget
