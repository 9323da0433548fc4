# SPDX-License-Identifier: Apache-2.0
"""A dask.distributed scheduler and workers as processes, as a farm has them, for tests and benchmarks."""

import contextlib
import json
import os
import pathlib
import subprocess
import sys
import time

SECONDS = 300  # a scheduler that takes longer to start hangs


@contextlib.contextmanager
def Cluster(folder, numWorkers=2, environment=None):
    """The address of a scheduler with worker processes, and these processes by name."""
    address = folder / "scheduler.json"
    processes = {}

    def Start(name, *arguments):
        log = open(folder / f"{name}.log", "wb")  # pylint: disable=consider-using-with
        processes[name] = subprocess.Popen(
            [sys.executable, "-c", f"from distributed.cli.dask_{arguments[0]} import main; main()", *arguments[1:]],
            stdout=log, stderr=subprocess.STDOUT, cwd=folder, env=dict(os.environ, **(environment or {})))

    Start("scheduler", "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
          "--scheduler-file", str(address))
    for index in range(numWorkers):
        Start(f"worker{index}", "worker", "--scheduler-file", str(address), "--nthreads", "1", "--no-nanny",
              "--no-dashboard", "--memory-limit", "0")
    try:
        yield AddressIn(address), processes
    finally:
        for process in processes.values():
            process.kill()
        for process in processes.values():
            process.wait(SECONDS)


def AddressIn(file: pathlib.Path):
    """Waits for the scheduler to say where it is."""
    deadline = time.monotonic() + SECONDS
    while time.monotonic() < deadline:
        with contextlib.suppress(OSError, ValueError):
            return json.loads(file.read_text())["address"]
        time.sleep(0.1)
    raise AssertionError("the scheduler did not start")
