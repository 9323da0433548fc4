// SPDX-License-Identifier: Apache-2.0
// What MaterialX's standard nodes are made of: inputs by name, and expressions that several of them
// share. Part of the material compiler. Explained in docs/materials.md.
#pragma once

#include "hdStream/shading/networkEvaluator.h"
#include "hdStream/shading/nodeId.h"
#include "hdStream/shading/patternRegistry.h"
#include "hdStream/shading/shaderMath.h"

namespace hds {

constexpr float kDegree = 0.01745329252F; ///< in radians

/// One channel; of a scalar, the scalar.
ShaderValue ChannelOf(const ShaderValue& value, std::uint32_t channel);

ShaderValue CombineChannels(const ShaderValue& x, const ShaderValue& y, const ShaderValue& z,
                            const ShaderValue& w, std::uint32_t numComponents);

/// The dot product of 2 to 4 components; what lies behind them may be anything.
ShaderValue DotProduct(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents);

ShaderValue ClampTo(const ShaderValue& value, const ShaderValue& low, const ShaderValue& high,
                    std::uint32_t numComponents);

/// Clockwise, as MaterialX turns.
ShaderValue Rotate2d(const ShaderValue& in, const ShaderValue& degrees);

/// A primvar of the prim.
ShaderValue MakePrimvar(const std::string& name, const ShaderValue& fallback,
                        std::uint32_t numComponents);

/// Geometry of the point: `code` and `operands` as the kind has them.
ShaderValue MakeGeometry(ShaderExpression::Kind kind, std::uint32_t code,
                         std::vector<ShaderValue> operands = {});

/// One node of a network: its id, its inputs, and the output that is asked for.
class PatternNode {
public:
    PatternNode(NetworkEvaluator& network, const MaterialNode& node, const std::string& output)
        : _network(network), _node(node), _output(output), _id(ParseId(node.identifier)),
          _n(_id.lastComponents) {}

protected:
    /// An input: a vector, or a scalar (in all components) where it is one or nothing.
    ShaderValue In(const std::string& input, float fallback);
    ShaderValue Vector(const std::string& input, const std::array<float, 4>& fallback,
                       std::uint32_t numComponents);
    /// A function whose result has as many components as the node's.
    ShaderValue Math(std::uint32_t code, std::vector<ShaderValue> operands) const;

    ShaderValue Coordinates();
    /// HDS_SPACE_* of the node's `space`.
    std::uint32_t Space();
    /// Expression::Kind of geometry in the node's `space`.
    ShaderValue Geometry(ShaderExpression::Kind kind);
    /// An input that is connected, else the position or the normal in object space.
    ShaderValue GeometryInput(const char* input, ShaderExpression::Kind kind);
    ShaderValue Mix(const ShaderValue& background, const ShaderValue& foreground,
                    const ShaderValue& share) const;
    ShaderValue RemapTo(const ShaderValue& in, const ShaderValue& low, const ShaderValue& high,
                        const ShaderValue& outLow, const ShaderValue& outHigh) const;
    ShaderValue RangeTo(const ShaderValue& in, const ShaderValue& low, const ShaderValue& high,
                        const ShaderValue& gamma, const ShaderValue& outLow,
                        const ShaderValue& outHigh, const ShaderValue& isClamped) const;
    /// Places coordinates as place2d does.
    ShaderValue Place(const ShaderValue& coordinates, const ShaderValue& scale,
                      const ShaderValue& rotate, const ShaderValue& offset,
                      std::array<float, 4> pivotDefault);
    /// Tangent-space normals of an encoded one.
    ShaderValue SignedNormal(const ShaderValue& in, const ShaderValue& size);

    // Arithmetic with as many components as the node has.
    ShaderValue Add(const ShaderValue& a, const ShaderValue& b) const {
        return Math(HDS_MATH_ADD, {a, b});
    }
    ShaderValue Subtract(const ShaderValue& a, const ShaderValue& b) const {
        return Math(HDS_MATH_SUBTRACT, {a, b});
    }
    ShaderValue Multiply(const ShaderValue& a, const ShaderValue& b) const {
        return Math(HDS_MATH_MULTIPLY, {a, b});
    }
    ShaderValue Divide(const ShaderValue& a, const ShaderValue& b) const {
        return Math(HDS_MATH_DIVIDE, {a, b});
    }
    ShaderValue OneMinus(const ShaderValue& value) const {
        return Subtract(MakeScalar(1.0F), value);
    }

    NetworkEvaluator& _network;
    const MaterialNode& _node;
    const std::string& _output;
    NodeId _id;
    std::uint32_t _n; ///< components of the result
};

/// Of a member function of a class of PatternNode the PatternFunction.
template <auto kFunction>
struct PatternMember;
template <typename Node, ShaderValue (Node::*kFunction)()>
struct PatternMember<kFunction> {
    static ShaderValue Evaluate(NetworkEvaluator& network, const MaterialNode& node,
                                const std::string& output) {
        return (Node(network, node, output).*kFunction)();
    }
};
template <auto kFunction>
constexpr PatternFunction kPattern = &PatternMember<kFunction>::Evaluate;

} // namespace hds
