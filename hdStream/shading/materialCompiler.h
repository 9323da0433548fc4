// SPDX-License-Identifier: Apache-2.0
// Material networks to HdsMaterial records. Two steps: compile a network once; resolve it against
// the attributes of each mesh it is bound to. Pure functions; any thread.
// Bad content warns once, names the material, and falls back to what docs/shading.md defines.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/materialNetwork.h"
#include "kernels/shared/material.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// The mean colour of an image in the linear working space; empty: it cannot be read.
/// \param sourceColorSpace "raw", "sRGB" or "auto".
using MeanColorCallback = std::function<std::optional<std::array<float, 4>>(
    const AssetReference& file, const std::string& sourceColorSpace)>;

/// An input that reads a primvar of the mesh.
struct PrimvarReader {
    std::uint32_t input = 0;         ///< HDS_INPUT_*
    std::string primvar;             ///< name without "primvars:"
    std::uint32_t numComponents = 1; ///< it needs: 1 or 3
};

/// How far a material moves the surface along its normal, object-space units.
struct DisplacementInput {
    float constant = 0.0F; ///< also where the mesh has no such primvar
    std::string primvar;   ///< without "primvars:", its first component; empty: the constant

    bool operator==(const DisplacementInput& other) const {
        return constant == other.constant && primvar == other.primvar;
    }
};

/// A material before it is bound: constants hold the readers' fallbacks, all slots are HDS_NONE.
struct CompiledMaterial {
    shared::HdsMaterial constants{};
    std::vector<PrimvarReader> readers;
    DisplacementInput displacement;
};

/// An attribute of a mesh as materials see it; its slot is HDS_SLOT_USER + its index in the list.
struct AttributeName {
    std::string name;
    std::uint32_t numComponents = 1;
};

/// Compiles a network. A missing or unknown surface gives DisplayColorMaterial().
/// \param materialPath subject of the warnings. \param meanColor may be empty.
CompiledMaterial CompileMaterial(const MaterialNetwork& network, const std::string& materialPath,
                                 const MeanColorCallback& meanColor, Warnings& warnings);

/// The material of meshes without one: Lambert of displayColor (0.5 where there is none, as
/// UsdImaging) with displayOpacity.
CompiledMaterial DisplayColorMaterial();

/// Fills the slots and the flags that depend on them. A primvar that the mesh lacks, or whose
/// component count is wrong, leaves the fallback; the latter warns with `meshPath`.
shared::HdsMaterial ResolveMaterial(const CompiledMaterial& material,
                                    const std::vector<AttributeName>& attributes,
                                    const std::string& meshPath, Warnings& warnings);

} // namespace hds
