// SPDX-License-Identifier: Apache-2.0
// Sets of UDIM tiles are found in the layers that author them, and no layer is read again for want
// of one.
#include "hdStream/hydra/udimSets.h"

#include <pxr/usd/sdf/assetPath.h>
#include <pxr/usd/sdf/attributeSpec.h>
#include <pxr/usd/sdf/primSpec.h>
#include <pxr/usd/sdf/types.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

PXR_NAMESPACE_USING_DIRECTIVE

namespace hydraHost {

namespace {

namespace fs = std::filesystem;

class UdimSets : public ::testing::Test {
protected:
    void SetUp() override {
        fs::remove_all(_folder);
        fs::create_directories(_folder);
    }
    void TearDown() override { fs::remove_all(_folder); }

    /// A layer in a folder of its own, which authors a set.
    SdfLayerRefPtr MakeLayer(const std::string& name, const std::string& set) {
        fs::create_directories(_folder / name);
        SdfLayerRefPtr layer = SdfLayer::CreateNew((_folder / name / "layer.usda").string());
        const SdfPrimSpecHandle prim = SdfPrimSpec::New(layer, "Texture", SdfSpecifierDef);
        SdfAttributeSpec::New(prim, "other", SdfValueTypeNames->String)
            ->SetDefaultValue(VtValue(std::string("./string.<UDIM>.png")));
        SdfAttributeSpec::New(prim, "file", SdfValueTypeNames->Asset);
        Author(layer, set);
        return layer;
    }
    static void Author(const SdfLayerRefPtr& layer, const std::string& set) {
        layer->GetAttributeAtPath(SdfPath("/Texture.file"))
            ->SetDefaultValue(VtValue(SdfAssetPath(set)));
    }
    std::string MakeTile(const std::string& name, const std::string& file, const std::string& set) {
        std::ofstream(_folder / name / file) << "a tile";
        return (fs::canonical(_folder / name) / set).string();
    }

    fs::path _folder = fs::path(::testing::TempDir()) / "hdStreamUdimSets";
};

TEST_F(UdimSets, AreThoseOfTheFirstLayerWithTiles) {
    const SdfLayerRefPtr without = MakeLayer("a", "./t.<UDIM>.png");
    const SdfLayerRefPtr first = MakeLayer("b", "./t.<UDIM>.png");
    const SdfLayerRefPtr second = MakeLayer("c", "./t.<UDIM>.png");
    MakeTile("c", "t.1001.png", "");
    const std::string path = MakeTile("b", "t.1042.png", "t.<UDIM>.png");
    MakeTile("b", "string.1001.png", "");
    HdStreamUdimSets sets;
    EXPECT_EQ(sets.Resolve("./t.<UDIM>.png"), path);
    EXPECT_EQ(sets.Resolve("./string.<UDIM>.png"), "") << "no asset has this value";
}

TEST_F(UdimSets, OfALayerThatIsEditedOrComesLaterAreFound) {
    HdStreamUdimSets sets;
    const SdfLayerRefPtr layer = MakeLayer("a", "./t.<UDIM>.png");
    const std::string path = MakeTile("a", "t.1001.png", "t.<UDIM>.png");
    const std::string other = MakeTile("a", "other.1001.png", "other.<UDIM>.png");
    EXPECT_EQ(sets.Resolve("./other.<UDIM>.png"), "");
    Author(layer, "./other.<UDIM>.png");
    EXPECT_EQ(sets.Resolve("./other.<UDIM>.png"), other);
    EXPECT_EQ(sets.Resolve("./t.<UDIM>.png"), "") << "no layer authors it any more";
    Author(layer, "./t.<UDIM>.png");
    EXPECT_EQ(sets.Resolve("./t.<UDIM>.png"), path);
    const SdfLayerRefPtr later = MakeLayer("b", "./later.<UDIM>.png");
    const std::string ofLater = MakeTile("b", "later.1001.png", "later.<UDIM>.png");
    EXPECT_EQ(sets.Resolve("./later.<UDIM>.png"), ofLater);
}

TEST_F(UdimSets, StayThoseOfTheFirstLayerWhenItIsEdited) {
    const SdfLayerRefPtr first = MakeLayer("a", "./t.<UDIM>.png");
    const SdfLayerRefPtr second = MakeLayer("b", "./t.<UDIM>.png");
    const std::string path = MakeTile("a", "t.1001.png", "t.<UDIM>.png");
    MakeTile("b", "t.1001.png", "");
    HdStreamUdimSets sets;
    EXPECT_EQ(sets.Resolve("./t.<UDIM>.png"), path);
    SdfPrimSpec::New(first, "Unlike", SdfSpecifierDef);
    EXPECT_EQ(sets.Resolve("./t.<UDIM>.png"), path);
}

TEST_F(UdimSets, ThatAreMissingReadNoLayerTwice) {
    const SdfLayerRefPtr one = MakeLayer("a", "./a.<UDIM>.png");
    const SdfLayerRefPtr two = MakeLayer("b", "./b.<UDIM>.png");
    HdStreamUdimSets sets;
    EXPECT_EQ(sets.Resolve("./missing.<UDIM>.png"), "");
    const std::size_t numLayers = SdfLayer::GetLoadedLayers().size();
    ASSERT_GE(numLayers, 2U);
    EXPECT_EQ(sets.NumRead(), numLayers);
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(sets.Resolve("./missing" + std::to_string(i) + ".<UDIM>.png"), "");
    }
    EXPECT_EQ(sets.NumRead(), numLayers);
    Author(two, "./c.<UDIM>.png");
    EXPECT_EQ(sets.Resolve("./missing.<UDIM>.png"), "");
    EXPECT_EQ(sets.NumRead(), numLayers + 1) << "the one that was edited";
    const SdfLayerRefPtr three = MakeLayer("c", "./c.<UDIM>.png");
    EXPECT_EQ(sets.Resolve("./missing.<UDIM>.png"), "");
    EXPECT_EQ(sets.NumRead(), numLayers + 2) << "the one that came";
}

} // namespace

} // namespace hydraHost
