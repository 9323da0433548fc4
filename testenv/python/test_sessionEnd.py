# SPDX-License-Identifier: Apache-2.0
"""A session that ends while one of its threads has something to warn of waits for it, and not for ever."""

import os
import subprocess
import sys

PROGRAM = """
import os, sys, time
from hdstream import _core
lines = []
session = _core.Session(lines.append)
settings = _core.Settings()
_core.SetSetting(settings, "cacheDirectory", sys.argv[1])
session.Warm(settings)
while not os.path.exists(sys.argv[2]):
    time.sleep(0.01)
sys.setswitchinterval(1e6)  # from here on nobody takes the GIL from this thread
until = time.monotonic() + 3.0
while time.monotonic() < until:
    pass  # the compiler fails, and the thread that started it waits for the GIL to tell of it
del session
print(len(lines), lines[0].partition("; ")[2])
"""


def test_a_thread_that_warns_gets_the_gil(tmp_path):
    compiler = tmp_path / "compiler"
    compiler.write_text(f"#!/bin/sh\ntouch {tmp_path}/started\nsleep 0.5\nexit 1\n")
    compiler.chmod(0o700)
    environment = dict(os.environ, HDSTREAM_KERNEL_COMPILER=str(compiler))
    done = subprocess.run([sys.executable, "-c", PROGRAM, str(tmp_path / "cache"), str(tmp_path / "started")],
                          env=environment, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "1 kernels are compiled without it, which takes longer\n"
