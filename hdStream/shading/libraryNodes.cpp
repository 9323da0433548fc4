// SPDX-License-Identifier: Apache-2.0
// Nodes that MaterialX's library builds of others, as expressions: their node graphs are in
// stdlib_ng.mtlx, nprlib_ng.mtlx and gltf_pbr.mtlx of MaterialX 1.39. Beside them geometry, slopes
// of heights, and noise by cells; colours are in colorNodes.cpp. The table of what there is:
// docs/materials.md.
#include "hdStream/shading/hostFrame.h"
#include "hdStream/shading/patternNode.h"
#include "hdStream/shading/programWriter.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace hds {

namespace {

using Kind = ShaderExpression::Kind;

constexpr float kSobelScale = 1.0F / 16.0F; ///< of heighttonormal, for parity with Sobel's filter

ShaderValue Scalar(std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
    return MakeMath(code, {a, b}, 1);
}

class LibraryNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    /// `yes` where a > b.
    ShaderValue IfGreater(const ShaderValue& a, const ShaderValue& b, const ShaderValue& yes,
                          const ShaderValue& no) const {
        return Math(HDS_MATH_SELECT, {Scalar(HDS_MATH_GREATER, a, b), yes, no});
    }
    bool IsOn(const char* input) { return !IsAll(In(input, 0.0F), 0.0F); }
    /// One of several values by a number that counts from 0.
    ShaderValue Switch(const ShaderValue& which, std::vector<ShaderValue> values) const {
        ShaderValue result = MakeScalar(0.0F);
        for (std::size_t i = values.size(); i > 0; --i) {
            const ShaderValue isBelow =
                Scalar(HDS_MATH_GREATER, MakeScalar(static_cast<float>(i)), which);
            result = Math(HDS_MATH_SELECT, {isBelow, values[i - 1], result});
        }
        return result;
    }
    ShaderValue LengthOf(const ShaderValue& value, std::uint32_t numComponents) const {
        return MakeMath(HDS_MATH_SQRT, {DotProduct(value, value, numComponents)}, 1);
    }

    // Noise.
    bool IsIn3d() const { return _id.category.find("3d") != std::string::npos; }
    ShaderValue NoisePlace() {
        return IsIn3d() ? GeometryInput("position", Kind::Position) : Coordinates();
    }
    ShaderValue WorleyAt(const ShaderValue& place) {
        const ShaderValue jitter = In("jitter", 1.0F);
        const ShaderValue distances =
            MakeMath(IsIn3d() ? HDS_MATH_WORLEY3 : HDS_MATH_WORLEY2, {place, jitter}, 4);
        ShaderValue cell;
        ShaderValue distance;
        if (_n == 1) {
            distance = SelectChannel(distances, 0);
            cell = SelectChannel(distances, 3);
        } else {
            distance = distances;
            cell = MakeMath(IsIn3d() ? HDS_MATH_WORLEY3_CELL : HDS_MATH_WORLEY2_CELL,
                            {place, jitter}, 4);
        }
        const ShaderValue isSolid = Scalar(HDS_MATH_EQUAL, In("style", 0.0F), MakeScalar(1.0F));
        ShaderValue result = Math(HDS_MATH_SELECT, {isSolid, cell, distance});
        result.numComponents = _n;
        return result;
    }
    ShaderValue Worley() { return WorleyAt(NoisePlace()); }
    ShaderValue FractalOf(std::uint32_t code, const ShaderValue& place) {
        return Math(code,
                    {place, In("octaves", 3.0F), In("lacunarity", 2.0F), In("diminish", 0.5F)});
    }
    ShaderValue Fractal2d() {
        const std::uint32_t code = _n == 1 ? HDS_MATH_FRACTAL2 : HDS_MATH_FRACTAL2_VECTOR;
        return Multiply(FractalOf(code, Coordinates()), In("amplitude", 1.0F));
    }
    ShaderValue UnifiedNoise() {
        const std::uint32_t count = IsIn3d() ? 3 : 2;
        const auto math = [&](std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
            return MakeMath(code, {a, b}, count);
        };
        const ShaderValue scaled =
            math(HDS_MATH_MULTIPLY, NoisePlace(), Vector("freq", {1.0F, 1.0F, 1.0F, 0.0F}, count));
        const ShaderValue place = math(HDS_MATH_ADD, scaled, Vector("offset", {}, count));
        const ShaderValue angle =
            Multiply(Subtract(In("jitter", 1.0F), MakeScalar(1.0F)), MakeScalar(90000.0F));
        const ShaderValue turned =
            IsIn3d() ? RotateAbout(place, angle, MakeConstant({0.1F, 1.0F, 0.0F, 0.0F}, 3))
                     : Rotate2d(place, angle);
        const ShaderValue half = MakeScalar(0.5F);
        const ShaderValue perlin =
            Add(Multiply(Math(IsIn3d() ? HDS_MATH_NOISE3 : HDS_MATH_NOISE2, {turned}), half), half);
        const ShaderValue inFractal =
            IsIn3d() ? turned
                     : CombineChannels(ChannelOf(place, 0), ChannelOf(place, 1), angle,
                                       MakeScalar(0.0F), 3);
        const ShaderValue noise = Switch(
            In("type", 0.0F), {perlin, Math(IsIn3d() ? HDS_MATH_CELL3 : HDS_MATH_CELL2, {turned}),
                               WorleyAt(place), FractalOf(HDS_MATH_FRACTAL3, inFractal)});
        return RangeTo(noise, MakeScalar(0.0F), MakeScalar(1.0F), MakeScalar(1.0F),
                       In("outmin", 0.0F), In("outmax", 1.0F), In("clampoutput", 1.0F));
    }
    /// Of randomfloat, with its seed.
    ShaderValue Random(const ShaderValue& seed) {
        const ShaderValue in =
            MakeMath(HDS_MATH_MULTIPLY, {In("in", 0.0F), MakeScalar(4096.0F)}, 1);
        const ShaderValue zero = MakeScalar(0.0F);
        return MakeMath(HDS_MATH_CELL2, {CombineChannels(in, seed, zero, zero, 2)}, 1);
    }
    ShaderValue RandomFloat() {
        const ShaderValue low = In("min", 0.0F);
        const ShaderValue high = In("max", 1.0F);
        return RangeTo(Random(In("seed", 0.0F)), MakeScalar(0.0F), MakeScalar(1.0F),
                       MakeScalar(1.0F), low, high, MakeScalar(1.0F));
    }
    ShaderValue RandomColor() {
        _n = 3; // its id names the type of `in`
        const auto part = [&](float offset, const char* low, float lowDefault, const char* high) {
            const ShaderValue moved = Scalar(HDS_MATH_ADD, In("seed", 0.0F), MakeScalar(offset));
            return MakeMath(
                HDS_MATH_MIX,
                {In(low, lowDefault), In(high, 1.0F), Random(MakeMath(HDS_MATH_CEIL, {moved}, 1))},
                1);
        };
        const ShaderValue hsv = CombineChannels(
            part(413.3F, "huelow", 0.0F, "huehigh"),
            part(1522.4F, "saturationlow", 0.825F, "saturationhigh"),
            part(1813.8F, "brightnesslow", 1.0F, "brightnesshigh"), MakeScalar(0.0F), 3);
        return Math(HDS_MATH_HSV_TO_RGB, {hsv});
    }

    // Grids and ramps.
    ShaderValue Grid() {
        const auto at = [&](const char* input, float value) {
            return Vector(input, {value, value, 0.0F, 0.0F}, 2);
        };
        const ShaderValue st =
            MakeMath(HDS_MATH_SUBTRACT,
                     {MakeMath(HDS_MATH_MULTIPLY, {Coordinates(), at("uvtiling", 1.0F)}, 2),
                      at("uvoffset", 0.0F)},
                     2);
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue zero = MakeScalar(0.0F);
        ShaderValue s = ChannelOf(st, 0);
        const ShaderValue t = ChannelOf(st, 1);
        if (IsOn("staggered")) {
            const ShaderValue row = Scalar(HDS_MATH_MODULO, t, MakeScalar(2.0F));
            const ShaderValue isOdd = Scalar(HDS_MATH_GREATER, row, one);
            s = Scalar(HDS_MATH_ADD, s,
                       MakeMath(HDS_MATH_SELECT, {isOdd, MakeScalar(0.5F), zero}, 1));
        }
        const ShaderValue inside = Scalar(HDS_MATH_SUBTRACT, one, In("thickness", 0.05F));
        const auto isInside = [&](const ShaderValue& x) {
            const ShaderValue cell = Scalar(HDS_MATH_MODULO, x, one);
            const ShaderValue moved =
                Scalar(HDS_MATH_SUBTRACT, Scalar(HDS_MATH_MULTIPLY, cell, MakeScalar(2.0F)), one);
            const ShaderValue distance = MakeMath(HDS_MATH_ABS, {moved}, 1);
            return MakeMath(HDS_MATH_SELECT,
                            {Scalar(HDS_MATH_GREATER, distance, inside), zero, one}, 1);
        };
        return OneMinus(Math(HDS_MATH_MIN, {isInside(s), isInside(t)}));
    }
    /// ramp_gradient: an interval of a ramp, \p before below it.
    ShaderValue Interval(const ShaderValue& x, const ShaderValue& low, const ShaderValue& high,
                         const ShaderValue& from, const ShaderValue& to,
                         const ShaderValue& before) {
        const ShaderValue linear =
            Scalar(HDS_MATH_DIVIDE, Scalar(HDS_MATH_SUBTRACT, ClampTo(x, low, high, 1), low),
                   Scalar(HDS_MATH_SUBTRACT, high, low));
        const ShaderValue smooth = MakeMath(HDS_MATH_SMOOTHSTEP, {x, low, high}, 1);
        const ShaderValue value =
            Switch(In("interpolation", 1.0F),
                   {Mix(from, to, linear), Mix(from, to, smooth), IfGreater(high, x, from, to)});
        return IfGreater(x, low, value, before);
    }
    static constexpr std::array<float, 4> kWhite{1.0F, 1.0F, 1.0F, 1.0F};
    static constexpr std::array<float, 4> kBlack{0.0F, 0.0F, 0.0F, 1.0F};
    ShaderValue RampGradient() {
        _n = 4;
        const ShaderValue before = Vector("prev_color", kBlack, 4);
        return Math(
            HDS_MATH_SELECT,
            {Scalar(HDS_MATH_GREATER_OR_EQUAL, In("interval_num", 1.0F), In("num_intervals", 2.0F)),
             before,
             Interval(In("x", 0.0F), In("interval1", 0.0F), In("interval2", 1.0F),
                      Vector("color1", kBlack, 4), Vector("color2", kWhite, 4), before)});
    }
    ShaderValue Ramp() {
        _n = 4;
        const ShaderValue x = RampPosition();
        const ShaderValue count = In("num_intervals", 2.0F);
        ShaderValue result = Vector("color1", kBlack, 4);
        ShaderValue from = result;
        ShaderValue low = In("interval1", 0.0F);
        for (int i = 1; i < 10; ++i) {
            const ShaderValue isPast =
                Scalar(HDS_MATH_GREATER_OR_EQUAL, MakeScalar(static_cast<float>(i)), count);
            if (IsAll(isPast, 1.0F)) {
                break;
            }
            const std::string number = std::to_string(i + 1);
            const ShaderValue high = In("interval" + number, 1.0F);
            const ShaderValue to = Vector("color" + number, kWhite, 4);
            result =
                Math(HDS_MATH_SELECT, {isPast, result, Interval(x, low, high, from, to, result)});
            from = to;
            low = high;
        }
        return result;
    }
    /// Along the ramp: across, around, from the middle out in circles or in boxes.
    ShaderValue RampPosition() {
        const ShaderValue st = Coordinates();
        const ShaderValue moved = MakeMath(HDS_MATH_SUBTRACT, {st, MakeScalar(0.5F)}, 2);
        const ShaderValue x = ChannelOf(moved, 0);
        const ShaderValue y = ChannelOf(moved, 1);
        const ShaderValue turns =
            Scalar(HDS_MATH_ADD,
                   Scalar(HDS_MATH_DIVIDE, Scalar(HDS_MATH_ATAN2, x, y), MakeScalar(6.28319F)),
                   MakeScalar(0.5F));
        const ShaderValue distance =
            Scalar(HDS_MATH_MULTIPLY, LengthOf(moved, 2), MakeScalar(1.414F));
        const ShaderValue box = Scalar(
            HDS_MATH_MULTIPLY,
            Scalar(HDS_MATH_MAX, MakeMath(HDS_MATH_ABS, {x}, 1), MakeMath(HDS_MATH_ABS, {y}, 1)),
            MakeScalar(2.0F));
        return Switch(In("type", 0.0F), {ChannelOf(st, 0), turns, distance, box});
    }

    // What the host knows.
    ShaderValue Frame() {
        const ShaderValue frame = _network.Evaluate(_node, kFrameInput);
        if (!frame) {
            _network.Warn("asks for the frame, which is not known: it counts as 0");
            return MakeScalar(0.0F);
        }
        return frame;
    }
    /// In seconds.
    ShaderValue Time() { return Scalar(HDS_MATH_DIVIDE, Frame(), In("fps", 24.0F)); }

    // Geometry.
    /// \tparam kDirection 0 or HDS_TANGENT_ACROSS
    template <std::uint32_t kDirection>
    ShaderValue Tangent() {
        const ShaderValue index = In("index", 0.0F);
        const int number = IsConstant(index) ? static_cast<int>(ConstantOf(index)[0]) : 0;
        return MakeGeometry(
            Kind::Tangent, Space() | kDirection,
            {number == 0 ? Coordinates()
                         : MakePrimvar("st" + std::to_string(number), MakeConstant({}, 2), 2)});
    }
    static ShaderValue View() { return MakeGeometry(Kind::View, 0); }
    ShaderValue FacingRatio() {
        const ShaderValue authored = _network.Evaluate(_node, "viewdirection");
        const ShaderValue normal = _network.Evaluate(_node, "normal");
        auto ownNormal = std::make_shared<ShaderExpression>();
        ownNormal->kind = Kind::Normal;
        ownNormal->code = HDS_SPACE_WORLD;
        const ShaderValue cosine =
            DotProduct(authored ? authored : View(),
                       normal ? normal : ShaderValue{std::move(ownNormal), HDS_CHANNEL_ALL, 3}, 3);
        const ShaderValue facing = IsAll(In("faceforward", 1.0F), 0.0F)
                                       ? Multiply(cosine, MakeScalar(-1.0F))
                                       : Math(HDS_MATH_ABS, {cosine});
        return IsOn("invert") ? OneMinus(facing) : facing;
    }

    /// Gooch et al. 1998: warm where the light does not come from, and a highlight.
    ShaderValue GoochShade() {
        _n = 3;
        const auto unit = [](const ShaderValue& value) {
            return MakeMath(HDS_MATH_NORMALIZE, {value}, 3);
        };
        auto ownNormal = std::make_shared<ShaderExpression>();
        ownNormal->kind = Kind::Normal;
        ownNormal->code = HDS_SPACE_WORLD;
        const ShaderValue normal = unit({std::move(ownNormal), HDS_CHANNEL_ALL, 3});
        const ShaderValue view = unit(View());
        const ShaderValue light = unit(Vector("light_direction", {1.0F, -0.5F, -0.5F, 0.0F}, 3));
        const ShaderValue cool = Scalar(
            HDS_MATH_DIVIDE, Scalar(HDS_MATH_ADD, MakeScalar(1.0F), DotProduct(normal, light, 3)),
            MakeScalar(2.0F));
        const ShaderValue color = Mix(Vector("warm_color", {0.8F, 0.8F, 0.7F, 1.0F}, 3),
                                      Vector("cool_color", {0.3F, 0.3F, 0.8F, 1.0F}, 3), cool);
        const ShaderValue twice =
            Scalar(HDS_MATH_MULTIPLY, DotProduct(normal, view, 3), MakeScalar(2.0F));
        const ShaderValue reflected = Subtract(view, Multiply(normal, twice));
        const ShaderValue cosine =
            Scalar(HDS_MATH_MAX,
                   Scalar(HDS_MATH_MULTIPLY, DotProduct(light, reflected, 3), MakeScalar(-1.0F)),
                   MakeScalar(0.0F));
        return Add(color,
                   Scalar(HDS_MATH_MULTIPLY, Scalar(HDS_MATH_POWER, cosine, In("shininess", 64.0F)),
                          In("specular_intensity", 1.0F)));
    }

    static ShaderValue ShiftedTo(std::uint32_t direction, const ShaderValue& value,
                                 const ShaderValue& coordinates) {
        auto expression = std::make_shared<ShaderExpression>();
        expression->kind = Kind::Shifted;
        expression->code = direction;
        expression->operands = {value, coordinates};
        return {std::move(expression), HDS_CHANNEL_ALL, 1};
    }
    /// The encoded tangent-space normal of a height, by its slopes along the coordinates.
    ShaderValue NormalOf(const char* input, const ShaderValue& scale) {
        const ShaderValue flat = MakeConstant({0.5F, 0.5F, 1.0F, 0.0F}, 3);
        const ShaderValue height = In(input, 0.0F);
        if (IsConstant(height)) {
            return flat;
        }
        if (HasSlope(height)) {
            _network.Warn("the height of " + _node.path +
                          " depends on the slope of another; it is taken as flat");
            return flat;
        }
        const ShaderValue st = Coordinates();
        const auto slope = [&](std::uint32_t direction) {
            const ShaderValue rise =
                Scalar(HDS_MATH_SUBTRACT, ShiftedTo(direction | HDS_SHIFT_MINUS, height, st),
                       ShiftedTo(direction, height, st));
            return Scalar(
                HDS_MATH_MULTIPLY,
                Scalar(HDS_MATH_MULTIPLY, rise, MakeScalar(kSobelScale * 0.5F / HDS_SHIFT_STEP)),
                scale);
        };
        const ShaderValue normal =
            MakeMath(HDS_MATH_NORMALIZE,
                     {CombineChannels(slope(HDS_SHIFT_S), slope(HDS_SHIFT_T), MakeScalar(1.0F),
                                      MakeScalar(0.0F), 3)},
                     3);
        const ShaderValue half = MakeScalar(0.5F);
        return MakeMath(HDS_MATH_ADD, {MakeMath(HDS_MATH_MULTIPLY, {normal, half}, 3), half}, 3);
    }
    ShaderValue HeightToNormal() { return NormalOf("in", In("scale", 1.0F)); }
    /// In tangent space, as normalmap.
    ShaderValue Bump() {
        return SignedNormal(NormalOf("height", MakeScalar(1.0F)), In("scale", 1.0F));
    }

    /// Its input, which is all that it is by default; more is left out.
    ShaderValue Blur() {
        if (!IsAll(In("size", 0.0F), 0.0F)) {
            _network.Warn("blur of " + _node.path + " is left out; its input is shown as it is");
        }
        return Vector("in", {}, _n);
    }

    ShaderValue Triplanar() {
        const ShaderValue position = GeometryInput("position", Kind::Position);
        const ShaderValue normal = GeometryInput("normal", Kind::Normal);
        const ShaderValue axis = In("upaxis", 2.0F);
        const int up = IsConstant(axis) ? static_cast<int>(ConstantOf(axis)[0]) : 2;
        const ShaderValue zero = MakeScalar(0.0F);
        const auto pair = [&](std::uint32_t s, std::uint32_t t, bool isMirrored) {
            ShaderValue first = ChannelOf(position, s);
            if (isMirrored) {
                first = Scalar(HDS_MATH_MULTIPLY, first, MakeScalar(-1.0F));
            }
            return CombineChannels(first, ChannelOf(position, t), zero, zero, 2);
        };
        const ShaderValue places[] = {up == 2 ? pair(1, 2, false) : pair(2, 1, false),
                                      up == 0 ? pair(2, 0, false) : pair(0, 2, false),
                                      up == 0 ? pair(1, 0, true) : pair(0, 1, false)};
        const auto shares = [&](const ShaderValue& weights) {
            const ShaderValue sum =
                DotProduct(weights, MakeConstant({1.0F, 1.0F, 1.0F, 0.0F}, 3), 3);
            return MakeMath(HDS_MATH_DIVIDE, {weights, sum}, 3);
        };
        const ShaderValue sides =
            shares(MakeMath(HDS_MATH_ABS, {MakeMath(HDS_MATH_NORMALIZE, {normal}, 3)}, 3));
        const ShaderValue blend =
            ClampTo(In("blend", 1.0F), MakeScalar(0.03F), MakeScalar(1.0F), 1);
        const ShaderValue weights = shares(
            MakeMath(HDS_MATH_POWER, {sides, Scalar(HDS_MATH_DIVIDE, MakeScalar(1.0F), blend)}, 3));
        const char* const files[] = {"filex", "filey", "filez"};
        ShaderValue sum = MakeScalar(0.0F);
        for (std::uint32_t k = 0; k < 3; ++k) {
            ImageRequest request{places[k], _n, files[k]};
            request.isPeriodic = true;
            const ShaderValue image = Spread(_network.EvaluateImage(_node, request));
            sum = Add(sum, Multiply(image, ChannelOf(weights, k)));
        }
        return sum;
    }

    // Vectors and numbers.
    /// Rodrigues' formula, clockwise.
    static ShaderValue RotateAbout(const ShaderValue& in, const ShaderValue& degrees,
                                   const ShaderValue& axis) {
        const auto math = [](std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
            return MakeMath(code, {a, b}, 3);
        };
        const ShaderValue unit = MakeMath(HDS_MATH_NORMALIZE, {axis}, 3);
        const ShaderValue angle = Scalar(HDS_MATH_MULTIPLY, Spread(degrees), MakeScalar(kDegree));
        const ShaderValue c = MakeMath(HDS_MATH_COS, {angle}, 1);
        const ShaderValue s = MakeMath(HDS_MATH_SIN, {angle}, 1);
        const ShaderValue along = Scalar(HDS_MATH_MULTIPLY, DotProduct(unit, in, 3),
                                         Scalar(HDS_MATH_SUBTRACT, MakeScalar(1.0F), c));
        const ShaderValue turned = math(HDS_MATH_ADD, math(HDS_MATH_MULTIPLY, in, c),
                                        math(HDS_MATH_MULTIPLY, math(HDS_MATH_CROSS, in, unit), s));
        return math(HDS_MATH_ADD, turned, math(HDS_MATH_MULTIPLY, unit, along));
    }
    ShaderValue Rotate3d() {
        return RotateAbout(Vector("in", {}, 3), In("amount", 0.0F),
                           Vector("axis", {0.0F, 1.0F, 0.0F, 0.0F}, 3));
    }
    ShaderValue Reflect() {
        const ShaderValue in = Vector("in", {1.0F, 0.0F, 0.0F, 0.0F}, 3);
        const ShaderValue normal = GeometryInput("normal", Kind::Normal);
        const ShaderValue twice =
            Scalar(HDS_MATH_MULTIPLY, DotProduct(normal, in, 3), MakeScalar(2.0F));
        return Subtract(in, Multiply(normal, twice));
    }
    ShaderValue Refract() {
        const ShaderValue in = Vector("in", {1.0F, 0.0F, 0.0F, 0.0F}, 3);
        const ShaderValue normal = GeometryInput("normal", Kind::Normal);
        const ShaderValue ior = In("ior", 1.0F);
        const ShaderValue cosine = DotProduct(in, normal, 3);
        const ShaderValue one = MakeScalar(1.0F);
        const auto product = [](const ShaderValue& a, const ShaderValue& b) {
            return Scalar(HDS_MATH_MULTIPLY, a, b);
        };
        const ShaderValue left =
            product(product(ior, ior), Scalar(HDS_MATH_SUBTRACT, one, product(cosine, cosine)));
        const ShaderValue k = Scalar(HDS_MATH_SUBTRACT, one, left);
        const ShaderValue scale =
            Scalar(HDS_MATH_ADD, product(ior, cosine), MakeMath(HDS_MATH_SQRT, {k}, 1));
        return IfGreater(MakeScalar(0.0F), k, MakeScalar(0.0F),
                         Subtract(Multiply(in, ior), Multiply(normal, scale)));
    }
    ShaderValue SafePower() {
        const ShaderValue in = In("in1", 0.0F);
        return Multiply(Math(HDS_MATH_SIGN, {in}),
                        Math(HDS_MATH_POWER, {Math(HDS_MATH_ABS, {in}), In("in2", 1.0F)}));
    }
    ShaderValue TriangleWave() {
        const ShaderValue half = MakeScalar(0.5F);
        const ShaderValue phase =
            Math(HDS_MATH_MODULO, {Math(HDS_MATH_ABS, {In("in", 0.0F)}), MakeScalar(1.0F)});
        return Subtract(half, Math(HDS_MATH_ABS, {Subtract(phase, half)}));
    }
    template <std::uint32_t kCode>
    ShaderValue ExtremeComponent() {
        const ShaderValue in = In("in", 0.0F);
        ShaderValue result = ChannelOf(in, 0);
        for (std::uint32_t k = 1; k < _id.firstComponents; ++k) {
            result = Scalar(kCode, result, ChannelOf(in, k));
        }
        return result;
    }

    // Of booleans, 0 and 1.
    ShaderValue Not() {
        _n = 1;
        return OneMinus(In("in", 0.0F));
    }
    template <std::uint32_t kCode>
    ShaderValue Logical() {
        _n = 1;
        const ShaderValue a = In("in1", 0.0F);
        return Math(kCode, {a, In("in2", 0.0F)});
    }
    ShaderValue Xor() { return OneMinus(Logical<HDS_MATH_EQUAL>()); }

    // glTF's images: placed the other way round than place2d.
    ShaderValue GltfImage(std::uint32_t numComponents, const std::array<float, 4>& fallback) {
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue scale =
            MakeMath(HDS_MATH_DIVIDE, {one, Vector("scale", {1.0F, 1.0F, 0.0F, 0.0F}, 2)}, 2);
        const ShaderValue turn = Scalar(HDS_MATH_MULTIPLY, In("rotate", 0.0F), MakeScalar(-1.0F));
        const ShaderValue offset =
            MakeMath(HDS_MATH_MULTIPLY,
                     {Vector("offset", {}, 2), MakeConstant({-1.0F, 1.0F, 0.0F, 0.0F}, 2)}, 2);
        const ShaderValue st = Place(Coordinates(), scale, turn, offset, {0.0F, 1.0F, 0.0F, 0.0F});
        return _network.EvaluateImage(_node, {st, numComponents, "file", fallback});
    }
    ShaderValue GltfNormalMap() {
        return SignedNormal(GltfImage(3, {0.5F, 0.5F, 1.0F, 0.0F}), MakeScalar(1.0F));
    }
    ShaderValue GltfScaledImage() {
        return Multiply(Spread(GltfImage(std::max(_n, 1U), {})), In("factor", 1.0F));
    }
    ShaderValue GltfIridescenceThickness() {
        const ShaderValue share = ChannelOf(GltfImage(3, {}), 1);
        return Mix(In("thicknessMax", 400.0F), In("thicknessMin", 100.0F), share);
    }
    /// A direction in the plane, encoded, and a strength.
    ShaderValue GltfAnisotropyImage() {
        const ShaderValue image = GltfImage(3, {1.0F, 0.5F, 1.0F, 0.0F});
        if (_output == "anisotropy_strength_out") {
            return Scalar(HDS_MATH_MULTIPLY, In("anisotropy_strength", 1.0F), ChannelOf(image, 2));
        }
        const auto part = [&](std::uint32_t channel) {
            return Scalar(HDS_MATH_SUBTRACT,
                          Scalar(HDS_MATH_MULTIPLY, ChannelOf(image, channel), MakeScalar(2.0F)),
                          MakeScalar(1.0F));
        };
        return Scalar(HDS_MATH_ADD, In("anisotropy_rotation", 0.0F),
                      Scalar(HDS_MATH_ATAN2, part(1), part(0)));
    }
    ShaderValue GltfColorImage() {
        _n = 4;
        const std::array<float, 4> white{1.0F, 1.0F, 1.0F, 1.0F};
        const ShaderValue tint = Multiply(Vector("color", white, 4), Vector("geomcolor", white, 4));
        ShaderValue color = Multiply(GltfImage(4, {}), tint);
        if (_output == "outa") {
            return SelectChannel(color, 3);
        }
        color.numComponents = 3;
        return color;
    }
};

constexpr PatternType kTypes[] = {
    {"worleynoise2d", kPattern<&LibraryNode::Worley>},
    {"worleynoise3d", kPattern<&LibraryNode::Worley>},
    {"fractal2d", kPattern<&LibraryNode::Fractal2d>},
    {"unifiednoise2d", kPattern<&LibraryNode::UnifiedNoise>},
    {"unifiednoise3d", kPattern<&LibraryNode::UnifiedNoise>},
    {"randomfloat", kPattern<&LibraryNode::RandomFloat>},
    {"randomcolor", kPattern<&LibraryNode::RandomColor>},
    {"grid", kPattern<&LibraryNode::Grid>},
    {"ramp", kPattern<&LibraryNode::Ramp>},
    {"ramp_gradient", kPattern<&LibraryNode::RampGradient>},
    {"frame", kPattern<&LibraryNode::Frame>},
    {"time", kPattern<&LibraryNode::Time>},
    {"tangent", kPattern<&LibraryNode::Tangent<0>>},
    {"bitangent", kPattern<&LibraryNode::Tangent<HDS_TANGENT_ACROSS>>},
    {"facingratio", kPattern<&LibraryNode::FacingRatio>},
    {"gooch_shade", kPattern<&LibraryNode::GoochShade>},
    {"heighttonormal", kPattern<&LibraryNode::HeightToNormal>},
    {"bump", kPattern<&LibraryNode::Bump>},
    {"blur", kPattern<&LibraryNode::Blur>},
    {"triplanarprojection", kPattern<&LibraryNode::Triplanar>},
    {"rotate3d", kPattern<&LibraryNode::Rotate3d>},
    {"reflect", kPattern<&LibraryNode::Reflect>},
    {"refract", kPattern<&LibraryNode::Refract>},
    {"safepower", kPattern<&LibraryNode::SafePower>},
    {"trianglewave", kPattern<&LibraryNode::TriangleWave>},
    {"mincomponent", kPattern<&LibraryNode::ExtremeComponent<HDS_MATH_MIN>>},
    {"maxcomponent", kPattern<&LibraryNode::ExtremeComponent<HDS_MATH_MAX>>},
    {"and", kPattern<&LibraryNode::Logical<HDS_MATH_MULTIPLY>>, "logical_and"},
    {"or", kPattern<&LibraryNode::Logical<HDS_MATH_MAX>>, "logical_or"},
    {"xor", kPattern<&LibraryNode::Xor>, "logical_xor"},
    {"not", kPattern<&LibraryNode::Not>, "logical_not"},
    {"gltf_image", kPattern<&LibraryNode::GltfScaledImage>},
    {"gltf_colorimage", kPattern<&LibraryNode::GltfColorImage>},
    {"gltf_anisotropy_image", kPattern<&LibraryNode::GltfAnisotropyImage>},
    {"gltf_normalmap", kPattern<&LibraryNode::GltfNormalMap>},
    {"gltf_iridescence_thickness", kPattern<&LibraryNode::GltfIridescenceThickness>},
};

} // namespace

PatternTable LibraryNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
