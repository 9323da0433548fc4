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
# A point of a patch has no normal where the cross product of derivatives is less than this part of the longest one...
_DEGENERATE = 1e-6
# ...and takes that of where this part of the way along u and v to the middle of the patch has been gone; shorter ones count there.
_STEPS = ((0.0, 1e-4), (1e-4, 0.0), (1e-4, 1e-4), (1e-2, 1e-2))
_DEGENERATE_INSIDE = 1e-9


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


def _IsWithin(indices, count):
    return not indices.size or (indices.min() >= 0 and indices.max() < count)


def _Primvars(shape, primvars, kept, prim, warn):
    """Primvars of those interpolations as they are, and those with a value a point as values of what is drawn."""
    result = []
    for primvar in primvars:
        if primvar.interpolation in (_core.Interpolation.Vertex, _core.Interpolation.Varying):
            rows = primvar.values.reshape(-1, primvar.numComponents)
            if primvar.indices.size:
                rows = rows[primvar.indices] if _IsWithin(primvar.indices, len(rows)) else rows[:0]
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


def _Weights(weights, numPoints, prim, warn):
    """The weights of points as an array; None where there are none, or not one for each point."""
    if not weights:
        return None
    if len(weights) != numPoints:
        warn(prim, f"pointWeights has {len(weights)} values for {numPoints} points; ignored")
        return None
    return np.asarray(weights, float)


class Curves:
    """The curves of a UsdGeomNurbsCurves prim as cubic Bezier curves."""

    def __init__(self, prim, counts, numPoints, timeCode, warn):
        def Values(name):
            attribute = prim.GetAttribute(name)
            return (attribute.Get(timeCode) if attribute else None) or []

        orders, knots, ranges = Values("order"), np.asarray(Values("knots"), float), Values("ranges")
        weights = _Weights(Values("pointWeights"), numPoints, prim, warn)
        self._blocks = []  # (slice of its points, Rows) of each curve
        point = knot = 0
        for number, authored in enumerate(counts):
            count = max(authored, 0)  # those of no curve have neither points nor knots
            order = max(int(orders[number]), 0) if number < len(orders) else 0
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

    def SamplesOf(self, primvar, samples):
        """(time, values) of a primvar as Primvars gives them; empty where it leaves it out."""
        if primvar.interpolation == _core.Interpolation.Constant or (
                primvar.interpolation == _core.Interpolation.Uniform and self.isWhole):
            return samples

        def AtPoints(values):
            return values[primvar.indices] if primvar.indices.size else values

        if (primvar.interpolation not in (_core.Interpolation.Vertex, _core.Interpolation.Varying)
                or not all(_IsWithin(primvar.indices, len(values)) and len(AtPoints(values)) == self.numPoints
                           for _, values in samples)):
            return []
        return [(time, self.Of(AtPoints(values))[:, 0].copy()) for time, values in samples]

    def Primvars(self, primvars, prim, warn):
        """Constants, those of whole curves where all are drawn, and those of points as values of the Bezier curves' points."""
        return _Primvars(self, primvars, ("Constant", "Uniform") if self.isWhole else ("Constant",), prim, warn)


class Patch:
    """A UsdGeomNurbsPatch as a grid of quads with normals; `gridSizes` is None where it is none."""

    def __init__(self, prim, numPoints, timeCode, warn):
        def Pair(name):
            return [prim.GetAttribute(axis + name).Get(timeCode) for axis in "uv"]

        self.sizes = [int(value or 0) for value in Pair("VertexCount")]
        orders = [int(value or 0) for value in Pair("Order")]
        knots = [np.asarray(value or [], float) for value in Pair("Knots")]
        ranges = Pair("Range")
        weights = _Weights(prim.GetAttribute("pointWeights").Get(timeCode), numPoints, prim, warn)
        self.gridSizes, self.numPoints = None, numPoints
        isUsable = self.sizes[0] * self.sizes[1] == numPoints and all(
            order >= 2 and size >= order and len(own) == size + order and np.isfinite(own).all() and (np.diff(own) >= 0).all()
            for order, size, own in zip(orders, self.sizes, knots))
        ends = [_Ends(own, order, interval) for own, order, interval in zip(knots, orders, ranges)] if isUsable else [None]
        if any(end is None for end in ends):
            return
        at = [np.unique(np.concatenate([np.linspace(a, b, _PATCH_PIECES + 1) for a, b in zip(end[:-1], end[1:])]))
              for end in ends]
        self._knots, self._orders, self._at = knots, orders, at
        self._u, self._v = [BasisRows(own, order, values) for own, order, values in zip(knots, orders, at)]
        self._du, self._dv = [BasisRows(own, order, values, 1) for own, order, values in zip(knots, orders, at)]
        self.gridSizes = (len(at[0]), len(at[1]))
        self._weights = None
        if weights is not None and not (weights > 0).all():
            warn(prim, "pointWeights has values that are not above 0; ignored")
            weights = None
        if weights is not None:
            self._weights = weights[:, None]
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

    def Normals(self, points):
        """Unit normals of the grid, along the cross product of the derivatives along u and v. Where that is 0, as in a pole,
        they are those of the surface a little towards its middle, which a limit is. None where no point has one."""
        points = np.asarray(points, float)
        normals = self._Crosses(self._u, self._v, self._du, self._dv, points)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        lengths = np.where(np.isfinite(lengths), lengths, 0.0)  # what is not finite the core counts and names
        longest = max(float(lengths.max()), 1e-300)
        isKnown = lengths > _DEGENERATE * longest
        if not isKnown.any():
            return None
        for steps in () if isKnown.all() else _STEPS:
            at = [own + step * (0.5 * (own[0] + own[-1]) - own) for own, step in zip(self._at, steps)]
            rows = [BasisRows(own, order, values, derivative) for derivative in (0, 1)
                    for own, order, values in zip(self._knots, self._orders, at)]
            inside = self._Crosses(*rows, points)
            lengthsInside = np.linalg.norm(inside, axis=1, keepdims=True)
            isFound = ~isKnown & (lengthsInside > _DEGENERATE_INSIDE * longest)
            normals, lengths = np.where(isFound, inside, normals), np.where(isFound, lengthsInside, lengths)
            isKnown |= isFound
        return np.ascontiguousarray(np.where(isKnown, normals / np.maximum(lengths, 1e-300), 0), np.float32)

    def _Crosses(self, u, v, du, dv, points):
        """Cross products of the derivatives along u and v of the points of a grid: rows of both bases and of their derivatives."""
        if self._weights is None:
            return np.cross(self._Along(du, v, points), self._Along(u, dv, points))
        weighted, sums = points * self._weights, self._Along(u, v, self._weights)
        values = self._Along(u, v, weighted) / sums
        return np.cross(*[(self._Along(*rows, weighted) - values * self._Along(*rows, self._weights)) / sums
                          for rows in ((du, v), (u, dv))])

    def Faces(self):
        """(counts, indices) of the quads."""
        numU, numV = self.gridSizes
        corner = (np.arange(numV - 1)[:, None] * numU + np.arange(numU - 1)).ravel()
        indices = np.stack([corner, corner + 1, corner + numU + 1, corner + numU], 1).ravel()
        return np.full(len(corner), 4, np.int32), np.ascontiguousarray(indices, np.int32)
