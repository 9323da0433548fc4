// SPDX-License-Identifier: Apache-2.0
// Implicit gprims as meshes. OpenUSD images them as catmullClark meshes of a fixed topology; these
// have the same points, topology and scheme, so both front ends and every complexity agree.
#pragma once

#include "hdStream/geometry/geometryDescription.h"

#include <optional>
#include <string>

namespace hds {

/// Authored size of an implicit gprim; only the members its type uses are read.
struct ImplicitShape {
    std::string type; ///< Sphere, Cube, Cylinder, Cone, Capsule, Plane
    std::string axis = "Z";
    double size = 2.0;   ///< Cube
    double radius = 1.0; ///< Sphere, Cylinder, Cone, Capsule
    /// Cylinder, Capsule: at the end towards +axis; empty: radius.
    std::optional<double> radiusTop;
    double height = 2.0; ///< Cylinder, Cone; Capsule: 1 is USD's default, the caller passes it
    double width = 2.0;  ///< Plane
    double length = 2.0; ///< Plane
};

/// The mesh of a shape. \throws Error for an unknown type.
GeometryDescription MakeImplicitMesh(const ImplicitShape& shape);

} // namespace hds
