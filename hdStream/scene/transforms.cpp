// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/transforms.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

/// Derived in docs/accel.md, "Padding".
constexpr int kMarginExponent = -19;
constexpr int kMovingMarginExponent = -17;
/// As far as an empty box is inside out (Bounds).
constexpr double kMaxReach = 1e30;

Bounds WidenedBounds(const glm::dmat4& matrix, const Bounds& bounds, int marginExponent) {
    Bounds result;
    if (!IsValidBounds(bounds)) {
        return result;
    }
    const glm::dvec3 centre = 0.5 * (glm::dvec3(bounds.min) + glm::dvec3(bounds.max));
    const glm::dvec3 half = 0.5 * (glm::dvec3(bounds.max) - glm::dvec3(bounds.min));
    const glm::dvec3 newCentre = glm::dvec3(matrix * glm::dvec4(centre, 1.0));
    for (int axis = 0; axis < 3; ++axis) {
        const double reach = std::abs(matrix[0][axis]) * half.x +
                             std::abs(matrix[1][axis]) * half.y +
                             std::abs(matrix[2][axis]) * half.z;
        const double margin = std::ldexp(std::abs(newCentre[axis]) + reach, marginExponent);
        result.min[axis] = static_cast<float>(newCentre[axis] - reach - margin);
        result.max[axis] = static_cast<float>(newCentre[axis] + reach + margin);
    }
    return result;
}

} // namespace

AffineRows RowsFromMatrix(const glm::dmat4& matrix) {
    AffineRows rows{};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            rows[4 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column)] =
                static_cast<float>(matrix[column][row]);
        }
    }
    return rows;
}

bool IsIdentity(const float* rows) {
    const AffineRows identity = RowsFromMatrix(glm::dmat4(1.0));
    return std::equal(identity.begin(), identity.end(), rows);
}

bool IsUsableTransform(const glm::dmat4& matrix) {
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            if (!std::isfinite(matrix[column][row])) {
                return false;
            }
        }
    }
    const glm::dmat3 linear(matrix);
    const double lengths = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
    constexpr double kMinRelativeVolume = 1e-12;
    return lengths > 0.0 && std::abs(glm::determinant(linear)) > kMinRelativeVolume * lengths &&
           std::isfinite(static_cast<float>(lengths));
}

glm::dmat4 ThickenFlat(const glm::dmat4& matrix) {
    // Of rank 2, the matrix of cofactors is the product of both stretches times the plane's normal
    // times the direction that is lost, transposed. Of rank 1 or 0, it is 0.
    const glm::dmat3 linear(matrix);
    const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                               glm::cross(linear[0], linear[1]));
    const double area =
        std::sqrt(glm::dot(cofactors[0], cofactors[0]) + glm::dot(cofactors[1], cofactors[1]) +
                  glm::dot(cofactors[2], cofactors[2]));
    const double square = glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) +
                          glm::dot(linear[2], linear[2]);
    constexpr double kMinRelativeArea = 1e-9;
    constexpr double kMinRelativeThickness = 1e-12;
    const bool isThick =
        std::abs(glm::determinant(linear)) > kMinRelativeThickness * area * std::sqrt(area);
    if (isThick || !(area > kMinRelativeArea * square) || !std::isfinite(area)) {
        return matrix;
    }
    constexpr int kThicknessExponent = -16;
    const double thickness = std::ldexp(std::sqrt(area), kThicknessExponent);
    glm::dmat4 thick = matrix;
    for (int column = 0; column < 3; ++column) {
        thick[column] += glm::dvec4(thickness / area * cofactors[column], 0.0);
    }
    return thick;
}

bool IsWithinReach(const glm::dmat4& matrix, const Bounds& bounds) {
    if (!IsValidBounds(bounds)) {
        return true;
    }
    const glm::dvec3 far =
        glm::max(glm::abs(glm::dvec3(bounds.min)), glm::abs(glm::dvec3(bounds.max)));
    for (int axis = 0; axis < 3; ++axis) {
        const double reach = std::abs(matrix[0][axis]) * far.x + std::abs(matrix[1][axis]) * far.y +
                             std::abs(matrix[2][axis]) * far.z + std::abs(matrix[3][axis]);
        if (!(reach <= kMaxReach)) {
            return false;
        }
    }
    return true;
}

Bounds TransformBounds(const glm::dmat4& matrix, const Bounds& bounds) {
    return WidenedBounds(matrix, bounds, kMarginExponent);
}

Bounds TransformBounds(const std::vector<glm::dmat4>& poses, const Bounds& bounds) {
    Bounds result;
    for (const glm::dmat4& pose : poses) {
        ExtendBounds(&result, WidenedBounds(pose, bounds, kMovingMarginExponent));
    }
    return result;
}

std::array<Bounds, 2> TransformEnds(const std::vector<glm::dmat4>& poses, const Bounds& bounds) {
    std::array<Bounds, 2> ends{WidenedBounds(poses.front(), bounds, kMovingMarginExponent),
                               WidenedBounds(poses.back(), bounds, kMovingMarginExponent)};
    const Bounds all = TransformBounds(poses, bounds);
    if (!IsValidBounds(all)) {
        return ends;
    }
    for (int axis = 0; axis < 3; ++axis) {
        double below = 0.0;
        double above = 0.0;
        for (std::size_t i = 1; i + 1 < poses.size(); ++i) {
            const double time = double(i) / double(poses.size() - 1);
            const Bounds pose = WidenedBounds(poses[i], bounds, kMovingMarginExponent);
            const auto between = [&](float open, float close) {
                return (1.0 - time) * double{open} + time * double{close};
            };
            below = std::max(below, between(ends[0].min[axis], ends[1].min[axis]) - pose.min[axis]);
            above = std::max(above, pose.max[axis] - between(ends[0].max[axis], ends[1].max[axis]));
        }
        // The device's rounding grows with the farthest pose.
        const double margin = std::ldexp(std::max(std::abs(all.min[axis]), std::abs(all.max[axis])),
                                         kMovingMarginExponent);
        for (Bounds& end : ends) {
            end.min[axis] = static_cast<float>(end.min[axis] - below - margin);
            end.max[axis] = static_cast<float>(end.max[axis] + above + margin);
        }
    }
    return ends;
}

void ExtendBounds(Bounds* bounds, const Bounds& other) {
    bounds->min = glm::min(bounds->min, other.min);
    bounds->max = glm::max(bounds->max, other.max);
}

} // namespace hds
