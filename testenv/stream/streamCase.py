# SPDX-License-Identifier: Apache-2.0
"""A stage rendered with streamed geometry and textures, against its picture with resident ones."""

import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest

AOVS = ["color", "depth", "normal", "primId", "instanceId", "elementId", "primvars:displayColor", "variance"]
SIZE = (61, 43)  # odd: no wave ends with a row
SAMPLES = 3
CHUNK_BYTES = 4096
RECORD_SECONDS = 120  # a command that takes longer hangs


def ColdCache(folder) -> str:
    """A cache folder without pages. It has the kernels of the common one, which take longer than a test: their files,
    where links can be made, since there may be many."""
    from hdstream import _core

    folder = pathlib.Path(folder)
    folder.mkdir()
    for kernel in pathlib.Path(_core.InspectCache("").directory).glob("kernel-*.hdsc"):
        try:
            os.link(kernel, folder / kernel.name)
        except OSError:
            shutil.copy(kernel, folder)
    return str(folder)


def Segments(cache) -> list:
    """The files of a cache folder that hold pages."""
    return sorted(pathlib.Path(cache).glob("pages-*.hdsp"))


def StartRecord(case, cache, folder, name, *options):
    """`hdstream record` of a case's stage, started."""
    command = [sys.executable, "-m", "hdstream", "record", case.path, str(folder / f"{name}.exr"), "--quiet",
               "--camera", case.camera, "--imageWidth", "64", "--imageHeight", "36", "--samples", "2",
               "--chunkSize", str(CHUNK_BYTES), "--residency", "stream", "--cacheDir", str(cache),
               "--stats", str(folder / f"{name}.json"), *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def FinishRecord(process, folder, name, seconds=RECORD_SECONDS):
    """(picture file's bytes, statistics) of a command that must succeed within so many seconds."""
    try:
        out, err = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        pytest.fail(f"hdstream record hangs: {process.communicate()}")
    assert process.returncode == 0, out + err
    return (folder / f"{name}.exr").read_bytes(), json.loads((folder / f"{name}.json").read_text())


class FullDisk:
    """onProgress of a render: once the first samples are there, files cannot grow beyond the cache's segments and `room`. Kernels
    are compiled by then: PoCL needs files for that. `isEarly`: as soon as there are segments, while prims are planned, for
    renders whose kernels the process has. `with` ends it."""

    def __init__(self, cache, room, isEarly=False):
        self._cache, self._room, self._isEarly = cache, room, isEarly
        self.limit = self.fraction = None  # of the files' sizes; of the work, when it was set
        self._old = resource.getrlimit(resource.RLIMIT_FSIZE)

    def __call__(self, progress):
        isReached = progress.fraction > 0 or (self._isEarly and Segments(self._cache))
        if isReached and self.limit is None:
            self.fraction = progress.fraction
            self.limit = max(path.stat().st_size for path in Segments(self._cache)) + self._room
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # LLVM has taken it; writes shall fail instead
            resource.setrlimit(resource.RLIMIT_FSIZE, (self.limit, self._old[1]))
        return True

    def __enter__(self):
        return self

    def __exit__(self, *_):
        resource.setrlimit(resource.RLIMIT_FSIZE, self._old)


def MovedMesh(core, prim, offset):
    """A mesh with other points: all its pages are new."""
    mesh = core.GeometryDescription()
    for name in ("faceVertexCounts", "faceVertexIndices", "holeIndices", "subdivisionScheme", "leftHanded", "primvars"):
        setattr(mesh, name, getattr(prim.geometry, name))
    mesh.points = np.array(prim.geometry.points).reshape(-1, 3) + np.float32(offset)
    result = core.GeometryPrim(mesh, prim.placement, prim.purpose, prim.materialPath)
    result.doubleSided = prim.doubleSided
    return result


class Case:
    """A stage in a session of its own, and its picture with resident geometry."""

    def __init__(self, path, camera="/World/Camera", timeCode=None, shutter=(0.0, 0.0)):
        from hdstream import _core
        from hdstream.translate import TranslateStage
        from pxr import Usd

        self.core, self.path, self.camera = _core, str(path), camera
        self.layers = self.statistics = None
        self.session = _core.Session()
        TranslateStage(Usd.Stage.Open(self.path), self.session,
                       Usd.TimeCode.Default() if timeCode is None else timeCode, shutter)

    def Fresh(self):
        """The same in a new session, whose accounts begin at 0."""
        case = Case(self.path, self.camera)
        case.layers, case.statistics = self.layers, self.statistics
        return case

    def Copy(self, folder):
        """The stage, with images of its own."""
        copy = pathlib.Path(folder) / "copy"
        shutil.copytree(pathlib.Path(self.path).parent, copy)
        case = Case(copy / pathlib.Path(self.path).name, self.camera)
        case.layers, case.statistics = self.layers, self.statistics
        return case

    def RenderResident(self, **settings):
        """What streamed pictures are compared with; it must not have streamed itself."""
        self.layers, self.statistics = self.Render(residency="resident", **settings)
        assert [self.statistics[kind]["mode"] for kind in ("geometry", "texture")] == ["resident", "resident"]
        assert self.statistics["geometry"]["streamedSamples"] == self.statistics["geometry"]["evictions"] == 0
        return self

    def Start(self, onProgress=None, isCancelled=None, **settings):
        """The result of a render, complete or not."""
        options = self.core.Settings()
        options.camera, options.imageWidth, options.imageHeight = self.camera, *SIZE
        options.aovs, options.samples, options.chunkBytes = AOVS, SAMPLES, CHUNK_BYTES
        for name, value in settings.items():
            setattr(options, name, value)
        return self.session.Render(options, onProgress, [], isCancelled)

    def Render(self, onProgress=None, **settings):
        """(layers by name, statistics)"""
        assert self.Start(onProgress, **settings) == self.core.RenderResult.Complete
        layers = {layer.name: np.array(layer.pixels) for layer in self.session.Layers()}
        return layers, json.loads(self.session.Statistics())

    def AssertBits(self, layers):
        assert set(layers) == set(self.layers)
        for name, pixels in layers.items():
            assert pixels.tobytes() == self.layers[name].tobytes(), f"layer {name} differs"

    def AssertStreams(self, onProgress=None, **settings):
        """Renders with streaming; checks bits and accounts. Returns geometry's statistics. Geometry may have become resident, but only
        once the pool held all of it."""
        layers, statistics = self.Render(onProgress, residency="stream", **settings)
        self.AssertBits(layers)
        geometry, paths = statistics["geometry"], statistics["rays"]["camera"]
        if geometry["mode"] == "stream":
            assert geometry["streamedSamples"] == statistics["image"]["samples"] and geometry["streamedPaths"] == paths
        else:
            assert geometry["mode"] == "resident" and settings.get("request") != "first"
            assert geometry["bytesTotal"] <= geometry["peakBytes"] <= geometry["budget"] and geometry["streamedPaths"] < paths
        if geometry["estimated"]:
            assert geometry["bytesTotal"] >= self.statistics["geometry"]["bytesTotal"]
        else:
            assert geometry["bytesTotal"] == self.statistics["geometry"]["bytesTotal"]
        assert geometry["uniqueBytesLoaded"] <= geometry["uploadedBytes"]
        assert geometry["uniqueBytesLoaded"] <= geometry["bytesTotal"]
        assert geometry["chunksTouched"] > 0 or geometry["uniqueBytesLoaded"] == 0 or geometry["mode"] == "resident"
        assert geometry["pinnedBytes"] <= geometry["budget"] // 4
        assert geometry["pinnedBytes"] <= geometry["peakBytes"] <= geometry["budget"]
        assert geometry["iterations"] >= geometry["rayBatches"] > 0
        self.AssertTextures(statistics["texture"])
        assert geometry["chunksTouched"] <= geometry["chunks"]
        # What is resident at any time fits: only what has left can be loaded again.
        if geometry["evictions"] == 0:
            assert geometry["uploadedBytes"] == geometry["uniqueBytesLoaded"] <= geometry["peakBytes"]
        return geometry

    def AssertTextures(self, texture):
        """Accounts of textures that stream."""
        if texture["textures"] == 0:
            return
        assert texture["mode"] == "stream"
        assert texture["fallbackTexels"] == 0, "final pictures are exact"
        assert texture["peakBytes"] <= texture["budget"]
        assert texture["alwaysResidentBytes"] <= texture["peakBytes"]
        assert texture["uniqueBytesLoaded"] <= texture["uploadedBytes"]
        assert texture["uniqueBytesLoaded"] <= texture["bytesTotal"]
        assert texture["bytesTotal"] == 512 * texture["linesTotal"]
        assert texture["linesLoaded"] <= texture["linesTotal"]
        assert (texture["uploadedBytes"] > 0) <= (texture["misses"] > 0)
        assert texture["misses"] <= texture["lookups"] > 0
        assert texture["shadeIterations"] >= texture["shadePasses"] > 0
        if texture["evictions"] == 0:
            assert texture["uploadedBytes"] == texture["uniqueBytesLoaded"] <= texture["peakBytes"]

    def AssertStreamsTextures(self, onProgress=None, **settings):
        """As AssertStreams. Returns the statistics of textures."""
        layers, statistics = self.Render(onProgress, residency="stream", **settings)
        self.AssertBits(layers)
        self.AssertTextures(statistics["texture"])
        return statistics["texture"]
