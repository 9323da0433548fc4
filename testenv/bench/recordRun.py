# SPDX-License-Identifier: Apache-2.0
"""`hdstream record` in a process of its own, for benches: its statistics, so that times and memory are of one render.
Run them with PYTHONPATH=build/release/python."""

import json
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time

SECONDS = 3600


class RunFailed(RuntimeError):
    """The command's own message."""


def Record(stage, cacheDirectory, limitSeconds=SECONDS, environment=None, onPoll=None, through=(), **options) -> dict:
    """Statistics of one render; options by their name on the command line, None for one without a value. Added are
    `pictureBytes`, and `cpuSeconds` of the whole process, which other work on the machine disturbs less than it does times.
    One at a time. `environment` is added to this process's own; `onPoll(process id)` is called every 20 ms, and ends the
    process with SIGKILL when it raises; `through` is a command that runs the command."""
    with tempfile.TemporaryDirectory() as folder:
        picture, statistics = f"{folder}/picture.exr", f"{folder}/statistics.json"
        command = [*through, sys.executable, "-m", "hdstream", "record", str(stage), picture, "--quiet", "--stats", statistics,
                   "--cacheDir", str(cacheDirectory)]
        for name, value in options.items():
            command += [f"--{name}"] if value is None else [f"--{name}", str(value)]
        before = _CpuSecondsOfChildren()
        try:
            code, said = _Run(command, limitSeconds, {**os.environ, **(environment or {})}, onPoll)
        except subprocess.TimeoutExpired as error:
            raise RunFailed(f"not done after {limitSeconds} s") from error
        if code != 0:
            raise RunFailed(f"exit code {code}: {said.strip().splitlines()[-1:]}")
        values = json.loads(pathlib.Path(statistics).read_text())
        values["cpuSeconds"] = _CpuSecondsOfChildren() - before
        values["pictureBytes"] = pathlib.Path(picture).read_bytes()
        return values


def _Run(command: list, limitSeconds: float, environment: dict, onPoll) -> tuple[int, str]:
    """(exit code, stderr)."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment) as process:
        end = time.monotonic() + limitSeconds
        try:
            while onPoll and process.poll() is None and time.monotonic() < end:
                onPoll(process.pid)
                time.sleep(0.02)
            said = process.communicate(timeout=max(0.0, end - time.monotonic()))[1]
        except BaseException:
            process.kill()
            raise
    return process.returncode, said


class AnonymousPeak:
    """An `onPoll`: the most memory without pages of files that a process had (RssAnon of /proc), in bytes."""

    def __init__(self):
        self.bytes = 0

    def __call__(self, process: int) -> None:
        try:
            lines = pathlib.Path(f"/proc/{process}/status").read_text().splitlines()
        except OSError:
            return  # it has just ended
        self.bytes = max([self.bytes, *(int(line.split()[1]) * 1024 for line in lines if line.startswith("RssAnon:"))])


def _CpuSecondsOfChildren() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def FreshCache(folder, kernelsFrom="") -> pathlib.Path:
    """An empty cache folder, with the kernels of another one."""
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for kernel in pathlib.Path(kernelsFrom).glob("kernel-*.hdsc") if kernelsFrom else ():
        shutil.copy(kernel, folder)
    return folder


def Segments(cache) -> list:
    return sorted(pathlib.Path(cache).glob("pages-*.hdsp"))


def DropFromMemory(cache) -> bool:
    """Takes the segments out of the system's page cache. False where that cannot be checked or did not work."""
    for path in Segments(cache):
        with open(path, "rb") as file:
            os.fsync(file.fileno())
            os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
    return _ResidentShare(cache) < 0.05


def _ResidentShare(cache) -> float:
    """Part of the segments that lies in memory (fincore of util-linux)."""
    total = resident = 0
    for path in Segments(cache):
        done = subprocess.run(["fincore", "--bytes", "--noheadings", "--output", "RES", str(path)],
                              capture_output=True, text=True)
        if done.returncode != 0:
            return 1.0
        resident += int(done.stdout.split()[0])
        total += path.stat().st_blocks * 512
    return resident / max(1, total)
