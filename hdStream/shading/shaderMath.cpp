// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/shaderMath.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

/// The value as the machine holds it after the function.
std::array<float, 4> Fold(std::uint32_t code, const std::vector<ShaderValue>& operands) {
    std::array<shared::float4, 4> values{};
    for (std::size_t i = 0; i < operands.size(); ++i) {
        const std::array<float, 4>& constant = ConstantOf(operands[i]);
        values[i] = {constant[0], constant[1], constant[2], constant[3]};
    }
    const shared::float4 result = shared::math_apply(code, values.data());
    return {result.x, result.y, result.z, result.w};
}

/// The operand that the function returns unchanged, or null.
const ShaderValue* FindUnchanged(std::uint32_t code, const std::vector<ShaderValue>& operands) {
    const ShaderValue& first = operands[0];
    switch (code) {
    case HDS_MATH_ADD:
        return IsAll(operands[1], 0.0F) ? &first : IsAll(first, 0.0F) ? &operands[1] : nullptr;
    case HDS_MATH_MULTIPLY:
        return IsAll(operands[1], 1.0F) ? &first : IsAll(first, 1.0F) ? &operands[1] : nullptr;
    case HDS_MATH_SUBTRACT:
        return IsAll(operands[1], 0.0F) ? &first : nullptr;
    case HDS_MATH_DIVIDE:
    case HDS_MATH_POWER:
        return IsAll(operands[1], 1.0F) ? &first : nullptr;
    case HDS_MATH_MIX:
        return IsAll(operands[2], 0.0F)   ? &first
               : IsAll(operands[2], 1.0F) ? &operands[1]
                                          : nullptr;
    case HDS_MATH_SELECT:
        return !IsConstant(first) ? nullptr : IsAll(first, 0.0F) ? &operands[2] : &operands[1];
    default:
        return nullptr;
    }
}

/// Whether a value is texture coordinates, with derivatives.
bool IsCoordinates(const ShaderValue& value) {
    const Kind kind = value.expression->kind;
    return value.numComponents == 2 && value.channel == HDS_CHANNEL_ALL &&
           (kind == Kind::Primvar || kind == Kind::Affine || kind == Kind::Transform2d);
}

/// Coordinates that a constant scales or moves; nothing: not that.
ShaderValue TryAffine(std::uint32_t code, const std::vector<ShaderValue>& operands) {
    if (operands.size() != 2) {
        return {};
    }
    const bool isSwapped = !IsCoordinates(operands[0]);
    const ShaderValue& in = operands[isSwapped ? 1 : 0];
    const ShaderValue& other = operands[isSwapped ? 0 : 1];
    if (!IsCoordinates(in) || !IsConstant(other)) {
        return {};
    }
    const double x = ConstantOf(other)[0];
    const double y = ConstantOf(other)[1];
    switch (code) {
    case HDS_MATH_ADD:
        return MakeAffine(in, {1, 0, x, 0, 1, y});
    case HDS_MATH_MULTIPLY:
        return MakeAffine(in, {x, 0, 0, 0, y, 0});
    case HDS_MATH_SUBTRACT:
        return isSwapped ? MakeAffine(in, {-1, 0, x, 0, -1, y})
                         : MakeAffine(in, {1, 0, -x, 0, 1, -y});
    case HDS_MATH_DIVIDE:
        if (isSwapped || x == 0.0 || y == 0.0) {
            return {};
        }
        return MakeAffine(in, {1 / x, 0, 0, 0, 1 / y, 0});
    default:
        return {};
    }
}

using Pair = std::pair<const ShaderExpression*, const ShaderExpression*>;

bool AreAlike(const ShaderValue& a, const ShaderValue& b, std::set<Pair>* known);

/// \param known pairs that need no second look, since nodes may be reached by many ways
bool AreAlike(const ShaderExpression& a, const ShaderExpression& b, std::set<Pair>* known) {
    if (&a == &b || !known->insert({&a, &b}).second) {
        return true;
    }
    return a.kind == b.kind && a.constant == b.constant && a.primvar == b.primvar &&
           a.tiles == b.tiles && a.lookup == b.lookup && a.code == b.code &&
           a.numComponents == b.numComponents && a.rows == b.rows &&
           std::equal(a.operands.begin(), a.operands.end(), b.operands.begin(), b.operands.end(),
                      [&](const ShaderValue& x, const ShaderValue& y) {
                          return x.numComponents == y.numComponents && AreAlike(x, y, known);
                      });
}

bool AreAlike(const ShaderValue& a, const ShaderValue& b, std::set<Pair>* known) {
    if (!a || !b) {
        return !a && !b;
    }
    return a.channel == b.channel && AreAlike(*a.expression, *b.expression, known);
}

} // namespace

ShaderValue MakeScalar(float value) {
    return MakeConstant({value, value, value, value}, 1);
}

bool IsAll(const ShaderValue& value, float constant) {
    if (!IsConstant(value)) {
        return false;
    }
    const auto count = static_cast<std::ptrdiff_t>(std::max(value.numComponents, 1U));
    const std::array<float, 4>& c = ConstantOf(value);
    return std::all_of(c.begin(), c.begin() + count, [&](float x) { return x == constant; });
}

bool AreSame(const ShaderValue& a, const ShaderValue& b) {
    if (!a || !b) {
        return !a && !b;
    }
    // A scalar stands for itself in all components, whatever its constant holds beyond the first.
    const ShaderValue x = Spread(a);
    const ShaderValue y = Spread(b);
    if (IsConstant(x) && IsConstant(y)) {
        const auto count = static_cast<std::ptrdiff_t>(std::max(a.numComponents, b.numComponents));
        return std::equal(ConstantOf(x).begin(), ConstantOf(x).begin() + count,
                          ConstantOf(y).begin());
    }
    std::set<Pair> known;
    return AreAlike(x, y, &known);
}

ShaderValue Spread(const ShaderValue& value) {
    if (value.numComponents != 1) {
        return value;
    }
    if (IsConstant(value)) {
        return MakeScalar(ConstantOf(value)[0]);
    }
    const ShaderExpression& expression = *value.expression;
    const bool isSpread = value.channel != HDS_CHANNEL_ALL ||
                          (expression.kind == Kind::Math && expression.numComponents == 1) ||
                          expression.kind == Kind::Chance || expression.kind == Kind::Inside;
    return isSpread ? value : ShaderValue{value.expression, 0, 1};
}

ShaderValue MakeMath(std::uint32_t code, std::vector<ShaderValue> operands,
                     std::uint32_t numComponents) {
    for (ShaderValue& operand : operands) {
        operand = Spread(operand);
    }
    if (std::all_of(operands.begin(), operands.end(), IsConstant)) {
        return MakeConstant(Fold(code, operands), numComponents);
    }
    if (const ShaderValue* same = FindUnchanged(code, operands)) {
        ShaderValue result = *same;
        result.numComponents = numComponents;
        return result;
    }
    if (numComponents == 2) {
        if (ShaderValue affine = TryAffine(code, operands)) {
            return affine;
        }
    }
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = Kind::Math;
    expression->code = code;
    expression->numComponents = numComponents;
    expression->operands = std::move(operands);
    return {std::move(expression), HDS_CHANNEL_ALL, numComponents};
}

ShaderValue Add(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_ADD, {a, b}, numComponents);
}

ShaderValue Subtract(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_SUBTRACT, {a, b}, numComponents);
}

ShaderValue Multiply(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_MULTIPLY, {a, b}, numComponents);
}

ShaderValue Divide(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_DIVIDE, {a, b}, numComponents);
}

ShaderValue Power(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_POWER, {a, b}, numComponents);
}

ShaderValue OneMinus(const ShaderValue& value, std::uint32_t numComponents) {
    return Subtract(MakeScalar(1.0F), value, numComponents);
}

ShaderValue Mix(const ShaderValue& background, const ShaderValue& foreground,
                const ShaderValue& share, std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_MIX, {background, foreground, share}, numComponents);
}

} // namespace hds
