# SPDX-License-Identifier: Apache-2.0
"""The helpers of the streaming and the render tests, and the scenes that the streaming tests share."""

import pathlib
import sys

import pytest

_TESTENV = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(_TESTENV / "stream"), str(_TESTENV / "render")]

from stages import streaming, textured  # noqa: E402


@pytest.fixture(scope="session", params=list(streaming.CASES))
def Scene(request, tmp_path_factory):
    """Each stage of stages/streaming.py, rendered with resident geometry."""
    from streamCase import Case

    path = tmp_path_factory.mktemp(request.param) / "stage.usda"
    streaming.CASES[request.param](str(path))
    return Case(path).RenderResident()


@pytest.fixture(scope="session")
def Textured(tmp_path_factory):
    """The stage of stages/textured.py, rendered with resident textures."""
    from streamCase import Case

    path = tmp_path_factory.mktemp("textured") / "stage.usda"
    textured.WriteTextured(str(path))
    return Case(path).RenderResident()
