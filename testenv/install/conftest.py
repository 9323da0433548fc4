# SPDX-License-Identifier: Apache-2.0
"""The wheel, built once, and a fresh virtual environment that holds it. Both need no network."""

import pathlib
import sys
import sysconfig

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from installCase import ROOT, STAGE, CleanEnvironment, Run  # noqa: E402


@pytest.fixture
def stage(tmp_path):
    path = tmp_path / "stage.usda"
    path.write_text(STAGE)
    return path


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """Built with the build requirements of this interpreter; objects stay in build/<tag>."""
    folder = tmp_path_factory.mktemp("wheel")
    result = Run([sys.executable, "-m", "pip", "wheel", ROOT, "--no-deps", "--no-build-isolation",
                  "--wheel-dir", folder], env=CleanEnvironment())
    assert result.returncode == 0, result.stdout[-4000:] + result.stderr[-4000:]
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="session")
def installed(wheel, tmp_path_factory):
    """bin/ of a fresh environment with the wheel. usd-core and numpy are lent by a path file: the
    .pth files of the lender, which name the build tree, are not read through it."""
    folder = tmp_path_factory.mktemp("venv with spaces")
    assert Run([sys.executable, "-m", "venv", "--without-pip", folder]).returncode == 0
    python = folder / "bin" / "python"
    result = Run([sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", wheel],
                 env=CleanEnvironment())
    assert result.returncode == 0, result.stdout + result.stderr
    (packages,) = folder.glob("lib/python*/site-packages")
    (packages / "lent.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin"
