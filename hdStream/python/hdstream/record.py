# SPDX-License-Identifier: Apache-2.0
"""`hdstream record`: stage in, images out. Everything that can fail early is checked early."""

import json
import os
import sys
import threading
import time

import numpy as np

from hdstream import _core
from hdstream.denoiser import FindDenoiser
from hdstream.errors import EXIT_INTERRUPTED, EXIT_OK, CommandError, UsageError
from hdstream.interruption import Interruption
from hdstream.processTime import SecondsSinceStart
from hdstream.progress import ProgressBar
from hdstream.texts import SecondsText

_DEFAULT_WIDTH = 960
# Settings that _SetCamera completes from the camera and the render settings prim.
_FRAMED = ("camera", "imageWidth", "imageHeight")


def Run(args):
    """Renders all frames; returns the exit code."""
    with Interruption() as interruption:
        recorder = Recorder(args, interruption)
        for timeCode in recorder.outputs.timeCodes:
            if not recorder.Record(timeCode):
                return EXIT_INTERRUPTED
    return EXIT_OK


class Recorder:
    """Renders frames of one stage. Used from the main thread; renders on one of its own."""

    def __init__(self, args, interruption):
        from hdstream.diagnostics import Diagnostics
        from hdstream.stage import FrameOutputs, OpenStage
        self._args = args
        self._interruption = interruption
        self._progress = ProgressBar(args.quiet)
        # Not a method: a cycle through the session would be kept for ever.
        self._session = _core.Session(_WarningPrinter(self._progress))
        self._CheckArguments()
        self._diagnostics = Diagnostics()
        start = time.perf_counter()
        self._stage = OpenStage(args.stage, args.mask)
        self._loadSeconds = time.perf_counter() - start
        self.outputs = FrameOutputs(self._stage, args.frames, args.defaultTime, args.output)
        for timeCode in self.outputs.timeCodes:
            _core.CheckImageFile(self.outputs.FileOf(timeCode))
        self._stageWarnings = self._diagnostics.Take()
        self._renderSettings = None

    def Record(self, timeCode):
        """Renders and writes one frame; False when it was interrupted."""
        from hdstream.framing import FindCamera
        from hdstream.renderSettings import ReadRenderSettings
        from hdstream.translate import TranslateStage
        start = time.perf_counter()
        self._session.Clear()
        self._WarnOfStage()
        self._renderSettings = ReadRenderSettings(self._stage, self._args.renderSettingsPrimPath, self._session)
        cameraPrim = FindCamera(self._stage, self._args.camera, self._renderSettings.camera)
        TranslateStage(self._stage, self._session, timeCode)
        self._diagnostics.WarnOf(self._session)
        if not self._session.Scene().meshes:
            self._session.Warn(self._args.stage, "the stage has nothing to draw")
        settings = self._MakeSettings()
        camera = self._SetCamera(cameraPrim, timeCode, settings)
        self._session.SetFrontEndTimes(self._loadSeconds, time.perf_counter() - start, SecondsSinceStart())
        self._interruption.Check()
        isComplete = self._Render(settings)
        self._Write(self.outputs.FileOf(timeCode), timeCode, settings, camera, isComplete)
        return isComplete

    def _WarnOfStage(self):
        """What holds for all frames; the statistics of each have it."""
        for subject, text in self._stageWarnings:
            self._session.Warn(subject, text)

    # --- Settings --------------------------------------------------------------------------------

    def _CheckArguments(self):
        """Whatever needs no stage."""
        args = self._args
        known = [info.name for info in _core.AovTable()]
        for name in args.aovs or ():
            if name not in known:
                raise UsageError(f"--aovs {name}: none of {', '.join(known)}")
        if args.aovs is not None and not args.aovs:
            raise UsageError("--aovs: no names")
        if "#" not in args.output:
            _core.CheckImageFile(args.output)
        FindDenoiser()
        if args.denoise:
            _core.CheckDenoiser()
        if args.stats:
            folder = os.path.dirname(args.stats) or "."
            if not os.path.isdir(folder) or os.path.isdir(args.stats) or not os.access(folder, os.W_OK):
                raise CommandError(f"--stats {args.stats}: cannot be written")

    def _MakeSettings(self):
        """The core's settings: the command line's, else the render settings prim's, else defaults."""
        args = self._args
        prim = self._renderSettings
        settings = _core.Settings()
        for name, value in prim.values.items():
            _core.SetSetting(settings, name, value)
        settings.purposes = list(_WithDefault(prim.purposes) or settings.purposes)
        if prim.aovs:
            settings.aovs = prim.aovs
        if prim.pixelAspectRatio:
            settings.pixelAspectRatio = prim.pixelAspectRatio
        for info in _core.SettingTable():
            value = getattr(args, info.name, None)
            if value is not None and info.name not in _FRAMED:
                _core.SetSetting(settings, info.name, value)
        return settings

    def _SetCamera(self, prim, timeCode, settings):
        """Puts the render camera into the scene, completes the settings; returns the camera."""
        from pxr import Gf, Usd, UsdGeom
        from hdstream.diagnostics import MessagesOf, TfError
        from hdstream.framing import FREE_CAMERA_PATH, MakeFramingCamera
        from hdstream.translate.cameras import CameraFromGf, ReadCamera
        usdTime = Usd.TimeCode(timeCode)
        if prim is None:
            gfCamera = MakeFramingCamera(self._stage, usdTime, settings.purposes)
            camera = CameraFromGf(gfCamera)
            settings.camera = FREE_CAMERA_PATH
        else:
            settings.camera = prim.GetPath().pathString
            try:
                gfCamera = UsdGeom.Camera(prim).GetCamera(usdTime)
                camera = ReadCamera(prim, usdTime)
            except TfError as error:
                raise CommandError(f"camera {settings.camera} cannot be read: {'; '.join(MessagesOf(error))}") from None
        if not camera.horizontalAperture > 0.0 or not camera.verticalAperture > 0.0:
            self._session.Warn(settings.camera, "aperture is not above 0; 20.955 x 15.2908 is used")
            gfCamera = Gf.Camera()
            camera.horizontalAperture, camera.verticalAperture = 2.0955, 1.52908
        if self._renderSettings.disableDepthOfField:
            camera.fStop = 0.0
        self._SetImageSize(gfCamera.aspectRatio, settings)
        self._SetDataWindow(settings)
        self._session.SetCamera(settings.camera, camera)
        return camera

    def _SetImageSize(self, aspect, settings):
        """usdrecord's rule: the height follows from the width and the camera's aspect ratio."""
        resolution = self._renderSettings.resolution
        width, height = self._args.imageWidth, self._args.imageHeight
        if width is None and height is None and resolution:
            width, height = resolution
        width = width or _DEFAULT_WIDTH
        if height is None:
            # As usdrecord: cut off, computed with floats; what the rounding leaves is the width's.
            pixels = np.float32(settings.pixelAspectRatio) * np.float32(width)
            height = max(1, int(pixels / np.float32(aspect)))
            settings.conformPolicy = "adjustApertureWidth"
        settings.conformPolicy = self._renderSettings.conformPolicy or settings.conformPolicy
        _core.SetSetting(settings, "imageWidth", width)
        _core.SetSetting(settings, "imageHeight", height)

    def _SetDataWindow(self, settings):
        """The render settings' data window: the image is that part of the full image."""
        from hdstream.renderSettings import DataWindow
        windowNDC = self._renderSettings.dataWindowNDC
        if windowNDC is None:
            return
        width, height = settings.imageWidth, settings.imageHeight
        left, top, right, bottom = DataWindow(windowNDC, width, height)
        if right <= left or bottom <= top:
            self._session.Warn(self._renderSettings.path, "dataWindowNDC holds no pixel; ignored")
            return
        settings.displayWindow = [0.0, 0.0, float(width), float(height)]
        settings.dataWindowMin = [left, top]
        settings.imageWidth, settings.imageHeight = right - left, bottom - top

    # --- Rendering -------------------------------------------------------------------------------

    def _Render(self, settings):
        """Renders on a thread, so that Ctrl-C is seen at once; True when it was not interrupted."""
        isStopping = threading.Event()
        isDone = threading.Event()
        outcome = []

        def OnProgress(progress):
            # There is something to show, and to write, once every pixel has a sample.
            if progress.previewStride == 1 and not isStopping.is_set():
                self._progress.Update(progress)
            return not isStopping.is_set()

        def Work():
            try:
                self._session.Render(settings, OnProgress)
            except BaseException as error:  # pylint: disable=broad-except
                outcome.append(error)
            finally:
                isDone.set()

        self._interruption.hasWork = True
        threading.Thread(target=Work, name="render", daemon=True).start()
        # Not Thread.join: when it is interrupted, Python 3.11 takes the thread for finished.
        while not isDone.is_set():
            try:
                isDone.wait(0.1)
            except KeyboardInterrupt:
                pass  # kept by the interruption
            if self._interruption.isRequested and not isStopping.is_set():
                isStopping.set()
                self._progress.Clear()
                print("hdstream record: interrupted; writing what is rendered so far", file=sys.stderr)
        self._progress.Clear()
        if outcome and isStopping.is_set() and not self._session.HasImage():
            # The compiler in the device's driver removes its files at SIGINT, and fails for want of them.
            raise KeyboardInterrupt from outcome[0]
        if outcome:
            raise outcome[0]
        return not isStopping.is_set()

    # --- Results ---------------------------------------------------------------------------------

    def _Write(self, file, timeCode, settings, camera, isComplete):
        statistics = self._session.Statistics() if self._session.HasImage() else ""
        values = json.loads(statistics) if statistics else None
        if not isComplete and (values is None or values["image"]["samples"] == 0):
            print(f"hdstream record: {file}: not written, no sample of every pixel is done", file=sys.stderr)
            return
        left = _core.WriteImage(file, self._session.Layers(), self._args.colorCorrectionMode,
                                _MakeMetadata(settings, camera))
        if left:
            self._session.Warn(file, f"no room in this format for {', '.join(left)}; use .exr")
        if self._args.stats:
            statsFile = self.outputs.StatsFileOf(self._args.stats, timeCode)
            _WriteText("--stats", statsFile, statistics)
        if not self._args.quiet:
            done = "" if isComplete else " (interrupted)"
            print(f"{file}: {settings.imageWidth}x{settings.imageHeight}, "
                  f"{values['image']['samples']} samples, {SecondsText(values['time']['total'])}{done}")


class _WarningPrinter:
    """Shows a warning once, however many frames have it."""

    def __init__(self, progress):
        self._progress = progress
        self._lines = set()

    def __call__(self, line):
        if line not in self._lines:
            self._lines.add(line)
            self._progress.Clear()
            print(f"warning: {line}", file=sys.stderr)


def _WriteText(option, file, text):
    try:
        with open(file, "w", encoding="utf-8") as stream:
            stream.write(text)
    except OSError as error:
        raise CommandError(f"{option} {file}: {error.strerror}") from None


def _WithDefault(purposes):
    if purposes is None:
        return None
    return ["default"] + [purpose for purpose in purposes if purpose != "default"]


def _MakeMetadata(settings, camera):
    """What the EXR says of the camera, in Gf's convention (row vectors), as OpenEXR's own names."""
    from pxr import Gf
    gfCamera = Gf.Camera()
    gfCamera.transform = Gf.Matrix4d(camera.worldFromCamera.tolist())
    gfCamera.projection = Gf.Camera.Orthographic if camera.orthographic else Gf.Camera.Perspective
    for name in ("horizontalAperture", "verticalAperture", "horizontalApertureOffset",
                 "verticalApertureOffset", "focalLength"):
        setattr(gfCamera, name, 10.0 * getattr(camera, name))  # tenths of a scene unit
    gfCamera.clippingRange = Gf.Range1f(camera.nearClip, camera.farClip)
    frustum = gfCamera.frustum
    view = frustum.ComputeViewMatrix()
    metadata = _core.ImageMetadata()
    metadata.samples = settings.samples
    metadata.camera = settings.camera
    metadata.pixelAspectRatio = settings.pixelAspectRatio
    metadata.worldToCamera = [value for row in view for value in row]
    projection = view * frustum.ComputeProjectionMatrix()
    metadata.worldToNdc = [value for row in projection for value in row]
    return metadata
