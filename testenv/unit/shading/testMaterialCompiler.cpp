// SPDX-License-Identifier: Apache-2.0
// UsdPreviewSurface networks to material records: defaults, readers and bad content. Programs are
// in testShaderProgram.cpp.
#include "hdStream/shading/materialCompiler.h"

#include "hdStream/shading/materialPrimvars.h"

#include "kernels/shared/geometry.h"
#include "testenv/unit/shading/imageQueries.h"

#include <gtest/gtest.h>

#include <algorithm>
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

CompiledMaterial Compile(const MaterialNetwork& network, Warnings& warnings) {
    return CompileMaterial(network, "/m", test::Images(), warnings);
}

shared::HdsMaterial Resolve(const CompiledMaterial& material,
                            const std::vector<AttributeName>& attributes, Warnings& warnings) {
    return ResolveMaterial(material, {}, attributes, {}, "/mesh", warnings).record;
}

/// Inputs that are no constants.
std::size_t NumValues(const CompiledMaterial& material) {
    return static_cast<std::size_t>(
        std::count_if(material.values.begin(), material.values.end(),
                      [](const ShaderValue& value) { return bool(value); }));
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
    EXPECT_EQ(NumValues(m), 0U);
    EXPECT_EQ(Resolve(m, {}, warnings).flags, 0U);
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
    EXPECT_EQ(Resolve(m, {}, warnings).flags, HDS_MATERIAL_SPECULAR_WORKFLOW | HDS_MATERIAL_CUTOUT |
                                                  HDS_MATERIAL_EMISSIVE | HDS_MATERIAL_NORMAL);
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
    ASSERT_EQ(NumValues(m), 2U);

    const shared::HdsMaterial bound =
        Resolve(m, {{"a", 1}, {"displayColor", 3}, {"mask", 1}}, warnings);
    EXPECT_EQ(bound.slots[HDS_INPUT_DIFFUSE_COLOR], HDS_SLOT_USER + 1);
    EXPECT_EQ(bound.slots[HDS_INPUT_OPACITY], HDS_SLOT_USER + 2);
    EXPECT_TRUE(bound.flags & HDS_MATERIAL_CUTOUT);

    const shared::HdsMaterial unbound = Resolve(m, {{"a", 1}}, warnings);
    EXPECT_EQ(unbound.slots[HDS_INPUT_DIFFUSE_COLOR], HDS_NONE);
    EXPECT_FLOAT_EQ(unbound.constants[HDS_INPUT_DIFFUSE_COLOR].x, 0.7F);
    EXPECT_FLOAT_EQ(unbound.constants[HDS_INPUT_OPACITY].x, 0.0F) << "a reader's default fallback";
    EXPECT_TRUE(warnings.Lines().empty()) << "a missing primvar is what fallbacks are for";

    Resolve(m, {{"displayColor", 1}}, warnings);
    ASSERT_EQ(warnings.Lines().size(), 1U);
    EXPECT_EQ(warnings.Lines()[0].rfind("/mesh", 0), 0U);
}

TEST(MaterialCompilerTest, UnreadableTexturesFallBack) {
    MaterialNetwork network = Preview();
    Surface(network).connections["diffuseColor"] = {"/m/t", "rgb"};
    Surface(network).connections["roughness"] = {"/m/t", "g"};
    AddTexture(network, "missing.png").parameters["fallback"] =
        std::vector<float>{0.3F, 0.2F, 0.1F, 1.0F};
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    EXPECT_EQ(NumValues(m), 0U);
    ExpectConstant(m, HDS_INPUT_DIFFUSE_COLOR, 0.3F, 0.2F, 0.1F);
    EXPECT_FLOAT_EQ(m.constants.constants[HDS_INPUT_ROUGHNESS].x, 0.2F);
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
            Resolve(m, {{"displayColor", 3}, {"displayOpacity", 1}}, warnings);
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
    EXPECT_EQ(NumValues(m), 1U);
    EXPECT_EQ(warnings.Lines().size(), 1U);
}

TEST(MaterialCompilerTest, ReadersFallBackToWhatTheirFallbackIsConnectedTo) {
    MaterialNetwork network = Preview();
    Surface(network).connections["diffuseColor"] = {"/m/r", "result"};
    MaterialNode& reader = AddNode(network, "/m/r", "UsdPrimvarReader_float3");
    reader.parameters["varname"] = std::string("c");
    reader.connections["fallback"] = {"/m/q", "result"};
    MaterialNode& other = AddNode(network, "/m/q", "UsdPrimvarReader_float3");
    other.parameters["varname"] = std::string("d");
    other.parameters["fallback"] = std::vector<float>{0.1F, 0.2F, 0.4F};
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    EXPECT_EQ(Resolve(m, {{"c", 3}, {"d", 3}}, warnings).slots[HDS_INPUT_DIFFUSE_COLOR],
              HDS_SLOT_USER);
    EXPECT_EQ(Resolve(m, {{"d", 3}}, warnings).slots[HDS_INPUT_DIFFUSE_COLOR], HDS_SLOT_USER);
    const shared::HdsMaterial neither = Resolve(m, {}, warnings);
    EXPECT_EQ(neither.slots[HDS_INPUT_DIFFUSE_COLOR], HDS_NONE);
    EXPECT_FLOAT_EQ(neither.constants[HDS_INPUT_DIFFUSE_COLOR].z, 0.4F);
    EXPECT_TRUE(warnings.Lines().empty());
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

TEST(MaterialCompilerTest, ConstantsOfAnotherWidthAreReadAndNamed) {
    MaterialNetwork network = Preview();
    auto& p = Surface(network).parameters;
    p["diffuseColor"] = 0.25;
    p["emissiveColor"] = std::vector<float>{0.1F, 0.2F, 0.3F, 0.4F};
    p["metallic"] = std::vector<float>{0.75F, 0.5F, 0.25F};
    p["displacement"] = std::vector<float>{0.5F, 0.0F};
    p["ior"] = 1.25;
    Surface(network).connections["opacity"] = {"/m/t", "a"};
    MaterialNode& texture = AddTexture(network, "opaque.png");
    texture.parameters["bias"] = std::vector<float>{0.0F, 0.0F, 0.0F};
    texture.parameters["wrapS"] = texture.parameters["wrapT"] = std::string("repeat");
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    ExpectConstant(m, HDS_INPUT_DIFFUSE_COLOR, 0.25F, 0.25F, 0.25F);
    ExpectConstant(m, HDS_INPUT_EMISSIVE_COLOR, 0.1F, 0.2F, 0.3F);
    EXPECT_FLOAT_EQ(m.constants.constants[HDS_INPUT_METALLIC].x, 0.75F);
    EXPECT_FLOAT_EQ(m.displacement.constant, 0.5F);
    EXPECT_FLOAT_EQ(m.constants.constants[HDS_INPUT_OPACITY].x, 1.0F)
        << "the fourth number of a bias is 0";
    const std::vector<std::string> expected = {
        "/m: input bias of /m/t has 3 numbers in place of 4",
        "/m: input diffuseColor of /m/s has 1 number in place of 3",
        "/m: input displacement of /m/s has 2 numbers in place of 1",
        "/m: input emissiveColor of /m/s has 4 numbers in place of 3",
        "/m: input metallic of /m/s has 3 numbers in place of 1"};
    std::vector<std::string> lines = warnings.Lines();
    std::sort(lines.begin(), lines.end());
    EXPECT_EQ(lines, expected);
}

TEST(MaterialCompilerTest, ConstantsOfAnotherWidthAreNamedOnLayeredSurfacesAndNodes) {
    MaterialNetwork network;
    network.nodes.push_back({"/m/s", "ND_standard_surface_surfaceshader", {}, {}});
    network.terminals["surface"] = {"/m/s", "surface"};
    network.nodes[0].parameters["specular_roughness"] = std::vector<float>{0.5F, 0.5F, 0.5F};
    network.nodes[0].parameters["opacity"] = 0.5;
    network.nodes[0].connections["base_color"] = {"/m/r", "result"};
    MaterialNode& reader = AddNode(network, "/m/r", "UsdPrimvarReader_float3");
    reader.parameters["varname"] = std::string("tint");
    reader.parameters["fallback"] = 0.5;
    Warnings warnings;
    Compile(network, warnings);
    std::vector<std::string> lines = warnings.Lines();
    std::sort(lines.begin(), lines.end());
    const std::vector<std::string> expected = {
        "/m: input fallback of /m/r has 1 number in place of 3",
        "/m: input opacity of /m/s has 1 number in place of 3",
        "/m: input specular_roughness of /m/s has 3 numbers in place of 1"};
    EXPECT_EQ(lines, expected);
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
    EXPECT_EQ(Compile(constant, warnings).displacement, (DisplacementInput{0.25F, "", {}}));
    MaterialNetwork reader = Preview();
    Surface(reader).connections["displacement"] = {"/m/reader", "result"};
    MaterialNode& node = AddNode(reader, "/m/reader", "UsdPrimvarReader_float");
    node.parameters["varname"] = std::string("bumps");
    node.parameters["fallback"] = 0.5;
    EXPECT_EQ(Compile(reader, warnings).displacement, (DisplacementInput{0.5F, "bumps", {}}));
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST(MaterialCompilerTest, DisplacementMayBeLookedUp) {
    MaterialNetwork network = Preview();
    network.nodes.reserve(8);
    Surface(network).connections["displacement"] = {"/m/t", "g"};
    MaterialNode& texture = AddTexture(network, "a.png");
    texture.parameters["wrapS"] = std::string("repeat");
    texture.parameters["scale"] = std::vector<float>{1.0F, 2.0F, 3.0F, 4.0F};
    texture.parameters["bias"] = std::vector<float>{0.1F, 0.2F, 0.3F, 0.4F};
    texture.parameters["fallback"] = std::vector<float>{5.0F, 6.0F, 7.0F, 8.0F};
    texture.connections["st"] = {"/m/x", "result"};
    MaterialNode& outer = AddNode(network, "/m/x", "UsdTransform2d");
    outer.connections["in"] = {"/m/y", "result"};
    outer.parameters["translation"] = std::vector<float>{0.5F, 0.25F};
    MaterialNode& inner = AddNode(network, "/m/y", "UsdTransform2d");
    inner.connections["in"] = {"/m/r", "result"};
    inner.parameters["scale"] = std::vector<float>{2.0F, 4.0F};
    AddNode(network, "/m/r", "UsdPrimvarReader_float2").parameters["varname"] = std::string("st");
    AddNode(network, "/m/scale", "UsdPrimvarReader_float4").parameters["varname"] =
        std::string("s");
    Warnings warnings;
    const CompiledMaterial m = Compile(network, warnings);
    EXPECT_EQ(m.displacement.primvar, "st");
    EXPECT_FLOAT_EQ(m.displacement.constant, 6.0F);
    ASSERT_TRUE(m.displacement.lookup);
    const DisplacementLookup& lookup = *m.displacement.lookup;
    EXPECT_EQ(lookup.texture.file.file, "a.png");
    EXPECT_EQ(lookup.channel, 1U);
    EXPECT_EQ(lookup.wrapS, HDS_WRAP_REPEAT);
    EXPECT_EQ(lookup.wrapT, HDS_WRAP_BLACK);
    EXPECT_EQ(lookup.rows, (std::array<double, 6>{2, 0, 0.5, 0, 4, 0.25}));
    EXPECT_FLOAT_EQ(lookup.scale, 2.0F);
    EXPECT_FLOAT_EQ(lookup.bias, 0.2F);
    EXPECT_TRUE(m.textures.empty()) << "no kernel reads it";
    EXPECT_TRUE(warnings.Lines().empty());

    texture.connections["scale"] = {"/m/scale", "result"};
    const CompiledMaterial other = Compile(network, warnings);
    EXPECT_FALSE(other.displacement.lookup);
    ASSERT_TRUE(other.displacement.network) << "a scale that varies";
    EXPECT_EQ(other.displacement.network->primvars.size(), 2U);
    EXPECT_EQ(PrimvarsOf(other), (std::set<std::string>{"s", "st"}));
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST(MaterialCompilerTest, DisplacementByWhatTheHostCannotEvaluateWarns) {
    MaterialNetwork network = Preview();
    Surface(network).connections["displacement"] = {"/m/facing", "out"};
    AddNode(network, "/m/facing", "ND_facingratio_float");
    Warnings warnings;
    EXPECT_EQ(Compile(network, warnings).displacement, DisplacementInput());
    EXPECT_EQ(warnings.Lines().back(), "/m: displacement by a network with normals, tangents, "
                                       "directions or slopes is ignored");
}

/// Where nothing is reflected the program has no Schlick's term, and scenes no kernels for it.
TEST(MaterialCompilerTest, SchlicksTermIsOfReflectionsThatAreThere) {
    for (const double weight : {1.0, 0.0}) {
        MaterialNetwork network;
        AddNode(network, "/m/surface", "ND_surface").connections["bsdf"] = {"/m/mirror", "out"};
        network.terminals["surface"] = {"/m/surface", "out"};
        MaterialNode& mirror = AddNode(network, "/m/mirror", "ND_generalized_schlick_bsdf");
        mirror.parameters["exponent"] = 3.0;
        mirror.parameters["weight"] = weight;
        Warnings warnings;
        const CompiledMaterial m = Compile(network, warnings);
        EXPECT_EQ((m.constants.lobes & HDS_LOBE_SCHLICK) != 0, weight > 0.0) << weight;
        EXPECT_TRUE(warnings.Lines().empty());
    }
}

} // namespace
} // namespace hds
