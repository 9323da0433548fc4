// SPDX-License-Identifier: Apache-2.0
// Helpers of MaterialX's physically based closures: node graphs and definitions of pbrlib 1.39.
#include "hdStream/shading/patternNode.h"

namespace hds {

namespace {

class PbrNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    static ShaderValue Scalar(std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
        return MakeMath(code, {a, b}, 1);
    }
    static ShaderValue Pair(const ShaderValue& x, const ShaderValue& y) {
        return CombineChannels(x, y, MakeScalar(0.0F), MakeScalar(0.0F), 2);
    }
    static ShaderValue Product(const ShaderValue& a, const ShaderValue& b) {
        return Scalar(HDS_MATH_MULTIPLY, a, b);
    }
    static ShaderValue Squared(const ShaderValue& value) {
        return ClampTo(Product(value, value), MakeScalar(1e-8F), MakeScalar(1.0F), 1);
    }

    /// Whether it is that function of scalars.
    static bool IsMath(const ShaderValue& value, std::uint32_t code) {
        return value && value.expression->kind == ShaderExpression::Kind::Math &&
               value.channel == HDS_CHANNEL_ALL && value.expression->numComponents == 1 &&
               value.expression->code == code;
    }
    /// Without a clamp to [0, 1], and one below a mix with 1. The square of a roughness is clamped
    /// anyway, and none is below 0. So roughnesses that differ by it alone are seen to be the same.
    static ShaderValue Unclamped(const ShaderValue& roughness) {
        if (IsMath(roughness, HDS_MATH_MIX)) {
            const std::vector<ShaderValue>& operands = roughness.expression->operands;
            return IsAll(operands[1], 1.0F)
                       ? MakeMath(HDS_MATH_MIX, {Unclamped(operands[0]), operands[1], operands[2]},
                                  1)
                       : roughness;
        }
        if (IsMath(roughness, HDS_MATH_MIN) && IsAll(roughness.expression->operands[1], 1.0F)) {
            const ShaderValue& inner = roughness.expression->operands[0];
            if (IsMath(inner, HDS_MATH_MAX) && IsAll(inner.expression->operands[1], 0.0F)) {
                return inner.expression->operands[0];
            }
        }
        return roughness;
    }

    /// mx_roughness_anisotropy: GGX's alpha along x and y.
    ShaderValue Stretched(const ShaderValue& roughness) {
        const ShaderValue alpha = Squared(Unclamped(roughness));
        const ShaderValue anisotropy =
            ClampTo(In("anisotropy", 0.0F), MakeScalar(0.0F), MakeScalar(0.98F), 1);
        const ShaderValue aspect =
            MakeMath(HDS_MATH_SQRT, {Scalar(HDS_MATH_SUBTRACT, MakeScalar(1.0F), anisotropy)}, 1);
        const ShaderValue along =
            Scalar(HDS_MATH_MIN, Scalar(HDS_MATH_DIVIDE, alpha, aspect), MakeScalar(1.0F));
        return Pair(along, Product(alpha, aspect));
    }
    ShaderValue RoughnessAnisotropy() { return Stretched(In("roughness", 0.0F)); }
    ShaderValue GlossinessAnisotropy() {
        return Stretched(Scalar(HDS_MATH_SUBTRACT, MakeScalar(1.0F), In("glossiness", 1.0F)));
    }
    ShaderValue RoughnessDual() {
        const ShaderValue roughness = Vector("roughness", {}, 2);
        return Pair(Squared(ChannelOf(roughness, 0)), Squared(ChannelOf(roughness, 1)));
    }
    ShaderValue OpenPbrAnisotropy() {
        const ShaderValue roughness = In("roughness", 0.0F);
        const ShaderValue alpha = Product(roughness, roughness);
        const ShaderValue left =
            Scalar(HDS_MATH_SUBTRACT, MakeScalar(1.0F), In("anisotropy", 0.0F));
        const ShaderValue sum = Scalar(HDS_MATH_ADD, Product(left, left), MakeScalar(1.0F));
        const ShaderValue along = Product(
            alpha, MakeMath(HDS_MATH_SQRT, {Scalar(HDS_MATH_DIVIDE, MakeScalar(2.0F), sum)}, 1));
        return Pair(along, Product(left, along));
    }

    /// Gulbrandsen 2014, "Artist Friendly Metallic Fresnel", JCGT 3(4), equations 2 and 3.
    ShaderValue ArtisticIor() {
        const auto math = [](std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
            return MakeMath(code, {a, b}, 3);
        };
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue r = ClampTo(Vector("reflectivity", {0.944F, 0.776F, 0.373F, 1.0F}, 3),
                                      MakeScalar(0.0F), MakeScalar(0.99F), 3);
        const ShaderValue edge = Vector("edge_color", {0.998F, 0.981F, 0.751F, 1.0F}, 3);
        const ShaderValue root = MakeMath(HDS_MATH_SQRT, {r}, 3);
        const ShaderValue least =
            math(HDS_MATH_DIVIDE, math(HDS_MATH_SUBTRACT, one, r), math(HDS_MATH_ADD, one, r));
        const ShaderValue most = math(HDS_MATH_DIVIDE, math(HDS_MATH_ADD, one, root),
                                      math(HDS_MATH_SUBTRACT, one, root));
        const ShaderValue index = MakeMath(HDS_MATH_MIX, {most, least, edge}, 3);
        if (_output != "extinction") {
            return index;
        }
        const ShaderValue up = math(HDS_MATH_ADD, index, one);
        const ShaderValue down = math(HDS_MATH_SUBTRACT, index, one);
        const ShaderValue squared =
            math(HDS_MATH_SUBTRACT, math(HDS_MATH_MULTIPLY, math(HDS_MATH_MULTIPLY, up, up), r),
                 math(HDS_MATH_MULTIPLY, down, down));
        const ShaderValue quotient =
            math(HDS_MATH_DIVIDE, squared, math(HDS_MATH_SUBTRACT, one, r));
        return MakeMath(HDS_MATH_SQRT, {math(HDS_MATH_MAX, quotient, MakeScalar(0.0F))}, 3);
    }

    /// Kang et al. 2002, "Design of advanced color temperature control system": the locus of
    /// chromaticities by cubic splines; then linear Rec. 709 of luminance 1.
    ShaderValue Blackbody() {
        const auto cubic = [](const ShaderValue& x, const std::array<float, 4>& coefficients) {
            ShaderValue sum = MakeScalar(coefficients[0]);
            for (std::size_t k = 1; k < 4; ++k) {
                sum = Scalar(HDS_MATH_ADD, Product(sum, x), MakeScalar(coefficients[k]));
            }
            return sum;
        };
        const ShaderValue kelvin =
            ClampTo(In("temperature", 5000.0F), MakeScalar(800.0F), MakeScalar(25000.0F), 1);
        const auto below = [&](float limit, const ShaderValue& low, const ShaderValue& high) {
            return MakeMath(HDS_MATH_SELECT,
                            {Scalar(HDS_MATH_GREATER, MakeScalar(limit), kelvin), low, high}, 1);
        };
        const ShaderValue t = Scalar(HDS_MATH_DIVIDE, MakeScalar(1000.0F), kelvin);
        const ShaderValue x =
            below(4000.0F, cubic(t, {-0.2661239F, -0.2343580F, 0.8776956F, 0.17991F}),
                  cubic(t, {-3.0258469F, 2.1070379F, 0.2226347F, 0.24039F}));
        const ShaderValue y =
            below(2222.0F, cubic(x, {-1.1063814F, -1.34811020F, 2.18555832F, -0.20219683F}),
                  below(4000.0F, cubic(x, {-0.9549476F, -1.37418593F, 2.09137015F, -0.16748867F}),
                        cubic(x, {3.0817580F, -5.87338670F, 3.75112997F, -0.37001483F})));
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue z = Scalar(HDS_MATH_SUBTRACT, Scalar(HDS_MATH_SUBTRACT, one, x), y);
        const ShaderValue xyz = CombineChannels(Scalar(HDS_MATH_DIVIDE, x, y), one,
                                                Scalar(HDS_MATH_DIVIDE, z, y), MakeScalar(0.0F), 3);
        const auto row = [&](const std::array<float, 4>& weights) {
            return DotProduct(xyz, MakeConstant(weights, 3), 3);
        };
        const ShaderValue color = CombineChannels(
            row({3.2406F, -1.5372F, -0.4986F, 0.0F}), row({-0.9689F, 1.8758F, 0.0415F, 0.0F}),
            row({0.0557F, -0.2040F, 1.0570F, 0.0F}), MakeScalar(0.0F), 3);
        return MakeMath(HDS_MATH_MAX, {color, MakeScalar(0.0F)}, 3);
    }

    /// Longitudinal variance and azimuthal scale of hair. Chiang et al. 2016, eqs. 7 and 8; the
    /// factors of the lobes are Marschner's et al. 2003.
    ShaderValue HairRoughness() {
        const auto polynomial = [](const ShaderValue& x, float linear, float square, float high,
                                   float exponent) {
            const ShaderValue sum = Scalar(HDS_MATH_ADD, Product(MakeScalar(linear), x),
                                           Product(MakeScalar(square), Product(x, x)));
            return Scalar(
                HDS_MATH_ADD, sum,
                Product(MakeScalar(high), Scalar(HDS_MATH_POWER, x, MakeScalar(exponent))));
        };
        const auto limited = [](const ShaderValue& x) {
            return ClampTo(x, MakeScalar(0.001F), MakeScalar(1.0F), 1);
        };
        const ShaderValue deviation =
            polynomial(limited(In("longitudinal", 0.1F)), 0.726F, 0.812F, 3.7F, 20.0F);
        const ShaderValue scale =
            polynomial(limited(In("azimuthal", 0.2F)), 0.265F, 1.194F, 5.372F, 22.0F);
        ShaderValue factor = MakeScalar(1.0F);
        if (_output == "roughness_TT") {
            factor = In("scale_TT", 0.5F);
        } else if (_output == "roughness_TRT") {
            factor = In("scale_TRT", 2.0F);
        }
        const ShaderValue scaled = Product(deviation, factor);
        return Pair(Product(scaled, scaled), scale);
    }

    /// Chiang et al. 2016, eq. 9: the absorption whose many times scattered light has a colour.
    ShaderValue HairAbsorptionOfColor() {
        const ShaderValue roughness = In("azimuthal_roughness", 0.2F);
        ShaderValue divisor = MakeScalar(0.245F);
        for (const float coefficient : {5.574F, -10.73F, 2.532F, -0.215F, 5.969F}) {
            divisor = Scalar(HDS_MATH_ADD, MakeScalar(coefficient), Product(divisor, roughness));
        }
        const ShaderValue color = ClampTo(Vector("color", {1.0F, 1.0F, 1.0F, 1.0F}, 3),
                                          MakeScalar(0.001F), MakeScalar(1.0F), 3);
        const ShaderValue root =
            MakeMath(HDS_MATH_DIVIDE, {MakeMath(HDS_MATH_LN, {color}, 3), divisor}, 3);
        return MakeMath(HDS_MATH_MULTIPLY, {root, root}, 3);
    }

    /// d'Eon et al. 2011, section 6.1: both melanins by their concentration.
    ShaderValue HairAbsorptionOfMelanin() {
        const auto absorption = [](const ShaderValue& color) {
            return MakeMath(HDS_MATH_SUBTRACT,
                            {MakeScalar(0.0F), MakeMath(HDS_MATH_LN, {color}, 3)}, 3);
        };
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue left =
            Scalar(HDS_MATH_MAX, Scalar(HDS_MATH_SUBTRACT, one, In("melanin_concentration", 0.25F)),
                   MakeScalar(1e-4F));
        const ShaderValue melanin =
            Scalar(HDS_MATH_SUBTRACT, MakeScalar(0.0F), MakeMath(HDS_MATH_LN, {left}, 1));
        const ShaderValue redness = In("melanin_redness", 0.5F);
        const auto amount = [&](const ShaderValue& share, const ShaderValue& color) {
            return MakeMath(HDS_MATH_MULTIPLY, {Product(melanin, share), absorption(color)}, 3);
        };
        const ShaderValue dark =
            amount(Scalar(HDS_MATH_SUBTRACT, one, redness),
                   Vector("eumelanin_color", {0.657704F, 0.498077F, 0.254107F, 1.0F}, 3));
        const ShaderValue red =
            amount(redness, Vector("pheomelanin_color", {0.829444F, 0.67032F, 0.349938F, 1.0F}, 3));
        return MakeMath(HDS_MATH_MAX, {MakeMath(HDS_MATH_ADD, {dark, red}, 3), MakeScalar(0.0F)},
                        3);
    }
};

constexpr PatternType kTypes[] = {
    {"roughness_anisotropy", kPattern<&PbrNode::RoughnessAnisotropy>},
    {"roughness_dual", kPattern<&PbrNode::RoughnessDual>},
    {"glossiness_anisotropy", kPattern<&PbrNode::GlossinessAnisotropy>},
    {"open_pbr_anisotropy", kPattern<&PbrNode::OpenPbrAnisotropy>},
    {"blackbody", kPattern<&PbrNode::Blackbody>},
    {"artistic_ior", kPattern<&PbrNode::ArtisticIor>},
    {"chiang_hair_roughness", kPattern<&PbrNode::HairRoughness>},
    {"chiang_hair_absorption_from_color", kPattern<&PbrNode::HairAbsorptionOfColor>},
    {"deon_hair_absorption_from_melanin", kPattern<&PbrNode::HairAbsorptionOfMelanin>},
};

} // namespace

PatternTable PbrNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
