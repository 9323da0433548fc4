# SPDX-License-Identifier: Apache-2.0
"""The table of hard cases: what a naive method does, what is done instead, the figure and its bar.

    stability.py [NAME...]               # names, or parts of them; without: all
    stability.py --fixedOffset 1e-4 ...  # with rays that leave surfaces by a fixed distance, as a naive method has it

The exit code is 1 when a figure is above its bar; with a naive method it says nothing. Explained in docs/stability.md.
"""

import argparse
import os
import pathlib
import shutil
import sys
import tempfile

_TESTENV = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(_TESTENV / "render"), str(_TESTENV)]

from stabilityCases import CASES  # noqa: E402

_OFFSET = "side * point->planeError"  # of offset_origin


def _UseFixedOffset(distance: float, folder: pathlib.Path) -> None:
    """Kernels that differ by that alone."""
    shutil.copytree(_TESTENV.parent / "kernels", folder)
    file = folder / "math" / "offset.clh"
    text = file.read_text()
    assert text.count(_OFFSET) == 1
    file.write_text(text.replace(_OFFSET, f"side * {distance!r}f"))
    os.environ["HDSTREAM_KERNEL_DIR"] = str(folder)


def _Figure(case) -> tuple:
    """(text, whether it is within the bar)."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            figure = case.figure(folder)
        except Exception as error:  # pylint: disable=broad-except
            return f"{type(error).__name__}: {str(error)[:300]}", False
    return f"{figure:.2g}{'' if figure <= case.bar else ' ABOVE'}", figure <= case.bar


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--fixedOffset", type=float)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if args.fixedOffset is not None:
            _UseFixedOffset(args.fixedOffset, pathlib.Path(folder) / "kernels")
        isGood = True
        print("| case | measure | figure | bar |\n|---|---|---|---|", flush=True)
        for name, case in CASES.items():
            if args.names and not any(part in name for part in args.names):
                continue
            text, isWithin = _Figure(case)
            isGood &= isWithin
            print(f"| {name} | {case.measure} | {text} | {case.bar:g} |", flush=True)
    return 0 if isGood or args.fixedOffset is not None else 1


if __name__ == "__main__":
    sys.exit(main())
