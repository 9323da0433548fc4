// SPDX-License-Identifier: Apache-2.0
// The transforms of an instancer's instances, as front ends have them: matrices of 128 bytes, or
// the arrays of which UsdGeomPointInstancer and Hydra make them, 32 to 40 bytes an instance.
#pragma once

#include "hdStream/base/fields.h"
#include "hdStream/base/sharedSpan.h"

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <vector>

namespace hds {

/// Matrices or, where there are none, parts: an instance is scaled, rotated and then moved. Parts
/// that are empty are the identity, and an array that is shorter than the longest one is the
/// identity beyond its end.
struct InstanceTransforms {
    SharedSpan<double> matrices;             ///< [numInstances][16], memory as glm::dmat4
    SharedSpan<float> translations;          ///< [numInstances][3]
    SharedSpan<float> rotations;             ///< [numInstances][4] quaternions: i, j, k, real
    SharedSpan<std::uint16_t> halfRotations; ///< the same as halves; used when `rotations` is empty
    SharedSpan<float> scales;                ///< [numInstances][3]

    InstanceTransforms() = default;
    InstanceTransforms(SharedSpan<double> all) // NOLINT(google-explicit-constructor): converts
        : matrices(std::move(all)) {}
    InstanceTransforms(std::vector<double> all) // NOLINT(google-explicit-constructor): converts
        : matrices(std::move(all)) {}

    /// Number of instances.
    std::size_t Size() const;
    /// The matrix of one. The arithmetic is that of UsdGeomPointInstancer's
    /// ComputeInstanceTransformsAtTime, so that all front ends give the same bits.
    glm::dmat4 At(std::size_t index) const;
    /// The matrices of all of them, made where there are only parts.
    SharedSpan<double> Matrices() const;

    static constexpr auto Fields() {
        constexpr auto kWhy = "the matrices that they make are dumped";
        return FieldList(HDS_FIELD(InstanceTransforms, matrices).Rows(16),
                         HDS_FIELD(InstanceTransforms, translations).Rows(3).NotInDump(kWhy),
                         HDS_FIELD(InstanceTransforms, rotations).Rows(4).NotInDump(kWhy),
                         HDS_FIELD(InstanceTransforms, halfRotations).Rows(4).NotInDump(kWhy),
                         HDS_FIELD(InstanceTransforms, scales).Rows(3).NotInDump(kWhy));
    }
};

} // namespace hds
