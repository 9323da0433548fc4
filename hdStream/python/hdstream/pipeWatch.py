# SPDX-License-Identifier: Apache-2.0
"""Layers that are pipes: OpenUSD would wait for a writer, and with it the command, without a word.

Nobody knows what a stage refers to before OpenUSD has read it. So a thread looks, while a stage is opened, in which system
call the others are (Linux; elsewhere it does nothing). A pipe that one of them waits to open is opened for writing and closed
again: its reader goes on with an empty file, which OpenUSD says is no layer.

Of value clips that is not enough. OpenUSD raises an error there, and opens others only when it reads a value, with Python's
lock held. So an empty layer stands in for such a pipe: who opens its path gets that.
"""

import contextlib
import os
import platform
import stat
import threading

from pxr import Sdf

IS_PIPE = "is a pipe, not a file: nothing is read of it"
_SECONDS = 0.5
_OPEN_CALLS = {"x86_64": ("257",), "aarch64": ("56",)}.get(platform.machine(), ())  # openat(folder, name, ...)
_MOST_BYTES = 4096  # of a path
_standIns = {}  # layers by the pipe's path; OpenUSD finds them as long as somebody has them


def IsPipe(path):
    """Whether opening a path waits for whoever writes it."""
    try:
        return stat.S_ISFIFO(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def StandIn(path):
    """Puts an empty layer in the place of a pipe that no layer is open of, for the rest of the process."""
    if path not in _standIns and not Sdf.Layer.Find(path):
        _standIns[path] = Sdf.Layer.New(Sdf.FileFormat.FindByExtension("usda"), path)


class Pipes:
    """The pipes that were met, each path once."""

    def __init__(self):
        self.paths = []
        self._isOver = threading.Event()

    def End(self):
        self._isOver.set()

    def Watch(self):
        """Until End. Errors are those of threads that have ended or of calls that are over."""
        while not self._isOver.wait(_SECONDS):
            for thread in os.listdir("/proc/self/task"):
                with contextlib.suppress(OSError, ValueError):
                    self._Release(_OpenedBy(thread))

    def _Release(self, path):
        if path and IsPipe(path):
            os.close(os.open(path, os.O_WRONLY | os.O_NONBLOCK))
            if path not in self.paths:
                self.paths.append(path)


def _OpenedBy(thread):
    """What a thread opens, if it does. The name is read by way of the kernel: it may be gone by now."""
    with open(f"/proc/self/task/{thread}/syscall", encoding="ascii") as file:
        words = file.read().split()
    if not words or words[0] not in _OPEN_CALLS:
        return None
    with open("/proc/self/mem", "rb", buffering=0) as memory:
        memory.seek(int(words[2], 16))
        return os.fsdecode(memory.read(_MOST_BYTES).split(b"\0")[0])


@contextlib.contextmanager
def Watched():
    """Gives the Pipes that are met in its block."""
    pipes = Pipes()
    if not _OPEN_CALLS or not os.access("/proc/self/syscall", os.R_OK):
        yield pipes
        return
    thread = threading.Thread(target=pipes.Watch, daemon=True)
    try:
        thread.start()
    except RuntimeError:  # no more threads are allowed
        yield pipes
        return
    try:
        yield pipes
    finally:
        pipes.End()
        thread.join()
