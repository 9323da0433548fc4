# SPDX-License-Identifier: Apache-2.0
"""Exit codes and the errors that lead to them. A message is one line that names what failed."""

EXIT_OK = 0
EXIT_FAILURE = 1      # rendering, a file, a device or memory failed
EXIT_USAGE = 2        # a wrong option or argument
EXIT_INTERRUPTED = 130  # Ctrl-C, as shells report SIGINT


class CommandError(Exception):
    """Ends the command with a line on stderr and an exit code."""

    def __init__(self, message, exitCode=EXIT_FAILURE):
        super().__init__(OneLine(message))
        self.exitCode = exitCode


def UsageError(message):
    return CommandError(message, EXIT_USAGE)


def OneLine(text):
    """The text with line breaks and runs of blanks made single blanks."""
    return " ".join(str(text).split())
