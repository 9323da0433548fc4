// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/networkAmount.h"

#include "hdStream/scene/textureAmount.h"
#include "hdStream/scene/valueRange.h"
#include "kernels/shared/programMath.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hds {

namespace {

using StepKind = DisplacementStep::Kind;
using Value = std::array<float, 4>;

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

class NetworkAmount : public DisplacementAmount {
public:
    explicit NetworkAmount(DisplacementNetwork network) : _network(std::move(network)) {
        for (const DisplacementPrimvar& primvar : _network.primvars) {
            AmountPrimvar& added = _primvars.emplace_back();
            added.names = primvar.names;
            added.numComponents = primvar.numComponents;
            std::copy(primvar.missing.begin(), primvar.missing.end(), added.missing.begin());
        }
        _readsPosition = std::any_of(
            _network.steps.begin(), _network.steps.end(),
            [](const DisplacementStep& step) { return step.kind == StepKind::Position; });
    }

    const std::vector<AmountPrimvar>& Primvars() const override { return _primvars; }
    bool ReadsPosition() const override { return _readsPosition; }

    DisplacementSpace Space() const override {
        if (!_network.isVector) {
            return DisplacementSpace::Normal;
        }
        return _network.coordinates == HDS_NONE ? DisplacementSpace::Object
                                                : DisplacementSpace::Tangent;
    }
    std::size_t Coordinates() const override { return _network.coordinates; }

    double At(const AmountPoint& point) const override {
        return _network.isVector ? 0.0 : Finite(ResultAt(point)[0]);
    }
    glm::dvec3 VectorAt(const AmountPoint& point) const override {
        if (!_network.isVector) {
            return glm::dvec3(0.0);
        }
        const Value result = ResultAt(point);
        return {Finite(result[0]), Finite(result[1]), Finite(result[2])};
    }

    AmountRange Over(const AmountBox& box) const override {
        std::vector<ValueRange> ranges;
        for (const DisplacementStep& step : _network.steps) {
            ranges.push_back(RangeOver(step, box, ranges));
        }
        const ValueRange results = OperandRange(_network.result, ranges);
        if (_network.isVector) {
            glm::dvec3 most(0.0);
            for (glm::length_t k = 0; k < 3; ++k) {
                const AmountRange& one = results[static_cast<std::size_t>(k)];
                most[k] = std::max(std::fabs(one.low), std::fabs(one.high));
            }
            const double length = glm::length(most);
            return {-length, length};
        }
        const AmountRange range = results[0];
        // What is not finite is 0.
        return std::isfinite(range.low) && std::isfinite(range.high) ? range
                                                                     : HullOf(range, {0.0, 0.0});
    }

private:
    static double Finite(float value) {
        return std::isfinite(value) ? static_cast<double>(value) : 0.0;
    }

    Value ResultAt(const AmountPoint& point) const {
        std::array<Value, kMaxDisplacementSteps> values;
        for (std::size_t i = 0; i < _network.steps.size(); ++i) {
            values[i] = ValueAt(_network.steps[i], point, values.data());
        }
        return Operand(_network.result, values.data());
    }

    static Value Operand(const DisplacementOperand& operand, const Value* values) {
        const Value& value = values[operand.step];
        if (operand.channel == HDS_CHANNEL_ALL) {
            return value;
        }
        const float one = value[operand.channel];
        return {one, one, one, one};
    }

    static Value ValueAt(const DisplacementStep& step, const AmountPoint& point,
                         const Value* values) {
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

    static Value Apply(const DisplacementStep& step, const Value* values) {
        std::array<shared::float4, 4> operands{};
        for (std::size_t i = 0; i < step.operands.size(); ++i) {
            const Value value = Operand(step.operands[i], values);
            operands[i] = {value[0], value[1], value[2], value[3]};
        }
        const shared::float4 result = shared::math_apply(step.code, operands.data());
        return {result.x, result.y, result.z, result.w};
    }

    static Value LookUp(const DisplacementStep& step, const Value* values) {
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

    static ValueRange OperandRange(const DisplacementOperand& operand,
                                   const std::vector<ValueRange>& ranges) {
        const ValueRange& range = ranges[operand.step];
        if (operand.channel == HDS_CHANNEL_ALL) {
            return range;
        }
        const AmountRange& one = range[operand.channel];
        return {one, one, one, one};
    }

    static ValueRange RangeOver(const DisplacementStep& step, const AmountBox& box,
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
                result[k] =
                    Widened({box.low.primvars[step.code][k], box.high.primvars[step.code][k]});
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

    /// Of all tiles, whatever the coordinates are.
    static ValueRange RangeOfLookUp(const DisplacementStep& step,
                                    const std::vector<ValueRange>& operands) {
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

    DisplacementNetwork _network;
    std::vector<AmountPrimvar> _primvars;
    bool _readsPosition = false;
};

} // namespace

std::shared_ptr<const DisplacementAmount> MakeNetworkAmount(DisplacementNetwork network) {
    return std::make_shared<NetworkAmount>(std::move(network));
}

} // namespace hds
