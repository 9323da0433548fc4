# SPDX-License-Identifier: Apache-2.0
"""The settings and the camera of a frame: of the caller, else of the render settings prim, else defaults."""

import dataclasses
import math
import operator
from fractions import Fraction
from typing import Optional, Tuple

import numpy as np
from pxr import Gf, Usd, UsdGeom

from hdstream import _core
from hdstream.diagnostics import MessagesOf, TfError
from hdstream.errors import CommandError, OneLine, UsageError
from hdstream.framing import FREE_CAMERA_PATH, MakeFramingCamera
from hdstream.options import PURPOSES
from hdstream.renderSettings import DataWindow
from hdstream.translate.cameras import CameraFromGf, CloseLens, ReadCamera
from hdstream.translate.motion import Motion, ReadShutter

# Settings that SetCamera completes from the camera and the render settings prim.
_FRAMED = ("camera", "imageWidth", "imageHeight")


def MakeSettings(values, prim, warn):
    """The core's settings of `values` (names of the settings table; None: not given) and a render settings prim.

    `warn(subject, text)` is called for values in a former spelling.
    """
    settings = _core.Settings()

    def Set(name, value):
        note = _SetSetting(settings, name, value)
        if note:
            subject, _, text = note.partition(": ")
            warn(subject, text)

    for name, value in prim.values.items():
        Set(name, value)
    settings.purposes = list(_WithDefault(prim.purposes) or settings.purposes)
    if prim.aovs:
        settings.aovs = prim.aovs
    if prim.disableMotionBlur:
        settings.motionBlur = "off"
    if prim.pixelAspectRatio:
        Set("pixelAspectRatio", prim.pixelAspectRatio)
    for name, value in values.items():
        if value is None or name in _FRAMED:
            continue
        Set(name, value)
        if name == "purposes":  # a list, as the core has seen
            unknown = [purpose for purpose in settings.purposes if purpose not in PURPOSES]
            if unknown:
                raise UsageError(f"--purposes: {unknown[0]!r} is none of {', '.join(PURPOSES)}")
            settings.purposes = _WithDefault(settings.purposes)
    return settings


def _SetSetting(settings, name, value):
    """As the core's function, also for values of types that no setting has: there it has a TypeError of several lines."""
    try:
        return _core.SetSetting(settings, name, value)
    except TypeError:
        raise UsageError(f"{name}: {value!r} is of no use") from None


def ShutterOf(cameraPrim, timeCode, settings):
    """(open, close) in frames from the frame; both 0 without motion blur."""
    if settings.motionBlur != "on" or cameraPrim is None:
        return 0.0, 0.0
    return ReadShutter(cameraPrim, Usd.TimeCode(timeCode))


def _WithDefault(purposes):
    if purposes is None:
        return None
    return ["default"] + [purpose for purpose in purposes if purpose != "default"]


class Framing:
    """Puts the render camera into a scene and completes the settings."""

    def __init__(self, stage, session, renderSettings, width, height, crop):
        """`width`, `height`, `crop`: of the caller, None where it does not say."""
        self._stage = stage
        self._session = session
        self._renderSettings = renderSettings
        self._width = width
        self._height = height
        self._crop = crop

    def SetCamera(self, prim, timeCode, shutter, settings):
        """`prim`: of the camera; None frames the stage. `shutter`: that counts. Returns the core's camera."""
        usdTime = Usd.TimeCode(timeCode)
        if prim is None:
            gfCamera = MakeFramingCamera(self._stage, usdTime, settings.purposes)
            camera = CameraFromGf(gfCamera)
            settings.camera = FREE_CAMERA_PATH
        else:
            settings.camera = prim.GetPath().pathString
            try:
                gfCamera = UsdGeom.Camera(prim).GetCamera(usdTime)
                camera = ReadCamera(prim, usdTime, Motion(usdTime, shutter), self._Warn)
            except TfError as error:
                raise CommandError(f"camera {settings.camera} cannot be read: {'; '.join(MessagesOf(error))}") from None
        if not all(0.0 < length < math.inf for length in (camera.horizontalAperture, camera.verticalAperture)):
            gfCamera = Gf.Camera()  # which the core takes the apertures of, and says so
        if self._renderSettings.disableDepthOfField:
            CloseLens(camera)
        self._SetImageSize(gfCamera.aspectRatio, settings)
        self._SetDataWindow(settings)
        if self._crop is not None:
            _Crop(self._crop, settings)
        self._session.SetCamera(settings.camera, camera)
        return camera

    def _Warn(self, prim, text):
        self._session.Warn(prim.GetPath().pathString, text)

    def _SetImageSize(self, aspect, settings):
        """usdrecord's rule: the height follows from the width and the camera's aspect ratio."""
        resolution = self._renderSettings.resolution
        width, height = self._width, self._height
        if width is None and height is None and self._renderSettings.resolutionProblem:
            raise UsageError(self._renderSettings.resolutionProblem)
        isOfPrim = width is None and height is None and bool(resolution)
        if isOfPrim:
            width, height = resolution
        try:
            if width is not None:
                _SetSetting(settings, "imageWidth", width)
            if height is None:
                # As usdrecord: cut off, computed with floats; what the rounding leaves is the width's.
                pixels = np.float32(settings.pixelAspectRatio) * np.float32(settings.imageWidth)
                height = max(1, int(pixels / np.float32(aspect)))
                settings.conformPolicy = "adjustApertureWidth"
            _SetSetting(settings, "imageHeight", height)
        except _core.UsageError as error:
            if not isOfPrim:
                raise
            raise UsageError(f"{self._renderSettings.path}: resolution: {OneLine(error)}") from None
        settings.conformPolicy = self._renderSettings.conformPolicy or settings.conformPolicy

    def _SetDataWindow(self, settings):
        """The render settings' data window: the image is that part of the full image."""
        windowNDC = self._renderSettings.dataWindowNDC
        if windowNDC is None:
            return
        left, top, right, bottom = DataWindow(windowNDC, settings.imageWidth, settings.imageHeight)
        if right <= left or bottom <= top:
            self._session.Warn(self._renderSettings.dataWindowPath, "dataWindowNDC holds no pixel; ignored")
            return
        try:
            _SetWindow((left, top, right, bottom), settings)
        except (CommandError, _core.UsageError) as error:
            raise UsageError(f"{self._renderSettings.dataWindowPath}: dataWindowNDC: {OneLine(error)}") from None


def _Crop(crop, settings):
    try:
        left, top, right, bottom = map(operator.index, crop)
    except (TypeError, ValueError):
        raise UsageError(f"crop {crop!r}: no four whole numbers left, top, right, bottom") from None
    if not (0 <= left < right <= settings.imageWidth and 0 <= top < bottom <= settings.imageHeight):
        raise UsageError(f"crop {tuple(crop)}: not inside the image of {settings.imageWidth}x{settings.imageHeight} pixels")
    x, y = settings.dataWindowMin
    settings.uncroppedWindow = [x, y, x + settings.imageWidth, y + settings.imageHeight]
    _SetWindow((left, top, right, bottom), settings)


def _SetWindow(window, settings):
    """The image becomes the part (left, top, right, bottom) of itself, with the same bits."""
    if not any(settings.displayWindow):
        settings.displayWindow = [0.0, 0.0, float(settings.imageWidth), float(settings.imageHeight)]
    left, top, right, bottom = window
    x, y = settings.dataWindowMin
    for name, size in (("imageWidth", right - left), ("imageHeight", bottom - top)):
        _SetSetting(settings, name, size)
    try:
        settings.dataWindowMin = [x + left, y + top]
    except TypeError:
        raise UsageError(f"pixel ({x + left}, {y + top}) is too far from the image") from None


@dataclasses.dataclass(frozen=True)
class FrameTime:
    """When a frame is, as a header says it."""

    framesPerSecond: Tuple[int, int] = (0, 0)  # a fraction; 0: the stage does not say
    number: Optional[int] = None  # of the frame; None: at no time, or before the first

    @staticmethod
    def Of(stage, timeCode):
        """Of a frame of a stage. Frames are those of framesPerSecond, which time codes may differ from."""
        if not any(stage.HasAuthoredMetadata(name) for name in ("framesPerSecond", "timeCodesPerSecond")):
            return FrameTime()
        rate = stage.GetFramesPerSecond()
        if not 0.01 <= rate <= 1e6:
            return FrameTime()
        whole = round(1.001 * rate)
        isNtsc = rate != round(rate) and abs(1.001 * rate - whole) < 1e-3 * whole / 24
        fraction = (1000 * whole, 1001) if isNtsc else Fraction(rate).limit_denominator(1000).as_integer_ratio()
        if timeCode.IsDefault() or stage.GetTimeCodesPerSecond() <= 0.0:
            return FrameTime(fraction)
        number = math.floor(timeCode.GetValue() * rate / stage.GetTimeCodesPerSecond() + 1e-6)
        return FrameTime(fraction, number if 0 <= number < 1 << 31 else None)


def MakeMetadata(settings, camera, frameTime=FrameTime()):
    """What the EXR says of the render."""
    metadata = _core.MakeImageMetadata(settings, camera)
    metadata.framesPerSecond = list(frameTime.framesPerSecond)
    metadata.frameNumber = frameTime.number
    return metadata
