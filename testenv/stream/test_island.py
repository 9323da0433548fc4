# SPDX-License-Identifier: Apache-2.0
"""The generated island (stages/island.py): bits at any pool, with the hierarchy's pages among them, and preparation that is
killed, or loses its cache, or fills its disk. HDSTREAM_ISLAND_SIZE=0.01 makes it the island of size 1/100.

The oracle is the picture with resident geometry, all instances in tables, all arrays kept, and no cache.
"""

import contextlib
import itertools
import os
import pathlib
import shutil
import signal
import time

import pytest

pytest.importorskip("hdstream._core")

from hdstream.translate import rereading
from stages import island
from streamCase import Case, ColdCache, FinishRecord, FullDisk, Segments, StartRecord

_SIZE = float(os.environ.get("HDSTREAM_ISLAND_SIZE", "0.001"))
_SECONDS = 120 + 60_000 * _SIZE  # a command that takes longer hangs
_POOLS = ("100%", "50%", "15%", "2%") if _SIZE < 0.01 else ("100%", "79%", "50%", "30%", "15%", "5%", "2%")
_EAGER = ("--prepare", "eager")  # which pages rays ask for may differ a little from run to run
_CHUNKS = dict(chunkBytes=1 << 15, instanceChunks=256)
# Memory grows with the island: else larger ones would load and make their pages again for hours.
_POOL, _ROOMY_POOL = (f"{max(1, round(part * _SIZE))}M" for part in (2000, 15_000))
_HOST = max(1, round(1000 * _SIZE)) << 20
_OPTIONS = ("--chunkSize", "32768", "--instanceChunks", "256", "--geometryMemory", _POOL, "--hostMemory", str(_HOST))
_BLOCK_BYTES = 1 << 16  # of a segment's index (docs/cache-format.md)


@pytest.fixture(scope="module")
def Island(tmp_path_factory):
    path = tmp_path_factory.mktemp("island") / "stage.usdc"
    island.WriteIsland(path, _SIZE)
    smallest, rereading.SMALLEST = rereading.SMALLEST, 1 << 62  # all arrays are kept
    try:
        case = Case(path).RenderResident(noCache=True, chunkBytes=1 << 15, instanceChunks=0)
    finally:
        rereading.SMALLEST = smallest
    case.session.Clear()
    return case


@pytest.mark.parametrize("eviction", ["lru", "flush"])
def test_any_pool_gives_the_same_bits(Island, eviction):
    case = Island.Fresh()
    for entries, pool in itertools.product((0, 512), _POOLS):  # of the page table
        layers, statistics = case.Render(residency="stream", geometryMemory=pool, geometryEviction=eviction, hostMemory=_HOST,
                                         pageEntries=entries, **_CHUNKS)
        case.AssertBits(layers)
        geometry = statistics["geometry"]
        assert geometry["budget"] <= float(pool[:-1]) / 100 * geometry["bytesTotal"] + 1
        assert geometry["peakBytes"] <= geometry["budget"]
    assert geometry["evictions"] > 0


def test_islands_by_one_more_level_of_instancing(Island, tmp_path):
    """They are one group, whose records stream as its geometry does. Tables do not grow with the number of islands."""

    def Islands(count):
        path = tmp_path / f"islands-{count}.usdc"
        island.WriteArchipelago(path, Island.path, count, _SIZE)
        return Case(path)

    case = Islands(4).RenderResident(noCache=True, chunkBytes=1 << 15)
    layers, few = case.Fresh().Render(residency="stream", geometryMemory=_POOL, **_CHUNKS)
    case.AssertBits(layers)
    many = Islands(9).Render(residency="stream", geometryMemory=_POOL, samples=1, **_CHUNKS)[1]
    for count, statistics in ((4, few), (9, many)):
        assert statistics["geometry"]["instances"] == count * Island.statistics["geometry"]["instances"]
        assert statistics["geometry"]["evictions"] > 0
    # 2 MB of the tables are of plants, whose leaves are as many at any size (docs/decisions/0018-streamed-hierarchy.md).
    assert few["geometry"]["alwaysResidentBytes"] < 0.4 * case.statistics["geometry"]["alwaysResidentBytes"]
    assert many["geometry"]["alwaysResidentBytes"] - few["geometry"]["alwaysResidentBytes"] <= 5 * 200  # records and their nodes


def test_a_cache_cold_and_warm(Island, tmp_path):
    """A cold cache for each eviction, of which all pools then find all pages."""
    for eviction in ("lru", "flush"):
        cache = ColdCache(tmp_path / f"cache-{eviction}")
        for number, pool in enumerate(("15%", *_POOLS)):
            case = Island.Fresh()
            layers, statistics = case.Render(residency="stream", geometryMemory=pool, geometryEviction=eviction, prepare="eager",
                                             cacheDirectory=cache, hostMemory=_HOST, **_CHUNKS)
            case.AssertBits(layers)
            assert (statistics["geometry"]["chunksBuilt"] > 0) == (number == 0)
            assert statistics["memory"]["arrays"] > 0


# --- Processes ----------------------------------------------------------------------------------------------------------


def _Start(case, cache, folder, name, *options):
    return StartRecord(case, cache, folder, name, *_OPTIONS, *options)


def _Finish(process, folder, name):
    """(picture file's bytes, geometry's statistics)"""
    picture, statistics = FinishRecord(process, folder, name, _SECONDS)
    return picture, statistics["geometry"]


@pytest.fixture(scope="module")
def Recorded(Island, tmp_path_factory):
    """The file that `hdstream record` writes with an empty cache."""
    folder = tmp_path_factory.mktemp("recorded")
    return _Finish(_Start(Island, ColdCache(folder / "cache"), folder, "alone"), folder, "alone")[0]


def _PageBytes(cache):
    total = 0
    for segment in Segments(cache):
        with contextlib.suppress(FileNotFoundError):  # what a killed run has left may go while this looks
            total += segment.stat().st_size
    return total


def _Maps(process, path):
    with contextlib.suppress(OSError):
        return path in pathlib.Path(f"/proc/{process}/maps").read_text()
    return False


# When a run is killed: by what it has mapped, and by what is in the cache, which it fills with summaries, then with pages
# while it renders.
_PHASES = {
    "before the first summary": lambda cache: any(pathlib.Path(cache).glob("pages-*")),
    "among summaries": lambda cache: _PageBytes(cache) > 0,
    "at the first pages": lambda cache: _PageBytes(cache) > _BLOCK_BYTES + (1 << 16),
    "among pages": lambda cache: _PageBytes(cache) > _BLOCK_BYTES + (1 << 20),
}


def _Await(process, phase, isReached):
    """Returns when a phase of a run has come, or the run is done."""
    end = time.monotonic() + _SECONDS
    while process.poll() is None and not isReached():
        assert time.monotonic() < end, f"{phase}: not reached"
        time.sleep(0.0005)


def test_killed_in_every_phase_of_preparation(Island, Recorded, tmp_path):
    """Each run finds what those before it left; the last one has all of it and nothing that is wrong."""
    cache = ColdCache(tmp_path / "cache")
    for index, (phase, isReached) in enumerate({"while the stage is read": None, **_PHASES}.items()):
        process = _Start(Island, cache, tmp_path, f"killed{index}")
        _Await(process, phase, lambda: isReached(cache) if isReached else _Maps(process.pid, "Scattered"))
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=_SECONDS)
        assert process.returncode == -signal.SIGKILL, f"{phase}: the run was done before"
    picture, geometry = _Finish(_Start(Island, cache, tmp_path, "last", *_EAGER), tmp_path, "last")
    assert picture == Recorded and geometry["chunksBuilt"] > 0
    picture, geometry = _Finish(_Start(Island, cache, tmp_path, "again", *_EAGER), tmp_path, "again")
    assert picture == Recorded and geometry["chunksBuilt"] == 0


def test_two_processes_share_a_cache(Island, Recorded, tmp_path):
    """Both at once, with other evictions and pools: of a cold cache, then of one that is warm."""
    cache = ColdCache(tmp_path / "cache")
    ways = {"a": (), "b": ("--geometryEviction", "flush", "--geometryMemory", _ROOMY_POOL)}
    for temperature in ("cold", "warm"):
        processes = {name: _Start(Island, cache, tmp_path, name, *_EAGER, *way) for name, way in ways.items()}
        for name, process in processes.items():
            picture, geometry = _Finish(process, tmp_path, name)
            assert picture == Recorded, (temperature, name)
            assert temperature == "cold" or geometry["chunksBuilt"] == 0


@pytest.mark.parametrize("phase", ["among summaries", "at the first pages"])
def test_the_cache_is_deleted_while_it_renders(Island, Recorded, tmp_path, phase):
    cache = pathlib.Path(ColdCache(tmp_path / "cache"))
    process = _Start(Island, cache, tmp_path, "deleted", "--hostMemory", "1G")  # else pages are made again and again
    _Await(process, phase, lambda: _PHASES[phase](cache))
    assert process.poll() is None, "the run was done before"
    while cache.exists():
        shutil.rmtree(cache, ignore_errors=True)
    assert _Finish(process, tmp_path, "deleted")[0] == Recorded


@pytest.mark.parametrize("isEarly", [True, False], ids=["among summaries", "among pages"])
def test_the_disk_runs_full(Island, Recorded, tmp_path, isEarly):
    """One warning and the same bits; the next run uses what is in the cache, and all of it is right."""
    settings = dict(residency="stream", geometryMemory=_ROOMY_POOL, hostMemory=_HOST, waveSize=64, **_CHUNKS)
    Island.Fresh().Render(**settings)  # compiles kernels
    cache, case = ColdCache(tmp_path / "cache"), Island.Fresh()
    with FullDisk(cache, 0 if isEarly else _BLOCK_BYTES, isEarly) as disk:
        layers, statistics = case.Render(disk, cacheDirectory=cache, **settings)
    case.AssertBits(layers)
    assert (disk.fraction == 0) == isEarly
    assert disk.limit and _PageBytes(cache) <= disk.limit * len(Segments(cache))
    assert len([line for line in case.session.Warnings() if "no more pages are kept" in line]) == 1, case.session.Warnings()
    picture, geometry = _Finish(_Start(Island, cache, tmp_path, "after"), tmp_path, "after")
    assert picture == Recorded and 0 < geometry["chunksBuilt"] < statistics["geometry"]["chunks"]
