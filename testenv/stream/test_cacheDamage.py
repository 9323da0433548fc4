# SPDX-License-Identifier: Apache-2.0
"""Whatever happens to the folder of the persistent cache, the picture has the right bits, and what is not in the folder
is made again. The oracle is a picture rendered without a cache."""

import os
import pathlib
import shutil
import threading
import time

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from stages import streaming
from streamCase import RECORD_SECONDS, Case, ColdCache, FinishRecord, FullDisk, Segments, StartRecord

_BLOCK_BYTES = 1 << 16  # of a segment's index (docs/cache-format.md)
# So little memory that pages are read from the cache all the time.
_THRASH = dict(geometryMemory="40K", hostMemory=1 << 14, waveSize=1 << 11)


@pytest.fixture(scope="module")
def Scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("overlap") / "stage.usda"
    streaming.WriteOverlap(str(path), meshes=8, rings=16)
    return Case(path).RenderResident(noCache=True)


@pytest.fixture(scope="module")
def Filled(Scene, tmp_path_factory):
    """A cache folder with all pages of the scene; to be copied."""
    cache = ColdCache(tmp_path_factory.mktemp("filled") / "cache")
    Scene.Fresh().Render(residency="resident", cacheDirectory=cache)
    assert sum(segment.stat().st_size for segment in Segments(cache)) > Scene.statistics["geometry"]["bytesTotal"]
    return cache


@pytest.fixture
def Cache(Filled, tmp_path):
    return shutil.copytree(Filled, tmp_path / "cache")


def _Flip(cache, rng, begin, end, count=1):
    """Turns over the bits of random bytes of a segment's range."""
    [segment] = Segments(cache)
    content = bytearray(segment.read_bytes())
    for at in rng.integers(begin, end or len(content), count):
        content[at] ^= 0xFF
    segment.write_bytes(content)


def _NumBuilt(scene, cache, **settings):
    """Renders in a new session; checks the picture."""
    return scene.Fresh().AssertStreams(cacheDirectory=str(cache), **{"geometryMemory": "64M", **settings})["chunksBuilt"]


def test_the_cache_is_used(Scene, Cache):
    assert _NumBuilt(Scene, Cache) == 0


@pytest.mark.parametrize("name, begin, end, count", [
    ("header", 0, 64, 1), ("firstEntries", 64, 64 * 40, 3), ("index", 64, _BLOCK_BYTES, 300), ("page", _BLOCK_BYTES, None, 1),
    ("pages", _BLOCK_BYTES, None, 200), ("anywhere", 0, None, 2000)])
def test_flipped_bytes(Scene, Cache, name, begin, end, count):
    _Flip(Cache, np.random.default_rng(5), begin, end, count)
    touched = Scene.Fresh().AssertStreams(noCache=True, geometryMemory="64M")["chunksTouched"]
    damaged = _NumBuilt(Scene, Cache, prepare="eager")
    assert damaged <= Scene.statistics["geometry"]["chunks"]
    lazy = _NumBuilt(Scene, Cache)
    if name in ("header", "index", "pages", "anywhere"):
        assert damaged + lazy > 0
    assert lazy <= touched
    # What was found wrong has been made anew, and is found in the cache by the next one.
    assert _NumBuilt(Scene, Cache) == 0


@pytest.mark.parametrize("length", [0, 63, 64, 4096, _BLOCK_BYTES, 0.5, -1], ids=str)
def test_truncated(Scene, Cache, length):
    [segment] = Segments(Cache)
    size = segment.stat().st_size
    os.truncate(segment, int(size * length) if isinstance(length, float) else length if length >= 0 else size + length)
    built = _NumBuilt(Scene, Cache)
    assert built > 0 or length == -1  # the last byte may be padding, or of a chunk that no ray asks for
    assert _NumBuilt(Scene, Cache) == 0


@pytest.mark.parametrize("at", [0, 8], ids=["otherMagic", "otherVersion"])
def test_another_version(Scene, Cache, at):
    [segment] = Segments(Cache)
    content = bytearray(segment.read_bytes())
    content[at] += 1
    segment.write_bytes(content)
    assert _NumBuilt(Scene, Cache) > 0
    assert _NumBuilt(Scene, Cache) == 0


def test_files_that_are_no_segments(Scene, Cache):
    (Cache / "pages-0000000000000000.hdsp").write_bytes(b"not a segment")
    (Cache / "pages-0000000000000001.hdsp").mkdir()
    (Cache / "pages-0000000000000002.hdsp").symlink_to("/nowhere")
    assert _NumBuilt(Scene, Cache) == 0


@pytest.mark.parametrize("isThere", [False, True], ids=["deleted", "emptied"])
def test_vanished_between_renders_of_a_session(Scene, Cache, isThere):
    case = Scene.Fresh()
    case.AssertStreams(cacheDirectory=str(Cache), **_THRASH)
    shutil.rmtree(Cache)
    if isThere:
        Cache.mkdir()
    case.AssertStreams(cacheDirectory=str(Cache), **_THRASH)
    _NumBuilt(Scene, Cache)


class _Once:
    """A progress callback that does something at one report of a render that it does not end."""

    def __init__(self, function, at):
        self.function, self.left = function, at

    def __call__(self, progress):
        self.left -= 1
        if self.left == 0:
            self.function()
        return True


def _Delete(folder):
    """A folder that others write into may gain a file while it is emptied."""
    while folder.exists():
        shutil.rmtree(folder, ignore_errors=True)


@pytest.mark.parametrize("isWarm", [False, True], ids=["cold", "warm"])
@pytest.mark.parametrize("at", [2, 5])
def test_vanished_during_a_render(Scene, Cache, tmp_path, isWarm, at):
    cache = Cache if isWarm else pathlib.Path(ColdCache(tmp_path / "cold"))
    callback = _Once(lambda: _Delete(cache), at)
    Scene.Fresh().AssertStreams(callback, cacheDirectory=str(cache), **_THRASH)
    assert callback.left <= 0, "the folder was never deleted"


@pytest.mark.parametrize("seed", [1, 2])
def test_flipped_during_a_render(Scene, Cache, seed):
    """Pages that have been verified once are verified again when they are read again."""
    callback = _Once(lambda: _Flip(Cache, np.random.default_rng(seed), _BLOCK_BYTES, None, 3000), 3)
    geometry = Scene.Fresh().AssertStreams(callback, cacheDirectory=str(Cache), **_THRASH)
    assert callback.left <= 0 and geometry["chunksBuilt"] > 0


def test_truncated_during_a_render(Scene, Cache):
    callback = _Once(lambda: [os.truncate(segment, 1 << 17) for segment in Segments(Cache)], 3)
    geometry = Scene.Fresh().AssertStreams(callback, cacheDirectory=str(Cache), **_THRASH)
    assert callback.left <= 0 and geometry["chunksBuilt"] > 0


def test_a_folder_that_cannot_be(Scene, tmp_path):
    """A file is in its place: one warning, and a picture."""
    (tmp_path / "cache").write_text("a file")
    case = Scene.Fresh()
    case.AssertStreams(cacheDirectory=str(tmp_path / "cache"), **_THRASH)
    case.AssertStreams(cacheDirectory=str(tmp_path / "cache" / "below"), geometryMemory="64M")
    assert case.session.Warnings(), "nothing was said"
    assert (tmp_path / "cache").read_text() == "a file"


# --- Processes -----------------------------------------------------------------------------------


_LITTLE = ("--geometryMemory", "48K", "--hostMemory", "16K")


def _Record(scene, cache, folder, name):
    return StartRecord(scene, cache, folder, name, *_LITTLE)


def _Finish(process, folder, name):
    """(picture file's bytes, geometry's statistics)"""
    picture, statistics = FinishRecord(process, folder, name)
    return picture, statistics["geometry"]


@pytest.fixture(scope="module")
def Recorded(Scene, tmp_path_factory):
    """(the file that `hdstream record` writes, seconds until it is there)"""
    folder = tmp_path_factory.mktemp("recorded")
    start = time.monotonic()
    picture, _ = _Finish(_Record(Scene, ColdCache(folder / "cache"), folder, "alone"), folder, "alone")
    return picture, time.monotonic() - start


def test_a_disk_that_runs_full(Scene, tmp_path):
    """One warning, the right picture; what was saved by then is used by the next run."""
    settings = {**_THRASH, "waveSize": 64}
    Scene.Fresh().AssertStreams(**settings)  # compiles kernels
    cache, case = ColdCache(tmp_path / "cache"), Scene.Fresh()
    with FullDisk(cache, _BLOCK_BYTES, isEarly=True) as disk:  # the guide of the dome sees most of the scene before any sample
        geometry = case.AssertStreams(disk, cacheDirectory=str(cache), **settings)
    assert geometry["chunksBuilt"] > geometry["chunksTouched"], "pages are made again and again"
    assert len([line for line in case.session.Warnings() if "no more pages are kept" in line]) == 1, case.session.Warnings()
    [segment] = Segments(cache)
    assert _BLOCK_BYTES < segment.stat().st_size <= disk.limit
    second = Scene.Fresh().AssertStreams(cacheDirectory=str(cache), **_THRASH)
    assert 0 < second["chunksBuilt"] < geometry["chunksTouched"]
    assert sum(path.stat().st_size for path in Segments(cache)) > disk.limit


def test_two_processes_fill_one_cold_cache(Scene, Recorded, tmp_path):
    cache = ColdCache(tmp_path / "cache")
    processes = {name: _Record(Scene, cache, tmp_path, name) for name in "ab"}
    numBuilt = 0
    for name, process in processes.items():
        picture, geometry = _Finish(process, tmp_path, name)
        assert picture == Recorded[0]
        numBuilt += geometry["chunksBuilt"]
    assert numBuilt > 0
    picture, geometry = _Finish(_Record(Scene, cache, tmp_path, "c"), tmp_path, "c")
    assert picture == Recorded[0] and geometry["chunksBuilt"] == 0


def test_killed_at_random_moments(Scene, Recorded, tmp_path):
    """Each one finds what those before it left; the last ones are not killed."""
    cache = ColdCache(tmp_path / "cache")
    rng = np.random.default_rng(7)
    for turn in range(6):
        process = _Record(Scene, cache, tmp_path, f"killed{turn}")
        if turn < 2:  # once pages are written
            end = time.monotonic() + RECORD_SECONDS
            while process.poll() is None and not any(segment.stat().st_size > _BLOCK_BYTES for segment in Segments(cache)):
                assert time.monotonic() < end, "nothing is saved"
                time.sleep(0.001)
        else:
            time.sleep(rng.uniform(0.5, 1.0) * Recorded[1])
        process.kill()
        process.communicate(timeout=RECORD_SECONDS)
    picture, _ = _Finish(_Record(Scene, cache, tmp_path, "last"), tmp_path, "last")
    assert picture == Recorded[0]
    picture, geometry = _Finish(_Record(Scene, cache, tmp_path, "again"), tmp_path, "again")
    assert picture == Recorded[0] and geometry["chunksBuilt"] == 0


def test_cleared_during_renders(Scene, tmp_path):
    """`hdstream cache --clear` again and again."""
    cache, isDone = ColdCache(tmp_path / "cache"), threading.Event()

    def Clear():
        while not isDone.wait(0.03):
            Scene.core.ClearCache(cache)

    thread = threading.Thread(target=Clear)
    thread.start()
    try:
        for _ in range(2):
            Scene.Fresh().AssertStreams(cacheDirectory=cache, **_THRASH)
    finally:
        isDone.set()
        thread.join(RECORD_SECONDS)
    _NumBuilt(Scene, cache)
