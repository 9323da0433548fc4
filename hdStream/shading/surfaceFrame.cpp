// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/surfaceFrame.h"

#include "hdStream/shading/patternNode.h"
#include "hdStream/shading/shaderMath.h"
#include "hdStream/shading/shaderNodes.h"
#include "kernels/shared/material.h"

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

/// Nodes on the way to a direction. More are a cycle, which the evaluator finds and tells of.
constexpr int kMaxDepth = 64;

/// The node that feeds an input, before it is normalised; null: none, or a cycle.
const MaterialNode* FindDirection(const NetworkEvaluator& network, const MaterialNode& node,
                                  const std::string& input) {
    const MaterialNode* source = network.FindSource(node, input);
    for (int depth = 0; source != nullptr && source->identifier == "ND_normalize_vector3";
         ++depth) {
        source = depth < kMaxDepth ? network.FindSource(*source, "in") : nullptr;
    }
    return source;
}

/// Whether a tangent is that of the first coordinates.
bool IsOfFirstCoordinates(NetworkEvaluator& network, const MaterialNode& tangent) {
    const ShaderValue index = network.EvaluateOr(tangent, "index", {}, 1);
    return IsConstant(index) && static_cast<int>(ConstantOf(index)[0]) == 0;
}

/// EvaluateTangent of any network: the angle of the vector.
ShaderValue TurnsOfVector(NetworkEvaluator& network, const MaterialNode& node,
                          const std::string& input) {
    if (!network.Evaluate(node, input)) {
        return MakeScalar(0.0F);
    }
    const ShaderValue direction = network.EvaluateOr(node, input, {}, 3);
    const ShaderValue own =
        MakeGeometry(Kind::Tangent, HDS_SPACE_WORLD, {network.ImageCoordinates(node)});
    const ShaderValue normal = MakeGeometry(Kind::Normal, HDS_SPACE_WORLD);
    const ShaderValue across = DotProduct(normal, MakeMath(HDS_MATH_CROSS, {own, direction}, 3), 3);
    return Multiply(MakeMath(HDS_MATH_ATAN2, {across, DotProduct(own, direction, 3)}, 1),
                    MakeScalar(kTurnsOfRadian), 1);
}

/// EvaluateTangent below `depth` rotations.
ShaderValue TurnsOf(NetworkEvaluator& network, const MaterialNode& node, const std::string& input,
                    int depth) {
    const MaterialNode* source = depth < kMaxDepth ? FindDirection(network, node, input) : nullptr;
    if (source != nullptr && source->identifier == "ND_tangent_vector3" &&
        IsOfFirstCoordinates(network, *source)) {
        return MakeScalar(0.0F);
    }
    if (source != nullptr && source->identifier == "ND_rotate3d_vector3") {
        const MaterialNode* axis = FindDirection(network, *source, "axis");
        if (axis != nullptr && axis->identifier == "ND_normal_vector3") {
            // Clockwise, as MaterialX turns.
            const ShaderValue turns = Multiply(network.EvaluateOr(*source, "amount", {}, 1),
                                               MakeScalar(1.0F / 360.0F), 1);
            return Subtract(TurnsOf(network, *source, "in", depth + 1), turns, 1);
        }
    }
    return TurnsOfVector(network, node, input);
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
    return TurnsOf(network, node, input, 0);
}

} // namespace hds
