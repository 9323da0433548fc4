// SPDX-License-Identifier: Apache-2.0
// How a hit chooses one of the slabs of a surface.
#include "hdStream/shading/closureParts.h"
#include "hdStream/shading/shaderMath.h"
#include "kernels/shared/sheen.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

namespace hds {

namespace {

/// A value that is `values[k]` where slab k is chosen. \param isChosen or one of those before it
ShaderValue ChooseValue(const std::vector<ShaderValue>& values,
                        const std::vector<ShaderValue>& isChosen, std::uint32_t numComponents) {
    ShaderValue result = values.back();
    for (std::size_t k = values.size() - 1; k > 0; --k) {
        if (!AreSame(values[k - 1], result)) {
            result =
                MakeMath(HDS_MATH_SELECT, {isChosen[k - 1], values[k - 1], result}, numComponents);
        }
    }
    return result;
}

ShaderValue MakeChance() {
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Chance;
    return {std::move(expression), HDS_CHANNEL_ALL, 1};
}

/// Gives each stack of covers a number above 1 by which the program chooses the lowest of them,
/// whose cover is the rest of the stack (HDS_INPUT_COVER).
class CoverNumbers {
public:
    /// \param stack not empty
    float NumberOf(const LayerStack& stack) {
        const auto found =
            std::find_if(_stacks.begin(), _stacks.end(),
                         [&](const LayerStack& known) { return AreSame(known, stack); });
        const auto index = static_cast<std::size_t>(found - _stacks.begin());
        if (found == _stacks.end()) {
            _stacks.push_back(stack);
        }
        return static_cast<float>(index) + kFirst;
    }

    /// The lowest of each, with the number of what lies on that. Their numbers follow each other.
    ClosureSlabs Slabs() {
        ClosureSlabs slabs;
        for (std::size_t k = 0; k < _stacks.size(); ++k) { // numbers add stacks
            ClosureSlab slab{*_stacks[k].front(), MakeScalar(0.0F), MakeScalar(1.0F)};
            const LayerStack rest(std::next(_stacks[k].begin()), _stacks[k].end());
            if (!rest.empty()) {
                slab.layered.values[HDS_INPUT_COVER] = MakeScalar(NumberOf(rest));
            }
            slabs.push_back(std::move(slab));
        }
        return slabs;
    }

    /// Above all numbers up to that of stack `index`, and below the others.
    static float EndOf(std::size_t index) { return static_cast<float>(index) + kFirst + 0.5F; }

private:
    static constexpr float kFirst = 1.5F; // numbers of hits are below 1
    std::vector<LayerStack> _stacks;
};

bool HasFlag(const ClosureSlab& slab, std::uint32_t flag) {
    return (slab.layered.flags & flag) != 0;
}

/// Where some sheens are fuzz or lie on all but the coat, and others are or do not, the roughnesses
/// of those that are no fuzz say so (HDS_SHEEN_MARK, HDS_SHEEN_OVER_MARK).
void MarkSheens(ClosureSlabs* slabs) {
    constexpr std::uint32_t kPlaces = HDS_MATERIAL_FUZZ | HDS_MATERIAL_SHEEN_OVER;
    if (std::none_of(slabs->begin(), slabs->end(),
                     [](const ClosureSlab& slab) { return HasFlag(slab, kPlaces); })) {
        return;
    }
    for (ClosureSlab& slab : *slabs) {
        if (Has(slab.layered, HDS_INPUT_SHEEN) && !HasFlag(slab, HDS_MATERIAL_FUZZ)) {
            const ShaderValue positive =
                MakeMath(HDS_MATH_MAX,
                         {ValueOf(slab.layered, HDS_INPUT_SHEEN_ROUGHNESS), MakeScalar(0.0F)}, 1);
            const ShaderValue inRange = MakeMath(HDS_MATH_MIN, {positive, MakeScalar(1.0F)}, 1);
            const float mark =
                HasFlag(slab, HDS_MATERIAL_SHEEN_OVER) ? HDS_SHEEN_OVER_MARK : HDS_SHEEN_MARK;
            slab.layered.values[HDS_INPUT_SHEEN_ROUGHNESS] = Subtract(MakeScalar(mark), inRange, 1);
        }
    }
}

} // namespace

LayeredMaterial ChooseSlab(ClosureSlabs slabs) {
    for (ClosureSlab& slab : slabs) {
        if (IsFoldable(slab)) {
            FoldFactor(&slab);
        }
    }
    CoverNumbers numbers;
    for (ClosureSlab& slab : slabs) {
        if (!slab.covers.empty()) {
            const ShaderValue number = MakeScalar(numbers.NumberOf(slab.covers));
            slab.layered.values[HDS_INPUT_COVER] =
                slab.isCovered ? Multiply(slab.isCovered, number, 1) : number;
        }
    }
    const std::size_t numChosen = slabs.size();
    const ClosureSlabs covers = numbers.Slabs();
    slabs.insert(slabs.end(), covers.begin(), covers.end());
    MarkSheens(&slabs);
    LayeredMaterial result = slabs.empty() ? BlackSlab().layered : slabs[0].layered;
    std::vector<ShaderValue> isChosen; // or one of those before it
    const ShaderValue chance = MakeChance();
    ShaderValue below = MakeScalar(0.0F);
    for (std::size_t k = 0; k < slabs.size(); ++k) {
        const ClosureSlab& slab = slabs[k];
        result.flags |= slab.layered.flags;
        result.lobes |= slab.layered.lobes;
        result.dispersion = std::max(result.dispersion, slab.layered.dispersion);
        below = k < numChosen ? Add(below, slab.share, 1)
                              : MakeScalar(CoverNumbers::EndOf(k - numChosen));
        const bool isLast = k + 1 == numChosen && !covers.empty();
        isChosen.push_back(
            MakeMath(HDS_MATH_GREATER, {isLast ? MakeScalar(1.0F) : below, chance}, 1));
    }
    for (std::uint32_t input = 0; input < HDS_NUM_LAYERED_INPUTS && slabs.size() > 1; ++input) {
        std::vector<ShaderValue> values;
        std::transform(slabs.begin(), slabs.end(), std::back_inserter(values),
                       [&](const ClosureSlab& slab) { return ValueOf(slab.layered, input); });
        if (std::any_of(slabs.begin(), slabs.end(),
                        [&](const auto& slab) { return bool(slab.layered.values[input]); })) {
            result.values[input] = ChooseValue(values, isChosen, NumComponentsOf(input));
        }
    }
    std::vector<ShaderValue> factors;
    std::transform(slabs.begin(), slabs.end(), std::back_inserter(factors),
                   [](const ClosureSlab& slab) { return slab.factor; });
    if (!factors.empty()) {
        result.values[HDS_INPUT_WEIGHT] = ChooseValue(factors, isChosen, 3);
    }
    return result;
}

} // namespace hds
