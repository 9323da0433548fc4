// SPDX-License-Identifier: Apache-2.0
// UsdPreviewSurface networks to material records: defaults, readers, textures, and bad content.
#include "hdStream/shading/materialCompiler.h"

#include "kernels/shared/geometry.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hds {
namespace {

/// A network with a UsdPreviewSurface "/m/s" as its surface.
MaterialNetwork Preview() {
    MaterialNetwork network;
    network.nodes.push_back({"/m/s", "UsdPreviewSurface", {}, {}});
    network.terminals["surface"] = {"/m/s", "surface"};
    return network;
}

MaterialNode& Surface(MaterialNetwork& network) {
    return network.nodes[0];
}

MaterialNode& AddNode(MaterialNetwork& network, const std::string& path, const std::string& id) {
    network.nodes.push_back({path, id, {}, {}});
    return network.nodes.back();
}

MaterialNode& AddTexture(MaterialNetwork& network, const std::string& file) {
    MaterialNode& node = AddNode(network, "/m/t", "UsdUVTexture");
    node.parameters["file"] = AssetReference{file, file, 0, 0};
    return node;
}

std::optional<std::array<float, 4>> Mean(const AssetReference& file, const std::string& space) {
    if (file.file == "missing.png") {
        return std::nullopt;
    }
    return std::array<float, 4>{0.1F, 0.2F, 0.4F, space == "raw" ? 0.5F : 0.8F};
}

CompiledMaterial Compile(const MaterialNetwork& network, Warnings& warnings) {
    return CompileMaterial(network, "/m", Mean, warnings);
}

void ExpectConstant(const CompiledMaterial& material, std::uint32_t input, float x, float y,
                    float z) {
    const shared::float4& c = material.constants.constants[input];
    EXPECT_FLOAT_EQ(c.x, x);
    EXPECT_FLOAT_EQ(c.y, y);
    EXPECT_FLOAT_EQ(c.z, z);
}

TEST(MaterialCompilerTest, DefaultsAreTheSpecifications) {
    Warnings warnings;
    const CompiledMaterial m = Compile(Preview(), warnings);
    ExpectConstant(m, HDS_INPUT_DIFFUSE_COLOR, 0.18F, 0.18F, 0.18F);
    ExpectConstant(m, HDS_INPUT_EMISSIVE_COLOR, 0, 0, 0);
    ExpectConstant(m, HDS_INPUT_SPECULAR_COLOR, 0, 0, 0);
    ExpectConstant(m, HDS_INPUT_NORMAL, 0, 0, 1);
    ExpectConstant(m, HDS_INPUT_METALLIC, 0, 0, 0);
    ExpectConstant(m, HDS_INPUT_ROUGHNESS, 0.5F, 0, 0);
    ExpectConstant(m, HDS_INPUT_CLEARCOAT, 0, 0, 0);
    ExpectConstant(m, HDS_INPUT_CLEARCOAT_ROUGHNESS, 0.01F, 0, 0);
    ExpectConstant(m, HDS_INPUT_OPACITY, 1, 0, 0);
    ExpectConstant(m, HDS_INPUT_OPACITY_THRESHOLD, 0, 0, 0);
    ExpectConstant(m, HDS_INPUT_IOR, 1.5F, 0, 0);
    EXPECT_TRUE(m.readers.empty());
    EXPECT_EQ(ResolveMaterial(m, {}, "/mesh", warnings).flags, 0U);
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST(MaterialCompilerTest, ParametersOfAllTypesAreRead) {
    MaterialNetwork network = Preview();
    auto& p = Surface(network).parameters;
    p["diffuseColor"] = std::vector<float>{0.1F, 0.2F, 0.3F};
    p["roughness"] = 0.25;
    p["metallic"] = std::int64_t(1);
    p["useSpecularWorkflow"] = std::int64_t(1);
    p["opacity"] = 0.5;
    p["emissiveColor"] = std::vector<float>{0.0F, 2.0F, 0.0F};
    p["normal"] = std::vector<float>{0.1F, 0.0F, 1.0F};
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    ExpectConstant(m, HDS_INPUT_DIFFUSE_COLOR, 0.1F, 0.2F, 0.3F);
    ExpectConstant(m, HDS_INPUT_METALLIC, 1, 0, 0);
    EXPECT_EQ(ResolveMaterial(m, {}, "/mesh", warnings).flags,
              HDS_MATERIAL_SPECULAR_WORKFLOW | HDS_MATERIAL_CUTOUT | HDS_MATERIAL_EMISSIVE |
                  HDS_MATERIAL_NORMAL);
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST(MaterialCompilerTest, ReadersResolveToSlotsOrFallBack) {
    MaterialNetwork network = Preview();
    Surface(network).connections["diffuseColor"] = {"/m/r", "result"};
    Surface(network).connections["opacity"] = {"/m/q", "result"};
    MaterialNode& color = AddNode(network, "/m/r", "UsdPrimvarReader_float3");
    color.parameters["varname"] = std::string("displayColor");
    color.parameters["fallback"] = std::vector<float>{0.7F, 0.6F, 0.5F};
    AddNode(network, "/m/q", "UsdPrimvarReader_float").parameters["varname"] = std::string("mask");
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    ASSERT_EQ(m.readers.size(), 2U);

    const shared::HdsMaterial bound =
        ResolveMaterial(m, {{"a", 1}, {"displayColor", 3}, {"mask", 1}}, "/mesh", warnings);
    EXPECT_EQ(bound.slots[HDS_INPUT_DIFFUSE_COLOR], HDS_SLOT_USER + 1);
    EXPECT_EQ(bound.slots[HDS_INPUT_OPACITY], HDS_SLOT_USER + 2);
    EXPECT_TRUE(bound.flags & HDS_MATERIAL_CUTOUT);

    const shared::HdsMaterial unbound = ResolveMaterial(m, {{"a", 1}}, "/mesh", warnings);
    EXPECT_EQ(unbound.slots[HDS_INPUT_DIFFUSE_COLOR], HDS_NONE);
    EXPECT_FLOAT_EQ(unbound.constants[HDS_INPUT_DIFFUSE_COLOR].x, 0.7F);
    EXPECT_FLOAT_EQ(unbound.constants[HDS_INPUT_OPACITY].x, 0.0F) << "a reader's default fallback";
    EXPECT_TRUE(warnings.Lines().empty()) << "a missing primvar is what fallbacks are for";

    ResolveMaterial(m, {{"displayColor", 1}}, "/mesh", warnings);
    ASSERT_EQ(warnings.Lines().size(), 1U);
    EXPECT_EQ(warnings.Lines()[0].rfind("/mesh", 0), 0U);
}

TEST(MaterialCompilerTest, TexturesBecomeTheirMeanWithOneWarning) {
    MaterialNetwork network = Preview();
    Surface(network).connections["diffuseColor"] = {"/m/t", "rgb"};
    Surface(network).connections["roughness"] = {"/m/t", "g"};
    Surface(network).connections["opacity"] = {"/m/t", "a"};
    MaterialNode& texture = AddTexture(network, "wood.png");
    texture.parameters["scale"] = std::vector<float>{2.0F, 2.0F, 2.0F, 1.0F};
    texture.parameters["bias"] = std::vector<float>{0.0F, 0.1F, 0.0F, 0.0F};
    texture.parameters["sourceColorSpace"] = std::string("raw");
    texture.connections["st"] = {"/m/x", "result"};
    AddNode(network, "/m/x", "UsdTransform2d");
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    ExpectConstant(m, HDS_INPUT_DIFFUSE_COLOR, 0.2F, 0.5F, 0.8F);
    EXPECT_FLOAT_EQ(m.constants.constants[HDS_INPUT_ROUGHNESS].x, 0.5F);
    EXPECT_FLOAT_EQ(m.constants.constants[HDS_INPUT_OPACITY].x, 0.5F);
    ASSERT_EQ(warnings.Lines().size(), 1U);
    EXPECT_NE(warnings.Lines()[0].find("wood.png"), std::string::npos);
}

TEST(MaterialCompilerTest, UnreadableTexturesFallBack) {
    MaterialNetwork network = Preview();
    Surface(network).connections["diffuseColor"] = {"/m/t", "rgb"};
    AddTexture(network, "missing.png").parameters["fallback"] =
        std::vector<float>{0.3F, 0.2F, 0.1F, 1.0F};
    Warnings warnings;
    ExpectConstant(Compile(network, warnings), HDS_INPUT_DIFFUSE_COLOR, 0.3F, 0.2F, 0.1F);
    ASSERT_EQ(warnings.Lines().size(), 1U);
    EXPECT_EQ(warnings.Lines()[0].rfind("/m: ", 0), 0U);
    EXPECT_NE(warnings.Lines()[0].find("missing.png"), std::string::npos);

    network.nodes[1].parameters.erase("file");
    Warnings unnamed;
    ExpectConstant(Compile(network, unnamed), HDS_INPUT_DIFFUSE_COLOR, 0.3F, 0.2F, 0.1F);
    EXPECT_EQ(unnamed.Lines().size(), 1U);
}

TEST(MaterialCompilerTest, UnknownOrMissingSurfacesBecomeDisplayColor) {
    MaterialNetwork unknown = Preview();
    Surface(unknown).identifier = "ArnoldStandardSurface";
    MaterialNetwork missing;
    MaterialNetwork dangling;
    dangling.terminals["surface"] = {"/nowhere", "surface"};
    for (const MaterialNetwork& network : {unknown, missing, dangling}) {
        Warnings warnings;
        const CompiledMaterial m = Compile(network, warnings);
        EXPECT_EQ(warnings.Lines().size(), 1U);
        EXPECT_TRUE(m.constants.flags & HDS_MATERIAL_LAMBERT);
        ExpectConstant(m, HDS_INPUT_DIFFUSE_COLOR, 0.5F, 0.5F, 0.5F);
        const shared::HdsMaterial bound =
            ResolveMaterial(m, {{"displayColor", 3}, {"displayOpacity", 1}}, "/mesh", warnings);
        EXPECT_EQ(bound.slots[HDS_INPUT_DIFFUSE_COLOR], HDS_SLOT_USER);
        EXPECT_EQ(bound.slots[HDS_INPUT_OPACITY], HDS_SLOT_USER + 1);
    }
}

TEST(MaterialCompilerTest, CyclesEndWithAWarning) {
    MaterialNetwork network = Preview();
    Surface(network).connections["diffuseColor"] = {"/m/r", "result"};
    MaterialNode& reader = AddNode(network, "/m/r", "UsdPrimvarReader_float3");
    reader.parameters["varname"] = std::string("c");
    reader.connections["fallback"] = {"/m/r", "result"};
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    EXPECT_EQ(m.readers.size(), 1U);
    EXPECT_EQ(warnings.Lines().size(), 1U);
}

TEST(MaterialCompilerTest, ReadersFallBackToWhatTheirFallbackIsConnectedTo) {
    MaterialNetwork network = Preview();
    Surface(network).connections["diffuseColor"] = {"/m/r", "result"};
    MaterialNode& reader = AddNode(network, "/m/r", "UsdPrimvarReader_float3");
    reader.parameters["varname"] = std::string("c");
    reader.connections["fallback"] = {"/m/t", "rgb"};
    AddTexture(network, "wood.png");
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    ASSERT_EQ(m.readers.size(), 1U);
    ExpectConstant(m, HDS_INPUT_DIFFUSE_COLOR, 0.1F, 0.2F, 0.4F);
}

TEST(MaterialCompilerTest, WrongTypesAndValuesWarnAndKeepTheDefault) {
    const std::pair<const char*, ParameterValue> bad[] = {
        {"diffuseColor", std::string("red")},
        {"diffuseColor", std::vector<float>{1.0F, 2.0F}},
        {"diffuseColor", std::vector<float>{NAN, 0.0F, 0.0F}},
        {"roughness", std::string("rough")},
        {"roughness", double(INFINITY)}};
    for (const auto& [name, value] : bad) {
        MaterialNetwork network = Preview();
        Surface(network).parameters[name] = value;
        Warnings warnings;
        const CompiledMaterial m = Compile(network, warnings);
        EXPECT_EQ(warnings.Lines().size(), 1U) << name;
        ExpectConstant(m, HDS_INPUT_DIFFUSE_COLOR, 0.18F, 0.18F, 0.18F);
        EXPECT_FLOAT_EQ(m.constants.constants[HDS_INPUT_ROUGHNESS].x, 0.5F);
    }
}

TEST(MaterialCompilerTest, UnknownUpstreamNodesKeepTheAuthoredValue) {
    for (const char* upstream : {"/m/noise", "/m/absent"}) {
        MaterialNetwork network = Preview();
        Surface(network).parameters["roughness"] = 0.3;
        Surface(network).connections["roughness"] = {upstream, "out"};
        AddNode(network, "/m/noise", "PxrFractal");
        Warnings warnings;
        const CompiledMaterial m = Compile(network, warnings);
        EXPECT_FLOAT_EQ(m.constants.constants[HDS_INPUT_ROUGHNESS].x, 0.3F);
        EXPECT_EQ(warnings.Lines().size(), 1U);
    }
}

TEST(MaterialCompilerTest, DisplacementIsAConstantOrAPrimvar) {
    Warnings warnings;
    EXPECT_EQ(Compile(Preview(), warnings).displacement, DisplacementInput());
    MaterialNetwork constant = Preview();
    Surface(constant).parameters["displacement"] = 0.25;
    EXPECT_EQ(Compile(constant, warnings).displacement, (DisplacementInput{0.25F, ""}));
    MaterialNetwork reader = Preview();
    Surface(reader).connections["displacement"] = {"/m/reader", "result"};
    MaterialNode& node = AddNode(reader, "/m/reader", "UsdPrimvarReader_float");
    node.parameters["varname"] = std::string("bumps");
    node.parameters["fallback"] = 0.5;
    EXPECT_EQ(Compile(reader, warnings).displacement, (DisplacementInput{0.5F, "bumps"}));
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST(MaterialCompilerTest, DisplacementByATextureWarnsOnce) {
    MaterialNetwork network = Preview();
    Surface(network).connections["displacement"] = {"/m/texture", "r"};
    AddNode(network, "/m/texture", "UsdUVTexture");
    Warnings warnings;
    EXPECT_EQ(Compile(network, warnings).displacement, DisplacementInput());
    Compile(network, warnings);
    EXPECT_EQ(warnings.Lines(),
              std::vector<std::string>{"/m: displacement by a texture is ignored"});
}

} // namespace
} // namespace hds
