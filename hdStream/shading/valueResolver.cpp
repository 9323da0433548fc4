// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/valueResolver.h"

#include "hdStream/shading/shaderMath.h"
#include "kernels/shared/compat.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

/// Components that the operands of an expression need.
std::uint32_t OperandComponents(const ShaderExpression& expression, std::size_t operand) {
    switch (expression.kind) {
    case Kind::Texture:
        return operand == 0 ? 2 : 3;
    case Kind::Affine:
    case Kind::Tangent:
        return 2;
    case Kind::Shifted:
        return operand == 0 ? 1 : 2;
    case Kind::ToSpace:
        return 3;
    case Kind::Math:
        return std::min(expression.operands[operand].numComponents, 3U);
    default:
        return expression.kind == Kind::Transform2d && operand != 1 ? 2 : 1;
    }
}

} // namespace

ShaderValue ValueResolver::Resolve(const ShaderValue& value, std::uint32_t numComponents) {
    const ShaderExpression& expression = *value.expression;
    if (expression.kind == Kind::Constant) {
        return value;
    }
    ShaderValue whole{value.expression, HDS_CHANNEL_ALL, 4};
    if (expression.kind == Kind::Primvar) {
        const std::uint32_t needed = value.channel == HDS_CHANNEL_ALL ? numComponents : 1;
        if (_findSlot(expression.primvar, needed) != HDS_NONE) {
            return value;
        }
        whole = Resolve(expression.operands[0], numComponents);
    } else if (const auto known = _resolved.find(&expression); known != _resolved.end()) {
        whole = known->second;
    } else {
        whole = ResolveOperands(expression, whole);
        _resolved[&expression] = whole;
    }
    if (value.channel != HDS_CHANNEL_ALL) {
        whole = SelectChannel(whole, value.channel);
    }
    whole.numComponents = value.numComponents;
    return whole;
}

/// `whole` itself when nothing below it changes.
ShaderValue ValueResolver::ResolveOperands(const ShaderExpression& expression,
                                           const ShaderValue& whole) {
    std::vector<ShaderValue> operands;
    bool isSame = true;
    for (std::size_t i = 0; i < expression.operands.size(); ++i) {
        const ShaderValue& operand = expression.operands[i];
        operands.push_back(Resolve(operand, OperandComponents(expression, i)));
        isSame = isSame && operands.back().expression == operand.expression;
    }
    if (isSame) {
        return whole;
    }
    if (expression.kind == Kind::Transform2d) {
        return MakeTransform2d(std::move(operands));
    }
    if (expression.kind == Kind::Affine) {
        return MakeAffine(operands[0], expression.rows);
    }
    if (expression.kind == Kind::Math) {
        return MakeMath(expression.code, std::move(operands), expression.numComponents);
    }
    auto copy = std::make_shared<ShaderExpression>(expression);
    copy->operands = std::move(operands);
    return {std::move(copy), HDS_CHANNEL_ALL, 4};
}

} // namespace hds
