# SPDX-License-Identifier: Apache-2.0
"""What changes while the shutter is open against 256 still pictures, by a z-test of each block of pixels.

The stills are pictures of the stage at random times of 256 equal parts of the interval, without motion blur: the front
end's samples, the device's keys and their interpolation take no part in them.
"""

import numpy as np
import pytest
from pxr import UsdGeom

pytest.importorskip("hdstream._core")

import hdstream
from stages import author, motion

WIDTH, HEIGHT, BLOCK = 48, 36, 6
GROUPS, STILLS_OF_GROUP, STILL_SAMPLES = 8, 32, 4
SETTINGS = dict(imageWidth=WIDTH, imageHeight=HEIGHT, camera="/World/Camera", pixelFilter="box", pixelFilterWidth=1.0, maxDepth=1,
                noCache=True)


def _Blocks(picture):
    return picture[..., :3].astype(np.float64).reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, 3).mean((1, 3))


def _Pictures(renderer):
    """(blurred, of stills) means of blocks, [GROUPS] each, independent of each other."""
    rng = np.random.default_rng(9)
    blurred, stills = [], []
    for group in range(GROUPS):
        blurred.append(_Blocks(renderer.Render(motion.FRAME, **SETTINGS, samples=STILLS_OF_GROUP * STILL_SAMPLES,
                                               seed=1 + group).aovs["color"]))
    # Every group has a time in each of its parts; all groups together have one in each of 256.
    parts = np.arange(STILLS_OF_GROUP * GROUPS).reshape(STILLS_OF_GROUP, GROUPS).T
    times = motion.FRAME + motion.SHUTTER[0] + (parts + rng.random(parts.shape)) / parts.size * (motion.SHUTTER[1] - motion.SHUTTER[0])
    sums = np.zeros((GROUPS, *blurred[0].shape))
    for i, time in sorted(enumerate(times.reshape(-1)), key=lambda one: one[1]):
        picture = renderer.Render(float(time), **SETTINGS, samples=STILL_SAMPLES, seed=100 + i, motionBlur="off").aovs["color"]
        sums[i // STILLS_OF_GROUP] += _Blocks(picture)
    stills = sums / STILLS_OF_GROUP
    return np.array(blurred), stills


def _Scores(a, b):
    """The differences of means over their standard errors; Welch 1947."""
    error = np.sqrt(a.var(0, ddof=1) / len(a) + b.var(0, ddof=1) / len(b))
    return (a.mean(0) - b.mean(0)) / np.maximum(error, 1e-5)


# Ways that bend between the keys, and surfaces whose limit is not a straight mean of those of two keys, are near, not equal.
BENT = ("quaternionArm", "face", "gprims")


@pytest.mark.parametrize("name", [*motion.SCENES, *motion.KEYS, *motion.LIGHTS, *motion.SHAPES, *motion.CAMERAS, *motion.VOLUMES])
def test_blur_is_the_average_of_256_stills(name, tmp_path):
    renderer = hdstream.Renderer(motion.Write(tmp_path / "a.usda", name), onWarning=lambda line: None)
    blurred, stills = _Pictures(renderer)
    scores = _Scores(blurred, stills)
    if name in BENT:
        off = blurred.mean(0) / stills.mean(0) - 1
        assert np.abs(off).max() < 0.02, off
    else:  # of about 14 degrees of freedom: a score above 6.5 has a chance of 1e-5, and there are 144
        assert np.abs(scores).max() < 6.5, scores
        assert np.sqrt((scores ** 2).mean()) < 1.35, scores
    still = _Blocks(renderer.Render(motion.FRAME, **SETTINGS, samples=512, motionBlur="off").aovs["color"])
    distance = np.abs(_Scores(blurred, np.repeat(still[None], 2, 0)))
    assert (distance > 8).mean() > 0.05, "the test would show little"


def test_a_light_that_is_dark_for_half_of_the_shutter_is_there_for_the_other_half(tmp_path):
    stage = author.NewStage(tmp_path / "a.usda")
    panel = author.AddLight(stage, "/World/Panel", "Rect", dict(translate=(0, 0, -1)), width=20.0, height=20.0)
    UsdGeom.Xformable(panel).AddRotateYOp().Set(180.0)  # its front is seen
    for time, intensity in ((0.5, -2.0), (1.5, 2.0)):  # what is below 0 is dark
        panel.GetIntensityAttr().Set(intensity, time)
    camera = author.AddCamera(stage, eye=(0, 0, 6), focalLength=40.0)
    camera.CreateShutterOpenAttr(-0.5)
    camera.CreateShutterCloseAttr(0.5)
    stage.GetRootLayer().Save()
    lines = []
    renderer = hdstream.Renderer(str(tmp_path / "a.usda"), onWarning=lines.append)
    picture = renderer.Render(1.0, **SETTINGS, samples=64, seed=1).aovs["color"].astype(np.float64).mean((0, 1))
    assert picture == pytest.approx([0.5, 0.5, 0.5, 0.5], abs=0.005)  # 1e5 samples: 0.0018 and 0.0011
    assert not [line for line in lines if "emission" in line]
