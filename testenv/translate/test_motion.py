# SPDX-License-Identifier: Apache-2.0
"""Samples while the shutter is open are what the stage has at those times."""

import numpy as np
import pytest
from pxr import Usd

from hdstream import _core
from hdstream.translate import TranslateStage
from hdstream.translate.motion import ReadShutter
from translateCase import FOLDER, StageOf

SHUTTER = (-0.25, 0.5)


def SceneAt(stage, timeCode, shutter=(0.0, 0.0)):
    session = _core.Session()
    TranslateStage(stage, session, timeCode, shutter)
    return session.Scene()


@pytest.mark.parametrize("case, time", [("skinning", 2.5), ("motion", 2.0)])
def test_points_are_those_of_the_shutters_ends(case, time):
    stage = Usd.Stage.Open(str(FOLDER / case / "scene.usda"))
    moving = SceneAt(stage, time, SHUTTER).geometry
    ends = [SceneAt(stage, time + end).geometry for end in SHUTTER]
    numMoving = 0
    for path, prim in moving.items():
        points = [scene[path].geometry.points for scene in ends]
        if prim.geometry.samples:
            numMoving += 1
            assert [sample[0] for sample in prim.geometry.samples] == list(SHUTTER)
            for (_, found), expected in zip(prim.geometry.samples, points):
                np.testing.assert_allclose(found, expected, atol=1e-5)
        elif len(points[0]) == len(points[1]) == len(prim.geometry.points):
            np.testing.assert_array_equal(points[0], points[1], path)
    assert numMoving > 0, "the test would show little"


def test_transforms_are_those_of_nine_times():
    stage = StageOf("""
        def Xform "A"
        {
            double xformOp:rotateZ.timeSamples = { 0: 0, 2: 400 }
            uniform token[] xformOpOrder = ["xformOp:rotateZ"]
            def Mesh "M"
            {
                int[] faceVertexCounts = [3]
                int[] faceVertexIndices = [0, 1, 2]
                point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
                double3 xformOp:translate = (1, 2, 3)
                uniform token[] xformOpOrder = ["xformOp:translate"]
            }
        }
        """)
    samples = SceneAt(stage, 1.0, SHUTTER).geometry["/A/M"].placement.samples
    assert len(samples) == 9 and samples[0][0] == -0.25 and samples[-1][0] == 0.5
    for time, matrix in samples:
        expected = SceneAt(stage, 1.0 + time).geometry["/A/M"].placement.worldFromObject
        np.testing.assert_allclose(matrix, expected, atol=1e-12)


def test_nothing_moves_without_shutter_or_frame():
    stage = Usd.Stage.Open(str(FOLDER / "motion" / "scene.usda"))
    for time, shutter in ((2.0, (0.0, 0.0)), (Usd.TimeCode.Default(), SHUTTER)):
        scene = SceneAt(stage, time, shutter)
        assert not any(prim.geometry.samples or prim.placement.samples for prim in scene.geometry.values())
        assert not any(prim.samples for prim in scene.instancers.values())


@pytest.mark.parametrize("value", ["inf", "-inf", "nan", "None"])
def test_shutters_that_are_no_numbers_are_closed(value):
    stage = StageOf(f"""
        def Camera "A"
        {{
            double shutter:open = {value}
            double shutter:close = {value}
        }}
        """)
    assert ReadShutter(stage.GetPrimAtPath("/A"), Usd.TimeCode(1.0)) == (0.0, 0.0)


def test_a_shutter_of_a_wrong_type_is_closed():
    stage = StageOf("""
        def Camera "A"
        {
            double shutter:open = -0.5
            token shutter:close = "late"
        }
        """)
    assert ReadShutter(stage.GetPrimAtPath("/A"), Usd.TimeCode(1.0)) == (-0.5, 0.0)
