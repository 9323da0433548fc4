// SPDX-License-Identifier: Apache-2.0
// Closures, surfaces and matrices of networks in which each node has the one before in two inputs:
// 2^40 ways lead to the first. A node that is read more than once shows as a test that never ends.
#include "hdStream/shading/materialCompiler.h"
#include "testenv/unit/shading/imageQueries.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <string>
#include <vector>

namespace hds {
namespace {

constexpr int kNumLevels = 40;

/// A kind of node with two inputs of what it gives.
struct Kind {
    const char* name;
    const char* id;
    const char* inputs[2];
};

constexpr Kind kBsdf{"bsdf", "ND_mix_bsdf", {"bg", "fg"}};
constexpr Kind kEdf{"edf", "ND_add_edf", {"in1", "in2"}};
constexpr Kind kSurface{"surface", "ND_mix_surfaceshader", {"bg", "fg"}};
constexpr Kind kMatrix{"matrix", "ND_add_matrix33", {"in1", "in2"}};

class NodeWalkTest : public ::testing::TestWithParam<Kind> {
protected:
    static constexpr float kColor[] = {0.25F, 0.5F, 0.75F};

    /// Holds until the next is added.
    MaterialNode& AddNode(const std::string& path, const std::string& id) {
        _network.nodes.push_back({path, id, {}, {}});
        return _network.nodes.back();
    }

    static std::string Level(int i) { return "/m/level" + std::to_string(i); }

    /// Levels 1 to kNumLevels above "/m/level0".
    void AddLevels(const Kind& kind) {
        for (int i = 1; i <= kNumLevels; ++i) {
            MaterialNode& node = AddNode(Level(i), kind.id);
            node.parameters["mix"] = 0.5;
            for (const char* input : kind.inputs) {
                node.connections[input] = {Level(i - 1), "out"};
            }
        }
    }

    /// The material is what is at `path`.
    void AddSurface(const Kind& kind, const std::string& path) {
        const std::string name = kind.name;
        if (name == "surface") {
            _network.terminals["surface"] = {path, "out"};
            return;
        }
        MaterialNode& surface =
            AddNode("/m/s", name == "matrix" ? "ND_surface_unlit" : "ND_surface");
        _network.terminals["surface"] = {"/m/s", "out"};
        if (name == "matrix") {
            surface.connections["emission"] = {"/m/determinant", "out"};
            AddNode("/m/determinant", "ND_determinant_matrix33").connections["in"] = {path, "out"};
        } else {
            surface.connections[name] = {path, "out"};
        }
    }

    CompiledMaterial Compile() {
        return CompileMaterial(_network, "/m", test::Images(), _warnings);
    }

    static void ExpectColor(const shared::float4& color, float scale) {
        EXPECT_FLOAT_EQ(color.x, scale * kColor[0]);
        EXPECT_FLOAT_EQ(color.y, scale * kColor[1]);
        EXPECT_FLOAT_EQ(color.z, scale * kColor[2]);
    }

    MaterialNetwork _network;
    Warnings _warnings;
};

TEST_F(NodeWalkTest, AMixOfAClosureWithItselfIsThatClosure) {
    AddNode(Level(0), "ND_oren_nayar_diffuse_bsdf").parameters["color"] =
        std::vector<float>(std::begin(kColor), std::end(kColor));
    AddLevels(kBsdf);
    AddSurface(kBsdf, Level(kNumLevels));
    ExpectColor(Compile().constants.constants[HDS_INPUT_DIFFUSE_COLOR], 1.0F);
    EXPECT_TRUE(_warnings.Lines().empty());
}

TEST_F(NodeWalkTest, AMixOfASurfaceWithItselfIsThatSurface) {
    MaterialNode& standard = AddNode(Level(0), "ND_standard_surface_surfaceshader");
    standard.parameters["base"] = 1.0;
    standard.parameters["base_color"] = std::vector<float>(std::begin(kColor), std::end(kColor));
    AddLevels(kSurface);
    AddSurface(kSurface, Level(kNumLevels));
    ExpectColor(Compile().constants.constants[HDS_INPUT_DIFFUSE_COLOR], 1.0F);
    EXPECT_TRUE(_warnings.Lines().empty());
}

TEST_F(NodeWalkTest, EmissionsThatAreAddedToThemselvesDouble) {
    AddNode(Level(0), "ND_uniform_edf").parameters["color"] =
        std::vector<float>(std::begin(kColor), std::end(kColor));
    AddLevels(kEdf);
    AddSurface(kEdf, Level(kNumLevels));
    ExpectColor(Compile().constants.constants[HDS_INPUT_EMISSIVE_COLOR],
                std::ldexp(1.0F, kNumLevels));
    EXPECT_TRUE(_warnings.Lines().empty());
}

TEST_F(NodeWalkTest, MatricesThatAreAddedToThemselvesDouble) {
    AddNode(Level(0), "ND_creatematrix_vector3_matrix33");
    AddLevels(kMatrix);
    AddSurface(kMatrix, Level(kNumLevels));
    const CompiledMaterial compiled = Compile();
    EXPECT_FLOAT_EQ(compiled.constants.constants[HDS_INPUT_EMISSIVE_COLOR].x,
                    std::ldexp(1.0F, 3 * kNumLevels));
    EXPECT_TRUE(_warnings.Lines().empty());
}

/// Functions are as deep as their chain, and so is what walks through them.
TEST_F(NodeWalkTest, LongChainsEndWithAWarning) {
    MaterialNode& surface = AddNode("/m/s", "ND_surface_unlit");
    _network.terminals["surface"] = {"/m/s", "out"};
    surface.connections["emission"] = {Level(1000), "out"};
    for (int i = 1; i <= 50000; ++i) {
        MaterialNode& node = AddNode(Level(i), "ND_add_float");
        node.parameters["in2"] = 1.0;
        node.connections["in1"] = {Level(i - 1), "out"};
    }
    AddNode(Level(0), "ND_constant_float");
    EXPECT_FLOAT_EQ(Compile().constants.constants[HDS_INPUT_EMISSIVE_COLOR].x, 1000.0F);
    EXPECT_TRUE(_warnings.Lines().empty());

    _network.nodes[0].connections["emission"] = {Level(50000), "out"};
    Compile();
    ASSERT_EQ(_warnings.Lines().size(), 1U);
    EXPECT_NE(_warnings.Lines()[0].find("nodes in a row"), std::string::npos)
        << _warnings.Lines()[0];
}

TEST_P(NodeWalkTest, CyclesThroughTwoInputsEndWithAWarning) {
    AddLevels(GetParam());
    MaterialNode& first = AddNode(Level(0), GetParam().id);
    for (const char* input : GetParam().inputs) {
        first.connections[input] = {Level(kNumLevels), "out"};
    }
    AddSurface(GetParam(), Level(kNumLevels));
    Compile();
    ASSERT_FALSE(_warnings.Lines().empty());
    EXPECT_NE(_warnings.Lines()[0].find("form a cycle"), std::string::npos) << _warnings.Lines()[0];
}

INSTANTIATE_TEST_SUITE_P(Kinds, NodeWalkTest, ::testing::Values(kBsdf, kEdf, kSurface, kMatrix),
                         [](const auto& info) { return std::string(info.param.name); });

} // namespace
} // namespace hds
