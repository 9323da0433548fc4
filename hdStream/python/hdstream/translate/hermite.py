# SPDX-License-Identifier: Apache-2.0
"""Hermite curves of UsdGeomHermiteCurves as cubic Bezier curves, which they are exactly: the derivative of a segment, whose
parameter goes from 0 to 1, is the tangent of its points at its ends."""

import numpy as np


class Curves:
    """Curves of `counts` points each, `numPoints` together. `bezierCounts`: points of the Bezier curves; None where there are
    no such curves."""

    def __init__(self, counts, numPoints):
        counts = np.asarray(counts, np.int64)
        self.bezierCounts = None
        if not counts.size or counts.min() < 2 or counts.sum() != numPoints:
            return
        self.bezierCounts = (3 * counts - 2).astype(np.int32)
        self._places = 3 * np.arange(numPoints) - 2 * np.repeat(np.arange(len(counts)), counts)
        self._begins = np.delete(np.arange(numPoints), np.cumsum(counts) - 1)  # all but the last points of curves

    def Of(self, points, tangents):
        """Points and tangents [numPoints][3] as the Bezier curves' points, float32."""
        points, thirds = np.asarray(points, float), np.asarray(tangents, float) / 3
        rows = np.empty((self._places[-1] + 1, 3))
        rows[self._places] = points
        rows[self._places[self._begins] + 1] = (points + thirds)[self._begins]
        rows[self._places[self._begins] + 2] = (points - thirds)[self._begins + 1]
        return np.ascontiguousarray(rows, np.float32)
