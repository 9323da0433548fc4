// SPDX-License-Identifier: Apache-2.0
// Double-precision transforms of the scene and their single-precision rows for the device.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <glm/mat4x4.hpp>

#include <array>
#include <vector>

namespace hds {

/// Rows of an affine transform as device structs hold them: [3][4], row major, for column vectors.
using AffineRows = std::array<float, 12>;

/// The upper three rows of a matrix, rounded to float.
AffineRows RowsFromMatrix(const glm::dmat4& matrix);

/// Whether rows of an affine transform map every point to itself. \param rows [3][4].
bool IsIdentity(const float* rows);

/// True when all elements are finite and the linear part is invertible in practice: its
/// determinant is not negligible against the product of its column lengths.
bool IsUsableTransform(const glm::dmat4& matrix);

/// The transform itself, but where its linear part maps space onto a plane (a scale of 0, or below
/// 1e-12 of the others, along one axis): there with a thickness of 2^-16 of the plane's scale, so
/// that it can be inverted and what it places is drawn as a thin sheet. Its determinant is
/// positive. What maps space onto a line or a point, or is not finite, stays as it is.
glm::dmat4 ThickenFlat(const glm::dmat4& matrix);

/// Whether a transform leaves a box where hierarchies of boxes in single precision can be built.
bool IsWithinReach(const glm::dmat4& matrix, const Bounds& bounds);

/// The box of a transformed box, rounded outwards by 2^-19 of its largest coordinate, which covers
/// the rounding of the float transform that the device applies to rays.
Bounds TransformBounds(const glm::dmat4& matrix, const Bounds& bounds);

/// The box of a box that goes straight from pose to pose: as TransformBounds, but by 2^-17, for the
/// device finds its map by interpolating and inverting.
Bounds TransformBounds(const std::vector<glm::dmat4>& poses, const Bounds& bounds);

/// Boxes at both ends of a way through `poses`, which are at equal distances in time. The box of
/// the box is always inside of what lies between them, linear in time. Wider, as TransformBounds.
std::array<Bounds, 2> TransformEnds(const std::vector<glm::dmat4>& poses, const Bounds& bounds);

/// Grows `bounds` by `other`.
void ExtendBounds(Bounds* bounds, const Bounds& other);

/// False for the empty box.
inline bool IsValidBounds(const Bounds& bounds) {
    return bounds.min.x <= bounds.max.x;
}

} // namespace hds
