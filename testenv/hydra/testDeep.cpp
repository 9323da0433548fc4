// SPDX-License-Identifier: Apache-2.0
// Deep pictures that a host leaves to the renderer, as husk does (`delegateRenderProducts`).
#include "hydraTest.h"

#include <pxr/base/tf/errorMark.h>
#include <pxr/base/vt/array.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace hydraHost {

namespace {

namespace fs = std::filesystem;

using Deep = HydraTest;

HdAovSettingsMap Product(const std::string& type, const std::string& file) {
    HdAovSettingsMap var;
    var[TfToken("sourceName")] = VtValue(std::string("Ci"));
    var[TfToken("dataType")] = VtValue(TfToken("color3f"));
    HdAovSettingsMap product;
    product[TfToken("productType")] = VtValue(TfToken(type));
    product[TfToken("productName")] = VtValue(TfToken(file));
    product[TfToken("orderedVars")] = VtValue(VtArray<HdAovSettingsMap>{var});
    product[TfToken("driver:parameters:OpenEXR:shot")] = VtValue(std::string("seq10"));
    product[TfToken("driver:parameters:OpenEXR:compression")] = VtValue(std::string("none"));
    return product;
}

std::string BytesOf(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

TEST_F(Deep, ProductsAreWrittenWhenThePictureIsDone) {
    const fs::path folder = fs::path(::testing::TempDir()) / "hydraDeep";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const VtArray<HdAovSettingsMap> products{Product("deepRaster", (folder / "a.exr").string()),
                                             Product("path", (folder / "never.exr").string())};
    HostOptions options = Quick();
    options.settings[TfToken("delegateRenderProducts")] = VtValue(products);
    Host host(ThreeMeshes(), options);
    ASSERT_TRUE(host.RenderUntilConverged());
    const Image flat = host.Read();
    const std::string bytes = BytesOf(folder / "a.exr");
    ASSERT_GT(bytes.size(), 8U);
    EXPECT_EQ(bytes.substr(0, 4), "\x76\x2f\x31\x01");
    EXPECT_NE(static_cast<unsigned char>(bytes[5]) & 0x08U, 0U); // deep data
    EXPECT_NE(bytes.find("deepscanline"), std::string::npos);
    EXPECT_NE(bytes.find("seq10"), std::string::npos);
    EXPECT_NE(bytes.find("worldToNDC"), std::string::npos);
    EXPECT_FALSE(fs::exists(folder / "never.exr"));
    EXPECT_GT(host.Statistic("memory.deep"), 0.0);

    // Not again while nothing changes; again with the scene, and elsewhere when that is asked for.
    fs::remove(folder / "a.exr");
    ASSERT_TRUE(host.RenderUntilConverged());
    EXPECT_FALSE(fs::exists(folder / "a.exr"));
    host.SetSetting(
        "delegateRenderProducts",
        VtValue(VtArray<HdAovSettingsMap>{Product("deepRaster", (folder / "b.exr").string())}));
    ASSERT_TRUE(host.RenderUntilConverged());
    EXPECT_EQ(BytesOf(folder / "b.exr"), bytes);
    EXPECT_FALSE(fs::exists(folder / "a.exr"));

    // The flat picture is that of a host that asks for none, and such a host keeps nothing.
    Host plain(ThreeMeshes(), Quick());
    const Image alone = plain.Render();
    EXPECT_EQ(plain.Statistic("memory.deep"), 0.0);
    ASSERT_EQ(alone.width, flat.width);
    for (int y = 0; y < flat.height; ++y) {
        for (int x = 0; x < flat.width; ++x) {
            for (int c = 0; c < 4; ++c) {
                ASSERT_EQ(flat.Float(x, y, c), alone.Float(x, y, c));
            }
        }
    }
    fs::remove_all(folder);
}

TEST_F(Deep, WhatCannotBeWrittenIsAnErrorOfTheHost) {
    HostOptions options = Quick();
    options.settings[TfToken("delegateRenderProducts")] =
        VtValue(VtArray<HdAovSettingsMap>{Product("deepRaster", "/no/such/folder/a.exr")});
    Host host(ThreeMeshes(), options);
    TfErrorMark mark;
    ASSERT_TRUE(host.RenderUntilConverged());
    ASSERT_FALSE(mark.IsClean());
    EXPECT_NE(mark.begin()->GetCommentary().find("/no/such/folder/a.exr"), std::string::npos);
    mark.Clear();
}

} // namespace

} // namespace hydraHost
