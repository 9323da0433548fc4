# SPDX-License-Identifier: Apache-2.0
"""The text of docs/performance.md: prose by hand, and between two markers a block for each section of run.py.

    <!-- begin knobs -->
    ... written anew by each run of that section
    <!-- end knobs -->
"""

import csv
import dataclasses
import pathlib
import re

_BLOCK = re.compile(r"(<!-- begin (\w+) -->\n).*?(<!-- end \2 -->)", re.DOTALL)
NOT_RUN = "Not run: `python testenv/bench/run.py --out FOLDER --sections {name}`.\n"


class LeftOut(Exception):
    """A section cannot run here; the message says what is missing."""


@dataclasses.dataclass
class Table:
    """Saved as STEM.csv beside the page and shown in it: all rows, or some. Numbers are shown with three digits."""

    stem: str
    head: list
    rows: list
    shown: list = None

    def Markdown(self) -> str:
        rows = self.rows if self.shown is None else self.shown
        lines = [self.head, ["---"] * len(self.head), *([_Cell(value) for value in row] for row in rows)]
        return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"

    def Save(self, folder: pathlib.Path) -> None:
        with open(folder / f"{self.stem}.csv", "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.head)
            writer.writerows([f"{value:.6g}" if isinstance(value, float) else value for value in row] for row in self.rows)


def _Cell(value) -> str:
    if value is None:
        return "-"
    if not isinstance(value, float):
        return f"{value:,}".replace(",", " ") if isinstance(value, int) else str(value)
    return f"{value:.2e}" if value and not 1e-3 <= abs(value) < 1e5 else f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def Names(text: str) -> list:
    """Of the blocks of a page."""
    return [match[2] for match in _BLOCK.finditer(text)]


def Emptied(text: str) -> str:
    """The page with nothing measured in it."""
    return _BLOCK.sub(lambda match: match[1] + NOT_RUN.format(name=match[2]) + match[3], text)


def Replaced(text: str, name: str, body: str) -> str:
    """The page with another block. Raises where the page has no such block."""
    if name not in Names(text):
        raise KeyError(f"the page has no block `{name}`")
    return _BLOCK.sub(lambda match: match[1] + body + match[3] if match[2] == name else match[0], text)


def Block(items: list, images: pathlib.Path, link: str) -> str:
    """Text of items: strings, tables, (stem, chart) and paths of SVG files in `images`; writes their files there.
    Charts in a row share a line."""
    images.mkdir(parents=True, exist_ok=True)
    parts, isAfterChart = [], False
    for item in items:
        if isinstance(item, Table):
            item.Save(images)
            part = item.Markdown()
        elif isinstance(item, str):
            part = item + "\n"
        else:
            if isinstance(item, tuple):
                item[1].Save(images / item[0])
            stem, title = (item[0], item[1].title) if isinstance(item, tuple) else (item.stem, item.stem)
            part = f"![{title}]({link}/{stem}.svg)\n"
        isChart = not isinstance(item, (Table, str))
        parts.append(part if not parts or (isChart and isAfterChart) else "\n" + part)
        isAfterChart = isChart
    return "".join(parts)
