# SPDX-License-Identifier: Apache-2.0
"""Large arrays are shared, not copied, and released on the main thread whichever thread drops them. Small ones are copied into a
few large allocations."""

import gc
import threading
import time
import weakref

import numpy as np
import pytest
from pxr import Vt

from hdstream import _core


def MakePrim(points):
    mesh = _core.GeometryDescription()
    mesh.points = points
    return _core.GeometryPrim(mesh, _core.Placement(np.eye(4)))


def AddressOf(array):
    return array.__array_interface__["data"][0]


def test_arrays_are_not_copied():
    points = np.zeros((400, 3), np.float32)
    mesh = _core.GeometryDescription()
    mesh.points = points
    assert AddressOf(mesh.points) == AddressOf(points)
    vt = Vt.Vec3fArray(500)
    mesh.points = vt
    assert AddressOf(mesh.points) == AddressOf(np.asarray(vt))
    session = _core.Session()
    session.SetGeometry("/M", _core.GeometryPrim(mesh, _core.Placement(np.eye(4))))
    assert AddressOf(session.Scene().geometry["/M"].geometry.points) == AddressOf(np.asarray(vt))


def test_returned_arrays_are_read_only():
    mesh = _core.GeometryDescription()
    mesh.points = np.zeros((1, 3), np.float32)
    assert not mesh.points.flags.writeable


@pytest.mark.parametrize("bad", [
    np.zeros((2, 3)), np.zeros((2, 3), np.int32), np.zeros((3, 4), np.float32)[:, :3], [[0, 0, 0]], None])
def test_other_arrays_are_refused(bad):
    with pytest.raises(TypeError):
        _core.GeometryDescription().points = bad


def test_incomplete_rows_are_refused():
    with pytest.raises(ValueError):
        _core.GeometryDescription().points = np.zeros(4, np.float32)


def MakeSmall(count, seed=0):
    """Points, counts and indices of so many meshes, all different but the counts."""
    rng = np.random.default_rng(seed)
    meshes = []
    for _ in range(count):
        mesh = _core.GeometryDescription()
        mesh.points = rng.random((20, 3), np.float32)
        mesh.faceVertexCounts = np.full(15, 4, np.int32)
        mesh.faceVertexIndices = rng.integers(0, 20, 60).astype(np.int32)
        meshes.append(mesh)
    return meshes


def test_small_arrays_are_values_of_their_own():
    """Whatever becomes of what they were copied from, and of others in their block; up to the largest and the smallest."""
    rng = np.random.default_rng(1)
    expected, meshes = [], []
    for size in [1, 2, 511, 512, 513, 16383, 16384, 16385, *rng.integers(1, 20_000, 100), *rng.integers(1, 4, 3000)]:
        values = rng.integers(0, 1 << 30, size).astype(np.int32)
        mesh = _core.GeometryDescription()
        mesh.faceVertexIndices = values
        expected.append(values.copy())
        values[:] = -1 if size <= 16384 else values
        meshes.append(mesh)
        if len(meshes) % 3 == 0:
            del meshes[0], expected[0]
    for mesh, values in zip(meshes, expected):
        assert np.array_equal(mesh.faceVertexIndices, values)


def test_small_arrays_take_few_allocations():
    """Of a thousand meshes: their bytes and some of the last block; equal arrays once."""
    before = _core.ArrayCounts()["poolBytes"]
    meshes = MakeSmall(5000)
    grown = _core.ArrayCounts()["poolBytes"] - before
    unique = 5000 * (240 + 240)
    assert unique - (1 << 20) <= grown <= 1.1 * unique + (2 << 20)
    assert len({AddressOf(mesh.faceVertexCounts) for mesh in meshes}) <= 5
    del meshes
    gc.collect()
    assert _core.ArrayCounts()["poolBytes"] <= before + (1 << 20), "blocks go with their last array"


def test_an_array_stays_when_others_of_its_block_go():
    meshes = MakeSmall(20_000, seed=2)
    kept = meshes[7777]
    points = np.array(kept.points)
    del meshes
    gc.collect()
    MakeSmall(20_000, seed=3)
    assert np.array_equal(kept.points, points)


class Tracked(np.ndarray):
    """An array that can be watched going away."""


@pytest.mark.parametrize("isOtherThread", [False, True])
def test_arrays_are_released(isOtherThread):
    """Session.Clear drops its arrays without the GIL, as worker threads of the core do."""
    points = np.zeros((1000, 3), np.float32).view(Tracked)
    alive = weakref.ref(points)
    session = _core.Session()
    session.SetGeometry("/M", MakePrim(points))
    del points
    gc.collect()
    assert alive() is not None
    if isOtherThread:
        thread = threading.Thread(target=session.Clear)
        thread.start()
        thread.join()
    else:
        session.Clear()
    deadline = time.monotonic() + 20  # only a lost release takes so long
    while alive() is not None and time.monotonic() < deadline:
        time.sleep(0.001)
    assert alive() is None and _core.NumBuffersToRelease() == 0


def test_many_arrays_dropped_at_once_are_all_released():
    """More than Python's own list of pending calls holds (32)."""
    session = _core.Session()
    alive = []
    for index in range(500):
        points = np.zeros((300, 3), np.float32).view(Tracked)
        alive.append(weakref.ref(points))
        session.SetGeometry(f"/M{index}", MakePrim(points))
    del points
    session.Clear()
    deadline = time.monotonic() + 20
    while any(ref() is not None for ref in alive) and time.monotonic() < deadline:
        time.sleep(0.001)
    assert all(ref() is None for ref in alive)


def test_warnings_reach_the_callback_from_any_thread():
    lines = []
    session = _core.Session(lines.append)
    threads = [threading.Thread(target=session.Warn, args=(f"/p{i % 4}", "text")) for i in range(32)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(lines) == [f"/p{i}: text" for i in range(4)] == session.Warnings()
