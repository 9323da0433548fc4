# SPDX-License-Identifier: Apache-2.0
"""A renderer's stage: how it is opened, how frames of it are prepared, how it is let go (docs/python.md)."""

import os
import time

from pxr import Usd

from hdstream import _core
from hdstream.diagnostics import Diagnostics
from hdstream.errors import EXIT_USAGE, CommandError
from hdstream.framing import FindCamera
from hdstream.frameSetup import Framing, FrameTime, MakeSettings, ShutterOf
from hdstream.materialXFiles import UnreadFiles
from hdstream.renderSettings import ReadRenderSettings, SettingsPathOf
from hdstream.stage import OpenStage
from hdstream.translate import rereading
from hdstream.translate.stageEdits import StageTranslation

LARGE_STAGE = 10_000  # prims; opening a part of a smaller one takes more time than its memory is worth


class Frame:
    """What is to be rendered."""

    def __init__(self, settings, camera, frameTime, translateSeconds):
        self.settings = settings
        self.camera = camera
        self.frameTime = frameTime
        self.translateSeconds = translateSeconds


class PreparedStage:
    """A stage whose frames are brought into a session. One thread at a time, the one that edits the stage.

    `stage` and `mask` as of Renderer. `stage`: what is left of it after `Release`. Raises what Renderer raises.
    """

    def __init__(self, stage, mask, session):
        self._session = session  # the first of what is here: it goes before the layers whose arrays it has
        self._diagnostics = Diagnostics()
        start = time.perf_counter()
        self._isOwn = not isinstance(stage, Usd.Stage)
        if isinstance(mask, str):
            raise _core.UsageError(f"mask {mask}: must be a list of prim paths")
        if mask and not self._isOwn:
            raise _core.UsageError("mask: for paths of stages only; a stage that is open has its own (Usd.Stage.SetPopulationMask)")
        self._isReleased = False
        self._mappedLayers = []  # after the release
        self._numPrims = 0  # visited
        self.frame = None  # the one that is prepared
        unread = []
        if self._isOwn:
            self._name = os.fspath(stage)
            self.stage = _Raising(OpenStage, self._name, mask)
        else:
            self.stage, self._name = stage, stage.GetRootLayer().identifier
            unread = [(file, "is not read in a stage that the caller opened, whose layers that would edit; give hdstream.Renderer "
                       "the stage's path, and edit its `stage`") for file in UnreadFiles(stage)]
        self.loadSeconds = time.perf_counter() - start
        session.SetStageFile(self.stage.GetRootLayer().realPath)
        warn, found = session.Warn, self._diagnostics.Take() + unread
        # Of opening the stage; the statistics of each frame have it. No method: the stage goes with its renderer.
        self._translation = StageTranslation(self.stage, session, lambda: [warn(subject, text) for subject, text in found])

    def Prepare(self, timeCode, values, renderSettingsPrimPath, renderProductPrimPath, renderPassPrimPath, crop):
        """Makes `frame`. `values`: settings by name. All as of Renderer.Prepare."""
        if timeCode is None:
            timeCode = self.stage.GetStartTimeCode()
        if self._isReleased:
            raise _core.UsageError("the stage has been released: nothing else can be prepared of it")
        self.frame = None  # what went wrong leaves nothing to render
        self.frame = _Raising(self._MakeFrame, Usd.TimeCode(timeCode), values, renderSettingsPrimPath, renderProductPrimPath,
                              renderPassPrimPath, crop)

    def Release(self):
        """As Renderer.ReleaseStage, once a frame is prepared."""
        if not self._isOwn:
            raise _core.UsageError("ReleaseStage: the stage was opened by the caller, who may let it go")
        if not self._isReleased and self._numPrims >= LARGE_STAGE:
            self._mappedLayers = self._translation.Release()
            self._translation = None  # it would keep the session longer than the layers
            self.stage = rereading.MoveToPart(self.stage)
            self._diagnostics.Take()  # was said when the stage was opened
        self._isReleased = True

    def _MakeFrame(self, timeCode, values, renderSettingsPrimPath, renderProductPrimPath, renderPassPrimPath, crop):
        start = time.perf_counter()
        settingsPath = SettingsPathOf(self.stage, renderSettingsPrimPath, renderPassPrimPath, self._session)
        renderSettings = ReadRenderSettings(self.stage, settingsPath, self._session, renderProductPrimPath)
        cameraPrim = FindCamera(self.stage, values.get("camera"), renderSettings.camera)
        settings = MakeSettings(values, renderSettings, self._session.Warn)
        shutter = ShutterOf(cameraPrim, timeCode, settings)
        self._numPrims = max(self._numPrims, self._translation.Update(timeCode, shutter, renderPassPrimPath or ""))
        self._diagnostics.WarnOf(self._session)
        if self._session.Scene().isEmpty:
            self._session.Warn(self._name, "the stage has nothing to draw")
        framing = Framing(self.stage, self._session, renderSettings, values.get("imageWidth"),
                          values.get("imageHeight"), crop)
        camera = framing.SetCamera(cameraPrim, timeCode, shutter, settings)
        if settings.cameraMoves:
            self._session.Redice()  # as for a fresh renderer; else surfaces are diced for each picture's camera
        return Frame(settings, camera, FrameTime.Of(self.stage, timeCode), time.perf_counter() - start)


def _Raising(function, *arguments):
    """Errors of the front end as the core's classes, which are the ones of the package."""
    try:
        return function(*arguments)
    except CommandError as error:
        kind = _core.UsageError if error.exitCode == EXIT_USAGE else _core.Error
        raise kind(str(error)) from None
