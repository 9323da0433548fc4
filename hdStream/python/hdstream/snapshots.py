# SPDX-License-Identifier: Apache-2.0
"""`--snapshot`: a frame as it is, written beside its files while it is rendered, and what `--resume` goes on from."""

import os
import time

SUFFIX = "_part"  # husk's


def PartFileOf(file):
    """Where the snapshot of a file lies."""
    stem, extension = os.path.splitext(file)
    return f"{stem}{SUFFIX}{extension}"


def RemoveParts(files):
    """Of a frame that is written."""
    for file in files:
        try:
            os.remove(PartFileOf(file))
        except OSError:
            pass  # there is none, or nobody may remove it


class Snapshots:
    """A progress callback in front of another: calls `write()` when `seconds` have passed since the last one was written, and
    every pixel has a sample. Used for one frame."""

    def __init__(self, seconds, write, onProgress):
        self._seconds = seconds
        self._write = write
        self._onProgress = onProgress
        self._last = time.monotonic()

    def __call__(self, progress):
        goesOn = self._onProgress is None or self._onProgress(progress) is not False
        if goesOn and progress.previewStride == 1 and time.monotonic() - self._last >= self._seconds:
            self._write()
            self._last = time.monotonic()  # what writing takes does not count
        return goesOn
