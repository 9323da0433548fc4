# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Hydra plug-in need: an OpenUSD with imaging, the plug-in, an X server.

Every missing piece skips the tests that need it, with its reason in the report and once more in the
terminal summary; with $HDSTREAM_REQUIRE_HYDRA a missing OpenUSD or plug-in fails them.
$HDSTREAM_TEST_RENDERER lets the machinery run with another renderer (Embree).
"""

import os
import pathlib
import shutil
import sys

import pytest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import openUsd as openUsdModule  # noqa: E402

_reasons = []


def _Skip(reason, isRequired=False):
    if isRequired and os.environ.get("HDSTREAM_REQUIRE_HYDRA"):
        pytest.fail(f"{reason}, and HDSTREAM_REQUIRE_HYDRA is set", pytrace=False)
    if reason not in _reasons:
        _reasons.append(reason)
    pytest.skip(reason)


def pytest_terminal_summary(terminalreporter):
    for reason in _reasons:
        terminalreporter.write_line(f"HYDRA TESTS SKIPPED: {reason}", yellow=True)


@pytest.fixture(scope="session")
def openUsd():
    found, reason = openUsdModule.FindOpenUsd()
    return found or _Skip(reason, isRequired=True)


@pytest.fixture(scope="session")
def renderer():
    """The display name of the renderer under test."""
    return os.environ.get("HDSTREAM_TEST_RENDERER", "Stream")


@pytest.fixture(scope="session")
def plugin(renderer):
    """The plug-in's folder of resources."""
    folder, reason = openUsdModule.FindPlugin()
    if not folder and renderer == "Stream":
        _Skip(reason, isRequired=True)
    return folder


@pytest.fixture(scope="session")
def isStream(renderer):
    return renderer == "Stream"


@pytest.fixture(scope="session")
def windowed(openUsd):
    """The words that start a program under an X server of its own, with OpenUSD's GUI modules at hand."""
    if not openUsd.HasModules("PySide6.QtOpenGLWidgets", "OpenGL.GL"):
        _Skip(f"{openUsd.python} has no PySide6 and PyOpenGL: usdview cannot run")
    if not shutil.which("xvfb-run"):
        _Skip("xvfb-run is missing: usdview has no screen")
    return ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 +extension GLX"]
