// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/programWriter.h"

#include "kernels/shared/material.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

/// Longest program. Networks are much shorter; chains that share nodes may grow exponentially.
constexpr std::size_t kMaxWords = 1U << 14U;

/// Inputs that a mask needs.
bool IsInMask(std::uint32_t input) {
    return input == HDS_INPUT_OPACITY || input == HDS_INPUT_OPACITY_THRESHOLD;
}

class Writer {
public:
    Writer(const std::vector<std::uint32_t>& textures, const SlotCallback& findSlot)
        : _textures(textures), _findSlot(findSlot) {}

    /// Evaluates an expression once and stores it to all inputs that it feeds.
    void WriteGroup(const std::vector<const ProgramInput*>& group) {
        const ShaderValue whole{group[0]->value.expression, HDS_CHANNEL_ALL, 4};
        const bool hasNormal = std::any_of(group.begin(), group.end(), [](const auto* one) {
            return one->input == HDS_INPUT_NORMAL;
        });
        Push(whole, hasNormal);
        for (const ProgramInput* one : group) {
            Emit(HDS_OP(HDS_OP_STORE, HDS_STORE(one->input, one->value.channel)));
        }
        Emit(HDS_OP(HDS_OP_POP, 0U));
        --_depth;
    }

    void Emit(std::uint32_t word) {
        if (_words.size() < kMaxWords) {
            _words.push_back(word);
        } else {
            _isTooLarge = true;
        }
    }

    std::vector<std::uint32_t> Take() {
        return _isTooLarge ? std::vector<std::uint32_t>() : std::move(_words);
    }

private:
    void EmitFloat(float value) {
        std::uint32_t word = 0;
        std::memcpy(&word, &value, sizeof(word));
        Emit(word);
    }

    void Grow(std::uint32_t count) {
        _depth += count;
        _isTooLarge = _isTooLarge || _depth > HDS_PROGRAM_STACK;
    }

    void PushConstant(const std::array<float, 4>& value) {
        Emit(HDS_OP(HDS_OP_CONSTANT, 0U));
        std::for_each(value.begin(), value.end(), [&](float x) { EmitFloat(x); });
        Grow(1);
    }

    /// Adds one value to the stack. \param hasTangents of a look-up: the normal is in its frame
    void Push(const ShaderValue& value, bool hasTangents = false) {
        if (_isTooLarge) {
            return;
        }
        const ShaderExpression& expression = *value.expression;
        switch (expression.kind) {
        case Kind::Constant:
            PushConstant(expression.constant);
            break;
        case Kind::Primvar:
            Emit(HDS_OP(HDS_OP_PRIMVAR, _findSlot(expression.primvar, 1)));
            Grow(1);
            break;
        case Kind::Transform2d:
            PushCoordinates(value);
            Emit(HDS_OP(HDS_OP_POP, 0U));
            --_depth;
            break;
        case Kind::Texture:
            PushLookup(expression, hasTangents);
            break;
        }
        if (value.channel != HDS_CHANNEL_ALL) {
            Emit(HDS_OP(HDS_OP_CHANNEL, HDS_STORE(0U, value.channel)));
        }
    }

    void PushLookup(const ShaderExpression& expression, bool hasTangents) {
        const auto parameters = expression.operands.begin() + 1;
        const bool isConstant = std::all_of(parameters, expression.operands.end(), IsConstant);
        if (!isConstant) {
            std::for_each(parameters, expression.operands.end(),
                          [&](const ShaderValue& value) { Push(value); });
        }
        PushCoordinates(expression.operands[0]);
        Emit(HDS_OP(HDS_OP_TEXTURE, expression.lookup | (isConstant ? 0U : HDS_LOOKUP_POPS) |
                                        (hasTangents ? HDS_LOOKUP_TANGENTS : 0U)));
        Emit(static_cast<std::uint32_t>(expression.tiles.size()));
        for (const std::uint32_t tile : expression.tiles) {
            Emit(tile == HDS_NONE ? HDS_NONE : _textures[tile]);
        }
        if (isConstant) {
            std::for_each(parameters, expression.operands.end(), [&](const ShaderValue& value) {
                const std::array<float, 4>& constant = ConstantOf(value);
                std::for_each(constant.begin(), constant.end(), [&](float x) { EmitFloat(x); });
            });
        }
        _depth -= isConstant ? 1 : 4;
    }

    /// Adds coordinates and their derivatives. Those of look-ups have none: they are looked up as
    /// points.
    void PushCoordinates(const ShaderValue& value) {
        if (_isTooLarge) {
            return;
        }
        const ShaderExpression& expression = *value.expression;
        if (expression.kind == Kind::Primvar && value.channel == HDS_CHANNEL_ALL) {
            Emit(HDS_OP(HDS_OP_COORDINATES, _findSlot(expression.primvar, 2)));
            Grow(2);
        } else if (expression.kind == Kind::Transform2d) {
            PushTransform(expression);
        } else {
            Push(value);
            PushConstant({});
        }
    }

    void PushTransform(const ShaderExpression& expression) {
        PushCoordinates(expression.operands[0]);
        const auto parameters = expression.operands.begin() + 1;
        if (std::all_of(parameters, expression.operands.end(), IsConstant)) {
            Emit(HDS_OP(HDS_OP_AFFINE, 0U));
            for (const double entry : Transform2dRows(ConstantOf(expression.operands[1])[0],
                                                      ConstantOf(expression.operands[2]),
                                                      ConstantOf(expression.operands[3]))) {
                EmitFloat(static_cast<float>(entry));
            }
            return;
        }
        std::for_each(parameters, expression.operands.end(),
                      [&](const ShaderValue& one) { Push(one); });
        Emit(HDS_OP(HDS_OP_TRANSFORM, 0U));
        _depth -= 3;
    }

    const std::vector<std::uint32_t>& _textures;
    const SlotCallback& _findSlot;
    std::vector<std::uint32_t> _words;
    std::uint32_t _depth = 0;
    bool _isTooLarge = false;
};

} // namespace

std::vector<std::uint32_t> WriteProgram(const std::vector<ProgramInput>& inputs,
                                        const std::vector<std::uint32_t>& textures,
                                        const SlotCallback& findSlot) {
    // In the order of their first input, so that equal materials give equal programs.
    std::vector<std::vector<const ProgramInput*>> groups;
    for (const ProgramInput& input : inputs) {
        const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& candidate) {
            return candidate[0]->value.expression == input.value.expression;
        });
        if (group == groups.end()) {
            groups.push_back({&input});
        } else {
            group->push_back(&input);
        }
    }
    const auto others = std::stable_partition(groups.begin(), groups.end(), [](const auto& group) {
        return std::any_of(group.begin(), group.end(),
                           [](const auto* one) { return IsInMask(one->input); });
    });
    Writer writer(textures, findSlot);
    for (auto group = groups.begin(); group != groups.end(); ++group) {
        if (group == others) {
            writer.Emit(HDS_OP(HDS_OP_MASK_END, 0U));
        }
        writer.WriteGroup(*group);
    }
    writer.Emit(HDS_OP(HDS_OP_END, 0U));
    return writer.Take();
}

std::uint32_t CountLookups(const std::vector<std::uint32_t>& program) {
    std::uint32_t count = 0;
    std::size_t at = 0;
    while (at < program.size()) {
        const std::uint32_t operation = program[at] & 0xffU;
        const std::uint32_t argument = program[at] >> 8U;
        ++at;
        if (operation == HDS_OP_CONSTANT) {
            at += 4;
        } else if (operation == HDS_OP_AFFINE) {
            at += 6;
        } else if (operation == HDS_OP_TEXTURE) {
            ++count;
            at += 1 + program[at] + ((argument & HDS_LOOKUP_POPS) != 0 ? 0 : 12);
        }
    }
    return count;
}

} // namespace hds
