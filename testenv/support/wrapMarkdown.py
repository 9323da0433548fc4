# SPDX-License-Identifier: Apache-2.0
"""Wraps the prose of Markdown files at 100 columns: wrapMarkdown.py FILE... ; testenv/docs/test_pages.py checks it.

Paragraphs, list items and block quotes are filled. Left as they are: tables, code, headings, HTML comments and what stands
between `<!-- begin` and `<!-- end` markers, pictures that stand alone on a line, and rules. A line may be longer than 100
columns only where a word of it (a link, a path in backquotes) is too long to be broken.
"""

import pathlib
import re
import sys
import textwrap

WIDTH = 100
_ITEM = re.compile(r"^(\s*)([*+-]|\d+[.)])(\s+)")
_PLAIN = re.compile(r"^\s*(\||#|<|!\[|\[!\[|---+\s*$|===+\s*$)")  # a table, a heading, HTML, a picture, a rule


def _Fill(lines: list[str], first: str, rest: str) -> list[str]:
    """One paragraph. Pieces in backquotes are not broken: a space in them is hidden from the filling."""
    text = " ".join(line.strip() for line in lines)
    text = re.sub(r"`[^`]*`", lambda piece: piece.group().replace(" ", "\x00"), text)
    filled = textwrap.wrap(text, WIDTH, initial_indent=first, subsequent_indent=rest, break_long_words=False,
                           break_on_hyphens=False)
    filled = [line.replace("\x00", " ") for line in filled]
    # A line that begins with what Markdown takes for an item, a heading or a quote would become one.
    for number in range(1, len(filled)):
        if re.match(r"^\s*([*+#>-]|\d+[.)])(\s|$)", filled[number]):
            word, _, tail = filled[number].strip().partition(" ")
            filled[number - 1] += " " + word
            filled[number] = rest + tail
    return [line for line in filled if line.strip()]


def Wrapped(text: str) -> str:
    """The text with its prose filled. Wrapping again changes nothing."""
    out: list[str] = []
    paragraph: list[str] = []
    first = rest = ""
    isFenced = isGenerated = isComment = False

    def Flush():
        nonlocal paragraph
        if paragraph:
            out.extend(_Fill(paragraph, first, rest))
        paragraph = []

    for line in text.split("\n"):
        if isFenced or isGenerated or isComment:
            out.append(line)
            isFenced = isFenced and not line.strip().startswith("```")
            isGenerated = isGenerated and not line.startswith("<!-- end ")
            isComment = isComment and "-->" not in line
            continue
        item = _ITEM.match(line)
        isCode = line.startswith("    ") and not paragraph and not rest
        if not line.strip() or isCode or _PLAIN.match(line) or line.strip().startswith("```"):
            Flush()
            if line.strip() and not line.startswith(" "):
                rest = ""
            out.append(line.rstrip() if not line.strip() else line)
            isFenced = line.strip().startswith("```")
            isGenerated = line.startswith("<!-- begin ")
            isComment = line.lstrip().startswith("<!--") and "-->" not in line
        elif item:
            Flush()
            first, rest = item.group(), " " * len(item.group())
            paragraph = [line[len(first):]]
        elif line.lstrip().startswith(">"):
            Flush()
            out.append(line)
        else:
            if not paragraph:
                indent = line[: len(line) - len(line.lstrip())]
                first = rest = indent
            paragraph.append(line)
    Flush()
    return "\n".join(out)


def main() -> int:
    for name in sys.argv[1:]:
        file = pathlib.Path(name)
        file.write_text(Wrapped(file.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
