# SPDX-License-Identifier: Apache-2.0
"""Motion vectors in pixels, against projections of our own of where points are a frame before and a frame after."""

import numpy as np
import pytest

pytest.importorskip("hdstream._core")

import hdstream

WIDTH, HEIGHT, FOCAL, APERTURE = 64, 48, 30.0, 36.0
_AOVS = ["position", "motionForward", "motionBackward", "primId"]
_STAGE = """#usda 1.0
(
    upAxis = "Y"
)
def Xform "World" {{
    def Camera "Camera" {{
        float focalLength = {focal}
        float horizontalAperture = {aperture}
        float verticalAperture = 27
        double shutter:open = {open}
        double shutter:close = {close}
        double3 xformOp:translate.timeSamples = {{ 0: ({back}, 0, 8), 2: ({pan}, 0, 8) }}
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
    def DomeLight "Sky" {{
    }}
    def Mesh "Mover" {{
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points.timeSamples = {{
            0: [(-4, -1, {near}), (0, -1, {near}), (0, 1, {near}), (-4, 1, {near})],
            2: [(-4, -1, {far}), (0, -1, {far}), (0, 1, {far}), (-4, 1, {far})]
        }}
        uniform token subdivisionScheme = "none"
        double3 xformOp:translate.timeSamples = {{ 0: (-0.4, -0.2, 0), 2: (0.4, 0.2, 0) }}
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
    def Mesh "Still" {{
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(0.6, -1, -1), (5, -1, -1), (5, 1, -1), (0.6, 1, -1)]
        uniform token subdivisionScheme = "none"
    }}
}}
"""


def _Raster(points, cameraX):
    scale = WIDTH * FOCAL / APERTURE
    depth = 8.0 - points[..., 2]
    return np.stack([WIDTH / 2 + scale * (points[..., 0] - cameraX) / depth, HEIGHT / 2 - scale * points[..., 1] / depth], -1)


def _Render(tmp_path, pan=0.0, near=0.0, far=0.0, shutter=(-0.5, 0.5), **settings):
    stage = tmp_path / "moving.usda"
    stage.write_text(_STAGE.format(focal=FOCAL, aperture=APERTURE, pan=pan, back=-pan, near=near, far=far, open=shutter[0], close=shutter[1]),
                     encoding="utf-8")
    image = hdstream.Renderer(str(stage)).Render(1.0, camera="/World/Camera", imageWidth=WIDTH, imageHeight=HEIGHT, samples=1, aovs=_AOVS,
                                                 noCache=True, **settings)
    return image.aovs


def _Expected(position, isMover, time, pan, velocityZ):
    """Where the points seen at the frame, time 1, are seen at another time."""
    moved = position + np.where(isMover[..., None], np.array([0.4, 0.2, velocityZ]) * (time - 1.0), 0.0)
    return _Raster(moved, pan * (time - 1.0))


@pytest.mark.parametrize("case", [dict(), dict(pan=0.5), dict(near=0.5, far=-0.5), dict(pan=-0.3, shutter=(-0.25, 0.0)),
                                  dict(shutter=(0.0, 0.5))], ids=["moves", "pans", "recedes", "shutterBefore", "shutterAfter"])
def test_vectors_are_where_points_are_seen(case, tmp_path):
    layers = _Render(tmp_path, **case)
    ids = layers["primId"]
    isHit, isMover = ids >= 0, ids == ids[HEIGHT // 2, WIDTH // 4]
    assert isMover.sum() > 300 and (isHit & ~isMover).sum() > 200 and (~isHit).sum() > 300
    position = layers["position"].astype(np.float64)
    pan, shutter = case.get("pan", 0.0), case.get("shutter", (-0.5, 0.5))
    velocityZ = (case.get("far", 0.0) - case.get("near", 0.0)) / 2.0
    here = _Expected(position, isMover, 1.0, pan, velocityZ)
    for name, end in (("motionForward", shutter[1] or shutter[0]), ("motionBackward", shutter[0] or shutter[1])):
        # Over the part of the shutter after, or before, the frame; pixels a frame.
        velocity = (_Expected(position, isMover, 1.0 + end, pan, velocityZ) - here) / end
        expected = velocity if name == "motionForward" else -velocity
        np.testing.assert_allclose(layers[name][isHit], expected[isHit], atol=2e-3)
        assert not layers[name][~isHit].any()
        assert np.abs(layers[name][isMover]).max() > 1.0


def test_nothing_moves_where_motion_blur_is_off(tmp_path):
    layers = _Render(tmp_path, pan=0.5, motionBlur="off")
    assert not layers["motionForward"].any() and not layers["motionBackward"].any()


def test_bits_are_those_of_any_pool(tmp_path):
    whole = _Render(tmp_path, pan=0.5, near=0.5, far=-0.5)
    streamed = _Render(tmp_path, pan=0.5, near=0.5, far=-0.5, residency="stream", geometryMemory="70%")
    assert all(pixels.tobytes() == streamed[name].tobytes() for name, pixels in whole.items())


def test_vectors_go_round_a_panorama(tmp_path):
    """A camera that turns steadily sees all that stands move by the same, also across the seam behind it."""
    stage = tmp_path / "turning.usda"
    stage.write_text("""#usda 1.0
(
    upAxis = "Y"
)
def Xform "World" {
    def Camera "Camera" {
        token hdstream:camera:projection = "latlong"
        double shutter:open = -0.5
        double shutter:close = 0.5
        double xformOp:rotateY.timeSamples = { 0.5: -5, 1.5: 5 }
        uniform token[] xformOpOrder = ["xformOp:rotateY"]
    }
    def DomeLight "Sky" {
    }
    def Cube "Room" {
        double size = 10
    }
}
""", encoding="utf-8")
    image = hdstream.Renderer(str(stage)).Render(1.0, camera="/World/Camera", imageWidth=WIDTH, imageHeight=HEIGHT, samples=1, aovs=_AOVS, noCache=True)
    for name, sign in (("motionForward", 1.0), ("motionBackward", -1.0)):
        expected = np.broadcast_to([sign * WIDTH * 10.0 / 360.0, 0.0], (HEIGHT, WIDTH, 2))
        np.testing.assert_allclose(image.aovs[name], expected, atol=5e-3)
