# SPDX-License-Identifier: Apache-2.0
"""A built hdstream on the path when none is installed, and Session helpers of the tests."""

import importlib.util
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
if importlib.util.find_spec("hdstream") is None:
    for build in sorted((ROOT / "build").glob("*/python")):
        if list(build.glob("hdstream/_core*")):
            sys.path.insert(0, str(build))
            break
