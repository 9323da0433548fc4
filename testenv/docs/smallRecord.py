# SPDX-License-Identifier: Apache-2.0
"""`hdstream`, as documented commands find it in tests: pictures of `record` are 32 pixels wide and of two samples."""

import sys

from hdstream.cli import Main

if __name__ == "__main__":
    arguments = sys.argv[1:]
    isPicture = arguments[:1] == ["record"] and len(arguments) > 2
    sys.exit(Main(arguments + (["--imageWidth", "32", "--samples", "2"] if isPicture else [])))
