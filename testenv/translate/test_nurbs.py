# SPDX-License-Identifier: Apache-2.0
"""NURBS curves and patches, against circles and cylinders, which they are exactly, and against the recursive definition of
their basis functions (Cox 1972, de Boor 1972), written apart from the implementation."""

import functools
import tracemalloc

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from hdstream import _core
from hdstream.translate import nurbs
from translateCase import Translate

_S = np.sqrt(0.5)
_CIRCLE = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]], float)
_CIRCLE_WEIGHTS = [1, _S, 1, _S, 1, _S, 1, _S, 1]
_CIRCLE_KNOTS = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]


def _Basis(knots, i, order, u):
    """The definition, one number at a time."""
    if order == 1:
        return 1.0 if knots[i] <= u < knots[i + 1] else 0.0
    left = right = 0.0
    if knots[i + order - 1] > knots[i]:
        left = (u - knots[i]) / (knots[i + order - 1] - knots[i]) * _Basis(knots, i, order - 1, u)
    if knots[i + order] > knots[i + 1]:
        right = (knots[i + order] - u) / (knots[i + order] - knots[i + 1]) * _Basis(knots, i + 1, order - 1, u)
    return left + right


def _PointAt(knots, order, weights, points, u):
    values = np.array([_Basis(knots, i, order, u) for i in range(len(points))]) * weights
    return values @ points / values.sum()


def _Bezier(points, t):
    t = np.asarray(t)[:, None]
    return (1 - t) ** 3 * points[0] + 3 * (1 - t) ** 2 * t * points[1] + 3 * (1 - t) * t * t * points[2] + t ** 3 * points[3]


def _Pieces(points):
    return [points[i:i + 4] for i in range(0, len(points) - 1, 3)]


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
@pytest.mark.parametrize("isRational", [False, True])
def test_curves_are_those_of_the_definition(order, isRational):
    random = np.random.default_rng(order)
    count = 9
    knots = np.concatenate([[0] * order, np.sort(random.random(count - order)) * 5, [5] * order])
    if order == 4:
        knots[order + 1] = knots[order]  # a knot of multiplicity two
    points = random.random((count, 3))
    weights = random.uniform(0.5, 2, count) if isRational else np.ones(count)
    bezier = nurbs.BezierRows(knots, order, weights if isRational else None) @ points
    ends = np.unique(knots)
    pieces = _Pieces(bezier)
    numPieces = len(pieces) // (len(ends) - 1)
    assert numPieces == (1 if order <= 4 and not isRational else 16)
    worst = 0
    for number, piece in enumerate(pieces):
        span, part = divmod(number, numPieces)
        step = (ends[span + 1] - ends[span]) / numPieces
        for t in (0.0, 0.21, 0.5, 0.83):
            expected = _PointAt(knots, order, weights, points, ends[span] + step * (part + t))
            worst = max(worst, np.abs(_Bezier(piece, [t])[0] - expected).max())
    assert worst < (1e-7 if numPieces == 1 else 2e-3)


def _Curves(stage, path="/C"):
    curves = UsdGeom.NurbsCurves.Define(stage, path)
    curves.CreateCurveVertexCountsAttr([9, 4])
    curves.CreateOrderAttr([3, 4])
    curves.CreateKnotsAttr(Vt.DoubleArray(_CIRCLE_KNOTS + [0, 0, 0, 0, 1, 1, 1, 1]))
    curves.CreateRangesAttr([Gf.Vec2d(0, 4), Gf.Vec2d(0, 1)])
    line = [(0, 0, 1), (1, 0, 1), (2, 3, 1), (3, 0, 1)]
    points = [(*p, 0) for p in _CIRCLE] + line
    curves.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points])
    curves.GetPrim().GetAttribute("pointWeights").Set(Vt.DoubleArray([float(w) for w in _CIRCLE_WEIGHTS] + [1.0] * 4))
    return curves


def test_a_prim_becomes_bezier_curves():
    stage = Usd.Stage.CreateInMemory()
    curves = _Curves(stage)
    curves.CreateWidthsAttr([0.1] * 9 + [0.1, 0.1, 0.4, 0.4])
    curves.SetWidthsInterpolation("vertex")
    session = Translate(stage)
    geometry = session.Scene().geometry["/C"].geometry
    assert (geometry.curves.type, geometry.curves.basis, geometry.curves.wrap) == ("cubic", "bezier", "nonperiodic")
    circle = geometry.points[:geometry.faceVertexCounts[0]]
    for piece in _Pieces(circle):
        radii = np.linalg.norm(_Bezier(piece.astype(float), np.linspace(0, 1, 9))[:, :2], axis=1)
        assert radii == pytest.approx(np.ones(9), abs=3e-6)
    widths = {primvar.name: primvar for primvar in geometry.primvars}["widths"]
    assert widths.interpolation == _core.Interpolation.Vertex and len(widths.values) == len(geometry.points)
    assert widths.values[:geometry.faceVertexCounts[0]].ravel() == pytest.approx(np.full(len(circle), 0.1), abs=1e-6)
    # Another curve's weights and knots are its own: it is one Bezier curve already where it is polynomial.
    last = geometry.points[-1]
    assert last == pytest.approx((3, 0, 1), abs=1e-6)
    assert not session.Warnings()


def test_samples_in_time_follow():
    stage = Usd.Stage.CreateInMemory()
    curves = _Curves(stage)
    atRest = np.array(curves.GetPointsAttr().Get())
    for time in (0, 1):
        curves.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy((atRest + (time, 0, 0)).astype(np.float32)), time)
    camera = UsdGeom.Camera.Define(stage, "/Camera")  # its shutter counts
    camera.CreateShutterOpenAttr(0.0)
    camera.CreateShutterCloseAttr(1.0)
    session = Translate(stage, 0)
    geometry = session.Scene().geometry["/C"].geometry
    assert [time for time, _ in geometry.samples] == [0, 1]
    assert geometry.samples[1][1] - geometry.samples[0][1] == pytest.approx(
        np.tile((1, 0, 0), (len(geometry.points), 1)), abs=1e-6)


@pytest.mark.parametrize("interpolation, indexed", [("constant", False), ("uniform", False), ("vertex", False), ("vertex", True)])
def test_widths_that_vary_in_time_follow(interpolation, indexed):
    """Widths at the shutter's ends are those that a still frame has there."""
    def Stage(isOpen):
        stage = Usd.Stage.CreateInMemory()
        curves = _Curves(stage)
        count = {"constant": 1, "uniform": 2, "vertex": 13}[interpolation]
        values = 0.1 + 0.05 * np.arange(count)
        name = "primvars:widths" if indexed else "widths"
        widths = curves.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.FloatArray)
        widths.SetMetadata("interpolation", interpolation)
        for time in (0, 1):
            widths.Set(Vt.FloatArray((values * (1 + time)).tolist()), time)
        if indexed:
            curves.GetPrim().CreateAttribute(name + ":indices", Sdf.ValueTypeNames.IntArray).Set(list(range(count))[::-1])
        if isOpen:
            camera = UsdGeom.Camera.Define(stage, "/Camera")
            camera.CreateShutterOpenAttr(0.0)
            camera.CreateShutterCloseAttr(1.0)
        return stage

    moving = Translate(Stage(True), 0).Scene().geometry["/C"].geometry
    assert [time for time, _ in moving.widthSamples] == [0, 1]
    for time, values in moving.widthSamples:
        still = Translate(Stage(False), time).Scene().geometry["/C"].geometry
        expected = {primvar.name: primvar for primvar in still.primvars}["widths"].values
        np.testing.assert_array_equal(np.asarray(values).ravel(), expected.ravel())


def test_negative_counts_take_no_points():
    """What follows them is drawn as without them."""
    stage = Usd.Stage.CreateInMemory()
    curves = _Curves(stage)
    expected = Translate(stage).Scene().geometry["/C"].geometry
    curves.GetCurveVertexCountsAttr().Set([9, -3, 4])
    curves.GetOrderAttr().Set([3, 3, 4])
    knots = list(curves.GetKnotsAttr().Get())
    curves.GetKnotsAttr().Set(Vt.DoubleArray(knots[:12] + [0.0] * 3 + knots[12:]))
    curves.GetRangesAttr().Set([Gf.Vec2d(0, 4), Gf.Vec2d(0, 1), Gf.Vec2d(0, 1)])
    session = Translate(stage)
    found = session.Scene().geometry["/C"].geometry
    np.testing.assert_array_equal(found.points, expected.points)
    assert session.Warnings() == ["/C: curves whose order, knots or weights make no NURBS are left out"]
    curves.GetCurveVertexCountsAttr().Set([-1, 9, 4])
    Translate(stage)  # knots that do not fit


@pytest.mark.parametrize("schema, weights, text", [
    ("curves", [1.0] * 12, "pointWeights has 12 values for 13 points; ignored"),
    ("patch", [1.0] * 17, "pointWeights has 17 values for 18 points; ignored"),
    ("patch", [1.0] * 17 + [0.0], "pointWeights has values that are not above 0; ignored")])
def test_weights_that_are_ignored_are_told(schema, weights, text):
    stage = Usd.Stage.CreateInMemory()
    prim = (_Curves(stage) if schema == "curves" else _Cylinder(stage)).GetPrim()
    prim.GetAttribute("pointWeights").Set(Vt.DoubleArray(weights))
    assert Translate(stage).Warnings() == [f"{prim.GetPath()}: {text}"]


def _Revolved(stage, profile, path="/P"):
    """The profile [(radius, z)], of order 3 where it has 5 points, else straight, turned around z."""
    patch = UsdGeom.NurbsPatch.Define(stage, path)
    isArc = len(profile) == 5
    patch.CreateUVertexCountAttr(9)
    patch.CreateVVertexCountAttr(len(profile))
    patch.CreateUOrderAttr(3)
    patch.CreateVOrderAttr(3 if isArc else 2)
    patch.CreateUKnotsAttr(Vt.DoubleArray(_CIRCLE_KNOTS))
    patch.CreateVKnotsAttr(Vt.DoubleArray([0, 0, 0, 1, 1, 2, 2, 2] if isArc else [0, 0, 1, 1]))
    patch.CreatePointsAttr([Gf.Vec3f(float(r * x), float(r * y), float(z)) for r, z in profile for x, y in _CIRCLE])
    along = _CIRCLE_WEIGHTS[:5] if isArc else [1, 1]
    patch.CreatePointWeightsAttr([float(w * v) for v in along for w in _CIRCLE_WEIGHTS])
    return patch


def test_poles_have_the_normal_of_the_surface():
    """A ball's normals are its points, at its poles too; a cone's at its tip are those of the lines that end there."""
    stage = Usd.Stage.CreateInMemory()
    _Revolved(stage, [(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)], "/Ball")
    _Revolved(stage, [(1, 0), (0, 2)], "/Cone")
    session = Translate(stage)
    ball, cone = (session.Scene().geometry[path].geometry for path in ("/Ball", "/Cone"))
    normals = {primvar.name: primvar for primvar in ball.primvars}["normals"].values
    assert np.linalg.norm(ball.points, axis=1) == pytest.approx(np.ones(len(ball.points)), abs=1e-6)
    assert (np.linalg.norm(ball.points[:, :2], axis=1) < 1e-6).sum() == 2 * 33  # both poles, once for each meridian
    assert normals == pytest.approx(ball.points, abs=5e-4)
    normals = {primvar.name: primvar for primvar in cone.primvars}["normals"].values.reshape(9, 33, 3)
    angles = np.arctan2(cone.points[:33, 1], cone.points[:33, 0])
    expected = np.stack([2 * np.cos(angles), 2 * np.sin(angles), np.ones(33)], 1) / np.sqrt(5)
    assert normals == pytest.approx(np.tile(expected, (9, 1, 1)), abs=1e-5)
    assert not session.Warnings()


def _Cylinder(stage, path="/P", leftHanded=False):
    """The circle along u, a line of length 2 along v."""
    patch = UsdGeom.NurbsPatch.Define(stage, path)
    patch.CreateUVertexCountAttr(9)
    patch.CreateVVertexCountAttr(2)
    patch.CreateUOrderAttr(3)
    patch.CreateVOrderAttr(2)
    patch.CreateUKnotsAttr(Vt.DoubleArray(_CIRCLE_KNOTS))
    patch.CreateVKnotsAttr([0, 0, 1, 1])
    patch.CreateURangeAttr(Gf.Vec2d(0, 4))
    patch.CreateVRangeAttr(Gf.Vec2d(0, 1))
    patch.CreatePointsAttr([Gf.Vec3f(float(x), float(y), z) for z in (-1.0, 1.0) for x, y in _CIRCLE])
    patch.CreatePointWeightsAttr([float(w) for w in _CIRCLE_WEIGHTS] * 2)
    if leftHanded:
        patch.CreateOrientationAttr("leftHanded")
    return patch


@pytest.mark.parametrize("leftHanded", [False, True])
def test_patches_are_the_surface_with_its_normals(leftHanded):
    stage = Usd.Stage.CreateInMemory()
    _Cylinder(stage, leftHanded=leftHanded)
    session = Translate(stage)
    mesh = session.Scene().geometry["/P"].geometry
    points = mesh.points.astype(float)
    assert np.linalg.norm(points[:, :2], axis=1) == pytest.approx(np.ones(len(points)), abs=1e-6)
    normals = {primvar.name: primvar for primvar in mesh.primvars}["normals"].values
    outwards = np.concatenate([points[:, :2], np.zeros((len(points), 1))], 1)
    assert normals == pytest.approx((-1 if leftHanded else 1) * outwards, abs=1e-5)
    # Faces turn as the surface does: their cross products are along du x dv.
    quads = points[mesh.faceVertexIndices.reshape(-1, 4)]
    cross = np.cross(quads[:, 1] - quads[:, 0], quads[:, 2] - quads[:, 0])
    assert (np.einsum("ni,ni->n", cross, quads.mean(1) * (1, 1, 0)) > 0).all()
    assert 0.5 * np.linalg.norm(np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]), axis=1).sum() == pytest.approx(
        4 * np.pi, rel=2e-3)
    assert mesh.leftHanded == leftHanded and not session.Warnings()


def test_patches_are_those_of_the_definition():
    random = np.random.default_rng(1)
    stage = Usd.Stage.CreateInMemory()
    patch = UsdGeom.NurbsPatch.Define(stage, "/P")
    sizes, orders = (6, 5), (4, 3)
    knots = [np.concatenate([[0] * order, np.sort(random.random(size - order)), [1] * order])
             for size, order in zip(sizes, orders)]
    points, weights = random.random((30, 3)), random.uniform(0.5, 2, 30)
    for axis, size, order, own in zip("UV", sizes, orders, knots):
        getattr(patch, f"Create{axis}VertexCountAttr")(size)
        getattr(patch, f"Create{axis}OrderAttr")(order)
        getattr(patch, f"Create{axis}KnotsAttr")(Vt.DoubleArray(own.tolist()))
    patch.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    patch.CreatePointWeightsAttr(weights.tolist())
    UsdGeom.PrimvarsAPI(patch).CreatePrimvar("h", Sdf.ValueTypeNames.FloatArray, "vertex").Set(points[:, 0].astype(np.float32).tolist())
    mesh = Translate(stage).Scene().geometry["/P"].geometry
    at = [np.unique(np.concatenate([np.linspace(a, b, 9) for a, b in zip(np.unique(own)[:-1], np.unique(own)[1:])]))
          for own in knots]
    for index in (0, 7, len(at[0]) * 3 + 5, len(mesh.points) - 2 - len(at[0])):
        v, u = divmod(index, len(at[0]))
        values = np.array([_Basis(knots[0], i, 4, at[0][u]) * _Basis(knots[1], j, 3, at[1][v])
                           for j in range(5) for i in range(6)]) * weights
        assert mesh.points[index] == pytest.approx(values @ points / values.sum(), abs=1e-6)
    heights = {primvar.name: primvar for primvar in mesh.primvars}["h"].values
    assert heights.ravel() == pytest.approx(mesh.points[:, 0], abs=1e-6)


@pytest.mark.parametrize("isRational", [False, True])
@pytest.mark.parametrize("schema", ["NurbsPatch", "NurbsCurves"])
def test_memory_is_that_of_what_is_drawn(schema, isRational):
    """A matrix from all points to all of the grid, or of the pieces, has 130 MB here and 8 GB at 64 x 64 points."""
    side = 24 if schema == "NurbsPatch" else 1500
    random = np.random.default_rng(3)
    knots = np.concatenate([[0] * 3, np.arange(side - 2), [side - 3] * 3]).astype(float)
    numPoints = side * side if schema == "NurbsPatch" else side
    points = random.random((numPoints, 3)).astype(np.float32)
    weights = random.uniform(0.5, 2, numPoints) if isRational else np.ones(numPoints)
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/P", schema)
    prim.GetAttribute("points").Set(Vt.Vec3fArray.FromNumpy(points))
    if isRational:
        prim.GetAttribute("pointWeights").Set(Vt.DoubleArray(weights.tolist()))
    if schema == "NurbsPatch":
        for axis in "uv":
            prim.GetAttribute(f"{axis}VertexCount").Set(side)
            prim.GetAttribute(f"{axis}Order").Set(4)
            prim.GetAttribute(f"{axis}Knots").Set(Vt.DoubleArray(knots.tolist()))
    else:
        prim.GetAttribute("curveVertexCounts").Set([side])
        prim.GetAttribute("order").Set([4])
        prim.GetAttribute("knots").Set(Vt.DoubleArray(knots.tolist()))
    tracemalloc.start()
    try:
        geometry = Translate(stage).Scene().geometry["/P"].geometry
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 30e6
    # A point in the middle, of few others: basis functions of others are 0 there.
    at = side // 2 + 0.125
    values = np.array([_Basis(knots, i, 4, at) if abs(i - at) < 6 else 0.0 for i in range(side)])
    if schema == "NurbsPatch":
        numAlong = 8 * (side - 3) + 1
        index = round(8 * at)
        values = np.outer(values, values).ravel() * weights
        assert geometry.points[index * numAlong + index] == pytest.approx(values @ points / values.sum(), abs=1e-5)
    else:
        values = values * weights
        piece, part = divmod(at, 1 / 16 if isRational else 1)
        assert _Bezier(geometry.points[3 * int(piece):][:4].astype(float), [part])[0] == pytest.approx(
            values @ points / values.sum(), abs=1e-5)


def test_what_is_no_nurbs_is_named():
    stage = Usd.Stage.CreateInMemory()
    curves = _Curves(stage)
    knots = list(curves.GetKnotsAttr().Get())
    curves.GetKnotsAttr().Set(Vt.DoubleArray([9.0] + knots[1:]))  # they descend
    patch = _Cylinder(stage)
    patch.GetUOrderAttr().Set(4)
    trimmed = _Cylinder(stage, "/T")
    trimmed.CreateTrimCurveCountsAttr([1])
    session = Translate(stage)
    lines = list(session.Warnings())
    assert any(line.startswith("/C") and "left out" in line for line in lines)
    assert any(line.startswith("/P") and "no NURBS patch" in line for line in lines)
    assert any(line.startswith("/T") and "trim" in line for line in lines)
    assert len(lines) == 3 and "/P" not in session.Scene().geometry
    left = session.Scene().geometry["/C"].geometry  # the other curve
    assert left.faceVertexCounts.tolist() == [len(left.points)] and left.points[-1] == pytest.approx((3, 0, 1), abs=1e-6)
