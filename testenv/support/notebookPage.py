# SPDX-License-Identifier: Apache-2.0
"""Writes docs/python.ipynb: docs/python.md as a notebook, its code run here, its output and pictures stored.

    python testenv/support/notebookPage.py        needs neither Jupyter nor its packages

Cells share one namespace; as in Jupyter, the value of a cell's last expression is shown when it has a picture.
"""

import ast
import base64
import contextlib
import io
import json
import pathlib
import re
import tempfile

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
PAGE = DOCS / "python.md"
NOTEBOOK = DOCS / "python.ipynb"
_FENCE = re.compile(r"```python\n(.*?)```\n", re.DOTALL)


def Split(text):
    """[("markdown" | "code", source)] of a page."""
    cells = []
    for index, part in enumerate(_FENCE.split(text)):
        if part.strip():
            cells.append(("code" if index % 2 else "markdown", part.strip("\n")))
    return cells


def RunCell(source, namespace):
    """Runs a cell; returns (what it printed, the value of its last expression or None)."""
    tree = ast.parse(source)
    last = None
    if isinstance(tree.body[-1], ast.Expr):
        last = ast.Expression(tree.body.pop().value)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), namespace)  # pylint: disable=exec-used
        value = eval(compile(last, "cell", "eval"), namespace) if last else None  # pylint: disable=eval-used
    return printed.getvalue(), value


def MakeNotebook(text):
    """The notebook, nbformat 4, as a dict."""
    cells = []
    namespace = {}
    numRuns = 0
    for index, (kind, source) in enumerate(Split(text)):
        cell = {"cell_type": kind, "id": f"cell{index}", "metadata": {}, "source": source.splitlines(keepends=True)}
        if kind == "code":
            numRuns += 1
            cell.update(execution_count=numRuns, outputs=_OutputsOf(*RunCell(source, namespace), numRuns))
        cells.append(cell)
    return {"cells": cells, "metadata": {"language_info": {"name": "python"}}, "nbformat": 4, "nbformat_minor": 5}


def _OutputsOf(printed, value, number):
    outputs = []
    if printed:
        outputs.append({"name": "stdout", "output_type": "stream", "text": printed.splitlines(keepends=True)})
    if hasattr(value, "_repr_png_"):
        data = {"image/png": base64.b64encode(value._repr_png_()).decode()}  # pylint: disable=protected-access
        outputs.append({"data": data, "execution_count": number, "metadata": {}, "output_type": "execute_result"})
    return outputs


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch, contextlib.chdir(scratch):  # cells write files
        page = MakeNotebook(PAGE.read_text(encoding="utf-8"))
    NOTEBOOK.write_text(json.dumps(page, indent=1) + "\n", encoding="utf-8")
