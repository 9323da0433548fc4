// SPDX-License-Identifier: Apache-2.0
// Transform, size and bounds of a light.
#include "hdStream/shading/lightPlacement.h"

#include "hdStream/shading/lightUnits.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

/// Bounds are padded by more than the rounding of the device's test against them.
constexpr double kBoundPadding = 1.0 + 1e-5;

/// Upper bound of the largest singular value of the first `columns` columns from `first`; exact
/// when they are orthogonal and equally long.
double LargestStretch(const glm::dmat3& m, int first, int columns) {
    double largest = 0.0;
    double frobenius = 0.0;
    for (int i = first; i < first + columns; ++i) {
        double rowSum = 0.0;
        for (int j = first; j < first + columns; ++j) {
            rowSum += std::abs(glm::dot(m[i], m[j]));
        }
        largest = std::max(largest, rowSum);
        frobenius += glm::dot(m[i], m[i]);
    }
    return std::sqrt(std::min(largest, frobenius));
}

/// Makes the third column the unit normal times what gives |determinant| 1: a flat light has no
/// extent along z, so any z scale (0 included) means the same light. \return false: no area.
bool NormalizeFlat(glm::dmat3& m) {
    const glm::dvec3 normal = glm::cross(m[0], m[1]);
    const double area = glm::length(normal);
    if (!(area > 0.0)) {
        return false;
    }
    const double side = glm::dot(normal, m[2]) < 0.0 ? -1.0 : 1.0;
    m[2] = normal * (side / (area * area));
    return true;
}

/// Moves the scale of column i into a size.
void MoveScale(glm::dmat3& m, int i, double scale, double* size) {
    m[i] /= scale;
    *size *= scale;
}

/// Scales the matrix to |determinant| 1 and the sizes by the inverse. \return false: singular.
bool NormalizeUniformly(glm::dmat3& m, double* sizes, int numSizes) {
    const double scale = std::cbrt(std::abs(glm::determinant(m)));
    if (!(scale > 0.0)) {
        return false;
    }
    m /= scale;
    for (int i = 0; i < numSizes; ++i) {
        sizes[i] *= scale;
    }
    return true;
}

/// An axis frame whose z is the direction to the light.
bool PlaceDistant(glm::dmat3& m) {
    const double length = glm::length(m[2]);
    if (!(length > 0.0)) {
        return false;
    }
    const glm::dvec3 z = m[2] / length;
    const glm::dvec3 helper = std::abs(z.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(helper, z));
    m = glm::dmat3(x, glm::cross(z, x), z);
    return true;
}

/// Normalises the matrix and sizes of a light and bounds its shape about its origin.
bool PlaceShape(const LightDescription& light, glm::dmat3& m, double* sizes, double* bound) {
    const double x = glm::length(m[0]);
    const double y = glm::length(m[1]);
    switch (light.type) {
    case LightType::Sphere:
        sizes[0] = light.radius;
        *bound = sizes[0] * LargestStretch(m, 0, 3);
        return NormalizeUniformly(m, sizes, 1);
    case LightType::Rect:
        sizes[0] = light.width;
        sizes[1] = light.height;
        if (!NormalizeFlat(m)) {
            return false;
        }
        *bound = 0.5 * std::max(glm::length(sizes[0] * m[0] + sizes[1] * m[1]),
                                glm::length(sizes[0] * m[0] - sizes[1] * m[1]));
        MoveScale(m, 0, x, &sizes[0]);
        MoveScale(m, 1, y, &sizes[1]);
        return NormalizeFlat(m);
    case LightType::Disk:
        sizes[0] = light.radius;
        if (!NormalizeFlat(m)) {
            return false;
        }
        *bound = sizes[0] * LargestStretch(m, 0, 2);
        MoveScale(m, 0, std::sqrt(x * y), &sizes[0]);
        m[1] /= std::sqrt(x * y);
        return NormalizeFlat(m);
    case LightType::Cylinder: {
        sizes[0] = light.radius;
        sizes[1] = light.length;
        *bound = 0.5 * sizes[1] * x + sizes[0] * LargestStretch(m, 1, 2);
        const double across = std::sqrt(y * glm::length(m[2]));
        if (!(x > 0.0 && across > 0.0)) {
            return false;
        }
        MoveScale(m, 0, x, &sizes[1]);
        MoveScale(m, 1, across, &sizes[0]);
        m[2] /= across;
        return NormalizeUniformly(m, sizes, 2);
    }
    case LightType::Distant:
        sizes[0] = 2.0 * std::pow(std::sin(0.5 * DistantHalfAngle(light)), 2.0);
        return PlaceDistant(m);
    case LightType::Dome:
        return NormalizeUniformly(m, sizes, 0);
    case LightType::Mesh: // its triangles are in place
        break;
    }
    return false;
}

bool HasSize(const LightDescription& light, const double* sizes) {
    switch (light.type) {
    case LightType::Sphere:
        return sizes[0] > 0.0 || (light.treatAsPoint && sizes[0] == 0.0);
    case LightType::Disk:
        return sizes[0] > 0.0;
    case LightType::Rect:
    case LightType::Cylinder:
        return sizes[0] > 0.0 && sizes[1] > 0.0;
    default:
        return true;
    }
}

void WriteRows(const glm::dmat3& linear, const glm::dvec3& last, float* rows) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            rows[row * 4 + column] = float(linear[column][row]);
        }
        rows[row * 4 + 3] = float(last[row]);
    }
}

bool AllFinite(const float* values, int count) {
    return std::all_of(values, values + count, [](float v) { return std::isfinite(v); });
}

} // namespace

bool PlaceLight(const LightDescription& light, const glm::dmat4& worldFromLight,
                shared::HdsLight* out) {
    glm::dmat3 m(worldFromLight);
    const glm::dvec3 origin(worldFromLight[3]);
    const double area = LightArea(light, m);
    double sizes[2] = {0.0, 0.0};
    double bound = 0.0;
    if (!PlaceShape(light, m, sizes, &bound) || !HasSize(light, sizes)) {
        return false;
    }
    const glm::dmat3 inverse = glm::inverse(m);
    WriteRows(m, origin, out->worldFromLight);
    WriteRows(inverse, glm::normalize(glm::row(inverse, 2)), out->lightFromWorld);
    out->params[0] = float(sizes[0]);
    out->params[1] = float(sizes[1]);
    out->area = float(area);
    for (int i = 0; i < 3; ++i) {
        out->center[i] = float(origin[i]);
    }
    const bool isFar = light.type == LightType::Distant || light.type == LightType::Dome;
    out->boundRadius = isFar ? HDS_LIGHT_FAR : float(bound * kBoundPadding);
    return AllFinite(out->worldFromLight, 12) && AllFinite(out->lightFromWorld, 12) &&
           AllFinite(out->params, 2) && std::isfinite(out->area) && std::isfinite(out->boundRadius);
}

} // namespace hds
