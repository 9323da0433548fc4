// SPDX-License-Identifier: Apache-2.0
// Primvars per instance. The core has them as primvars of its instancers. What it reads once a prim
// (visibility, widths, normals) it cannot have by instance: instances of a gprim are grouped by
// these values, and each group is drawn as a prim of its own, with constant primvars.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/pxr.h>

#include <cstdint>
#include <memory>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// What an instancer knows of its instances. Immutable once it is shared.
struct HdStreamInstanceLevel {
    std::vector<hds::Primvar> primvars;       ///< values [numInstances][numComponents]
    hds::SharedSpan<std::int32_t> placements; ///< instances of its parent that place the instancer
};

/// An instancer and those above it, the innermost first.
using HdStreamInstanceLevels = std::vector<std::shared_ptr<const HdStreamInstanceLevel>>;

/// The instances of a gprim that have equal values.
struct HdStreamInstanceGroup {
    std::vector<hds::Primvar> primvars; ///< constant
    /// As long as the gprim's own list, with -1 for instances of other groups: a rank in it is what
    /// instanceId counts.
    hds::SharedSpan<std::int32_t> instances;
};

struct HdStreamInstanceGroups {
    std::vector<HdStreamInstanceGroup> groups; ///< at least one, in the order of first instances
    bool hasTooMany = false;  ///< one group without those values, for more than 64 different ones
    bool variesAbove = false; ///< such values of an outer instancer differ; the first are taken
};

/// Groups the instances of a gprim by the bits of those values that the core reads once a prim.
/// Constant primvars of the groups are these, and those that all instances have equal. Of primvars
/// of one name those of the gprim itself win, then those of the inner instancer.
HdStreamInstanceGroups HdStreamGroupInstances(const HdStreamInstanceLevels& levels,
                                              const hds::SharedSpan<std::int32_t>& instances,
                                              const std::vector<hds::Primvar>& own);

/// What the core is told of an instancer: those of its primvars that differ between its instances.
std::vector<hds::Primvar> HdStreamInstancerPrimvars(const std::vector<hds::Primvar>& primvars);

PXR_NAMESPACE_CLOSE_SCOPE
