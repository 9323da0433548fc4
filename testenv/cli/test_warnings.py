# SPDX-License-Identifier: Apache-2.0
"""Warnings that people read: one line a kind, with three names; all of them on request and in the statistics."""

import json

import pytest

from cliCase import SCENE, SMALL, TRIANGLE, Run, WriteStage

COUNT = 40


def _WriteBroken(folder):
    """Forty meshes with one face or two too few points, and a light filter."""
    bad = "".join(TRIANGLE.replace('"Triangle"', f'"Bad{i:02d}"').replace("Counts = [3]", f"Counts = [3{', 3' * (i % 2 + 1)}]")
                  .replace("[0, 1, 2]", f"[0, 1, 2{', 0, 1, 7' * (i % 2 + 1)}]") for i in range(COUNT))
    return WriteStage(folder, SCENE + bad + 'def RectLight "Filtered" { rel light:filters = </F> }\n')


@pytest.fixture(name="stage")
def MakeStage(tmp_path):
    return _WriteBroken(tmp_path)


def _Record(stage, tmp_path, *options, **keywords):
    result = Run("record", stage, tmp_path / "o.exr", *SMALL, "--stats", tmp_path / "s.json", *options, **keywords)
    assert result.code == 0 and not result.errors, result.text
    every = json.loads((tmp_path / "s.json").read_text(encoding="utf-8"))["warnings"]
    return result.warnings, [line for line in every if line.startswith("/Bad")], every


def test_one_line_a_kind_with_three_names(stage, tmp_path):
    shown, bad, every = _Record(stage, tmp_path)
    assert len(bad) == COUNT
    lines = [line for line in shown if line.startswith("/Bad")]
    # One face or two: the words differ, so these are two kinds.
    assert [line.split(":")[0] for line in lines] == ["/Bad00, /Bad02, /Bad04 and 17 more", "/Bad01, /Bad03, /Bad05 and 17 more"]
    assert bad[0] == lines[0].replace(", /Bad02, /Bad04 and 17 more", "")
    assert len(shown) == len(every) - COUNT + 2
    assert any(line.startswith("/Filtered: light filter") for line in shown), "what is alone stays as it is"


def test_verbose_shows_each(stage, tmp_path):
    shown, _, every = _Record(stage, tmp_path, "--verbose")
    assert sorted(shown) == every
    shown, _, _ = _Record(stage, tmp_path, environment=dict(HDSTREAM_VERBOSE="1"))
    assert sorted(shown) == every


def test_frames_repeat_nothing(stage, tmp_path):
    result = Run("record", stage, tmp_path / "o.##.exr", *SMALL, "--frames", "1:3")
    assert result.code == 0 and len(result.warnings) == len(set(result.warnings)), result.text
    assert len([line for line in result.warnings if line.startswith("/Bad")]) == 2


def test_line_breaks_in_names_break_no_line(tmp_path):
    """The stage has nothing to draw, which is said with its name."""
    folder = tmp_path / "two\nlines"
    folder.mkdir()
    result = Run("record", WriteStage(folder, ""), tmp_path / "o.exr", *SMALL)
    assert result.code == 0 and not result.errors and [line for line in result.warnings if "two lines" in line], result.text


def test_a_layer_that_cannot_be_read_is_one_line(tmp_path):
    (tmp_path / "broken.usda").write_text("#usda 1.0\ndef Mesh \"M\" { float a = }\n")
    stage = tmp_path / "s.usda"
    stage.write_text("#usda 1.0\n(\n    subLayers = [@./broken.usda@]\n)\ndef Sphere \"Ball\" {}\n")
    ofUsd = [line for line in Run("info", stage).warnings if line.startswith("USD: ")]
    assert len(ofUsd) == 1 and "broken.usda" in ofUsd[0] and ofUsd[0].endswith("; skipping."), ofUsd
