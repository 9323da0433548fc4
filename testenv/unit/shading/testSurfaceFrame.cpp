// SPDX-License-Identifier: Apache-2.0
// Tangents and normals of networks: which are known to be constants, or need no pattern, and
// networks that are cycles. What they look like is in render/test_tangents.py.
#include "hdStream/shading/materialCompiler.h"
#include "hdStream/shading/programWriter.h"
#include "testenv/unit/shading/imageQueries.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace hds {
namespace {

class SurfaceFrameTest : public ::testing::Test {
protected:
    SurfaceFrameTest() {
        MaterialNode& surface = AddNode("/m/s", "ND_standard_surface_surfaceshader");
        surface.parameters["metalness"] = 1.0;
        surface.parameters["specular_anisotropy"] = 0.5;
        surface.connections["tangent"] = {"/m/t", "out"};
        _network.terminals["surface"] = {"/m/s", "out"};
        AddNode("/m/own", "ND_tangent_vector3").parameters["space"] = std::string("world");
        AddNode("/m/n", "ND_normal_vector3").parameters["space"] = std::string("world");
    }

    /// Holds until the next is added.
    MaterialNode& AddNode(const std::string& path, const std::string& id) {
        _network.nodes.push_back({path, id, {}, {}});
        return _network.nodes.back();
    }

    /// What turns the tangent `of` by 36 degrees about `axis`.
    void AddTurn(const char* of, const char* axis) {
        MaterialNode& turn = AddNode("/m/t", "ND_rotate3d_vector3");
        turn.parameters["amount"] = 36.0;
        turn.connections["in"] = {of, "out"};
        turn.connections["axis"] = {axis, "out"};
    }

    void Compile() { _compiled = CompileMaterial(_network, "/m", test::Images(), _warnings); }

    const ShaderValue& Stretch() const { return _compiled.values[HDS_INPUT_STRETCH]; }

    void ExpectOneCycle() const {
        ASSERT_EQ(_warnings.Lines().size(), 1U);
        EXPECT_NE(_warnings.Lines()[0].find("form a cycle"), std::string::npos)
            << _warnings.Lines()[0];
    }

    MaterialNetwork _network;
    CompiledMaterial _compiled;
    Warnings _warnings;
};

TEST_F(SurfaceFrameTest, TurnsAboutTheNormalAreConstants) {
    AddTurn("/m/own", "/m/n");
    Compile();
    ASSERT_TRUE(IsConstant(Stretch()));
    EXPECT_FLOAT_EQ(ConstantOf(Stretch())[2], -0.1F);
    EXPECT_TRUE(_warnings.Lines().empty());
}

TEST_F(SurfaceFrameTest, TurnsAboutATangentAreNot) {
    AddTurn("/m/own", "/m/own");
    Compile();
    EXPECT_FALSE(IsConstant(Stretch()));
}

TEST_F(SurfaceFrameTest, OnlyTangentsOfTheFirstCoordinatesAreTheSurfaces) {
    for (const std::int64_t index : {0, 1}) {
        AddNode("/m/t", "ND_tangent_vector3").parameters["index"] = index;
        Compile();
        EXPECT_EQ(IsConstant(Stretch()), index == 0) << index;
        _network.nodes.pop_back();
    }
    AddNode("/m/t", "ND_tangent_vector3").connections["index"] = {"/m/index", "out"};
    AddNode("/m/index", "ND_geompropvalue_integer").parameters["geomprop"] = std::string("k");
    Compile();
    EXPECT_FALSE(IsConstant(Stretch()));
}

TEST_F(SurfaceFrameTest, CyclesOfNormalizeEnd) {
    AddNode("/m/t", "ND_normalize_vector3").connections["in"] = {"/m/t", "out"};
    Compile();
    ExpectOneCycle();
}

TEST_F(SurfaceFrameTest, CyclesOfRotationsEnd) {
    AddTurn("/m/t", "/m/n");
    Compile();
    ExpectOneCycle();
}

TEST_F(SurfaceFrameTest, CyclesOfAxesEnd) {
    AddTurn("/m/own", "/m/axis");
    AddNode("/m/axis", "ND_normalize_vector3").connections["in"] = {"/m/axis", "out"};
    Compile();
    ExpectOneCycle();
}

/// Kernels with patterns are slower: nothing has to ask whether the texels of a map are 0.
TEST_F(SurfaceFrameTest, PlainNormalMapsOfCoatsAreNoPatterns) {
    _network.nodes[0].connections["tangent"] = {"/m/own", "out"};
    _network.nodes[0].parameters["coat"] = 1.0;
    _network.nodes[0].connections["coat_normal"] = {"/m/map", "out"};
    AddNode("/m/map", "ND_normalmap").connections["in"] = {"/m/image", "out"};
    AddNode("/m/image", "ND_image_vector3").parameters["file"] =
        AssetReference{"map.png", "map.png", 0, 0};
    Compile();
    const auto program =
        ResolveMaterial(_compiled, {7}, {{"st", 2}}, {}, "/mesh", _warnings).program;
    EXPECT_TRUE(_warnings.Lines().empty());
    EXPECT_EQ(CountLookups(program), 1U);
    EXPECT_FALSE(HasPatterns(program));
}

} // namespace
} // namespace hds
