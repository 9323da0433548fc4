# SPDX-License-Identifier: Apache-2.0
"""`hdstream cache`: where the persistent cache is, how large, how to empty it, and how to have kernels in it before the
first render."""

from hdstream import _core
from hdstream.console import SayWarning
from hdstream.texts import BytesText


def Run(args):
    if args.clear:
        directory = _core.InspectCache("").directory
        print(f"{directory}: {BytesText(_core.ClearCache(''))} deleted")
        return
    if args.kernels is not None:
        for line in _core.PrepareKernels(args.kernels, ""):
            SayWarning(line)
    state = _core.InspectCache("")
    print(f"{state.directory}: {BytesText(state.bytes)}")
