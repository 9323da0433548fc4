# SPDX-License-Identifier: Apache-2.0
"""Sync and edits of the Hydra plug-in beside hdEmbree: benchHydra (testenv/bench/hydraSync.cpp), where OpenUSD's imaging was
found when it was built. Its tables are taken as it prints them."""

import os
import re
import subprocess

from bench.performancePage import LeftOut, Table


def _Tables(text: str) -> list:
    """Heads and rows of tables in Markdown."""
    tables = []
    for block in re.findall(r"(?:^\|.*\|\n?)+", text, re.MULTILINE):
        lines = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in block.strip().splitlines()]
        tables.append((lines[0], lines[2:]))
    return tables


def Run(bench) -> list:
    program = bench.Program("testenv/hydra/benchHydra")
    ours = str(bench.build / "plugin/usd/hdStream/resources")
    theirs = os.environ.get("PXR_PLUGINPATH_NAME", "")  # where the other renderer is
    environment = {**os.environ, "PXR_PLUGINPATH_NAME": f"{theirs}{os.pathsep}{ours}" if theirs else ours}
    # Many small meshes, then 10^6 triangles in few.
    scenes = bench.Pick([["--repeats", "3"], ["--repeats", "3", "--meshes", "100", "--quads", "71"]],
                        [["--meshes", "64", "--quads", "4", "--repeats", "1", "--width", "64"]])
    tables = []
    for scene in scenes:
        done = subprocess.run([program, *scene, "HdStreamRendererPlugin", "HdEmbreeRendererPlugin"], capture_output=True,
                              text=True, env=environment)
        if done.returncode != 0:
            message = (done.stderr.strip() or "no output").splitlines()[-1]
            raise LeftOut(f"benchHydra ended with exit code {done.returncode}: {message}")
        tables += _Tables(done.stdout)
    return [Table(f"hydra-{index}", head, rows) for index, (head, rows) in enumerate(tables)]
