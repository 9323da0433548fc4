// SPDX-License-Identifier: Apache-2.0
// Surfaces that are thin walls: who says so, and what spreads. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/layeredMaterial.h"

namespace hds {

/// Whether an input of a surface says that it is a thin wall. One that varies warns and says no.
bool IsThinWall(NetworkEvaluator& network, const MaterialNode& node, const char* input);

/// Says that what a thin wall transmits, if anything, is spread by its roughness, unless that is
/// small: then it goes straight on, and shadow rays pass. Where it varies each point says so.
void FrostThinWall(LayeredMaterial* material);

} // namespace hds
