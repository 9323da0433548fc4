// SPDX-License-Identifier: Apache-2.0
// MaterialX's standard nodes as expressions. Nodes are told by the id of their definition,
// ND_<category>_<types>. Semantics and defaults: MaterialX 1.39 specification, standard nodes.
// The table of what there is: docs/materials.md.
#include "hdStream/shading/matrixNodes.h"
#include "hdStream/shading/patternNode.h"
#include "hdStream/shading/surfaceFrame.h"

#include <algorithm>
#include <memory>

namespace hds {

namespace {

constexpr std::array<float, 4> kLuminance{0.2722287F, 0.6740818F, 0.0536895F, 0.0F}; // ACEScg

class StandardNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    template <std::uint32_t kCode>
    ShaderValue Unary() {
        return Math(kCode, {In("in", 0.0F)});
    }
    /// \tparam kDefault of in2; that of in1 is 0
    template <std::uint32_t kCode, int kDefault>
    ShaderValue Binary() {
        const ShaderValue first = In("in1", 0.0F);
        return Math(kCode, {first, In("in2", float(kDefault))});
    }

    ShaderValue Constant() { return In("value", 0.0F); }
    ShaderValue Pass() { return _network.Evaluate(_node, "in"); }
    ShaderValue Image() { return _network.EvaluateImage(_node, {Coordinates(), std::max(_n, 1U)}); }
    ShaderValue TiledImage() {
        const auto at = [&](const char* input, float value) {
            return Vector(input, {value, value, 0.0F, 0.0F}, 2);
        };
        ShaderValue st = MakeMath(HDS_MATH_MULTIPLY, {Coordinates(), at("uvtiling", 1.0F)}, 2);
        st = MakeMath(HDS_MATH_SUBTRACT, {st, at("uvoffset", 0.0F)}, 2);
        st = MakeMath(HDS_MATH_DIVIDE, {st, at("realworldimagesize", 1.0F)}, 2);
        st = MakeMath(HDS_MATH_MULTIPLY, {st, at("realworldtilesize", 1.0F)}, 2);
        ImageRequest request{st, std::max(_n, 1U)};
        request.isPeriodic = true;
        return _network.EvaluateImage(_node, request);
    }

    ShaderValue TexCoord() {
        const ShaderValue index = In("index", 0.0F);
        const int number = IsConstant(index) ? static_cast<int>(ConstantOf(index)[0]) : 0;
        return number == 0 ? Coordinates()
                           : MakePrimvar("st" + std::to_string(number), MakeConstant({}, 2), 2);
    }
    ShaderValue GeomProp() {
        const ShaderValue fallback = Vector("default", {}, std::max(_n, 1U));
        const std::string name = _network.Text(_node, "geomprop");
        if (_n == 0) {
            _network.Warn("node " + _node.identifier + " of " + _node.path +
                          " gives nothing that can be shown");
            return {};
        }
        if (name.empty()) {
            _network.Warn(_node.path + " names no primvar");
            return fallback;
        }
        return MakePrimvar(name, fallback, _n);
    }
    ShaderValue GeomColor() {
        return MakePrimvar("displayColor", MakeConstant({0.0F, 0.0F, 0.0F, 1.0F}, _n),
                           std::min(_n, 3U));
    }

    ShaderValue Position() { return Geometry(ShaderExpression::Kind::Position); }
    ShaderValue Normal() { return Geometry(ShaderExpression::Kind::Normal); }
    ShaderValue PositionInput() {
        return GeometryInput("position", ShaderExpression::Kind::Position);
    }

    /// In tangent space; the surface applies it.
    ShaderValue NormalMap() {
        const ShaderValue in = Vector("in", {0.5F, 0.5F, 1.0F, 0.0F}, 3);
        if (_network.Text(_node, "space") == "object") { // of MaterialX 1.38
            return InTangentSpace(_network, _node, SignedNormal(in, MakeScalar(1.0F)),
                                  HDS_SPACE_OBJECT);
        }
        return SignedNormal(in, In("scale", 1.0F));
    }

    ShaderValue Place2d() {
        return Place(Coordinates(), Vector("scale", {1.0F, 1.0F, 0.0F, 0.0F}, 2),
                     In("rotate", 0.0F), Vector("offset", {}, 2), {});
    }
    ShaderValue RotateNode() { return Rotate2d(Vector("in", {}, 2), In("amount", 0.0F)); }

    ShaderValue MixNode() {
        return Math(HDS_MATH_MIX, {In("bg", 0.0F), In("fg", 0.0F), In("mix", 0.0F)});
    }
    ShaderValue ClampNode() {
        return ClampTo(In("in", 0.0F), In("low", 0.0F), In("high", 1.0F), _n);
    }
    ShaderValue Smoothstep() {
        return Math(HDS_MATH_SMOOTHSTEP, {In("in", 0.0F), In("low", 0.0F), In("high", 1.0F)});
    }
    ShaderValue Remap() {
        return RemapTo(In("in", 0.0F), In("inlow", 0.0F), In("inhigh", 1.0F), In("outlow", 0.0F),
                       In("outhigh", 1.0F));
    }
    ShaderValue Range() {
        return RangeTo(In("in", 0.0F), In("inlow", 0.0F), In("inhigh", 1.0F), In("gamma", 1.0F),
                       In("outlow", 0.0F), In("outhigh", 1.0F), In("doclamp", 0.0F));
    }
    ShaderValue Invert() { return Math(HDS_MATH_SUBTRACT, {In("amount", 1.0F), In("in", 0.0F)}); }
    ShaderValue Fract() { return Math(HDS_MATH_MODULO, {In("in", 0.0F), MakeScalar(1.0F)}); }
    ShaderValue Atan2() {
        const bool isOld = _node.parameters.count("in1") + _node.connections.count("in1") +
                               _node.parameters.count("in2") + _node.connections.count("in2") >
                           0; // before 1.39
        return Math(HDS_MATH_ATAN2,
                    {In(isOld ? "in1" : "iny", 0.0F), In(isOld ? "in2" : "inx", 1.0F)});
    }

    ShaderValue DotNode() { return DotProduct(In("in1", 0.0F), In("in2", 0.0F), _n); }
    ShaderValue CrossProduct() { return Math(HDS_MATH_CROSS, {In("in1", 0.0F), In("in2", 0.0F)}); }
    ShaderValue LengthOf(const ShaderValue& value) const {
        return MakeMath(HDS_MATH_SQRT, {DotProduct(value, value, _n)}, 1);
    }
    ShaderValue Magnitude() { return LengthOf(In("in", 0.0F)); }
    ShaderValue Distance() {
        return LengthOf(Math(HDS_MATH_SUBTRACT, {In("in1", 0.0F), In("in2", 0.0F)}));
    }
    ShaderValue Normalize() {
        const ShaderValue in = In("in", 0.0F);
        return _n == 3 ? Math(HDS_MATH_NORMALIZE, {in}) : Math(HDS_MATH_DIVIDE, {in, LengthOf(in)});
    }

    ShaderValue LuminanceOf(const ShaderValue& in) {
        ShaderValue result = DotProduct(in, Vector("lumacoeffs", kLuminance, 3), 3);
        result.numComponents = _n;
        return result;
    }
    ShaderValue Luminance() { return LuminanceOf(In("in", 0.0F)); }
    ShaderValue Saturate() {
        const ShaderValue in = In("in", 0.0F);
        return Math(HDS_MATH_MIX, {LuminanceOf(in), in, In("amount", 1.0F)});
    }
    ShaderValue Contrast() {
        const ShaderValue pivot = In("pivot", 0.5F);
        const ShaderValue moved = Math(HDS_MATH_SUBTRACT, {In("in", 0.0F), pivot});
        return Math(HDS_MATH_ADD, {Math(HDS_MATH_MULTIPLY, {moved, In("amount", 1.0F)}), pivot});
    }
    ShaderValue RgbToHsv() { return Math(HDS_MATH_RGB_TO_HSV, {In("in", 0.0F)}); }
    ShaderValue HsvToRgb() { return Math(HDS_MATH_HSV_TO_RGB, {In("in", 0.0F)}); }
    ShaderValue HsvAdjust() {
        const ShaderValue amount = Vector("amount", {0.0F, 1.0F, 1.0F, 0.0F}, 3);
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue turn = CombineChannels(ChannelOf(amount, 0), zero, zero, zero, _n);
        const ShaderValue scale =
            CombineChannels(one, ChannelOf(amount, 1), ChannelOf(amount, 2), one, _n);
        const ShaderValue hsv = Math(HDS_MATH_ADD, {RgbToHsv(), turn});
        return Math(HDS_MATH_HSV_TO_RGB, {Math(HDS_MATH_MULTIPLY, {hsv, scale})});
    }

    /// Of scalars, or of vectors that fill the components one after another.
    template <std::size_t kCount>
    ShaderValue CombineNode() {
        std::vector<ShaderValue> parts;
        const char* const inputs[] = {"in1", "in2", "in3", "in4"};
        for (std::size_t i = 0; i < kCount; ++i) {
            const ShaderValue in = In(inputs[i], 0.0F);
            for (std::uint32_t k = 0; k < in.numComponents; ++k) {
                parts.push_back(ChannelOf(in, k));
            }
        }
        parts.resize(4, MakeScalar(0.0F));
        return CombineChannels(parts[0], parts[1], parts[2], parts[3], _n);
    }
    ShaderValue Extract() {
        const ShaderValue index = In("index", 0.0F);
        if (!IsConstant(index)) {
            _network.Warn("the index of " + _node.path + " varies; 0 is used");
        }
        const float number = IsConstant(index) ? ConstantOf(index)[0] : 0.0F;
        const auto place = static_cast<std::uint32_t>(std::clamp(number, 0.0F, 3.0F));
        if (_node.identifier.find("_matrix") != std::string::npos) {
            return ExtractRow(_network, _node, place);
        }
        return ChannelOf(In("in", 0.0F), place);
    }
    ShaderValue Separate() {
        static const std::string kNames = "rgbaxyzw";
        const std::size_t channel =
            _output.size() == 4 ? kNames.find(_output[3]) : std::string::npos;
        if (channel == std::string::npos) {
            _network.Warn(_node.path + " has no output " + _output);
            return {};
        }
        return ChannelOf(In("in", 0.0F), static_cast<std::uint32_t>(channel % 4));
    }
    ShaderValue Convert() {
        ShaderValue in = In("in", 0.0F);
        if (in.numComponents == 3 && _n == 4) {
            return CombineChannels(ChannelOf(in, 0), ChannelOf(in, 1), ChannelOf(in, 2),
                                   MakeScalar(1.0F), 4);
        }
        if (in.numComponents == 2 && _n > 2) {
            return CombineChannels(ChannelOf(in, 0), ChannelOf(in, 1), MakeScalar(0.0F),
                                   MakeScalar(0.0F), _n);
        }
        if (_n == 1) {
            return ChannelOf(in, 0);
        }
        in.numComponents = _n;
        return in;
    }
    ShaderValue Swizzle() {
        static const std::string kNames = "rgbaxyzw";
        const std::string channels = _network.Text(_node, "channels");
        const ShaderValue in = In("in", 0.0F);
        std::vector<ShaderValue> parts;
        for (const char name : channels) {
            const std::size_t channel = kNames.find(name);
            if (name == '0' || name == '1') {
                parts.push_back(MakeScalar(name == '1' ? 1.0F : 0.0F));
            } else if (channel != std::string::npos) {
                parts.push_back(ChannelOf(in, static_cast<std::uint32_t>(channel % 4)));
            }
        }
        if (parts.size() != channels.size() || parts.empty() || parts.size() > 4) {
            _network.Warn("channels of " + _node.path + " are '" + channels + "'");
            return {};
        }
        if (parts.size() == 1) {
            parts[0].numComponents = std::max(_n, 1U);
            return parts[0];
        }
        parts.resize(4, MakeScalar(0.0F));
        return CombineChannels(parts[0], parts[1], parts[2], parts[3], _n);
    }

    /// \tparam kDefault of value1
    template <std::uint32_t kCode, int kDefault>
    ShaderValue If() {
        const ShaderValue first = In("value1", float(kDefault));
        const ShaderValue condition = MakeMath(kCode, {first, In("value2", 0.0F)}, 1);
        return Math(HDS_MATH_SELECT, {condition, In("in1", 0.0F), In("in2", 0.0F)});
    }
    ShaderValue Switch() {
        const ShaderValue which = In("which", 0.0F);
        ShaderValue result = MakeScalar(0.0F);
        for (int i = 10; i > 0; --i) {
            const std::string input = "in" + std::to_string(i);
            const ShaderValue isBelow =
                MakeMath(HDS_MATH_GREATER, {MakeScalar(static_cast<float>(i)), which}, 1);
            result = Math(HDS_MATH_SELECT, {isBelow, In(input.c_str(), 0.0F), result});
        }
        return result;
    }

    ShaderValue ClampedCoordinate(std::uint32_t channel) {
        return ClampTo(ChannelOf(Coordinates(), channel), MakeScalar(0.0F), MakeScalar(1.0F), 1);
    }
    ShaderValue RampLr() {
        return Math(HDS_MATH_MIX, {In("valuel", 0.0F), In("valuer", 0.0F), ClampedCoordinate(0)});
    }
    ShaderValue RampTb() {
        return Math(HDS_MATH_MIX, {In("valueb", 0.0F), In("valuet", 0.0F), ClampedCoordinate(1)});
    }
    ShaderValue Ramp4() {
        const ShaderValue s = ClampedCoordinate(0);
        const ShaderValue top = Math(HDS_MATH_MIX, {In("valuetl", 0.0F), In("valuetr", 0.0F), s});
        const ShaderValue bottom =
            Math(HDS_MATH_MIX, {In("valuebl", 0.0F), In("valuebr", 0.0F), s});
        return Math(HDS_MATH_MIX, {bottom, top, ClampedCoordinate(1)});
    }
    ShaderValue Split(const char* low, const char* high, std::uint32_t channel) {
        const ShaderValue isHigh = MakeMath(
            HDS_MATH_GREATER_OR_EQUAL, {ChannelOf(Coordinates(), channel), In("center", 0.5F)}, 1);
        return Math(HDS_MATH_SELECT, {isHigh, In(high, 0.0F), In(low, 0.0F)});
    }
    ShaderValue SplitLr() { return Split("valuel", "valuer", 0); }
    ShaderValue SplitTb() { return Split("valueb", "valuet", 1); }
    ShaderValue Checkerboard() {
        const auto at = [&](const char* input, float value) {
            return Vector(input, {value, value, 0.0F, 0.0F}, 2);
        };
        const ShaderValue st =
            MakeMath(HDS_MATH_SUBTRACT,
                     {MakeMath(HDS_MATH_MULTIPLY, {Coordinates(), at("uvtiling", 8.0F)}, 2),
                      at("uvoffset", 0.0F)},
                     2);
        const ShaderValue cell = MakeMath(HDS_MATH_FLOOR, {st}, 2);
        const ShaderValue sum = MakeMath(HDS_MATH_ADD, {ChannelOf(cell, 0), ChannelOf(cell, 1)}, 1);
        const ShaderValue odd = MakeMath(HDS_MATH_MODULO, {sum, MakeScalar(2.0F)}, 1);
        return Math(HDS_MATH_MIX, {In("color2", 0.0F), In("color1", 1.0F), odd});
    }

    bool IsIn3d() const { return _id.category.find("3d") != std::string::npos; }
    ShaderValue NoisePlace() { return IsIn3d() ? PositionInput() : Coordinates(); }
    ShaderValue Noise() {
        const std::uint32_t code =
            _n == 1 ? (IsIn3d() ? HDS_MATH_NOISE3 : HDS_MATH_NOISE2)
                    : (IsIn3d() ? HDS_MATH_NOISE3_VECTOR : HDS_MATH_NOISE2_VECTOR);
        const ShaderValue scaled =
            Math(HDS_MATH_MULTIPLY, {Math(code, {NoisePlace()}), In("amplitude", 1.0F)});
        return Math(HDS_MATH_ADD, {scaled, In("pivot", 0.0F)});
    }
    ShaderValue Fractal() {
        const std::uint32_t code = _n == 1 ? HDS_MATH_FRACTAL3 : HDS_MATH_FRACTAL3_VECTOR;
        const ShaderValue sum = Math(code, {PositionInput(), In("octaves", 3.0F),
                                            In("lacunarity", 2.0F), In("diminish", 0.5F)});
        return Math(HDS_MATH_MULTIPLY, {sum, In("amplitude", 1.0F)});
    }
    ShaderValue CellNoise() {
        return Math(IsIn3d() ? HDS_MATH_CELL3 : HDS_MATH_CELL2, {NoisePlace()});
    }

    /// \tparam kCode of background and foreground
    template <std::uint32_t kCode>
    ShaderValue Blend() {
        const ShaderValue fg = In("fg", 0.0F);
        const ShaderValue bg = In("bg", 0.0F);
        return Mix(bg, Math(kCode, {bg, fg}), In("mix", 1.0F));
    }
    ShaderValue Difference() {
        const ShaderValue fg = In("fg", 0.0F);
        const ShaderValue bg = In("bg", 0.0F);
        return Mix(bg, Math(HDS_MATH_ABS, {Subtract(bg, fg)}), In("mix", 1.0F));
    }
    ShaderValue Screen() {
        const ShaderValue fg = In("fg", 0.0F);
        const ShaderValue bg = In("bg", 0.0F);
        return Mix(bg, OneMinus(Multiply(OneMinus(bg), OneMinus(fg))), In("mix", 1.0F));
    }
    ShaderValue Inside() {
        const ShaderValue mask = In("mask", 1.0F);
        return Multiply(In("in", 0.0F), mask);
    }
    ShaderValue Outside() {
        const ShaderValue mask = In("mask", 0.0F);
        const ShaderValue share = MakeMath(HDS_MATH_SUBTRACT, {MakeScalar(1.0F), mask}, 1);
        return Multiply(In("in", 0.0F), share);
    }
};

constexpr PatternType kTypes[] = {
    {"constant", kPattern<&StandardNode::Constant>},
    {"dot", kPattern<&StandardNode::Pass>},
    {"image", kPattern<&StandardNode::Image>},
    {"tiledimage", kPattern<&StandardNode::TiledImage>},
    {"texcoord", kPattern<&StandardNode::TexCoord>},
    {"geompropvalue", kPattern<&StandardNode::GeomProp>},
    {"geomcolor", kPattern<&StandardNode::GeomColor>},
    {"position", kPattern<&StandardNode::Position>},
    {"normal", kPattern<&StandardNode::Normal>},
    {"normalmap", kPattern<&StandardNode::NormalMap>},
    {"absval", kPattern<&StandardNode::Unary<HDS_MATH_ABS>>},
    {"sign", kPattern<&StandardNode::Unary<HDS_MATH_SIGN>>},
    {"floor", kPattern<&StandardNode::Unary<HDS_MATH_FLOOR>>},
    {"ceil", kPattern<&StandardNode::Unary<HDS_MATH_CEIL>>},
    {"round", kPattern<&StandardNode::Unary<HDS_MATH_ROUND>>},
    {"sqrt", kPattern<&StandardNode::Unary<HDS_MATH_SQRT>>},
    {"exp", kPattern<&StandardNode::Unary<HDS_MATH_EXP>>},
    {"ln", kPattern<&StandardNode::Unary<HDS_MATH_LN>>},
    {"sin", kPattern<&StandardNode::Unary<HDS_MATH_SIN>>},
    {"cos", kPattern<&StandardNode::Unary<HDS_MATH_COS>>},
    {"tan", kPattern<&StandardNode::Unary<HDS_MATH_TAN>>},
    {"asin", kPattern<&StandardNode::Unary<HDS_MATH_ASIN>>},
    {"acos", kPattern<&StandardNode::Unary<HDS_MATH_ACOS>>},
    {"add", kPattern<&StandardNode::Binary<HDS_MATH_ADD, 0>>},
    {"subtract", kPattern<&StandardNode::Binary<HDS_MATH_SUBTRACT, 0>>},
    {"multiply", kPattern<&StandardNode::Binary<HDS_MATH_MULTIPLY, 1>>},
    {"divide", kPattern<&StandardNode::Binary<HDS_MATH_DIVIDE, 1>>},
    {"modulo", kPattern<&StandardNode::Binary<HDS_MATH_MODULO, 1>>},
    {"power", kPattern<&StandardNode::Binary<HDS_MATH_POWER, 1>>},
    {"min", kPattern<&StandardNode::Binary<HDS_MATH_MIN, 0>>},
    {"max", kPattern<&StandardNode::Binary<HDS_MATH_MAX, 0>>},
    {"place2d", kPattern<&StandardNode::Place2d>},
    {"rotate2d", kPattern<&StandardNode::RotateNode>},
    {"mix", kPattern<&StandardNode::MixNode>},
    {"clamp", kPattern<&StandardNode::ClampNode>},
    {"smoothstep", kPattern<&StandardNode::Smoothstep>},
    {"remap", kPattern<&StandardNode::Remap>},
    {"range", kPattern<&StandardNode::Range>},
    {"invert", kPattern<&StandardNode::Invert>},
    {"fract", kPattern<&StandardNode::Fract>},
    {"atan2", kPattern<&StandardNode::Atan2>},
    {"dotproduct", kPattern<&StandardNode::DotNode>},
    {"crossproduct", kPattern<&StandardNode::CrossProduct>},
    {"magnitude", kPattern<&StandardNode::Magnitude>},
    {"distance", kPattern<&StandardNode::Distance>},
    {"normalize", kPattern<&StandardNode::Normalize>},
    {"luminance", kPattern<&StandardNode::Luminance>},
    {"saturate", kPattern<&StandardNode::Saturate>},
    {"contrast", kPattern<&StandardNode::Contrast>},
    {"rgbtohsv", kPattern<&StandardNode::RgbToHsv>},
    {"hsvtorgb", kPattern<&StandardNode::HsvToRgb>},
    {"hsvadjust", kPattern<&StandardNode::HsvAdjust>},
    {"combine2", kPattern<&StandardNode::CombineNode<2>>},
    {"combine3", kPattern<&StandardNode::CombineNode<3>>},
    {"combine4", kPattern<&StandardNode::CombineNode<4>>},
    {"separate2", kPattern<&StandardNode::Separate>},
    {"separate3", kPattern<&StandardNode::Separate>},
    {"separate4", kPattern<&StandardNode::Separate>},
    {"extract", kPattern<&StandardNode::Extract>},
    {"convert", kPattern<&StandardNode::Convert>},
    {"swizzle", kPattern<&StandardNode::Swizzle>},
    {"ifgreater", kPattern<&StandardNode::If<HDS_MATH_GREATER, 1>>},
    {"ifgreatereq", kPattern<&StandardNode::If<HDS_MATH_GREATER_OR_EQUAL, 1>>},
    {"ifequal", kPattern<&StandardNode::If<HDS_MATH_EQUAL, 0>>},
    {"switch", kPattern<&StandardNode::Switch>},
    {"ramplr", kPattern<&StandardNode::RampLr>},
    {"ramptb", kPattern<&StandardNode::RampTb>},
    {"ramp4", kPattern<&StandardNode::Ramp4>},
    {"splitlr", kPattern<&StandardNode::SplitLr>},
    {"splittb", kPattern<&StandardNode::SplitTb>},
    {"checkerboard", kPattern<&StandardNode::Checkerboard>},
    {"noise2d", kPattern<&StandardNode::Noise>},
    {"noise3d", kPattern<&StandardNode::Noise>},
    {"fractal3d", kPattern<&StandardNode::Fractal>},
    {"cellnoise2d", kPattern<&StandardNode::CellNoise>},
    {"cellnoise3d", kPattern<&StandardNode::CellNoise>},
    {"plus", kPattern<&StandardNode::Blend<HDS_MATH_ADD>>},
    {"minus", kPattern<&StandardNode::Blend<HDS_MATH_SUBTRACT>>},
    {"difference", kPattern<&StandardNode::Difference>},
    {"screen", kPattern<&StandardNode::Screen>},
    {"inside", kPattern<&StandardNode::Inside>},
    {"outside", kPattern<&StandardNode::Outside>},
};

} // namespace

PatternTable StandardNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
