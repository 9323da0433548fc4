# SPDX-License-Identifier: Apache-2.0
"""NURBS of UsdGeomNurbsCurves and UsdGeomNurbsPatch as cubic Bezier curves and as meshes.

A NURBS is a sum of its points with weights that depend on the parameter alone (Piegl and Tiller 1997, "The NURBS Book",
equations 2.5, 4.1 and 4.11). So a matrix takes points, their samples in time and primvars of points to those of what is drawn.
At a parameter as many weights as the order are not zero, of points that follow one another: these alone are kept.
"""

import numpy as np

from hdstream import _core

# Pieces that a span of knots is cut into where no cubic is exact: rational ones, and those of an order above 4.
_PIECES = 16
_PATCH_PIECES = 8  # edges along a span of a patch


class Rows:
    """A matrix [rows][number of points] of which each row has a few entries, one after another, that are not zero."""

    def __init__(self, firsts, entries):
        self.firsts = firsts    # [rows]: the column of a row's first entry
        self.entries = entries  # [rows][entries of a row]

    def __len__(self):
        return len(self.firsts)

    def __matmul__(self, values):
        """Of values [points][...]."""
        shape = (-1,) + (1,) * (values.ndim - 1)
        return sum(self.entries[:, k].reshape(shape) * values[self.firsts + k] for k in range(self.entries.shape[1]))

    def OfEntries(self, values):
        """What each entry is multiplied by, [rows][entries of a row]: values [points]."""
        return values[self.firsts[:, None] + np.arange(self.entries.shape[1])]


def BasisRows(knots, order, parameters, derivative=0):
    """The basis functions of a knot vector at parameters as Rows, or their first derivatives. A parameter at a knot counts to
    the span on its right, the last one to the span on its left."""
    knots = np.asarray(knots, float)
    numPoints = len(knots) - order
    parameters = np.asarray(parameters, float)
    spans = np.clip(np.searchsorted(knots, parameters, "right") - 1, order - 1, numPoints - 1)
    entries = np.ones((len(parameters), 1))
    at = parameters[:, None]
    for degree in range(1, order):  # the functions of a degree from those of the one below (Cox and de Boor)
        i = spans[:, None] + np.arange(-degree, 1)
        below = np.pad(entries, ((0, 0), (1, 1)))
        low = _Inverse(knots[i + degree] - knots[i])
        high = _Inverse(knots[i + degree + 1] - knots[i + 1])
        if degree < order - derivative:
            entries = (at - knots[i]) * low * below[:, :-1] + (knots[i + degree + 1] - at) * high * below[:, 1:]
        else:
            entries = degree * (below[:, :-1] * low - below[:, 1:] * high)
    return Rows(spans - (order - 1), entries)


def _Inverse(widths):
    """1 / width; 0 where knots are equal."""
    return np.divide(1.0, widths, out=np.zeros_like(widths), where=widths > 0)


def RationalRows(knots, order, weights, parameters):
    """(rows, first derivatives): what the points of a curve are multiplied by."""
    rows = BasisRows(knots, order, parameters)
    slopeRows = BasisRows(knots, order, parameters, 1)
    if weights is None:
        return rows, slopeRows
    weights = rows.OfEntries(weights)
    values, slopes = rows.entries * weights, slopeRows.entries * weights
    sums, sumSlopes = values.sum(1, keepdims=True), slopes.sum(1, keepdims=True)
    values = values / sums
    return Rows(rows.firsts, values), Rows(rows.firsts, (slopes - values * sumSlopes) / sums)


def _Ends(knots, order, interval):
    """The borders of the spans of an interval, each once."""
    knots = np.asarray(knots, float)
    low, high = knots[order - 1], knots[len(knots) - order]
    if interval is not None and interval[0] < interval[1]:
        low, high = max(low, interval[0]), min(high, interval[1])
    inner = np.unique(knots[(knots > low) & (knots < high)])
    return np.concatenate([[low], inner, [high]]) if low < high else None


def BezierRows(knots, order, weights, interval=None):
    """The matrix from the points of a curve to the 3 pieces + 1 control points of cubic Bezier pieces, as Rows; None where
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
    # Of the first piece its first point, of each piece the three that follow.
    thirds = steps[:, None] / 3
    firsts = np.stack([first.firsts, last.firsts, last.firsts], 1).ravel()
    entries = np.stack([first.entries + firstSlopes.entries * thirds, last.entries - lastSlopes.entries * thirds,
                        last.entries], 1).reshape(len(firsts), -1)
    return Rows(np.append(first.firsts[:1], firsts), np.append(first.entries[:1], entries, 0))


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
        self._blocks = []  # (slice of its points, Rows) of each curve
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
                self._blocks.append((slice(point, point + count), rows))
            point, knot = point + count, knot + count + order
        self.numPoints = numPoints
        self.isWhole = len(self._blocks) == len(counts)
        self.counts = np.array([len(rows) for _, rows in self._blocks], np.int32)

    def Of(self, values):
        """Values of points [numPoints][...] as those of the Bezier curves, float32."""
        values = np.asarray(values, float).reshape(self.numPoints, -1)
        parts = [rows @ values[points] for points, rows in self._blocks]
        return np.ascontiguousarray(np.concatenate(parts), np.float32)

    def Primvars(self, primvars, prim, warn):
        """Constants, those of whole curves where all are drawn, and those of points as values of the Bezier curves' points."""
        return _Primvars(self, primvars, ("Constant", "Uniform") if self.isWhole else ("Constant",), prim, warn)


class Patch:
    """A UsdGeomNurbsPatch as a grid of quads with normals; `gridSizes` is None where it is none."""

    def __init__(self, prim, numPoints, timeCode):
        def Pair(name):
            return [prim.GetAttribute(axis + name).Get(timeCode) for axis in "uv"]

        self.sizes = [int(value or 0) for value in Pair("VertexCount")]
        orders = [int(value or 0) for value in Pair("Order")]
        knots = [np.asarray(value or [], float) for value in Pair("Knots")]
        ranges = Pair("Range")
        weights = prim.GetAttribute("pointWeights").Get(timeCode)
        self.gridSizes, self.numPoints = None, numPoints
        isUsable = self.sizes[0] * self.sizes[1] == numPoints and all(
            order >= 2 and size >= order and len(own) == size + order and np.isfinite(own).all() and (np.diff(own) >= 0).all()
            for order, size, own in zip(orders, self.sizes, knots))
        ends = [_Ends(own, order, interval) for own, order, interval in zip(knots, orders, ranges)] if isUsable else [None]
        if any(end is None for end in ends):
            return
        at = [np.unique(np.concatenate([np.linspace(a, b, _PATCH_PIECES + 1) for a, b in zip(end[:-1], end[1:])]))
              for end in ends]
        self._u, self._v = [BasisRows(own, order, values) for own, order, values in zip(knots, orders, at)]
        self._du, self._dv = [BasisRows(own, order, values, 1) for own, order, values in zip(knots, orders, at)]
        self.gridSizes = (len(at[0]), len(at[1]))
        self._weights = None
        if weights and len(weights) == numPoints and min(weights) > 0:
            self._weights = np.asarray(weights, float)[:, None]
            self._sums = self._Along(self._u, self._v, self._weights)

    def _Along(self, u, v, values):
        """Rows along u and those along v of values [points][...], for the grid: one after the other, since the matrix of both has
        an entry for each point of the grid and each of the patch."""
        values = values.reshape(self.sizes[1], self.sizes[0], -1)  # points go row by row: u is the faster index
        values = (u @ values.swapaxes(0, 1)).swapaxes(0, 1)
        return (v @ values).reshape(len(u) * len(v), -1)

    def _Values(self, values):
        """Values of points as those of the grid."""
        if self._weights is None:
            return self._Along(self._u, self._v, values)
        return self._Along(self._u, self._v, values * self._weights) / self._sums

    def Of(self, values):
        """Values of points as those of the grid, float32."""
        return np.ascontiguousarray(self._Values(np.asarray(values, float).reshape(self.numPoints, -1)), np.float32)

    def Primvars(self, primvars, prim, warn):
        """Constants, and those of points as values of the grid; normals are those of the surface."""
        return _Primvars(self, [primvar for primvar in primvars if primvar.name != "normals"], ("Constant",), prim, warn)

    def _Slopes(self, u, v, points):
        """Derivatives of the grid's points; of `u` and `v` one is that of a basis."""
        if self._weights is None:
            return self._Along(u, v, points)
        slopes, sumSlopes = self._Along(u, v, points * self._weights), self._Along(u, v, self._weights)
        return (slopes - self._Values(points) * sumSlopes) / self._sums

    def Normals(self, points):
        """Unit normals of the grid, along the cross product of the derivatives along u and v."""
        points = np.asarray(points, float)
        normals = np.cross(self._Slopes(self._du, self._v, points), self._Slopes(self._u, self._dv, points))
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        isDegenerate = bool((lengths < 1e-12 * max(float(lengths.max()), 1e-300)).any())
        return None if isDegenerate else np.ascontiguousarray(normals / lengths, np.float32)

    def Faces(self):
        """(counts, indices) of the quads."""
        numU, numV = self.gridSizes
        corner = (np.arange(numV - 1)[:, None] * numU + np.arange(numU - 1)).ravel()
        indices = np.stack([corner, corner + 1, corner + numU + 1, corner + numU], 1).ravel()
        return np.full(len(corner), 4, np.int32), np.ascontiguousarray(indices, np.int32)
