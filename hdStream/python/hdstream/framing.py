# SPDX-License-Identifier: Apache-2.0
"""Which camera renders, as usdrecord chooses it, and the camera that frames a stage without one.

Source of the framing: OpenUSD, UsdAppUtilsFrameRecorder, "_ComputeCameraToFrameStage"; deviates:
prims whose bounds are not finite are left out, and a stage that is empty, or has instancers that place themselves, is
framed as a unit cube.
"""

import math

from pxr import Gf, Sdf, Usd, UsdGeom, UsdUtils

from hdstream.diagnostics import TfError
from hdstream.errors import UsageError
from hdstream.translate.circles import HasCircularInstancers

FREE_CAMERA_PATH = "/hdStreamFreeCamera"
_PREDICATE = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)


def FindCamera(stage, camera, settingsCamera):
    """The camera prim to render: of the option, of the render settings, main_cam; None: frame it."""
    if camera:
        prim = _FindByNameOrPath(stage, str(camera))
        if prim is None:
            raise UsageError(f"--camera {camera}: {_NoSuchCamera(stage)}")
        return prim
    if settingsCamera:
        prim = _FindByNameOrPath(stage, str(settingsCamera))
        if prim is None:
            raise UsageError(f"camera {settingsCamera} of the render settings: {_NoSuchCamera(stage)}")
        return prim
    return _FindByNameOrPath(stage, UsdUtils.GetPrimaryCameraName())


def _NoSuchCamera(stage):
    isWhole = stage.GetPopulationMask() == Usd.StagePopulationMask.All()
    return "the stage has no such camera" + ("" if isWhole else " inside of the mask")


def _FindByNameOrPath(stage, text):
    if not Sdf.Path.IsValidPathString(text) or not Sdf.Path(text).IsPrimPath():
        return None
    path = Sdf.Path(text)
    if not path.IsAbsolutePath() and path.pathElementCount == 1:
        for prim in Usd.PrimRange.Stage(stage, _PREDICATE):
            if prim.GetName() == text and prim.IsA(UsdGeom.Camera):
                return prim
        return None
    prim = stage.GetPrimAtPath(path.MakeAbsolutePath(Sdf.Path.absoluteRootPath))
    return prim if prim and prim.IsA(UsdGeom.Camera) else None


def MakeFramingCamera(stage, timeCode, purposes):
    """A GfCamera that shows all of the stage from the front."""
    camera = Gf.Camera()  # 50 mm, perspective
    centre, size = _StageBounds(stage, timeCode, purposes)
    isYUp = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    height, depth = (size[1], size[2]) if isYUp else (size[2], size[1])
    planeRadius = math.hypot(size[0] / 2.0, height / 2.0)
    halfFov = math.radians(camera.GetFieldOfView(Gf.Camera.FOVHorizontal) / 2.0)
    # The front face of the bounds is in view, and never nearer than the near clipping plane.
    distance = planeRadius / math.tan(halfFov) + depth / 2.0
    if distance < camera.clippingRange.min:
        distance += camera.clippingRange.min
    # usdrecord keeps its planes at 1 and 10^6, cuts open what lies nearer and leaves out what lies beyond; we draw all of it.
    near, far = camera.clippingRange.min, camera.clippingRange.max
    front, back = distance - depth / 2.0, distance + depth / 2.0
    if 0.0 < front < 2.0 * near:
        near = front / 2.0
    if back > far:
        far = 2.0 * back
    camera.clippingRange = Gf.Range1f(near, far)
    matrix = Gf.Matrix4d(1.0)
    if isYUp:
        matrix.SetTranslate(centre + Gf.Vec3d(0, 0, distance))
    else:
        matrix.SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90))
        matrix.SetTranslateOnly(centre + Gf.Vec3d(0, -distance, 0))
    camera.transform = matrix
    return camera


def _StageBounds(stage, timeCode, purposes):
    """(centre, size) of everything drawn."""
    if HasCircularInstancers(stage):
        return Gf.Vec3d(0.0), Gf.Vec3d(1.0)
    cache = UsdGeom.BBoxCache(timeCode, purposes, useExtentsHint=True)
    bounds = _BoundsOf(stage.GetPseudoRoot(), cache)
    box = bounds.ComputeAlignedRange()
    if not _IsFinite(box):
        box = Gf.Range3d()
        for prim in Usd.PrimRange.Stage(stage, _PREDICATE):
            if prim.IsA(UsdGeom.Boundable):
                part = _BoundsOf(prim, cache).ComputeAlignedRange()
                if _IsFinite(part):
                    box.UnionWith(part)
        if box.IsEmpty():
            box = Gf.Range3d(Gf.Vec3d(-0.5), Gf.Vec3d(0.5))
        return box.GetMidpoint(), box.GetSize()
    return bounds.ComputeCentroid(), box.GetSize()


def _BoundsOf(prim, cache):
    """The world bound; empty where OpenUSD finds something wrong, which the translation warns of."""
    try:
        return cache.ComputeWorldBound(prim)
    except TfError:
        return Gf.BBox3d()


def _IsFinite(box):
    """True for a box with contents, none of it infinite, NaN or beyond what floats can square."""
    return not box.IsEmpty() and all(
        math.isfinite(value) and abs(value) < 1e18 for point in (box.min, box.max) for value in point)
