# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C that is never lost.

Python raises KeyboardInterrupt wherever the main thread is, also inside callbacks of C++ libraries,
which swallow it. So before there is anything to keep (modules load, the stage is read) the process ends
at once, and later the request is kept as well, and asked for where work can stop. While there is a picture to lose the
request is only kept.
"""

import contextlib
import os
import signal

from hdstream.errors import EXIT_INTERRUPTED


class Interruption:
    """Keeps SIGINT while it is entered. The second one ends the process at once."""

    def __init__(self):
        self.isRequested = False
        self.hasWork = False  # something is rendered that an interruption must not lose
        self._isHeld = False
        self._before = None

    def __enter__(self):
        try:
            self._before = signal.signal(signal.SIGINT, self._OnSignal)
        except ValueError:  # not the main thread: there is no Ctrl-C to see
            self._before = None
        return self

    def __exit__(self, *_):
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)

    @contextlib.contextmanager
    def Held(self):
        """While it is entered an interruption is kept and raises nothing: a frame is rendered and written."""
        self.hasWork = self._isHeld = True
        try:
            yield
        finally:
            self._isHeld = False

    def Check(self):
        """Raises KeyboardInterrupt when one was requested."""
        if self.isRequested:
            raise KeyboardInterrupt

    def _OnSignal(self, number, frame):
        if not self.hasWork:
            os.write(2, b"hdstream: interrupted\n")
        if self.isRequested or not self.hasWork:
            os._exit(EXIT_INTERRUPTED)
        self.isRequested = True
        if not self._isHeld:
            raise KeyboardInterrupt
