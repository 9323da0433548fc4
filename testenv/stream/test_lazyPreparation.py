# SPDX-License-Identifier: Apache-2.0
"""Geometry that is prepared when rays ask for it gives the bits of geometry that is prepared before, and no more of it
is prepared than was asked for; what is in the cache is not prepared again."""

import pytest

pytest.importorskip("hdstream._core")

from stages import grove
from streamCase import Case, ColdCache



@pytest.fixture(scope="module")
def Garden(tmp_path_factory):
    """A garden with walls around it; most trees are in others."""
    path = tmp_path_factory.mktemp("gardens") / "stage.usda"
    grove.WriteGrove(str(path), 60_000, 4_000, gardens=3)
    return Case(path, "/World/Inside").RenderResident(noCache=True)


def _SmallPool(scene):
    """A tenth of all pages in bytes, so that sizes need not be known."""
    return str(max(24 << 10, int(0.1 * scene.statistics["geometry"]["bytesTotal"])))


def test_lazy_builds_what_rays_ask_for(Scene):
    geometry = Scene.Fresh().AssertStreams(noCache=True, geometryMemory="64M")
    assert 0 < geometry["chunksBuilt"] == geometry["chunksTouched"] <= geometry["chunks"]
    assert geometry["chunksFromCache"] == 0
    assert geometry["estimated"] == (geometry["chunksTouched"] < geometry["chunks"])


def test_what_is_hidden_is_not_built(Garden):
    lazy = Garden.Fresh().AssertStreams(noCache=True, geometryMemory="64M")
    assert 0 < lazy["chunksBuilt"] == lazy["chunksTouched"] < 0.4 * lazy["chunks"]
    assert lazy["estimated"]
    eager = Garden.Fresh().AssertStreams(noCache=True, geometryMemory="64M", prepare="eager")
    assert eager["chunksTouched"] == lazy["chunksTouched"] and eager["chunksBuilt"] == eager["chunks"] == lazy["chunks"]


def test_eager_builds_everything(Scene):
    geometry = Scene.Fresh().AssertStreams(noCache=True, geometryMemory="64M", prepare="eager")
    assert geometry["chunksBuilt"] == geometry["chunks"] and not geometry["estimated"]


def test_a_warm_cache_builds_nothing(Scene, tmp_path):
    cache = ColdCache(tmp_path / "cache")
    cold = Scene.Fresh().AssertStreams(cacheDirectory=cache, geometryMemory="64M")
    # Equal meshes share pages; a chunk's two pages may be read apart.
    assert cold["chunksBuilt"] <= cold["chunksTouched"] <= cold["chunksBuilt"] + cold["chunksFromCache"]
    warm = Scene.Fresh().AssertStreams(cacheDirectory=cache, geometryMemory="64M")
    assert warm["chunksBuilt"] == 0 and warm["chunksTouched"] == cold["chunksTouched"]
    assert warm["chunksTouched"] <= warm["chunksFromCache"] <= 2 * warm["chunksTouched"]
    eager = Scene.Fresh().AssertStreams(cacheDirectory=cache, geometryMemory="64M", prepare="eager")
    assert eager["chunksBuilt"] <= eager["chunks"] - cold["chunksTouched"] and not eager["estimated"]
    complete = Scene.Fresh()
    layers, statistics = complete.Render(residency="resident", cacheDirectory=cache)
    complete.AssertBits(layers)
    assert statistics["geometry"]["chunksBuilt"] == 0
    assert statistics["geometry"]["chunksFromCache"] == statistics["geometry"]["chunks"]


def test_forgotten_pages_are_made_again(Scene, tmp_path):
    """Host memory for few pages and a small pool: built anew without a cache, read again with one."""
    pool = _SmallPool(Scene)
    settings = dict(geometryMemory=pool, hostMemory=16 << 10, waveSize=1 << 12)
    without = Scene.Fresh().AssertStreams(noCache=True, **settings)
    assert without["chunksBuilt"] > without["chunksTouched"] and without["chunksFromCache"] == 0
    assert without["budget"] <= int(pool)
    cached = Scene.Fresh().AssertStreams(cacheDirectory=ColdCache(tmp_path / "cache"), **settings)
    assert cached["chunksBuilt"] <= cached["chunks"] < cached["chunksBuilt"] + cached["chunksFromCache"]


@pytest.mark.parametrize("isWarm, settings", [
    (False, dict(prepare="lazy", geometryEviction="flush")),
    (True, dict(prepare="eager", hostMemory=1 << 14)),
    (True, dict(prepare="lazy", hostMemory=1 << 14, request="first", traversal="scalar")),
    (False, dict(residency="resident", hostMemory=1 << 14)),
], ids=["cold-lazy-flush", "warm-eager-tinyHost", "warm-lazy-tinyHost-first-lane", "cold-resident-tinyHost"])
def test_every_way_gives_the_same_bits(Scene, isWarm, settings, tmp_path):
    pool, cache = _SmallPool(Scene), ColdCache(tmp_path / "cache")
    if isWarm:
        Scene.Fresh().Start(residency="resident", samples=1, cacheDirectory=cache)
    layers, statistics = Scene.Fresh().Render(**{"residency": "stream", "geometryMemory": pool, "cacheDirectory": cache, **settings})
    Scene.AssertBits(layers)
    geometry = statistics["geometry"]
    assert (geometry["chunksBuilt"] == 0) == isWarm
    assert geometry["mode"] == "resident" or geometry["budget"] <= int(pool)


def test_a_percentage_is_of_exact_sizes(Garden, tmp_path):
    """All is prepared, or found in the cache, before the share is taken."""
    cache = ColdCache(tmp_path / "cache")
    total = Garden.statistics["geometry"]["bytesTotal"]
    for isWarm in (False, True):
        geometry = Garden.Fresh().AssertStreams(cacheDirectory=cache, geometryMemory="30%")
        assert geometry["bytesTotal"] == total and not geometry["estimated"]
        assert geometry["budget"] == int(0.3 * total) // 16 * 16
        assert (geometry["chunksBuilt"] == 0) == isWarm


@pytest.mark.parametrize("prepare", ["lazy", "eager"])
def test_a_pool_below_the_largest_chunk_is_an_error(Garden, prepare):
    """It names what is needed, exactly: so much is enough, although bounds of other chunks are larger."""
    tooSmall = Garden.Fresh()
    with pytest.raises(Garden.core.Error, match="--geometryMemory: 1024 bytes cannot hold the largest chunk, which takes") as error:
        tooSmall.Render(residency="stream", geometryMemory="1K", noCache=True, prepare=prepare)
    needed = int(str(error.value).split("which takes ")[1].split()[0])
    geometry = Garden.Fresh().AssertStreams(geometryMemory=str(needed), noCache=True, prepare=prepare)
    assert geometry["budget"] <= needed
    with pytest.raises(Garden.core.Error, match=f"which takes {needed} "):
        Garden.Fresh().Render(residency="stream", geometryMemory=str(needed - 16), noCache=True, prepare=prepare)


def test_budgets_in_bytes_hold_while_sizes_are_bounds(Garden):
    for pool in ("40K", "200K", "1M"):
        geometry = Garden.Fresh().AssertStreams(geometryMemory=pool, noCache=True)
        assert geometry["budget"] <= {"40K": 40 << 10, "200K": 200 << 10, "1M": 1 << 20}[pool]
        assert geometry["chunksBuilt"] >= geometry["chunksTouched"] < geometry["chunks"]
