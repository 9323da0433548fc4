// SPDX-License-Identifier: Apache-2.0
// MaterialX's nodes that correct and composite colours, as expressions: node graphs of MaterialX
// 1.39's stdlib_ng.mtlx, and Porter and Duff's operators. The table of what there is:
// docs/materials.md.
#include "hdStream/shading/patternNode.h"

namespace hds {

namespace {

class ColorNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    ShaderValue ColorCorrect() {
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue in = In("in", 1.0F);
        ShaderValue color = in;
        const ShaderValue hue = In("hue", 0.0F);
        if (!IsAll(hue, 0.0F)) {
            const ShaderValue turn = CombineChannels(hue, zero, zero, zero, _n);
            color = Math(HDS_MATH_HSV_TO_RGB, {Add(Math(HDS_MATH_RGB_TO_HSV, {color}), turn)});
        }
        const ShaderValue grey =
            DotProduct(color, MakeConstant({0.2722287F, 0.6740818F, 0.0536895F, 0.0F}, 3), 3);
        color = Mix(grey, color, In("saturation", 1.0F));
        color = RangeTo(color, zero, one, In("gamma", 1.0F), zero, one, zero);
        const ShaderValue lift = In("lift", 0.0F);
        color = Add(Multiply(color, MakeMath(HDS_MATH_SUBTRACT, {one, lift}, 1)), lift);
        color = Multiply(color, In("gain", 1.0F));
        const ShaderValue pivot = In("contrastpivot", 0.5F);
        color = Add(Multiply(Subtract(color, pivot), In("contrast", 1.0F)), pivot);
        const ShaderValue exposure = In("exposure", 0.0F);
        color = Multiply(color, MakeMath(HDS_MATH_POWER, {MakeScalar(2.0F), exposure}, 1));
        return _n == 4 ? CombineChannels(ChannelOf(color, 0), ChannelOf(color, 1),
                                         ChannelOf(color, 2), ChannelOf(in, 3), 4)
                       : color;
    }
    ShaderValue Overlay() {
        const ShaderValue fg = In("fg", 0.0F);
        const ShaderValue bg = In("bg", 0.0F);
        const ShaderValue two = MakeScalar(2.0F);
        const ShaderValue high = OneMinus(Multiply(Multiply(OneMinus(bg), OneMinus(fg)), two));
        const ShaderValue isHigh = Math(HDS_MATH_GREATER_OR_EQUAL, {bg, MakeScalar(0.5F)});
        const ShaderValue value =
            Math(HDS_MATH_SELECT, {isHigh, high, Multiply(Multiply(fg, bg), two)});
        return Mix(bg, value, In("mix", 1.0F));
    }
    template <bool kIsBurn>
    ShaderValue BurnOrDodge() {
        const ShaderValue fg = In("fg", 0.0F);
        const ShaderValue bg = In("bg", 0.0F);
        const ShaderValue divisor = kIsBurn ? fg : OneMinus(fg);
        const ShaderValue value =
            kIsBurn ? OneMinus(Divide(OneMinus(bg), divisor)) : Divide(bg, divisor);
        const ShaderValue isSmall =
            Math(HDS_MATH_GREATER, {MakeScalar(1e-8F), Math(HDS_MATH_ABS, {divisor})});
        return Math(HDS_MATH_SELECT, {isSmall, MakeScalar(0.0F), Mix(bg, value, In("mix", 1.0F))});
    }
    /// \tparam kCode of what is done with the alpha
    template <std::uint32_t kCode>
    ShaderValue Premultiply() {
        const ShaderValue in = Vector("in", {0.0F, 0.0F, 0.0F, 1.0F}, 4);
        const ShaderValue alpha = ChannelOf(in, 3);
        const ShaderValue color = Math(kCode, {in, alpha});
        return CombineChannels(ChannelOf(color, 0), ChannelOf(color, 1), ChannelOf(color, 2), alpha,
                               4);
    }

    /// What Porter and Duff's operators have: two colours with alpha.
    struct Layers {
        ShaderValue fg;
        ShaderValue bg;
        ShaderValue front; ///< alphas
        ShaderValue back;
    };
    Layers ReadLayers() {
        const ShaderValue fg = Vector("fg", {}, 4);
        const ShaderValue bg = Vector("bg", {}, 4);
        return {fg, bg, ChannelOf(fg, 3), ChannelOf(bg, 3)};
    }
    ShaderValue Merged(const Layers& layers, const ShaderValue& value) {
        return Mix(layers.bg, value, In("mix", 1.0F));
    }
    ShaderValue Rest(const Layers& layers) const {
        return Multiply(layers.bg, OneMinus(layers.front));
    }
    ShaderValue Over() {
        const Layers layers = ReadLayers();
        return Merged(layers, Add(layers.fg, Rest(layers)));
    }
    ShaderValue InNode() {
        const Layers layers = ReadLayers();
        return Merged(layers, Multiply(layers.fg, layers.back));
    }
    ShaderValue Out() {
        const Layers layers = ReadLayers();
        return Merged(layers, Multiply(layers.fg, OneMinus(layers.back)));
    }
    /// Over, for what does not overlap as far as there is room.
    ShaderValue DisjointOver() {
        const Layers layers = ReadLayers();
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue sum = MakeMath(HDS_MATH_ADD, {layers.front, layers.back}, 1);
        const ShaderValue isCrowded = MakeMath(HDS_MATH_GREATER, {sum, one}, 1);
        const ShaderValue rest = MakeMath(
            HDS_MATH_DIVIDE, {MakeMath(HDS_MATH_SUBTRACT, {one, layers.front}, 1), layers.back}, 1);
        const ShaderValue isClear = MakeMath(
            HDS_MATH_GREATER, {MakeScalar(1e-8F), MakeMath(HDS_MATH_ABS, {layers.back}, 1)}, 1);
        const ShaderValue crowded =
            Math(HDS_MATH_SELECT, {isClear, zero, Add(layers.fg, Multiply(layers.bg, rest))});
        const ShaderValue color =
            Math(HDS_MATH_SELECT, {isCrowded, crowded, Add(layers.fg, layers.bg)});
        const ShaderValue alpha = MakeMath(HDS_MATH_MIN, {sum, one}, 1);
        return Merged(layers, CombineChannels(ChannelOf(color, 0), ChannelOf(color, 1),
                                              ChannelOf(color, 2), alpha, 4));
    }
    ShaderValue Mask() {
        const Layers layers = ReadLayers();
        return Merged(layers, Multiply(layers.bg, layers.front));
    }
    ShaderValue Matte() {
        const Layers layers = ReadLayers();
        const ShaderValue scaled = Multiply(layers.fg, layers.front);
        return Merged(layers, Add(CombineChannels(ChannelOf(scaled, 0), ChannelOf(scaled, 1),
                                                  ChannelOf(scaled, 2), layers.front, 4),
                                  Rest(layers)));
    }
};

constexpr PatternType kTypes[] = {
    {"colorcorrect", kPattern<&ColorNode::ColorCorrect>},
    {"overlay", kPattern<&ColorNode::Overlay>},
    {"burn", kPattern<&ColorNode::BurnOrDodge<true>>},
    {"dodge", kPattern<&ColorNode::BurnOrDodge<false>>},
    {"premult", kPattern<&ColorNode::Premultiply<HDS_MATH_MULTIPLY>>},
    {"unpremult", kPattern<&ColorNode::Premultiply<HDS_MATH_DIVIDE>>},
    {"over", kPattern<&ColorNode::Over>},
    {"in", kPattern<&ColorNode::InNode>},
    {"out", kPattern<&ColorNode::Out>},
    {"disjointover", kPattern<&ColorNode::DisjointOver>},
    {"mask", kPattern<&ColorNode::Mask>},
    {"matte", kPattern<&ColorNode::Matte>},
};

} // namespace

PatternTable ColorNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
