# SPDX-License-Identifier: Apache-2.0
"""`python -m hdstream` is the command line."""

import sys

from hdstream.cli import Main

if __name__ == "__main__":  # processes that multiprocessing starts read this module too
    sys.exit(Main())
