# SPDX-License-Identifier: Apache-2.0
"""Whatever happens to images and to the cache that textures are prepared into, the render ends with the right picture:
bits of resident textures, or the fallback and one warning. docs/testing.md lists the cases."""

import os
import pathlib
import shutil
import struct
import time

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

from pxr import Usd

from cardStrip import Strip
from stages import author, imageFile
from streamCase import RECORD_SECONDS, Case, ColdCache, FinishRecord, FullDisk, Segments, StartRecord
from textureCases import AddTexture, Connect

_BLOCK_BYTES = 1 << 16  # of a segment's index (docs/cache-format.md)
_LITTLE = dict(textureMemory="24K", waveSize=1 << 10)  # lines are read again all the time


def _Images(case) -> list:
    return sorted((pathlib.Path(case.path).parent / "images").iterdir())


def _Warned(case) -> list:
    """Gives the case a session that collects its warnings; the list."""
    from hdstream.translate import TranslateStage

    warnings = []
    case.session = case.core.Session(warnings.append)
    TranslateStage(Usd.Stage.Open(case.path), case.session, Usd.TimeCode.Default())
    return warnings


def _Bytes(cache) -> int:
    """Of all pages: it does not grow when nothing is prepared."""
    return sum(segment.stat().st_size for segment in Segments(cache))


# --- Images ------------------------------------------------------------------------------------------


def _Png(width, height, data=b"") -> bytes:
    """A file whose header claims a size; `data` stands for its texels."""
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", imageFile.zlib.crc32(kind + body))
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def _Exr(folder, window) -> bytes:
    """A small file whose data window says something else."""
    imageFile.WriteExr(folder / "good", dict.fromkeys("RGB", np.ones((4, 4), np.float32)))
    data = (folder / "good").read_bytes()
    return data.replace(struct.pack("<4i", 0, 0, 3, 3), struct.pack("<4i", *window), 1)


def _AbsurdImages(folder) -> dict:
    """Contents by file name; None is made by hand."""
    whole = imageFile.zlib.compress(bytes(61 * 20))
    return {
        "empty.png": b"", "text.png": b"this is no image", "zeros.png": bytes(4096), "signature.png": b"\x89PNG\r\n\x1a\n",
        "beyond.png": _Png(2**31 - 1, 2**31 - 1, whole), "huge.png": _Png(60000, 60000, whole), "nothing.png": _Png(0, 0, whole),
        "rowsMissing.png": _Png(20, 4000, whole), "noise.png": _Png(64, 64, bytes(range(256))),
        "chunkLength.png": _Png(64, 64, whole)[:33] + b"\xff\xff\xff\xffIDAT" + bytes(64),
        "beyond.exr": _Exr(folder, (0, 0, 2**31 - 2, 2**31 - 2)), "inverted.exr": _Exr(folder, (0, 0, -5, -5)),
        "header.exr": _Exr(folder, (0, 0, 3, 3))[:100], "start.jpg": b"\xff\xd8\xff", "offset.tif": b"II*\0\xff\xff\xff\x7f",
        "beyond.hdr": b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 999999999 +X 999999999\n\x02\x02", "folder.png": None, "pipe.png": None,
    }


def _Glow(name, fallback):
    return lambda card: Connect(card.material, "emissiveColor", AddTexture(
        card.material, "T", file=f"./{name}", fallback=(*fallback, 1.0)), "rgb")


def test_absurd_images(tmp_path):
    """Headers that claim too much, files that end too early, and what is no file: each shows its fallback, and is
    reported once. A pipe must not be waited for."""
    strip, fallbacks = Strip(tmp_path / "a.usda"), {}
    for i, (name, content) in enumerate(_AbsurdImages(tmp_path).items()):
        if content is not None:
            (tmp_path / name).write_bytes(content)
        fallbacks[name] = (0.25, i / 32, 0.5)
        strip.Add(name, _Glow(name, fallbacks[name]), diffuseColor=(0.0, 0.0, 0.0), metallic=1.0)
    (tmp_path / "folder.png").mkdir()
    os.mkfifo(tmp_path / "pipe.png")
    author.AddLight(strip.stage, "/World/Dark", "Sphere", dict(translate=(0, 50, 0)), intensity=0.0, radius=0.01)
    strip.Render(samples=2)
    for name, fallback in fallbacks.items():
        np.testing.assert_allclose(strip.Pixels(name)[:, :3], np.broadcast_to(fallback, (4, 3)), rtol=1e-6, err_msg=name)
        lines = [line for line in strip.picture.warnings if name in line]
        assert len(lines) == 1 and "\n" not in lines[0], (name, lines)
    assert len(strip.picture.warnings) == len(fallbacks)


def test_images_that_vanish_before_they_are_opened(Textured, tmp_path):
    """They were there when the scene was committed. The picture is the one of a stage that never had them."""
    case, bare = Textured.Copy(tmp_path), tmp_path / "bare"
    bare.mkdir()
    shutil.copy(case.path, bare)
    expected, _ = Case(bare / "stage.usda").Render(residency="stream")
    warnings, names = _Warned(case), [path.name for path in _Images(case)]

    def Vanish(progress):
        shutil.rmtree(pathlib.Path(case.path).parent / "images", ignore_errors=True)
        return True

    layers, _ = case.Render(Vanish, residency="stream", noCache=True)
    np.testing.assert_allclose(layers["color"], expected["color"], rtol=1e-5, atol=1e-6)
    assert len(warnings) == len(names) and all(sum(name in line for line in warnings) == 1 for name in names)


@pytest.mark.parametrize("noCache", [False, True])
def test_images_that_vanish_during_the_render(Textured, tmp_path, noCache):
    """What was opened stays as it was, also lines that come later."""
    case, gone = Textured.Copy(tmp_path), []
    warnings = _Warned(case)

    def Vanish(progress):
        if progress.samplesDone >= 1 and not gone:
            gone.extend(path.unlink() for path in _Images(case))
        return True

    case.AssertStreamsTextures(Vanish, noCache=noCache, cacheDirectory=ColdCache(tmp_path / "cache"), **_LITTLE)
    assert gone and not warnings


@pytest.mark.parametrize("offset", [0, -3600], ids=["equalTime", "olderTime"])
def test_an_image_edited_to_the_same_size_is_prepared_anew(Textured, tmp_path, offset):
    """Its time of modification is the same, or goes backwards."""
    case, cache = Textured.Copy(tmp_path), ColdCache(tmp_path / "cache")
    image, rng = _Images(case)[2], np.random.default_rng(3)
    pictures = []
    for _ in range(2):
        before = image.stat()
        imageFile.WritePng(image, rng.integers(0, 256, (64, 64, 3)).astype(np.uint8), level=0)
        if pictures:
            assert image.stat().st_size == before.st_size
            os.utime(image, (before.st_atime + offset, before.st_mtime + offset))
        warm, _ = Case(case.path).Render(residency="stream", cacheDirectory=cache)
        bare, _ = Case(case.path).Render(residency="stream", noCache=True)
        assert warm["color"].tobytes() == bare["color"].tobytes()
        pictures.append(warm["color"].tobytes())
    assert pictures[0] != pictures[1]


def test_paths_with_spaces_and_other_letters(Textured, tmp_path):
    folder = tmp_path / "Ein Fußboden 画"
    folder.mkdir()
    text = pathlib.Path(Textured.path).read_text(encoding="utf-8")
    (folder / "Bühne.usda").write_text(text.replace("./images/", "./Bilder ü 画/"), encoding="utf-8")
    shutil.copytree(pathlib.Path(Textured.path).parent / "images", folder / "Bilder ü 画")
    case, cache = Case(folder / "Bühne.usda"), ColdCache(folder / "der Cache é")
    case.layers, case.statistics = Textured.layers, Textured.statistics
    case.AssertStreamsTextures(cacheDirectory=cache)
    size = _Bytes(cache)
    assert size > _BLOCK_BYTES
    case.Fresh().AssertStreamsTextures(cacheDirectory=cache)
    assert _Bytes(cache) == size


# --- The cache ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def Filled(Textured, tmp_path_factory):
    """A cache folder with all that a render takes; to be copied."""
    cache = ColdCache(tmp_path_factory.mktemp("filled") / "cache")
    Textured.Fresh().AssertStreamsTextures(cacheDirectory=cache)
    return cache


def _CopyOf(cache, folder) -> pathlib.Path:
    copy = pathlib.Path(ColdCache(folder / "cache"))
    for segment in Segments(cache):
        shutil.copy(segment, copy)
    return copy


def _Spoil(cache, how) -> None:
    """Does something to the only segment of a cache."""
    [segment] = Segments(cache)
    content = bytearray(segment.read_bytes())
    if how == "otherVersion":
        content[8] += 1
    elif how == "pages":
        rng = np.random.default_rng(5)
        for at in rng.integers(_BLOCK_BYTES, len(content), 400):
            content[at] ^= 0xFF
    elif how == "index":
        content[64:_BLOCK_BYTES:331] = bytes(len(content[64:_BLOCK_BYTES:331]))
    else:
        os.truncate(segment, int(len(content) * how))
        return
    segment.write_bytes(content)


@pytest.mark.parametrize("how", ["otherVersion", "pages", "index", 0.0, 0.3, 0.9], ids=str)
def test_damaged_between_renders(Textured, Filled, tmp_path, how):
    """What is damaged is prepared again, and then it is there. (A chunk whose two pages are damaged takes two runs.)"""
    cache = _CopyOf(Filled, tmp_path)
    _Spoil(cache, how)
    for _ in range(3):
        before = _Bytes(cache)
        Textured.Fresh().AssertStreamsTextures(cacheDirectory=str(cache), **_LITTLE)
    assert _Bytes(cache) == before


@pytest.mark.parametrize("how", [0.0, 0.3, 0.9], ids=str)
def test_cut_during_a_render(Textured, Filled, tmp_path, how):
    """Lines that were verified before are read of a file that has ended meanwhile."""
    cache, done = _CopyOf(Filled, tmp_path), []

    def Cut(progress):
        if progress.samplesDone >= 1 and not done:
            done.append(_Spoil(cache, how))
        return True

    Textured.Fresh().AssertStreamsTextures(Cut, cacheDirectory=str(cache), **_LITTLE)
    assert done
    Textured.Fresh().AssertStreamsTextures(cacheDirectory=str(cache), **_LITTLE)


@pytest.mark.parametrize("isWarm", [False, True], ids=["cold", "warm"])
def test_vanished_during_a_render(Textured, Filled, tmp_path, isWarm):
    cache = _CopyOf(Filled, tmp_path) if isWarm else pathlib.Path(ColdCache(tmp_path / "cache"))
    reports = []

    def Vanish(progress):
        reports.append(progress.samplesDone)
        if len(reports) in (2, 5):  # in the middle of the first sample, and later
            shutil.rmtree(cache, ignore_errors=True)
        return True

    Textured.Fresh().AssertStreamsTextures(Vanish, cacheDirectory=str(cache), **_LITTLE)
    assert len(reports) >= 5


def test_a_folder_that_cannot_be(Textured, tmp_path):
    """A file is in its place: textures are kept in memory."""
    (tmp_path / "cache").write_text("a file")
    case = Textured.Fresh()
    case.AssertStreamsTextures(cacheDirectory=str(tmp_path / "cache"), **_LITTLE)
    assert case.session.Warnings() and (tmp_path / "cache").read_text() == "a file"


@pytest.mark.parametrize("room", [0, _BLOCK_BYTES // 2, 3 * _BLOCK_BYTES])
def test_a_disk_that_runs_full(Textured, tmp_path, room):
    """Files cannot grow by more than `room` once the first texels have been seen, which ends between two groups of lines
    or in one: one warning, what is saved stays, and a run with room finishes it."""
    cache, case = ColdCache(tmp_path / "cache"), Textured.Fresh()
    with FullDisk(cache, room) as disk:
        # Without the guide of the dome, which sees most texels before any sample.
        case.AssertStreamsTextures(disk, cacheDirectory=cache, textureMemory="24K", waveSize=64, interactive=True)
    assert len(case.session.Warnings()) == 1 and "no more pages are kept" in case.session.Warnings()[0]
    assert _Bytes(cache) <= disk.limit
    for _ in range(2):
        before = _Bytes(cache)
        case = Textured.Fresh()
        case.AssertStreamsTextures(cacheDirectory=cache, **_LITTLE)
        assert not case.session.Warnings()
    assert before == _Bytes(cache) > disk.limit


# --- Processes -----------------------------------------------------------------------------------


def _Start(case, cache, folder, name):
    return StartRecord(case, cache, folder, name, "--textureMemory", "24K")


@pytest.fixture(scope="module")
def Recorded(Textured, tmp_path_factory):
    """(the file that `hdstream record` writes, seconds until it is there)"""
    folder = tmp_path_factory.mktemp("recorded")
    start = time.monotonic()
    picture, _ = FinishRecord(_Start(Textured, ColdCache(folder / "cache"), folder, "alone"), folder, "alone")
    return picture, time.monotonic() - start


def _AssertFilled(case, recorded, cache, folder):
    """A run makes nothing any more."""
    before = _Bytes(cache)
    picture, statistics = FinishRecord(_Start(case, cache, folder, "again"), folder, "again")
    assert picture == recorded[0] and statistics["texture"]["fallbackTexels"] == 0
    assert _Bytes(cache) == before > _BLOCK_BYTES


def test_two_processes_prepare_the_same_textures(Textured, Recorded, tmp_path):
    cache = ColdCache(tmp_path / "cache")
    processes = {name: _Start(Textured, cache, tmp_path, name) for name in "ab"}
    for name, process in processes.items():
        assert FinishRecord(process, tmp_path, name)[0] == Recorded[0]
    _AssertFilled(Textured, Recorded, cache, tmp_path)


def test_killed_while_textures_are_prepared(Textured, Recorded, tmp_path):
    """Each one finds what those before it left."""
    cache, rng = ColdCache(tmp_path / "cache"), np.random.default_rng(9)
    for turn in range(3):
        process, before = _Start(Textured, cache, tmp_path, f"killed{turn}"), _Bytes(cache)
        end = time.monotonic() + RECORD_SECONDS
        # Once pages are written, and a little later.
        while process.poll() is None and _Bytes(cache) <= max(before, _BLOCK_BYTES) + turn * 4096:
            assert time.monotonic() < end, "nothing is saved"
            time.sleep(0.001)
        time.sleep(rng.uniform(0.0, 0.02) * Recorded[1])
        process.kill()
        process.communicate(timeout=RECORD_SECONDS)
    assert FinishRecord(_Start(Textured, cache, tmp_path, "last"), tmp_path, "last")[0] == Recorded[0]
    _AssertFilled(Textured, Recorded, cache, tmp_path)
