// SPDX-License-Identifier: Apache-2.0
// MaterialX nodes that take and give whole shaders: what hands one on, mixes of displacements.
// Explained in docs/materials.md. Part of the material compiler.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/materialNetwork.h"

#include <string>

namespace hds {

/// The shader of a terminal behind what only hands it on (`dot`, `surfacematerial`,
/// `volumematerial`); null: there is none. Pure; any thread.
const MaterialNode* FindTerminalShader(const MaterialNetwork& network, const std::string& terminal);

/// The same of an input of a node.
const MaterialNode* FindInputShader(const MaterialNetwork& network, const MaterialNode& node,
                                    const std::string& input);

/// The network whose terminals are the shaders that FindTerminalShader finds, with one displacement
/// in the place of a mix of them. What `displacement` hangs on may also be the input of a
/// `surfacematerial`. Pure; any thread.
/// Source: MaterialX 1.39, stdlib_defs.mtlx.
MaterialNetwork JoinShaders(const MaterialNetwork& network, const std::string& materialPath,
                            Warnings& warnings);

} // namespace hds
