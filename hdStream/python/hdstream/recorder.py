# SPDX-License-Identifier: Apache-2.0
"""Frames of one stage rendered and written by this process, with a progress bar and Ctrl-C."""

import threading

from hdstream.console import Say, SayError
from hdstream.frameJob import FrameWriter
from hdstream.framing import FREE_CAMERA_PATH
from hdstream.recordArguments import FramesOf, JobOf
from hdstream.texts import SecondsText
from hdstream.workThread import RunOnThread

_NAMED_CAMERAS = 3  # in the line that says that none of them is used


class Recorder:
    """Renders frames of one stage. Used from the main thread; renders on one of its own."""

    def __init__(self, args, interruption, progress, warn, warmth):
        self._args = args
        self._interruption = interruption
        self._progress = progress
        self._warn = warn
        progress.Begin("reading the stage")
        self._writer = FrameWriter(JobOf(args), warn, warmth)
        self._isFramingNoted = False
        self.frames = FramesOf(args, self._writer.renderer.stage, self._writer.renderer.Warn)

    def Record(self, frame):
        """Renders and writes one frame; False when it was interrupted. Raises KeyboardInterrupt where the frame is whole."""
        files = ", ".join(output.file for output in frame.outputs) or frame.file
        self._progress.Begin("translating the stage")
        if not self._writer.Prepare(frame):
            self._progress.Clear()
            if not self._args.quiet:
                Say(f"{files}: is there already")
            return True
        self._interruption.Check()
        self._NoteFraming()
        if frame is self.frames[-1]:
            self._writer.renderer.ReleaseStage()
        with self._interruption.Held():
            image = self._Render(frame)
            isWritten = self._writer.Finish(frame, image)
        self._warn.Flush()
        if not isWritten:
            SayError(f"hdstream record: {files}: not written, no sample of every pixel is done")
        elif not self._args.quiet:
            done = "" if image.isComplete else " (interrupted)"
            Say(f"{files}: {image.width}x{image.height}, {image.samples} samples, "
                f"{SecondsText(image.statistics['time']['total'])}{done}")
        if image.isComplete:
            self._interruption.Check()
        return image.isComplete

    def _NoteFraming(self):
        """Says once that none of the stage's cameras is used, where nobody has chosen one."""
        renderer = self._writer.renderer
        cameras = renderer.CameraPaths()
        if self._args.quiet or self._isFramingNoted or not cameras or renderer.settings["camera"] != FREE_CAMERA_PATH:
            return
        self._isFramingNoted = True
        more = f" and {len(cameras) - _NAMED_CAMERAS} more" if len(cameras) > _NAMED_CAMERAS else ""
        self._progress.Clear()
        Say(f"the stage is framed from the front; --camera takes {', '.join(cameras[:_NAMED_CAMERAS])}{more}")

    def _Render(self, frame):
        isPrepared = threading.Event()
        isStopping = threading.Event()

        def OnProgress(progress):
            if progress.fraction == 0 and not isStopping.is_set():
                self._progress.Prepare(progress)
            if progress.fraction > 0 and not isPrepared.is_set():  # 0 while the scene is prepared
                isPrepared.set()
                self._warn.Flush()
            if progress.fraction > 0 and not isStopping.is_set():
                self._progress.Update(progress)

        def Stop():
            isStopping.set()
            self._writer.renderer.Cancel()
            self._progress.Clear()
            SayError("hdstream record: interrupted; writing what is rendered so far")

        try:
            return RunOnThread(lambda: self._writer.Render(frame, OnProgress), self._interruption, Stop)
        finally:
            self._progress.Clear()
