// SPDX-License-Identifier: Apache-2.0
// Surfaces that are thin walls. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/networkEvaluator.h"

namespace hds {

/// Whether an input of a surface says that it is a thin wall. One that varies warns and says no.
bool IsThinWall(NetworkEvaluator& network, const MaterialNode& node, const char* input);

} // namespace hds
