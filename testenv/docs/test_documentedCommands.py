# SPDX-License-Identifier: Apache-2.0
"""Every command of README.md and docs/ runs, or says why it is not run here; the stage's words are those of the pages."""

import json
import re

import pytest

from documentedCommands import PAGES, ROOT, Blocks, InlineCommands, MakeCheckout, RunBlocks

_WITH_COMMANDS = [page for page in PAGES if any(not block.notRun for block in Blocks(page))]


def test_blocks_are_found(tmp_path):
    """Fences, indentation, marks; formulas and other languages are no commands."""
    page = tmp_path / "page.md"
    page.write_text("# T\n\n    hdstream devices\n\n    y = f(x)\n\ntext\n\n    f(x) = 2 x\n\n<!-- not run: a reason -->\n```sh\nmake coffee\n```\n\n"
                    "<!-- needs: OpenUSD -->\n\n    export A=1\n    usdview X\n\n```python\nimport os\n```\n\n- a\n    hdstream x\n")
    blocks = Blocks(page)
    assert [(block.line, block.notRun, block.needs) for block in blocks] == [(3, "", ""), (13, "a reason", ""), (18, "", "OpenUSD")]
    assert blocks[0].text == "hdstream devices\n\ny = f(x)" and blocks[1].text == "make coffee"


@pytest.mark.parametrize("page", _WITH_COMMANDS, ids=lambda page: page.stem)
def test_commands_run(page, build, cache, missing, openUsd, tmp_path):
    environment = MakeCheckout(tmp_path, build, openUsd)
    environment["HDSTREAM_CACHE_DIR"] = str(cache)
    blocks = [block for block in Blocks(page) if not block.notRun]
    lacks = {why for block in blocks for word in block.needs.split(", ") if word and (why := missing[word])}
    able = [block for block in blocks if not any(missing[word] for word in block.needs.split(", ") if word)]
    if able:
        RunBlocks(able, tmp_path, environment)
    if lacks:
        pytest.skip("; ".join(sorted(lacks)))


def test_a_command_that_fails_is_noticed(build, cache, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("    hdstream devices\n    hdstream info missing.usd\n    hdstream devices\n")
    folder = tmp_path / "checkout"
    folder.mkdir()
    with pytest.raises(AssertionError, match="page.md:1.*exit code 1"):
        RunBlocks(Blocks(page), folder, {**MakeCheckout(folder, build), "HDSTREAM_CACHE_DIR": str(cache)})


def test_commands_in_running_text_exist():
    """Scripts are there, and they and `hdstream` have the options that the text gives them."""
    known = {"hdstream": "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "hdStream/python/hdstream").glob("*.py"))
             + (ROOT / "docs/settings.md").read_text(encoding="utf-8")}
    wrong = []
    for page in PAGES:
        for command in InlineCommands(page):
            words = command.split()
            script = next((word for word in words if word.startswith("testenv/")), "hdstream")
            if script not in known:
                path = ROOT / script
                files = sorted(path.rglob("*.py")) if path.is_dir() else [path] * path.is_file()
                known[script] = "\n".join(file.read_text(encoding="utf-8") for file in files)
            options = re.findall(r"(?<![\w-])--?[a-zA-Z]\w*", command)
            if not known[script] or any(option not in known[script] for option in options):
                wrong.append((page.name, command))
    assert not wrong


def _Keys(value, prefix=""):
    """Names of all values below an object: a.b.c."""
    if not isinstance(value, dict):
        return {prefix}
    return {key for name, below in value.items() for key in _Keys(below, f"{prefix}.{name}" if prefix else name)}


def test_every_key_of_the_statistics_is_explained(tmp_path):
    from hdstream.cli import Main
    (tmp_path / "stage.usda").write_text((ROOT / "testenv/docs/stage.usda").read_text())
    assert Main(["record", str(tmp_path / "stage.usda"), str(tmp_path / "p.exr"), "--imageWidth", "16", "--samples", "1", "--quiet",
                 "--stats", str(tmp_path / "s.json")]) == 0
    keys = _Keys(json.loads((tmp_path / "s.json").read_text()))
    table = (ROOT / "docs/statistics.md").read_text(encoding="utf-8").split("## Every key")[1]
    explained = [name for row in re.findall(r"^\| (`.+?) \|", table, re.MULTILINE) for name in re.findall(r"`([^`]+)`", row)]
    assert set(explained) == keys
    assert len(explained) == len(set(explained))


def test_links_lead_somewhere():
    """Files and headings that pages link to are there; every page is in the index docs/README.md."""
    slug = lambda heading: re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
    broken = []
    for page in PAGES:
        text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if target.startswith(("http://", "https://")):
                continue
            name, _, anchor = target.partition("#")
            path = (page.parent / name).resolve() if name else page
            headings = [slug(line.lstrip("#")) for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#")] \
                if anchor and path.is_file() else [anchor]
            if not path.exists() or anchor not in headings:
                broken.append((page.name, target))
    assert not broken
    index = (ROOT / "docs/README.md").read_text(encoding="utf-8")
    assert not [page.name for page in PAGES if page.parent.name == "docs" and page.name != "README.md" and f"({page.name}" not in index]
