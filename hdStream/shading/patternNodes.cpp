// SPDX-License-Identifier: Apache-2.0
// MaterialX's standard nodes as expressions. Nodes are told by the id of their definition,
// ND_<category>_<types>. Semantics and defaults: MaterialX 1.39 specification, standard nodes.
// The table of what there is: docs/materials.md.
#include "hdStream/shading/networkEvaluator.h"
#include "hdStream/shading/nodeId.h"
#include "hdStream/shading/shaderMath.h"

#include <algorithm>
#include <memory>

namespace hds {

namespace {

const std::map<std::string, std::uint32_t>& UnaryFunctions() {
    static const std::map<std::string, std::uint32_t> kFunctions = {
        {"absval", HDS_MATH_ABS}, {"sign", HDS_MATH_SIGN},   {"floor", HDS_MATH_FLOOR},
        {"ceil", HDS_MATH_CEIL},  {"round", HDS_MATH_ROUND}, {"sqrt", HDS_MATH_SQRT},
        {"exp", HDS_MATH_EXP},    {"ln", HDS_MATH_LN},       {"sin", HDS_MATH_SIN},
        {"cos", HDS_MATH_COS},    {"tan", HDS_MATH_TAN},     {"asin", HDS_MATH_ASIN},
        {"acos", HDS_MATH_ACOS}};
    return kFunctions;
}

/// Function and default of in2; that of in1 is 0.
const std::map<std::string, std::pair<std::uint32_t, float>>& BinaryFunctions() {
    static const std::map<std::string, std::pair<std::uint32_t, float>> kFunctions = {
        {"add", {HDS_MATH_ADD, 0.0F}},           {"subtract", {HDS_MATH_SUBTRACT, 0.0F}},
        {"multiply", {HDS_MATH_MULTIPLY, 1.0F}}, {"divide", {HDS_MATH_DIVIDE, 1.0F}},
        {"modulo", {HDS_MATH_MODULO, 1.0F}},     {"power", {HDS_MATH_POWER, 1.0F}},
        {"min", {HDS_MATH_MIN, 0.0F}},           {"max", {HDS_MATH_MAX, 0.0F}}};
    return kFunctions;
}

constexpr std::array<float, 4> kLuminance{0.2722287F, 0.6740818F, 0.0536895F, 0.0F}; // ACEScg
constexpr float kDegree = 0.01745329252F;

ShaderValue Channel(const ShaderValue& value, std::uint32_t channel) {
    return value.numComponents == 1 ? value : SelectChannel(value, channel);
}

ShaderValue Combine(const ShaderValue& x, const ShaderValue& y, const ShaderValue& z,
                    const ShaderValue& w, std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_COMBINE, {x, y, z, w}, numComponents);
}

/// The dot product of 2 to 4 components; what lies behind them may be anything.
ShaderValue Dot(const ShaderValue& a, const ShaderValue& b, std::uint32_t numComponents) {
    if (numComponents == 3) {
        return MakeMath(HDS_MATH_DOT, {a, b}, 1);
    }
    ShaderValue sum = MakeScalar(0.0F);
    for (std::uint32_t k = 0; k < numComponents; ++k) {
        sum = MakeMath(HDS_MATH_ADD,
                       {sum, MakeMath(HDS_MATH_MULTIPLY, {Channel(a, k), Channel(b, k)}, 1)}, 1);
    }
    return sum;
}

ShaderValue Clamp(const ShaderValue& value, const ShaderValue& low, const ShaderValue& high,
                  std::uint32_t numComponents) {
    return MakeMath(HDS_MATH_MIN, {MakeMath(HDS_MATH_MAX, {value, low}, numComponents), high},
                    numComponents);
}

/// MaterialX turns clockwise.
ShaderValue Rotate(const ShaderValue& in, const ShaderValue& degrees) {
    if (IsConstant(degrees)) {
        const std::array<double, 6> rows =
            Transform2dRows(-ConstantOf(degrees)[0], {1.0F, 1.0F, 0.0F, 0.0F}, {});
        return MakeAffine(in, rows);
    }
    const ShaderValue angle =
        MakeMath(HDS_MATH_MULTIPLY, {Spread(degrees), MakeScalar(kDegree)}, 1);
    const ShaderValue c = MakeMath(HDS_MATH_COS, {angle}, 1);
    const ShaderValue s = MakeMath(HDS_MATH_SIN, {angle}, 1);
    const auto product = [](const ShaderValue& a, const ShaderValue& b) {
        return MakeMath(HDS_MATH_MULTIPLY, {a, b}, 1);
    };
    const ShaderValue x = Channel(in, 0);
    const ShaderValue y = Channel(in, 1);
    return Combine(MakeMath(HDS_MATH_ADD, {product(c, x), product(s, y)}, 1),
                   MakeMath(HDS_MATH_SUBTRACT, {product(c, y), product(s, x)}, 1), MakeScalar(0.0F),
                   MakeScalar(0.0F), 2);
}

} // namespace

/// One node of a network.
class PatternEvaluator {
public:
    PatternEvaluator(NetworkEvaluator& network, const MaterialNode& node)
        : _network(network), _node(node), _id(ParseId(node.identifier)), _n(_id.lastComponents) {}

    /// Empty: not supported, or not to be had (warned of).
    ShaderValue Evaluate(const std::string& output) {
        using Function = ShaderValue (PatternEvaluator::*)();
        static const std::map<std::string, Function> kFunctions = {
            {"constant", &PatternEvaluator::Constant},
            {"dot", &PatternEvaluator::Pass},
            {"image", &PatternEvaluator::Image},
            {"tiledimage", &PatternEvaluator::Image},
            {"texcoord", &PatternEvaluator::TexCoord},
            {"geompropvalue", &PatternEvaluator::GeomProp},
            {"geomcolor", &PatternEvaluator::GeomColor},
            {"position", &PatternEvaluator::Position},
            {"normal", &PatternEvaluator::Normal},
            {"normalmap", &PatternEvaluator::NormalMap},
            {"place2d", &PatternEvaluator::Place2d},
            {"rotate2d", &PatternEvaluator::Rotate2d},
            {"mix", &PatternEvaluator::Mix},
            {"clamp", &PatternEvaluator::ClampNode},
            {"smoothstep", &PatternEvaluator::Smoothstep},
            {"remap", &PatternEvaluator::Remap},
            {"range", &PatternEvaluator::Range},
            {"invert", &PatternEvaluator::Invert},
            {"fract", &PatternEvaluator::Fract},
            {"atan2", &PatternEvaluator::Atan2},
            {"dotproduct", &PatternEvaluator::DotProduct},
            {"crossproduct", &PatternEvaluator::CrossProduct},
            {"magnitude", &PatternEvaluator::Magnitude},
            {"distance", &PatternEvaluator::Distance},
            {"normalize", &PatternEvaluator::Normalize},
            {"luminance", &PatternEvaluator::Luminance},
            {"saturate", &PatternEvaluator::Saturate},
            {"contrast", &PatternEvaluator::Contrast},
            {"rgbtohsv", &PatternEvaluator::RgbToHsv},
            {"hsvtorgb", &PatternEvaluator::HsvToRgb},
            {"hsvadjust", &PatternEvaluator::HsvAdjust},
            {"combine2", &PatternEvaluator::CombineNode},
            {"combine3", &PatternEvaluator::CombineNode},
            {"combine4", &PatternEvaluator::CombineNode},
            {"extract", &PatternEvaluator::Extract},
            {"convert", &PatternEvaluator::Convert},
            {"swizzle", &PatternEvaluator::Swizzle},
            {"ifgreater", &PatternEvaluator::If},
            {"ifgreatereq", &PatternEvaluator::If},
            {"ifequal", &PatternEvaluator::If},
            {"switch", &PatternEvaluator::Switch},
            {"ramplr", &PatternEvaluator::RampLr},
            {"ramptb", &PatternEvaluator::RampTb},
            {"ramp4", &PatternEvaluator::Ramp4},
            {"splitlr", &PatternEvaluator::SplitLr},
            {"splittb", &PatternEvaluator::SplitTb},
            {"checkerboard", &PatternEvaluator::Checkerboard},
            {"noise2d", &PatternEvaluator::Noise},
            {"noise3d", &PatternEvaluator::Noise},
            {"fractal3d", &PatternEvaluator::Fractal},
            {"cellnoise2d", &PatternEvaluator::CellNoise},
            {"cellnoise3d", &PatternEvaluator::CellNoise},
            {"plus", &PatternEvaluator::Blend},
            {"minus", &PatternEvaluator::Blend},
            {"difference", &PatternEvaluator::Blend},
            {"screen", &PatternEvaluator::Blend},
            {"inside", &PatternEvaluator::Mask},
            {"outside", &PatternEvaluator::Mask},
        };
        const std::string& category = _id.category;
        if (const auto unary = UnaryFunctions().find(category); unary != UnaryFunctions().end()) {
            return MakeMath(unary->second, {In("in", 0.0F)}, _n);
        }
        if (const auto binary = BinaryFunctions().find(category);
            binary != BinaryFunctions().end()) {
            return MakeMath(binary->second.first,
                            {In("in1", 0.0F), In("in2", binary->second.second)}, _n);
        }
        if (category.compare(0, 8, "separate") == 0) {
            return Separate(output);
        }
        const auto found = kFunctions.find(category);
        if (found == kFunctions.end()) {
            _network.Warn("node " + _node.identifier + " of " + _node.path +
                          " is not supported; what it feeds keeps its default");
            return {};
        }
        return (this->*found->second)();
    }

private:
    /// An input: a vector, or a scalar (in all components) where it is one or nothing.
    ShaderValue In(const char* input, float fallback) {
        return Spread(
            _network.EvaluateOr(_node, input, {fallback, fallback, fallback, fallback}, 1));
    }
    ShaderValue Vector(const char* input, const std::array<float, 4>& fallback,
                       std::uint32_t numComponents) {
        return _network.EvaluateOr(_node, input, fallback, numComponents);
    }
    ShaderValue Math(std::uint32_t code, std::vector<ShaderValue> operands) {
        return MakeMath(code, std::move(operands), _n);
    }
    ShaderValue Coordinates() { return _network.ImageCoordinates(_node); }

    ShaderValue Constant() { return In("value", 0.0F); }
    ShaderValue Pass() { return _network.Evaluate(_node, "in"); }
    ShaderValue Image() { return _network.EvaluateImage(_node, std::max(_n, 1U)); }

    static ShaderValue Primvar(const std::string& name, const ShaderValue& fallback,
                               std::uint32_t numComponents) {
        auto expression = std::make_shared<ShaderExpression>();
        expression->kind = ShaderExpression::Kind::Primvar;
        expression->primvar = name;
        expression->operands = {fallback};
        return {std::move(expression), HDS_CHANNEL_ALL, numComponents};
    }

    ShaderValue TexCoord() {
        const ShaderValue index = In("index", 0.0F);
        const int number = IsConstant(index) ? static_cast<int>(ConstantOf(index)[0]) : 0;
        return number == 0 ? Coordinates()
                           : Primvar("st" + std::to_string(number), MakeConstant({}, 2), 2);
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
        return Primvar(name, fallback, _n);
    }
    ShaderValue GeomColor() {
        return Primvar("displayColor", MakeConstant({0.0F, 0.0F, 0.0F, 1.0F}, _n),
                       std::min(_n, 3U));
    }

    ShaderValue Geometry(ShaderExpression::Kind kind) {
        auto expression = std::make_shared<ShaderExpression>();
        expression->kind = kind;
        expression->code =
            _network.Text(_node, "space") == "world" ? HDS_SPACE_WORLD : HDS_SPACE_OBJECT;
        return {std::move(expression), HDS_CHANNEL_ALL, 3};
    }
    ShaderValue Position() { return Geometry(ShaderExpression::Kind::Position); }
    ShaderValue Normal() { return Geometry(ShaderExpression::Kind::Normal); }
    ShaderValue PositionInput() {
        const ShaderValue authored = _network.Evaluate(_node, "position");
        return authored && authored.numComponents >= 3 ? authored : Position();
    }

    /// In tangent space; the surface applies it.
    ShaderValue NormalMap() {
        if (_network.Text(_node, "space") == "object") {
            _network.Warn("normal map " + _node.path + " in object space is not supported");
            return {};
        }
        const ShaderValue in = Vector("in", {0.5F, 0.5F, 1.0F, 0.0F}, 3);
        const ShaderValue size = In("scale", 1.0F);
        const ShaderValue scale = Combine(Channel(size, 0), Channel(size, size.numComponents > 1),
                                          MakeScalar(1.0F), MakeScalar(0.0F), 4);
        if (in.expression->kind == ShaderExpression::Kind::Texture &&
            in.channel == HDS_CHANNEL_ALL && IsConstant(scale)) {
            auto lookup = std::make_shared<ShaderExpression>(*in.expression);
            const std::array<float, 4>& s = ConstantOf(scale);
            lookup->operands[1] = ToSigned(lookup->operands[1], scale);
            lookup->operands[2] = MakeConstant({2.0F * s[0], 2.0F * s[1], 2.0F, 1.0F}, 4);
            lookup->operands[3] = MakeConstant({-s[0], -s[1], -1.0F, 0.0F}, 4);
            return {std::move(lookup), HDS_CHANNEL_ALL, 3};
        }
        return ToSigned(in, scale);
    }
    static ShaderValue ToSigned(const ShaderValue& in, const ShaderValue& scale) {
        const ShaderValue moved =
            MakeMath(HDS_MATH_SUBTRACT,
                     {MakeMath(HDS_MATH_MULTIPLY, {in, MakeScalar(2.0F)}, 3), MakeScalar(1.0F)}, 3);
        return MakeMath(HDS_MATH_MULTIPLY, {moved, scale}, 3);
    }

    ShaderValue Place2d() {
        const ShaderValue pivot = Vector("pivot", {}, 2);
        const ShaderValue scale = Vector("scale", {1.0F, 1.0F, 0.0F, 0.0F}, 2);
        const ShaderValue offset = Vector("offset", {}, 2);
        const ShaderValue rotate = In("rotate", 0.0F);
        const bool movesFirst = IsAll(In("operationorder", 0.0F), 1.0F);
        ShaderValue st = Math(HDS_MATH_SUBTRACT, {Coordinates(), pivot});
        if (movesFirst) {
            st = Rotate(Math(HDS_MATH_SUBTRACT, {st, offset}), rotate);
            st = Math(HDS_MATH_DIVIDE, {st, scale});
        } else {
            st = Rotate(Math(HDS_MATH_DIVIDE, {st, scale}), rotate);
            st = Math(HDS_MATH_SUBTRACT, {st, offset});
        }
        return Math(HDS_MATH_ADD, {st, pivot});
    }
    ShaderValue Rotate2d() { return Rotate(Vector("in", {}, 2), In("amount", 0.0F)); }

    ShaderValue Mix() {
        return Math(HDS_MATH_MIX, {In("bg", 0.0F), In("fg", 0.0F), In("mix", 0.0F)});
    }
    ShaderValue ClampNode() { return Clamp(In("in", 0.0F), In("low", 0.0F), In("high", 1.0F), _n); }
    ShaderValue Smoothstep() {
        return Math(HDS_MATH_SMOOTHSTEP, {In("in", 0.0F), In("low", 0.0F), In("high", 1.0F)});
    }
    ShaderValue RemapTo(const ShaderValue& in, const ShaderValue& low, const ShaderValue& high,
                        const ShaderValue& outLow, const ShaderValue& outHigh) {
        const ShaderValue share = Math(HDS_MATH_DIVIDE, {Math(HDS_MATH_SUBTRACT, {in, low}),
                                                         Math(HDS_MATH_SUBTRACT, {high, low})});
        return Math(
            HDS_MATH_ADD,
            {outLow, Math(HDS_MATH_MULTIPLY, {share, Math(HDS_MATH_SUBTRACT, {outHigh, outLow})})});
    }
    ShaderValue Remap() {
        return RemapTo(In("in", 0.0F), In("inlow", 0.0F), In("inhigh", 1.0F), In("outlow", 0.0F),
                       In("outhigh", 1.0F));
    }
    ShaderValue Range() {
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue one = MakeScalar(1.0F);
        ShaderValue share =
            RemapTo(In("in", 0.0F), In("inlow", 0.0F), In("inhigh", 1.0F), zero, one);
        const ShaderValue gamma = In("gamma", 1.0F);
        if (!IsAll(gamma, 1.0F)) {
            const ShaderValue power = Math(
                HDS_MATH_POWER, {Math(HDS_MATH_ABS, {share}), Math(HDS_MATH_DIVIDE, {one, gamma})});
            share = Math(HDS_MATH_MULTIPLY, {power, Math(HDS_MATH_SIGN, {share})});
        }
        const ShaderValue low = In("outlow", 0.0F);
        const ShaderValue high = In("outhigh", 1.0F);
        const ShaderValue result = RemapTo(share, zero, one, low, high);
        return IsAll(In("doclamp", 0.0F), 1.0F) ? Clamp(result, low, high, _n) : result;
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

    ShaderValue DotProduct() { return Dot(In("in1", 0.0F), In("in2", 0.0F), _n); }
    ShaderValue CrossProduct() { return Math(HDS_MATH_CROSS, {In("in1", 0.0F), In("in2", 0.0F)}); }
    ShaderValue LengthOf(const ShaderValue& value) const {
        return MakeMath(HDS_MATH_SQRT, {Dot(value, value, _n)}, 1);
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
        ShaderValue result = Dot(in, Vector("lumacoeffs", kLuminance, 3), 3);
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
        const ShaderValue turn = Combine(Channel(amount, 0), zero, zero, zero, _n);
        const ShaderValue scale = Combine(one, Channel(amount, 1), Channel(amount, 2), one, _n);
        const ShaderValue hsv = Math(HDS_MATH_ADD, {RgbToHsv(), turn});
        return Math(HDS_MATH_HSV_TO_RGB, {Math(HDS_MATH_MULTIPLY, {hsv, scale})});
    }

    /// Of scalars, or of vectors that fill the components one after another.
    ShaderValue CombineNode() {
        std::vector<ShaderValue> parts;
        const char* const inputs[] = {"in1", "in2", "in3", "in4"};
        const std::size_t count = _id.category.back() - '0';
        for (std::size_t i = 0; i < count; ++i) {
            const ShaderValue in = In(inputs[i], 0.0F);
            for (std::uint32_t k = 0; k < in.numComponents; ++k) {
                parts.push_back(Channel(in, k));
            }
        }
        parts.resize(4, MakeScalar(0.0F));
        return Combine(parts[0], parts[1], parts[2], parts[3], _n);
    }
    ShaderValue Extract() {
        const ShaderValue index = In("index", 0.0F);
        if (!IsConstant(index)) {
            _network.Warn("the index of " + _node.path + " varies; 0 is used");
        }
        const float number = IsConstant(index) ? ConstantOf(index)[0] : 0.0F;
        return Channel(In("in", 0.0F), static_cast<std::uint32_t>(std::clamp(number, 0.0F, 3.0F)));
    }
    ShaderValue Separate(const std::string& output) {
        static const std::string kNames = "rgbaxyzw";
        const std::size_t channel = output.size() == 4 ? kNames.find(output[3]) : std::string::npos;
        if (channel == std::string::npos) {
            _network.Warn(_node.path + " has no output " + output);
            return {};
        }
        return Channel(In("in", 0.0F), static_cast<std::uint32_t>(channel % 4));
    }
    ShaderValue Convert() {
        ShaderValue in = In("in", 0.0F);
        if (in.numComponents == 3 && _n == 4) {
            return Combine(Channel(in, 0), Channel(in, 1), Channel(in, 2), MakeScalar(1.0F), 4);
        }
        if (in.numComponents == 2 && _n > 2) {
            return Combine(Channel(in, 0), Channel(in, 1), MakeScalar(0.0F), MakeScalar(0.0F), _n);
        }
        if (_n == 1) {
            return Channel(in, 0);
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
                parts.push_back(Channel(in, static_cast<std::uint32_t>(channel % 4)));
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
        return Combine(parts[0], parts[1], parts[2], parts[3], _n);
    }

    ShaderValue If() {
        const std::uint32_t code = _id.category == "ifgreater"     ? HDS_MATH_GREATER
                                   : _id.category == "ifgreatereq" ? HDS_MATH_GREATER_OR_EQUAL
                                                                   : HDS_MATH_EQUAL;
        const float first = code == HDS_MATH_EQUAL ? 0.0F : 1.0F;
        const ShaderValue condition = MakeMath(code, {In("value1", first), In("value2", 0.0F)}, 1);
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
        return Clamp(Channel(Coordinates(), channel), MakeScalar(0.0F), MakeScalar(1.0F), 1);
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
            HDS_MATH_GREATER_OR_EQUAL, {Channel(Coordinates(), channel), In("center", 0.5F)}, 1);
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
        const ShaderValue sum = MakeMath(HDS_MATH_ADD, {Channel(cell, 0), Channel(cell, 1)}, 1);
        const ShaderValue odd = MakeMath(HDS_MATH_MODULO, {sum, MakeScalar(2.0F)}, 1);
        return Math(HDS_MATH_MIX, {In("color2", 0.0F), In("color1", 1.0F), odd});
    }

    bool IsIn3d() const { return _id.category.find("3d") != std::string::npos; }
    ShaderValue Place() { return IsIn3d() ? PositionInput() : Coordinates(); }
    ShaderValue Noise() {
        const std::uint32_t code =
            _n == 1 ? (IsIn3d() ? HDS_MATH_NOISE3 : HDS_MATH_NOISE2)
                    : (IsIn3d() ? HDS_MATH_NOISE3_VECTOR : HDS_MATH_NOISE2_VECTOR);
        const ShaderValue scaled =
            Math(HDS_MATH_MULTIPLY, {Math(code, {Place()}), In("amplitude", 1.0F)});
        return Math(HDS_MATH_ADD, {scaled, In("pivot", 0.0F)});
    }
    ShaderValue Fractal() {
        const std::uint32_t code = _n == 1 ? HDS_MATH_FRACTAL3 : HDS_MATH_FRACTAL3_VECTOR;
        const ShaderValue sum = Math(code, {PositionInput(), In("octaves", 3.0F),
                                            In("lacunarity", 2.0F), In("diminish", 0.5F)});
        return Math(HDS_MATH_MULTIPLY, {sum, In("amplitude", 1.0F)});
    }
    ShaderValue CellNoise() { return Math(IsIn3d() ? HDS_MATH_CELL3 : HDS_MATH_CELL2, {Place()}); }

    ShaderValue Blend() {
        const ShaderValue fg = In("fg", 0.0F);
        const ShaderValue bg = In("bg", 0.0F);
        const ShaderValue one = MakeScalar(1.0F);
        ShaderValue result;
        if (_id.category == "plus") {
            result = Math(HDS_MATH_ADD, {bg, fg});
        } else if (_id.category == "minus") {
            result = Math(HDS_MATH_SUBTRACT, {bg, fg});
        } else if (_id.category == "difference") {
            result = Math(HDS_MATH_ABS, {Math(HDS_MATH_SUBTRACT, {bg, fg})});
        } else {
            const ShaderValue product =
                Math(HDS_MATH_MULTIPLY,
                     {Math(HDS_MATH_SUBTRACT, {one, bg}), Math(HDS_MATH_SUBTRACT, {one, fg})});
            result = Math(HDS_MATH_SUBTRACT, {one, product});
        }
        return Math(HDS_MATH_MIX, {bg, result, In("mix", 1.0F)});
    }
    ShaderValue Mask() {
        const ShaderValue mask = In("mask", _id.category == "inside" ? 1.0F : 0.0F);
        const ShaderValue share = _id.category == "inside"
                                      ? mask
                                      : MakeMath(HDS_MATH_SUBTRACT, {MakeScalar(1.0F), mask}, 1);
        return Math(HDS_MATH_MULTIPLY, {In("in", 0.0F), share});
    }

    NetworkEvaluator& _network;
    const MaterialNode& _node;
    NodeId _id;
    std::uint32_t _n; ///< components of the result
};

ShaderValue NetworkEvaluator::EvaluatePattern(const MaterialNode& node, const std::string& output) {
    const std::string& id = node.identifier;
    if (id.compare(0, 15, "ND_UsdUVTexture") == 0) {
        return EvaluateTexture(node, output);
    }
    if (id.compare(0, 17, "ND_UsdTransform2d") == 0) {
        return EvaluateTransform2d(node);
    }
    if (id.compare(0, 20, "ND_UsdPrimvarReader_") == 0) {
        return EvaluateReader(node);
    }
    const auto key = std::make_pair(node.path, output);
    const auto known = _patterns.find(key);
    if (known != _patterns.end()) {
        return known->second;
    }
    const ShaderValue value = PatternEvaluator(*this, node).Evaluate(output);
    _patterns[key] = value;
    return value;
}

} // namespace hds
