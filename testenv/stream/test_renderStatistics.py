# SPDX-License-Identifier: Apache-2.0
"""Statistics are those of the last render of a session, whatever the renders before it have done."""

import pytest

pytest.importorskip("hdstream._core")

from stages import streaming
from streamCase import Case, ColdCache, MovedMesh

_COUNTS = ("uploads", "uploadedBytes", "uniqueBytesLoaded", "evictions", "shadingRefetches", "chunksBuilt", "chunksFromCache")
_SECONDS = ("prepare", "compile", "requests")  # what a render that finds everything ready does not do at all


@pytest.fixture(scope="module")
def Path(tmp_path_factory):
    path = tmp_path_factory.mktemp("overlap") / "stage.usda"
    streaming.WriteOverlap(str(path), meshes=8, rings=16)
    return path


@pytest.mark.parametrize("settings", [dict(residency="resident"), dict(residency="stream", geometryMemory="64M"),
                                      dict(residency="stream", geometryMemory="64M", request="first")],
                         ids=["resident", "stream", "first"])
def test_a_second_render_has_nothing_to_load(Path, settings):
    case = Case(Path)
    _, first = case.Render(noCache=True, **settings)
    _, second = case.Render(noCache=True, **settings)
    _, third = case.Render(noCache=True, seed=5, imageWidth=40, **settings)
    assert first["geometry"]["uploadedBytes"] == first["geometry"]["uniqueBytesLoaded"] > 0 < first["time"]["prepare"]
    assert {name: second["geometry"][name] for name in _COUNTS} == dict.fromkeys(_COUNTS, 0)
    assert {name: second["time"][name] for name in _SECONDS} == dict.fromkeys(_SECONDS, 0)
    assert second["geometry"]["iterations"] == second["geometry"]["rayBatches"] > 0
    assert second["geometry"]["raysRelaunched"] == 0
    assert third["geometry"]["uploadedBytes"] < 0.1 * first["geometry"]["uploadedBytes"], "other rays see little more"
    streams = settings["residency"] == "stream"
    assert (0 < second["geometry"]["chunksTouched"] <= first["geometry"]["chunksTouched"]) == streams
    assert second["rays"]["camera"] == first["rays"]["camera"] > third["rays"]["camera"]


@pytest.mark.parametrize("residency", ["resident", "stream"])
def test_an_edit_loads_what_it_brings(Path, residency):
    case = Case(Path)
    settings = dict(residency=residency, geometryMemory="64M", noCache=True)
    _, first = case.Render(**settings)
    ball = case.session.Scene().geometry["/World/Ball3"]
    case.session.SetGeometry("/World/Ball3", MovedMesh(case.core, ball, (0.3, 0.2, 0.1)))
    _, second = case.Render(**settings)
    chunks = first["geometry"]["chunks"]
    assert 0 < second["geometry"]["chunksBuilt"] < chunks // 4
    assert 0 < second["geometry"]["uploadedBytes"] < 0.2 * first["geometry"]["uploadedBytes"]
    assert 0 < second["geometry"]["uploads"] <= 2 * second["geometry"]["chunksBuilt"]
    if residency == "stream":
        assert second["geometry"]["chunksTouched"] > second["geometry"]["chunksBuilt"], "most are there already"
    case.session.Remove("/World/Ball3")
    _, third = case.Render(**settings)
    if residency == "resident":
        assert third["geometry"]["chunks"] == chunks - second["geometry"]["chunksBuilt"]
        assert third["geometry"]["chunksBuilt"] == third["geometry"]["uploads"] == 0
    else:  # what was behind it is seen
        assert third["geometry"]["uploadedBytes"] < 0.1 * first["geometry"]["uploadedBytes"]


def test_each_render_counts_what_it_loads_again(Path):
    """A pool that is too small loads the same pages in each render: unique bytes are those of one."""
    case = Case(Path)
    renders = [case.Render(residency="stream", geometryMemory="48K", noCache=True, waveSize=1 << 11, hostMemory=1 << 14)[1]["geometry"]
               for _ in range(3)]
    for geometry in renders:
        assert 0 < geometry["uniqueBytesLoaded"] <= geometry["bytesTotal"] < geometry["uploadedBytes"]
        assert 0 < geometry["chunksTouched"] <= geometry["chunks"]
    assert renders[2]["uploadedBytes"] < 1.5 * renders[1]["uploadedBytes"]


def test_pages_that_come_from_the_cache(Path, tmp_path):
    cache = ColdCache(tmp_path / "cache")
    Case(Path).Render(residency="resident", cacheDirectory=cache)
    case = Case(Path)
    _, first = case.Render(residency="resident", cacheDirectory=cache)
    _, second = case.Render(residency="resident", cacheDirectory=cache, seed=3)
    assert first["geometry"]["chunksFromCache"] == first["geometry"]["chunks"]
    assert second["geometry"]["chunksFromCache"] == second["geometry"]["chunksBuilt"] == 0


def test_peak_memory_is_of_the_last_render(Path):
    case = Case(Path)
    _, large = case.Render(residency="resident", noCache=True, imageWidth=500, imageHeight=500, samples=1)
    _, small = case.Render(residency="resident", noCache=True, samples=1)
    _, again = case.Render(residency="resident", noCache=True, samples=1)
    assert again["memory"]["devicePeak"] < large["memory"]["devicePeak"] - 500 * 500
    assert again["memory"]["devicePeak"] <= small["memory"]["devicePeak"]
