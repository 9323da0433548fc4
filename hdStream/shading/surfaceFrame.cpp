// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/surfaceFrame.h"

#include "hdStream/shading/nodeWalk.h"
#include "hdStream/shading/patternNode.h"
#include "hdStream/shading/programWriter.h"
#include "hdStream/shading/shaderMath.h"
#include "hdStream/shading/shaderNodes.h"
#include "kernels/shared/material.h"

#include <algorithm>
#include <iterator>
#include <set>

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

/// Whether a node gives a normal in tangent space.
bool IsMap(const std::string& identifier) {
    constexpr const char* kMaps[] = {"ND_normalmap", "ND_bump_", "ND_gltf_normalmap",
                                     "ND_hextilednormalmap", "ND_flake"};
    return std::any_of(std::begin(kMaps), std::end(kMaps),
                       [&](const char* name) { return identifier.rfind(name, 0) == 0; });
}

/// Whether a node that gives a normal in tangent space is below an input.
bool HasMap(const NetworkEvaluator& network, const MaterialNode& node, const std::string& input,
            std::set<const MaterialNode*>* searched) {
    const MaterialNode* source = network.FindSource(node, input);
    return source != nullptr && searched->insert(source).second &&
           (IsMap(source->identifier) ||
            std::any_of(source->connections.begin(), source->connections.end(),
                        [&](const auto& connection) {
                            return HasMap(network, *source, connection.first, searched);
                        }));
}

/// The coordinates of the first image below a value that give it a frame; empty: none.
ShaderValue FrameOf(const ShaderValue& value) {
    const ShaderExpression& expression = *value.expression;
    if (expression.kind == Kind::Texture || !HasFrame(value)) {
        return HasFrame(value) ? expression.operands[0] : ShaderValue();
    }
    return FrameOf(*std::find_if(expression.operands.begin(), expression.operands.end(),
                                 [](const ShaderValue& one) { return HasFrame(one); }));
}

/// Reads networks that blend normals in tangent space. Their nodes give what is turned where what
/// they are given is turned, so it does not matter that MaterialX computes them in world space:
/// all ways through them end at maps, bumps and the surface's own normal.
class NormalBlends {
public:
    explicit NormalBlends(NetworkEvaluator& network) : _network(network) {}

    /// Empty: another vector takes part, or another node.
    ShaderValue Read(const MaterialNode& node, const std::string& input) {
        const MaterialNode* source = _network.FindSource(node, input);
        if (source == nullptr) {
            const ShaderValue value = _network.EvaluateOr(node, input, {}, 3);
            return node.connections.count(input) == 0 && IsAll(value, 0.0F) ? value : ShaderValue();
        }
        const auto read = [&] { return ReadNode(*source, node, input); };
        return _walk.Visit(*source, read).value_or(ShaderValue());
    }

private:
    ShaderValue ReadNode(const MaterialNode& source, const MaterialNode& node,
                         const std::string& input) {
        const std::string& id = source.identifier;
        if (IsMap(id)) {
            const ShaderValue map = _network.Evaluate(node, input);
            return map ? MakeMath(HDS_MATH_NORMALIZE, {map}, 3) : map;
        }
        if (id == "ND_normal_vector3") {
            return MakeConstant({0.0F, 0.0F, 1.0F, 0.0F}, 3);
        }
        if (id == "ND_normalize_vector3") {
            const ShaderValue in = Read(source, "in");
            return in ? MakeMath(HDS_MATH_NORMALIZE, {in}, 3) : in;
        }
        if (id == "ND_multiply_vector3FA" || id == "ND_divide_vector3FA") {
            const ShaderValue in = Read(source, "in1");
            const ShaderValue by = _network.EvaluateOr(source, "in2", {1.0F}, 1);
            return !in ? in : id[3] == 'm' ? Multiply(in, by, 3) : Divide(in, by, 3);
        }
        const bool isMix = id == "ND_mix_vector3";
        const bool isSum = id == "ND_add_vector3";
        if (!isMix && !isSum && id != "ND_subtract_vector3") {
            return {};
        }
        const ShaderValue first = Read(source, isMix ? "bg" : "in1");
        const ShaderValue second = Read(source, isMix ? "fg" : "in2");
        if (!first || !second) {
            return {};
        }
        return isMix   ? Mix(first, second, _network.EvaluateOr(source, "mix", {}, 1), 3)
               : isSum ? Add(first, second, 3)
                       : Subtract(first, second, 3);
    }

    NetworkEvaluator& _network;
    NodeWalk<ShaderValue> _walk;
};

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

ShaderValue InTangentSpace(NetworkEvaluator& network, const MaterialNode& node,
                           const ShaderValue& direction, std::uint32_t space) {
    const ShaderValue ofImage = FrameOf(direction);
    const ShaderValue coordinates = ofImage ? ofImage : network.ImageCoordinates(node);
    const auto part = [&](const ShaderValue& axis) { return DotProduct(direction, axis, 3); };
    const ShaderValue up = part(MakeGeometry(Kind::Normal, space));
    const ShaderValue local =
        MakeMath(HDS_MATH_COMBINE,
                 {part(MakeGeometry(Kind::Tangent, space, {coordinates})),
                  part(MakeGeometry(Kind::Tangent, space | HDS_TANGENT_ACROSS, {coordinates})), up,
                  MakeScalar(0.0F)},
                 4);
    const ShaderValue isBelow = MakeMath(HDS_MATH_GREATER, {MakeScalar(0.0F), up}, 1);
    const ShaderValue sign =
        MakeMath(HDS_MATH_SELECT, {isBelow, MakeScalar(-1.0F), MakeScalar(1.0F)}, 1);
    return Multiply(local, sign, 3);
}

ShaderValue EvaluateNormal(NetworkEvaluator& network, const MaterialNode& node,
                           const std::string& input) {
    const MaterialNode* source = network.FindSource(node, input);
    if (source != nullptr && IsMap(source->identifier)) {
        return network.Evaluate(node, input);
    }
    if (IsSurfaces(network, node, input)) {
        return {};
    }
    if (const ShaderValue blend = NormalBlends(network).Read(node, input)) {
        return blend;
    }
    std::set<const MaterialNode*> searched;
    if (!HasMap(network, node, input, &searched)) {
        return network.Evaluate(node, input)
                   ? InTangentSpace(network, node, network.EvaluateOr(node, input, {}, 3),
                                    HDS_SPACE_WORLD)
                   : ShaderValue();
    }
    WarnOf(network, node, input, kSurfacesFrame);
    return {};
}

ShaderValue EvaluateTangent(NetworkEvaluator& network, const MaterialNode& node,
                            const std::string& input) {
    return TurnsOf(network, node, input, 0);
}

} // namespace hds
