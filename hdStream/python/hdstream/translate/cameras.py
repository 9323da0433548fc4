# SPDX-License-Identifier: Apache-2.0
"""UsdGeomCamera (through GfCamera) as the core's camera."""

import numpy as np
from pxr import Gf, UsdGeom

from hdstream import _core
from hdstream.translate.motion import ReadShutter


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


def ReadCamera(prim, timeCode, motion=None):
    """The camera of a UsdGeomCamera prim, in world space; its poses while the shutter of a Motion is open."""
    usdCamera = UsdGeom.Camera(prim)
    camera = CameraFromGf(usdCamera.GetCamera(timeCode), _ExposureScale(usdCamera, timeCode))
    camera.shutter = ReadShutter(prim, timeCode)
    if motion is not None:
        camera.samples = motion.CameraSamplesOf(usdCamera)
    return camera


def _ExposureScale(usdCamera, timeCode):
    """Linear factor on radiance: UsdGeom's own formula where this usd-core has it (25.05 on)."""
    if hasattr(usdCamera, "ComputeLinearExposureScale"):
        return float(usdCamera.ComputeLinearExposureScale(timeCode))
    exposure = usdCamera.GetPrim().GetAttribute("exposure").Get(timeCode)
    return 2.0 ** exposure if exposure else 1.0
