// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/shaderExpression.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hds {

ShaderValue MakeConstant(const std::array<float, 4>& value, std::uint32_t numComponents) {
    auto expression = std::make_shared<ShaderExpression>();
    expression->constant = value;
    return {std::move(expression), HDS_CHANNEL_ALL, numComponents};
}

ShaderValue SelectChannel(const ShaderValue& value, std::uint32_t channel) {
    const std::uint32_t source = value.channel == HDS_CHANNEL_ALL ? channel : value.channel;
    if (IsConstant(value)) {
        return MakeConstant({ConstantOf(value)[source], 0.0F, 0.0F, 1.0F}, 1);
    }
    return {value.expression, source, 1};
}

bool IsConstant(const ShaderValue& value) {
    return value && value.expression->kind == ShaderExpression::Kind::Constant;
}

const std::array<float, 4>& ConstantOf(const ShaderValue& value) {
    return value.expression->constant;
}

std::array<double, 6> Transform2dRows(double degrees, const std::array<float, 4>& scale,
                                      const std::array<float, 4>& translation) {
    const double angle = degrees * std::acos(-1.0) / 180.0;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return {c * scale[0], -s * scale[1], translation[0],
            s * scale[0], c * scale[1],  translation[1]};
}

ShaderValue MakeTransform2d(std::vector<ShaderValue> operands) {
    if (std::all_of(operands.begin(), operands.end(), IsConstant)) {
        const std::array<double, 6> rows = Transform2dRows(
            ConstantOf(operands[1])[0], ConstantOf(operands[2]), ConstantOf(operands[3]));
        return MakeAffine(operands[0], rows);
    }
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Transform2d;
    expression->operands = std::move(operands);
    return {std::move(expression), HDS_CHANNEL_ALL, 2};
}

std::array<double, 6> ComposeRows(const std::array<double, 6>& outer,
                                  const std::array<double, 6>& inner) {
    const std::array<double, 6>& m = outer;
    return {m[0] * inner[0] + m[1] * inner[3],        m[0] * inner[1] + m[1] * inner[4],
            m[0] * inner[2] + m[1] * inner[5] + m[2], m[3] * inner[0] + m[4] * inner[3],
            m[3] * inner[1] + m[4] * inner[4],        m[3] * inner[2] + m[4] * inner[5] + m[5]};
}

ShaderValue MakeAffine(const ShaderValue& in, const std::array<double, 6>& rows) {
    if (IsConstant(in)) {
        const std::array<float, 4>& st = ConstantOf(in);
        return MakeConstant({static_cast<float>(rows[0] * st[0] + rows[1] * st[1] + rows[2]),
                             static_cast<float>(rows[3] * st[0] + rows[4] * st[1] + rows[5]), 0.0F,
                             0.0F},
                            2);
    }
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Affine;
    const ShaderExpression& inner = *in.expression;
    if (inner.kind == ShaderExpression::Kind::Affine && in.channel == HDS_CHANNEL_ALL) {
        expression->operands = inner.operands;
        expression->rows = ComposeRows(rows, inner.rows);
    } else {
        expression->operands = {in};
        expression->rows = rows;
    }
    return {std::move(expression), HDS_CHANNEL_ALL, 2};
}

} // namespace hds
