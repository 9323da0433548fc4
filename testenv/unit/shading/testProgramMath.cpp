// SPDX-License-Identifier: Apache-2.0
// Functions of the shader machine and the expressions made of them: noise against MaterialX's own
// text, colours there and back, what is folded, left out and kept as coordinates.
#include "hdStream/shading/shaderMath.h"

#include <gtest/gtest.h>

namespace hds {
namespace {

shared::float4 Apply(std::uint32_t code, const shared::float4& a) {
    const shared::float4 arguments[4] = {
        a, {3.0F, 3.0F, 3.0F, 3.0F}, {2.0F, 2.0F, 2.0F, 2.0F}, {0.5F, 0.5F, 0.5F, 0.5F}};
    return shared::math_apply(code, arguments);
}

ShaderValue Coordinates() {
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Primvar;
    expression->primvar = "st";
    expression->operands = {MakeConstant({}, 2)};
    return {std::move(expression), HDS_CHANNEL_ALL, 2};
}

/// Values of lib/mx_noise.glsl of MaterialX 1.39.5, compiled as C++ apart from us.
TEST(ProgramMath, NoiseIsMaterialXs) {
    struct Row {
        float p[3];
        float noise2, noise3, second, third, cell2, cell3, fractal;
    };
    const Row rows[] = {{{0.3F, 0.7F, 0.2F},
                         0.040743679F,
                         0.27371189F,
                         0.65101218F,
                         0.40486136F,
                         0.86031276F,
                         0.61106765F,
                         0.48179933F},
                        {{-3.4F, 12.9F, 5.5F},
                         0.14113612F,
                         0.054810829F,
                         -0.22569886F,
                         0.048312541F,
                         0.061291363F,
                         0.41063979F,
                         -0.14174041F},
                        {{100.25F, -7.75F, 0.5F},
                         0.4655017F,
                         -0.01715168F,
                         0.24097531F,
                         0.13114111F,
                         0.9439131F,
                         0.19899526F,
                         0.16697332F},
                        {{2.5F, 2.5F, -2.5F},
                         -0.3308F,
                         -0.2455F,
                         -0.66159999F,
                         0.0F,
                         0.73678869F,
                         0.95532548F,
                         -0.2455F}};
    for (const Row& row : rows) {
        const shared::float4 p{row.p[0], row.p[1], row.p[2], 0.0F};
        EXPECT_NEAR(Apply(HDS_MATH_NOISE2, p).x, row.noise2, 1e-6);
        EXPECT_NEAR(Apply(HDS_MATH_NOISE3, p).x, row.noise3, 1e-6);
        EXPECT_NEAR(Apply(HDS_MATH_NOISE2_VECTOR, p).y, row.second, 1e-6);
        EXPECT_NEAR(Apply(HDS_MATH_NOISE3_VECTOR, p).z, row.third, 1e-6);
        EXPECT_NEAR(Apply(HDS_MATH_CELL2, p).x, row.cell2, 1e-6);
        EXPECT_NEAR(Apply(HDS_MATH_CELL3, p).x, row.cell3, 1e-6);
        EXPECT_NEAR(Apply(HDS_MATH_FRACTAL3, p).x, row.fractal, 1e-6);
    }
}

TEST(ProgramMath, HueSaturationValueAndBack) {
    for (const shared::float4 color : {shared::float4{0.2F, 0.5F, 0.8F, 1.0F},
                                       {0.9F, 0.1F, 0.3F, 1.0F},
                                       {0.4F, 0.4F, 0.4F, 1.0F},
                                       {2.0F, 1.5F, 0.0F, 1.0F}}) {
        const shared::float4 back = Apply(HDS_MATH_HSV_TO_RGB, Apply(HDS_MATH_RGB_TO_HSV, color));
        EXPECT_NEAR(back.x, color.x, 1e-6);
        EXPECT_NEAR(back.y, color.y, 1e-6);
        EXPECT_NEAR(back.z, color.z, 1e-6);
    }
}

TEST(ProgramMath, ConstantsAreFolded) {
    const ShaderValue color = MakeConstant({0.5F, 0.25F, 1.0F, 1.0F}, 3);
    const ShaderValue product = MakeMath(HDS_MATH_MULTIPLY, {color, MakeScalar(0.5F)}, 3);
    ASSERT_TRUE(IsConstant(product));
    EXPECT_FLOAT_EQ(ConstantOf(product)[1], 0.125F);
    EXPECT_EQ(product.numComponents, 3U);
}

TEST(ProgramMath, WhatChangesNothingIsLeftOut) {
    const ShaderValue st = Coordinates();
    const ShaderValue one = MakeScalar(1.0F);
    const ShaderValue zero = MakeScalar(0.0F);
    for (const ShaderValue& value :
         {MakeMath(HDS_MATH_MULTIPLY, {st, one}, 3), MakeMath(HDS_MATH_ADD, {zero, st}, 3),
          MakeMath(HDS_MATH_POWER, {st, one}, 3), MakeMath(HDS_MATH_MIX, {st, one, zero}, 3),
          MakeMath(HDS_MATH_SELECT, {one, st, zero}, 3)}) {
        EXPECT_EQ(value.expression, st.expression);
    }
}

TEST(ProgramMath, WhatIsComputedAlikeIsTheSame) {
    const auto make = [](std::uint32_t code, float factor, std::uint32_t channel) {
        const ShaderValue st = Coordinates();
        const ShaderValue x = SelectChannel(st, channel);
        return MakeMath(code, {MakeMath(HDS_MATH_MULTIPLY, {x, MakeScalar(factor)}, 1), x}, 1);
    };
    const ShaderValue value = make(HDS_MATH_MAX, 2.0F, 0);
    EXPECT_TRUE(AreSame(value, make(HDS_MATH_MAX, 2.0F, 0)));
    EXPECT_FALSE(AreSame(value, make(HDS_MATH_MIN, 2.0F, 0)));
    EXPECT_FALSE(AreSame(value, make(HDS_MATH_MAX, 2.5F, 0)));
    EXPECT_FALSE(AreSame(value, make(HDS_MATH_MAX, 2.0F, 1)));
    EXPECT_FALSE(AreSame(value, MakeScalar(2.0F)));
    EXPECT_FALSE(AreSame(value, {}));
    EXPECT_TRUE(AreSame({}, {}));
    // Each step doubles the ways to the first.
    const auto doubled = [&](ShaderValue sum) {
        for (int i = 0; i < 60; ++i) {
            sum = MakeMath(HDS_MATH_ADD, {sum, sum}, 1);
        }
        return sum;
    };
    EXPECT_TRUE(AreSame(doubled(value), doubled(make(HDS_MATH_MAX, 2.0F, 0))));
    EXPECT_FALSE(AreSame(doubled(value), doubled(make(HDS_MATH_MAX, 2.0F, 1))));
}

TEST(ProgramMath, OnlyComponentsThatCountMakeADifference) {
    const ShaderValue channel = SelectChannel(MakeConstant({0.3F, 0.5F, 0.7F, 1.0F}, 3), 0);
    const ShaderValue red = MakeConstant({0.3F, 0.0F, 0.0F, 1.0F}, 3);
    EXPECT_TRUE(AreSame(channel, MakeScalar(0.3F))) << "scalars";
    EXPECT_FALSE(AreSame(channel, MakeScalar(0.4F)));
    EXPECT_FALSE(AreSame(channel, red)) << "a scalar is grey";
    EXPECT_TRUE(AreSame(channel, MakeConstant({0.3F, 0.3F, 0.3F, 1.0F}, 3)));
    EXPECT_TRUE(AreSame(red, MakeConstant({0.3F, 0.0F, 0.0F, 0.0F}, 3))) << "of three components";
    EXPECT_FALSE(AreSame(red, MakeConstant({0.3F, 0.0F, 0.1F, 1.0F}, 3)));
    EXPECT_FALSE(AreSame(MakeConstant({0.1F, 0.2F, 0.3F, 0.0F}, 4),
                         MakeConstant({0.1F, 0.2F, 0.3F, 1.0F}, 4)));
    // Of what is not constant too: the first component is another value than all of them.
    const ShaderValue st = Coordinates();
    EXPECT_TRUE(AreSame({st.expression, HDS_CHANNEL_ALL, 1}, SelectChannel(st, 0)));
    EXPECT_FALSE(AreSame({st.expression, HDS_CHANNEL_ALL, 1}, st));
}

TEST(ProgramMath, ScaledCoordinatesStayCoordinates) {
    const ShaderValue factor = MakeConstant({4.0F, 2.0F, 0.0F, 0.0F}, 2);
    const ShaderValue offset = MakeConstant({0.5F, -1.0F, 0.0F, 0.0F}, 2);
    const ShaderValue st = MakeMath(
        HDS_MATH_SUBTRACT, {MakeMath(HDS_MATH_MULTIPLY, {Coordinates(), factor}, 2), offset}, 2);
    ASSERT_EQ(st.expression->kind, ShaderExpression::Kind::Affine);
    EXPECT_EQ(st.expression->operands[0].expression->kind, ShaderExpression::Kind::Primvar);
    const std::array<double, 6> expected{4, 0, -0.5, 0, 2, 1};
    EXPECT_EQ(st.expression->rows, expected);
}

} // namespace
} // namespace hds
