// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/cryptomatte.h"

#include "hdStream/base/error.h"
#include "hdStream/film/aov.h"

#include <gtest/gtest.h>

#include <cstring>

namespace {

using hds::MatteKind;
using hds::MatteSums;
using hds::MatteSurface;

std::uint32_t BitsOf(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    return bits;
}

std::string NameOf(MatteKind kind, const MatteSurface& surface) {
    return (kind == MatteKind::Material ? "m" + std::to_string(surface.entry)
                                        : "p" + std::to_string(surface.prim));
}

/// Published values of MurmurHash3_x86_32, seed 0.
TEST(Cryptomatte, IdsAreMurmurHashes) {
    EXPECT_EQ(hds::MatteId("test"), 0xba6bd213U);
    EXPECT_EQ(hds::MatteId("Hello, world!"), 0xc0363e43U);
    EXPECT_EQ(hds::MatteId("The quick brown fox jumps over the lazy dog"), 0x2e4ff723U);
}

/// The hash of no bytes is 0, whose float is no normal number.
TEST(Cryptomatte, IdsAreNormalFloats) {
    EXPECT_EQ(hds::MatteId(""), 0x00800000U);
}

TEST(Cryptomatte, NamesOfAovs) {
    EXPECT_FALSE(hds::ParseMatteAov("crypto_objects"));
    EXPECT_FALSE(hds::ParseMatteAov("crypto_object08"));
    EXPECT_FALSE(hds::ParseMatteAov("color"));
    ASSERT_TRUE(hds::ParseMatteAov("crypto_material07"));
    EXPECT_EQ(hds::ParseMatteAov("crypto_material07")->layer, 7U);
    ASSERT_TRUE(hds::ParseMatteAov("crypto_instance"));
    EXPECT_FALSE(hds::ParseMatteAov("crypto_instance")->layer);
}

TEST(Cryptomatte, ItsNameStandsForThreeLayers) {
    const hds::AovLayout layout = hds::MakeAovLayout({"crypto_object", "color", "crypto_object03"});
    ASSERT_EQ(layout.slots.size(), 5U);
    EXPECT_EQ(layout.slots[2].info->name, "crypto_object02");
    EXPECT_EQ(layout.slots[4].info->name, "crypto_object03");
    EXPECT_TRUE(layout.hasMattes);
    EXPECT_EQ(layout.floatsPerPixel, 4U); // of the colour
    EXPECT_THROW(hds::MakeAovLayout({"crypto_object", "crypto_object01"}), hds::Error);
    EXPECT_FALSE(hds::MakeAovLayout({"color"}).hasMattes);
}

TEST(Cryptomatte, RanksFallAndSurfacesOfOneNameAreOne) {
    MatteSums sums;
    sums.Reset(2, 1);
    for (int i = 0; i < 10; ++i) {
        sums.AddSample(1);
    }
    sums.Add(1, {7, 0, -1}, 2);
    sums.Add(1, {3, 1, -1}, 3);
    sums.Add(1, {7, 1, 4}, 2); // the same prim by another material and instance
    const auto layers = sums.MakeLayers(MatteKind::Object, "crypto_object", 2, NameOf);
    ASSERT_EQ(layers.size(), 2U);
    EXPECT_EQ(layers[0].name, "crypto_object00");
    const float* pixel = &layers[0].values[4];
    EXPECT_EQ(BitsOf(pixel[0]), hds::MatteId("p7"));
    EXPECT_FLOAT_EQ(pixel[1], 0.4F);
    EXPECT_EQ(BitsOf(pixel[2]), hds::MatteId("p3"));
    EXPECT_FLOAT_EQ(pixel[3], 0.3F);
    EXPECT_EQ(layers[1].values, std::vector<float>(8, 0.0F));
    EXPECT_EQ(std::vector<float>(layers[0].values.begin(), layers[0].values.begin() + 4),
              std::vector<float>(4, 0.0F));
    const auto materials = sums.MakeLayers(MatteKind::Material, "crypto_material", 1, NameOf);
    EXPECT_EQ(BitsOf(materials[0].values[4]), hds::MatteId("m1"));
    EXPECT_FLOAT_EQ(materials[0].values[5], 0.5F);
}

/// Whatever the order in which they come; of equal ones the lower id is first.
TEST(Cryptomatte, OrderDoesNotCount) {
    MatteSums forward;
    MatteSums backward;
    forward.Reset(1, 1);
    backward.Reset(1, 1);
    for (std::uint32_t i = 0; i < 9; ++i) {
        forward.Add(0, {i, 0, -1}, 1);
        backward.Add(0, {8 - i, 0, -1}, 1);
    }
    const auto a = forward.MakeLayers(MatteKind::Object, "crypto_object", 3, NameOf);
    const auto b = backward.MakeLayers(MatteKind::Object, "crypto_object", 3, NameOf);
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(std::memcmp(a[i].values.data(), b[i].values.data(), 16), 0);
    }
    EXPECT_EQ(a[0].header, b[0].header);
    EXPECT_LT(BitsOf(a[0].values[0]), BitsOf(a[0].values[2]));
    const auto counts = forward.Counts();
    ASSERT_EQ(counts.size(), 9U);
    EXPECT_EQ(counts[8].surface.prim, 8U);
}

TEST(Cryptomatte, ManifestIsJson) {
    MatteSums sums;
    sums.Reset(1, 1);
    sums.Add(0, {0, 0, -1}, 1);
    const auto name = [](MatteKind, const MatteSurface&) { return std::string("a\"b\\c\n"); };
    const auto layers = sums.MakeLayers(MatteKind::Object, "crypto_object", 1, name);
    std::string manifest;
    for (const auto& [key, text] : layers[0].header) {
        if (key.size() > 9 && key.compare(key.size() - 9, 9, "/manifest") == 0) {
            manifest = text;
        }
    }
    EXPECT_EQ(manifest.substr(0, manifest.find(':')), "{\"a\\\"b\\\\c\\u000a\"");
}

} // namespace
