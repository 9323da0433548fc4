# SPDX-License-Identifier: Apache-2.0
"""Writes scene.golden.txt of the named cases, or of all: updateGoldens.py [CASE...]

The one way to change goldens. Read the difference before it is committed: a golden is right when
it follows from OpenUSD's text, not because the program says so.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import builtPackage  # noqa: E402

builtPackage.PutOnPath()
from translateCase import CASES, FOLDER, GoldenText  # noqa: E402

for case in sys.argv[1:] or CASES:
    (FOLDER / case / "scene.golden.txt").write_text(GoldenText(case), encoding="utf-8")
    print(case)
