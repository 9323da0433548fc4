# SPDX-License-Identifier: Apache-2.0
"""A built hdstream for tests when none is installed."""

import importlib.util
import os
import pathlib
import sys

_BUILDS = pathlib.Path(__file__).resolve().parents[2] / "build"


def PutOnPath() -> None:
    """A build of this tree, `release` before others, for this process and for the commands that it starts."""
    if importlib.util.find_spec("hdstream") is not None:
        return
    for package in [_BUILDS / "release" / "python", *sorted(_BUILDS.glob("*/python"))]:
        if list(package.glob("hdstream/_core*")):
            sys.path.insert(0, str(package))
            os.environ["PYTHONPATH"] = os.pathsep.join([str(package), *filter(None, [os.environ.get("PYTHONPATH")])])
            return
