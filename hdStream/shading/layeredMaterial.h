// SPDX-License-Identifier: Apache-2.0
// Surface shaders of MaterialX as the inputs of layered surfaces (kernels/shared/material.h). Part
// of the material compiler. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/networkEvaluator.h"
#include "kernels/shared/material.h"

#include <array>
#include <cstdint>
#include <string>

namespace hds {

/// A layered surface before it is bound.
struct LayeredMaterial {
    std::array<ShaderValue, HDS_NUM_LAYERED_INPUTS> values; ///< empty: the default
    std::uint32_t flags = 0;                                ///< HDS_MATERIAL_*
    std::uint32_t lobes = 0; ///< HDS_LOBE_*; before FinishLayered HDS_LOBE_CONDUCTOR alone
    float dispersion = 0.0F; ///< one over the Abbe number of what refracts; 0: none
};

/// Gives the coat a normal where that is not the surface's. \param normal as HDS_INPUT_NORMAL;
/// empty: none; one without a direction is that of the mesh. \pre HDS_INPUT_NORMAL is set.
void SetOwnNormal(const ShaderValue& normal, LayeredMaterial* material);

/// Makes the metal a conductor, with Fresnel's equations. \param color reflectance at normal
/// incidence. \param edge Gulbrandsen's tint of its edge (Gulbrandsen 2014)
void SetConductor(const ShaderValue& color, const ShaderValue& edge, LayeredMaterial* material);

/// The dispersion of what refracts, as dispersion_ofFlags reads it. \pre FinishLayered.
std::uint32_t DispersionFlags(const LayeredMaterial& material);

/// Sets the lobes by the values, and takes away what belongs to lobes that are not there.
void FinishLayered(LayeredMaterial* material);

/// Whether a shader id is a surface shader that EvaluateLayered knows.
bool IsLayered(const std::string& identifier);

/// \pre IsLayered(node.identifier)
LayeredMaterial EvaluateLayered(NetworkEvaluator& network, const MaterialNode& node);

} // namespace hds
