# SPDX-License-Identifier: Apache-2.0
"""`hdstream prepare`: fills the persistent cache with all that `hdstream record` with the same words may read of it."""

import dataclasses
import time

from hdstream import _core
from hdstream.console import Say, SayError
from hdstream.errors import EXIT_INTERRUPTED, EXIT_OK
from hdstream.interruption import Interruption
from hdstream.progress import ProgressBar, WarningPrinter
from hdstream.texts import BytesText, SecondsText


def Run(args):
    """Prepares all frames; returns the exit code."""
    with Interruption() as interruption, ProgressBar(args.quiet) as progress, WarningPrinter(progress, args.verbose) as warn:
        from hdstream.frameJob import FrameWriter
        from hdstream.recordArguments import FramesToPrepare, JobOf
        if args.aovs:
            _core.CheckAovs(list(args.aovs))
        progress.Begin("reading the stage")
        writer = FrameWriter(dataclasses.replace(JobOf(args), resumes=False, snapshotSeconds=0.0), warn)
        frames = FramesToPrepare(args, writer.renderer.stage, writer.renderer.Warn)
        for frame in frames:
            start = time.perf_counter()
            progress.Begin("translating the stage")
            writer.Prepare(frame)
            interruption.Check()
            if frame is frames[-1]:
                writer.renderer.ReleaseStage()
            with interruption.Held():
                amount = _Fill(writer.renderer, interruption, progress)
            warn.Flush()
            if amount is None:
                SayError("hdstream prepare: interrupted; what is prepared is kept")
                return EXIT_INTERRUPTED
            if not args.quiet:
                name = f"{args.stage} at {frame.timeCode:g}" if len(frames) > 1 else args.stage
                Say(f"{name}: {_Text(amount)}, {SecondsText(time.perf_counter() - start)}")
    return EXIT_OK


def _Fill(renderer, interruption, progress):
    from hdstream.workThread import RunOnThread
    try:
        return RunOnThread(lambda: renderer.FillCache(progress.Prepare), interruption, renderer.Cancel)
    finally:
        progress.Clear()


def _Text(amount):
    text = f"{amount.chunks} chunks of {BytesText(amount.chunkBytes)}, {amount.chunksBuilt} made"
    return text + (f"; {amount.textures} textures, {amount.texturesBuilt} made" if amount.textures else "")
