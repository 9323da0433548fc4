# SPDX-License-Identifier: Apache-2.0
"""Streamed geometry gives the bits of resident geometry, whatever the pool, in bounded memory.

The oracle is the resident mode, whose pictures testenv/render compares with closed forms and other renderers.
"""

import pytest

pytest.importorskip("hdstream._core")

from stages import streaming
from streamCase import SAMPLES, SIZE, Case

_POOLS = ("100%", "79%", "50%", "30%", "15%", "5%", "2%")


@pytest.mark.parametrize("eviction", ["lru", "flush"])
def test_any_pool_gives_the_same_bits(Scene, eviction):
    uploaded = []
    for pool in _POOLS:
        geometry = Scene.AssertStreams(geometryMemory=pool, geometryEviction=eviction)
        assert geometry["budget"] <= float(pool[:-1]) / 100 * geometry["bytesTotal"] + 1
        uploaded.append(geometry["uploadedBytes"])
    assert uploaded[-1] > uploaded[0], "a small pool loads more"


def test_all_fits_means_loaded_once(Scene):
    geometry = Scene.AssertStreams(geometryMemory="100%")
    assert geometry["evictions"] == 0 and geometry["uploadedBytes"] == geometry["uniqueBytesLoaded"]


@pytest.mark.parametrize("settings", [
    dict(traversal="scalar"),
    dict(traversal="scalar", geometryEviction="flush"),
    dict(request="first"),
    dict(request="first", traversal="scalar", geometryEviction="flush"),
    dict(waveSize=1000),
    dict(waveSize=1 << 20),
], ids=lambda settings: "-".join(f"{key}={value}" for key, value in settings.items()))
def test_other_ways_give_the_same_bits(Scene, settings):
    Scene.AssertStreams(geometryMemory="10%", **settings)


@pytest.mark.parametrize("pool", ["99%", "10%"])
def test_slots_of_ended_paths_are_used_again(Scene, pool):
    """Where pages leave, a wave has six paths for each of its slots: so few waves trace the passes of one and two samples, and the
    first hits."""
    slots, pixels = 128, SIZE[0] * SIZE[1]
    layers, statistics = Scene.Render(residency="stream", geometryMemory=pool, waveSize=slots)
    Scene.AssertBits(layers)
    geometry = statistics["geometry"]
    assert statistics["wave"]["size"] == slots and statistics["rays"]["camera"] == pixels * SAMPLES
    assert geometry["rayBatches"] == sum(-(-pixels * samples // (6 * slots)) for samples in (1, 2, 1))


def test_the_pool_of_the_largest_chunk_is_enough(Scene):
    """And a smaller one says what is needed."""
    with pytest.raises(Scene.core.Error, match="--geometryMemory: 16 bytes cannot hold the largest chunk, which takes") as error:
        Scene.Render(residency="stream", geometryMemory="16")
    needed = int(str(error.value).split("which takes ")[1].split()[0])
    Scene.AssertStreams(geometryMemory=str(needed), waveSize=1 << 20)
    with pytest.raises(Scene.core.Error, match="cannot hold the largest chunk"):
        Scene.Render(residency="stream", geometryMemory=str(needed - 16))


def test_device_memory_is_what_was_asked_for(Scene):
    """By the allocator's own account: what is not the pool does not depend on the pool."""
    others = []
    for pool in (0.4, 0.1):
        fresh = Scene.Fresh()  # the account begins with the device
        _, statistics = fresh.Render(residency="stream", geometryMemory=f"{100 * pool:g}%")
        geometry, memory = statistics["geometry"], statistics["memory"]
        assert geometry["budget"] <= pool * geometry["bytesTotal"] + 1
        others.append(memory["devicePeak"] - geometry["budget"])
        assert others[-1] >= memory["pathState"] + memory["film"] + memory["tables"]
    assert others[0] == others[1]


def test_auto_streams_only_what_does_not_fit(Scene):
    _, statistics = Scene.Render(residency="auto")
    assert statistics["geometry"]["mode"] == "resident"
    layers, statistics = Scene.Render(residency="auto", geometryMemory="50%")
    assert statistics["geometry"]["mode"] == "stream"
    assert layers["color"].tobytes() == Scene.layers["color"].tobytes()
    _, statistics = Scene.Render(residency="auto", geometryMemory="100%")
    assert statistics["geometry"]["mode"] == "resident"


def test_mapped_pages_give_the_same_bits(Scene, tmp_path):
    """Read where the persistent cache has them: cold, warm, and nothing of it is device memory."""
    for isWarm in (False, True):
        fresh = Scene.Fresh()
        layers, statistics = fresh.Render(residency="mapped", cacheDirectory=str(tmp_path))
        for name, pixels in layers.items():
            assert pixels.tobytes() == Scene.layers[name].tobytes(), f"layer {name} differs"
        geometry = statistics["geometry"]
        assert geometry["mode"] == "mapped" and geometry["budget"] == 0
        assert (geometry["chunksBuilt"] == 0) == isWarm


def test_mapped_needs_the_cache(Scene):
    with pytest.raises(Scene.core.Error, match="--residency mapped: needs the persistent cache"):
        Scene.Render(residency="mapped", noCache=True)


def test_light_geometry_is_pinned(tmp_path):
    """Up to a quarter of the pool, and not where the report's rule empties it."""
    streaming.WriteOverlap(str(tmp_path / "stage.usda"), meshes=8, rings=16)
    case = Case(tmp_path / "stage.usda").RenderResident(noCache=True)
    for pool in ("100%", "50%", "30%", "15%"):
        geometry = case.Fresh().AssertStreams(geometryMemory=pool, noCache=True)
        assert 0 < geometry["pinnedBytes"] <= geometry["budget"] // 4
        geometry = case.Fresh().AssertStreams(geometryMemory=pool, noCache=True, geometryEviction="flush")
        assert geometry["pinnedBytes"] == 0
    dark = dict(case.session.Scene().geometry)
    glowing = dark["/World/Ball4"]
    glowing.materialPath = dark["/World/Ball3"].materialPath
    case.session.SetGeometry("/World/Ball4", glowing)
    case.RenderResident(noCache=True)
    assert case.AssertStreams(geometryMemory="30%", noCache=True)["pinnedBytes"] == 0, "nothing shines any more"
