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

    /// mx_roughness_anisotropy: GGX's alpha along x and y.
    ShaderValue Stretched(const ShaderValue& roughness) {
        const ShaderValue alpha = Squared(roughness);
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
};

constexpr PatternType kTypes[] = {
    {"roughness_anisotropy", kPattern<&PbrNode::RoughnessAnisotropy>},
    {"roughness_dual", kPattern<&PbrNode::RoughnessDual>},
    {"glossiness_anisotropy", kPattern<&PbrNode::GlossinessAnisotropy>},
    {"open_pbr_anisotropy", kPattern<&PbrNode::OpenPbrAnisotropy>},
    {"artistic_ior", kPattern<&PbrNode::ArtisticIor>},
};

} // namespace

PatternTable PbrNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
