# SPDX-License-Identifier: Apache-2.0
"""A built hdstream on the path, for the tests and for the commands they start."""

import importlib.util
import os
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
if importlib.util.find_spec("hdstream") is None:
    for build in sorted((HERE.parents[1] / "build").glob("*/python")):
        if list(build.glob("hdstream/_core*")):
            sys.path.insert(0, str(build))
            os.environ["PYTHONPATH"] = os.pathsep.join(
                [str(build)] + [path for path in [os.environ.get("PYTHONPATH")] if path])
            break
