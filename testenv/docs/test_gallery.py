# SPDX-License-Identifier: Apache-2.0
"""docs/gallery.md: all stages are made and translated without a warning, two are rendered, and the page is renewed."""

import os
import subprocess
import sys

import pytest

from documentedCommands import ROOT
from gallery.__main__ import PICTURES, WriteStage

_RENDERED = ("mountains", "macro")  # of features whose kernels other tests have built


@pytest.mark.parametrize("name", PICTURES)
def test_stages_translate_without_warnings(name, tmp_path):
    from hdstream import _core
    from hdstream.translate import TranslateStage
    from pxr import Usd

    stage = WriteStage(name, tmp_path, 0.02)
    session = _core.Session()
    TranslateStage(Usd.Stage.Open(str(stage)), session, Usd.TimeCode.Default())
    again = tmp_path / "again"
    WriteStage(name, again, 0.02)
    twin = _core.Session()
    TranslateStage(Usd.Stage.Open(str(again / "stage.usdc")), twin, Usd.TimeCode.Default())
    dump = session.Dump()
    assert dump.replace(str(tmp_path), "") == twin.Dump().replace(str(again), "")  # made from formulas: always the same
    assert "/World/Camera" in dump


def test_pictures_and_figures_reach_the_page(cache, tmp_path):
    done = subprocess.run([sys.executable, ROOT / "testenv/gallery", *_RENDERED, "--out", tmp_path, "--short"], capture_output=True, text=True,
                          env=dict(os.environ, HDSTREAM_CACHE_DIR=str(cache)), timeout=600)
    assert done.returncode == 0, done.stderr
    assert "warning:" not in done.stderr
    page = (tmp_path / "gallery.md").read_text(encoding="utf-8")
    for name in _RENDERED:
        picture = tmp_path / "images" / "gallery" / f"{name}.jpg"
        assert picture.read_bytes()[:3] == b"\xff\xd8\xff"
        block = page.split(f"<!-- begin {name} -->")[1].split(f"<!-- end {name} -->")[0]
        assert f"images/gallery/{name}.jpg" in block and "2 samples" in block and "triangles" in block


def test_the_page_has_every_picture():
    page = (ROOT / "docs/gallery.md").read_text(encoding="utf-8")
    for name, options in PICTURES.items():
        block = page.split(f"<!-- begin {name} -->")[1].split(f"<!-- end {name} -->")[0]
        assert " ".join(options) in block, f"run scripts/gallery {name} --out docs"
        picture = ROOT / "docs/images/gallery" / f"{name}.jpg"
        assert 10_000 < picture.stat().st_size < 300_000


def test_an_unknown_name_is_one_line(tmp_path):
    done = subprocess.run([sys.executable, ROOT / "testenv/gallery", "sea", "--out", tmp_path], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "no picture 'sea'; there are: forest" in done.stderr
