// SPDX-License-Identifier: Apache-2.0
// MaterialX's flakes at random, as in metallic paint. Definitions: MaterialX 1.39, the text of
// flake2d and flake3d. The table of what there is: docs/materials.md.
#include "hdStream/shading/patternNode.h"

namespace hds {

namespace {

class FlakeNode : public PatternNode {
public:
    using PatternNode::PatternNode;

    ShaderValue Flakes2d() { return Flakes(Coordinates()); }
    ShaderValue Flakes3d() {
        return Flakes(GeometryInput("position", ShaderExpression::Kind::Position));
    }

private:
    static ShaderValue Scalar(std::uint32_t code, const ShaderValue& a, const ShaderValue& b) {
        return MakeMath(code, {a, b}, 1);
    }
    static ShaderValue Product(const ShaderValue& a, const ShaderValue& b) {
        return Scalar(HDS_MATH_MULTIPLY, a, b);
    }
    static ShaderValue Root(const ShaderValue& a) { return MakeMath(HDS_MATH_SQRT, {a}, 1); }

    ShaderValue Flakes(const ShaderValue& place) {
        const ShaderValue cells =
            MakeMath(HDS_MATH_DIVIDE, {place, In("size", 0.01F)}, place.numComponents);
        const ShaderValue flake = MakeMath(HDS_MATH_FLAKE, {cells, In("coverage", 0.5F)}, 4);
        if (_output == "presence") {
            return ChannelOf(flake, 3);
        }
        if (_output == "rand") {
            return ChannelOf(flake, 2);
        }
        if (_output == "id") {
            const ShaderValue scaled = Product(ChannelOf(flake, 2), MakeScalar(16777215.0F));
            return MakeMath(HDS_MATH_FLOOR, {scaled}, 1);
        }
        return NormalOf(flake);
    }

    /// In tangent space, as normalmap: a normal of GGX's microfacets, the surface's where there is
    /// no flake.
    ShaderValue NormalOf(const ShaderValue& flake) {
        const ShaderValue one = MakeScalar(1.0F);
        const ShaderValue zero = MakeScalar(0.0F);
        const ShaderValue roughness = In("roughness", 0.1F);
        const ShaderValue height = ChannelOf(flake, 1);
        const ShaderValue slope = Scalar(
            HDS_MATH_DIVIDE, Product(Product(roughness, roughness), Root(height)),
            Root(Scalar(HDS_MATH_MAX, Scalar(HDS_MATH_SUBTRACT, one, height), MakeScalar(1e-7F))));
        const ShaderValue phi = Product(ChannelOf(flake, 0), MakeScalar(6.28318531F));
        const ShaderValue normal = MakeMath(
            HDS_MATH_NORMALIZE,
            {CombineChannels(Product(slope, MakeMath(HDS_MATH_COS, {phi}, 1)),
                             Product(slope, MakeMath(HDS_MATH_SIN, {phi}, 1)), one, zero, 3)},
            3);
        const ShaderValue isThere = Scalar(HDS_MATH_GREATER, ChannelOf(flake, 3), zero);
        return MakeMath(HDS_MATH_SELECT,
                        {isThere, normal, MakeConstant({0.0F, 0.0F, 1.0F, 0.0F}, 3)}, 3);
    }
};

constexpr PatternType kTypes[] = {
    {"flake2d", kPattern<&FlakeNode::Flakes2d>},
    {"flake3d", kPattern<&FlakeNode::Flakes3d>},
};

} // namespace

PatternTable FlakeNodes() {
    return PatternTable(kTypes);
}

} // namespace hds
