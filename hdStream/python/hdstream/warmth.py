# SPDX-License-Identifier: Apache-2.0
"""What a first render needs whatever the stage is, made ready beside the reading of the stage."""

import threading

from hdstream import _core

_SETTINGS = ("device", "cacheDirectory", "noCache", "hostMemory")  # that say what is made ready


class Warmth:
    """A session whose device and kernels are made ready on a thread of its own, from `with` on until the end of its block at
    the latest. What fails is left to the render, which tells of it."""

    def __init__(self, args, onWarning):
        self._session = _core.Session(onWarning)
        settings = _core.Settings()
        for name in _SETTINGS:
            value = getattr(args, name, None)
            if value is not None:
                _core.SetSetting(settings, name, value)
        self._thread = threading.Thread(target=self._session.Warm, args=(settings,), name="warm", daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._thread.join()

    def TakeSession(self):
        """The session, ready. Blocks."""
        self._thread.join()
        return self._session
