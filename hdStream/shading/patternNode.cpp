// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/patternNode.h"

#include <memory>
#include <utility>

namespace hds {

ShaderValue ChannelOf(const ShaderValue& value, std::uint32_t channel) {
    return value.numComponents == 1 ? value : SelectChannel(value, channel);
}

ShaderValue CombineChannels(const ShaderValue& x, const ShaderValue& y, const ShaderValue& z,
                            const ShaderValue& w, std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_COMBINE, {x, y, z, w}, numComponents);
}

ShaderValue DotProduct(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents) {
    if (numComponents == 3) {
        return MakeMath(HDS_MATH_DOT, {a, b}, 1);
    }
    ShaderValue sum = MakeScalar(0.0F);
    for (std::uint32_t k = 0; k < numComponents; ++k) {
        const ShaderValue product =
            MakeMath(HDS_MATH_MULTIPLY, {ChannelOf(a, k), ChannelOf(b, k)}, 1);
        sum = MakeMath(HDS_MATH_ADD, {sum, product}, 1);
    }
    return sum;
}

ShaderValue ClampTo(const ShaderValue& value, const ShaderValue& low, const ShaderValue& high,
                    std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_MIN, {MakeMath(HDS_MATH_MAX, {value, low}, numComponents), high},
                    numComponents);
}

ShaderValue Rotate2d(const ShaderValue& in, const ShaderValue& degrees) {
    if (IsConstant(degrees)) {
        const std::array<double, 6> rows =
            Transform2dRows(-ConstantOf(degrees)[0], {1.0F, 1.0F, 0.0F, 0.0F}, {});
        return MakeAffine(in, rows);
    }
    const ShaderValue angle =
        MakeMath(HDS_MATH_MULTIPLY, {Spread(degrees), MakeScalar(kDegree)}, 1);
    const ShaderValue c = MakeMath(HDS_MATH_COS, {angle}, 1);
    const ShaderValue s = MakeMath(HDS_MATH_SIN, {angle}, 1);
    const auto product = [](const ShaderValue& a, const ShaderValue& b) {
        return MakeMath(HDS_MATH_MULTIPLY, {a, b}, 1);
    };
    const ShaderValue x = ChannelOf(in, 0);
    const ShaderValue y = ChannelOf(in, 1);
    return CombineChannels(MakeMath(HDS_MATH_ADD, {product(c, x), product(s, y)}, 1),
                           MakeMath(HDS_MATH_SUBTRACT, {product(c, y), product(s, x)}, 1),
                           MakeScalar(0.0F), MakeScalar(0.0F), 2);
}

ShaderValue MakePrimvar(const std::string& name, const ShaderValue& fallback,
                        std::uint32_t numComponents) {
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Primvar;
    expression->primvar = name;
    expression->operands = {fallback};
    return {std::move(expression), HDS_CHANNEL_ALL, numComponents};
}

ShaderValue MakeGeometry(ShaderExpression::Kind kind, std::uint32_t code,
                         std::vector<ShaderValue> operands) {
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = kind;
    expression->code = code;
    expression->operands = std::move(operands);
    return {std::move(expression), HDS_CHANNEL_ALL, 3};
}

ShaderValue PatternNode::In(const std::string& input, float fallback) {
    return Spread(_network.EvaluateOr(_node, input, {fallback, fallback, fallback, fallback}, 1));
}

ShaderValue PatternNode::Vector(const std::string& input, const std::array<float, 4>& fallback,
                                std::uint32_t numComponents) {
    return _network.EvaluateOr(_node, input, fallback, numComponents);
}

ShaderValue PatternNode::Math(std::uint32_t code, std::vector<ShaderValue> operands) const {
    return MakeMath(code, std::move(operands), _n);
}

ShaderValue PatternNode::Coordinates() {
    return _network.ImageCoordinates(_node);
}

std::uint32_t PatternNode::Space() {
    return _network.Text(_node, "space") == "world" ? HDS_SPACE_WORLD : HDS_SPACE_OBJECT;
}

ShaderValue PatternNode::Geometry(ShaderExpression::Kind kind) {
    return MakeGeometry(kind, Space());
}

ShaderValue PatternNode::GeometryInput(const char* input, ShaderExpression::Kind kind) {
    const ShaderValue authored = _network.Evaluate(_node, input);
    return authored && authored.numComponents >= 3 ? authored : Geometry(kind);
}

ShaderValue PatternNode::Mix(const ShaderValue& background, const ShaderValue& foreground,
                             const ShaderValue& share) const {
    return Math(HDS_MATH_MIX, {background, foreground, share});
}

ShaderValue PatternNode::RemapTo(const ShaderValue& in, const ShaderValue& low,
                                 const ShaderValue& high, const ShaderValue& outLow,
                                 const ShaderValue& outHigh) const {
    const ShaderValue share = Math(HDS_MATH_DIVIDE, {Math(HDS_MATH_SUBTRACT, {in, low}),
                                                     Math(HDS_MATH_SUBTRACT, {high, low})});
    return Math(HDS_MATH_ADD, {outLow, Math(HDS_MATH_MULTIPLY,
                                            {share, Math(HDS_MATH_SUBTRACT, {outHigh, outLow})})});
}

ShaderValue PatternNode::RangeTo(const ShaderValue& in, const ShaderValue& low,
                                 const ShaderValue& high, const ShaderValue& gamma,
                                 const ShaderValue& outLow, const ShaderValue& outHigh,
                                 const ShaderValue& isClamped) const {
    const ShaderValue zero = MakeScalar(0.0F);
    const ShaderValue one = MakeScalar(1.0F);
    ShaderValue share = RemapTo(in, low, high, zero, one);
    if (!IsAll(gamma, 1.0F)) {
        const ShaderValue power = Math(
            HDS_MATH_POWER, {Math(HDS_MATH_ABS, {share}), Math(HDS_MATH_DIVIDE, {one, gamma})});
        share = Math(HDS_MATH_MULTIPLY, {power, Math(HDS_MATH_SIGN, {share})});
    }
    const ShaderValue result = RemapTo(share, zero, one, outLow, outHigh);
    return IsAll(isClamped, 1.0F) ? ClampTo(result, outLow, outHigh, _n) : result;
}

ShaderValue PatternNode::Place(const ShaderValue& coordinates, const ShaderValue& scale,
                               const ShaderValue& rotate, const ShaderValue& offset,
                               std::array<float, 4> pivotDefault) {
    const auto math = [](std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
        return MakeMath(code, {a, b}, 2);
    };
    const ShaderValue pivot = Vector("pivot", pivotDefault, 2);
    const bool movesFirst = IsAll(In("operationorder", 0.0F), 1.0F);
    ShaderValue st = math(HDS_MATH_SUBTRACT, coordinates, pivot);
    if (movesFirst) {
        st = Rotate2d(math(HDS_MATH_SUBTRACT, st, offset), rotate);
        st = math(HDS_MATH_DIVIDE, st, scale);
    } else {
        st = Rotate2d(math(HDS_MATH_DIVIDE, st, scale), rotate);
        st = math(HDS_MATH_SUBTRACT, st, offset);
    }
    return math(HDS_MATH_ADD, st, pivot);
}

ShaderValue PatternNode::SignedNormal(const ShaderValue& in, const ShaderValue& size) {
    const ShaderValue scale =
        CombineChannels(ChannelOf(size, 0), ChannelOf(size, size.numComponents > 1),
                        MakeScalar(1.0F), MakeScalar(0.0F), 4);
    const auto toSigned = [&](const ShaderValue& value) {
        const ShaderValue doubled = MakeMath(HDS_MATH_MULTIPLY, {value, MakeScalar(2.0F)}, 3);
        const ShaderValue moved = MakeMath(HDS_MATH_SUBTRACT, {doubled, MakeScalar(1.0F)}, 3);
        return MakeMath(HDS_MATH_MULTIPLY, {moved, scale}, 3);
    };
    if (in.expression->kind == ShaderExpression::Kind::Texture && in.channel == HDS_CHANNEL_ALL &&
        IsConstant(scale)) {
        auto lookup = std::make_shared<ShaderExpression>(*in.expression);
        const std::array<float, 4>& s = ConstantOf(scale);
        lookup->operands[1] = toSigned(lookup->operands[1]);
        lookup->operands[2] = MakeConstant({2.0F * s[0], 2.0F * s[1], 2.0F, 1.0F}, 4);
        lookup->operands[3] = MakeConstant({-s[0], -s[1], -1.0F, 0.0F}, 4);
        return {std::move(lookup), HDS_CHANNEL_ALL, 3};
    }
    return toSigned(in);
}

} // namespace hds
