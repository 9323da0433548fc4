# SPDX-License-Identifier: Apache-2.0
"""`hdstream cache`: where the persistent cache is, how large, what is in it by stage, how to empty it, and how to have kernels
in it before the first render."""

from hdstream import _core
from hdstream.console import SayWarning
from hdstream.texts import BytesText


def Run(args):
    if args.clear:
        directory = _core.InspectCache(args.cacheDir).directory
        print(f"{directory}: {BytesText(_core.ClearCache(args.cacheDir))} deleted")
        return
    if args.kernels is not None:
        for line in _core.PrepareKernels(args.kernels, args.cacheDir):
            SayWarning(line)
    state = _core.InspectCache(args.cacheDir)
    print(f"{state.directory}: {BytesText(state.bytes)}")
    for stage in state.stages:
        print(_Line(stage.file, stage.pages, stage.bytes))
    if state.otherPages:
        print(_Line("of no stage that is known", state.otherPages, state.otherBytes))


def _Line(name, pages, size):
    return f"{BytesText(size):>12} {pages:>10} pages  {' '.join(name.splitlines())}"
