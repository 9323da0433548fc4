# SPDX-License-Identifier: Apache-2.0
"""What all tests share: the packages of testenv, its support, a built hdstream."""

import pathlib
import sys

_TESTENV = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(_TESTENV / "support"), str(_TESTENV)]

import builtPackage  # noqa: E402

builtPackage.PutOnPath()
