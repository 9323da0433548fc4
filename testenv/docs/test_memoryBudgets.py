# SPDX-License-Identifier: Apache-2.0
"""The bench behind docs/memory-budgets.md: charts, tables, and prose that stays as it is."""

import os
import re
import subprocess
import sys

from documentedCommands import ROOT


def test_the_short_form_fills_the_page(cache, tmp_path):
    done = subprocess.run([sys.executable, ROOT / "testenv/bench/budgets.py", "--out", tmp_path, "--short"], capture_output=True,
                          text=True, env=dict(os.environ, HDSTREAM_CACHE_DIR=str(cache)), timeout=600)
    assert done.returncode == 0, done.stderr
    page, ours = (folder.joinpath("memory-budgets.md").read_text(encoding="utf-8") for folder in (tmp_path, ROOT / "docs"))
    blocks = re.compile(r"(<!-- begin (\w+) -->\n).*?(<!-- end \2 -->)", re.DOTALL)
    assert blocks.sub("", page) == blocks.sub("", ours)
    for kind in ("geometry", "texture"):
        block = next(match[0] for match in blocks.finditer(page) if match[2] == kind)
        assert re.search(r"^\| 50 \|", block, re.MULTILINE)
        for chart in (f"images/budgets-{kind}-time.svg", f"images/budgets-{kind}-traffic.svg"):
            assert chart in block and (tmp_path / chart).read_text().startswith("<svg")
