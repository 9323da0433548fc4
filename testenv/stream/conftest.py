# SPDX-License-Identifier: Apache-2.0
"""Paths of the streaming tests: those of the render tests."""

import importlib.util
import pathlib
import sys

_TESTENV = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(_TESTENV / "render"), str(_TESTENV)]
if importlib.util.find_spec("hdstream") is None:
    for build in sorted((_TESTENV.parent / "build").glob("*/python")):
        if list(build.glob("hdstream/_core*")):
            sys.path.insert(0, str(build))
            break
