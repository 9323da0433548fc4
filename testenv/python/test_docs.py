# SPDX-License-Identifier: Apache-2.0
"""docs/python.md and docs/python.ipynb: every cell runs, prints what the notebook shows, and both pages agree."""

import base64
import inspect
import json

import notebookPage
import pytest


@pytest.fixture(scope="module", name="notebook")
def ReadNotebook():
    return json.loads(notebookPage.NOTEBOOK.read_text(encoding="utf-8"))


def test_the_notebook_is_the_page(notebook):
    cells = [(cell["cell_type"], "".join(cell["source"])) for cell in notebook["cells"]]
    assert cells == notebookPage.Split(notebookPage.PAGE.read_text(encoding="utf-8")), \
        "run python testenv/support/notebookPage.py"
    assert notebook["nbformat"] == 4


def test_cells_run_and_print_what_the_notebook_shows(notebook, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # cells write files
    namespace = {}
    numPictures = 0
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        printed, value = notebookPage.RunCell("".join(cell["source"]), namespace)
        shown = {output["output_type"]: output for output in cell["outputs"]}
        assert printed == "".join(shown.get("stream", {"text": []})["text"])
        if "execute_result" in shown:
            numPictures += 1
            picture = base64.b64decode(shown["execute_result"]["data"]["image/png"])
            # Another driver may round another way: sizes and kinds are the notebook's, bits the device's.
            assert picture[:24] == value._repr_png_()[:24]
    assert numPictures == 2


def test_every_public_name_has_a_docstring_with_its_parameters():
    import hdstream
    for name in ("Renderer", "Image", "Render"):
        thing = getattr(hdstream, name)
        members = {f"{name}.{key}": value for key, value in vars(thing).items()
                   if not key.startswith("_") and callable(value)} if inspect.isclass(thing) else {}
        for key, function in {name: thing, **members}.items():
            assert inspect.getdoc(function), key
            if inspect.isfunction(function):
                hints = function.__annotations__
                missing = [p for p in inspect.signature(function).parameters if p != "self" and p not in hints]
                assert not missing and "return" in hints, (key, missing)
