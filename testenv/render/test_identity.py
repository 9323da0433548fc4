# SPDX-License-Identifier: Apache-2.0
"""Bits are a function of scene, settings and samples, and of nothing else.

Every comparison is of all layers, bit for bit, on scenes that use lights, instances and cut-outs.
"""

import pytest

pytest.importorskip("hdstream._core")

import ours
from stages import economies
from stages.verify import CASES

_AOVS = ("color", "alpha", "depth", "normal", "position", "primId", "instanceId", "elementId", "variance")
_NAMES = ("fiveLights", "instancing", "surfaceCutout", "surfaceClearcoat", "surfaceEmissive")
_SIZE = (61, 47)  # odd: no wave or tile ends with a row


@pytest.fixture(scope="module", params=_NAMES)
def Stage(request, tmp_path_factory):
    return CASES[request.param].Write(f"{tmp_path_factory.mktemp(request.param)}/stage.usda")


@pytest.fixture(scope="module")
def Expected(Stage):
    return ours.Render(Stage, *_SIZE, _AOVS, samples=20, waveSize=1 << 16).layers


def _AssertSameBits(a: dict, b: dict) -> None:
    assert set(a) == set(b)
    for name in a:
        assert a[name].tobytes() == b[name].tobytes(), f"layer {name} differs"


@pytest.mark.parametrize("waveSize", [8192, 1 << 16, 1 << 20, 3001])
def test_wave_size_does_not_matter(Stage, Expected, waveSize):
    _AssertSameBits(ours.Render(Stage, *_SIZE, _AOVS, samples=20, waveSize=waveSize).layers, Expected)


@pytest.mark.parametrize("traversal", ["flat", "simd8", "scalar"])
def test_traversal_form_does_not_matter(Stage, Expected, traversal):
    _AssertSameBits(ours.Render(Stage, *_SIZE, _AOVS, samples=20, traversal=traversal).layers, Expected)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_thread_count_does_not_matter(Stage, Expected, threads):
    """PoCL reads its thread count once, so each count has a process."""
    layers = ours.RenderApart(Stage, *_SIZE, {"POCL_MAX_PTHREAD_COUNT": str(threads)}, aovs=list(_AOVS), samples=20, waveSize=1 << 16)
    _AssertSameBits(layers, Expected)


def test_chunk_size_does_not_matter(Stage, Expected):
    _AssertSameBits(ours.Render(Stage, *_SIZE, _AOVS, samples=20, chunkBytes=1 << 14).layers, Expected)


def test_caches_do_not_matter(Stage, Expected, tmp_path):
    """Without a cache, with an empty one, and with what the render before has left there."""
    for chunksFrom in ("chunksBuilt", "chunksFromCache"):
        picture = ours.Render(Stage, *_SIZE, _AOVS, samples=20, noCache=False, cacheDirectory=str(tmp_path))
        assert picture.statistics["geometry"][chunksFrom] > 0
        _AssertSameBits(picture.layers, Expected)


def test_seed_does_matter(Stage, Expected):
    other = ours.Render(Stage, *_SIZE, _AOVS, samples=20, seed=9).layers
    assert other["color"].tobytes() != Expected["color"].tobytes()


def test_what_no_ray_sees_does_not_matter(tmp_path):
    """Neither does what else the kernels can do then."""
    def Picture(addition):
        path = tmp_path / f"{addition}.usda"
        economies.WriteEconomies(path, addition, cells=12)
        aovs = [name for name in _AOVS if name not in ("primId", "instanceId")]  # these count the scene's prims
        return ours.Render(str(path), *_SIZE, aovs, samples=20).layers

    assert {"nothing", "all of these"} < set(economies.UNSEEN)
    _AssertSameBits(Picture("all of these"), Picture("nothing"))
