# SPDX-License-Identifier: Apache-2.0
"""Which camera renders, what frames a stage without one, data windows, and units."""

import math

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from hdstream.errors import CommandError
from hdstream.framing import FindCamera, MakeFramingCamera
from hdstream.renderSettings import DataWindow
from hdstream.translate.cameras import CameraFromGf, ReadCamera
from translateCase import StageOf

CAMERAS = """
def Camera "main_cam" {}
def Xform "Rig" { def Camera "Close" {} def Xform "NoCamera" {} }
"""


def test_camera_is_found_by_name_path_or_default():
    stage = StageOf(CAMERAS)
    assert str(FindCamera(stage, None, None).GetPath()) == "/main_cam"
    assert str(FindCamera(stage, "Close", None).GetPath()) == "/Rig/Close"
    assert str(FindCamera(stage, "/Rig/Close", None).GetPath()) == "/Rig/Close"
    assert str(FindCamera(stage, None, "/Rig/Close").GetPath()) == "/Rig/Close"
    assert FindCamera(StageOf('def Camera "other" {}'), None, None) is None


@pytest.mark.parametrize("name", ["none", "/Rig", "NoCamera", "not a path!", "/Rig/Close.attr"])
def test_unknown_camera_is_wrong_usage(name):
    with pytest.raises(CommandError) as caught:
        FindCamera(StageOf(CAMERAS), name, None)
    assert caught.value.exitCode == 2 and str(caught.value).endswith(f"{name}: the stage has no such camera")


def test_a_camera_outside_of_the_mask_is_told_so():
    layer = StageOf(CAMERAS).GetRootLayer()
    stage = Usd.Stage.OpenMasked(layer, Usd.StagePopulationMask(["/Rig"]))
    assert FindCamera(stage, "/Rig/Close", None)
    for asked in (("/main_cam", None), (None, "/main_cam")):
        with pytest.raises(CommandError, match="the stage has no such camera inside of the mask"):
            FindCamera(stage, *asked)


@pytest.mark.parametrize("upAxis", ["Y", "Z"])
@pytest.mark.parametrize("scale", [0.01, 1.0, 1000.0, 1e6, 1e12])
def test_framing_shows_all_corners_of_the_bounds(upAxis, scale):
    stage = StageOf(f"""def Xform "W" {{
        double3 xformOp:translate = (5, -7, 3)
        float3 xformOp:scale = ({scale}, {2 * scale}, {3 * scale})
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
        def Cube "C" {{}}
    }}""")
    UsdGeom.SetStageUpAxis(stage, upAxis)
    camera = MakeFramingCamera(stage, Usd.TimeCode.Default(), ["default"])
    frustum = camera.frustum
    matrix = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
    for corner in range(8):
        point = Gf.Vec3d(*((-1 if corner >> axis & 1 else 1) * scale * (1, 2, 3)[axis] + (5, -7, 3)[axis]
                           for axis in range(3)))
        ndc = matrix.Transform(point)
        # All of the width, and neither plane cuts (usdrecord frames by the horizontal field).
        assert abs(ndc[0]) <= 1 + 1e-6 and -1 <= ndc[2] <= 1
    up = camera.transform.TransformDir(Gf.Vec3d(0, 1, 0))
    assert Gf.IsClose(up, Gf.Vec3d(0, 1, 0) if upAxis == "Y" else Gf.Vec3d(0, 0, 1), 1e-9)


def test_framing_distance_is_usdrecords():
    """A 2 x 4 x 6 box: half diagonal of the front face over the tangent, plus half the depth."""
    stage = StageOf('def Xform "W" { float3 xformOp:scale = (1, 2, 3)\n'
                    'uniform token[] xformOpOrder = ["xformOp:scale"]\n def Cube "C" {} }')
    camera = MakeFramingCamera(stage, Usd.TimeCode.Default(), ["default"])
    tangent = 0.5 * 20.955 / 50.0
    assert camera.transform.ExtractTranslation()[2] == pytest.approx(math.hypot(1, 2) / tangent + 3, rel=1e-6)


@pytest.mark.parametrize("body", ["", 'def Mesh "M" { point3f[] points = [(nan, 0, 0), (1, inf, 0)] }'])
def test_framing_without_usable_bounds_is_finite(body):
    camera = MakeFramingCamera(StageOf(body), Usd.TimeCode.Default(), ["default"])
    assert all(math.isfinite(value) for row in camera.transform for value in row)


@pytest.mark.parametrize("window, expected", [
    ((0, 0, 1, 1), (0, 0, 100, 50)),
    ((0.1, 0.2, 0.5, 0.8), (10, 10, 50, 40)),       # y is up in NDC, down in pixels
    ((-0.1, 0.0, 1.1, 1.0), (-10, 0, 110, 50)),     # overscan
    ((0.104, 0, 0.106, 1), (10, 0, 11, 50)),        # one column: the centre of pixel 10 is at 0.105
    ((0.106, 0, 0.114, 1), (11, 0, 11, 50)),        # no centre inside: empty
])
def test_data_window_holds_the_pixels_whose_centres_it_holds(window, expected):
    assert DataWindow(window, 100, 50) == expected


def test_lengths_are_hydras_floats():
    """HdCamera's lengths: USD's floats times 0.1f, as floats."""
    gfCamera = Gf.Camera(horizontalAperture=20.955, verticalAperture=15.2908, focalLength=35.3)
    gfCamera.clippingPlanes = [Gf.Vec4f(0.0, 0.0, -1.0, -2.5)]
    camera = CameraFromGf(gfCamera)
    tenth = np.float32(0.1)
    assert camera.horizontalAperture == np.float32(20.955) * tenth
    assert camera.verticalAperture == np.float32(15.2908) * tenth
    assert camera.focalLength == np.float32(35.3) * tenth
    assert camera.clippingPlanes == [[0.0, 0.0, -1.0, -2.5]]


def test_exposure_is_usds_own_formula():
    stage = StageOf('def Camera "C" { float exposure = 1 }')
    camera = UsdGeom.Camera.Get(stage, "/C")
    assert ReadCamera(camera.GetPrim(), Usd.TimeCode(1)).exposureScale == pytest.approx(2.0)
    if hasattr(camera, "GetExposureIsoAttr"):
        camera.CreateExposureIsoAttr(400)
        assert ReadCamera(camera.GetPrim(), Usd.TimeCode(1)).exposureScale == pytest.approx(
            camera.ComputeLinearExposureScale(Usd.TimeCode(1)))
