// SPDX-License-Identifier: Apache-2.0
// Networks with textures to programs: what is looked up and how, outputs, transforms, UDIM sets,
// folding, sharing and limits. Programs are read back by a disassembler of this file.
#include "hdStream/shading/materialCompiler.h"
#include "hdStream/shading/materialPrimvars.h"
#include "hdStream/shading/programWriter.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/programMath.h"
#include "testenv/unit/shading/imageQueries.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <sstream>
#include <string>

namespace hds {
namespace {

float AsFloat(std::uint32_t word) {
    float value = 0.0F;
    std::memcpy(&value, &word, sizeof(value));
    return value;
}

/// A program as text, one instruction after another: "coords 3; texture 5 wrap 2,1 ...".
std::string Disassemble(const std::vector<std::uint32_t>& words) {
    std::ostringstream text;
    const auto floats = [&](std::size_t at, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            text << (i == 0 ? " " : ",") << AsFloat(words.at(at + i));
        }
    };
    for (std::size_t at = 0; at < words.size();) {
        const std::uint32_t argument = words[at] >> 8U;
        switch (words[at++] & 0xffU) {
        case HDS_OP_END:
            text << "end";
            EXPECT_EQ(at, words.size());
            break;
        case HDS_OP_MASK_END:
            text << "mask; ";
            break;
        case HDS_OP_CONSTANT:
            text << "constant";
            floats(at, 4);
            text << "; ";
            at += 4;
            break;
        case HDS_OP_PRIMVAR:
            text << "primvar " << argument << "; ";
            break;
        case HDS_OP_COORDINATES:
            text << "coords " << argument << "; ";
            break;
        case HDS_OP_AFFINE:
            text << "affine";
            floats(at, 6);
            text << "; ";
            at += 6;
            break;
        case HDS_OP_TRANSFORM:
            text << "transform; ";
            break;
        case HDS_OP_TEXTURE: {
            const std::uint32_t count = words.at(at++);
            text << "texture";
            for (std::uint32_t i = 0; i < count; ++i) {
                text << " " << static_cast<std::int32_t>(words.at(at + i));
            }
            at += count;
            text << " wrap " << (argument & 3U) << "," << (argument >> 2U & 3U);
            text << ((argument & HDS_LOOKUP_UDIM) != 0 ? " udim" : "")
                 << ((argument & HDS_LOOKUP_TANGENTS) != 0 ? " tangents" : "")
                 << ((argument & HDS_LOOKUP_AGAIN) != 0 ? " again" : "");
            if ((argument & HDS_LOOKUP_POPS) != 0) {
                text << " pops";
            } else {
                text << " :";
                floats(at, 12);
                at += 12;
            }
            text << "; ";
            break;
        }
        case HDS_OP_STORE:
            text << "store " << (argument & 0xffU) << "." << (argument >> 8U) << "; ";
            break;
        case HDS_OP_CHANNEL:
            text << "channel " << (argument >> 8U) << "; ";
            break;
        case HDS_OP_POP:
            text << "pop; ";
            break;
        default:
            ADD_FAILURE() << "unknown operation at word " << at - 1;
            return text.str();
        }
    }
    return text.str();
}

/// A material "/m" with a surface "/m/s" that is put together piece by piece.
class ProgramTest : public ::testing::Test {
protected:
    ProgramTest() {
        _network.nodes.reserve(16); // references stay valid
        AddNode("/m/s", "UsdPreviewSurface");
        _network.terminals["surface"] = {"/m/s", "surface"};
    }

    MaterialNode& AddNode(const std::string& path, const std::string& id) {
        _network.nodes.push_back({path, id, {}, {}});
        return _network.nodes.back();
    }
    MaterialNode& AddTexture(const std::string& path, const std::string& file) {
        MaterialNode& node = AddNode(path, "UsdUVTexture");
        node.parameters["file"] = AssetReference{file, file, 0, 0};
        node.parameters["wrapS"] = std::string("repeat");
        node.parameters["wrapT"] = std::string("clamp");
        return node;
    }
    MaterialNode& AddReader(const std::string& path, const std::string& type,
                            const std::string& primvar) {
        MaterialNode& node = AddNode(path, "UsdPrimvarReader_" + type);
        node.parameters["varname"] = primvar;
        return node;
    }
    void Connect(const std::string& input, const std::string& path, const std::string& output) {
        _network.nodes[0].connections[input] = {path, output};
    }

    /// Compiles and resolves for a mesh with st (slot 0 of the user's) and amount (slot 1);
    /// textures are numbered from 10.
    ResolvedMaterial Resolve() {
        _compiled = CompileMaterial(_network, "/m", test::Images(), _warnings);
        std::vector<std::uint32_t> textures;
        for (std::size_t i = 0; i < _compiled.textures.size(); ++i) {
            textures.push_back(static_cast<std::uint32_t>(10 + i));
        }
        return ResolveMaterial(_compiled, textures, {{"st", 2}, {"amount", 1}}, {}, "/mesh",
                               _warnings);
    }
    std::string Program() { return Disassemble(Resolve().program); }

    MaterialNetwork _network;
    CompiledMaterial _compiled;
    Warnings _warnings;
};

const char* const kPlain = " : 0,0,0,1,1,1,1,1,0,0,0,0; ";

TEST_F(ProgramTest, AMaterialOfConstantsAndPrimvarsHasNone) {
    Connect("roughness", "/m/r", "result");
    AddReader("/m/r", "float", "amount");
    const ResolvedMaterial resolved = Resolve();
    EXPECT_TRUE(resolved.program.empty());
    EXPECT_EQ(resolved.record.program, HDS_NONE);
    EXPECT_EQ(resolved.record.programInputs, 0U);
    EXPECT_EQ(resolved.record.slots[HDS_INPUT_ROUGHNESS], HDS_SLOT_USER + 1);
}

TEST_F(ProgramTest, TheCoordinatesOfTheLookUpBeforeAreNotPushedAgain) {
    AddTexture("/m/t", "t.png").connections["st"] = {"/m/r", "result"};
    AddTexture("/m/u", "u.png"); // without coordinates: at (0, 0)
    AddTexture("/m/v", "v.png").connections["st"] = {"/m/r", "result"};
    AddTexture("/m/w", "w.png").connections["st"] = {"/m/q", "result"};
    AddReader("/m/r", "float2", "st");
    AddReader("/m/q", "float2", "st");
    Connect("diffuseColor", "/m/t", "rgb");
    Connect("emissiveColor", "/m/u", "rgb");
    Connect("metallic", "/m/v", "g");
    Connect("roughness", "/m/w", "g");
    const std::string lookup = std::string(" wrap 2,1") + kPlain;
    EXPECT_EQ(Program(), "mask; coords 3; texture 10" + lookup + "store 0.4; pop; " +
                             "constant 0,0,0,0; constant 0,0,0,0; texture 11" + lookup +
                             "store 1.4; pop; coords 3; texture 12" + lookup +
                             "store 4.1; pop; texture 13 wrap 2,1 again" + kPlain +
                             "store 5.1; pop; end");
}

TEST_F(ProgramTest, ATextureIsLookedUpOnceForAllItsOutputs) {
    AddTexture("/m/t", "a.png").connections["st"] = {"/m/r", "result"};
    AddReader("/m/r", "float2", "st");
    Connect("diffuseColor", "/m/t", "rgb");
    Connect("roughness", "/m/t", "g");
    Connect("opacity", "/m/t", "a");
    EXPECT_EQ(Program(), std::string("coords 3; texture 10 wrap 2,1") + kPlain +
                             "store 0.4; store 5.1; store 8.3; pop; end");
    const ResolvedMaterial resolved = Resolve();
    EXPECT_EQ(resolved.record.programInputs,
              1U << HDS_INPUT_DIFFUSE_COLOR | 1U << HDS_INPUT_ROUGHNESS | 1U << HDS_INPUT_OPACITY);
    EXPECT_EQ(resolved.record.flags, std::uint32_t{HDS_MATERIAL_CUTOUT});
    ASSERT_EQ(_compiled.textures.size(), 1U);
    EXPECT_EQ(_compiled.textures[0].file.file, "a.png");
    EXPECT_EQ(_compiled.textures[0].colorSpace, "auto");
    EXPECT_EQ(_compiled.textures[0].channels, 15U);
    EXPECT_TRUE(_warnings.Lines().empty());
}

TEST_F(ProgramTest, WhatAMaskNeedsComesFirst) {
    AddTexture("/m/t", "a.png");
    AddTexture("/m/u", "b.png");
    _network.nodes[0].parameters["opacityThreshold"] = 0.5;
    Connect("diffuseColor", "/m/t", "rgb");
    Connect("opacity", "/m/u", "r");
    EXPECT_EQ(Program(), std::string("constant 0,0,0,0; constant 0,0,0,0; texture 11 wrap 2,1") +
                             kPlain + "store 8.0; pop; mask; " + "texture 10 wrap 2,1 again" +
                             kPlain + "store 0.4; pop; end");
    EXPECT_EQ(Resolve().record.flags, std::uint32_t{HDS_MATERIAL_CUTOUT | HDS_MATERIAL_MASK});
}

TEST_F(ProgramTest, WrapModesAreReadOneByOne) {
    const std::pair<const char*, std::uint32_t> modes[] = {
        {"black", HDS_WRAP_BLACK},   {"clamp", HDS_WRAP_CLAMP},       {"repeat", HDS_WRAP_REPEAT},
        {"mirror", HDS_WRAP_MIRROR}, {"useMetadata", HDS_WRAP_BLACK}, {"", HDS_WRAP_BLACK}};
    for (const auto& [mode, expected] : modes) {
        _network.nodes.resize(1);
        MaterialNode& texture = AddTexture("/m/t", "a.png");
        texture.parameters["wrapS"] = std::string(mode);
        Connect("diffuseColor", "/m/t", "rgb");
        const std::string wrap = "wrap " + std::to_string(expected) + ",1";
        EXPECT_NE(Program().find(wrap), std::string::npos) << mode;
    }
    EXPECT_TRUE(_warnings.Lines().empty());
    _network.nodes[1].parameters["wrapS"] = std::string("twist");
    EXPECT_NE(Program().find("wrap 0,1"), std::string::npos);
    EXPECT_EQ(_warnings.Lines().size(), 1U);
}

TEST_F(ProgramTest, MetadataOfTheFileDecidesWhereTheNodeLeavesItOpen) {
    MaterialNode& texture = AddTexture("/m/t", "mirror.png");
    texture.parameters.erase("wrapS");
    texture.parameters["wrapT"] = std::string("useMetadata");
    Connect("diffuseColor", "/m/t", "rgb");
    EXPECT_NE(Program().find("wrap 3,1"), std::string::npos);
    texture.parameters["wrapT"] = std::string("repeat");
    EXPECT_NE(Program().find("wrap 3,2"), std::string::npos);
}

TEST_F(ProgramTest, ScaleBiasAndFallbackAreConstantsOrComeFromTheStack) {
    MaterialNode& texture = AddTexture("/m/t", "a.png");
    texture.parameters["scale"] = std::vector<float>{2.0F, 3.0F, 4.0F, 5.0F};
    texture.parameters["bias"] = std::vector<float>{-1.0F, -2.0F, -3.0F, -4.0F};
    texture.parameters["fallback"] = std::vector<float>{0.1F, 0.2F, 0.3F, 0.4F};
    Connect("diffuseColor", "/m/t", "rgb");
    EXPECT_NE(Program().find(": 0.1,0.2,0.3,0.4,2,3,4,5,-1,-2,-3,-4;"), std::string::npos);

    texture.connections["scale"] = {"/m/r", "result"};
    AddReader("/m/r", "float", "amount");
    EXPECT_EQ(Program(), "mask; constant 0.1,0.2,0.3,0.4; primvar 4; channel 0; "
                         "constant -1,-2,-3,-4; constant 0,0,0,0; constant 0,0,0,0; "
                         "texture 10 wrap 2,1 pops; store 0.4; pop; end");
}

TEST_F(ProgramTest, TransformsAreChained) {
    AddTexture("/m/t", "a.png").connections["st"] = {"/m/x", "result"};
    MaterialNode& outer = AddNode("/m/x", "UsdTransform2d");
    outer.connections["in"] = {"/m/y", "result"};
    outer.parameters["translation"] = std::vector<float>{0.5F, 0.25F};
    MaterialNode& inner = AddNode("/m/y", "UsdTransform2d");
    inner.connections["in"] = {"/m/r", "result"};
    inner.parameters["scale"] = std::vector<float>{2.0F, 4.0F};
    AddReader("/m/r", "float2", "st");
    Connect("diffuseColor", "/m/t", "rgb");
    EXPECT_EQ(Program(), std::string("mask; coords 3; affine 2,-0,0,0,4,0; "
                                     "affine 1,-0,0.5,0,1,0.25; texture 10 wrap 2,1") +
                             kPlain + "store 0.4; pop; end");
    inner.connections["rotation"] = {"/m/q", "result"};
    AddReader("/m/q", "float", "amount");
    EXPECT_NE(
        Program().find("coords 3; primvar 4; constant 2,4,0,1; constant 0,0,0,0; transform; "),
        std::string::npos);
}

TEST_F(ProgramTest, TransformsOfConstantsAreFolded) {
    AddTexture("/m/t", "a.png").connections["st"] = {"/m/x", "result"};
    MaterialNode& transform = AddNode("/m/x", "UsdTransform2d");
    transform.parameters["in"] = std::vector<float>{1.0F, 0.0F};
    transform.parameters["rotation"] = 90.0;
    transform.parameters["scale"] = std::vector<float>{2.0F, 4.0F};
    transform.parameters["translation"] = std::vector<float>{10.0F, 20.0F};
    Connect("diffuseColor", "/m/t", "rgb");
    EXPECT_NE(Program().find("constant 10,22,0,0; constant 0,0,0,0; texture"), std::string::npos)
        << "scaled, then turned from s to t, then moved";
}

TEST_F(ProgramTest, AMissingPrimvarGivesTheReadersFallback) {
    AddTexture("/m/t", "a.png").connections["st"] = {"/m/r", "result"};
    AddReader("/m/r", "float2", "uv").parameters["fallback"] = std::vector<float>{0.25F, 0.75F};
    Connect("diffuseColor", "/m/t", "rgb");
    Connect("roughness", "/m/t", "g");
    EXPECT_EQ(Program(), std::string("mask; constant 0.25,0.75,0,1; constant 0,0,0,0; "
                                     "texture 10 wrap 2,1") +
                             kPlain + "store 0.4; store 5.1; pop; end")
        << "still one look-up";
    EXPECT_TRUE(_warnings.Lines().empty());
}

TEST_F(ProgramTest, UdimSetsHaveHoles) {
    MaterialNode& texture = AddTexture("/m/t", "skin.<UDIM>.png");
    texture.parameters["sourceColorSpace"] = std::string("raw");
    Connect("diffuseColor", "/m/t", "rgb");
    EXPECT_NE(Program().find("texture 10 -1 -1 11 wrap 1,1 udim"), std::string::npos);
    ASSERT_EQ(_compiled.textures.size(), 2U);
    EXPECT_EQ(_compiled.textures[1].file.file, "skin.1004.png");
    EXPECT_EQ(_compiled.textures[1].colorSpace, "raw");
    EXPECT_EQ(_compiled.textures[1].channels, 7U) << "nobody reads alpha";
    texture.parameters["file"] = AssetReference{"no.<UDIM>.png", "no.<UDIM>.png", 0, 0};
    EXPECT_EQ(Program(), "");
    EXPECT_EQ(_warnings.Lines().size(), 1U);
}

TEST_F(ProgramTest, ColourSpacesMakeTexturesOfTheirOwn) {
    AddTexture("/m/t", "a.png");
    AddTexture("/m/u", "a.png").parameters["sourceColorSpace"] = std::string("raw");
    AddTexture("/m/v", "a.png").parameters["colorSpace:file"] = std::string("lin_rec709");
    Connect("diffuseColor", "/m/t", "rgb");
    Connect("roughness", "/m/u", "r");
    Connect("metallic", "/m/v", "r");
    Program();
    std::vector<std::string> spaces;
    for (const MaterialTexture& texture : _compiled.textures) {
        spaces.push_back(texture.colorSpace);
    }
    EXPECT_EQ(spaces, (std::vector<std::string>{"auto", "lin_rec709", "raw"}));
}

TEST_F(ProgramTest, NormalsAreInTheFrameOfTheirCoordinates) {
    AddTexture("/m/t", "a.png").connections["st"] = {"/m/r", "result"};
    AddReader("/m/r", "float2", "st");
    Connect("normal", "/m/t", "rgb");
    EXPECT_NE(Program().find(" tangents"), std::string::npos);
    EXPECT_EQ(Resolve().record.flags, std::uint32_t{HDS_MATERIAL_NORMAL | HDS_MATERIAL_TANGENTS});
}

TEST_F(ProgramTest, OpacityOfAnImageWithoutAlphaIsConstant) {
    AddTexture("/m/t", "opaque.png");
    Connect("diffuseColor", "/m/t", "rgb");
    Connect("opacity", "/m/t", "a");
    EXPECT_EQ(Resolve().record.flags, 0U) << "such a surface is opaque";
    _network.nodes[1].parameters["wrapS"] = std::string("black");
    EXPECT_EQ(Resolve().record.flags, std::uint32_t{HDS_MATERIAL_CUTOUT}) << "but black borders";
}

TEST_F(ProgramTest, AScalarPrimvarSpreadsOverAColour) {
    Connect("diffuseColor", "/m/r", "result");
    AddReader("/m/r", "float", "amount");
    EXPECT_EQ(Program(), "mask; primvar 4; store 0.0; pop; end");
}

TEST_F(ProgramTest, TextAndMatricesGiveNothingButOneWarning) {
    for (const char* type : {"string", "matrix"}) {
        Warnings before;
        Connect("roughness", "/m/r", "result");
        _network.nodes.resize(1);
        AddReader("/m/r", type, "x");
        _network.nodes[0].parameters["roughness"] = 0.75;
        EXPECT_EQ(Program(), "");
        EXPECT_FLOAT_EQ(_compiled.constants.constants[HDS_INPUT_ROUGHNESS].x, 0.75F) << type;
    }
    EXPECT_EQ(_warnings.Lines().size(), 2U);
}

TEST_F(ProgramTest, CyclesOfTexturesEnd) {
    AddTexture("/m/t", "a.png").connections["st"] = {"/m/t", "rgb"};
    Connect("diffuseColor", "/m/t", "rgb");
    EXPECT_NE(Program(), "");
    EXPECT_EQ(_warnings.Lines().size(), 1U);
}

TEST_F(ProgramTest, WhatIsTooDeepForTheMachineKeepsTheDefault) {
    std::string upstream;
    for (int i = 0; i < 10; ++i) {
        const std::string path = "/m/t" + std::to_string(i);
        MaterialNode& texture = AddTexture(path, "a.png");
        if (!upstream.empty()) {
            texture.connections["bias"] = {upstream, "rgba"};
        }
        upstream = path;
    }
    Connect("diffuseColor", upstream, "rgb");
    const ResolvedMaterial resolved = Resolve();
    EXPECT_TRUE(resolved.program.empty());
    EXPECT_EQ(resolved.record.programInputs, 0U);
    EXPECT_FLOAT_EQ(resolved.record.constants[HDS_INPUT_DIFFUSE_COLOR].x, 0.18F);
    ASSERT_EQ(_warnings.Lines().size(), 1U);
    EXPECT_EQ(_warnings.Lines()[0].rfind("/mesh", 0), 0U);
}

/// A value that each node uses twice: there are 2^64 ways through the network, which are not gone.
TEST_F(ProgramTest, ChainsThatShareNodesAreReadOnce) {
    AddNode("/m/p", "ND_position_vector3");
    AddNode("/m/0", "ND_magnitude_vector3").connections["in"] = {"/m/p", "out"};
    for (int i = 0; i < 64; ++i) {
        const std::string upstream = "/m/" + std::to_string(i);
        MaterialNode& sum = AddNode("/m/" + std::to_string(i + 1), "ND_add_float");
        sum.connections["in1"] = {upstream, "out"};
        sum.connections["in2"] = {upstream, "out"};
    }
    AddNode("/m/n", "ND_heighttonormal_vector3").connections["in"] = {"/m/64", "out"};
    Connect("emissiveColor", "/m/64", "out");
    Connect("normal", "/m/n", "out");
    EXPECT_TRUE(Resolve().program.empty());
    EXPECT_EQ(PrimvarsOf(_compiled).count("st"), 1U) << "for the slope";
    ASSERT_EQ(_warnings.Lines().size(), 1U);
    EXPECT_NE(_warnings.Lines()[0].find("too deep"), std::string::npos);
}

/// A chain of transforms, of which each uses the one before three times, is read once.
TEST_F(ProgramTest, TransformsThatShareNodesAreReadOnce) {
    AddNode("/m/0", "UsdPrimvarReader_float2").parameters["varname"] = std::string("st");
    for (int i = 0; i < 64; ++i) {
        MaterialNode& transform = AddNode("/m/" + std::to_string(i + 1), "UsdTransform2d");
        for (const char* input : {"in", "scale", "translation"}) {
            transform.connections[input] = {"/m/" + std::to_string(i), "result"};
        }
    }
    AddTexture("/m/t", "a.png").connections["st"] = {"/m/64", "result"};
    Connect("diffuseColor", "/m/t", "rgb");
    AddNode("/m/p", "ND_position_vector3");
    AddNode("/m/n", "ND_magnitude_vector3").connections["in"] = {"/m/p", "out"};
    Connect("emissiveColor", "/m/n", "out"); // uses are counted where something computes
    EXPECT_TRUE(Resolve().program.empty());
    EXPECT_EQ(PrimvarsOf(_compiled).count("st"), 1U);
    ASSERT_EQ(_warnings.Lines().size(), 1U);
    EXPECT_NE(_warnings.Lines()[0].find("too deep"), std::string::npos);
}

TEST(ShaderProgram, SumsAndProductsMayBeOfChosenTexels) {
    const auto needs = [](std::uint32_t function, std::uint32_t count) {
        const std::uint32_t operand = HDS_OP(HDS_OP_MATH, HDS_MATH(HDS_MATH_ADD, 2U));
        return NeedsFilteredTexels(
            {operand, HDS_OP(HDS_OP_MATH, HDS_MATH(function, count)), HDS_OP(HDS_OP_END, 0U)});
    };
    EXPECT_FALSE(needs(HDS_MATH_MULTIPLY, 2));
    EXPECT_FALSE(needs(HDS_MATH_MIX, 3));
    EXPECT_TRUE(needs(HDS_MATH_GREATER, 2));
    EXPECT_TRUE(needs(HDS_MATH_SMOOTHSTEP, 3));
    EXPECT_TRUE(needs(HDS_MATH_NOISE2, 1));
    EXPECT_TRUE(NeedsFilteredTexels({HDS_OP(HDS_OP_SHIFT, 0U), HDS_OP(HDS_OP_END, 0U)}));
    // An operand is not taken for an instruction.
    EXPECT_FALSE(NeedsFilteredTexels(
        {HDS_OP_CONSTANT, HDS_OP(HDS_OP_MATH, HDS_MATH_SQRT), 0, 0, 0, HDS_OP(HDS_OP_END, 0U)}));
}

TEST(ShaderProgram, LookUpsAreCounted) {
    // Operands that look like look-ups are none.
    std::vector<std::uint32_t> words = {
        HDS_OP_CONSTANT, 7, 7, 7, 7, HDS_OP_AFFINE, 7, 7, 7, 7, 7, 7};
    EXPECT_EQ(CountLookups(words), 0U);
    words.insert(words.end(), {HDS_OP_TEXTURE, 3, 7, 7, 7});
    words.insert(words.end(), 12, 7);
    words.insert(words.end(), {HDS_OP(HDS_OP_TEXTURE, HDS_LOOKUP_POPS), 1, 7, HDS_OP_MASK_END});
    words.insert(words.end(), {HDS_OP_TEXTURE, 0});
    words.insert(words.end(), 12, 0);
    words.push_back(HDS_OP_END);
    EXPECT_EQ(CountLookups(words), 3U);
}

} // namespace
} // namespace hds
