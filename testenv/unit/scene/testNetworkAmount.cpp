// SPDX-License-Identifier: Apache-2.0
// Displacement by networks: nothing leaves its bounds, whatever the network is; closed forms.
#include "hdStream/scene/networkAmount.h"
#include "hdStream/scene/valueRange.h"
#include "kernels/shared/programMath.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hds {
namespace {

using StepKind = DisplacementStep::Kind;

struct Function {
    std::uint32_t code;
    std::uint32_t numOperands;
};
constexpr Function kFunctions[] = {{HDS_MATH_ABS, 1},           {HDS_MATH_SIGN, 1},
                                   {HDS_MATH_FLOOR, 1},         {HDS_MATH_CEIL, 1},
                                   {HDS_MATH_ROUND, 1},         {HDS_MATH_SQRT, 1},
                                   {HDS_MATH_EXP, 1},           {HDS_MATH_LN, 1},
                                   {HDS_MATH_SIN, 1},           {HDS_MATH_COS, 1},
                                   {HDS_MATH_TAN, 1},           {HDS_MATH_ASIN, 1},
                                   {HDS_MATH_ACOS, 1},          {HDS_MATH_ADD, 2},
                                   {HDS_MATH_SUBTRACT, 2},      {HDS_MATH_MULTIPLY, 2},
                                   {HDS_MATH_DIVIDE, 2},        {HDS_MATH_MODULO, 2},
                                   {HDS_MATH_POWER, 2},         {HDS_MATH_MIN, 2},
                                   {HDS_MATH_MAX, 2},           {HDS_MATH_ATAN2, 2},
                                   {HDS_MATH_GREATER, 2},       {HDS_MATH_GREATER_OR_EQUAL, 2},
                                   {HDS_MATH_EQUAL, 2},         {HDS_MATH_MIX, 3},
                                   {HDS_MATH_SMOOTHSTEP, 3},    {HDS_MATH_SELECT, 3},
                                   {HDS_MATH_DOT, 2},           {HDS_MATH_CROSS, 2},
                                   {HDS_MATH_NORMALIZE, 1},     {HDS_MATH_COMBINE, 4},
                                   {HDS_MATH_RGB_TO_HSV, 1},    {HDS_MATH_HSV_TO_RGB, 1},
                                   {HDS_MATH_NOISE2, 1},        {HDS_MATH_NOISE3, 1},
                                   {HDS_MATH_NOISE2_VECTOR, 1}, {HDS_MATH_NOISE3_VECTOR, 1},
                                   {HDS_MATH_CELL2, 1},         {HDS_MATH_CELL3, 1},
                                   {HDS_MATH_FRACTAL3, 4},      {HDS_MATH_FRACTAL3_VECTOR, 4},
                                   {HDS_MATH_FRACTAL2, 4},      {HDS_MATH_FRACTAL2_VECTOR, 4},
                                   {HDS_MATH_WORLEY2, 2},       {HDS_MATH_WORLEY3, 2},
                                   {HDS_MATH_WORLEY2_CELL, 2},  {HDS_MATH_WORLEY3_CELL, 2}};

DisplacementStep MathStep(std::uint32_t code, std::vector<DisplacementOperand> operands) {
    DisplacementStep step;
    step.kind = StepKind::Math;
    step.code = code;
    step.operands = std::move(operands);
    return step;
}

DisplacementStep ConstantStep(float value) {
    DisplacementStep step;
    step.constant = {value, value, value, value};
    return step;
}

DisplacementStep StepOf(StepKind kind, std::uint32_t code = 0) {
    DisplacementStep step;
    step.kind = kind;
    step.code = code;
    return step;
}

/// Four columns of one row: 1, 2, 3, 4, in channels 0 and 1.
DisplacementTile Tile(float first) {
    auto image = std::make_shared<HeightImage>();
    image->width = 4;
    image->height = 1;
    image->values = {first, first + 1.0F, first + 2.0F, first + 3.0F};
    DisplacementTile tile;
    tile.channels = 3;
    tile.heights = {image, image, nullptr, nullptr};
    return tile;
}

DisplacementStep TextureStep(std::uint32_t st, std::uint32_t one, std::uint32_t zero) {
    DisplacementStep step = StepOf(
        StepKind::Texture, HDS_LOOKUP_WRAPS(HDS_WRAP_CLAMP, HDS_WRAP_CLAMP) | HDS_LOOKUP_UDIM);
    step.operands = {{st}, {zero}, {one}, {zero}};
    step.tiles = {Tile(1.0F), DisplacementTile(), Tile(-2.0F)};
    return step;
}

class RandomNetworks {
public:
    explicit RandomNetworks(unsigned seed) : _random(seed) {}

    double Uniform(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(_random);
    }
    std::uint32_t Below(std::size_t count) { return std::uint32_t(_random() % count); }

    DisplacementNetwork Make() {
        DisplacementNetwork network;
        network.primvars = {{{"a"}, 4, {}}, {{"b"}, 2, {}}};
        network.steps = {StepOf(StepKind::Primvar, 0),
                         StepOf(StepKind::Primvar, 1),
                         StepOf(StepKind::Position),
                         ConstantStep(1.0F),
                         ConstantStep(0.0F),
                         ConstantStep(float(Uniform(-3.0, 3.0))),
                         ConstantStep(2.0F)};
        DisplacementStep affine = StepOf(StepKind::Affine);
        affine.rows = {Uniform(-2, 2), Uniform(-2, 2), 0.5, Uniform(-2, 2), Uniform(-2, 2), 0.25};
        affine.operands = {{1}};
        network.steps.push_back(affine);
        network.steps.push_back(TextureStep(7, 3, 4));
        const std::size_t count = network.steps.size() + 1 + Below(6);
        while (network.steps.size() < count) {
            const Function function = kFunctions[Below(std::size(kFunctions))];
            std::vector<DisplacementOperand> operands;
            for (std::uint32_t i = 0; i < function.numOperands; ++i) {
                const std::uint32_t channel = Below(4);
                operands.push_back(
                    {Below(network.steps.size()), Below(2) == 0 ? HDS_CHANNEL_ALL : channel});
            }
            network.steps.push_back(MathStep(function.code, std::move(operands)));
        }
        network.result = {std::uint32_t(network.steps.size() - 1), Below(4)};
        return network;
    }

    AmountBox Box() {
        AmountBox box;
        box.low.primvars.resize(2);
        box.high.primvars.resize(2);
        const auto add = [&](double* low, double* high) {
            const double a = Below(4) == 0 ? 0.0 : Uniform(-2.0, 2.0);
            const double b = Below(8) == 0 ? a : a + Uniform(0.0, Below(2) == 0 ? 0.2 : 4.0);
            *low = a;
            *high = b;
        };
        for (std::size_t k = 0; k < 4; ++k) {
            add(&box.low.primvars[0][k], &box.high.primvars[0][k]);
        }
        for (std::size_t k = 0; k < 2; ++k) {
            add(&box.low.primvars[1][k], &box.high.primvars[1][k]);
        }
        for (glm::length_t k = 0; k < 3; ++k) {
            add(&box.low.position[k], &box.high.position[k]);
        }
        return box;
    }

    AmountPoint PointIn(const AmountBox& box) {
        AmountPoint point = box.low;
        const auto choose = [&](double low, double high) {
            const std::uint32_t side = Below(4);
            return side == 0 ? low : side == 1 ? high : Uniform(low, high);
        };
        for (std::size_t i = 0; i < 2; ++i) {
            for (std::size_t k = 0; k < 4; ++k) {
                point.primvars[i][k] = choose(box.low.primvars[i][k], box.high.primvars[i][k]);
            }
        }
        for (glm::length_t k = 0; k < 3; ++k) {
            point.position[k] = choose(box.low.position[k], box.high.position[k]);
        }
        return point;
    }

private:
    std::mt19937 _random;
};

TEST(NetworkAmount, NothingLeavesTheBoundsOfRandomNetworks) {
    RandomNetworks networks(7);
    int numBounded = 0;
    constexpr int kNetworks = 20000;
    for (int round = 0; round < kNetworks; ++round) {
        const DisplacementNetwork network = networks.Make();
        const auto amount = MakeNetworkAmount(network);
        const AmountBox box = networks.Box();
        const AmountRange range = amount->Over(box);
        ASSERT_LE(range.low, range.high);
        numBounded += std::isfinite(range.low) && std::isfinite(range.high) ? 1 : 0;
        for (int i = 0; i < 50; ++i) {
            const double value = amount->At(networks.PointIn(box));
            ASSERT_GE(value, range.low) << round << " function " << network.steps.back().code;
            ASSERT_LE(value, range.high) << round << " function " << network.steps.back().code;
        }
    }
    EXPECT_GT(numBounded, kNetworks * 3 / 4) << "bounds that are infinite hold everything";
}

TEST(NetworkAmount, VectorsOfRandomNetworksAreNoLongerThanTheirBounds) {
    RandomNetworks networks(11);
    int numBounded = 0;
    double nearest = 0.0;
    constexpr int kNetworks = 10000;
    for (int round = 0; round < kNetworks; ++round) {
        DisplacementNetwork network = networks.Make();
        network.isVector = true;
        network.result.channel = networks.Below(4) == 0 ? 1 : HDS_CHANNEL_ALL;
        network.coordinates = networks.Below(2) == 0 ? HDS_NONE : 1;
        const auto amount = MakeNetworkAmount(network);
        ASSERT_EQ(amount->Space(), network.coordinates == HDS_NONE ? DisplacementSpace::Object
                                                                   : DisplacementSpace::Tangent);
        const AmountBox box = networks.Box();
        const AmountRange range = amount->Over(box);
        ASSERT_EQ(range.low, -range.high);
        numBounded += std::isfinite(range.high) ? 1 : 0;
        for (int i = 0; i < 50; ++i) {
            const AmountPoint point = networks.PointIn(box);
            const double length = glm::length(amount->VectorAt(point));
            ASSERT_LE(length, range.high) << round << " function " << network.steps.back().code;
            ASSERT_EQ(amount->At(point), 0.0);
            nearest = range.high > 0.0 ? std::max(nearest, length / range.high) : nearest;
        }
    }
    EXPECT_GT(numBounded, kNetworks * 3 / 4) << "bounds that are infinite hold everything";
    EXPECT_GT(nearest, 0.999) << "no vector comes near its bound";
}

/// 3 sin(x) + image of two tiles of a, with a hole between.
DisplacementNetwork Waves() {
    DisplacementNetwork network;
    network.primvars = {{{"st"}, 2, {0.125F, 0.5F, 0.0F, 0.0F}}};
    network.steps = {StepOf(StepKind::Position),
                     MathStep(HDS_MATH_SIN, {{0, 0}}),
                     ConstantStep(3.0F),
                     MathStep(HDS_MATH_MULTIPLY, {{1}, {2}}),
                     StepOf(StepKind::Primvar, 0),
                     ConstantStep(1.0F),
                     ConstantStep(0.0F),
                     TextureStep(4, 5, 6),
                     MathStep(HDS_MATH_ADD, {{3}, {7, 1}})};
    network.result = {8};
    return network;
}

TEST(NetworkAmount, IsTheFunctionOfItsSteps) {
    const auto amount = MakeNetworkAmount(Waves());
    EXPECT_TRUE(amount->ReadsPosition());
    ASSERT_EQ(amount->Primvars().size(), 1U);
    EXPECT_EQ(amount->Primvars()[0].numComponents, 2U);
    AmountPoint point = MissingPoint(*amount);
    point.position = {0.7, 9.0, 9.0};
    EXPECT_NEAR(amount->At(point), 3.0 * std::sin(0.7) + 1.0, 1e-6);
    point.primvars[0] = {2.5, 0.5, 0.0, 0.0}; // the middle of the third tile
    EXPECT_NEAR(amount->At(point), 3.0 * std::sin(0.7) - 0.5, 1e-6);
    point.primvars[0] = {1.5, 0.5, 0.0, 0.0};
    EXPECT_NEAR(amount->At(point), 3.0 * std::sin(0.7), 1e-6) << "a hole has the fallback";
}

TEST(NetworkAmount, BoundsAreThoseOfTheDomain) {
    const auto amount = MakeNetworkAmount(Waves());
    AmountBox box{MissingPoint(*amount), MissingPoint(*amount)};
    box.low.position = {-0.1, 0.0, 0.0};
    box.high.position = {0.1, 0.0, 0.0};
    const AmountRange near = amount->Over(box); // of the images all: -2 to 4
    EXPECT_NEAR(near.low, -2.0 - 3.0 * std::sin(0.1), 1e-3);
    EXPECT_NEAR(near.high, 4.0 + 3.0 * std::sin(0.1), 1e-3);
    box.high.position = {2.0, 0.0, 0.0};
    EXPECT_NEAR(amount->Over(box).high, 7.0, 1e-3);
}

TEST(ValueRange, LinearFunctionsHaveTheirEnds) {
    const ValueRange a = {AmountRange{-1.0, 2.0}, AmountRange{-1.0, 2.0}, AmountRange{-1.0, 2.0},
                          AmountRange{-1.0, 2.0}};
    const ValueRange b = {AmountRange{3.0, 4.0}, AmountRange{3.0, 4.0}, AmountRange{3.0, 4.0},
                          AmountRange{3.0, 4.0}};
    const auto of = [&](std::uint32_t code) { return RangeOfMath(code, {a, b})[0]; };
    EXPECT_NEAR(of(HDS_MATH_ADD).high, 6.0, 1e-4);
    EXPECT_NEAR(of(HDS_MATH_SUBTRACT).low, -5.0, 1e-4);
    EXPECT_NEAR(of(HDS_MATH_MULTIPLY).low, -4.0, 1e-4);
    EXPECT_NEAR(of(HDS_MATH_DIVIDE).high, 2.0 / 3.0, 1e-4);
    EXPECT_TRUE(std::isinf(RangeOfMath(HDS_MATH_DIVIDE, {b, a})[0].high));
}

} // namespace
} // namespace hds
