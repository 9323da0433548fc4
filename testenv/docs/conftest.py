# SPDX-License-Identifier: Apache-2.0
"""OpenUSD with its plug-in where there is one; caches that pages may clear."""

import os
import pathlib
import shutil
import sys

import pytest

HERE = pathlib.Path(__file__).resolve().parent
TESTENV = HERE.parent
sys.path[:0] = [str(HERE), str(TESTENV), str(TESTENV / "hydra")]

import openUsd as openUsdModule  # noqa: E402
from bench.recordRun import FreshCache  # noqa: E402


@pytest.fixture(scope="session")
def build():
    return openUsdModule.BuildFolder()


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """A folder for caches that pages may clear, with the kernels that other tests have built."""
    return FreshCache(tmp_path_factory.mktemp("cache"), os.environ.get("HDSTREAM_CACHE_DIR", ""))


@pytest.fixture(scope="session")
def missing():
    """{what a block may need: why it is not there, or ""}."""
    found, why = openUsdModule.FindOpenUsd()
    plugin, whyNot = openUsdModule.FindPlugin()
    reason = why if not found else whyNot if not plugin else ""
    screen = ""
    if not shutil.which("xvfb-run"):
        screen = "xvfb-run is missing"
    elif found and not found.HasModules("PySide6.QtOpenGLWidgets", "OpenGL.GL"):
        screen = f"{found.python} has no PySide6 and PyOpenGL"
    return {"OpenUSD": reason, "an X server": screen}


@pytest.fixture(scope="session")
def openUsd(missing):
    return None if missing["OpenUSD"] else openUsdModule.FindOpenUsd()[0]
