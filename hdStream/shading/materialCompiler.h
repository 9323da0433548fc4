// SPDX-License-Identifier: Apache-2.0
// Material networks to HdsMaterial records and programs. Two steps: compile a network once; resolve
// it against the attributes of each prim it is bound to. Pure functions; any thread.
// Bad content warns once, names the material, and falls back to what docs/shading.md defines.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/displacementNetwork.h"
#include "hdStream/shading/imageQueries.h"
#include "hdStream/shading/materialNetwork.h"
#include "hdStream/shading/shaderExpression.h"
#include "kernels/shared/material.h"
#include "kernels/shared/meshMedium.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// An amount that is looked up: value * scale + bias.
struct DisplacementLookup {
    MaterialTexture texture;
    std::uint32_t channel = 0;
    std::uint32_t wrapS = HDS_WRAP_BLACK; ///< HDS_WRAP_*
    std::uint32_t wrapT = HDS_WRAP_BLACK;
    std::array<double, 6> rows{1, 0, 0, 0, 1, 0}; ///< coordinates = rows * (primvar, 1)
    std::array<float, 2> missing{}; ///< stands for the primvar where the prim has none
    float scale = 1.0F;
    float bias = 0.0F;
    std::shared_ptr<const HeightImage> image; ///< null until commit has read it

    static constexpr auto Fields() {
        using Lookup = DisplacementLookup;
        return FieldList(
            HDS_FIELD(Lookup, texture)
                .NotInKey("the heights are: a file that changes makes other pages"),
            HDS_FIELD(Lookup, channel).NotInKey("the heights are"), HDS_FIELD(Lookup, wrapS),
            HDS_FIELD(Lookup, wrapT), HDS_FIELD(Lookup, rows), HDS_FIELD(Lookup, missing),
            HDS_FIELD(Lookup, scale), HDS_FIELD(Lookup, bias), HDS_FIELD(Lookup, image));
    }
};

/// How far a material moves the surface along its normal, object-space units.
struct DisplacementInput {
    float constant = 0.0F; ///< also where the prim has no such primvar, or the image is unreadable
    std::string primvar;   ///< without "primvars:"; empty: the constant
    /// Nothing: the primvar's first component is the amount; else its first two are coordinates.
    std::optional<DisplacementLookup> lookup = {};
    /// What is none of these; then all else is at its default.
    std::optional<DisplacementNetwork> network = {};

    static constexpr auto Fields() {
        return FieldList(
            HDS_FIELD(DisplacementInput, constant), HDS_FIELD(DisplacementInput, primvar),
            HDS_FIELD(DisplacementInput, lookup), HDS_FIELD(DisplacementInput, network));
    }
};

/// Displacement as programs evaluate it at a hit, where triangles lack some of it.
struct MaterialRelief {
    ShaderValue value;                          ///< empty: they have all
    std::uint32_t space = 0;                    ///< HDS_DISPLACES_*
    std::vector<MaterialTexture> textures = {}; ///< those of the material, and what only displaces
};

/// What an emission that varies is looked up from, as far as that can be told: for a guess of how
/// bright a surface is where.
struct EmissionInput {
    std::string primvar; ///< without "primvars:"; empty: unknown
    /// Nothing: the primvar is the emission; else its first two components are coordinates.
    std::optional<DisplacementLookup> lookup = {}; ///< but for channel, scale and bias
    std::array<float, 4> factors{};                ///< on the channels of the look-up...
    float bias = 0.0F;                             ///< ...and what is added to their sum
};

/// A material before it is bound.
struct CompiledMaterial {
    /// Inputs that are constants; slots and program are HDS_NONE.
    shared::HdsMaterial constants{};
    /// Inputs that are none, by HDS_INPUT_*; empty: the constant.
    std::array<ShaderValue, HDS_NUM_LAYERED_INPUTS> values;
    std::vector<MaterialTexture> textures; ///< what tiles of look-ups name
    DisplacementInput displacement;
    MaterialRelief relief;
    EmissionInput emission;
    std::optional<shared::HdsMeshMedium> meshMedium; ///< that fills meshes, of the volume
    std::optional<float> dielectricPriority;         ///< of the inside
};

/// Primvars along which the tangents of a surface lie that names none: the first that is there.
constexpr std::array<const char*, 2> kTangentPrimvars = {"st", "UV0"};

/// An attribute of a prim as materials see it; its slot is HDS_SLOT_USER + its index in the list.
struct AttributeName {
    std::string name;
    std::uint32_t numComponents = 1;
};

/// Compiles a network. A missing or unknown surface gives DisplayColorMaterial(), or where there is
/// a volume, the boundary of that, which is not seen. \param materialPath subject of the warnings.
CompiledMaterial CompileMaterial(const MaterialNetwork& network, const std::string& materialPath,
                                 const ImageQueries& images, Warnings& warnings);

/// The material of prims without one: Lambert of displayColor (0.5 where there is none, as
/// UsdImaging) with displayOpacity.
CompiledMaterial DisplayColorMaterial();

/// Of Gaussian splats: kernels make opacity and emission of what the splat is (HDS_MATERIAL_SPLAT).
/// \param harmonics the primvar with their coefficients.
CompiledMaterial SplatMaterial(const char* harmonics);

/// Reflects nothing.
CompiledMaterial BlackMaterial();

/// What the inputs of a refracting surface say of its inside, as a medium that fills meshes. Inputs
/// that vary count as their defaults, with a warning of primPath.
shared::HdsMeshMedium InteriorOf(const CompiledMaterial& material, const std::string& primPath,
                                 Warnings& warnings);

/// Whether a material emits the same everywhere, or nothing.
bool HasConstantEmission(const shared::HdsMaterial& material);

/// A material for the prims with certain attributes.
struct ResolvedMaterial {
    shared::HdsMaterial record{};       ///< its program is HDS_NONE
    std::vector<std::uint32_t> program; ///< of record.programInputs; empty: none
};

/// Fills slots, program and the flags that depend on them. A primvar that the prim lacks, or whose
/// component count is wrong, gives its reader's fallback; the latter warns with `primPath`.
/// \param textures index in the scene of each of the material's textures. \param ofInstances
/// primvars with a value an instance; the slot of each is HDS_SLOT_INSTANCE + its index. Where the
/// prim keeps what displacement needs (kMovedBy), the program bumps it by the material's relief,
/// whose textures `textures` are then.
ResolvedMaterial ResolveMaterial(const CompiledMaterial& material,
                                 const std::vector<std::uint32_t>& textures,
                                 const std::vector<AttributeName>& attributes,
                                 const std::vector<AttributeName>& ofInstances,
                                 const std::string& primPath, Warnings& warnings);

} // namespace hds
