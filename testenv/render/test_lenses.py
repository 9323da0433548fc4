# SPDX-License-Identifier: Apache-2.0
"""Projections, apertures, vignetting and exposure, from the attributes of a stage to its picture, against closed forms.

Every ray of every pixel is checked to 1e-6 in device/integrator/testCamera; here whole pictures of whole stages are.
"""

import math

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

pytest.importorskip("hdstream._core")

import hdstream
from hdstream import _core
from stages import author, shapes

WIDTH, HEIGHT = 64, 48
SETTINGS = dict(imageWidth=WIDTH, imageHeight=HEIGHT, camera="/World/Camera", pixelFilter="box", pixelFilterWidth=1.0, noCache=True)
_TYPES = {list: Sdf.ValueTypeNames.StringArray, str: Sdf.ValueTypeNames.Token, int: Sdf.ValueTypeNames.Int, float: Sdf.ValueTypeNames.Float}


def Author(camera, attributes):
    for name, value in attributes.items():
        isPair = isinstance(value, tuple)
        kind = Sdf.ValueTypeNames.Float2 if isPair else _TYPES[type(value)]
        camera.GetPrim().CreateAttribute(name, kind).Set(Gf.Vec2f(*value) if isPair else value)


def Room(attributes=None, **camera):
    """A camera that is turned somehow, in a box of 8 units; a dome that nothing sees lights it from inside all the same."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/World")
    author.AddMesh(stage, "/World/Room", shapes.Box(8.0, 8.0, 8.0), color=(0.5, 0.5, 0.5))
    author.AddLight(stage, "/World/Lamp", "Sphere", dict(translate=(1, 2, 1)), intensity=5.0, radius=0.4)
    made = author.AddCamera(stage, **{**dict(eye=(0.3, -0.4, 0.8), target=(2, 1, -3), up=(0.3, 1, 0.2)), **camera})
    Author(made, attributes or {})
    return stage, made


def Render(stage, onWarning=lambda line: None, **settings):
    return hdstream.Renderer(stage, onWarning=onWarning).Render(1.0, **{**SETTINGS, **settings})


def Latlong(u, v):
    longitude, latitude = (u - 0.5) * 2 * math.pi, (0.5 - v) * math.pi
    return np.stack([np.sin(longitude) * np.cos(latitude), np.sin(latitude), -np.cos(longitude) * np.cos(latitude)], -1)


def Fisheye(angleOf):
    def Directions(u, v):
        x, y = (2 * u - 1) * WIDTH / HEIGHT, 1 - 2 * v
        radius = np.hypot(x, y)
        angle = angleOf(np.minimum(radius, 1.0))
        directions = np.stack([np.sin(angle) * x / radius, np.sin(angle) * y / radius, -np.cos(angle)], -1)
        return np.where((radius <= 1.0)[..., None], directions, np.nan)
    return Directions


_HALF = math.radians(100.0)
PROJECTIONS = {
    "latlong": ({"hdstream:camera:projection": "latlong"}, Latlong),
    "spherical_camera": ({"primvars:arnold:camera": "spherical_camera"}, Latlong),
    "fisheyeEquidistant": ({"hdstream:camera:projection": "fisheyeEquidistant", "hdstream:camera:fieldOfView": 200.0},
                           Fisheye(lambda radius: radius * _HALF)),
    "fisheye_camera": ({"primvars:arnold:camera": "fisheye_camera"}, Fisheye(lambda radius: radius * math.pi / 4)),
    "fisheyeEquisolid": ({"hdstream:camera:projection": "fisheyeEquisolid", "hdstream:camera:fieldOfView": 200.0},
                         Fisheye(lambda radius: 2 * np.arcsin(radius * math.sin(_HALF / 2)))),
    "fisheyeStereographic": ({"hdstream:camera:projection": "fisheyeStereographic", "hdstream:camera:fieldOfView": 200.0},
                             Fisheye(lambda radius: 2 * np.arctan(radius * math.tan(_HALF / 2)))),
}


@pytest.mark.parametrize("name", PROJECTIONS)
def test_projections_see_what_their_closed_form_says(name):
    """Positions of first hits lie along the direction of their pixel, and their distance is cameraDepth."""
    attributes, directionsOf = PROJECTIONS[name]
    stage, camera = Room(attributes)
    aovs = Render(stage, samples=1, aovs=["color", "alpha", "position", "cameraDepth"]).aovs
    v, u = np.meshgrid((np.arange(HEIGHT) + 0.5) / HEIGHT, (np.arange(WIDTH) + 0.5) / WIDTH, indexing="ij")
    expected = directionsOf(u, v)
    matrix = np.array(camera.ComputeLocalToWorldTransform(1.0))
    seen = ~np.isnan(expected[..., 0])
    way = aovs["position"].astype(np.float64) - matrix[3, :3]
    found = way / np.linalg.norm(way, axis=-1, keepdims=True)
    assert np.abs(found - expected @ matrix[:3, :3])[seen].max() < 1e-5  # positions of hits are floats of their own
    assert np.abs(aovs["cameraDepth"][..., 0] - np.linalg.norm(way, axis=-1))[seen].max() < 1e-4
    outside = np.hypot((2 * u - 1) * WIDTH / HEIGHT, 1 - 2 * v) > 1.05  # of pixels that the border crosses some is seen
    if name not in ("latlong", "spherical_camera"):
        assert (~seen).mean() > 0.3
        assert not aovs["color"][outside].any() and not aovs["alpha"][outside].any()


def test_outside_of_a_fisheye_nothing_is_seen():
    """Not the sky either."""
    stage, _ = Room(PROJECTIONS["fisheyeEquidistant"][0])
    stage.RemovePrim("/World/Room")
    author.AddLight(stage, "/World/Dome", "Dome", intensity=1.0)
    aovs = Render(stage, samples=4, aovs=["color", "alpha"]).aovs
    for corner in ((0, 0), (0, -1), (-1, 0), (-1, -1)):
        assert not aovs["color"][corner].any() and not aovs["alpha"][corner].any()
    assert aovs["alpha"][HEIGHT // 2, WIDTH // 2] == 1.0 and np.allclose(aovs["color"][HEIGHT // 2, WIDTH // 2], 1.0)


def test_parts_of_a_panorama_are_its_pixels():
    """Longitudes and latitudes of a quarter of it."""
    whole, _ = Room({"hdstream:camera:projection": "latlong"})
    part, _ = Room({"hdstream:camera:projection": "latlong", "hdstream:camera:longitudes": (0.0, 180.0), "hdstream:camera:latitudes": (-90.0, 0.0)})
    positions = Render(whole, samples=1, aovs=["position"]).aovs["position"]
    quarter = Render(part, samples=1, aovs=["position"], imageWidth=WIDTH // 2, imageHeight=HEIGHT // 2).aovs["position"]
    assert np.abs(quarter - positions[HEIGHT // 2:, WIDTH // 2:]).max() < 1e-4


@pytest.mark.parametrize("projection", ["film", "fisheyeEquisolid"])
def test_first_hits_are_seen_through_the_centre_of_any_aperture(projection):
    """Far out of focus: AOVs of the first hit are those of a round lens, to the bit, and of a pinhole but for rounding."""
    aovs = ["position", "normal", "primId", "cameraDepth"]

    def Layers(fStop, **attributes):
        stage, camera = Room({"hdstream:camera:projection": projection, **attributes})
        camera.CreateFStopAttr(fStop)
        camera.CreateFocusDistanceAttr(0.5)
        return Render(stage, samples=1, aovs=aovs).aovs

    pinhole, round_ = Layers(0.0), Layers(1.0)
    seen = pinhole["primId"] >= 0
    assert np.abs(round_["position"] - pinhole["position"])[seen].max() < 1e-3
    for blades, ratio in ((5, 1.0), (6, 1.0), (5, 2.0)):
        found = Layers(1.0, **{"hdstream:camera:apertureBlades": blades, "hdstream:camera:apertureRatio": ratio})
        assert all(found[name].tobytes() == round_[name].tobytes() for name in aovs)


@pytest.mark.parametrize("far", [1e3, 1e30, 3e38, math.inf])
def test_depth_for_any_far_plane(far):
    """Of [0, 1], as OpenGL has it: what is nearly no far plane is as good as none."""
    stage, camera = Room()
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.1, far))
    aovs = Render(stage, samples=1, aovs=["depth", "cameraDepth"]).aovs
    z = aovs["cameraDepth"].astype(np.float64)
    np.testing.assert_allclose(aovs["depth"], (z - 0.1) / z / (1.0 - 0.1 / far), atol=1e-6)


def _DiskCovered(x):
    """The part of a unit disk to the left of x."""
    x = np.clip(x, -1.0, 1.0)
    return 0.5 + (x * np.sqrt(1.0 - x * x) + np.arcsin(x)) / math.pi


@pytest.mark.parametrize("ratio", [1.0, 2.0])
def test_orthographic_cameras_have_depth_of_field(ratio):
    """A knife edge out of focus: of a pixel that sees it, the part is lit that the lens' disk leaves."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/World")
    white = author.AddMaterial(stage, "/World/White", emissiveColor=(1.0, 1.0, 1.0), diffuseColor=(0.0, 0.0, 0.0), specularColor=(0.0, 0.0, 0.0))
    card = shapes.Shape(np.array([[-9.0, -9, 0], [0, -9, 0], [0, 9, 0], [-9, 9, 0]]), np.array([4]), np.array([0, 1, 2, 3]))
    author.AddMesh(stage, "/World/Card", card, material=white, translate=(0, 0, -5))
    author.AddLight(stage, "/World/Dark", "Dome", intensity=0.0)
    camera = author.AddCamera(stage, eye=(0, 0, 0), target=(0, 0, -1), width=40.0, orthographic=True)
    camera.CreateFocalLengthAttr(50.0)
    camera.CreateFStopAttr(1.0)
    camera.CreateFocusDistanceAttr(8.0)
    Author(camera, {"hdstream:camera:apertureRatio": ratio})
    color = Render(stage, samples=256, maxDepth=0).aovs["color"][..., 0].astype(np.float64).mean(0)
    radius = 2.5 * (8.0 - 5.0) / 8.0 / ratio  # of the circle of confusion, units
    edges = np.linspace(-2.0, 2.0, 8 * WIDTH + 1)
    x = 0.5 * (edges[1:] + edges[:-1])
    expected = _DiskCovered(-x / radius).reshape(WIDTH, 8).mean(1)
    assert np.abs(color - expected).max() < 0.01
    assert ((expected > 0.05) & (expected < 0.95)).sum() > 10, "the test would show little"


def test_vignetting_is_the_fourth_power_of_the_cosine():
    attributes = {"hdstream:camera:vignetting": 1.0}
    stage, camera = Room(attributes, width=72.0)
    stage.RemovePrim("/World/Room")
    stage.RemovePrim("/World/Lamp")
    author.AddLight(stage, "/World/Dome", "Dome", intensity=2.0)
    aovs = Render(stage, samples=64, aovs=["color", "alpha"]).aovs
    scale = 7.2 / 3.5 / WIDTH
    y, x = np.meshgrid((np.arange(HEIGHT) + 0.5 - HEIGHT / 2) * scale, (np.arange(WIDTH) + 0.5 - WIDTH / 2) * scale, indexing="ij")
    expected = 2.0 / (1.0 + x * x + y * y) ** 2
    assert np.abs(aovs["color"][..., 0] / expected - 1.0).max() < 0.01
    assert (aovs["alpha"] == 1.0).all()


def test_what_says_nothing_changes_no_bits():
    plain, _ = Room()
    named, _ = Room({"hdstream:camera:projection": "film", "hdstream:camera:apertureBlades": 0, "hdstream:camera:vignetting": 0.0,
                     "primvars:arnold:camera": "persp_camera", "ri:apertureNSides": 0, "ri:dofaspect": 1.0})
    assert Render(plain, samples=2).aovs["color"].tobytes() == Render(named, samples=2).aovs["color"].tobytes()


def test_own_names_win_over_those_of_hosts():
    camera = _core.CameraPrim()
    problems = _core.SetCameraAttributes({
        "hdstream:camera:apertureBlades": 7, "ri:apertureNSides": 5, "primvars:arnold:aperture_blades": 6, "ri:apertureAngle": 30.0,
        "primvars:arnold:aperture_blade_curvature": 0.5, "primvars:arnold:camera": 1.0}, camera)
    assert not problems
    assert (camera.lens.apertureBlades, camera.lens.apertureRotation, camera.lens.apertureRoundness) == (7, 30.0, 0.5)
    assert camera.lens.projection == _core.CameraProjection.Film  # a light's attribute of that name is a number


@pytest.mark.parametrize("name, value, word", [
    ("hdstream:camera:projection", "fish", "is none of film, fisheyeEquidistant"),
    ("primvars:arnold:camera", "cyl_camera", "is not supported"),
    ("hdstream:camera:fieldOfView", 400.0, "out of its range"),
    ("hdstream:camera:fieldOfView", math.nan, "is no number"),
    ("hdstream:camera:latitudes", (10.0, -10.0), "no interval"),
    ("hdstream:camera:apertureBlades", ["five"], "is no number"),
    ("hdstream:camera:vignetting", -1.0, "out of its range"),
    ("ri:dofaspect", 2.0, "hdstream:camera:apertureRatio is"),
])
def test_bad_attributes_cost_a_line_that_names_them(name, value, word):
    stage, _ = Room({name: value})
    lines = []
    Render(stage, onWarning=lines.append, samples=1)
    assert [line for line in lines if line.startswith(f"/World/Camera: {name} ") and word in line] == lines


def test_exposure_is_usds_formula():
    exposure = {"exposure": 1.5, "exposure:time": 0.25, "exposure:iso": 400.0, "exposure:fStop": 2.8, "exposure:responsivity": 1.3}
    stage, camera = Room()
    plain = Render(stage, samples=1).aovs["color"][..., :3]
    Author(camera, exposure)
    factor = 0.25 * 400.0 * 2.0 ** 1.5 * 1.3 / (100.0 * 2.8 ** 2)
    assert np.allclose(Render(stage, samples=1).aovs["color"][..., :3], factor * plain, rtol=1e-4)
    darker = Render(stage, samples=1, exposure=-1.5).aovs["color"]
    assert np.allclose(darker[..., :3], factor * 2.0 ** -1.5 * plain, rtol=1e-4)  # the setting counts beside the camera's
    attributes = {name: value for name, value in exposure.items() if name != "exposure"}
    found = _core.LinearExposureScale(1.5, attributes)
    assert found == pytest.approx(factor, rel=1e-6)
    if hasattr(camera, "ComputeLinearExposureScale"):
        assert np.float32(camera.ComputeLinearExposureScale(Usd.TimeCode(1.0))) == np.float32(found)
