# SPDX-License-Identifier: Apache-2.0
"""The table of hard cases: what a naive method does, what is done instead, the figure and its bar.

    stability.py [NAME...]        # names, or parts of them; without: all

The exit code is 1 when a figure is above its bar. Explained in docs/stability.md.
"""

import pathlib
import sys
import tempfile

_TESTENV = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(_TESTENV / "render"), str(_TESTENV)]

from stabilityCases import CASES  # noqa: E402


def main(names) -> int:
    isGood = True
    print("| case | measure | figure | bar |\n|---|---|---|---|", flush=True)
    for name, case in CASES.items():
        if names and not any(part in name for part in names):
            continue
        with tempfile.TemporaryDirectory() as folder:
            try:
                figure = case.figure(folder)
            except Exception as error:  # pylint: disable=broad-except
                print(f"| {name} | {case.measure} | {type(error).__name__}: {str(error)[:300]} | {case.bar:g} |", flush=True)
                isGood = False
                continue
        isGood &= figure <= case.bar
        print(f"| {name} | {case.measure} | {figure:.2g}{'' if figure <= case.bar else ' ABOVE'} | {case.bar:g} |", flush=True)
    return 0 if isGood else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
