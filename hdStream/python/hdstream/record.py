# SPDX-License-Identifier: Apache-2.0
"""`hdstream record`: stage in, images out. Everything that can fail early is checked early.

Modules that read stages are imported when a device has begun to get ready: both take as long.
"""

from hdstream.errors import EXIT_INTERRUPTED, EXIT_OK
from hdstream.interruption import Interruption
from hdstream.progress import ProgressBar, WarningPrinter
from hdstream.warmth import Warmth


def Run(args):
    """Renders all frames; returns the exit code."""
    with Interruption() as interruption:
        if args.scheduler or args.workers:
            return _RunOnFarm(args, interruption)
        with ProgressBar(args.quiet) as progress, WarningPrinter(progress, args.verbose) as warn, Warmth(args, warn) as warmth:
            from hdstream.recordArguments import CheckArguments
            CheckArguments(args)
            from hdstream.recorder import Recorder
            recorder = Recorder(args, interruption, progress, warn, warmth)
            for frame in recorder.frames:
                if not recorder.Record(frame):
                    return EXIT_INTERRUPTED
    return EXIT_OK


def _RunOnFarm(args, interruption):
    from hdstream.farm import RunOnFarm
    from hdstream.recordArguments import CheckArguments
    CheckArguments(args)
    return RunOnFarm(args, interruption)
