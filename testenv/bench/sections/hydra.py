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
    environment = {**os.environ, "PXR_PLUGINPATH_NAME": str(bench.build / "plugin/usd/hdStream/resources")}
    sizes = bench.Pick([], ["--meshes", "64", "--quads", "4", "--repeats", "1", "--width", "64"])
    done = subprocess.run([program, *sizes, "HdStreamRendererPlugin", "HdEmbreeRendererPlugin"], capture_output=True, text=True,
                          env=environment)
    if done.returncode != 0:
        raise LeftOut(f"benchHydra ended with exit code {done.returncode}: {(done.stderr.strip() or 'no output').splitlines()[-1]}")
    return [Table(f"hydra-{index}", head, rows) for index, (head, rows) in enumerate(_Tables(done.stdout))]
