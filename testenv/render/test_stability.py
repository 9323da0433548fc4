# SPDX-License-Identifier: Apache-2.0
"""Hard cases stay below their bars, and what docs/stability.md links to is there."""

import pathlib
import re

import pytest

pytest.importorskip("hdstream._core")

from stabilityCases import CASES

_ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", CASES)
def test_hard_case(name, tmp_path):
    case = CASES[name]
    figure = case.figure(str(tmp_path))
    assert figure <= case.bar, f"{case.measure}: {figure:.3g}"


def test_the_page_names_tests_that_are_there():
    """Each test that docs/stability.md names in backquotes after its file is in that file."""
    page = (_ROOT / "docs" / "stability.md").read_text(encoding="utf-8")
    references = re.findall(r"\[(\w+)\]\(\.\./(testenv/[\w/.]+)\)((?: `[\w*\[\], .-]+`,?)*)", page)
    assert len(references) > 35
    for _, file, names in references:
        text = (_ROOT / file).read_text(encoding="utf-8")
        for name in re.findall(r"`(\w+)", names):
            assert name in text, f"{file} has no {name}"
    for name in CASES:
        assert name.split("[")[0] in page, f"docs/stability.md has no row of {name}"
