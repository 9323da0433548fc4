# SPDX-License-Identifier: Apache-2.0
"""What is shown on stderr: a bar with what is done before rays, then samples a pixel, the share that is done, the time left;
warnings."""

import os
import shutil
import sys
import threading
import time

from hdstream import _core
from hdstream.console import SayWarning, Write
from hdstream.texts import SecondsText

_INTERVAL = 0.2  # seconds between redraws


class ProgressBar:
    """Draws on a terminal, or when HDSTREAM_PROGRESS=1; else does nothing. Any one thread a time. `with` removes it at the end."""

    def __init__(self, isQuiet, label=""):
        isWanted = sys.stderr.isatty() or os.environ.get("HDSTREAM_PROGRESS") == "1"
        self._isShown = isWanted and not isQuiet
        self._label = f"{label} " if label else ""
        self._lastDraw = 0.0
        self._length = 0
        self._start = time.monotonic()
        self._beginning = ""  # what of `Begin` was said last, until there are samples
        self._beginningStart = 0.0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.Clear()

    def Begin(self, what, done=0, total=0):
        """What is done before there are samples, and how much of it, if that is known; may be called again while it goes on."""
        now = time.monotonic()
        if what != self._beginning or not self._length:
            self._beginningStart = self._beginningStart if what == self._beginning else now
            self._beginning = what
            self._lastDraw = 0.0  # it may be said only once, soon after something else
        if not total:
            self.Show(0.0, f"{what}, {SecondsText(now - self._start)}")
            return
        left = (now - self._beginningStart) * (total - done) / done if done else None
        text = f", {SecondsText(left)} left" if left is not None else ""
        self.Show(done / total, f"{what}: {done} of {total}{text}")

    def Prepare(self, progress):
        """What is done for a scene before there are samples."""
        for what, count in (("making textures", progress.textures), ("making pages of chunks", progress.chunks),
                            ("planning prims", progress.prims)):
            if count.done < count.total:
                self.Begin(what, count.done, count.total)
                return
        self.Begin("preparing the scene")

    def Update(self, progress):
        if self._beginning:
            self._beginning = ""
            self._lastDraw = 0.0  # short renders have no second one
        self.Show(progress.fraction, f"{progress.samplesDone}/{progress.samplesTotal} samples, "
                                     f"{SecondsText(progress.secondsLeft)} left")

    def Show(self, fraction, text):
        """`fraction` of the work is done, which `text` says in words."""
        now = time.monotonic()
        if not self._isShown or now - self._lastDraw < _INTERVAL:
            return
        self._lastDraw = now
        percent = f"{100.0 * fraction:3.0f}% "
        room = shutil.get_terminal_size().columns - len(self._label) - len(percent) - len(text) - 4
        bar = ""
        if room >= 10:
            cells = min(room, 40)
            done = int(round(cells * min(1.0, fraction)))
            bar = "[" + "#" * done + "." * (cells - done) + "] "
        self._Draw(self._label + percent + bar + text)

    def Clear(self):
        """Removes the bar, so that a line can be written."""
        if self._isShown and self._length:
            self._Draw("")

    def _Draw(self, line):
        Write(sys.stderr, "\r" + line.ljust(self._length) + ("\r" if not line else ""))
        self._length = len(line)


class WarningPrinter:
    """Shows a warning once, however many frames have it: as it comes, or one line a kind when its block or `Flush` ends."""

    def __init__(self, progress, isVerbose=False):
        self._progress = progress
        self._isVerbose = isVerbose or os.environ.get("HDSTREAM_VERBOSE") == "1"
        self._lines = set()
        self._waiting = []
        self._lock = threading.Lock()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.Flush()

    def __call__(self, line):
        with self._lock:
            if line in self._lines:
                return
            self._lines.add(line)
            self._waiting.append(line)
        if self._isVerbose:
            self.Flush()

    def Flush(self):
        """Shows those that wait. Any thread."""
        with self._lock:
            lines, self._waiting = self._waiting, []
        if lines:
            self._progress.Clear()
        for line in lines if self._isVerbose else _core.DigestWarnings(lines):
            SayWarning(line)
