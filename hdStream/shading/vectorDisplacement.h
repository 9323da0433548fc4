// SPDX-License-Identifier: Apache-2.0
// MaterialX's displacement by vectors as a network that the host evaluates. Part of the material
// compiler. Explained in docs/geometry.md.
#pragma once

#include "hdStream/shading/displacementNetwork.h"
#include "hdStream/shading/networkEvaluator.h"

#include <optional>

namespace hds {

/// Of an ND_displacement_vector3: in the frame of (dP/ds, dP/dt, normal) unless its input `space`,
/// which is ours, is "object". Nothing where the vector is 0 everywhere, or where the host cannot
/// evaluate it, which warns. \param[out] value the vector
std::optional<DisplacementNetwork>
MakeVectorDisplacement(NetworkEvaluator& evaluator, const MaterialNode& node, ShaderValue* value);

} // namespace hds
