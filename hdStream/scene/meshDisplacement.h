// SPDX-License-Identifier: Apache-2.0
// Displacement inputs of materials -> the displacement of a mesh.
#pragma once

#include "hdStream/geometry/displacement.h"
#include "hdStream/shading/materialCompiler.h"

#include <vector>

namespace hds {

/// \param inputs by material entry (MaterialCommit::DisplacementsOf).
/// \return empty when nothing is displaced.
Displacement MakeDisplacement(const std::vector<DisplacementInput>& inputs);

/// How far they move a mesh's points at most, object space. Costs nothing where nothing displaces,
/// else a look at all values of the primvars that amounts read.
double DisplacementReachOf(const GeometryDescription& mesh,
                           const std::vector<DisplacementInput>& inputs);

} // namespace hds
