// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/networkValues.h"

#include "hdStream/scene/textureAmount.h"
#include "kernels/shared/programMath.h"

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

using StepKind = DisplacementStep::Kind;
using Value = NetworkValue;

float Rounded(double value) {
    return std::isfinite(value) ? static_cast<float>(value) : 0.0F;
}

/// The tile of coordinates, which become those in it; null: a hole. As program_findTile.
const DisplacementTile* FindTile(const DisplacementStep& step, double* s, double* t) {
    std::size_t index = 0;
    if ((step.code & HDS_LOOKUP_UDIM) != 0) {
        const double column = std::floor(*s);
        const double row = std::floor(*t);
        if (!(column >= 0.0 && column < 10.0 && row >= 0.0 && row < 1000.0)) {
            return nullptr;
        }
        index = static_cast<std::size_t>(row) * 10 + static_cast<std::size_t>(column);
        *s -= column;
        *t -= row;
    }
    return index < step.tiles.size() && step.tiles[index].channels != 0 ? &step.tiles[index]
                                                                        : nullptr;
}

Value Operand(const DisplacementOperand& operand, const Value* values) {
    const Value& value = values[operand.step];
    if (operand.channel == HDS_CHANNEL_ALL) {
        return value;
    }
    const float one = value[operand.channel];
    return {one, one, one, one};
}

Value Apply(const DisplacementStep& step, const Value* values) {
    std::array<shared::float4, 4> operands{};
    for (std::size_t i = 0; i < step.operands.size(); ++i) {
        const Value value = Operand(step.operands[i], values);
        operands[i] = {value[0], value[1], value[2], value[3]};
    }
    const shared::float4 result = shared::math_apply(step.code, operands.data());
    return {result.x, result.y, result.z, result.w};
}

Value LookUp(const DisplacementStep& step, const Value* values) {
    const Value st = Operand(step.operands[0], values);
    const Value fallback = Operand(step.operands[1], values);
    const Value scale = Operand(step.operands[2], values);
    const Value bias = Operand(step.operands[3], values);
    double s = st[0];
    double t = st[1];
    const DisplacementTile* tile = FindTile(step, &s, &t);
    Value result = fallback;
    for (std::size_t k = 0; tile != nullptr && k < 4; ++k) {
        if (tile->heights[k] != nullptr) {
            const double texel =
                LookUpHeight(*tile->heights[k], step.code & 3U, step.code >> 2U & 3U, s, t);
            result[k] = static_cast<float>(texel) * scale[k] + bias[k];
        }
    }
    return result;
}

ValueRange OperandRange(const DisplacementOperand& operand, const std::vector<ValueRange>& ranges) {
    const ValueRange& range = ranges[operand.step];
    if (operand.channel == HDS_CHANNEL_ALL) {
        return range;
    }
    const AmountRange& one = range[operand.channel];
    return {one, one, one, one};
}

/// Of all tiles, whatever the coordinates are.
ValueRange RangeOfLookUp(const DisplacementStep& step, const std::vector<ValueRange>& operands) {
    ValueRange result{};
    for (std::size_t k = 0; k < 4; ++k) {
        bool isFirst = true;
        const auto add = [&](const AmountRange& range) {
            result[k] = isFirst ? range : HullOf(result[k], range);
            isFirst = false;
        };
        const bool isUdim = (step.code & HDS_LOOKUP_UDIM) != 0;
        for (const DisplacementTile& tile : step.tiles) {
            if (tile.heights[k] == nullptr) {
                add(operands[1][k]);
                continue;
            }
            const AmountRange heights =
                RangeOfHeights(*tile.heights[k], step.code & 3U, step.code >> 2U & 3U);
            add(SumOf(ProductOf(heights, operands[2][k]), operands[3][k]));
        }
        if (isUdim || isFirst) {
            add(operands[1][k]);
        }
        result[k] = Widened(result[k]);
    }
    return result;
}

Value ValueAt(const DisplacementStep& step, const AmountPoint& point, const Value* values) {
    switch (step.kind) {
    case StepKind::Constant:
        return step.constant;
    case StepKind::Primvar: {
        const std::array<double, 4>& v = point.primvars[step.code];
        return {Rounded(v[0]), Rounded(v[1]), Rounded(v[2]), Rounded(v[3])};
    }
    case StepKind::Position:
        return {Rounded(point.position.x), Rounded(point.position.y), Rounded(point.position.z),
                0.0F};
    case StepKind::Affine: {
        const Value in = Operand(step.operands[0], values);
        const double x = in[0];
        const double y = in[1];
        const std::array<double, 6>& m = step.rows;
        return {Rounded(m[0] * x + m[1] * y + m[2]), Rounded(m[3] * x + m[4] * y + m[5]), 0.0F,
                0.0F};
    }
    case StepKind::Texture:
        return LookUp(step, values);
    default:
        return Apply(step, values);
    }
}

ValueRange RangeOver(const DisplacementStep& step, const AmountBox& box,
                     const std::vector<ValueRange>& ranges) {
    ValueRange result{};
    std::vector<ValueRange> operands;
    for (const DisplacementOperand& operand : step.operands) {
        operands.push_back(OperandRange(operand, ranges));
    }
    switch (step.kind) {
    case StepKind::Constant:
        for (std::size_t k = 0; k < 4; ++k) {
            result[k] = {step.constant[k], step.constant[k]};
        }
        return result;
    case StepKind::Primvar:
        for (std::size_t k = 0; k < 4; ++k) {
            result[k] = Widened({box.low.primvars[step.code][k], box.high.primvars[step.code][k]});
        }
        return result;
    case StepKind::Position:
        for (glm::length_t k = 0; k < 3; ++k) {
            result[static_cast<std::size_t>(k)] =
                Widened({box.low.position[k], box.high.position[k]});
        }
        return result;
    case StepKind::Affine:
        for (std::size_t k = 0; k < 2; ++k) {
            const double* row = step.rows.data() + 3 * k;
            const AmountRange turned = SumOf(ProductOf(operands[0][0], {row[0], row[0]}),
                                             ProductOf(operands[0][1], {row[1], row[1]}));
            result[k] = Widened(SumOf(turned, {row[2], row[2]}));
        }
        return result;
    case StepKind::Texture:
        return RangeOfLookUp(step, operands);
    default:
        return RangeOfMath(step.code, operands);
    }
}

} // namespace

NetworkValue ValueOf(const DisplacementNetwork& network, const AmountPoint& point) {
    std::array<Value, kMaxDisplacementSteps> values;
    for (std::size_t i = 0; i < network.steps.size(); ++i) {
        values[i] = ValueAt(network.steps[i], point, values.data());
    }
    return Operand(network.result, values.data());
}

ValueRange RangeOf(const DisplacementNetwork& network, const AmountBox& box) {
    std::vector<ValueRange> ranges;
    for (const DisplacementStep& step : network.steps) {
        ranges.push_back(RangeOver(step, box, ranges));
    }
    return OperandRange(network.result, ranges);
}

bool ReadsPosition(const DisplacementNetwork& network) {
    return std::any_of(
        network.steps.begin(), network.steps.end(),
        [](const DisplacementStep& step) { return step.kind == StepKind::Position; });
}

} // namespace hds
