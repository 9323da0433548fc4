# SPDX-License-Identifier: Apache-2.0
"""Large arrays are read again from the stage instead of kept: with the bits of kept ones, and with one line where that cannot be.

Here every array counts as large, and so little may stay in host memory that each page is built of arrays that are read for it.
"""

import gc
import json
import os
import signal
import subprocess
import sys
import time
import weakref

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import Usd, UsdGeom

from hdstream import _core
from hdstream.translate import meshes, rereading
from stages import streaming
from streamCase import RECORD_SECONDS, Case, ColdCache

_POOLS = ("100%", "79%", "50%", "30%", "15%", "5%", "2%")
_LITTLE = 1 << 14  # bytes of host memory: of sources only the one used last stays
# Pages are built again and again, each of arrays that are read for it.
_READ_AGAIN = dict(residency="stream", geometryMemory="40K", noCache=True, hostMemory=_LITTLE, waveSize=1 << 10)


@pytest.fixture
def allArrays(monkeypatch):
    monkeypatch.setattr(rereading, "SMALLEST", 0)


def _Away(scene):
    """The stage of a case in a session that keeps none of its arrays, to be compared with the case's picture."""
    before = _core.ArrayCounts()["bytes"]
    case = scene.Fresh()
    assert _core.ArrayCounts()["bytes"] > before
    return case


@pytest.mark.parametrize("eviction", ["lru", "flush"])
def test_any_pool_gives_the_bits_of_kept_arrays(Scene, allArrays, eviction):
    case = _Away(Scene)
    numRead = 0
    for pool in _POOLS:
        layers, statistics = case.Render(residency="stream", geometryMemory=pool, geometryEviction=eviction, noCache=True,
                                         hostMemory=_LITTLE)
        case.AssertBits(layers)
        memory = statistics["memory"]
        assert memory["arrays"] > 0 and memory["sourcesPeak"] > 0
        numRead += memory["arraysReadAgain"]
    assert numRead > 0


@pytest.mark.parametrize("settings", [dict(residency="resident"), dict(residency="auto", prepare="eager")], ids=str)
def test_other_ways_give_the_bits_of_kept_arrays(Scene, allArrays, settings):
    layers, _ = _Away(Scene).Render(noCache=True, hostMemory=_LITTLE, **settings)
    Scene.AssertBits(layers)


def test_a_cache_cold_and_warm(Scene, allArrays, tmp_path):
    """Warm, nothing is read but for the key of the pages: as the stage is translated."""
    cache = ColdCache(tmp_path / "cache")
    counts = []
    for _ in range(2):
        layers, statistics = _Away(Scene).Render(residency="stream", geometryMemory="30%", prepare="eager", cacheDirectory=cache,
                                                 hostMemory=_LITTLE)
        Scene.AssertBits(layers)
        counts.append((statistics["geometry"]["chunksBuilt"], statistics["memory"]["arraysReadAgain"]))
    assert counts[0][0] > 0 and counts[1] == (0, 0) or Scene.statistics["geometry"]["chunks"] > 1000
    if counts[1] != (0, 0):  # meshes of few triangles have no summary in the cache
        assert counts[1][1] <= counts[0][1]


def test_what_fits_is_read_once(Scene, allArrays):
    """With the default of host memory nothing is read a second time."""
    layers, statistics = _Away(Scene).Render(residency="stream", geometryMemory="10%", noCache=True)
    Scene.AssertBits(layers)
    assert statistics["memory"]["arraysReadAgain"] == 0


def test_what_is_read_again_and_again_makes_pages_ahead(allArrays, tmp_path):
    """With a cache nothing that pages are cut from is made more than five times, and without one for nearly each chunk."""
    numMeshes = 6
    streaming.WriteOverlap(str(tmp_path / "stage.usda"), meshes=numMeshes, rings=48)
    expected = Case(tmp_path / "stage.usda").RenderResident(noCache=True)
    settings = {name: value for name, value in _READ_AGAIN.items() if name != "noCache"}
    without = expected.Fresh().Render(noCache=True, **settings)[1]
    layers, cold = expected.Fresh().Render(cacheDirectory=ColdCache(tmp_path / "cache"), **settings)
    expected.AssertBits(layers)
    prims = cold["geometry"]["meshes"]
    assert cold["geometry"]["chunks"] > 30 * numMeshes
    assert 0 < cold["geometry"]["chunksAhead"] <= cold["geometry"]["chunks"]
    assert cold["memory"]["sourcesMade"] <= 5 * prims < without["memory"]["sourcesMade"]
    assert without["geometry"]["chunksAhead"] == 0
    layers, warm = expected.Fresh().Render(cacheDirectory=str(tmp_path / "cache"), **settings)
    expected.AssertBits(layers)
    assert warm["memory"]["sourcesMade"] <= warm["geometry"]["chunksBuilt"] <= prims, "single chunks have no summary"


def test_arrays_leave_memory(allArrays, monkeypatch, tmp_path):
    """Those of numpy are gone once pages have been planned, and arrays that nobody holds any more do not wait for their use."""
    alive = []

    def Watch(function):
        def Watched(*arguments):
            array = np.array(function(*arguments))
            alive.append(weakref.ref(array))
            return array
        return Watched

    for name in ("ReadArray", "ReadPoints", "_ReadInts", "_ReadPointArray"):
        monkeypatch.setattr(meshes, name, Watch(getattr(meshes, name)))
    streaming.WriteOverlap(str(tmp_path / "stage.usda"), meshes=6, rings=16)
    case = Case(tmp_path / "stage.usda")
    gc.collect()
    assert len(alive) >= 3 * 7 and all(array() is not None for array in alive)
    kept = _core.ArrayCounts()["keptBytes"]
    case.Render(noCache=True, hostMemory=_LITTLE, residency="resident")
    deadline = time.monotonic() + 20
    while sum(array() is not None for array in alive) > 3 and time.monotonic() < deadline:
        time.sleep(0.001)
    assert sum(array() is not None for array in alive) <= 3, "of the source that was used last"
    assert _core.ArrayCounts()["keptBytes"] < kept
    case.session.Clear()


@pytest.mark.parametrize("smallest", [0, 5000, 1 << 62])
def test_statistics_count_arrays_to_the_byte(monkeypatch, tmp_path, smallest):
    """Against the arrays as Python has them: those that are kept and those that are read again."""
    monkeypatch.setattr(rereading, "SMALLEST", smallest)
    streaming.WriteNested(str(tmp_path / "stage.usda"), depth=2, copies=5, rings=12)
    before = _core.ArrayCounts()["bytes"]
    case = Case(tmp_path / "stage.usda")
    _, statistics = case.Render(noCache=True)
    kept = away = instances = 0
    for prim in case.session.Scene().geometry.values():
        mesh = prim.geometry
        arrays = [mesh.points, mesh.faceVertexCounts, mesh.faceVertexIndices, mesh.holeIndices]
        for primvar in mesh.primvars:
            if primvar.interpolation == _core.Interpolation.Constant:
                kept += primvar.values.nbytes
            else:
                arrays.append(primvar.values)
            arrays.append(primvar.indices)
        for array in arrays:
            isAway = 0 < array.nbytes >= smallest
            away += array.nbytes * isAway
            kept += array.nbytes * (not isAway)
        instances += prim.placement.instances.nbytes
    for instancer in case.session.Scene().instancers.values():
        instances += 5 * (12 + 12) + instancer.placement.instances.nbytes  # positions and scales
    memory = statistics["memory"]
    assert (away > 0) == (smallest == 0 or smallest == 5000)
    assert memory["arraysKept"] == kept and memory["instanceArraysKept"] == instances
    assert memory["arrays"] - before == away


def test_edits_read_what_is_there_then(allArrays, tmp_path):
    """An edited stage is drawn as it is, not as it was, and its other prims are found again."""
    from hdstream import Renderer

    streaming.WriteOverlap(str(tmp_path / "stage.usda"), meshes=6, rings=16)
    stage = Usd.Stage.Open(str(tmp_path / "stage.usda"))
    options = dict(_READ_AGAIN, camera="/World/Camera", imageWidth=48, imageHeight=32, samples=2)
    renderer = Renderer(stage)
    renderer.Render(**options)
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Ball1")).GetPointsAttr()
    points.Set([1.1 * point for point in points.Get()])
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath("/World/Ball2")).SetTranslate((0.2, 0.1, 0.0))
    edited = renderer.Render(**options)
    fresh = Renderer(stage).Render(**options)
    for name, pixels in fresh.aovs.items():
        assert edited.aovs[name].tobytes() == pixels.tobytes(), name


# --- What cannot be read again ------------------------------------------------------------------------------------------


class _Big:
    """A crate file with meshes of arrays that are mapped, rendered so that they are read again and again."""

    def __init__(self, folder):
        text = folder / "text.usda"
        streaming.WriteOverlap(str(text), meshes=8, rings=32)
        self.path = folder / "stage.usdc"
        Usd.Stage.Open(str(text)).Export(str(self.path))
        stage = Usd.Stage.Open(str(self.path))
        points = stage.GetPrimAtPath("/World/Ball0").GetAttribute("points").Get()
        self._points = np.asarray(points).tobytes()

    def Render(self, onProgress=None):
        case = Case(self.path)
        return case.Start(onProgress, **_READ_AGAIN)

    def Change(self, isHidden=False):
        """Moves points of a mesh in the file itself; hidden: the file has its time of before."""
        before = os.stat(self.path)
        content = self.path.read_bytes()
        at = content.index(self._points)
        with open(self.path, "r+b") as file:
            file.seek(at + 12 * 100)
            file.write(np.float32([0.5, 0.5, 0.5]).tobytes())
        if isHidden:
            os.utime(self.path, ns=(before.st_atime_ns, before.st_mtime_ns))
        else:
            os.utime(self.path, ns=(before.st_atime_ns, before.st_mtime_ns + 1))


class _Once:
    """onProgress that does something when the first samples are there."""

    def __init__(self, action):
        self._action, self.isDone = action, False

    def __call__(self, progress):
        if progress.fraction > 0 and not self.isDone:
            self._action()
            self.isDone = True
        return True


@pytest.fixture
def Big(tmp_path, allArrays):
    return _Big(tmp_path)


@pytest.mark.parametrize("isReplaced", [False, True], ids=["deleted", "replaced"])
def test_a_file_that_is_deleted_or_replaced_stays_what_it_was(Big, tmp_path, isReplaced):
    case = Case(Big.path).RenderResident(noCache=True).Fresh()
    other = tmp_path / "other.usdc"
    other.write_bytes(b"no stage at all" * 1000)
    once = _Once((lambda: os.replace(other, Big.path)) if isReplaced else Big.path.unlink)
    layers, statistics = case.Render(once, **_READ_AGAIN)
    assert once.isDone and statistics["memory"]["arraysReadAgain"] > 0
    case.AssertBits(layers)


def test_a_file_that_is_written_into_is_one_line(Big):
    once = _Once(Big.Change)
    with pytest.raises(_core.Error) as error:
        Big.Render(once)
    assert once.isDone
    line = str(error.value)
    assert line.startswith("/World/") and line.endswith(f": cannot be read again: {Big.path} has been written into"), line
    assert "\n" not in line


def test_values_that_differ_are_one_line(Big):
    """Even where the file does not show it."""
    with pytest.raises(_core.Error) as error:
        Big.Render(_Once(lambda: Big.Change(isHidden=True)))
    assert str(error.value) == "/World/Ball0.points: has changed since the stage was translated"


def test_a_file_that_is_written_into_under_held_arrays_is_one_line(Big, tmp_path):
    """Also where nothing is read again: pages are made of arrays that are mapped from the file. None of them stays in the
    cache, which serves the next run."""
    content, before = Big.path.read_bytes(), os.stat(Big.path)
    settings = dict(residency="stream", geometryMemory="40K", waveSize=64, cacheDirectory=ColdCache(tmp_path / "cache"))
    once = _Once(Big.Change)
    with pytest.raises(_core.Error) as error:
        Case(Big.path).Start(once, **settings)
    assert once.isDone
    line = str(error.value)
    assert line.startswith("/World/Ball") and line.endswith(f": cannot be read again: {Big.path} has been written into"), line
    with open(Big.path, "r+b") as file:
        file.write(content)
    os.utime(Big.path, ns=(before.st_atime_ns, before.st_mtime_ns))
    layers, statistics = Case(Big.path).Render(**settings)
    geometry = statistics["geometry"]
    assert 0 < geometry["chunksBuilt"] < geometry["chunksTouched"], "the cache has pages of the run before"
    Case(Big.path).RenderResident(noCache=True).AssertBits(layers)


def test_the_session_renders_again_after_the_error(Big):
    case = Case(Big.path)
    content, before = Big.path.read_bytes(), os.stat(Big.path)
    with pytest.raises(_core.Error, match="has changed since"):
        case.Start(_Once(lambda: Big.Change(isHidden=True)), **_READ_AGAIN)
    with open(Big.path, "r+b") as file:
        file.write(content)
    os.utime(Big.path, ns=(before.st_atime_ns, before.st_mtime_ns))
    layers, _ = case.Render(**_READ_AGAIN)
    Case(Big.path).RenderResident(noCache=True).AssertBits(layers)


def test_the_command_ends_with_one_line(Big, tmp_path):
    """Exit code 1; no traceback and no picture. The file is written into when an array is read again for the first time."""
    script = f"""
import sys
from hdstream import cli
from hdstream.translate import meshes, rereading

rereading.SMALLEST = 0
isDone = False
call = rereading._Reader.__call__

def Changed(self):
    global isDone
    if not isDone:
        isDone = True
        with open({str(Big.path)!r}, "r+b") as file:
            file.seek(0)
            file.write(file.read(1) and b"P")
    return call(self)

rereading._Reader.__call__ = Changed
sys.exit(cli.Main(sys.argv[1:]))
"""
    command = [sys.executable, "-c", script, "record", str(Big.path), str(tmp_path / "out.exr"), "--quiet", "--camera",
               "/World/Camera", "--imageWidth", "64", "--samples", "2", "--chunkSize", "4096", "--residency", "stream",
               "--geometryMemory", "40K", "--hostMemory", "16K", "--noCache"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=RECORD_SECONDS)
    assert done.returncode == 1, done.stdout + done.stderr
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1 and lines[0].endswith("has been written into") and "/World/" in lines[0], done.stderr
    assert not (tmp_path / "out.exr").exists()


def _Session(read, points):
    """A session with a mesh whose points are read again by a function."""
    mesh = _core.GeometryDescription()
    mesh.points = _core.StageArray("/M.points", points, read)
    mesh.faceVertexCounts = np.int32([3])
    mesh.faceVertexIndices = np.int32([0, 1, 2])
    session = _core.Session()
    session.SetGeometry("/M", _core.GeometryPrim(mesh, _core.Placement(np.eye(4))))
    return session


_TRIANGLE = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize("read, text", [
    (lambda: 1 / 0, "cannot be read again: division by zero"), (lambda: None, "cannot be read again: array: expected"),
    (lambda: np.zeros((3, 3)), "cannot be read again: array: expected"), (lambda: _TRIANGLE[:2].copy(), "has changed since"),
    (lambda: _TRIANGLE + np.float32(1e-7), "has changed since")], ids=["raises", "nothing", "type", "size", "values"])
def test_what_python_does_wrong_is_one_line(read, text):
    session = _Session(read, _TRIANGLE.copy())
    session.Info()  # plans, and drops the arrays
    gc.collect()
    with pytest.raises(_core.Error) as error:
        session.Info()
    assert str(error.value).startswith(f"/M.points: {text}") and "\n" not in str(error.value)


def test_an_interruption_while_an_array_is_read_waits():
    """It is Python's to raise, when the core has returned. Shells start what runs in the background with the signal ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        _RaiseWhileReading()
    finally:
        signal.signal(signal.SIGINT, before)


def _RaiseWhileReading():
    isInterrupted = []

    def Read():
        if not isInterrupted:
            isInterrupted.append(True)
            raise KeyboardInterrupt
        return _TRIANGLE.copy()

    session = _Session(Read, _TRIANGLE.copy())
    session.Info()
    gc.collect()
    with pytest.raises(KeyboardInterrupt):
        info = json.loads(session.Info())
        assert info["triangles"] == 1
        time.sleep(1)
    assert isInterrupted


def test_arrays_of_other_types_are_refused():
    for values in (np.zeros((2, 3)), np.zeros((3, 4), np.float32)[:, :3], [[0, 0, 0]]):
        with pytest.raises(TypeError):
            _core.StageArray("/M.points", values, lambda: values)
    mesh = _core.GeometryDescription()
    with pytest.raises(TypeError):
        mesh.points = _core.StageArray("/M.points", np.zeros(3, np.int32), lambda: None)
    with pytest.raises(ValueError):
        mesh.points = _core.StageArray("/M.points", np.zeros(4, np.float32), lambda: None)
