// SPDX-License-Identifier: Apache-2.0
// Oracle: OpenImageIO's own writers make the files; the names of their formats are theirs.
#include "hdStream/texture/imageFormat.h"

#include "testenv/support/temporaryFolder.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <sstream>

namespace {

TEST(ImageFormat, ContentOfWrittenFilesIsRecognised) {
    const hds::test::TemporaryFolder folder;
    const std::pair<const char*, const char*> formats[] = {
        {"png", "png"},   {"jpg", "jpeg"}, {"exr", "openexr"}, {"tif", "tiff"}, {"hdr", "hdr"},
        {"webp", "webp"}, {"gif", "gif"},  {"dpx", "dpx"},     {"bmp", "bmp"}};
    for (const auto& [extension, format] : formats) {
        const std::string file = folder.File(std::string("image.") + extension);
        const auto output = OIIO::ImageOutput::create(file);
        ASSERT_TRUE(output) << extension;
        ASSERT_TRUE(output->open(file, OIIO::ImageSpec(4, 4, 3, OIIO::TypeUInt8)));
        const std::vector<float> pixels(4 * 4 * 3, 0.5f);
        ASSERT_TRUE(output->write_image(OIIO::TypeFloat, pixels.data())) << extension;
        ASSERT_TRUE(output->close());
        EXPECT_EQ(hds::FormatOfContent(hds::test::ReadFile(file).substr(0, 64)), format);
        EXPECT_EQ(hds::FormatOfName(file), format);
    }
    for (const char* head : {"", "P", "BM", "no image"}) {
        EXPECT_EQ(hds::FormatOfContent(head), head == std::string("BM") ? "bmp" : "");
    }
}

TEST(ImageFormat, NamesInsidePackagesHaveExtensions) {
    EXPECT_EQ(hds::FormatOfName("scene.usdz[textures/wood.JPG]"), "jpeg");
    EXPECT_EQ(hds::FormatOfName("/a.b/wood"), "");
    EXPECT_EQ(hds::FormatOfName("film.mp4"), "");
    EXPECT_EQ(hds::FormatOfName("image.null"), "");
    EXPECT_EQ(hds::FormatOfName(""), "");
}

TEST(ImageFormat, PngEndIsFoundByChunks) {
    const auto chunk = [](const std::string& type, unsigned char length) {
        return std::string(3, '\0') + static_cast<char>(length) + type + std::string(length, 'd') +
               "crc!";
    };
    const std::string whole =
        "signatur" + chunk("IHDR", 13) + chunk("IDAT", 200) + chunk("IEND", 0);
    const auto hasEnd = [](const std::string& bytes, std::uint64_t begin, std::uint64_t size) {
        std::istringstream stream(bytes);
        return hds::HasPngEnd(stream, begin, size);
    };
    EXPECT_TRUE(hasEnd(whole, 0, whole.size()));
    EXPECT_TRUE(hasEnd("before" + whole + "after", 6, whole.size()));
    for (std::size_t size = 0; size < whole.size(); ++size) {
        EXPECT_FALSE(hasEnd(whole.substr(0, size), 0, size)) << size;
        EXPECT_FALSE(hasEnd(whole, 0, size)) << size;
    }
    const std::string lie = "signatur" + std::string(4, '\xff') + "IDAT" + std::string(50, 'x');
    EXPECT_FALSE(hasEnd(lie, 0, lie.size()));
}

} // namespace
