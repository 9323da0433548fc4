# SPDX-License-Identifier: Apache-2.0
"""Budgets by the process's own memory: RssAnon of processes that differ in one budget alone differs by what the budgets do.
On a CPU device the pool is memory of the process. Pages come from the cache, since what builds them leaves the allocators in
another state each time. testenv/bench/memoryBudget.py does the same in the large."""

import pytest

pytest.importorskip("hdstream._core")

from bench import memoryBudget
from stages import bench

_MEGA = 1 << 20
_SETTINGS = dict(camera="/World/Camera", imageWidth=320, imageHeight=240, samples=1, residency="stream", waveSize=1 << 15)


@pytest.fixture(scope="module")
def Render(tmp_path_factory):
    """Renders a terrain of 140 MiB, all of whose pages are in the cache, in a process of its own."""
    folder = tmp_path_factory.mktemp("terrain")
    stage = str(folder / "stage.usdc")
    bench.WriteTerrain(stage, cells=1600)

    def Render(**settings):
        return memoryBudget.Render(stage, **_SETTINGS, cacheDirectory=str(folder / "cache"), **settings)

    Render(prepare="eager", geometryMemory="80M")
    return Render


def _Pair(Render, name, budgets, **settings):
    runs = [Render(**settings, **{name: budget}) for budget in budgets]
    for run in runs:
        print(f"{name}: {run['anonymous'] / _MEGA:.1f} MiB; {run['geometry']}")
        assert run["geometry"]["chunksBuilt"] == 0
    return runs


def _Grows(runs, byBytes):
    """The larger budget's process has so many bytes more, give or take an eighth: pages of the allocators."""
    more = runs[1]["anonymous"] - runs[0]["anonymous"]
    assert abs(more - byBytes) < byBytes / 8, f"{more / _MEGA:.2f} MiB more, not {byBytes / _MEGA:.2f}"


def test_the_process_has_the_pool_that_was_asked_for(Render):
    budgets = [16 * _MEGA, 80 * _MEGA]
    runs = _Pair(Render, "geometryMemory", [str(budget) for budget in budgets], hostMemory=1024 * _MEGA)  # keeps all
    _Grows(runs, budgets[1] - budgets[0])
    for run, budget in zip(runs, budgets):
        assert run["geometry"]["budget"] == budget and run["geometry"]["evictions"] > 0, "all of the pool is used"
        assert 0.9 * budget < run["geometry"]["peakBytes"] <= budget


def test_the_process_keeps_the_prepared_pages_that_it_may(Render):
    """The pool is small: what a round prepares for it is kept, up to three quarters of the bound; a quarter is for what pages
    are made of (docs/memory-budgets.md), and these come from the cache."""
    budgets = [8 * _MEGA, 72 * _MEGA]
    runs = _Pair(Render, "hostMemory", budgets, geometryMemory=str(4 * _MEGA))
    _Grows(runs, (budgets[1] - budgets[0]) * 3 // 4)
    assert all(run["geometry"]["uniqueBytesLoaded"] > budgets[1] for run in runs), "more is prepared than is kept"
