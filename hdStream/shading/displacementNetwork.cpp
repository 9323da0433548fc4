// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/displacementNetwork.h"

#include "kernels/shared/material.h"

#include <algorithm>
#include <map>

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;
using StepKind = DisplacementStep::Kind;

/// Writes steps, operands first.
class StepWriter {
public:
    explicit StepWriter(const std::vector<MaterialTexture>& textures) : _textures(textures) {}

    DisplacementOperand Write(const ShaderValue& value) {
        const ShaderExpression& expression = *value.expression;
        if (const auto known = _steps.find(&expression); known != _steps.end()) {
            ReadChannels(value, known->second);
            return {known->second, value.channel};
        }
        DisplacementStep step;
        if (expression.kind == Kind::Primvar) {
            step.kind = StepKind::Primvar;
            step.code = FindPrimvar(value);
        } else {
            step = StepOf(expression);
        }
        if (!_problem.empty()) {
            return {};
        }
        if (_network.steps.size() >= kMaxDisplacementSteps) {
            _problem = "more than " + std::to_string(kMaxDisplacementSteps) + " functions";
            return {};
        }
        const auto index = static_cast<std::uint32_t>(_network.steps.size());
        _network.steps.push_back(std::move(step));
        if (expression.kind != Kind::Primvar) { // whose readers may want different components
            _steps[&expression] = index;
        }
        ReadChannels(value, index);
        return {index, value.channel};
    }

    std::optional<DisplacementNetwork> Take(const DisplacementOperand& result,
                                            std::string* problem) {
        *problem = _problem;
        _network.result = result;
        return _problem.empty() ? std::optional<DisplacementNetwork>(std::move(_network))
                                : std::nullopt;
    }

private:
    DisplacementStep StepOf(const ShaderExpression& expression) {
        DisplacementStep step;
        switch (expression.kind) {
        case Kind::Constant:
            step.constant = expression.constant;
            return step;
        case Kind::Position:
            step.kind = StepKind::Position;
            if (expression.code != HDS_SPACE_OBJECT) {
                _problem = "the position in world space";
            }
            return step;
        case Kind::ToSpace:
            _problem = "the transform of an instance";
            return step;
        case Kind::Affine:
            step.kind = StepKind::Affine;
            step.rows = expression.rows;
            break;
        case Kind::Transform2d:
            step.kind = StepKind::Affine;
            if (!std::all_of(expression.operands.begin() + 1, expression.operands.end(),
                             IsConstant)) {
                _problem = "a UsdTransform2d that varies";
                return step;
            }
            step.rows = Transform2dRows(ConstantOf(expression.operands[1])[0],
                                        ConstantOf(expression.operands[2]),
                                        ConstantOf(expression.operands[3]));
            step.operands = {Write(expression.operands[0])};
            return step;
        case Kind::Texture:
            step.kind = StepKind::Texture;
            step.code = expression.lookup;
            for (const std::uint32_t tile : expression.tiles) {
                step.tiles.emplace_back();
                if (tile != HDS_NONE) {
                    step.tiles.back().texture = _textures[tile];
                }
            }
            break;
        case Kind::Math:
            step.kind = StepKind::Math;
            step.code = expression.code;
            break;
        default:
            _problem = "normals, tangents, directions or slopes";
            return step;
        }
        for (const ShaderValue& operand : expression.operands) {
            step.operands.push_back(Write(operand));
        }
        return step;
    }

    std::uint32_t FindPrimvar(const ShaderValue& value) {
        const std::uint32_t read = value.channel == HDS_CHANNEL_ALL
                                       ? std::clamp(value.numComponents, 1U, 4U)
                                       : value.channel + 1;
        DisplacementPrimvar primvar;
        primvar.numComponents = read;
        const ShaderValue* fallback = &value;
        while (fallback->expression->kind == Kind::Primvar) {
            primvar.names.push_back(fallback->expression->primvar);
            fallback = &fallback->expression->operands[0];
        }
        if (!IsConstant(*fallback)) {
            _problem = "a primvar whose fallback varies";
            return 0;
        }
        primvar.missing = ConstantOf(*fallback);
        std::vector<DisplacementPrimvar>& all = _network.primvars;
        const auto found = std::find(all.begin(), all.end(), primvar);
        if (found == all.end()) {
            all.push_back(primvar);
            return static_cast<std::uint32_t>(all.size() - 1);
        }
        return static_cast<std::uint32_t>(found - all.begin());
    }

    /// Of a look-up, what has to be read for a use of it.
    void ReadChannels(const ShaderValue& value, std::uint32_t index) {
        DisplacementStep& step = _network.steps[index];
        const std::uint32_t channels = value.channel == HDS_CHANNEL_ALL
                                           ? (1U << std::clamp(value.numComponents, 1U, 4U)) - 1U
                                           : 1U << value.channel;
        const std::vector<std::uint32_t>& tiles = value.expression->tiles;
        for (std::size_t i = 0; i < step.tiles.size(); ++i) {
            step.tiles[i].channels |= tiles[i] == HDS_NONE ? 0U : channels;
        }
    }

    const std::vector<MaterialTexture>& _textures;
    std::map<const ShaderExpression*, std::uint32_t> _steps;
    DisplacementNetwork _network;
    std::string _problem;
};

} // namespace

std::optional<DisplacementNetwork>
MakeDisplacementNetwork(const ShaderValue& value, const std::vector<MaterialTexture>& textures,
                        std::string* problem) {
    StepWriter writer(textures);
    const DisplacementOperand result = writer.Write(value);
    return writer.Take(result, problem);
}

} // namespace hds
