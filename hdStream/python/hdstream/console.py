# SPDX-License-Identifier: Apache-2.0
"""What the command says on stdout and stderr. Nobody may listen: the reader of a pipe has gone, the disk of a log is full, the
streams were closed. Frames are rendered and written all the same."""

import os
import sys

_STREAMS = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))  # by descriptor


def OpenStreams():
    """Opens those that the caller has closed on the null device. Else the next files have their numbers, and what libraries print
    on them goes into a picture. Letters that the locale lacks are escaped in what is said."""
    for number, (name, mode) in enumerate(_STREAMS):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # gets the lowest free number, which is this one
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, encoding="utf-8", errors="backslashreplace", closefd=False))  # pylint: disable=consider-using-with
        elif mode == "w" and hasattr(getattr(sys, name), "reconfigure"):
            getattr(sys, name).reconfigure(errors="backslashreplace")


def Say(line):
    """A line on stdout."""
    Write(sys.stdout, line + "\n")


def SayError(line):
    """A line on stderr."""
    Write(sys.stderr, line + "\n")


def SayWarning(text):
    """One line on stderr, whatever the names in it hold."""
    SayError("warning: " + " ".join(text.splitlines()))


def Write(stream, text):
    """Writes at once; what cannot be written, and all that comes after it, is dropped."""
    try:
        try:
            stream.write(text)
        except UnicodeEncodeError:  # names of files in a locale that lacks their letters
            stream.write(text.encode("ascii", "backslashreplace").decode("ascii"))
        stream.flush()
    except OSError:
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, stream.fileno())  # which takes what the stream still holds, too
        os.close(nothing)
