// SPDX-License-Identifier: Apache-2.0
// UsdPreviewSurface networks to records. Defaults: UsdPreviewSurface specification 2.5.
#include "hdStream/shading/materialCompiler.h"

#include "hdStream/shading/networkEvaluator.h"
#include "kernels/shared/geometry.h"

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

struct InputRow {
    const char* name;
    std::uint32_t numComponents;
    std::array<float, 3> fallback;
};

/// By HDS_INPUT_*.
const InputRow kInputs[HDS_NUM_INPUTS] = {
    {"diffuseColor", 3, {0.18F, 0.18F, 0.18F}},
    {"emissiveColor", 3, {0.0F, 0.0F, 0.0F}},
    {"specularColor", 3, {0.0F, 0.0F, 0.0F}},
    {"normal", 3, {0.0F, 0.0F, 1.0F}},
    {"metallic", 1, {0.0F, 0.0F, 0.0F}},
    {"roughness", 1, {0.5F, 0.0F, 0.0F}},
    {"clearcoat", 1, {0.0F, 0.0F, 0.0F}},
    {"clearcoatRoughness", 1, {0.01F, 0.0F, 0.0F}},
    {"opacity", 1, {1.0F, 0.0F, 0.0F}},
    {"opacityThreshold", 1, {0.0F, 0.0F, 0.0F}},
    {"ior", 1, {1.5F, 0.0F, 0.0F}},
};

void SetConstant(shared::HdsMaterial& material, std::uint32_t input,
                 const std::array<float, 4>& value) {
    material.constants[input] = {value[0], value[1], value[2], value[3]};
}

/// All constants at the specification's defaults, no slots, no flags.
CompiledMaterial DefaultMaterial() {
    CompiledMaterial material;
    for (std::uint32_t i = 0; i < HDS_NUM_INPUTS; ++i) {
        const std::array<float, 3>& value = kInputs[i].fallback;
        SetConstant(material.constants, i, {value[0], value[1], value[2], 1.0F});
        material.constants.slots[i] = HDS_NONE;
    }
    return material;
}

/// Puts a value into an input: one component spreads over a colour, a scalar takes the first of
/// many.
void SetInput(CompiledMaterial& material, std::uint32_t input, const InputValue& value,
              const MaterialNode& node, const std::string& materialPath, Warnings& warnings) {
    const InputRow& row = kInputs[input];
    const bool isShort = row.numComponents == 3 && value.numComponents < 3;
    const bool isSpread = isShort && value.numComponents == 1 && input != HDS_INPUT_NORMAL;
    if (isShort && (!isSpread || value.kind == InputValue::Kind::Primvar)) {
        warnings.Add(materialPath,
                     std::string("input ") + row.name + " of " + node.path + " has a wrong type");
        return;
    }
    std::array<float, 4> constant = value.value;
    if (isSpread) {
        constant = {constant[0], constant[0], constant[0], 1.0F};
    }
    SetConstant(material.constants, input, constant);
    if (value.kind == InputValue::Kind::Primvar) {
        material.readers.push_back({input, value.primvar, row.numComponents});
    }
}

/// The node of the surface terminal when it is a UsdPreviewSurface, else null with a warning.
const MaterialNode* FindSurface(const MaterialNetwork& network, const NetworkEvaluator& evaluator,
                                const std::string& materialPath, Warnings& warnings) {
    const auto terminal = network.terminals.find("surface");
    const MaterialNode* node = terminal == network.terminals.end()
                                   ? nullptr
                                   : evaluator.FindNode(terminal->second.upstreamPath);
    if (node == nullptr) {
        warnings.Add(materialPath, "material has no surface shader; displayColor is used");
        return nullptr;
    }
    if (node->identifier != "UsdPreviewSurface") {
        const std::string what = node->identifier.empty() ? node->path + ", which has no shader id,"
                                                          : node->identifier + " of " + node->path;
        warnings.Add(materialPath,
                     "surface shader " + what + " is not supported; displayColor is used");
        return nullptr;
    }
    return node;
}

/// Constants and primvars; what reads a texture warns and is ignored.
DisplacementInput FindDisplacement(NetworkEvaluator& evaluator, const MaterialNode& surface,
                                   const std::string& materialPath, Warnings& warnings) {
    DisplacementInput displacement;
    const auto connection = surface.connections.find("displacement");
    if (connection != surface.connections.end()) {
        const MaterialNode* source = evaluator.FindNode(connection->second.upstreamPath);
        if (source != nullptr && source->identifier == "UsdUVTexture") {
            warnings.Add(materialPath, "displacement by a texture is ignored");
            return displacement;
        }
    }
    const InputValue value = evaluator.Evaluate(surface, "displacement");
    if (value.kind != InputValue::Kind::None) {
        displacement.constant = value.value[0];
    }
    if (value.kind == InputValue::Kind::Primvar) {
        displacement.primvar = value.primvar;
    }
    return displacement;
}

bool HasSlot(const shared::HdsMaterial& m, std::uint32_t input) {
    return m.slots[input] != HDS_NONE;
}

/// Flags that follow from constants and slots.
std::uint32_t DerivedFlags(const shared::HdsMaterial& m) {
    std::uint32_t flags = 0;
    if (HasSlot(m, HDS_INPUT_OPACITY) || m.constants[HDS_INPUT_OPACITY].x < 1.0F) {
        flags |= HDS_MATERIAL_CUTOUT;
    }
    const shared::float4& emission = m.constants[HDS_INPUT_EMISSIVE_COLOR];
    if (HasSlot(m, HDS_INPUT_EMISSIVE_COLOR) || emission.x > 0.0F || emission.y > 0.0F ||
        emission.z > 0.0F) {
        flags |= HDS_MATERIAL_EMISSIVE;
    }
    const shared::float4& normal = m.constants[HDS_INPUT_NORMAL];
    if (HasSlot(m, HDS_INPUT_NORMAL) || normal.x != 0.0F || normal.y != 0.0F) {
        flags |= HDS_MATERIAL_NORMAL;
    }
    return flags;
}

} // namespace

CompiledMaterial DisplayColorMaterial() {
    CompiledMaterial material = DefaultMaterial();
    SetConstant(material.constants, HDS_INPUT_DIFFUSE_COLOR, {0.5F, 0.5F, 0.5F, 1.0F});
    material.constants.flags = HDS_MATERIAL_LAMBERT;
    material.readers.push_back({HDS_INPUT_DIFFUSE_COLOR, "displayColor", 3});
    material.readers.push_back({HDS_INPUT_OPACITY, "displayOpacity", 1});
    return material;
}

CompiledMaterial CompileMaterial(const MaterialNetwork& network, const std::string& materialPath,
                                 const MeanColorCallback& meanColor, Warnings& warnings) {
    NetworkEvaluator evaluator(network, materialPath, meanColor, warnings);
    const MaterialNode* surface = FindSurface(network, evaluator, materialPath, warnings);
    if (surface == nullptr) {
        return DisplayColorMaterial();
    }
    CompiledMaterial material = DefaultMaterial();
    for (std::uint32_t i = 0; i < HDS_NUM_INPUTS; ++i) {
        const InputValue value = evaluator.Evaluate(*surface, kInputs[i].name);
        if (value.kind != InputValue::Kind::None) {
            SetInput(material, i, value, *surface, materialPath, warnings);
        }
    }
    const InputValue workflow = evaluator.Evaluate(*surface, "useSpecularWorkflow");
    if (workflow.kind == InputValue::Kind::Constant && workflow.value[0] != 0.0F) {
        material.constants.flags |= HDS_MATERIAL_SPECULAR_WORKFLOW;
    }
    material.displacement = FindDisplacement(evaluator, *surface, materialPath, warnings);
    return material;
}

shared::HdsMaterial ResolveMaterial(const CompiledMaterial& material,
                                    const std::vector<AttributeName>& attributes,
                                    const std::string& meshPath, Warnings& warnings) {
    shared::HdsMaterial result = material.constants;
    for (const PrimvarReader& reader : material.readers) {
        const auto found =
            std::find_if(attributes.begin(), attributes.end(), [&](const AttributeName& attribute) {
                return attribute.name == reader.primvar;
            });
        if (found == attributes.end()) {
            continue;
        }
        if (found->numComponents < reader.numComponents) {
            warnings.Add(meshPath, "primvar " + reader.primvar + " has " +
                                       std::to_string(found->numComponents) + " components; " +
                                       kInputs[reader.input].name + " needs " +
                                       std::to_string(reader.numComponents));
            continue;
        }
        result.slots[reader.input] =
            HDS_SLOT_USER + std::uint32_t(std::distance(attributes.begin(), found));
    }
    result.flags |= DerivedFlags(result);
    return result;
}

} // namespace hds
