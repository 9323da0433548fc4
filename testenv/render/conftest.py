# SPDX-License-Identifier: Apache-2.0
"""Paths of the render tests: this folder, testenv, and a built hdstream when none is installed."""

import importlib.util
import pathlib
import sys

_HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(_HERE), str(_HERE.parent)]
if importlib.util.find_spec("hdstream") is None:
    for build in sorted((_HERE.parent.parent / "build").glob("*/python")):
        if list(build.glob("hdstream/_core*")):
            sys.path.insert(0, str(build))
            break
