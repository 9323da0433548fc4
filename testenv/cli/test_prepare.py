# SPDX-License-Identifier: Apache-2.0
"""`hdstream prepare`: a render of the same words after it makes nothing and has the same bits; `hdstream cache` says whose pages
there are."""

import json
import os
import pathlib
import re
import signal
import subprocess
import time

import numpy as np
import pytest

from hdstream import _core
from stages import author, crowd, imageFile, shapes, subdivided, textured

from cliCase import SECONDS, AssertFails, Command, Result, Run, WriteStage
from test_interruption import DefaultInterrupt

_RECORD = ("--imageWidth", 32, "--samples", 2, "--maxDepth", 2, "--quiet")


def _Cache(folder) -> pathlib.Path:
    """Without pages, with the kernels that there are."""
    folder.mkdir()
    for kernel in pathlib.Path(_core.InspectCache("").directory).glob("kernel-*.hdsc"):
        os.symlink(kernel, folder / kernel.name)
    return folder


def _Amount(cache) -> tuple:
    """(pages, their bytes)"""
    state = _core.InspectCache(str(cache))
    # Of tests here each cache has pages of one stage at most.
    return (state.stages[0].pages if state.stages else 0) + state.otherPages, sum(s.bytes for s in state.stages) + state.otherBytes


def _Record(cache, stage, picture, *options):
    """Geometry's statistics."""
    stats = picture.with_suffix(".json")
    result = Run("record", stage, picture, *_RECORD, "--cacheDir", cache, "--stats", stats, *options)
    assert result.code == 0, result.text
    return json.loads(stats.read_text())["geometry"]


def _Textured(path):
    """With an image of which no render makes the finest mip before it reads it."""
    textured.WriteTextured(path)
    rng = np.random.default_rng(3)
    imageFile.WritePng(path.parent / "images" / "photo1.png", rng.integers(0, 256, (2048, 2048, 1)).astype(np.uint8).repeat(3, 2))


_STAGES = {
    "textures": (_Textured, ()),
    "instance chunks": (lambda path: crowd.WriteCrowd(str(path)), ("--instanceChunks", 1, "--chunkSize", 4096)),
    "a primvar shown": (lambda path: crowd.WriteCrowd(str(path)), ("--aovs", "color,primvars:displayColor")),
    "diced": (lambda path: subdivided.WriteSubdivided(str(path)), ("--imageWidth", 77)),
}


@pytest.mark.parametrize("write, options", _STAGES.values(), ids=_STAGES)
def test_a_render_after_it_makes_nothing(tmp_path, write, options):
    stage, cache = tmp_path / "stage.usda", _Cache(tmp_path / "cache")
    write(stage)
    first = Run("prepare", stage, "--cacheDir", cache, *options)
    assert first.code == 0 and not first.errors, first.text
    chunks, made = map(int, re.search(r": (\d+) chunks of .*?, (\d+) made", first.out).groups())
    assert 0 < made <= chunks, first.text  # equal chunks are made once
    pages = _Amount(cache)
    for number, more in enumerate((("--residency", "stream", "--geometryMemory", "50%"), ("--residency", "resident"))):
        geometry = _Record(cache, stage, tmp_path / f"after{number}.exr", *options, *more)
        assert geometry["chunksBuilt"] == 0 and geometry["chunksFromCache"] > 0
        assert _Amount(cache) == pages
    assert chunks <= geometry["chunks"] <= 2 * chunks  # those of instances are kept nowhere
    again = Run("prepare", stage, "--cacheDir", cache, *options)
    assert f"{chunks} chunks" in again.out and ", 0 made" in again.out, again.text
    assert _Amount(cache) == pages
    _Record(cache, stage, tmp_path / "alone.exr", *options, "--noCache", "--residency", "resident")
    for layer in _core.CompareImages(str(tmp_path / "after0.exr"), str(tmp_path / "alone.exr")).layers:
        assert layer.maxAbs == 0.0, layer.name


def test_it_completes_what_a_render_has_left(tmp_path):
    """Lines of fine mips that a render did not need, and chunks that it did not see."""
    stage, cache = tmp_path / "stage.usda", _Cache(tmp_path / "cache")
    _Textured(stage)
    _Record(cache, stage, tmp_path / "before.exr", "--residency", "stream")
    before = _Amount(cache)
    assert Run("prepare", stage, "--cacheDir", cache).code == 0
    after = _Amount(cache)
    assert after[0] > before[0]
    other = _Cache(tmp_path / "other")
    assert Run("prepare", stage, "--cacheDir", other).code == 0
    assert _Amount(other) == after


def _ProductsStage(path):
    """Two products of a surface that is diced for each camera, at two times."""
    subdivided.WriteSubdivided(str(path))
    from pxr import Usd
    stage = Usd.Stage.Open(str(path))
    author.AddCamera(stage, "/World/Near", eye=(0, 1.4, 2.2), target=(0, 0.6, -1.2), aspect=16 / 9)
    stage.GetRootLayer().Save()
    with open(path, "a", encoding="utf-8") as file:
        file.write("""
def Scope "Render" {
    def RenderSettings "Settings" {
        rel products = [</Render/Far>, </Render/Near>]
        uniform int2 resolution = (48, 27)
    }
    def RenderProduct "Far" { token productName = "far.####.exr"
        rel camera = </World/Camera>
    }
    def RenderProduct "Near" { token productName = "near.####.exr"
        rel camera = </World/Near>
    }
}
""".replace('{ token', '{\n token'))
    return ("-rs", "/Render/Settings", "--frames", "1:2")


def test_all_products_and_frames(tmp_path):
    stage, cache = tmp_path / "stage.usda", _Cache(tmp_path / "cache")
    words = _ProductsStage(stage)
    result = Run("prepare", stage, *words, "--cacheDir", cache)
    assert result.code == 0 and len(result.out.splitlines()) == 4, result.text
    assert " at 2: " in result.out
    pages = _Amount(cache)
    done = Run("record", stage, *words, "--samples", 1, "--quiet", "--cacheDir", cache, cwd=tmp_path)
    assert done.code == 0 and (tmp_path / "near.0002.exr").exists(), done.text
    assert _Amount(cache) == pages
    # Of one camera there would be less.
    alone = _Cache(tmp_path / "alone")
    assert Run("prepare", stage, "OUT.exr", "--camera", "/World/Near", "--imageWidth", 48, "--cacheDir", alone).code == 0
    assert 0 < _Amount(alone)[0] < pages[0] and not (tmp_path / "OUT.exr").exists()


def test_the_cache_by_stage(tmp_path):
    cache = _Cache(tmp_path / "cache")
    stages = [WriteStage(tmp_path, name=name) for name in ("one.usda", "two.usda")]
    other = tmp_path / "other.usda"
    crowd.WriteCrowd(str(other))
    for stage in (*stages, other):
        assert Run("prepare", stage, "--quiet", "--cacheDir", cache).code == 0
    state = _core.InspectCache(str(cache))
    one, more, two = state.stages  # by name
    assert [os.path.basename(stage.file) for stage in state.stages] == ["one.usda", "other.usda", "two.usda"]
    assert one.pages == two.pages > 0 and one.bytes == two.bytes > 0  # they have the same triangle
    assert more.pages > one.pages and state.otherPages == 0
    shown = Run("cache", "--cacheDir", cache)
    lines = shown.out.splitlines()
    assert shown.code == 0 and len(lines) == 4 and lines[0].startswith(f"{cache}: "), shown.text
    assert lines[1].endswith(f"{one.pages} pages  {stages[0]}"), shown.text
    for note in cache.glob("stage-*.hdsc"):  # as of hosts, which name no stage
        note.unlink()
    state = _core.InspectCache(str(cache))
    assert not state.stages and state.otherPages == one.pages + more.pages
    assert "of no stage that is known" in Run("cache", "--cacheDir", cache).out
    assert Run("record", stages[1], tmp_path / "o.exr", *_RECORD, "--cacheDir", cache).code == 0
    two, = _core.InspectCache(str(cache)).stages  # a render notes what it uses
    assert two.file == str(stages[1]) and 0 < two.pages <= one.pages


def test_what_cannot_be_prepared(tmp_path):
    stage = WriteStage(tmp_path)
    AssertFails(Run("prepare", stage, "--noCache"), 2, "--noCache")
    AssertFails(Run("prepare", tmp_path / "none.usda"), 1, "none.usda: no such file")
    AssertFails(Run("prepare", stage, "--camera", "nobody"), 2, "--camera nobody")
    AssertFails(Run("prepare", stage, "--frames", "1:x"), 2, "1:x")
    AssertFails(Run("prepare"), 2, "STAGE")
    file = tmp_path / "file"
    file.write_text("")
    AssertFails(Run("prepare", stage, "--cacheDir", file / "cache"), 1, "cannot be written")


def test_it_needs_no_device(tmp_path):
    result = Run("prepare", WriteStage(tmp_path), "--cacheDir", tmp_path / "cache", environment={"OCL_ICD_VENDORS": str(tmp_path)})
    assert result.code == 0 and "1 chunks" in result.out, result.text


def test_ctrl_c_keeps_what_is_there(tmp_path):
    """A second run goes on, and ends with all that one run has."""
    stage, cache = tmp_path / "stage.usda", _Cache(tmp_path / "cache")
    author_stage = author.NewStage(str(stage))
    for i in range(60):
        author.AddMesh(author_stage, f"/World/Ball{i}", shapes.Sphere(1.0 + 0.01 * i, 200, 300))
    author_stage.GetRootLayer().Save()
    process = subprocess.Popen(Command("prepare", stage, "--cacheDir", cache), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, preexec_fn=DefaultInterrupt)
    end = time.monotonic() + SECONDS
    while not any(path.stat().st_size > 1 << 20 for path in cache.glob("pages-*.hdsp")) and time.monotonic() < end:
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=SECONDS)
    AssertFails(Result(process.returncode, out, err), 130, "hdstream prepare: interrupted; what is prepared is kept")
    result = Run("prepare", stage, "--cacheDir", cache)
    chunks, made = map(int, re.search(r": (\d+) chunks of .*?, (\d+) made", result.out).groups())
    assert 0 < made < chunks, result.text
