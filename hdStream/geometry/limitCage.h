// SPDX-License-Identifier: Apache-2.0
// Cages whose limit surface goes through given points. OpenUSD's meshes of implicit gprims have
// their points on the shape, and the limit surface of such a cage lies inside of it: that of a
// sphere of ten sides has 0.92 of the radius at its equator.
#pragma once

#include "hdStream/geometry/geometryDescription.h"

namespace hds {

/// Moves the points of a catmullClark cage so that the limit points of its vertices are where the
/// points were. Boundaries are those of "edgeAndCorner"; creases and corners are not looked at.
/// Leaves other schemes, and cages whose indices do not fit, as they are. Thread-safe.
/// Source: Halstead, Kass, DeRose 1993, Efficient, Fair Interpolation using Catmull-Clark Surfaces.
void FitLimitSurface(GeometryDescription& cage);

} // namespace hds
