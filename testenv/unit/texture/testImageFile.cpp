// SPDX-License-Identifier: Apache-2.0
// Oracle: the numbers that were written, in the order of the whole image.
#include "hdStream/texture/imageFile.h"

#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <cstring>

namespace {

constexpr int kWidth = 37;
constexpr int kHeight = 261; ///< several bands, the last one not full

struct Layout {
    const char* extension;
    int tileWidth, tileHeight;
    int x, y; ///< origin of the data window
};

class Bands : public testing::TestWithParam<Layout> {};

TEST_P(Bands, DeliverEveryRowOnceInOrder) {
    const Layout& layout = GetParam();
    const hds::test::TemporaryFolder folder;
    const std::string path = folder.File(std::string("image.") + layout.extension);
    OIIO::ImageSpec spec(kWidth, kHeight, 3, OIIO::TypeUInt16);
    if (layout.extension == std::string("exr")) {
        spec.set_format(OIIO::TypeFloat);
    }
    spec.tile_width = layout.tileWidth;
    spec.tile_height = layout.tileHeight;
    spec.x = layout.x;
    spec.y = layout.y;
    std::vector<float> values;
    for (int i = 0; i < kWidth * kHeight * 3; ++i) {
        values.push_back(static_cast<float>(i) / 65535.0f);
    }
    const auto output = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(output && output->open(path, spec)) << OIIO::geterror();
    ASSERT_TRUE(output->write_image(OIIO::TypeFloat, values.data())) << output->geterror();
    ASSERT_TRUE(output->close());

    std::string error;
    const auto file = hds::ImageFile::Open({path, 0, 0, {}}, &error);
    ASSERT_TRUE(file) << error;
    std::uint32_t nextRow = 0;
    int numBands = 0;
    // channels 1 and 2 only; a band is 64 rows or a row of tiles
    error = file->ReadBands(
        OIIO::TypeFloat, 1, 3,
        [&](std::uint32_t y, std::uint32_t rows, const void* data) {
            ASSERT_EQ(y, nextRow);
            const float* pixels = static_cast<const float*>(data);
            for (std::uint32_t i = 0; i < rows * kWidth; ++i) {
                for (std::uint32_t c = 0; c < 2; ++c) {
                    ASSERT_NEAR(pixels[2 * i + c], values[3 * (y * kWidth + i) + 1 + c], 1e-7)
                        << "row " << y + i / kWidth;
                }
            }
            nextRow += rows;
            ++numBands;
        },
        1);
    EXPECT_EQ(error, "");
    EXPECT_EQ(nextRow, static_cast<std::uint32_t>(kHeight));
    EXPECT_GE(numBands, 3);
}

INSTANTIATE_TEST_SUITE_P(Layouts, Bands,
                         testing::Values(Layout{"png", 0, 0, 0, 0}, Layout{"exr", 0, 0, 0, 0},
                                         Layout{"exr", 0, 0, -3, 20}, Layout{"exr", 16, 32, 0, 0},
                                         Layout{"exr", 16, 32, 5, -7}, Layout{"tif", 0, 0, 0, 0},
                                         Layout{"tif", 16, 16, 0, 0}));

TEST(ColorChannels, AreFoundByNameThenByOrder) {
    const auto find = [](const std::vector<std::string>& names, int alpha) {
        OIIO::ImageSpec spec(1, 1, static_cast<int>(names.size()), OIIO::TypeFloat);
        spec.channelnames = names;
        spec.alpha_channel = alpha;
        const hds::ColorChannels found = hds::FindColorChannels(spec);
        return std::vector<int>{found.red, found.green, found.blue, found.alpha};
    };
    EXPECT_EQ(find({"R", "G", "B"}, -1), (std::vector<int>{0, 1, 2, -1}));
    EXPECT_EQ(find({"A", "B", "G", "R"}, 0), (std::vector<int>{3, 2, 1, 0}));
    EXPECT_EQ(find({"r", "g", "b", "a"}, -1), (std::vector<int>{0, 1, 2, 3}));
    EXPECT_EQ(find({"Y"}, -1), (std::vector<int>{0, 0, 0, -1}));
    EXPECT_EQ(find({"Y", "A"}, 1), (std::vector<int>{0, 0, 0, 1}));
    EXPECT_EQ(find({"R", "G"}, -1), (std::vector<int>{0, 0, 0, 1})); // as UsdUVTexture has two
    EXPECT_EQ(find({"BY", "RY", "Y"}, -1), (std::vector<int>{2, 2, 2, -1}));
    EXPECT_EQ(find({"u", "v", "w"}, -1), (std::vector<int>{0, 1, 2, -1}));
    EXPECT_EQ(find({"A"}, 0), (std::vector<int>{0, 0, 0, -1}));
}

} // namespace
