# SPDX-License-Identifier: Apache-2.0
"""Text that an option says where to write."""

import errno
import os
import stat

from hdstream.errors import CommandError


def _OpenUnlessWaiting(file, flags):
    """os.open, which of a pipe without a reader would wait for one: ENXIO then. Writing waits for the reader as usual."""
    opened = os.open(file, flags | os.O_NONBLOCK, 0o666)
    os.set_blocking(opened, True)
    return opened


def WriteText(option, file, text):
    """Raises CommandError that names the option."""
    try:
        with open(file, "w", encoding="utf-8", opener=_OpenUnlessWaiting) as stream:
            stream.write(text)
    except OSError as error:
        if error.errno == errno.ENXIO and stat.S_ISFIFO(os.stat(file).st_mode):
            raise CommandError(f"{option} {file}: is a pipe that nobody reads") from None
        raise CommandError(f"{option} {file}: {error.strerror}") from None
