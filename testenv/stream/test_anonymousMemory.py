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


def _Pair(stage, name, budgets, **settings):
    """Statistics at both budgets, whose pictures ask for more than the larger one."""
    runs = [memoryBudget.Render(stage, **{**_SETTINGS, **settings, name: budget}) for budget in budgets]
    for run in runs:
        print(f"{name}: {run['anonymous'] / _MEGA:.1f} MiB; {run['geometry']}")
    return runs


def _Grows(runs, byBytes):
    """The larger budget's process has so many bytes more, give or take an eighth: pages of the allocators."""
    more = runs[1]["anonymous"] - runs[0]["anonymous"]
    assert abs(more - byBytes) < byBytes / 8, f"{more / _MEGA:.2f} MiB more, not {byBytes / _MEGA:.2f}"


def test_the_process_has_the_pool_that_was_asked_for(Terrain):
    budgets = [8 * _MEGA, 24 * _MEGA]
    runs = _Pair(Terrain, "geometryMemory", [str(budget) for budget in budgets], hostMemory=_MEGA)
    _Grows(runs, budgets[1] - budgets[0])
    for run, budget in zip(runs, budgets):
        assert run["geometry"]["budget"] == budget and run["geometry"]["evictions"] > 0, "all of the pool is used"
        assert 0.9 * budget < run["geometry"]["peakBytes"] <= budget


def test_the_process_keeps_the_prepared_pages_that_it_may(Terrain):
    budgets = [2 * _MEGA, 18 * _MEGA]
    runs = _Pair(Terrain, "hostMemory", budgets, geometryMemory=str(16 * _MEGA))
    _Grows(runs, budgets[1] - budgets[0])
    assert all(run["geometry"]["uniqueBytesLoaded"] > budgets[1] for run in runs), "more is prepared than is kept"
