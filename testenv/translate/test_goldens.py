# SPDX-License-Identifier: Apache-2.0
"""The scene of each case is the text of its golden file: both front ends give the same text."""

import difflib

import pytest

from hdstream.translate import geometryBatch, rereading
from translateCase import CASES, FOLDER, GoldenText


@pytest.mark.parametrize("case", CASES)
def test_dump_is_golden(case):
    golden = (FOLDER / case / "scene.golden.txt").read_text(encoding="utf-8")
    found = GoldenText(case)
    difference = "\n".join(difflib.unified_diff(golden.splitlines(), found.splitlines(),
                                                "golden", "found", lineterm="", n=2))
    assert found == golden, f"{case}:\n{difference}\n(see updateGoldens.py)"


@pytest.mark.parametrize("case", CASES)
def test_dump_of_arrays_that_are_away_is_golden(case, monkeypatch):
    """Where every array counts as large and is read again (docs/memory-budgets.md)."""
    monkeypatch.setattr(rereading, "SMALLEST", 0)
    assert GoldenText(case) == (FOLDER / case / "scene.golden.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize("case", CASES)
def test_dump_of_prims_that_are_handed_over_one_by_one_is_golden(case, monkeypatch):
    monkeypatch.setattr(geometryBatch, "_AT_ONCE", 1)
    assert GoldenText(case) == (FOLDER / case / "scene.golden.txt").read_text(encoding="utf-8")


def test_dump_does_not_depend_on_earlier_scenes():
    assert GoldenText(CASES[0]) == GoldenText(CASES[0])
