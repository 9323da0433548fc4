# SPDX-License-Identifier: Apache-2.0
"""NURBS of UsdGeomNurbsCurves and UsdGeomNurbsPatch as cubic Bezier curves and as meshes.

A NURBS is a sum of its points with weights that depend on the parameter alone (Piegl and Tiller 1997, "The NURBS Book",
equations 2.5, 4.1 and 4.11). So a matrix takes points, their samples in time and primvars of points to those of what is drawn.
"""

import numpy as np

from hdstream import _core

# Pieces that a span of knots is cut into where no cubic is exact: rational ones, and those of an order above 4.
_PIECES = 16
_PATCH_PIECES = 8  # edges along a span of a patch


def BasisRows(knots, order, parameters, derivative=0):
    """The basis functions [len(parameters)][number of points] of a knot vector, or their first derivatives. A parameter at a
    knot counts to the span on its right, the last one to the span on its left."""
    knots = np.asarray(knots, float)
    numPoints = len(knots) - order
    parameters = np.asarray(parameters, float)
    spans = np.clip(np.searchsorted(knots, parameters, "right") - 1, order - 1, numPoints - 1)
    rows = np.zeros((len(parameters), len(knots) - 1))
    rows[np.arange(len(parameters)), spans] = 1.0
    for degree in range(1, order - derivative):
        rows = _Raise(knots, degree, parameters, rows)
    for degree in range(order - derivative, order):
        low, high = _Inverse(knots, degree)
        rows = degree * (rows[:, :-1] * low - rows[:, 1:] * high)
    return rows


def _Inverse(knots, degree):
    """1 / (k[i + degree] - k[i]), and the same of i + 1; 0 where knots are equal."""
    widths = knots[degree:] - knots[:-degree]
    inverse = np.divide(1.0, widths, out=np.zeros_like(widths), where=widths > 0)
    return inverse[:-1], inverse[1:]


def _Raise(knots, degree, parameters, rows):
    """The functions of a degree from those of the one below (Cox and de Boor)."""
    low, high = _Inverse(knots, degree)
    count = rows.shape[1] - 1
    at = parameters[:, None]
    return ((at - knots[None, :count]) * low * rows[:, :-1]
            + (knots[None, degree + 1:degree + 1 + count] - at) * high * rows[:, 1:])


def RationalRows(knots, order, weights, parameters):
    """(rows, first derivatives): what the points of a curve are multiplied by."""
    values = BasisRows(knots, order, parameters)
    slopes = BasisRows(knots, order, parameters, 1)
    if weights is None:
        return values, slopes
    values, slopes = values * weights, slopes * weights
    sums, sumSlopes = values.sum(1, keepdims=True), slopes.sum(1, keepdims=True)
    rows = values / sums
    return rows, (slopes - rows * sumSlopes) / sums


def _Ends(knots, order, interval):
    """The borders of the spans of an interval, each once."""
    knots = np.asarray(knots, float)
    low, high = knots[order - 1], knots[len(knots) - order]
    if interval is not None and interval[0] < interval[1]:
        low, high = max(low, interval[0]), min(high, interval[1])
    inner = np.unique(knots[(knots > low) & (knots < high)])
    return np.concatenate([[low], inner, [high]]) if low < high else None


def BezierRows(knots, order, weights, interval=None):
    """The matrix from the points of a curve to the control points of cubic Bezier pieces, [3 pieces + 1][points]; None where
    the knots span nothing. Exact for polynomials of order 4 at most; others agree in position and tangent at the ends of
    pieces, sixteen to a span."""
    ends = _Ends(knots, order, interval)
    if ends is None:
        return None
    isExact = weights is None and order <= 4
    if not isExact:
        ends = np.unique(np.concatenate([np.linspace(a, b, _PIECES + 1) for a, b in zip(ends[:-1], ends[1:])]))
    # Tangents of a piece are those inside of it: at a knot the curve may have a corner.
    steps = np.diff(ends)
    inside = 1e-9 * steps
    first, firstSlopes = RationalRows(knots, order, weights, ends[:-1] + inside)
    last, lastSlopes = RationalRows(knots, order, weights, ends[1:] - inside)
    rows = np.empty((3 * len(steps) + 1, len(knots) - order))
    rows[0:-1:3], rows[3::3] = first, last
    rows[1::3] = first + firstSlopes * steps[:, None] / 3
    rows[2::3] = last - lastSlopes * steps[:, None] / 3
    return rows


def _Primvars(shape, primvars, kept, prim, warn):
    """Primvars of those interpolations as they are, and those with a value a point as values of what is drawn."""
    result = []
    for primvar in primvars:
        if primvar.interpolation in (_core.Interpolation.Vertex, _core.Interpolation.Varying):
            rows = primvar.values.reshape(-1, primvar.numComponents)
            if primvar.indices.size:
                isWithin = primvar.indices.min() >= 0 and primvar.indices.max() < len(rows)
                rows = rows[primvar.indices] if isWithin else rows[:0]
            if len(rows) == shape.numPoints:
                rows = shape.Of(rows)
                rows = rows[:, 0].copy() if primvar.numComponents == 1 else rows
                result.append(_core.Primvar(primvar.name, _core.Interpolation.Vertex, rows, None, primvar.colorSpace))
                continue
        elif any(primvar.interpolation == getattr(_core.Interpolation, name) for name in kept):
            result.append(primvar)
            continue
        warn(prim, f"primvar {primvar.name} of NURBS has no value a point; ignored")
    return result


class Curves:
    """The curves of a UsdGeomNurbsCurves prim as cubic Bezier curves."""

    def __init__(self, prim, counts, numPoints, timeCode, warn):
        def Values(name):
            attribute = prim.GetAttribute(name)
            return (attribute.Get(timeCode) if attribute else None) or []

        orders, knots, ranges = Values("order"), np.asarray(Values("knots"), float), Values("ranges")
        weights = Values("pointWeights")
        weights = np.asarray(weights, float) if weights and len(weights) == numPoints else None
        self._blocks = []  # (first point, matrix) of each curve
        point = knot = 0
        for number, count in enumerate(counts):
            order = int(orders[number]) if number < len(orders) else 0
            own = knots[knot:knot + count + order]
            ownWeights = weights[point:point + count] if weights is not None else None
            interval = ranges[number] if number < len(ranges) else None
            rows = None
            if (order >= 2 and count >= order and len(own) == count + order and (np.diff(own) >= 0).all()
                    and (ownWeights is None or (ownWeights > 0).all()) and point + count <= numPoints):
                rows = BezierRows(own, order, ownWeights, interval)
            if rows is None:
                warn(prim, "curves whose order, knots or weights make no NURBS are left out")
            else:
                self._blocks.append((point, rows))
            point, knot = point + count, knot + count + order
        self.numPoints = numPoints
        self.isWhole = len(self._blocks) == len(counts)
        self.counts = np.array([len(rows) for _, rows in self._blocks], np.int32)

    def Of(self, values):
        """Values of points [numPoints][...] as those of the Bezier curves, float32."""
        values = np.asarray(values, float)
        parts = [rows @ values[first:first + rows.shape[1]].reshape(rows.shape[1], -1) for first, rows in self._blocks]
        return np.ascontiguousarray(np.concatenate(parts), np.float32)

    def Primvars(self, primvars, prim, warn):
        """Constants, those of whole curves where all are drawn, and those of points as values of the Bezier curves' points."""
        return _Primvars(self, primvars, ("Constant", "Uniform") if self.isWhole else ("Constant",), prim, warn)


class Patch:
    """A UsdGeomNurbsPatch as a grid of quads with normals; `rows` is None where it is none."""

    def __init__(self, prim, numPoints, timeCode):
        def Pair(name):
            return [prim.GetAttribute(axis + name).Get(timeCode) for axis in "uv"]

        self.sizes = [int(value or 0) for value in Pair("VertexCount")]
        orders = [int(value or 0) for value in Pair("Order")]
        knots = [np.asarray(value or [], float) for value in Pair("Knots")]
        ranges = Pair("Range")
        weights = prim.GetAttribute("pointWeights").Get(timeCode)
        self.rows, self.numPoints = None, numPoints
        isUsable = self.sizes[0] * self.sizes[1] == numPoints and all(
            order >= 2 and size >= order and len(own) == size + order and (np.diff(own) >= 0).all()
            for order, size, own in zip(orders, self.sizes, knots))
        ends = [_Ends(own, order, interval) for own, order, interval in zip(knots, orders, ranges)] if isUsable else [None]
        if any(end is None for end in ends):
            return
        at = [np.unique(np.concatenate([np.linspace(a, b, _PATCH_PIECES + 1) for a, b in zip(end[:-1], end[1:])]))
              for end in ends]
        u, v = [BasisRows(own, order, values) for own, order, values in zip(knots, orders, at)]
        du, dv = [BasisRows(own, order, values, 1) for own, order, values in zip(knots, orders, at)]
        # Points go row by row: u is the faster index.
        self.gridSizes = (len(at[0]), len(at[1]))
        rows, alongU, alongV = (np.einsum("vj,ui->vuji", b, a).reshape(len(at[0]) * len(at[1]), numPoints)
                                for a, b in ((u, v), (du, v), (u, dv)))
        if weights and len(weights) == numPoints and min(weights) > 0:
            weights = np.asarray(weights, float)
            rows, alongU, alongV = rows * weights, alongU * weights, alongV * weights
            sums = rows.sum(1, keepdims=True)
            rows = rows / sums
            alongU, alongV = ((slopes - rows * slopes.sum(1, keepdims=True)) / sums for slopes in (alongU, alongV))
        self.rows, self._alongU, self._alongV = rows, alongU, alongV

    def Of(self, values):
        """Values of points as those of the grid, float32."""
        return np.ascontiguousarray(self.rows @ np.asarray(values, float).reshape(self.rows.shape[1], -1), np.float32)

    def Primvars(self, primvars, prim, warn):
        """Constants, and those of points as values of the grid; normals are those of the surface."""
        return _Primvars(self, [primvar for primvar in primvars if primvar.name != "normals"], ("Constant",), prim, warn)

    def Normals(self, points):
        """Unit normals of the grid, along the cross product of the derivatives along u and v."""
        normals = np.cross(self._alongU @ np.asarray(points, float), self._alongV @ np.asarray(points, float))
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        isDegenerate = bool((lengths < 1e-12 * max(float(lengths.max()), 1e-300)).any())
        return None if isDegenerate else np.ascontiguousarray(normals / lengths, np.float32)

    def Faces(self):
        """(counts, indices) of the quads."""
        numU, numV = self.gridSizes
        corner = (np.arange(numV - 1)[:, None] * numU + np.arange(numU - 1)).ravel()
        indices = np.stack([corner, corner + 1, corner + numU + 1, corner + numU], 1).ravel()
        return np.full(len(corner), 4, np.int32), np.ascontiguousarray(indices, np.int32)
