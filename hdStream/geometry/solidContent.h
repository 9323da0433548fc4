// SPDX-License-Identifier: Apache-2.0
// What curves and points have in common: points, widths, primvars, with the warnings of each.
// Internal to geometry. Explained in docs/curves.md.
#pragma once

#include "hdStream/geometry/meshContent.h"

#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Point `index` of a description; nothing when there is none, or it is not finite or too far.
std::optional<glm::vec3> FindPoint(const GeometryDescription& description, std::size_t index);

/// The same at a time while the shutter is open. \param pose 0: when it opens; else of keys[pose -
/// 1].
std::optional<glm::vec3> FindPointAt(const GeometryDescription& description, std::size_t pose,
                                     std::size_t index);

/// Whether there is such a point in all poses.
bool HasPoint(const GeometryDescription& description, std::size_t index);

/// Widths in all poses: when the shutter opens, and at each of the keys.
std::vector<GeometryAttribute> WidthsOfPoses(const GeometryDescription& description,
                                             const GeometryAttribute& widths);

/// The box of all points that can be used.
Bounds BoundPoints(const GeometryDescription& description);

/// The primvar "widths", if it can be used.
std::optional<GeometryAttribute> AuthoredWidths(const GeometryDescription& description,
                                                const TopologySize& size, PrimLog& log);

/// Warns about widths that are negative or not finite; they count as 0.
void WarnBadWidths(const GeometryAttribute& widths, PrimLog& log);

/// Half the width of an element; 0 where it cannot be used.
float RadiusOf(const GeometryAttribute& widths, std::size_t element);

/// User primvars that can be used, sorted by name: all but widths and normals. FaceVarying ones are
/// Varying where there are joints.
std::vector<GeometryAttribute> SolidAttributes(const GeometryDescription& description,
                                               const TopologySize& size, PrimLog& log);

/// A box of a ball's or a piece's hull in double, with what kernels may round.
void ExtendBySolid(const glm::dvec3& centre, double radius, Bounds* bounds);

} // namespace hds
