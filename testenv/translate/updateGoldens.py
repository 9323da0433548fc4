# SPDX-License-Identifier: Apache-2.0
"""Writes scene.golden.txt of the named cases, or of all: updateGoldens.py [CASE...]

The one way to change goldens. Read the difference before it is committed: a golden is right when
it follows from OpenUSD's text, not because the program says so.
"""

import conftest  # noqa: F401  pylint: disable=unused-import
import sys

from translateCase import CASES, FOLDER, GoldenText

for case in sys.argv[1:] or CASES:
    (FOLDER / case / "scene.golden.txt").write_text(GoldenText(case), encoding="utf-8")
    print(case)
