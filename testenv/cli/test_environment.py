# SPDX-License-Identifier: Apache-2.0
"""No variable is added to the environment beside the thread that opens the device: that moves the table of all variables, which
getenv in another thread may be reading. One of some hundred commands ended by it."""

import os
import subprocess
import sys

from cliCase import SMALL, WriteStage

_PROGRAM = """
import ctypes, sys
from hdstream import warmth
from hdstream.cli import Main

def Names():
    table = ctypes.POINTER(ctypes.c_char_p).in_dll(ctypes.CDLL(None), "environ")
    names = set()
    i = 0
    while table[i] is not None:
        names.add(table[i].split(b"=")[0].decode())
        i += 1
    return names

before, added, Enter = set(), set(), warmth.Warmth.__enter__

def Note(self):
    before.update(Names())
    sys.addaudithook(lambda event, args: added.add(args[0].decode()) if event == "os.putenv" else None)
    return Enter(self)

warmth.Warmth.__enter__ = Note
code = Main(sys.argv[1:])
print("added:", *sorted((Names() | added) - before))
sys.exit(code if before else 3)
"""


def test_record_adds_nothing_once_threads_run(tmp_path):
    environment = {name: value for name, value in os.environ.items()
                   if not name.startswith(("OPENBLAS", "HWLOC", "POCL_WORK"))}
    run = subprocess.run([sys.executable, "-c", _PROGRAM, "record", str(WriteStage(tmp_path)), str(tmp_path / "o.exr"), *SMALL],
                         capture_output=True, text=True, timeout=300, env=environment)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.splitlines()[-1] == "added:"
