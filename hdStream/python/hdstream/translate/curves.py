# SPDX-License-Identifier: Apache-2.0
"""UsdGeomCurves and UsdGeomPoints as descriptions of curves and points."""

import numpy as np
from pxr import Vt

from hdstream import _core
from hdstream.translate import hermite, nurbs
from hdstream.translate.meshes import OrAgain, PosePoints, PoseSamples, ReadArray, ReadPoints
from hdstream.translate.motion import CHANGES_IN_NUMBER, SampleAt
from hdstream.translate.primvars import FloatRows, INTERPOLATIONS, PrimvarsOf

_DEFAULT_WIDTH = 1.0  # as UsdImaging has it
_TOKENS = {"type": ("linear", "cubic"), "basis": ("bezier", "bspline", "catmullRom"),
           "wrap": ("nonperiodic", "periodic", "pinned")}
_FALLBACKS = {"type": "cubic", "basis": "bezier", "wrap": "nonperiodic"}


def ReadCurves(prim, schema, names, inherited, timeCode, motion, warn, skin=None):
    """The description of UsdGeomCurves, in the pose of a Skin where there is one; None without points or without curves.
    Curves whose other attributes do not tell their shape are lines between their points, as UsdImaging has them."""
    if schema == "NurbsCurves" and "order" in names and "knots" in names:
        return _ReadNurbsCurves(prim, names, inherited, timeCode, motion, warn, skin)
    hermiteCurves = None
    if schema == "HermiteCurves" and skin is None:  # which says nothing of tangents
        hermiteCurves = _ReadHermiteCurves(prim, names, inherited, timeCode, motion, warn)
    return hermiteCurves or _ReadBasisCurves(prim, schema, names, inherited, timeCode, motion, warn, skin)


def _ReadBasisCurves(prim, schema, names, inherited, timeCode, motion, warn, skin):
    points = ReadPoints(prim, names, timeCode)
    counts = ReadArray(prim, "curveVertexCounts", timeCode, np.int32)
    if points is None or counts is None or not points.size or not counts.size:
        return None
    form = _core.CurveForm()
    form.type = "linear"
    for name, known in _TOKENS.items() if schema == "BasisCurves" else ():
        value = prim.GetAttribute(name).Get() if name in names else _FALLBACKS[name]
        if value not in known:
            if value:
                warn(prim, f"curve {name} {value} is unknown; drawn as {_FALLBACKS[name]}")
            value = _FALLBACKS[name]
        setattr(form, name, value)
    curves = _core.GeometryDescription()
    curves.primitives = _core.PrimitiveKind.Curves
    curves.curves = form
    curves.points = PosePoints(prim, names, timeCode, points, skin)
    curves.faceVertexCounts = OrAgain(prim, "curveVertexCounts", timeCode, counts)
    curves.primvars = _WithWidths(PrimvarsOf(prim, names, inherited, timeCode), prim, names, timeCode,
                                  _DEFAULT_WIDTH)
    curves.samples = PoseSamples(prim, names, points, motion, warn, ("curveVertexCounts",), skin)
    curves.widthSamples = motion.PrimvarSamplesOf(prim, "widths", names, curves.primvars)
    return curves


def _ReadNurbsCurves(prim, names, inherited, timeCode, motion, warn, skin):
    """UsdGeomNurbsCurves as cubic Bezier curves; None when there is none that can be drawn. A Skin carries their points."""
    points = ReadPoints(prim, names, timeCode)
    counts = ReadArray(prim, "curveVertexCounts", timeCode, np.int32)
    if points is None or counts is None or not points.size or not counts.size:
        return None
    nurbsCurves = nurbs.Curves(prim, counts.tolist(), len(points), timeCode, warn)
    if not len(nurbsCurves.counts):
        return None
    curves = _CubicBezier()
    curves.points = nurbsCurves.Of(points if skin is None else skin.PointsOf(points))
    curves.faceVertexCounts = nurbsCurves.counts
    curves.samples = [(time, nurbsCurves.Of(array)) for time, array in PoseSamples(
        prim, names, points, motion, warn, ("curveVertexCounts",), skin)]
    primvars = _WithWidths(PrimvarsOf(prim, names, inherited, timeCode), prim, names, timeCode, _DEFAULT_WIDTH)
    curves.primvars = nurbsCurves.Primvars(primvars, prim, warn)
    widthSamples = motion.PrimvarSamplesOf(prim, "widths", names, primvars)
    if widthSamples:
        widths = next(primvar for primvar in primvars if primvar.name == "widths")
        curves.widthSamples = nurbsCurves.SamplesOf(widths, widthSamples)
    return curves


def _ReadHermiteCurves(prim, names, inherited, timeCode, motion, warn):
    """UsdGeomHermiteCurves as cubic Bezier curves; None where there is not a tangent for each of their points."""
    points = ReadPoints(prim, names, timeCode)
    tangents = ReadArray(prim, "tangents", timeCode, np.float32)
    counts = ReadArray(prim, "curveVertexCounts", timeCode, np.int32)
    if points is None or tangents is None or counts is None or tangents.shape != points.shape:
        return None
    shape = hermite.Curves(counts, len(points))
    if shape.bezierCounts is None:
        return None
    curves = _CubicBezier()
    curves.points = shape.Of(points, tangents)
    curves.faceVertexCounts = shape.bezierCounts
    samples = motion.PointSamplesOf(prim, names, len(points), warn, ("curveVertexCounts",))
    tangentSamples = motion.ArraySamplesOf(prim, "tangents", len(points))
    if tangentSamples is None:
        warn(prim, CHANGES_IN_NUMBER)
        tangentSamples = []
    curves.samples = [(time, shape.Of(SampleAt(samples, time, points), SampleAt(tangentSamples, time, tangents)))
                      for time in sorted({time for time, _ in samples + tangentSamples})]
    primvars = _WithWidths(PrimvarsOf(prim, names, inherited, timeCode), prim, names, timeCode, _DEFAULT_WIDTH)
    curves.primvars = [_AsVarying(primvar) for primvar in primvars]
    curves.widthSamples = motion.PrimvarSamplesOf(prim, "widths", names, curves.primvars)
    return curves


def _CubicBezier():
    curves = _core.GeometryDescription()
    curves.primitives = _core.PrimitiveKind.Curves
    form = _core.CurveForm()
    form.type, form.basis, form.wrap = "cubic", "bezier", "nonperiodic"
    curves.curves = form
    return curves


def _AsVarying(primvar):
    """A primvar of Hermite curves, which have no cubic interpolation of values (UsdGeomHermiteCurves)."""
    if primvar.interpolation != _core.Interpolation.Vertex:
        return primvar
    indices = primvar.indices if primvar.indices.size else None
    return _core.Primvar(primvar.name, _core.Interpolation.Varying, primvar.values, indices, primvar.colorSpace)


def ReadPointCloud(prim, names, inherited, timeCode, motion, warn, skin=None):
    """The description of UsdGeomPoints, in the pose of a Skin where there is one; None when there are no points."""
    positions = ReadPoints(prim, names, timeCode)
    if positions is None or not positions.size:
        return None
    points = _core.GeometryDescription()
    points.primitives = _core.PrimitiveKind.Points
    points.points = PosePoints(prim, names, timeCode, positions, skin)
    points.primvars = _WithWidths(PrimvarsOf(prim, names, inherited, timeCode), prim, names, timeCode, None)
    points.samples = PoseSamples(prim, names, positions, motion, warn, (), skin)
    points.widthSamples = motion.PrimvarSamplesOf(prim, "widths", names, points.primvars)
    return points


def _WithWidths(primvars, prim, names, timeCode, fallback):
    """Adds attribute `widths`, which primvars:widths precedes, or else a constant fallback."""
    if any(primvar.name == "widths" for primvar in primvars):
        return primvars
    attribute = prim.GetAttribute("widths")
    value = attribute.Get(timeCode) if "widths" in names else None
    if isinstance(value, Vt.FloatArray):
        rows = FloatRows(value, attribute)
        interpolation = INTERPOLATIONS.get(attribute.GetMetadata("interpolation") or "vertex")
        if rows is not None and interpolation is not None:
            return primvars + [_core.Primvar("widths", interpolation, rows)]
    if fallback is None:
        return primvars
    return primvars + [_core.Primvar("widths", _core.Interpolation.Constant, np.array([fallback], np.float32))]
