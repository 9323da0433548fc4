# SPDX-License-Identifier: Apache-2.0
"""`hdstream record --renderPassPrimPath`: the pass's collections, its render settings and their products."""

import exrFile
import numpy as np
import pytest

from cliCase import ANIMATED, Run, RunHere, WriteStage

_PASSES = """
def Scope "Render" {
    def RenderSettings "Settings" {
        rel products = </Render/Main>
        uniform int2 resolution = (24, 16)
        custom int hdstream:samples = 4
    }
    def RenderSettings "Other" {
        rel products = </Render/Second>
        uniform int2 resolution = (12, 8)
        custom int hdstream:samples = 2
    }
    def RenderProduct "Main" { token productName = "main.exr" }
    def RenderProduct "Second" { token productName = "second.exr" }
    def RenderPass "All" { rel renderSource = </Render/Settings> }
    def RenderPass "Matte" (prepend apiSchemas = ["CollectionAPI:matte"]) {
        rel renderSource = </Render/Settings>
        uniform token passType = "prman:default"
        rel collection:matte:includes = [</Triangle>, </Ball>]
    }
    def RenderPass "Lost" { rel renderSource = </Render/Main> }
    def RenderPass "Elsewhere" { asset fileName = @other.usda@ }
}
"""
_BRIGHT = ANIMATED.replace("inputs:intensity = 1", "inputs:intensity = 50000")


@pytest.fixture(name="stage")
def MakeStage(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return WriteStage(tmp_path, _BRIGHT + _PASSES, "stage.usda")


def _Record(stage, *arguments, run=RunHere, **further):
    result = run("record", stage, *arguments, **further)
    assert result.code == 0, result.text
    return result


def test_a_pass_writes_the_products_of_its_renderSource(stage, tmp_path):
    assert "main.exr: 24x16, 4 samples" in _Record(stage, "-rp", "/Render/All").out
    assert {path.name for path in tmp_path.glob("*.exr")} == {"main.exr"}
    _, whole = exrFile.Read("main.exr")
    assert whole["A"].max() > 0.5
    _Record(stage, "--renderPassPrimPath", "/Render/Matte")
    _, matte = exrFile.Read("main.exr")
    assert not matte["A"].any() and whole["A"].any()


def test_options_win_over_the_pass(stage):
    """The settings that are asked for count; with OUT the settings' first product says the size."""
    assert "second.exr: 12x8, 2 samples" in _Record(stage, "-rp", "/Render/All", "-rs", "/Render/Other").out
    assert "out.exr: 24x16, 4 samples" in _Record(stage, "out.exr", "-rp", "/Render/Matte").out
    assert not exrFile.Read("out.exr")[1]["A"].any()


def test_what_a_pass_names_in_vain_is_said(stage):
    text = _Record(stage, "out.exr", "-rp", "/Render/Lost", "-w", "16", "--samples", "1").text
    assert "/Render/Lost: renderSource /Render/Main is no render settings; ignored" in text
    text = _Record(stage, "out.exr", "-rp", "/Render/Elsewhere", "-w", "16", "--samples", "1").text
    assert "/Render/Elsewhere: fileName is not read" in text


def test_resume_tells_passes_apart_and_farms_write_the_same(stage, tmp_path):
    _Record(stage, "-rp", "/Render/All", "--resume")
    assert "is there already" in _Record(stage, "-rp", "/Render/All", "--resume").out
    assert "is there already" not in _Record(stage, "-rp", "/Render/Matte", "--resume").out
    _, single = exrFile.Read("main.exr")
    (tmp_path / "main.exr").unlink()
    _Record(stage, "-rp", "/Render/Matte", "--workers", "1", run=Run, cwd=tmp_path)
    _, again = exrFile.Read("main.exr")
    assert again.keys() == single.keys() and all(np.array_equal(again[key], single[key]) for key in again)
