# SPDX-License-Identifier: Apache-2.0
"""This folder's helpers and those of the command line's tests."""

import pathlib
import sys

_TESTENV = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(_TESTENV / "python"), str(_TESTENV / "cli")]
