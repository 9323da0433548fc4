# SPDX-License-Identifier: Apache-2.0
"""The commands of README.md and docs/*.md: blocks of them, as they stand in the pages, and a folder in which they run.

A block is fenced as sh, or indented with a line that begins with a program of ours or of a build. The line before it may be
a comment, which no reader sees: `<!-- not run: REASON -->`, or `<!-- needs: OpenUSD -->` (also: `OpenUSD, an X server`).
"""

import os
import pathlib
import re
import stat
import subprocess
import sys
from dataclasses import dataclass

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# Pages whose commands others run.
RUN_ELSEWHERE = {"building.md": "they install and build: testenv/install"}
_COMMAND = re.compile(r"(\w+=\S+ )*(scripts/|testenv/|\.venv/|hdstream |python |usdview |usdrecord |hython |husk |blender |cmake |ctest |ninja "
                      r"|pip |apt-get |dask |export |sudo )")
_MARK = re.compile(r"<!-- (not run|needs): (.+) -->$")
_SHELLS = ("sh", "bash", "shell", "console")
SECONDS = 600  # a page that takes longer hangs
_ARRIVED = "@@ "  # begins the lines by which the shell says which block it is at


@dataclass(frozen=True)
class Block:
    """Commands that stand together in a page."""

    page: str
    line: int  # of the first command, from 1
    text: str
    notRun: str = ""  # the reason
    needs: str = ""


def Blocks(page: pathlib.Path) -> list[Block]:
    """All blocks of commands of a page, in its order."""
    lines = page.read_text(encoding="utf-8").splitlines() + [""]
    blocks, at = [], 0
    while at < len(lines):
        fence = re.match(r"```(\w*)", lines[at])
        start, end = at, at + 1
        if fence:
            while not lines[end].startswith("```"):
                end += 1
            body = lines[start + 1:end]
            isCommands = fence[1] in _SHELLS or (not fence[1] and any(_COMMAND.match(line) for line in body))
            first, at = start + 2, end + 1
        elif lines[at].startswith("    ") and (at == 0 or not lines[at - 1].strip() or _MARK.match(lines[at - 1])):
            while lines[end].startswith("    ") or (not lines[end].strip() and end + 1 < len(lines) and lines[end + 1].startswith("    ")):
                end += 1
            body = [line[4:] for line in lines[start:end]]
            isCommands = any(_COMMAND.match(line) for line in body)
            first, at = start + 1, end
        else:
            at += 1
            continue
        if isCommands:
            before = next((line for line in reversed(lines[:start]) if line.strip()), "")
            mark = _MARK.match(before)
            kind, why = (mark[1], mark[2]) if mark else ("not run" if page.name in RUN_ELSEWHERE else "", RUN_ELSEWHERE.get(page.name, ""))
            blocks.append(Block(page.name, first, "\n".join(body), why if kind == "not run" else "", why if kind == "needs" else ""))
    return blocks


def InlineCommands(page: pathlib.Path) -> list[str]:
    """Commands in running text: `hdstream ...`, `python testenv/...`, `testenv/....py ...`."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    spans = re.findall(r"`([^`\n]+)`", text)
    return [span for span in spans if re.match(r"(hdstream |(\S+=\S+ )*python testenv/|testenv/[^\s*]+\.py)", span)]


def RunBlocks(blocks: list[Block], folder: pathlib.Path, environment: dict) -> None:
    """Runs blocks one after the other in one shell, which ends at the first command that fails; raises AssertionError."""
    script = "\n".join(f"echo '{_ARRIVED}{block.page}:{block.line}'\n{block.text}" for block in blocks)
    done = subprocess.run(["bash", "-eu", "-o", "pipefail", "-c", script], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=SECONDS)
    place = [line for line in done.stdout.splitlines() if line.startswith(_ARRIVED)][-1:]
    assert done.returncode == 0, f"{place}: exit code {done.returncode}\n{done.stdout[-3000:]}"
    assert "Traceback" not in done.stdout, f"{place}\n{done.stdout[-3000:]}"


def _Write(path: pathlib.Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def MakeCheckout(folder: pathlib.Path, build: pathlib.Path, openUsd=None) -> dict:
    """Makes a folder look like a checkout that was built, with the files that pages call STAGE.usd, SHOT.usd, A.exr and so on.
    Returns the environment of a shell in which `hdstream`, `python`, `scripts/render` and, with an OpenUSD, `usdview` and
    `usdrecord` are found. What `record` renders there is 32 pixels wide and has two samples, whatever the command says."""
    programs = folder / ".programs"
    python = f'"{sys.executable}"'
    record = f'exec {python} "{HERE / "smallRecord.py"}" "$@"\n'
    _Write(programs / "hdstream", "#!/bin/bash\n" + record)
    _Write(programs / "python", f'#!/bin/bash\nexec {python} "$@"\n')
    _Write(folder / "scripts" / "render", '#!/bin/bash\nset -- record "$@"\n' + record)
    (folder / "testenv").symlink_to(ROOT / "testenv")
    (folder / "docs").symlink_to(ROOT / "docs")
    (folder / "build").mkdir()
    (folder / "build" / "release").symlink_to(build)
    text = (HERE / "stage.usda").read_text(encoding="utf-8")
    for name in ("STAGE.usd", "SHOT.usd", "STAGE.usda", "scene.usda"):
        (folder / name).write_text(text, encoding="utf-8")
    if openUsd:
        environment = {name: value for name, value in openUsd.Environment().items() if os.environ.get(name) != value and name != "PATH"}
        exports = "".join(f'export {name}="{value}"\n' for name, value in environment.items())
        words = lambda name: " ".join(f'"{word}"' for word in openUsd.Program(name))
        _Write(programs / "usdrecord", f'#!/bin/bash\n{exports}exec {words("usdrecord")} "$@" --imageWidth 32\n')
        _Write(programs / "usdview", f'#!/bin/bash\n{exports}exec xvfb-run -a -s "-screen 0 1280x1024x24 +extension GLX" '
               f'{words("testusdview")} --testScript "{HERE / "viewOnce.py"}" "$@"\n')
    shell = {name: value for name, value in os.environ.items() if name not in ("PXR_PLUGINPATH_NAME", "OCIO")}
    shell["PATH"] = os.pathsep.join([str(programs), shell.get("PATH", "")])
    return shell
