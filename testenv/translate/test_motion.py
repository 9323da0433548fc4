# SPDX-License-Identifier: Apache-2.0
"""Samples while the shutter is open are what the stage has at those times."""

import functools

import numpy as np
import pytest
from pxr import Sdf, Usd

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
def test_points_are_those_of_the_shutters_ends_and_of_samples_between(case, time):
    stage = Usd.Stage.Open(str(FOLDER / case / "scene.usda"))
    moving = SceneAt(stage, time, SHUTTER).geometry
    sceneAt = functools.cache(lambda offset: SceneAt(stage, time + offset).geometry)
    numMoving = 0
    for path, prim in moving.items():
        points = [sceneAt(end)[path].geometry.points for end in SHUTTER]
        if prim.geometry.samples:
            numMoving += 1
            times = [sample[0] for sample in prim.geometry.samples]
            assert (times[0], times[-1]) == SHUTTER and times == sorted(set(times))
            for offset, found in prim.geometry.samples:
                np.testing.assert_allclose(found, sceneAt(offset)[path].geometry.points, atol=1e-5)
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


_SCALED = """
    def Xform "R"
    {{
        double3 xformOp:translate.timeSamples = {{ 0: (0, 0, 0), 2: (4, 0, 0) }}
        uniform token[] xformOpOrder = ["xformOp:translate"]
    def Xform "A" (prepend apiSchemas = ["MotionAPI"])
    {{
        float motion:blurScale = {scale}
        double xformOp:rotateZ.timeSamples = {{ 0: 0, 1: 70, 3: 400 }}
        uniform token[] xformOpOrder = ["xformOp:rotateZ"]
        def Mesh "M"
        {{
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points.timeSamples = {{
                0: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], 1: [(3, 0, 0), (1, 0, 0), (0, 1, 0)], 2: [(0, 0, 5), (1, 0, 0), (0, 1, 0)]
            }}
            double3 xformOp:translate = (1, 2, 3)
            uniform token[] xformOpOrder = ["xformOp:translate"]
        }}
        def Mesh "N" (prepend apiSchemas = ["MotionAPI"])
        {{
            float motion:blurScale = 0
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        }}
    }}
    }}
    """


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_blur_scale_is_another_shutter(scale):
    """The samples of a shutter that much as long, at the times of the shutter."""
    found = SceneAt(StageOf(_SCALED.format(scale=scale)), 1.0, SHUTTER).geometry
    expected = SceneAt(StageOf(_SCALED.format(scale=1)), 1.0, tuple(scale * end for end in SHUTTER)).geometry
    for path in ("/R/A/M", "/R/A/N"):
        for samples, others in ((found[path].placement.samples, expected[path].placement.samples),
                                (found[path].geometry.samples, expected[path].geometry.samples)):
            assert len(samples) == len(others) and (samples or path == "/R/A/N")
            for (time, value), (otherTime, other) in zip(samples, others):
                assert time == pytest.approx(otherTime / scale, abs=1e-6)
                np.testing.assert_allclose(value, other, atol=1e-12)


@pytest.mark.parametrize("value", ["-1", "inf", "nan"])
def test_blur_scales_that_are_none_are_told(value):
    session = _core.Session()
    TranslateStage(StageOf(_SCALED.format(scale=value)), session, 1.0, SHUTTER)
    assert sum("motion:blurScale" in line and "/R/A" in line for line in session.Warnings()) == 1
    assert len(session.Scene().geometry["/R/A/M"].placement.samples) == 9


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


def _Sampled(text):
    """The stage's one gprim, with samples at frames."""
    return SceneAt(StageOf(text), 1.0, SHUTTER).geometry["/A"].geometry


def test_points_are_sampled_where_the_stage_has_samples():
    geometry = _Sampled("""
        def Points "A"
        {
            point3f[] points.timeSamples = { 0: [(0, 0, 0)], 0.9: [(3, 0, 0)], 1.25: [(0, 1, 0)], 2: [(0, 0, 0)] }
            float[] widths.timeSamples = { 1: [1], 1.125: [3] }
        }
        """)
    times = [time for time, _ in geometry.samples]
    np.testing.assert_allclose(times, [-0.25, -0.1, 0.25, 0.5], atol=1e-7)
    np.testing.assert_allclose([points[0] for _, points in geometry.samples],
                               [(2.5, 0, 0), (3, 0, 0), (0, 1, 0), (0, 2 / 3, 0)], atol=1e-5)
    np.testing.assert_allclose([time for time, _ in geometry.widthSamples], [-0.25, 0.0, 0.125, 0.5])
    np.testing.assert_allclose([widths[0] for _, widths in geometry.widthSamples], [1, 1, 3, 3])


def test_shapes_of_splats_are_sampled():
    geometry = _Sampled("""
        def ParticleField3DGaussianSplat "A"
        {
            point3f[] positions = [(0, 0, 0)]
            quatf[] orientations.timeSamples = { 1: [(1, 0, 0, 0)], 2: [(0, 1, 0, 0)] }
            float3[] scales.timeSamples = { 0.9: [(1, 2, 3)], 1.25: [(4, 2, 3)] }
            half[] opacitiesh.timeSamples = { 0: [0], 2: [1] }
        }
        """)
    assert geometry.samples == []
    shapes = geometry.splatSamples
    assert [time for time, _ in shapes.orientations] == [-0.25, 0.0, 0.5]
    np.testing.assert_allclose(shapes.orientations[2][1], (np.sqrt(0.5), 0, 0, np.sqrt(0.5)), atol=1e-6)
    np.testing.assert_allclose([time for time, _ in shapes.scales], [-0.25, -0.1, 0.25, 0.5], atol=1e-7)
    np.testing.assert_array_equal(shapes.scales[-1][1], (4, 2, 3))
    np.testing.assert_allclose([float(values[0]) for _, values in shapes.opacities], [0.375, 0.75])


def test_accelerations_bend_the_way():
    geometry = _Sampled("""
        def Points "A"
        {
            point3f[] points.timeSamples = { 1: [(0, 0, 0)] }
            vector3f[] velocities.timeSamples = { 1: [(24, 0, 0)] }
            vector3f[] accelerations.timeSamples = { 1: [(0, 1152, 0)] }
            float[] widths = [1]
        }
        """)
    assert len(geometry.samples) == 17
    for time, points in geometry.samples:
        np.testing.assert_allclose(points[0], (time, time ** 2, 0), atol=1e-6)


def test_normals_are_sampled():
    geometry = _Sampled("""
        def Mesh "A"
        {
            uniform token subdivisionScheme = "none"
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
            normal3f[] normals.timeSamples = { 1: [(0, 0, 1), (0, 0, 1), (0, 0, 1)], 1.25: [(0, 1, 0), (0, 1, 0), (0, 1, 0)] }
        }
        """)
    assert [time for time, _ in geometry.normalSamples] == [-0.25, 0.0, 0.25, 0.5]
    np.testing.assert_array_equal(geometry.normalSamples[2][1][0], (0, 1, 0))
    assert not geometry.samples


@pytest.mark.parametrize("velocities", [False, True])
def test_topology_that_changes_is_warned_of_unless_velocities_move_it(velocities):
    stage = StageOf("""
        def Mesh "A"
        {
            int[] faceVertexCounts.timeSamples = { 1: [3], 1.25: [4] }
            int[] faceVertexIndices.timeSamples = { 1: [0, 1, 2], 1.25: [0, 1, 2, 3] }
            point3f[] points.timeSamples = { 1: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], 1.25: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)] }
        }
        """)
    if velocities:
        attribute = stage.GetPrimAtPath("/A").CreateAttribute("velocities", Sdf.ValueTypeNames.Vector3fArray)
        attribute.Set([(0, 0, 24)] * 4, 1.0)
        attribute.Set([(0, 0, 0)] * 4, 1.25)
    session = _core.Session()
    TranslateStage(stage, session, 1.0, SHUTTER)
    samples = session.Scene().geometry["/A"].geometry.samples
    warned = [line for line in session.Warnings() if "topology" in line]
    if velocities:
        assert not warned
        for time, points in samples:
            np.testing.assert_allclose(points[:, 2], time, atol=1e-6)
        assert len(samples) == 2
    else:
        assert warned == ["/A: its topology changes while the shutter is open: drawn without motion blur"] and not samples


@pytest.mark.parametrize("shutter, time", [(SHUTTER, 1.0), ((0.0, 0.0), 1.0), ((0.0, 0.0), 1.5)])
def test_points_whose_velocities_are_not_finite_stand_still(shutter, time):
    stage = StageOf("""
        def Mesh "A"
        {
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points.timeSamples = { 1: [(0, 0, 0), (1, 0, 0), (0, 1, 0)] }
            vector3f[] velocities.timeSamples = { 1: [(0, 0, 24), (0, nan, 0), (inf, 0, 0)] }
        }
        """)
    session = _core.Session()
    TranslateStage(stage, session, time, shutter)
    geometry = session.Scene().geometry["/A"].geometry
    np.testing.assert_allclose(geometry.points, [(0, 0, time - 1), (1, 0, 0), (0, 1, 0)], atol=1e-6)
    assert len(geometry.samples) == (2 if shutter is SHUTTER else 0)
    for at, points in geometry.samples:
        np.testing.assert_allclose(points, [(0, 0, at), (1, 0, 0), (0, 1, 0)], atol=1e-6)
    warned = [line for line in session.Warnings() if "velocities" in line]
    assert warned == ["/A: velocities are not finite: points that have these stand still"] * (shutter is SHUTTER)


@pytest.mark.parametrize("shutter, time", [(SHUTTER, 1.0), ((0.0, 0.0), 1.0), ((0.0, 0.0), 1.5)])
def test_instances_whose_velocities_are_not_finite_stand_still(shutter, time):
    """The first goes and turns, the second does not go, the third does not turn, the fourth does neither; that of a position which
    is not finite is no matter of velocities."""
    stage = StageOf("""
        def PointInstancer "A"
        {
            rel prototypes = </A/P>
            int[] protoIndices = [0, 0, 0, 0, 0]
            point3f[] positions.timeSamples = { 1: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 2, 0), (nan, 0, 0)] }
            float3[] scales = [(1, 1, 1), (1, 2, 1), (1, 2, 1), (3, 2, 1), (1, 1, 1)]
            quath[] orientations.timeSamples = { 1: [(0.5, 0.5, 0.5, 0.5), (1, 0, 0, 0), (0.5, 0.5, 0.5, 0.5), (0.5, 0.5, 0.5, 0.5),
                                                     (1, 0, 0, 0)] }
            vector3f[] velocities.timeSamples = { 1: [(0, 0, 24), (0, nan, 0), (24, 0, 0), (inf, 0, 0), (0, 0, 0)] }
            vector3f[] angularVelocities.timeSamples = { 1: [(0, 0, 480), (0, 0, 480), (0, nan, 0), (0, 0, inf), (0, 0, 0)] }
            def Mesh "P"
            {
                int[] faceVertexCounts = [3]
                int[] faceVertexIndices = [0, 1, 2]
                point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
            }
        }
        """)
    session = _core.Session()
    TranslateStage(stage, session, time, shutter)
    instancer = session.Scene().instancers["/A"]
    samples = [(time - 1, instancer.instanceTransforms), *((at, matrices) for at, matrices in instancer.samples)]
    assert len(samples) == (18 if shutter is SHUTTER else 1)
    cycle = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float)  # what the orientation does to rows
    for at, matrices in samples:
        matrices = np.asarray(matrices).reshape(5, 4, 4)
        angle = np.radians(20.0 * at)
        turn = np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        np.testing.assert_allclose(matrices[:4, 3, :3], [(0, 0, at), (1, 0, 0), (at, 1, 0), (2, 2, 0)], atol=1e-6)
        for found, expected in zip(matrices, (cycle @ turn, np.diag([1, 2, 1]) @ turn, np.diag([1, 2, 1]) @ cycle,
                                              np.diag([3, 2, 1]) @ cycle)):
            np.testing.assert_allclose(found[:3, :3], expected, atol=1e-6)
        assert np.isnan(matrices[4, 3, 0])
    warned = [line for line in session.Warnings() if "velocities" in line]
    assert warned == ["/A: velocities are not finite: instances that have these stand still"] * (shutter is SHUTTER)


@pytest.mark.parametrize("velocities", [False, True])
def test_instances_that_change_in_number_are_told(velocities):
    stage = StageOf("""
        def PointInstancer "A"
        {
            rel prototypes = </A/P>
            int[] protoIndices.timeSamples = { 1: [0, 0], 1.25: [0, 0, 0] }
            point3f[] positions.timeSamples = { 1: [(0, 0, 0), (1, 0, 0)], 1.25: [(0, 1, 0), (1, 1, 0), (2, 1, 0)] }
            def Sphere "P" {}
        }
        """)
    if velocities:
        for time, count in ((1.0, 2), (1.25, 3)):
            stage.GetPrimAtPath("/A").GetAttribute("velocities").Set([(0, 0, 24)] * count, time)
    session = _core.Session()
    TranslateStage(stage, session, 1.0, SHUTTER)
    line = "/A: its instances change in number while the shutter is open: drawn without motion blur"
    assert session.Warnings() == ([] if velocities else [line])


_CHANGING = """
    def Xform "Rig" (prepend apiSchemas = ["MotionAPI"])
    {
        float motion:blurScale = %g
        def SphereLight "L"
        {
            float inputs:radius.timeSamples = { 0: 0.5, 2: 2.5 }
            float inputs:intensity.timeSamples = { 0: 3, 1: 5, 2: 1 }
            color3f inputs:color.timeSamples = { 0: (1, 0, 0), 2: (0, 1, 0.5) }
            float inputs:width.timeSamples = { 0: 1, 2: 3 }
            float inputs:exposure = 2
        }
        def RectLight "Still" { float inputs:width = 3 }
    }
    """


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_lights_that_change_have_what_the_stage_has_at_nine_times(scale):
    stage = StageOf(_CHANGING % scale)
    lights = SceneAt(stage, 1.0, SHUTTER).lights
    samples = lights["/Rig/L"].samples
    assert [sample.time for sample in samples] == pytest.approx(np.linspace(*SHUTTER, 9))
    for sample in samples:
        expected = SceneAt(stage, 1.0 + scale * sample.time).lights["/Rig/L"].light
        for name in ("radius", "intensity", "color", "exposure", "colorTemperature", "angle"):
            assert getattr(sample, name) == pytest.approx(getattr(expected, name)), name
    assert lights["/Rig/Still"].samples == []
    assert SceneAt(stage, 1.0).lights["/Rig/L"].samples == [], "the shutter is closed"


def test_inputs_of_other_types_that_change_keep_the_lights_own_values():
    stage = StageOf("""
        def SphereLight "L"
        {
            token inputs:radius.timeSamples = { 0: "wide", 2: "wider" }
        }
        """)
    light = SceneAt(stage, 1.0, SHUTTER).lights["/L"]
    assert [sample.radius for sample in light.samples] == [light.light.radius] * 9
