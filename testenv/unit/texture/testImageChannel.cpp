// SPDX-License-Identifier: Apache-2.0
// One channel of a whole image: linear light, gray, what a file lacks; unreadable files.
#include "hdStream/texture/imageChannel.h"

#include "testenv/unit/texture/textureFixtures.h"

#include <fstream>

namespace hds {
namespace {

class ImageChannelTest : public TextureTest {};

TEST_F(ImageChannelTest, ChannelsAreReadInLinearLight) {
    const std::string path = WriteImage("a.png", 4, 4, 4, OIIO::TypeUInt8,
                                        [](int x, int, int c) { return c == 3 ? 0.2 : x / 255.0; });
    const ImageChannel green = LoadImageChannel({path, 0, 0, ""}, "sRGB", 1);
    ASSERT_EQ(green.values.size(), 16U);
    EXPECT_NEAR(green.values[3], 3 / 255.0 / 12.92, 1e-7);
    EXPECT_NEAR(LoadImageChannel({path, 0, 0, ""}, "sRGB", 3).values[0], 0.2, 1e-6);
    const std::string gray =
        WriteImage("g.png", 2, 2, 1, OIIO::TypeUInt8, [](int, int, int) { return 0.4; });
    EXPECT_NEAR(LoadImageChannel({gray, 0, 0, ""}, "raw", 2).values[0], 0.4, 1e-6);
    EXPECT_EQ(LoadImageChannel({gray, 0, 0, ""}, "raw", 3).values[0], 1.0F);
}

TEST_F(ImageChannelTest, UnreadableFilesHaveNoValues) {
    const std::string path = WriteImage("a.png", 64, 64, 3, OIIO::TypeUInt8);
    std::ifstream whole(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(whole)), std::istreambuf_iterator<char>());
    std::ofstream(folder.File("cut.png"), std::ios::binary).write(bytes.data(), 1000);
    std::ofstream(folder.File("text.png")) << "no image";
    for (const char* name : {"cut.png", "text.png", "absent.png"}) {
        const ImageChannel channel = LoadImageChannel({folder.File(name), 0, 0, ""}, "raw", 0);
        EXPECT_NE(channel.error.find(name), std::string::npos) << channel.error;
        EXPECT_TRUE(channel.values.empty());
        // As a texture it is missing.
        const auto texture = Prepare(folder.File(name));
        EXPECT_NE(texture->Description().error.find(name), std::string::npos);
        EXPECT_EQ(texture->Record().flags & HDS_TEXTURE_MISSING, HDS_TEXTURE_MISSING);
        EXPECT_EQ(texture->NumLines(), 1U);
    }
}

} // namespace
} // namespace hds
