// SPDX-License-Identifier: Apache-2.0
// How a material displaces, as the host evaluates it and as programs do. Part of the material
// compiler. Explained in docs/geometry.md.
#pragma once

#include "hdStream/shading/materialCompiler.h"
#include "hdStream/shading/networkEvaluator.h"

#include <optional>
#include <string>
#include <vector>

namespace hds {

/// A look-up of one image, at coordinates that are a primvar or constant transforms of one.
std::optional<DisplacementInput> LookupDisplacement(const ShaderValue& value,
                                                    const std::vector<MaterialTexture>& textures);

/// Displaces along the normal. Constants, primvars, look-ups and networks; what the host cannot
/// evaluate warns and is ignored. \param textures what tiles of look-ups name
void SetDisplacement(const ShaderValue& amount, const std::vector<MaterialTexture>& textures,
                     const std::string& materialPath, Warnings& warnings,
                     CompiledMaterial* material);

/// The same of the displacement terminal, a MaterialX displacement node, if there is one.
void SetMaterialXDisplacement(NetworkEvaluator& evaluator, const MaterialNetwork& network,
                              const std::string& materialPath, Warnings& warnings,
                              CompiledMaterial* material);

} // namespace hds
