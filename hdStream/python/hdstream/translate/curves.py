# SPDX-License-Identifier: Apache-2.0
"""UsdGeomCurves and UsdGeomPoints as descriptions of curves and points."""

import numpy as np
from pxr import Vt

from hdstream import _core
from hdstream.translate import nurbs
from hdstream.translate.meshes import OrAgain, PointsAgain, ReadArray, ReadPoints
from hdstream.translate.primvars import FloatRows, INTERPOLATIONS, PrimvarsOf

_DEFAULT_WIDTH = 1.0  # as UsdImaging has it
_TOKENS = {"type": ("linear", "cubic"), "basis": ("bezier", "bspline", "catmullRom"),
           "wrap": ("nonperiodic", "periodic", "pinned")}
_FALLBACKS = {"type": "cubic", "basis": "bezier", "wrap": "nonperiodic"}


def ReadCurves(prim, schema, names, inherited, timeCode, warn):
    """The description of UsdGeomCurves; None when there are no points or no curves. Hermite curves are lines between their
    points, as UsdImaging has them."""
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
    curves.points = PointsAgain(prim, names, timeCode, points)
    curves.faceVertexCounts = OrAgain(prim, "curveVertexCounts", timeCode, counts)
    curves.primvars = _WithWidths(PrimvarsOf(prim, names, inherited, timeCode), prim, names, timeCode,
                                  _DEFAULT_WIDTH)
    return curves


def ReadNurbsCurves(prim, names, inherited, timeCode, motion, warn):
    """UsdGeomNurbsCurves as cubic Bezier curves; None when there is none that can be drawn."""
    points = ReadPoints(prim, names, timeCode)
    counts = ReadArray(prim, "curveVertexCounts", timeCode, np.int32)
    if points is None or counts is None or not points.size or not counts.size:
        return None
    nurbsCurves = nurbs.Curves(prim, counts.tolist(), len(points), timeCode, warn)
    if not len(nurbsCurves.counts):
        return None
    curves = _core.GeometryDescription()
    curves.primitives = _core.PrimitiveKind.Curves
    form = _core.CurveForm()
    form.type, form.basis, form.wrap = "cubic", "bezier", "nonperiodic"
    curves.curves = form
    curves.points = nurbsCurves.Of(points)
    curves.faceVertexCounts = nurbsCurves.counts
    curves.samples = [(time, nurbsCurves.Of(array))
                      for time, array in motion.PointSamplesOf(prim, names, len(points), warn, ("curveVertexCounts",))]
    primvars = _WithWidths(PrimvarsOf(prim, names, inherited, timeCode), prim, names, timeCode, _DEFAULT_WIDTH)
    curves.primvars = nurbsCurves.Primvars(primvars, prim, warn)
    return curves


def ReadPointCloud(prim, names, inherited, timeCode):
    """The description of UsdGeomPoints; None when there are no points."""
    positions = ReadPoints(prim, names, timeCode)
    if positions is None or not positions.size:
        return None
    points = _core.GeometryDescription()
    points.primitives = _core.PrimitiveKind.Points
    points.points = PointsAgain(prim, names, timeCode, positions)
    points.primvars = _WithWidths(PrimvarsOf(prim, names, inherited, timeCode), prim, names, timeCode, None)
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
