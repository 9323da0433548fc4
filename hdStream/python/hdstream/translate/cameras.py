# SPDX-License-Identifier: Apache-2.0
"""UsdGeomCamera (through GfCamera) as the core's camera."""

import numpy as np
from pxr import Gf, UsdGeom

from hdstream import _core
from hdstream.translate import valueClips
from hdstream.translate.motion import ReadShutter, ShutterProblems
from hdstream.typedValues import TypedValue


# GfCamera's apertures and focal lengths are in tenths of a scene unit; Hydra multiplies as floats.
_TENTH = np.float32(0.1)


def CameraFromGf(gfCamera, exposureScale=1.0):
    """The core's camera with a GfCamera's values, with HdCamera's floats in scene units."""
    camera = _core.CameraPrim()
    camera.worldFromCamera = np.array(gfCamera.transform)
    camera.orthographic = gfCamera.projection == Gf.Camera.Orthographic
    camera.horizontalAperture = _SceneUnits(gfCamera.horizontalAperture)
    camera.verticalAperture = _SceneUnits(gfCamera.verticalAperture)
    camera.horizontalApertureOffset = _SceneUnits(gfCamera.horizontalApertureOffset)
    camera.verticalApertureOffset = _SceneUnits(gfCamera.verticalApertureOffset)
    camera.focalLength = _SceneUnits(gfCamera.focalLength)
    camera.nearClip = gfCamera.clippingRange.min
    camera.farClip = gfCamera.clippingRange.max
    camera.fStop = gfCamera.fStop
    camera.focusDistance = gfCamera.focusDistance
    camera.exposureScale = exposureScale
    camera.clippingPlanes = [list(plane) for plane in gfCamera.clippingPlanes]
    return camera


def _SceneUnits(tenths):
    return float(np.float32(tenths) * _TENTH)


def ReadCamera(prim, timeCode, motion=None, warn=lambda prim, text: None):
    """The camera of a UsdGeomCamera prim, in world space; poses and lenses while the shutter of a Motion is open.

    `warn(prim, text)` gets what is wrong with attributes beside UsdGeomCamera's.
    """
    usdCamera = UsdGeom.Camera(prim)
    attributes = _ReadAttributes(prim, timeCode)
    projection = prim.GetAttribute("projection").Get(timeCode)
    if projection not in (None, "perspective", "orthographic"):
        warn(prim, f"projection {projection} is unknown; perspective is used")
    try:
        exposure = TypedValue(prim.GetAttribute("exposure"), timeCode)
    except TypeError as error:
        warn(prim, f"exposure {error}; ignored")
        exposure = None
    camera = CameraFromGf(usdCamera.GetCamera(timeCode), _core.LinearExposureScale(exposure or 0.0, attributes))
    camera.shutter = ReadShutter(prim, timeCode)
    for text in ShutterProblems(prim, timeCode) + list(_core.SetCameraAttributes(attributes, camera)):
        warn(prim, text)
    if motion is not None:
        camera.samples = motion.CameraSamplesOf(usdCamera)
        camera.lensSamples = _ReadLensSamples(prim, motion)
    return camera


def CloseLens(camera):
    """Makes a camera a pinhole."""
    camera.fStop = 0.0
    samples = camera.lensSamples
    for sample in samples:
        sample.fStop = 0.0
    camera.lensSamples = samples


def _ReadAttributes(prim, timeCode):
    """The values of attributes beside UsdGeomCamera's that the core reads, by name."""
    values = {}
    for name in _core.CAMERA_ATTRIBUTES + _core.EXPOSURE_ATTRIBUTES:
        attribute = prim.GetAttribute(name)
        value = attribute.Get(timeCode) if attribute and attribute.HasAuthoredValue() else None
        if isinstance(value, (bool, int, float, str)):
            values[name] = value
        elif value is not None:
            try:
                values[name] = [float(number) for number in value]
            except (TypeError, ValueError):
                values[name] = str(value)  # of no use, which the core says
    return values


def _ReadLensSamples(prim, motion):
    """The lens and the film while the shutter is open; empty when they are the same at all times."""
    lengths = ("focalLength", "horizontalAperture", "verticalAperture", "horizontalApertureOffset", "verticalApertureOffset")
    attributes = [prim.GetAttribute(name) for name in ("fStop", "focusDistance", *lengths)]
    if not motion.isOn or not any(valueClips.Varies(attribute) for attribute in attributes):
        return []
    samples = []
    for time in motion.times:
        sample = _core.LensSample()
        sample.time = time
        sample.fStop, sample.focusDistance, *tenths = [float(attribute.Get(motion.At(time))) for attribute in attributes]
        for name, value in zip(lengths, tenths):
            setattr(sample, name, _SceneUnits(value))
        samples.append(sample)
    return samples
