// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/surfaceFrame.h"

#include "hdStream/shading/patternNode.h"
#include "hdStream/shading/shaderMath.h"
#include "hdStream/shading/shaderNodes.h"
#include "kernels/shared/material.h"

#include <memory>
#include <utility>
#include <vector>

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

constexpr float kTurnsOfRadians = 0.15915494309F;

/// The node that feeds an input, before it is normalised; null: none.
const MaterialNode* FindDirection(const NetworkEvaluator& network, const MaterialNode& node,
                                  const std::string& input) {
    const MaterialNode* source = network.FindSource(node, input);
    while (source != nullptr && source->identifier == "ND_normalize_vector3") {
        source = network.FindSource(*source, "in");
    }
    return source;
}

ShaderValue MakeGeometry(Kind kind, std::vector<ShaderValue> operands) {
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = kind;
    expression->code = HDS_SPACE_WORLD;
    expression->operands = std::move(operands);
    return {std::move(expression), HDS_CHANNEL_ALL, 3};
}

} // namespace

void WarnOf(NetworkEvaluator& network, const MaterialNode& node, const std::string& input,
            const std::string& what) {
    network.Warn(input + " of " + node.path + ": " + what);
}

bool IsSurfaces(const NetworkEvaluator& network, const MaterialNode& node,
                const std::string& input) {
    if (node.connections.count(input) == 0) {
        return true;
    }
    const MaterialNode* source = FindDirection(network, node, input);
    return source != nullptr && (source->identifier == "ND_normal_vector3" ||
                                 source->identifier == "ND_tangent_vector3");
}

ShaderValue EvaluateNormal(NetworkEvaluator& network, const MaterialNode& node,
                           const std::string& input) {
    const MaterialNode* source = network.FindSource(node, input);
    const std::string id = source == nullptr ? std::string() : source->identifier;
    const auto isOne = [&](const char* name) { return id.rfind(name, 0) == 0; };
    if (isOne("ND_normalmap") || isOne("ND_bump_") || isOne("ND_gltf_normalmap") ||
        isOne("ND_hextilednormalmap") || isOne("ND_flake")) {
        return network.Evaluate(node, input);
    }
    if (!IsSurfaces(network, node, input)) {
        WarnOf(network, node, input, kSurfacesFrame);
    }
    return {};
}

ShaderValue EvaluateTangent(NetworkEvaluator& network, const MaterialNode& node,
                            const std::string& input) {
    const MaterialNode* source = FindDirection(network, node, input);
    if (source != nullptr && source->identifier == "ND_tangent_vector3") {
        return MakeScalar(0.0F);
    }
    if (source != nullptr && source->identifier == "ND_rotate3d_vector3" &&
        source->connections.count("axis") != 0 && IsSurfaces(network, *source, "axis")) {
        // Clockwise, as MaterialX turns.
        const ShaderValue turns =
            Multiply(network.EvaluateOr(*source, "amount", {}, 1), MakeScalar(1.0F / 360.0F), 1);
        return Subtract(EvaluateTangent(network, *source, "in"), turns, 1);
    }
    const ShaderValue tangent = network.Evaluate(node, input);
    if (!tangent) {
        return MakeScalar(0.0F);
    }
    const ShaderValue direction = network.EvaluateOr(node, input, {}, 3);
    const ShaderValue own = MakeGeometry(Kind::Tangent, {network.ImageCoordinates(node)});
    const ShaderValue normal = MakeGeometry(Kind::Normal, {});
    const ShaderValue across = DotProduct(normal, MakeMath(HDS_MATH_CROSS, {own, direction}, 3), 3);
    return Multiply(MakeMath(HDS_MATH_ATAN2, {across, DotProduct(own, direction, 3)}, 1),
                    MakeScalar(kTurnsOfRadians), 1);
}

} // namespace hds
