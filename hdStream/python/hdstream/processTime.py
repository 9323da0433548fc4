# SPDX-License-Identifier: Apache-2.0
"""How long the process has been running, for the time to the first pixel."""

import os
import time

_IMPORTED = time.monotonic()
_START_FIELD = 19  # of /proc/self/stat after the command's name: starttime, in ticks since boot


def SecondsSinceStart():
    """Seconds since the process began; since this module's import where /proc does not tell."""
    try:
        with open("/proc/self/stat", encoding="ascii", errors="replace") as stream:
            fields = stream.read().rpartition(")")[2].split()
        start = int(fields[_START_FIELD]) / os.sysconf("SC_CLK_TCK")
        return time.clock_gettime(time.CLOCK_BOOTTIME) - start
    except (OSError, AttributeError, ValueError, IndexError):
        return time.monotonic() - _IMPORTED
