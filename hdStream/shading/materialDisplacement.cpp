// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/materialDisplacement.h"

#include "hdStream/shading/shaderMath.h"
#include "hdStream/shading/shaderNetwork.h"
#include "hdStream/shading/vectorDisplacement.h"

#include <algorithm>
#include <array>
#include <utility>

namespace hds {

std::optional<DisplacementInput> LookupDisplacement(const ShaderValue& value,
                                                    const std::vector<MaterialTexture>& textures) {
    const ShaderExpression& expression = *value.expression;
    const std::vector<ShaderValue>& operands = expression.operands;
    if (expression.kind != ShaderExpression::Kind::Texture ||
        (expression.lookup & HDS_LOOKUP_UDIM) != 0 ||
        !std::all_of(operands.begin() + 1, operands.end(), IsConstant)) {
        return std::nullopt;
    }
    const std::uint32_t channel = value.channel == HDS_CHANNEL_ALL ? 0 : value.channel;
    DisplacementLookup lookup;
    lookup.texture = textures[expression.tiles[0]];
    lookup.channel = channel;
    lookup.wrapS = expression.lookup & 3U;
    lookup.wrapT = expression.lookup >> 2U & 3U;
    lookup.scale = ConstantOf(operands[2])[channel];
    lookup.bias = ConstantOf(operands[3])[channel];
    const ShaderExpression* st = operands[0].expression.get();
    while (st->kind == ShaderExpression::Kind::Affine ||
           (st->kind == ShaderExpression::Kind::Transform2d &&
            std::all_of(st->operands.begin() + 1, st->operands.end(), IsConstant))) {
        const std::array<double, 6> inner =
            st->kind == ShaderExpression::Kind::Affine
                ? st->rows
                : Transform2dRows(ConstantOf(st->operands[1])[0], ConstantOf(st->operands[2]),
                                  ConstantOf(st->operands[3]));
        lookup.rows = ComposeRows(lookup.rows, inner);
        st = st->operands[0].expression.get();
    }
    DisplacementInput result;
    result.constant = ConstantOf(operands[1])[channel];
    if (st->kind == ShaderExpression::Kind::Primvar && IsConstant(st->operands[0])) {
        result.primvar = st->primvar;
        lookup.missing = {ConstantOf(st->operands[0])[0], ConstantOf(st->operands[0])[1]};
    } else if (st->kind == ShaderExpression::Kind::Constant) {
        lookup.missing = {st->constant[0], st->constant[1]};
    } else {
        return std::nullopt;
    }
    result.lookup = std::move(lookup);
    return result;
}

namespace {

/// Constants, primvars, look-ups and networks; what the host cannot evaluate warns and is ignored.
DisplacementInput DisplacementBy(const ShaderValue& value,
                                 const std::vector<MaterialTexture>& textures,
                                 const std::string& materialPath, Warnings& warnings) {
    DisplacementInput displacement;
    if (!value) {
        return displacement;
    }
    const ShaderExpression& expression = *value.expression;
    if (IsConstant(value)) {
        displacement.constant = expression.constant[0];
    } else if (expression.kind == ShaderExpression::Kind::Primvar &&
               (value.channel == HDS_CHANNEL_ALL || value.channel == 0) &&
               IsConstant(expression.operands[0])) {
        displacement.constant = ConstantOf(expression.operands[0])[0];
        displacement.primvar = expression.primvar;
    } else if (auto lookup = LookupDisplacement(value, textures)) {
        displacement = std::move(*lookup);
    } else {
        std::string problem;
        displacement.network = MakeDisplacementNetwork(value, textures, &problem);
        if (!displacement.network) {
            warnings.Add(materialPath, "displacement by a network with " + problem + " is ignored");
        }
    }
    return displacement;
}

/// \param[out] value what the programs of hits evaluate; empty: nothing displaces
DisplacementInput MaterialXDisplacement(NetworkEvaluator& evaluator, const MaterialNode& node,
                                        const std::string& materialPath, Warnings& warnings,
                                        ShaderValue* value) {
    DisplacementInput result;
    if (node.identifier == "ND_displacement_vector3") {
        result.network = MakeVectorDisplacement(evaluator, node, value);
        return result;
    }
    const ShaderValue scale = evaluator.EvaluateOr(node, "scale", {1.0F, 1.0F, 1.0F, 1.0F}, 1);
    const ShaderValue amount = evaluator.Evaluate(node, "displacement");
    if (!amount) {
        return result;
    }
    *value = Multiply(amount, scale, 1);
    if (!LookupDisplacement(amount, evaluator.Textures()) || !IsConstant(scale)) {
        return DisplacementBy(*value, evaluator.Textures(), materialPath, warnings);
    }
    const float factor = ConstantOf(scale)[0];
    result = DisplacementBy(amount, evaluator.Textures(), materialPath, warnings);
    result.constant *= factor;
    result.lookup->scale *= factor;
    result.lookup->bias *= factor;
    return result;
}

/// Whether it has an amount: UsdPreviewSurface has one beside its surface.
bool IsDisplacementShader(const MaterialNode& node) {
    return node.identifier.rfind("ND_displacement", 0) == 0 ||
           node.parameters.count("displacement") + node.connections.count("displacement") > 0 ||
           node.identifier.find("UsdPreviewSurface") != std::string::npos;
}

/// Sets what hits are bumped by: amounts that are more than a primvar, which is as fine as the
/// triangles, and which the host knows how to evaluate.
void SetRelief(const ShaderValue& value, const std::vector<MaterialTexture>& textures,
               CompiledMaterial* material) {
    const DisplacementInput& displacement = material->displacement;
    if (!value || (!displacement.network && !displacement.lookup)) {
        return;
    }
    material->relief.value = value;
    material->relief.textures = textures;
    if (displacement.network && displacement.network->isVector) {
        material->relief.space = displacement.network->coordinates == HDS_NONE
                                     ? HDS_DISPLACES_OBJECT
                                     : HDS_DISPLACES_TANGENT;
    }
}

} // namespace

void SetDisplacement(const ShaderValue& amount, const std::vector<MaterialTexture>& textures,
                     const std::string& materialPath, Warnings& warnings,
                     CompiledMaterial* material) {
    material->displacement = DisplacementBy(amount, textures, materialPath, warnings);
    SetRelief(amount, textures, material);
}

void SetMaterialXDisplacement(NetworkEvaluator& evaluator, const MaterialNetwork& network,
                              const std::string& materialPath, Warnings& warnings,
                              CompiledMaterial* material) {
    const MaterialNode* node = FindTerminalShader(network, "displacement");
    if (node != nullptr && !IsDisplacementShader(*node)) {
        warnings.Add(materialPath, "displacement shader " + node->identifier + " of " + node->path +
                                       " is not supported; ignored");
    } else if (node != nullptr) {
        ShaderValue value;
        material->displacement =
            MaterialXDisplacement(evaluator, *node, materialPath, warnings, &value);
        SetRelief(value, evaluator.Textures(), material);
    }
}

} // namespace hds
