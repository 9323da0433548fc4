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

    std::optional<ShaderValue> Evaluate() {
        using Function = ShaderValue (ColorNode::*)();
        static const std::map<std::string, Function> kFunctions = {
            {"colorcorrect", &ColorNode::ColorCorrect},
            {"overlay", &ColorNode::Overlay},
            {"burn", &ColorNode::BurnOrDodge},
            {"dodge", &ColorNode::BurnOrDodge},
            {"premult", &ColorNode::Premultiply},
            {"unpremult", &ColorNode::Premultiply},
            {"over", &ColorNode::Merge},
            {"in", &ColorNode::Merge},
            {"out", &ColorNode::Merge},
            {"mask", &ColorNode::Merge},
            {"matte", &ColorNode::Merge},
        };
        const auto found = kFunctions.find(_id.category);
        return found == kFunctions.end() ? std::nullopt : std::optional((this->*found->second)());
    }

private:
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
    ShaderValue BurnOrDodge() {
        const bool isBurn = _id.category == "burn";
        const ShaderValue fg = In("fg", 0.0F);
        const ShaderValue bg = In("bg", 0.0F);
        const ShaderValue divisor = isBurn ? fg : OneMinus(fg);
        const ShaderValue value =
            isBurn ? OneMinus(Divide(OneMinus(bg), divisor)) : Divide(bg, divisor);
        const ShaderValue isSmall =
            Math(HDS_MATH_GREATER, {MakeScalar(1e-8F), Math(HDS_MATH_ABS, {divisor})});
        return Math(HDS_MATH_SELECT, {isSmall, MakeScalar(0.0F), Mix(bg, value, In("mix", 1.0F))});
    }
    ShaderValue Premultiply() {
        const ShaderValue in = Vector("in", {0.0F, 0.0F, 0.0F, 1.0F}, 4);
        const ShaderValue alpha = ChannelOf(in, 3);
        const ShaderValue color =
            _id.category == "premult" ? Multiply(in, alpha) : Divide(in, alpha);
        return CombineChannels(ChannelOf(color, 0), ChannelOf(color, 1), ChannelOf(color, 2), alpha,
                               4);
    }
    /// Porter and Duff's operators on colours with alpha.
    ShaderValue Merge() {
        const ShaderValue fg = Vector("fg", {}, 4);
        const ShaderValue bg = Vector("bg", {}, 4);
        const ShaderValue front = ChannelOf(fg, 3);
        const ShaderValue back = ChannelOf(bg, 3);
        const ShaderValue rest = Multiply(bg, OneMinus(front));
        ShaderValue value;
        if (_id.category == "over") {
            value = Add(fg, rest);
        } else if (_id.category == "in") {
            value = Multiply(fg, back);
        } else if (_id.category == "out") {
            value = Multiply(fg, OneMinus(back));
        } else if (_id.category == "mask") {
            value = Multiply(bg, front);
        } else { // matte
            const ShaderValue scaled = Multiply(fg, front);
            value = Add(CombineChannels(ChannelOf(scaled, 0), ChannelOf(scaled, 1),
                                        ChannelOf(scaled, 2), front, 4),
                        rest);
        }
        return Mix(bg, value, In("mix", 1.0F));
    }
};

} // namespace

std::optional<ShaderValue> EvaluateColorNode(NetworkEvaluator& network, const MaterialNode& node) {
    return ColorNode(network, node).Evaluate();
}

} // namespace hds
