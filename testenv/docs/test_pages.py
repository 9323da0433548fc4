# SPDX-License-Identifier: Apache-2.0
"""Every page opens with what it is for, and its prose is wrapped at 100 columns."""

import pytest

from documentedCommands import ROOT
from wrapMarkdown import WIDTH, Wrapped

_PAGES = sorted([ROOT / "README.md", ROOT / "CHANGELOG.md", *ROOT.glob("docs/*.md"), *ROOT.glob("docs/decisions/*.md")])


@pytest.mark.parametrize("page", _PAGES, ids=lambda page: page.name)
def test_prose_is_wrapped(page):
    text = page.read_text(encoding="utf-8")
    assert Wrapped(text) == text, f"run python testenv/support/wrapMarkdown.py {page.relative_to(ROOT)}"


@pytest.mark.parametrize("page", _PAGES, ids=lambda page: page.name)
def test_it_opens_with_what_it_is_for(page):
    title, blank, first = page.read_text(encoding="utf-8").split("\n")[:3]
    assert title.startswith("# ") and blank == ""
    assert first[0].isalpha() or first[0] in "*`_", f"{page.name} opens with {first!r}, which is no sentence"


def test_wrapping_breaks_what_is_long_and_leaves_the_rest():
    words = "word " * 60
    table, code, link = "| " + "cell " * 60 + "|", "    " + "code " * 60, "[text](" + "x" * 150 + ")"
    text = f"# T\n\n{words}\n\n* {words}\n\n{table}\n\n{code}\n\n```\n{words}\n```\n\n{link}\n"
    lines = Wrapped(text).split("\n")
    assert Wrapped("\n".join(lines)) == "\n".join(lines)
    assert {table, code, link, words} <= set(lines)
    prose = [line for line in lines if line not in (table, code, link, words)]
    assert all(len(line) <= WIDTH for line in prose) and sum("word" in line for line in prose) > 4
    assert any(line.startswith("  word") for line in prose)  # an item goes on under its first word
