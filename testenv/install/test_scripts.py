# SPDX-License-Identifier: Apache-2.0
"""scripts/render on a machine that is set up: quiet, from any folder, with hdstream's exit codes."""

import pathlib

import pytest
from installCase import ROOT, CleanEnvironment, Run

RENDER = ROOT / "scripts" / "render"


@pytest.fixture(autouse=True)
def setUp():
    if not (ROOT / ".setup" / "stamp").exists():
        pytest.skip("this tree was not set up by scripts/render or scripts/test")


def test_second_run_sets_nothing_up(stage, tmp_path):
    folder = tmp_path / "a folder"
    folder.mkdir()
    result = Run([RENDER, pathlib.Path("..") / stage.name, "pic ture.exr", "--camera", "/Camera", "--imageWidth", 8,
                  "--samples", 1, "--quiet"], cwd=folder, env=CleanEnvironment())
    assert result.returncode == 0, result.stderr
    assert (folder / "pic ture.exr").stat().st_size > 0
    assert "hdStream:" not in result.stderr  # every set-up step says so with this prefix


def test_modules_of_the_callers_folder_are_not_taken(stage, tmp_path):
    for name in ("hdstream", "numpy", "pxr"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise SystemExit(77)")
    result = Run([RENDER, stage.name, "out.exr", "--imageWidth", 8, "--samples", 1], cwd=tmp_path, env=CleanEnvironment())
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("arguments, code", [(["missing.usda", "out.exr"], 1), (["missing.usda"], 1), (["--noSuchOption"], 2), (["one", "two", "three"], 2)])
def test_exit_codes_are_passed_through(arguments, code, tmp_path):
    result = Run([RENDER, *arguments], cwd=tmp_path, env=CleanEnvironment())
    assert result.returncode == code, result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
