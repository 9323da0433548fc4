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
        const std::array<float, 4>& in = ConstantOf(operands[0]);
        return MakeConstant({static_cast<float>(rows[0] * in[0] + rows[1] * in[1] + rows[2]),
                             static_cast<float>(rows[3] * in[0] + rows[4] * in[1] + rows[5]), 0.0F,
                             0.0F},
                            2);
    }
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Transform2d;
    expression->operands = std::move(operands);
    return {std::move(expression), HDS_CHANNEL_ALL, 2};
}

} // namespace hds
