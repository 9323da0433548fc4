// SPDX-License-Identifier: Apache-2.0
// Nodes of MaterialX whose input is a matrix, though others of their name have vectors. Part of the
// material compiler. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/networkEvaluator.h"

namespace hds {

/// Of a node extract_matrix33 or extract_matrix44 the row that its constant index names.
ShaderValue ExtractRow(NetworkEvaluator& network, const MaterialNode& node, std::uint32_t index);

} // namespace hds
