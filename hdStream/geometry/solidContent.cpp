// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/solidContent.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hds {

namespace {

/// Kernels evaluate curves in float: boxes are wider by this part of their largest coordinate.
constexpr double kRounding = 8.0 / (1U << 23U);

bool IsUsableWidth(float width) {
    return std::isfinite(width) && width >= 0.0F && width < kMaxCoordinate;
}

} // namespace

namespace {

std::optional<glm::vec3> FindIn(const SharedSpan<float>& points, std::size_t index) {
    if (3 * index + 2 >= points.size()) {
        return std::nullopt;
    }
    const float* point = points.data() + 3 * index;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(std::fabs(point[axis]) <= kMaxCoordinate)) {
            return std::nullopt;
        }
    }
    return glm::vec3(point[0], point[1], point[2]);
}

} // namespace

std::optional<glm::vec3> FindPoint(const GeometryDescription& description, std::size_t index) {
    return FindIn(description.points, index);
}

std::optional<glm::vec3> FindPointAt(const GeometryDescription& description, std::size_t pose,
                                     std::size_t index) {
    return FindIn(pose == 0 ? description.points : description.keys[pose - 1].points, index);
}

bool HasPoint(const GeometryDescription& description, std::size_t index) {
    for (std::size_t pose = 0; pose <= description.keys.size(); ++pose) {
        if (!FindPointAt(description, pose, index)) {
            return false;
        }
    }
    return true;
}

std::vector<GeometryAttribute> WidthsOfPoses(const GeometryDescription& description,
                                             const GeometryAttribute& widths) {
    std::vector<GeometryAttribute> poses(1 + description.keys.size(), widths);
    for (std::size_t i = 0; i < description.keys.size(); ++i) {
        if (description.keys[i].widths.size() == widths.values.size()) {
            poses[i + 1].values = description.keys[i].widths;
        }
    }
    return poses;
}

Bounds BoundPoints(const GeometryDescription& description) {
    Bounds bounds;
    for (std::size_t i = 0; i < description.points.size() / 3; ++i) {
        if (const std::optional<glm::vec3> point = FindPoint(description, i)) {
            bounds.min = glm::min(bounds.min, *point);
            bounds.max = glm::max(bounds.max, *point);
        }
    }
    return bounds;
}

std::optional<GeometryAttribute> AuthoredWidths(const GeometryDescription& description,
                                                const TopologySize& size, PrimLog& log) {
    for (const Primvar& primvar : description.primvars) {
        if (primvar.name != "widths" || primvar.interpolation == Interpolation::Instance) {
            continue;
        }
        if (primvar.numComponents != 1) {
            log.Warn("primvar \"widths\" ignored: " + std::to_string(primvar.numComponents) +
                     " components, 1 is needed");
            return std::nullopt;
        }
        auto widths = ValidatePrimvar(primvar, size, log.PrimPath(), log.Sink());
        if (widths && widths->interpolation == Interpolation::FaceVarying) {
            widths->interpolation = Interpolation::Varying;
        }
        return widths;
    }
    return std::nullopt;
}

void WarnBadWidths(const GeometryAttribute& widths, PrimLog& log) {
    const auto numBad = std::count_if(widths.values.begin(), widths.values.end(),
                                      [](float width) { return !IsUsableWidth(width); });
    if (numBad > 0) {
        log.Warn(std::to_string(numBad) + " widths are negative or not finite, read as 0");
    }
}

float RadiusOf(const GeometryAttribute& widths, std::size_t element) {
    const float width =
        *ValueOf(widths, widths.interpolation == Interpolation::Constant ? 0 : element);
    return IsUsableWidth(width) ? 0.5F * width : 0.0F;
}

std::vector<GeometryAttribute> SolidAttributes(const GeometryDescription& description,
                                               const TopologySize& size, PrimLog& log) {
    std::vector<GeometryAttribute> attributes = CollectAttributes(description, size, log);
    attributes.erase(std::remove_if(attributes.begin(), attributes.end(),
                                    [](const GeometryAttribute& attribute) {
                                        return attribute.name == "widths";
                                    }),
                     attributes.end());
    for (GeometryAttribute& attribute : attributes) {
        if (attribute.interpolation == Interpolation::FaceVarying) {
            attribute.interpolation =
                size.hasJoints ? Interpolation::Varying : Interpolation::Vertex;
        }
    }
    return attributes;
}

void ExtendBySolid(const glm::dvec3& centre, double radius, Bounds* bounds) {
    const double size = std::fabs(radius);
    for (int axis = 0; axis < 3; ++axis) {
        const double pad = kRounding * (std::fabs(centre[axis]) + size);
        bounds->min[axis] =
            std::min(bounds->min[axis], static_cast<float>(centre[axis] - size - pad));
        bounds->max[axis] =
            std::max(bounds->max[axis], static_cast<float>(centre[axis] + size + pad));
    }
}

} // namespace hds
