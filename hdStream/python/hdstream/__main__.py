# SPDX-License-Identifier: Apache-2.0
"""`python -m hdstream` is the command line."""

import sys

from hdstream.cli import Main

sys.exit(Main())
