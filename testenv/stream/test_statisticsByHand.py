# SPDX-License-Identifier: Apache-2.0
"""Figures of the statistics (docs/statistics.md) against what is counted by hand: a square that fills half of the picture, or
all of it, under one light without size."""

import json
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import Gf, Sdf, UsdGeom, Vt
from stages import author, shapes
from streamCase import Case

_PIXELS, _SAMPLES = 16 * 8, 4
_NODE, _INSTANCE, _OBJECT, _WORD = 80, 80, 16, 4  # bytes, kernels/shared
_SQUARE = shapes.Plane(2.0, 2.0)


def _Finish(stage):
    author.AddLight(stage, "/World/Sun", "Distant", dict(rotate=(-90, 0, 0)), intensity=1.0, angle=0.0)
    author.AddCamera(stage, eye=(0, 3, 0), target=(0, 0, 0), up=(0, 0, -1), aspect=2.0, orthographic=True, width=10.0)
    stage.GetRootLayer().Save()


def _Square(folder, offset=(0, 0, 0), scale=1.0):
    """A case of one square seen from above; the picture is one unit wide."""
    path = folder / "square.usda"
    stage = author.NewStage(path)
    author.AddMesh(stage, "/World/Square", _SQUARE, translate=offset, scale=scale)
    _Finish(stage)
    return Case(path)


def _Statistics(case, **settings):
    values = dict(imageWidth=16, imageHeight=8, samples=_SAMPLES, maxDepth=0, aovs=["color"], pixelFilter="box",
                  pixelFilterWidth=1.0, noCache=True)
    case.Start(**{**values, **settings})
    return json.loads(case.session.Statistics())


# --- Rays ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("residency", ["resident", "stream"])
def test_rays_of_a_square_that_fills_the_picture(tmp_path, residency):
    """Each sample is a camera ray, whose hit sends one shadow ray to the light and one ray on, which only finds lights."""
    rays = _Statistics(_Square(tmp_path), residency=residency)["rays"]
    assert rays["camera"] == _PIXELS * _SAMPLES
    assert rays["shadow"] == rays["indirect"] == _PIXELS * _SAMPLES


@pytest.mark.parametrize("residency", ["resident", "stream"])
def test_rays_of_a_square_that_fills_half_of_the_picture(tmp_path, residency):
    rays = _Statistics(_Square(tmp_path, offset=(-1, 0, 0)), residency=residency)["rays"]
    assert rays["camera"] == _PIXELS * _SAMPLES
    assert rays["shadow"] == rays["indirect"] == _PIXELS // 2 * _SAMPLES


# --- Ray batches, iterations and what waits ----------------------------------------------------------------


def test_ray_batches_and_iterations(tmp_path):
    """Resident: camera rays, then the rays of their hits, of each of the two passes (one sample, three samples). Streamed: each pass is a
    ray batch; in the first one all rays wait for the square's geometry and then all hits for its attributes."""
    settings = dict(waveSize=_PIXELS * _SAMPLES)
    resident = _Statistics(_Square(tmp_path), residency="resident", **settings)["geometry"]
    assert resident["rayBatches"] == resident["iterations"] == 4
    assert resident["maxIterationsPerBatch"] == 1
    assert resident["raysRelaunched"] == resident["shadingRefetches"] == 0
    case = Case(tmp_path / "square.usda")
    first = _Statistics(case, residency="stream", **settings)["geometry"]
    assert first["rayBatches"] == 2
    assert first["maxIterationsPerBatch"] == 3
    assert first["iterations"] == 3 + 1
    assert first["raysRelaunched"] == _PIXELS, "one sample of all pixels; the three that follow find the page"
    assert first["uploads"] == 2 and first["shadingRefetches"] == 1, "geometry for rays, attributes for their hits"
    second = _Statistics(case, residency="stream", **settings)["geometry"]
    assert second["maxIterationsPerBatch"] == 1 and second["shadingRefetches"] == second["raysRelaunched"] == 0


# --- Memory ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count, nodes", [(1, 1), (5, 1), (8, 1), (9, 2)])
@pytest.mark.parametrize("residency", ["resident", "stream"])
def test_what_is_always_resident(tmp_path, residency, count, nodes):
    """`count` instances of a square of one chunk: nodes of 8 children over them, a record and its order for each, two objects
    (the square and the tree over all), and the addresses of the chunk's two pages; streamed, what kernels tell of each page as well."""
    path = tmp_path / "instances.usda"
    stage = author.NewStage(path)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Squares")
    author.AddMesh(stage, "/World/Squares/Square", _SQUARE)
    instancer.CreatePrototypesRel().SetTargets([Sdf.Path("/World/Squares/Square")])
    instancer.CreateProtoIndicesAttr(Vt.IntArray([0] * count))
    instancer.CreatePositionsAttr([Gf.Vec3f(3.0 * i, 0, 0) for i in range(count)])
    _Finish(stage)
    geometry = _Statistics(Case(path), residency=residency)["geometry"]
    assert (geometry["instances"], geometry["chunks"]) == (count, 1)
    addresses = 2 * _WORD
    assert geometry["alwaysResidentBytes"] == (nodes * _NODE + count * (_INSTANCE + _WORD) + 2 * _OBJECT + addresses
                                               + (addresses if residency == "stream" else 0))


def test_peak_bytes_are_those_of_the_pages_that_were_there(tmp_path):
    """A pool far larger than what is loaded holds just that; the peak of a render that loads nothing is what is still there."""
    case = _Square(tmp_path)
    resident = _Statistics(Case(case.path), residency="resident")["geometry"]
    assert resident["peakBytes"] == resident["bytesTotal"] == resident["uploadedBytes"] > 0
    first = _Statistics(case, residency="stream", geometryMemory="8M")["geometry"]
    second = _Statistics(case, residency="stream", geometryMemory="8M")["geometry"]
    assert first["peakBytes"] == second["peakBytes"] == resident["bytesTotal"] < first["budget"]
    assert (first["uploadedBytes"], second["uploadedBytes"]) == (resident["bytesTotal"], 0)


def test_peak_bytes_of_what_leaves(tmp_path):
    """Squares of which the pool holds a few: it is never as full as all of them, and at least as full as it is at the end."""
    path = tmp_path / "many.usda"
    stage = author.NewStage(path)
    for i in range(64):
        author.AddMesh(stage, f"/World/Square{i}", shapes.Plane(0.11, 0.11, 8, 8), translate=(i % 8 / 8 - 0.44, 0, i // 8 / 16 - 0.22))
    _Finish(stage)
    total = _Statistics(Case(path), residency="resident")["geometry"]["bytesTotal"]
    small = _Statistics(Case(path), residency="stream", geometryMemory=str(total // 3))["geometry"]
    assert small["evictions"] > 0 and small["uploadedBytes"] > small["budget"]
    assert 0.5 * small["budget"] < small["peakBytes"] <= small["budget"] <= total // 3
    large = _Statistics(Case(path), residency="stream", geometryMemory=str(4 * total))["geometry"]
    assert large["evictions"] == 0 and large["peakBytes"] == large["uploadedBytes"] <= total


def test_peak_bytes_of_textures_are_those_of_lines_that_were_there(Textured):
    """In a pool that holds all of them: each line that was loaded once, and no more."""
    statistics = Textured.Fresh().Render(residency="stream", textureMemory="64M")[1]["texture"]
    assert statistics["evictions"] == 0
    assert statistics["peakBytes"] == statistics["uploadedBytes"] == statistics["uniqueBytesLoaded"] > 0


_HOST_PEAK = """
import json, pathlib, sys
import numpy as np
sys.path[:0] = json.loads(sys.argv[2])
from hdstream import _core
from hdstream.translate import TranslateStage
from pxr import Usd
def Most():
    lines = pathlib.Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:"))
def Peak():
    session.Render(options)
    before = Most()
    return [before, json.loads(session.Statistics())["memory"]["hostPeak"], Most()]
session = _core.Session()
TranslateStage(Usd.Stage.Open(sys.argv[1]), session, Usd.TimeCode.Default())
options = _core.Settings()
options.camera, options.imageWidth, options.imageHeight, options.samples, options.noCache = "/World/Camera", 16, 8, 1, True
first = Peak()
size = first[1] + (64 << 20)
held = np.ones(size, np.uint8)
del held
print(json.dumps([first, Peak(), size]))
"""


def test_the_peak_of_the_process_is_its_own(tmp_path):
    """By the kernel's account of this process alone: not of the one that started it, which is larger; and by an array that
    was there between two renders."""
    held = np.ones(1 << 30, np.uint8)  # what the process below would inherit
    case = _Square(tmp_path)
    done = subprocess.run([sys.executable, "-c", _HOST_PEAK, case.path, json.dumps(sys.path)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    first, second, size = json.loads(done.stdout.splitlines()[-1])
    assert first[0] <= first[1] <= first[2] < held.nbytes
    assert second[0] <= second[1] <= second[2]
    assert second[1] >= size > first[1], "memory that was given back counts still"


# --- Time --------------------------------------------------------------------------------------------


def test_transfer_is_of_what_is_moved(tmp_path):
    """To the device while a render runs, and of pictures that are fetched from it: none without either. What a render does one
    after the other takes no longer than all of it."""
    case = _Square(tmp_path)
    first = _Statistics(case, residency="stream")
    assert first["geometry"]["uploads"] > 0 < first["time"]["transfer"]
    second = _Statistics(case, residency="stream")
    assert second["geometry"]["uploads"] == 0 == second["time"]["transfer"]
    case.session.Layers()
    assert json.loads(case.session.Statistics())["time"]["transfer"] > 0
    for time in (first["time"], second["time"]):
        assert time["trace"] + time["shade"] + time["requests"] + time["transfer"] <= time["render"] <= time["total"]
