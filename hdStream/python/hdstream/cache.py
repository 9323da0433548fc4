# SPDX-License-Identifier: Apache-2.0
"""`hdstream cache`: where the persistent cache is, how large, and how to empty it."""

from hdstream import _core
from hdstream.texts import BytesText


def Run(args):
    state = _core.InspectCache("")
    if args.clear:
        freed = _core.ClearCache("")
        print(f"{state.directory}: {BytesText(freed)} deleted")
    else:
        print(f"{state.directory}: {BytesText(state.bytes)}")
