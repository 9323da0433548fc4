# SPDX-License-Identifier: Apache-2.0
"""Hermite curves, against the definition of a cubic by its ends and its derivatives there."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, Vt

from hdstream import _core
from hdstream.translate.stageTranslator import TranslateStage
from translateCase import Translate

COUNTS = [4, 2, 3]
_RANDOM = np.random.default_rng(3)
POINTS = _RANDOM.uniform(-1, 1, (9, 3)).astype(np.float32)
TANGENTS = _RANDOM.uniform(-2, 2, (9, 3)).astype(np.float32)


def _Hermite(p, q, m, n, t):
    """Basis functions of the textbook: 1 or 0 at one end, with a derivative of 1 or 0."""
    return (2 * t**3 - 3 * t**2 + 1) * p + (t**3 - 2 * t**2 + t) * m + (3 * t**2 - 2 * t**3) * q + (t**3 - t**2) * n


def _Bezier(points, t):
    """De Casteljau."""
    points = np.asarray(points, float)
    while len(points) > 1:
        points = (1 - t) * points[:-1] + t * points[1:]
    return points[0]


def _Stage(points=POINTS, tangents=TANGENTS, counts=COUNTS):
    stage = Usd.Stage.CreateInMemory()
    curves = UsdGeom.HermiteCurves.Define(stage, "/C")
    curves.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    curves.CreateTangentsAttr(Vt.Vec3fArray.FromNumpy(tangents))
    curves.CreateCurveVertexCountsAttr(counts)
    return stage, curves


def _Check(bezier, counts, points, tangents):
    """That Bezier curves, one behind another, are the Hermite curves."""
    assert list(counts) == [3 * count - 2 for count in COUNTS] and len(bezier) == sum(counts)
    first = own = 0
    for count in COUNTS:
        for i in range(count - 1):
            piece = bezier[first + 3 * i:first + 3 * i + 4]
            for t in (0.0, 0.2, 0.5, 0.9, 1.0):
                expected = _Hermite(points[own + i], points[own + i + 1], tangents[own + i], tangents[own + i + 1], t)
                assert _Bezier(piece, t) == pytest.approx(expected, abs=1e-6)
        first, own = first + 3 * count - 2, own + count


def test_curves_are_those_of_the_definition():
    stage, _ = _Stage()
    session = Translate(stage)
    geometry = session.Scene().geometry["/C"].geometry
    form = geometry.curves
    assert (form.type, form.basis, form.wrap) == ("cubic", "bezier", "nonperiodic")
    _Check(geometry.points, geometry.faceVertexCounts, POINTS.astype(float), TANGENTS.astype(float))
    assert not session.Warnings()


def test_values_of_points_are_linear_between_them():
    stage, curves = _Stage()
    curves.CreateWidthsAttr([0.1 * i for i in range(9)])
    primvars = UsdGeom.PrimvarsAPI(curves)
    primvars.CreatePrimvar("a", Sdf.ValueTypeNames.FloatArray, "vertex").Set([float(i) for i in range(9)])
    indexed = primvars.CreatePrimvar("b", Sdf.ValueTypeNames.Color3fArray, "varying")
    indexed.Set([(1, 0, 0), (0, 1, 0)])
    indexed.SetIndices([0, 1] * 4 + [0])
    primvars.CreatePrimvar("c", Sdf.ValueTypeNames.FloatArray, "uniform").Set([1, 2, 3])
    found = {primvar.name: primvar for primvar in Translate(stage).Scene().geometry["/C"].geometry.primvars}
    assert all(found[name].interpolation == _core.Interpolation.Varying for name in ("a", "b", "widths"))
    assert found["c"].interpolation == _core.Interpolation.Uniform
    assert found["a"].values.tolist() == [float(i) for i in range(9)] and found["b"].indices.tolist() == [0, 1] * 4 + [0]


@pytest.mark.parametrize("moving", ["points", "tangents", "both"])
def test_curves_move_while_the_shutter_is_open(moving):
    """Linearly between samples at 0, 1 and 2, of points or tangents at other frames than of the other."""
    stage, curves = _Stage()
    step = _RANDOM.uniform(-1, 1, (2, 9, 3)).astype(np.float32)
    pointsAt, tangentsAt = (lambda t: POINTS), (lambda t: TANGENTS)
    if moving != "tangents":
        pointsAt = lambda t: POINTS + step[0] * t + step[1] * max(t - 1, 0)  # noqa: E731
        for frame in (0, 1, 2):
            curves.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(pointsAt(frame).astype(np.float32)), frame)
    if moving != "points":
        tangentsAt = lambda t: TANGENTS + step[1] * t  # noqa: E731
        for frame in (0, 2):
            curves.GetTangentsAttr().Set(Vt.Vec3fArray.FromNumpy(tangentsAt(frame).astype(np.float32)), frame)
    session = _core.Session()
    TranslateStage(stage, session, 0.75, (-0.5, 0.75))
    geometry = session.Scene().geometry["/C"].geometry
    times = [time for time, _ in geometry.samples]
    assert times == ([-0.5, 0.75] if moving == "tangents" else [-0.5, 0.25, 0.75])
    for time, points in geometry.samples:
        _Check(np.asarray(points, float).reshape(-1, 3), geometry.faceVertexCounts, pointsAt(0.75 + time), tangentsAt(0.75 + time))


@pytest.mark.parametrize("wrong", [dict(tangents=TANGENTS[:8]), dict(counts=[4, 2]), dict(counts=[4, 4, 1])],
                         ids=["tangents", "points", "short"])
def test_what_has_no_tangents_is_lines(wrong):
    stage, _ = _Stage(**wrong)
    session = Translate(stage)
    assert session.Scene().geometry["/C"].geometry.curves.type == "linear"
    assert any(line.startswith("/C: HermiteCurves are drawn as lines between their points") for line in session.Warnings())
