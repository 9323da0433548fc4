// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/programWriter.h"

#include "hdStream/shading/programDepth.h"
#include "kernels/shared/material.h"
#include "kernels/shared/programMath.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <map>
#include <set>
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

/// Whether coordinates have derivatives; where they have none images are looked up as points.
bool HasDerivatives(const ShaderValue& coordinates) {
    const ShaderExpression& expression = *coordinates.expression;
    return coordinates.channel == HDS_CHANNEL_ALL &&
           (expression.kind == Kind::Primvar ||
            ((expression.kind == Kind::Transform2d || expression.kind == Kind::Affine) &&
             HasDerivatives(expression.operands[0])));
}

/// Uses of each function and look-up, as operands or as inputs.
using UseCounts = std::map<const ShaderExpression*, std::uint32_t>;

bool IsShareable(const ShaderExpression& expression) {
    return expression.kind == Kind::Math || expression.kind == Kind::Texture ||
           expression.kind == Kind::ToSpace;
}

/// What is below an expression that is written at each use is used as often; twice says all.
void CountUses(const ShaderExpression& expression, UseCounts* counts) {
    if (++(*counts)[&expression] > (IsShareable(expression) ? 1U : 2U)) {
        return;
    }
    for (const ShaderValue& operand : expression.operands) {
        CountUses(*operand.expression, counts);
    }
}

/// What has been searched: nodes are shared, and there may be exponentially many ways to one.
using Searched = std::set<const ShaderExpression*>;

/// Whether a node of one of the kinds is the expression or below it.
bool HasKind(const ShaderExpression& expression, std::initializer_list<Kind> kinds,
             Searched* searched) {
    return searched->insert(&expression).second &&
           (std::count(kinds.begin(), kinds.end(), expression.kind) > 0 ||
            std::any_of(
                expression.operands.begin(), expression.operands.end(),
                [&](const ShaderValue& one) { return HasKind(*one.expression, kinds, searched); }));
}

/// Whether its value depends on the shading normal.
bool ReadsNormal(const ShaderExpression& expression) {
    Searched searched;
    return HasKind(expression, {Kind::Normal, Kind::Tangent}, &searched);
}

/// A register that holds the value of an expression.
struct HeldValue {
    std::uint32_t index = 0;
    std::uint32_t numUses = 0; ///< that are still to come
};
using Registers = std::map<const ShaderExpression*, HeldValue>;

class Writer {
public:
    /// \param isDeep some operands have to wait (FindEarly)
    Writer(const std::vector<std::uint32_t>& textures, const SlotCallback& findSlot,
           UseCounts counts, bool isDeep)
        : _textures(textures), _findSlot(findSlot), _counts(std::move(counts)),
          _numForEarly(isDeep ? 2 : 0) {}

    /// Evaluates an expression once and stores it to all inputs that it feeds.
    void WriteGroup(const std::vector<const ProgramInput*>& group) {
        const ShaderValue whole{group[0]->value.expression, HDS_CHANNEL_ALL, 4};
        const bool hasNormal = std::any_of(group.begin(), group.end(), [](const auto* one) {
            return one->input == HDS_INPUT_NORMAL || one->input == HDS_INPUT_COAT_NORMAL;
        });
        Push(whole, hasNormal);
        for (const ProgramInput* one : group) {
            Emit(HDS_OP(HDS_OP_STORE, HDS_STORE(one->input, one->value.channel)));
        }
        Emit(HDS_OP(HDS_OP_POP, 0U));
        --_depth;
    }

    /// Bumps the hit; for what comes later.
    void WriteRelief(const ProgramRelief& relief, UseCounts counts) {
        const std::size_t begin = _words.size();
        Emit(0U);
        // What registers hold belongs to the place that was hit; they are needed afterwards.
        Registers kept;
        kept.swap(_registers);
        _counts.swap(counts);
        const std::uint32_t keptMask = _takenMask;
        constexpr std::uint32_t kWays[] = {HDS_SHIFT_T | HDS_SHIFT_MINUS, HDS_SHIFT_T,
                                           HDS_SHIFT_S | HDS_SHIFT_MINUS, HDS_SHIFT_S};
        for (const std::uint32_t way : kWays) {
            Emit(HDS_OP(HDS_OP_ASIDE, way));
            Emit(relief.movedSlot);
            Emit(relief.normalSlot);
            _lookupCoordinates.clear();
            Push(relief.value);
            Emit(HDS_OP(HDS_OP_SHIFT, HDS_SHIFT_BACK));
            _registers.clear();
            _takenMask = keptMask;
        }
        _lookupCoordinates.clear();
        for (const auto& one : kept) {
            if (ReadsNormal(*one.first)) {
                _stale.insert(one.first);
            }
        }
        Emit(HDS_OP(HDS_OP_AUTOBUMP, relief.space));
        Emit(relief.movedSlot);
        Emit(relief.normalSlot);
        Emit(relief.coordinateSlot);
        _depth -= 4;
        _counts.swap(counts);
        kept.swap(_registers);
        if (!_isTooLarge) {
            _words[begin] =
                HDS_OP(HDS_OP_RESOLVED, static_cast<std::uint32_t>(_words.size() - begin - 1));
        }
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

    std::uint32_t NumFreeRegisters() const {
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < HDS_PROGRAM_REGISTERS; ++i) {
            count += (_takenMask >> i & 1U) == 0 ? 1U : 0U;
        }
        return count;
    }

    /// One that has held nothing yet, if there is one: words of coordinates that name it are then
    /// still those of the same values. \pre NumFreeRegisters() > 0
    std::uint32_t TakeRegister() {
        const auto firstWithout = [](std::uint32_t mask) {
            std::uint32_t index = 0;
            while ((mask >> index & 1U) != 0) {
                ++index;
            }
            return index;
        };
        std::uint32_t index = firstWithout(_usedMask);
        if (index >= HDS_PROGRAM_REGISTERS) {
            index = firstWithout(_takenMask);
            _lookupCoordinates.clear();
        }
        _usedMask |= 1U << index;
        _takenMask |= 1U << index;
        return index;
    }

    void FreeRegister(std::uint32_t index) { _takenMask &= ~(1U << index); }

    /// A use of what a register holds; after the last one it is free. What is evaluated again, for
    /// want of registers, is used more often than was counted, and then evaluated anew.
    void CountUse(Registers::iterator held) {
        if (--held->second.numUses == 0) {
            _stale.erase(held->first);
            FreeRegister(held->second.index);
            _registers.erase(held);
        }
    }

    void PushConstant(const std::array<float, 4>& value) {
        Emit(HDS_OP(HDS_OP_CONSTANT, 0U));
        std::for_each(value.begin(), value.end(), [&](float x) { EmitFloat(x); });
        Grow(1);
    }

    /// Adds one value to the stack. \param hasTangents the normal is in the frame of its first
    /// look-up
    void Push(const ShaderValue& value, bool hasTangents = false) {
        if (_isTooLarge) {
            return;
        }
        const ShaderExpression& expression = *value.expression;
        const auto known = _isShifted ? _registers.end() : _registers.find(&expression);
        const bool isKnown = known != _registers.end() && _stale.count(&expression) == 0;
        if (isKnown && !hasTangents) {
            Emit(HDS_OP(HDS_OP_LOAD, known->second.index));
            Grow(1);
            CountUse(known);
        } else {
            PushExpression(value, hasTangents);
            if (!_isShifted) {
                Keep(expression);
            }
        }
        if (value.channel != HDS_CHANNEL_ALL) {
            Emit(HDS_OP(HDS_OP_CHANNEL, HDS_STORE(0U, value.channel)));
        }
    }

    /// Keeps the top of the stack in a register, if it is used again.
    void Keep(const ShaderExpression& expression) {
        const auto known = _registers.find(&expression);
        if (known != _registers.end()) {
            if (_stale.erase(&expression) != 0) { // kept before the normal changed
                Emit(HDS_OP(HDS_OP_SAVE, known->second.index));
                _lookupCoordinates.clear();
            }
            CountUse(known);
            return;
        }
        const auto uses = _counts.find(&expression);
        if (IsShareable(expression) && uses != _counts.end() && uses->second > 1 &&
            NumFreeRegisters() > _numForEarly) {
            const std::uint32_t index = TakeRegister();
            _registers[&expression] = {index, uses->second - 1};
            Emit(HDS_OP(HDS_OP_SAVE, index));
        }
    }

    /// As Push, without the channel.
    void PushExpression(const ShaderValue& value, bool hasTangents) {
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
        case Kind::Affine:
            PushCoordinates({value.expression, HDS_CHANNEL_ALL, 2});
            Emit(HDS_OP(HDS_OP_POP, 0U));
            --_depth;
            break;
        case Kind::Texture:
            PushLookup(expression, hasTangents);
            break;
        case Kind::Math:
            PushMath(expression, hasTangents);
            break;
        case Kind::Position:
            Emit(HDS_OP(HDS_OP_POSITION, expression.code));
            std::for_each(_zero.begin(), _zero.end(), [&](float x) { EmitFloat(x); });
            Grow(1);
            break;
        case Kind::Normal:
            Emit(HDS_OP(HDS_OP_NORMAL, expression.code));
            Grow(1);
            break;
        case Kind::Tangent:
            PushCoordinates(expression.operands[0]);
            Emit(HDS_OP(HDS_OP_TANGENT, expression.code));
            --_depth;
            break;
        case Kind::View:
            Emit(HDS_OP(HDS_OP_VIEW, 0U));
            Grow(1);
            break;
        case Kind::ToSpace:
            Push(expression.operands[0]);
            Emit(HDS_OP(HDS_OP_TO_SPACE, expression.code));
            for (int i = 0; i < 6; ++i) {
                EmitFloat(0.0F);
            }
            break;
        case Kind::Chance:
            Emit(HDS_OP(HDS_OP_CHANCE, 0U));
            Grow(1);
            break;
        case Kind::Inside:
            Emit(HDS_OP(HDS_OP_INSIDE, 0U));
            Grow(1);
            break;
        case Kind::Shifted:
            PushShifted(expression);
            break;
        }
    }

    /// What registers hold belongs to the place that was hit.
    void PushShifted(const ShaderExpression& expression) {
        PushCoordinates(expression.operands[1]);
        Emit(HDS_OP(HDS_OP_SHIFT, expression.code));
        _depth -= 2;
        _isShifted = true;
        _lookupCoordinates.clear();
        Push(expression.operands[0]);
        _isShifted = false;
        _lookupCoordinates.clear();
        Emit(HDS_OP(HDS_OP_SHIFT, HDS_SHIFT_BACK));
    }

    void PushMath(const ShaderExpression& expression, bool hasTangents) {
        const auto& operands = expression.operands;
        const auto withFrame = std::find_if(operands.begin(), operands.end(), [&](const auto& one) {
            return hasTangents && HasFrame(one);
        });
        const auto isInFrame = [&](std::size_t i) {
            return operands.begin() + static_cast<std::ptrdiff_t>(i) == withFrame;
        };
        const std::size_t early = FindEarly(expression);
        std::uint32_t waiting = 0;
        if (early < operands.size()) {
            Push(operands[early], isInFrame(early));
            _isTooLarge = _isTooLarge || NumFreeRegisters() == 0;
            if (_isTooLarge) {
                return;
            }
            waiting = TakeRegister();
            Emit(HDS_OP(HDS_OP_SAVE, waiting));
            Emit(HDS_OP(HDS_OP_POP, 0U));
            --_depth;
        }
        for (std::size_t i = 0; i < operands.size(); ++i) {
            if (i == early) {
                Emit(HDS_OP(HDS_OP_LOAD, waiting));
                FreeRegister(waiting);
                Grow(1);
            } else {
                Push(operands[i], isInFrame(i));
            }
        }
        const auto count = static_cast<std::uint32_t>(operands.size());
        Emit(HDS_OP(HDS_OP_MATH, HDS_MATH(expression.code, count)));
        _depth -= count - 1;
    }

    /// Where operands in order do not fit the stack, the one that takes most places is evaluated
    /// before the others, where it begins lower, and waits in a register. \return its number, or
    /// one past the last: in order.
    std::size_t FindEarly(const ShaderExpression& expression) {
        const auto& operands = expression.operands;
        if (_depth + _depths.Of(expression) <= HDS_PROGRAM_STACK || NumFreeRegisters() == 0) {
            return operands.size();
        }
        std::size_t early = 0;
        std::uint32_t most = 0;
        for (std::size_t i = 0; i < operands.size(); ++i) {
            const std::uint32_t depth =
                static_cast<std::uint32_t>(i) + _depths.Of(*operands[i].expression);
            early = depth > most ? i : early;
            most = std::max(most, depth);
        }
        return early > 0 ? early : operands.size();
    }

    void PushLookup(const ShaderExpression& expression, bool hasTangents) {
        const auto parameters = expression.operands.begin() + 1;
        const bool isConstant = std::all_of(parameters, expression.operands.end(), IsConstant);
        if (!isConstant) {
            std::for_each(parameters, expression.operands.end(),
                          [&](const ShaderValue& value) { Push(value); });
        }
        const bool isAgain = PushLookupCoordinates(expression.operands[0]);
        Emit(HDS_OP(
            HDS_OP_TEXTURE,
            expression.lookup | (isConstant ? 0U : HDS_LOOKUP_POPS) |
                (hasTangents && HasDerivatives(expression.operands[0]) ? HDS_LOOKUP_TANGENTS : 0U) |
                (isAgain ? HDS_LOOKUP_AGAIN : 0U)));
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
        _depth -= (isAgain ? 0 : 2) + (isConstant ? 0 : 3);
        ++_depth;
    }

    /// As PushCoordinates for a look-up; adds nothing where they are those of the look-up before:
    /// the same words then give the same values. \return whether they are.
    bool PushLookupCoordinates(const ShaderValue& value) {
        const std::size_t begin = _words.size();
        PushCoordinates(value);
        const std::vector<std::uint32_t> words(_words.begin() + static_cast<std::ptrdiff_t>(begin),
                                               _words.end());
        if (_isTooLarge || words != _lookupCoordinates) {
            _lookupCoordinates = words;
            return false;
        }
        _words.resize(begin);
        _depth -= 2;
        return true;
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
        } else if (expression.kind == Kind::Transform2d && value.channel == HDS_CHANNEL_ALL) {
            PushTransform(expression);
        } else if (expression.kind == Kind::Affine && value.channel == HDS_CHANNEL_ALL) {
            PushCoordinates(expression.operands[0]);
            EmitAffine(expression.rows);
        } else {
            Push(value);
            PushConstant({});
        }
    }

    void PushTransform(const ShaderExpression& expression) {
        PushCoordinates(expression.operands[0]);
        const auto parameters = expression.operands.begin() + 1;
        if (std::all_of(parameters, expression.operands.end(), IsConstant)) {
            EmitAffine(Transform2dRows(ConstantOf(expression.operands[1])[0],
                                       ConstantOf(expression.operands[2]),
                                       ConstantOf(expression.operands[3])));
            return;
        }
        std::for_each(parameters, expression.operands.end(),
                      [&](const ShaderValue& one) { Push(one); });
        Emit(HDS_OP(HDS_OP_TRANSFORM, 0U));
        _depth -= 3;
    }

    void EmitAffine(const std::array<double, 6>& rows) {
        Emit(HDS_OP(HDS_OP_AFFINE, 0U));
        for (const double entry : rows) {
            EmitFloat(static_cast<float>(entry));
        }
    }

    static constexpr std::array<float, 3> _zero{};
    const std::vector<std::uint32_t>& _textures;
    const SlotCallback& _findSlot;
    UseCounts _counts; ///< empty: nothing is kept in registers
    Registers _registers;
    Searched _stale; ///< what registers hold is of the normal before relief
    std::vector<std::uint32_t> _words;
    std::vector<std::uint32_t> _lookupCoordinates; ///< words of those of the last look-up
    std::uint32_t _depth = 0;
    ProgramDepth _depths;
    std::uint32_t _numForEarly;   ///< registers that are left to operands that wait
    std::uint32_t _takenMask = 0; ///< registers that hold something
    std::uint32_t _usedMask = 0;  ///< registers that have held something
    bool _isTooLarge = false;
    bool _isShifted = false;
};

bool HasFrame(const ShaderValue& value, Searched* searched) {
    const ShaderExpression& expression = *value.expression;
    return searched->insert(&expression).second &&
           ((expression.kind == Kind::Texture && HasDerivatives(expression.operands[0])) ||
            (expression.kind == Kind::Math &&
             std::any_of(expression.operands.begin(), expression.operands.end(),
                         [&](const ShaderValue& one) { return HasFrame(one, searched); })));
}

} // namespace

bool HasSlope(const ShaderValue& value) {
    Searched searched;
    return HasKind(*value.expression, {Kind::Shifted}, &searched);
}

bool HasFrame(const ShaderValue& value) {
    Searched searched;
    return HasFrame(value, &searched);
}

std::vector<std::uint32_t> WriteProgram(const std::vector<ProgramInput>& inputs,
                                        const std::vector<std::uint32_t>& textures,
                                        const SlotCallback& findSlot, std::uint32_t tangentSlot,
                                        const ProgramRelief& relief) {
    // In the order of their first input, so that equal materials give equal programs. What masks
    // need is evaluated before the relief, and has a group apart where the normal counts.
    std::vector<std::vector<const ProgramInput*>> groups;
    for (const ProgramInput& input : inputs) {
        const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& candidate) {
            return candidate[0]->value.expression == input.value.expression &&
                   (!relief.value || IsInMask(candidate[0]->input) == IsInMask(input.input) ||
                    !ReadsNormal(*input.value.expression));
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
    UseCounts counts;
    Searched searched;
    if (std::any_of(inputs.begin(), inputs.end(), [&](const ProgramInput& input) {
            return HasKind(*input.value.expression, {Kind::Math}, &searched);
        })) {
        for (const auto& group : groups) {
            CountUses(*group[0]->value.expression, &counts);
        }
    }
    ProgramDepth depths;
    const bool isDeep = std::any_of(groups.begin(), groups.end(), [&](const auto& group) {
        return depths.Of(*group[0]->value.expression) > HDS_PROGRAM_STACK;
    });
    Writer writer(textures, findSlot, std::move(counts), isDeep);
    if (tangentSlot != HDS_NONE) {
        writer.Emit(HDS_OP(HDS_OP_TANGENTS, tangentSlot));
    }
    std::for_each(groups.begin(), others, [&](const auto& group) { writer.WriteGroup(group); });
    if (others != groups.end() || relief.value) {
        writer.Emit(HDS_OP(HDS_OP_MASK_END, 0U));
    }
    if (relief.value) {
        UseCounts ofRelief;
        CountUses(*relief.value.expression, &ofRelief);
        writer.WriteRelief(relief, std::move(ofRelief));
    }
    std::for_each(others, groups.end(), [&](const auto& group) { writer.WriteGroup(group); });
    writer.Emit(HDS_OP(HDS_OP_END, 0U));
    return writer.Take();
}

} // namespace hds
