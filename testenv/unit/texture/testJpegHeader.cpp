// SPDX-License-Identifier: Apache-2.0
// Oracles: the same image as a baseline file, which OpenImageIO reads the header of; files made
// here segment by segment.
#include "hdStream/texture/jpegHeader.h"

#include "hdStream/texture/imageFile.h"
#include "hdStream/texture/imageReader.h"
#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

namespace {

using hds::test::ReadFile;
using hds::test::TemporaryFolder;
using hds::test::WriteFile;

std::optional<hds::JpegHeader> HeaderOf(const std::string& bytes, const std::string& before = "") {
    std::istringstream stream(before + bytes);
    return hds::ReadProgressiveHeader(stream, before.size(), bytes.size());
}

std::string Segment(char marker, const std::string& content) {
    const std::size_t length = content.size() + 2;
    return std::string("\xff") + marker + static_cast<char>(length >> 8U) +
           static_cast<char>(length & 255U) + content;
}

const std::string kBegin("\xff\xd8");
/// Progressive, 8 bits, 300 x 500 pixels, one channel.
const std::string kFrame = Segment('\xc2', std::string("\x08\x01\xf4\x01\x2c\x01\x01\x11\x00", 9));
const std::string kScan = Segment('\xda', std::string("\x01\x01\x00\x00\x00\x00", 6));

/// A file of `channels` with a pattern.
void WriteJpeg(const std::string& path, int width, int height, int channels, bool isProgressive) {
    OIIO::ImageSpec spec(width, height, channels, OIIO::TypeUInt8);
    spec.attribute("jpeg:progressive", isProgressive ? 1 : 0);
    spec.attribute("ImageDescription", "a pattern");
    std::vector<unsigned char> values;
    for (int i = 0; i < width * height * channels; ++i) {
        values.push_back(static_cast<unsigned char>(i * 7 % 251));
    }
    const auto output = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(output && output->open(path, spec)) << OIIO::geterror();
    ASSERT_TRUE(output->write_image(OIIO::TypeUInt8, values.data())) << output->geterror();
    ASSERT_TRUE(output->close());
}

class Channels : public testing::TestWithParam<int> {};

TEST_P(Channels, ProgressiveFilesAreWhatBaselineFilesAre) {
    const TemporaryFolder folder;
    const std::string baseline = folder.File("baseline.jpg");
    const std::string progressive = folder.File("progressive.jpg");
    WriteJpeg(baseline, 301, 517, GetParam(), false);
    WriteJpeg(progressive, 301, 517, GetParam(), true);
    EXPECT_FALSE(HeaderOf(ReadFile(baseline)));
    ASSERT_TRUE(HeaderOf(ReadFile(progressive)));

    const hds::ImageInfo expected = hds::ProbeImage({baseline, 0, 0, {}});
    ASSERT_EQ(expected.error, "");
    const std::string package = folder.File("package.usdz");
    WriteFile(package, "before" + ReadFile(progressive) + "after");
    const hds::ImageSource inPackage = {package, 6, ReadFile(progressive).size(), "a.jpg"};
    for (const hds::ImageSource& source : {hds::ImageSource{progressive, 0, 0, {}}, inPackage}) {
        const hds::ImageInfo info = hds::ProbeImage(source);
        EXPECT_EQ(info.error, "");
        EXPECT_EQ(info.width, expected.width);
        EXPECT_EQ(info.height, expected.height);
        EXPECT_EQ(info.channels, expected.channels);
        EXPECT_EQ(info.fileFormat, expected.fileFormat);
        EXPECT_EQ(info.channelType, expected.channelType);
        EXPECT_EQ(info.autoColorSpace, expected.autoColorSpace);
        EXPECT_EQ(info.hasAlpha, expected.hasAlpha);
        EXPECT_EQ(info.bytesDecoded, expected.bytesDecoded);
        std::string error;
        const auto file = hds::ImageFile::OpenHeader(source, &error);
        ASSERT_TRUE(file) << error;
        EXPECT_EQ(file->Spec().get_string_attribute("ImageDescription"), "a pattern");
    }
}

INSTANTIATE_TEST_SUITE_P(Jpeg, Channels, testing::Values(1, 3));

TEST(JpegHeader, IsAnImageWithoutPixelsToDecode) {
    const TemporaryFolder folder;
    const std::string path = folder.File("progressive.jpg");
    WriteJpeg(path, 301, 517, 3, true);
    const auto header = HeaderOf(ReadFile(path));
    ASSERT_TRUE(header);
    EXPECT_EQ(header->width, 301U);
    EXPECT_EQ(header->height, 517U);
    const std::string alone = folder.File("header.jpg");
    WriteFile(alone, std::string(header->bytes.begin(), header->bytes.end()));
    std::string error;
    const auto file = hds::ImageFile::Open({alone, 0, 0, {}}, &error);
    ASSERT_TRUE(file) << error;
    EXPECT_EQ(file->Width(), 8U);
    EXPECT_EQ(file->Height(), 8U);
}

TEST(JpegHeader, IsFoundWhereItBegins) {
    const auto header = HeaderOf(kBegin + kFrame + kScan, "something before");
    ASSERT_TRUE(header);
    EXPECT_EQ(header->width, 300U);
    EXPECT_EQ(header->height, 500U);
    EXPECT_TRUE(HeaderOf(kBegin + "\xff\xff" + kFrame + kScan)) << "bytes that fill up";
}

TEST(JpegHeader, ProfilesAreFoundAnywhere) {
    const std::string name("ICC_PROFILE\0", 12);
    for (const std::size_t place : {0, 1, 65530, 65536, 131071}) {
        std::string bytes(140000, 'x');
        bytes.replace(place, name.size(), name);
        std::istringstream stream("before" + bytes);
        EXPECT_TRUE(hds::NamesProfile(stream, 6, bytes.size())) << place;
        EXPECT_FALSE(hds::NamesProfile(stream, 6, place + name.size() - 1)) << place;
        EXPECT_TRUE(hds::NamesProfile(stream, 6, bytes.size() + 1)) << "that cannot be read";
    }
    std::istringstream without("before" + std::string(140000, 'x'));
    EXPECT_TRUE(hds::NamesProfile(without, 6, 140001)) << "that cannot be read";
    EXPECT_FALSE(hds::NamesProfile(without, 6, 140000)) << "after a read that failed";
}

TEST(JpegHeader, IsNotThereInDamagedFiles) {
    const std::string whole = kBegin + kFrame + kScan;
    for (std::size_t size = 0; size < whole.size(); ++size) {
        EXPECT_FALSE(HeaderOf(whole.substr(0, size))) << size;
    }
    EXPECT_FALSE(HeaderOf(kBegin + kScan)) << "no frame";
    EXPECT_FALSE(HeaderOf(kBegin + Segment('\xc2', "\x08") + kScan)) << "a frame without a size";
    EXPECT_FALSE(HeaderOf(kBegin + std::string("\xff\xc2\0\1", 4) + kScan)) << "a length below 2";
    EXPECT_FALSE(HeaderOf("\xff\xd9" + kFrame + kScan)) << "another file";
    for (const char* alone : {"\xff\x01", "\xff\xd0", "\xff\xd7", "\xff\xd9"}) {
        EXPECT_FALSE(HeaderOf(kBegin + alone + kFrame + kScan)) << "no length follows this marker";
    }
    const std::string empty = std::string("\x08\0\0\x01\x2c\x01\x01\x11\x00", 9);
    EXPECT_FALSE(HeaderOf(kBegin + Segment('\xc2', empty) + kScan)) << "no rows";
}

} // namespace
