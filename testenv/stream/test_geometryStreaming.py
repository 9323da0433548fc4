# SPDX-License-Identifier: Apache-2.0
"""Streamed geometry gives the bits of resident geometry, whatever the pool, in bounded memory.

The oracle is the resident mode, whose pictures testenv/render compares with closed forms and other renderers.
"""

import json

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from stages import streaming

_AOVS = ["color", "depth", "normal", "primId", "instanceId", "elementId", "primvars:displayColor", "variance"]
_SIZE = (61, 43)  # odd: no wave ends with a row
_SAMPLES = 3
_CHUNK_BYTES = 4096
_POOLS = ("100%", "79%", "50%", "30%", "15%", "5%", "2%")


class Case:
    """A stage in a session of its own, and its picture with resident geometry."""

    def __init__(self, path):
        from hdstream import _core
        from hdstream.translate import TranslateStage
        from pxr import Usd

        self.core = _core
        self.path = path
        self.session = _core.Session()
        TranslateStage(Usd.Stage.Open(path), self.session, Usd.TimeCode.Default())

    def Fresh(self):
        """The same in a new session."""
        return Case(self.path)

    def RenderResident(self):
        self.layers, self.statistics = self.Render(residency="resident")
        return self

    def Render(self, **settings):
        options = self.core.Settings()
        options.camera, options.imageWidth, options.imageHeight = "/World/Camera", *_SIZE
        options.aovs, options.samples, options.chunkBytes = _AOVS, _SAMPLES, _CHUNK_BYTES
        for name, value in settings.items():
            setattr(options, name, value)
        assert self.session.Render(options) == self.core.RenderResult.Complete
        layers = {layer.name: np.array(layer.pixels) for layer in self.session.Layers()}
        return layers, json.loads(self.session.Statistics())

    def AssertStreams(self, **settings):
        """Renders with streaming; checks bits and accounts. Returns geometry's statistics."""
        layers, statistics = self.Render(residency="stream", **settings)
        assert set(layers) == set(self.layers)
        for name, pixels in layers.items():
            assert pixels.tobytes() == self.layers[name].tobytes(), f"layer {name} differs"
        geometry = statistics["geometry"]
        assert geometry["mode"] == "stream"
        assert geometry["bytesTotal"] == self.statistics["geometry"]["bytesTotal"]
        assert 0 < geometry["uniqueBytesLoaded"] <= min(geometry["bytesTotal"], geometry["uploadedBytes"])
        assert geometry["peakBytes"] <= geometry["budget"]
        assert geometry["iterations"] >= geometry["casts"] > 0
        assert 0 < geometry["chunksTouched"] <= geometry["chunks"]
        # What is resident at any time fits: only what has left can be loaded again.
        if geometry["evictions"] == 0:
            assert geometry["uploadedBytes"] == geometry["uniqueBytesLoaded"] <= geometry["budget"]
        return geometry


@pytest.fixture(scope="module", params=list(streaming.CASES))
def Scene(request, tmp_path_factory):
    path = f"{tmp_path_factory.mktemp(request.param)}/stage.usda"
    streaming.CASES[request.param](path)
    return Case(path).RenderResident()


@pytest.mark.parametrize("eviction", ["clock", "flush"])
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
    dict(traversal="lane"),
    dict(traversal="lane", geometryEviction="flush"),
    dict(request="first"),
    dict(request="first", traversal="lane", geometryEviction="flush"),
    dict(waveSize=1000),
    dict(waveSize=1 << 20),
], ids=lambda settings: "-".join(f"{key}={value}" for key, value in settings.items()))
def test_other_ways_give_the_same_bits(Scene, settings):
    Scene.AssertStreams(geometryMemory="10%", **settings)


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
