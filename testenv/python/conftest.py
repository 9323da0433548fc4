# SPDX-License-Identifier: Apache-2.0
"""A built hdstream on the path, and the helpers of the command line's tests."""

import importlib.util
import os
import pathlib
import sys

_TESTENV = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(_TESTENV / "python"), str(_TESTENV / "cli"), str(_TESTENV / "support"), str(_TESTENV)]
if importlib.util.find_spec("hdstream") is None:
    for build in sorted((_TESTENV.parent / "build").glob("*/python")):
        if list(build.glob("hdstream/_core*")):
            sys.path.insert(0, str(build))
            os.environ["PYTHONPATH"] = os.pathsep.join(  # of the commands that tests start
                [str(build)] + [path for path in [os.environ.get("PYTHONPATH")] if path])
            break
