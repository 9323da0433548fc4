# SPDX-License-Identifier: Apache-2.0
"""Paths of the streaming tests, those of the render tests and this folder, and the scenes they share."""

import importlib.util
import os
import pathlib
import sys

import pytest

_TESTENV = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(_TESTENV / "stream"), str(_TESTENV / "render"), str(_TESTENV)]
if importlib.util.find_spec("hdstream") is None:
    for build in sorted((_TESTENV.parent / "build").glob("*/python")):
        if list(build.glob("hdstream/_core*")):
            sys.path.insert(0, str(build))
            os.environ["PYTHONPATH"] = os.pathsep.join(  # of the commands that tests start
                [str(build)] + [path for path in [os.environ.get("PYTHONPATH")] if path])
            break

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
