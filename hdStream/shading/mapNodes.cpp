// SPDX-License-Identifier: Apache-2.0
// MaterialX's nodes that look images up elsewhere than at coordinates: by a direction, and on tiles
// at random. Definitions: MaterialX 1.39, stdlib_ng.mtlx and the text of hextiledimage and
// hextilednormalmap. The table of what there is: docs/materials.md.
#include "hdStream/shading/patternNode.h"

namespace hds {

namespace {

class MapNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    static ShaderValue Scalar(std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
        return MakeMath(code, {a, b}, 1);
    }
    static ShaderValue Product(const ShaderValue& a, const ShaderValue& b) {
        return Scalar(HDS_MATH_MULTIPLY, a, b);
    }
    static ShaderValue Sum(const ShaderValue& a, const ShaderValue& b) {
        return Scalar(HDS_MATH_ADD, a, b);
    }

    ShaderValue LatLong() {
        _n = 3;
        const ShaderValue direction = Vector("viewdir", {0.0F, 0.0F, 1.0F, 0.0F}, 3);
        const ShaderValue half = MakeScalar(0.5F);
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue turn =
            Scalar(HDS_MATH_ATAN2, ChannelOf(direction, 0), ChannelOf(direction, 2));
        const ShaderValue longitude = Sum(Product(In("rotation", 0.0F), MakeScalar(0.00277778F)),
                                          Sum(Product(turn, MakeScalar(-0.15915494F)), half));
        const ShaderValue latitude = Sum(
            Product(MakeMath(HDS_MATH_ASIN, {ChannelOf(direction, 1)}, 1), MakeScalar(0.31830989F)),
            half);
        const ShaderValue st = CombineChannels(longitude, latitude, zero, zero, 2);
        ImageRequest request{st, 3};
        request.wraps = HDS_LOOKUP_WRAPS(HDS_WRAP_REPEAT, HDS_WRAP_MIRROR);
        return _network.EvaluateImage(_node, request);
    }

    /// The least of a range and how much there is above it, scaled.
    std::pair<ShaderValue, ShaderValue> Range(const char* input, const std::array<float, 4>& range,
                                              const char* amount, float unit) {
        const ShaderValue value = Vector(input, range, 2);
        const ShaderValue least = Product(ChannelOf(value, 0), MakeScalar(unit));
        const ShaderValue most = Product(ChannelOf(value, 1), MakeScalar(unit));
        return {least, Product(Scalar(HDS_MATH_SUBTRACT, most, least), In(amount, 1.0F))};
    }
    /// Weights whose sum is 1, with Schlick's gain. \param falloff its parameter
    ShaderValue Blend(const ShaderValue& weights, const ShaderValue& falloff) const {
        const auto math = [](std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
            return MakeMath(code, {a, b}, 3);
        };
        const ShaderValue one = MakeScalar(1.0F);
        const auto shares = [&](const ShaderValue& w) {
            return math(HDS_MATH_DIVIDE, w,
                        DotProduct(w, MakeConstant({1.0F, 1.0F, 1.0F, 0.0F}, 3), 3));
        };
        const ShaderValue x = shares(weights);
        if (IsAll(falloff, 0.5F)) {
            return x;
        }
        const ShaderValue r = ClampTo(falloff, MakeScalar(0.001F), MakeScalar(0.999F), 1);
        const ShaderValue slope =
            Scalar(HDS_MATH_SUBTRACT, Scalar(HDS_MATH_DIVIDE, one, r), MakeScalar(2.0F));
        const ShaderValue twice = math(HDS_MATH_MULTIPLY, x, MakeScalar(2.0F));
        const ShaderValue a = math(HDS_MATH_MULTIPLY, math(HDS_MATH_SUBTRACT, one, twice), slope);
        const ShaderValue low = math(HDS_MATH_DIVIDE, x, math(HDS_MATH_ADD, a, one));
        const ShaderValue high =
            math(HDS_MATH_DIVIDE, math(HDS_MATH_SUBTRACT, a, x), math(HDS_MATH_SUBTRACT, a, one));
        const ShaderValue isLow = math(HDS_MATH_GREATER, MakeScalar(0.5F), x);
        return shares(MakeMath(HDS_MATH_SELECT, {isLow, low, high}, 3));
    }

    /// The image at one of the three tiles around a point.
    struct Hextile {
        ShaderValue color;
        ShaderValue share;
        ShaderValue angle;
    };
    std::array<Hextile, 3> Hextiles(std::uint32_t numComponents,
                                    const std::array<float, 4>& fallback) {
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue st = MakeMath(
            HDS_MATH_MULTIPLY, {Coordinates(), Vector("tiling", {1.0F, 1.0F, 0.0F, 0.0F}, 2)}, 2);
        const auto [turn, turns] =
            Range("rotationrange", {0.0F, 360.0F, 0.0F, 0.0F}, "rotation", kDegree);
        const auto [least, scales] = Range("scalerange", {0.5F, 2.0F, 0.0F, 0.0F}, "scale", 1.0F);
        const ShaderValue scale =
            Sum(one, Product(In("scale", 1.0F), Scalar(HDS_MATH_SUBTRACT, least, one)));
        const auto [offset, offsets] =
            Range("offsetrange", {0.0F, 1.0F, 0.0F, 0.0F}, "offset", 1.0F);
        const ShaderValue spread = CombineChannels(turn, turns, scale, scales, 4);
        std::array<Hextile, 3> tiles;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const ShaderValue move =
                CombineChannels(offset, offsets, MakeScalar(static_cast<float>(k)), zero, 4);
            const ShaderValue tile = MakeMath(HDS_MATH_HEXTILE, {st, spread, move}, 4);
            ShaderValue place = tile;
            place.numComponents = 2;
            ImageRequest request{place, numComponents, "file", fallback};
            request.number = k;
            request.isPeriodic = true;
            tiles[k] = {_network.EvaluateImage(_node, request),
                        Scalar(HDS_MATH_POWER, ChannelOf(tile, 2), MakeScalar(7.0F)),
                        ChannelOf(tile, 3)};
        }
        return tiles;
    }
    ShaderValue Hextiled() {
        constexpr std::array<float, 4> kLuminance{0.2722287F, 0.6740818F, 0.0536895F, 0.0F};
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue one = MakeScalar(1.0F);
        const std::array<Hextile, 3> tiles = Hextiles(_n, {});
        const ShaderValue contrast = In("falloffcontrast", 0.5F);
        const ShaderValue lumaCoeffs = Vector("lumacoeffs", kLuminance, 3);
        ShaderValue lights[3];
        for (std::uint32_t k = 0; k < 3; ++k) {
            lights[k] =
                Product(tiles[k].share,
                        MakeMath(HDS_MATH_MIX,
                                 {one, DotProduct(tiles[k].color, lumaCoeffs, 3), contrast}, 1));
        }
        const ShaderValue falloff = In("falloff", 0.5F);
        const ShaderValue weights =
            Blend(CombineChannels(lights[0], lights[1], lights[2], zero, 3), falloff);
        const auto blended = [&](const ShaderValue& by) {
            ShaderValue sum = Multiply(tiles[0].color, ChannelOf(by, 0));
            sum = Add(sum, Multiply(tiles[1].color, ChannelOf(by, 1)));
            return Add(sum, Multiply(tiles[2].color, ChannelOf(by, 2)));
        };
        const ShaderValue color = blended(weights);
        if (_n != 4) {
            return color;
        }
        const ShaderValue alpha = blended(Blend(SharesOf(tiles), falloff));
        return CombineChannels(ChannelOf(color, 0), ChannelOf(color, 1), ChannelOf(color, 2),
                               ChannelOf(alpha, 3), 4);
    }
    static ShaderValue SharesOf(const std::array<Hextile, 3>& tiles) {
        return CombineChannels(tiles[0].share, tiles[1].share, tiles[2].share, MakeScalar(0.0F), 3);
    }

    /// In tangent space, as normalmap. Slopes of the three tiles, each turned as its tile is, are
    /// added by their weights.
    ShaderValue HextiledNormal() {
        const std::array<Hextile, 3> tiles = Hextiles(3, {0.5F, 0.5F, 1.0F, 0.0F});
        const ShaderValue weights = Blend(SharesOf(tiles), In("falloff", 0.5F));
        const ShaderValue strength = In("strength", 1.0F);
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue up =
            MakeMath(HDS_MATH_MIX, {one, MakeScalar(-1.0F), In("flip_g", 0.0F)}, 1);
        const auto part = [&](const Hextile& tile, std::uint32_t channel) {
            return Scalar(HDS_MATH_SUBTRACT,
                          Product(ChannelOf(tile.color, channel), MakeScalar(2.0F)), one);
        };
        ShaderValue slopes[2] = {zero, zero};
        for (std::uint32_t k = 0; k < 3; ++k) {
            const ShaderValue x = part(tiles[k], 0);
            const ShaderValue y = Product(part(tiles[k], 1), up);
            const ShaderValue height = Scalar(
                HDS_MATH_MAX, MakeMath(HDS_MATH_ABS, {part(tiles[k], 2)}, 1), MakeScalar(1e-6F));
            const ShaderValue weight =
                Scalar(HDS_MATH_DIVIDE, Product(ChannelOf(weights, k), strength), height);
            const ShaderValue sine = MakeMath(HDS_MATH_SIN, {tiles[k].angle}, 1);
            const ShaderValue cosine = MakeMath(HDS_MATH_COS, {tiles[k].angle}, 1);
            const ShaderValue alongS =
                Scalar(HDS_MATH_SUBTRACT, Product(x, cosine), Product(y, sine));
            const ShaderValue alongT = Sum(Product(x, sine), Product(y, cosine));
            slopes[0] = Sum(slopes[0], Product(weight, alongS));
            slopes[1] = Sum(slopes[1], Product(weight, alongT));
        }
        return MakeMath(HDS_MATH_NORMALIZE, {CombineChannels(slopes[0], slopes[1], one, zero, 3)},
                        3);
    }
};

constexpr PatternType kTypes[] = {
    {"latlongimage", kPattern<&MapNode::LatLong>},
    {"hextiledimage", kPattern<&MapNode::Hextiled>},
    {"hextilednormalmap", kPattern<&MapNode::HextiledNormal>},
};

} // namespace

PatternTable MapNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
