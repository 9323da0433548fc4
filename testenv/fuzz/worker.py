# SPDX-License-Identifier: Apache-2.0
"""The process that runs cases: worker.py KIND SEED FOLDER; reads numbers of cases from stdin, writes a line of JSON for
each to stdout. What libraries print goes to stderr. Started by driver.py, which sets its limits."""

import json
import os
import pathlib
import sys

_TESTENV = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(_TESTENV / "fuzz"), str(_TESTENV)]

from kinds import KINDS  # noqa: E402


def _ResidentBytes() -> int:
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def Main(name, seed, folder) -> None:
    reports = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    os.chdir(folder)
    kind = KINDS[name](folder, int(seed))
    for line in sys.stdin:
        wrong = kind.Run(int(line))
        reports.write(json.dumps({"wrong": wrong, "bytes": _ResidentBytes()}) + "\n")
        reports.flush()


if __name__ == "__main__":
    Main(*sys.argv[1:])
