// SPDX-License-Identifier: Apache-2.0
// Oracles: images are made here from formulas and written with OpenImageIO; their means follow from
// the stored numbers and the sRGB formula of IEC 61966-2-1 in long double. Lossy files are decoded
// by OIIO::ImageBuf, another reading path than ImageFile's bands.
#include "hdStream/texture/imageReader.h"

#include "hdStream/texture/imageChannel.h"
#include "testenv/support/temporaryFolder.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

namespace {

using hds::test::ReadFile;
using hds::test::TemporaryFolder;
using hds::test::WriteFile;

hds::ImageSource Whole(const std::string& file) {
    return {file, 0, 0, {}};
}

/// The means of an image's channels in linear light.
struct Means {
    std::string error;
    std::string warning;
    std::array<double, 4> rgba{};

    bool Ok() const { return error.empty(); }
};

Means MeanColor(const hds::ImageSource& source, const std::string& colorSpace) {
    Means means;
    for (std::uint32_t c = 0; c < 4 && means.Ok(); ++c) {
        const hds::ImageChannel channel = hds::LoadImageChannel(source, colorSpace, c);
        means.error = channel.error;
        means.warning = channel.warning;
        long double sum = 0;
        for (const float value : channel.values) {
            sum += value;
        }
        means.rgba[c] = static_cast<double>(sum / channel.values.size());
    }
    return means;
}

long double SrgbOracle(long double v) {
    return v <= 0.04045L ? v / 12.92L : std::pow((v + 0.055L) / 1.055L, 2.4L);
}

/// A pattern in [0, 1] without symmetry.
double Pattern(int x, int y, int c, int width, int height) {
    return std::fmod(0.131 + 0.37 * c + (x + 0.5) / width * 0.61 + (y + 0.5) / height * 0.83, 1.0);
}

struct Image {
    OIIO::ImageSpec spec;
    std::vector<float> values;
};

Image MakeImage(int width, int height, int channels, OIIO::TypeDesc type) {
    Image image;
    image.spec = OIIO::ImageSpec(width, height, channels, type);
    image.spec.attribute("oiio:UnassociatedAlpha", 1);
    if (channels == 2) {
        image.spec.channelnames = {"Y", "A"};
        image.spec.alpha_channel = 1;
    }
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (int c = 0; c < channels; ++c) {
                double value = Pattern(x, y, c, width, height);
                if (type == OIIO::TypeUInt8) {
                    value = std::round(value * 255) / 255;
                } else if (type == OIIO::TypeUInt16) {
                    value = std::round(value * 65535) / 65535;
                } else if (type == OIIO::TypeHalf) {
                    value = std::round(value * 1024) / 1024; // exact in half: 10 bits and a sign
                }
                image.values.push_back(static_cast<float>(value));
            }
        }
    }
    return image;
}

void Write(const std::string& file, const Image& image) {
    const auto output = OIIO::ImageOutput::create(file);
    ASSERT_TRUE(output) << OIIO::geterror();
    ASSERT_TRUE(output->open(file, image.spec)) << output->geterror();
    ASSERT_TRUE(output->write_image(OIIO::TypeFloat, image.values.data())) << output->geterror();
    ASSERT_TRUE(output->close()) << output->geterror();
}

/// Mean of channel c of the stored numbers, decoded.
long double MeanOracle(const Image& image, int c, bool isSrgb) {
    long double sum = 0;
    const auto channels = static_cast<std::size_t>(image.spec.nchannels);
    const std::size_t count = image.values.size() / channels;
    for (std::size_t i = 0; i < count; ++i) {
        const long double value = image.values[i * channels + static_cast<std::size_t>(c)];
        sum += isSrgb ? SrgbOracle(value) : value;
    }
    return sum / static_cast<long double>(count);
}

struct Case {
    const char* name;
    const char* extension;
    int width, height, channels;
    OIIO::TypeDesc type;
    bool isAutoSrgb;
    double tolerance;
};

// Lossless files hold the floats of the pattern up to their own rounding: a float rounding of the
// pattern (6e-8) through the slope of the sRGB curve (< 2.4) stays below 2e-7. .hdr cuts mantissas
// off at 8 bits: at most 1/128 of a pixel's largest channel, half of that in the mean, times 2.4.
const Case kCases[] = {
    {"GrayPng", "png", 17, 9, 1, OIIO::TypeUInt8, false, 2e-7},
    {"GrayAlphaPng", "png", 17, 9, 2, OIIO::TypeUInt8, false, 2e-7},
    {"RgbPng", "png", 33, 65, 3, OIIO::TypeUInt8, true, 2e-7},
    {"RgbaPng", "png", 31, 7, 4, OIIO::TypeUInt8, true, 2e-7},
    {"OnePixelPng", "png", 1, 1, 3, OIIO::TypeUInt8, true, 2e-7},
    {"Rgb16Png", "png", 33, 65, 3, OIIO::TypeUInt16, false, 2e-7},
    {"Rgba16Png", "png", 5, 3, 4, OIIO::TypeUInt16, false, 2e-7},
    {"RgbTif", "tif", 33, 65, 3, OIIO::TypeUInt8, true, 2e-7},
    {"Rgba16Tif", "tif", 33, 65, 4, OIIO::TypeUInt16, false, 2e-7},
    {"FloatTif", "tif", 33, 65, 3, OIIO::TypeFloat, false, 2e-7},
    {"GrayFloatTif", "tif", 1, 65, 1, OIIO::TypeFloat, false, 2e-7},
    {"HalfExr", "exr", 33, 65, 3, OIIO::TypeHalf, false, 2e-7},
    {"FloatRgbaExr", "exr", 65, 33, 4, OIIO::TypeFloat, false, 2e-7},
    {"GrayHalfExr", "exr", 3, 130, 1, OIIO::TypeHalf, false, 2e-7},
    {"Tga", "tga", 33, 65, 3, OIIO::TypeUInt8, true, 2e-7},
    {"SgiWithoutProxy", "sgi", 33, 65, 3, OIIO::TypeUInt8, true, 2e-7},
    {"Hdr", "hdr", 33, 65, 3, OIIO::TypeFloat, false, 9.4e-3},
};

class MeanOfFormat : public testing::TestWithParam<Case> {};

TEST_P(MeanOfFormat, EqualsTheFormulaForEveryColourSpace) {
    const Case& test = GetParam();
    const TemporaryFolder folder;
    const std::string file = folder.File(std::string("image.") + test.extension);
    Image image = MakeImage(test.width, test.height, test.channels, test.type);
    Write(file, image);

    for (const std::string space : {"auto", "", "raw", "sRGB"}) {
        const bool isSrgb = space == "sRGB" || (space != "raw" && test.isAutoSrgb);
        const Means mean = MeanColor(Whole(file), space);
        ASSERT_TRUE(mean.Ok()) << mean.error;
        EXPECT_EQ(mean.warning, "");
        const bool isGray = test.channels < 3;
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(mean.rgba[static_cast<std::size_t>(c)],
                        static_cast<double>(MeanOracle(image, isGray ? 0 : c, isSrgb)),
                        test.tolerance)
                << space << " channel " << c;
        }
        const bool hasAlpha = test.channels == 2 || test.channels == 4;
        const double alpha =
            hasAlpha ? static_cast<double>(MeanOracle(image, test.channels - 1, false)) : 1.0;
        EXPECT_NEAR(mean.rgba[3], alpha, test.tolerance) << space;
    }
}

TEST_P(MeanOfFormat, IsDescribedByProbe) {
    const Case& test = GetParam();
    const TemporaryFolder folder;
    const std::string file = folder.File(std::string("image.") + test.extension);
    Write(file, MakeImage(test.width, test.height, test.channels, test.type));
    const hds::ImageInfo info = hds::ProbeImage(Whole(file));
    ASSERT_TRUE(info.Ok()) << info.error;
    EXPECT_EQ(info.width, static_cast<std::uint32_t>(test.width));
    EXPECT_EQ(info.height, static_cast<std::uint32_t>(test.height));
    EXPECT_EQ(info.channels, static_cast<std::uint32_t>(test.channels));
    EXPECT_EQ(info.channelType, test.type.c_str());
    EXPECT_EQ(info.autoColorSpace, test.isAutoSrgb ? "sRGB" : "raw");
    EXPECT_EQ(info.bytesDecoded, static_cast<std::uint64_t>(test.width) * test.height *
                                     test.channels * test.type.size());
}

TEST_P(MeanOfFormat, ByteRangeEqualsFile) {
    const Case& test = GetParam();
    const TemporaryFolder folder;
    const std::string file = folder.File(std::string("image.") + test.extension);
    Write(file, MakeImage(test.width, test.height, test.channels, test.type));
    const std::string bytes = ReadFile(file);
    const std::string package = folder.File("package.usdz");
    WriteFile(package, std::string(67, '\x5a') + bytes + std::string(1000, '\xa5'));
    const hds::ImageSource range{package, 67, bytes.size(),
                                 std::string("package.usdz[textures/image.") + test.extension +
                                     "]"};

    const Means expected = MeanColor(Whole(file), "auto");
    const Means mean = MeanColor(range, "auto");
    ASSERT_TRUE(mean.Ok()) << mean.error;
    EXPECT_EQ(mean.rgba, expected.rgba);
    EXPECT_EQ(hds::ProbeImage(range).fileFormat, hds::ProbeImage(Whole(file)).fileFormat);
    for (std::uint32_t c = 0; c < 4; ++c) {
        EXPECT_EQ(hds::LoadImageChannel(range, "auto", c).values,
                  hds::LoadImageChannel(Whole(file), "auto", c).values);
    }
}

TEST_P(MeanOfFormat, TruncatedFileIsAnErrorThatNamesIt) {
    const Case& test = GetParam();
    const TemporaryFolder folder;
    const std::string file = folder.File(std::string("image.") + test.extension);
    // Large enough that a cut is inside the pixels whatever the header's size.
    Write(file, MakeImage(test.width + 64, test.height + 64, test.channels, test.type));
    const std::string bytes = ReadFile(file);
    for (const double fraction : {0.02, 0.5, 0.8}) {
        WriteFile(file, bytes.substr(0, static_cast<std::size_t>(bytes.size() * fraction)));
        const Means mean = MeanColor(Whole(file), "auto");
        EXPECT_FALSE(mean.Ok()) << fraction;
        EXPECT_NE(mean.error.find(file), std::string::npos) << mean.error;
        EXPECT_EQ(mean.error.find('\n'), std::string::npos) << mean.error;
        EXPECT_TRUE(hds::LoadImageChannel(Whole(file), "auto", 0).values.empty());
    }
}

/// Damaged ones end the process inside of OpenImageIO 2.4.
TEST(ImageReader, FormatsWhoseReadersAreNotSafeAreRefused) {
    for (const std::string extension : {"iff", "ico"}) {
        const TemporaryFolder folder;
        const std::string file = folder.File("a." + extension);
        OIIO::ImageSpec spec(8, 8, 3, OIIO::TypeDesc::UINT8);
        const std::vector<unsigned char> pixels(8 * 8 * 3, 100);
        const auto out = OIIO::ImageOutput::create(file);
        ASSERT_TRUE(out && out->open(file, spec) &&
                    out->write_image(OIIO::TypeDesc::UINT8, pixels.data()) && out->close());
        const hds::ImageInfo info = hds::ProbeImage(Whole(file));
        EXPECT_EQ(info.error, file + ": images of the format " + extension +
                                  " are not read: save it as another one");
    }
}

INSTANTIATE_TEST_SUITE_P(All, MeanOfFormat, testing::ValuesIn(kCases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(ImageReader, JpegMeanEqualsAnotherDecodersPixels) {
    const TemporaryFolder folder;
    const std::string file = folder.File("image.jpg");
    Write(file, MakeImage(45, 37, 3, OIIO::TypeUInt8));
    OIIO::ImageBuf buffer(file);
    ASSERT_TRUE(buffer.read(0, 0, true, OIIO::TypeFloat)) << buffer.geterror();
    const Means mean = MeanColor(Whole(file), "auto");
    ASSERT_TRUE(mean.Ok()) << mean.error;
    for (int c = 0; c < 3; ++c) {
        long double sum = 0;
        for (int y = 0; y < 37; ++y) {
            for (int x = 0; x < 45; ++x) {
                sum += SrgbOracle(buffer.getchannel(x, y, 0, c));
            }
        }
        EXPECT_NEAR(mean.rgba[static_cast<std::size_t>(c)], static_cast<double>(sum / (45 * 37)),
                    2e-7); // ImageBuf's floats
    }
}

TEST(ImageReader, TruncatedJpegIsAnError) {
    const TemporaryFolder folder;
    const std::string file = folder.File("image.jpg");
    Write(file, MakeImage(145, 137, 3, OIIO::TypeUInt8));
    const std::string bytes = ReadFile(file);
    WriteFile(file, bytes.substr(0, bytes.size() / 2));
    const Means mean = MeanColor(Whole(file), "auto");
    EXPECT_FALSE(mean.Ok());
    EXPECT_NE(mean.error.find(file), std::string::npos) << mean.error;
}

TEST(ImageReader, ContentDecidesWhenTheExtensionIsWrong) {
    const TemporaryFolder folder;
    const std::string png = folder.File("image.png");
    Write(png, MakeImage(9, 5, 3, OIIO::TypeUInt8));
    const std::string named = folder.File("image.jpg");
    WriteFile(named, ReadFile(png));
    const std::string bare = folder.File("image");
    WriteFile(bare, ReadFile(png));
    EXPECT_EQ(MeanColor(Whole(named), "auto").rgba, MeanColor(Whole(png), "auto").rgba);
    EXPECT_EQ(hds::ProbeImage(Whole(named)).fileFormat, "png");
    EXPECT_EQ(MeanColor(Whole(bare), "auto").rgba, MeanColor(Whole(png), "auto").rgba);
}

TEST(ImageReader, AuthoredGammaDecidesAuto) {
    const TemporaryFolder folder;
    Image image = MakeImage(9, 5, 3, OIIO::TypeUInt8);
    image.spec.attribute("oiio:ColorSpace", "Linear"); // writes a gAMA chunk of 1
    const std::string file = folder.File("linear.png");
    Write(file, image);
    EXPECT_EQ(hds::ProbeImage(Whole(file)).autoColorSpace, "raw");
    EXPECT_NEAR(MeanColor(Whole(file), "auto").rgba[0],
                static_cast<double>(MeanOracle(image, 0, false)), 2e-7);
}

TEST(ImageReader, UnknownColourSpaceWarnsAndReadsAsAuto) {
    const TemporaryFolder folder;
    const std::string file = folder.File("image.png");
    Write(file, MakeImage(9, 5, 3, OIIO::TypeUInt8));
    const Means mean = MeanColor(Whole(file), "no such space");
    ASSERT_TRUE(mean.Ok());
    EXPECT_NE(mean.warning.find(file), std::string::npos);
    EXPECT_NE(mean.warning.find("no such space"), std::string::npos);
    EXPECT_EQ(mean.rgba, MeanColor(Whole(file), "auto").rgba);
}

TEST(ImageReader, MissingBlueIsZero) {
    const TemporaryFolder folder;
    const std::string file = folder.File("two.exr");
    Image image = MakeImage(9, 5, 3, OIIO::TypeFloat);
    image.spec.channelnames = {"G", "R", "Z"};
    image.spec.alpha_channel = -1;
    Write(file, image);
    const Means mean = MeanColor(Whole(file), "auto");
    EXPECT_NEAR(mean.rgba[0], static_cast<double>(MeanOracle(image, 1, false)), 2e-7);
    EXPECT_NEAR(mean.rgba[1], static_cast<double>(MeanOracle(image, 0, false)), 2e-7);
    EXPECT_EQ(mean.rgba[2], 0.0);
    EXPECT_EQ(mean.rgba[3], 1.0);
}

TEST(ImageReader, TheSecondOfThreeCoordinatesIsNoLuminance) {
    const TemporaryFolder folder;
    const std::string file = folder.File("position.exr");
    Image image = MakeImage(9, 5, 3, OIIO::TypeFloat);
    image.spec.channelnames = {"X", "Y", "Z"};
    image.spec.alpha_channel = -1;
    Write(file, image);
    const Means mean = MeanColor(Whole(file), "auto");
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(mean.rgba[c], static_cast<double>(MeanOracle(image, c, false)), 2e-7) << c;
    }
}

TEST(ImageReader, LuminanceBesideDepthIsGray) {
    const TemporaryFolder folder;
    const std::string file = folder.File("luminance.exr");
    Image image = MakeImage(9, 5, 3, OIIO::TypeFloat);
    image.spec.channelnames = {"A", "Y", "Z"};
    image.spec.alpha_channel = 0;
    Write(file, image);
    const Means mean = MeanColor(Whole(file), "auto");
    EXPECT_EQ(mean.rgba[1], mean.rgba[0]);
    EXPECT_EQ(mean.rgba[2], mean.rgba[0]);
}

TEST(ImageReader, TwoChannelsAreGrayAndAlphaWhateverTheirNames) {
    const TemporaryFolder folder;
    const std::string file = folder.File("two.exr");
    const std::vector<std::string> names[] = {{"R", "G"}, {"A", "Y"}, {"U", "V"}};
    for (const std::vector<std::string>& pair : names) {
        Image image = MakeImage(9, 5, 2, OIIO::TypeFloat);
        image.spec.channelnames = pair;
        image.spec.alpha_channel = pair[0] == "A" ? 0 : -1;
        Write(file, image);
        const int gray = pair[0] == "A" ? 1 : 0;
        const Means mean = MeanColor(Whole(file), "auto");
        for (std::size_t c = 0; c < 4; ++c) {
            const int source = c < 3 ? gray : 1 - gray;
            EXPECT_NEAR(mean.rgba[c], static_cast<double>(MeanOracle(image, source, false)), 2e-7)
                << pair[0] << pair[1] << c;
        }
        EXPECT_TRUE(hds::ProbeImage(Whole(file)).hasAlpha);
    }
}

TEST(ImageReader, WrapModesComeFromWhicheverAttributeNamesThem) {
    const TemporaryFolder folder;
    const std::string file = folder.File("image.exr");
    Image image = MakeImage(9, 5, 3, OIIO::TypeFloat);
    const auto expect = [&](const char* wrapS, const char* wrapT) {
        Write(file, image);
        const hds::ImageInfo info = hds::ProbeImage(Whole(file));
        EXPECT_EQ(info.wrapS, wrapS);
        EXPECT_EQ(info.wrapT, wrapT);
    };
    expect("", "");
    image.spec.attribute("wrapmodes", "clamp");
    expect("clamp", "clamp");
    image.spec.attribute("wrapmodes", "periodic,mirror");
    expect("periodic", "mirror");
    image.spec.attribute("wrapT", "repeat");
    expect("periodic", "repeat");
    image.spec.attribute("wrapS", "black");
    expect("black", "repeat");
}

TEST(ImageReader, ColourIsFoundByNameAmongOtherLayers) {
    const TemporaryFolder folder;
    const std::string file = folder.File("layers.exr");
    Image image = MakeImage(9, 5, 6, OIIO::TypeFloat);
    image.spec.channelnames = {"depth.Z", "A", "B", "G", "R", "id.x"};
    image.spec.alpha_channel = 1;
    Write(file, image);
    const Means mean = MeanColor(Whole(file), "auto");
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(mean.rgba[static_cast<std::size_t>(c)],
                    static_cast<double>(MeanOracle(image, 4 - c, false)), 2e-7);
    }
    EXPECT_NEAR(mean.rgba[3], static_cast<double>(MeanOracle(image, 1, false)), 2e-7);
}

TEST(ImageReader, TiledImagesReadLikeScanlines) {
    const TemporaryFolder folder;
    Image image = MakeImage(130, 70, 3, OIIO::TypeFloat);
    const std::string scanlines = folder.File("scanlines.exr");
    Write(scanlines, image);
    image.spec.tile_width = 32;
    image.spec.tile_height = 16;
    const std::string tiles = folder.File("tiles.exr");
    Write(tiles, image);
    for (std::uint32_t c = 0; c < 3; ++c) {
        EXPECT_EQ(hds::LoadImageChannel(Whole(tiles), "auto", c).values,
                  hds::LoadImageChannel(Whole(scanlines), "auto", c).values);
    }
}

TEST(ImageReader, BadFilesAreErrorsOfOneLineThatNameThem) {
    const TemporaryFolder folder;
    const std::string empty = folder.File("empty.png");
    WriteFile(empty, "");
    const std::string text = folder.File("text.png");
    WriteFile(text, "this is no image, whatever its name says\n");
    const std::string unknown = folder.File("text.txt");
    WriteFile(unknown, "this is no image either\n");
    const std::string missing = folder.File("missing.png");
    for (const std::string& file : {empty, text, unknown, missing, folder.Path()}) {
        const hds::ImageInfo info = hds::ProbeImage(Whole(file));
        EXPECT_FALSE(info.Ok()) << file;
        EXPECT_NE(info.error.find(file), std::string::npos) << info.error;
        EXPECT_EQ(info.error.find('\n'), std::string::npos) << info.error;
        EXPECT_EQ(MeanColor(Whole(file), "auto").error, info.error);
    }
    EXPECT_FALSE(hds::ProbeImage(Whole("")).Ok());
}

TEST(ImageReader, RangeBeyondTheFileIsAnError) {
    const TemporaryFolder folder;
    const std::string file = folder.File("image.png");
    Write(file, MakeImage(9, 5, 3, OIIO::TypeUInt8));
    const std::uint64_t size = ReadFile(file).size();
    EXPECT_FALSE(hds::ProbeImage({file, 1, size, "a.png"}).Ok());
    EXPECT_FALSE(hds::ProbeImage({file, size + 1, 1, "a.png"}).Ok());
    EXPECT_FALSE(
        hds::ProbeImage({file, std::numeric_limits<std::uint64_t>::max(), 2, "a.png"}).Ok());
    EXPECT_NE(hds::ProbeImage({file, 1, size, "inner.png"}).error.find("inner.png"),
              std::string::npos);
}

TEST(ImageReader, HeaderThatClaimsTooMuchIsAnError) {
    const TemporaryFolder folder;
    for (const std::string size : {"-Y 100000 +X 100000", "-Y 0 +X 0", "-Y 2000000 +X 2000000"}) {
        const std::string file = folder.File("claim.hdr");
        WriteFile(file,
                  "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n" + std::string(4096, '\0'));
        const hds::ImageChannel image = hds::LoadImageChannel(Whole(file), "auto", 0);
        EXPECT_FALSE(image.error.empty()) << size;
        EXPECT_NE(image.error.find(file), std::string::npos) << image.error;
    }
}

TEST(ImageReader, NonFiniteTexelsAreCountedAndReplaced) {
    const TemporaryFolder folder;
    const std::string file = folder.File("bad.exr");
    Image image = MakeImage(2, 2, 3, OIIO::TypeFloat);
    image.values = {1, 1,
                    1, std::numeric_limits<float>::quiet_NaN(),
                    2, 2, //
                    3, std::numeric_limits<float>::infinity(),
                    3, -4,
                    4, 4};
    Write(file, image);
    const Means mean = MeanColor(Whole(file), "auto");
    ASSERT_TRUE(mean.Ok()) << mean.error;
    EXPECT_EQ(mean.rgba[0], 0.0); // (1 + 0 + 3 - 4) / 4
    EXPECT_EQ(mean.rgba[1], 0.25 * (1 + 2 + 65504 + 4));
    EXPECT_EQ(mean.rgba[2], 2.5);
    EXPECT_NE(mean.warning.find(file), std::string::npos);
    EXPECT_NE(mean.warning.find("2 NaN or infinite"), std::string::npos) << mean.warning;
}

TEST(ImageReader, LatlongLoadsAsStored) {
    const TemporaryFolder folder;
    const std::string exr = folder.File("dome.exr");
    Image image = MakeImage(64, 32, 3, OIIO::TypeFloat);
    for (float& value : image.values) {
        value *= 1000.0f;
    }
    Write(exr, image);
    for (std::uint32_t c = 0; c < 3; ++c) {
        const hds::ImageChannel linear = hds::LoadImageChannel(Whole(exr), "auto", c);
        EXPECT_EQ(linear.error + linear.warning, "");
        EXPECT_EQ(linear.width, 64u);
        EXPECT_EQ(linear.height, 32u);
        ASSERT_EQ(linear.values.size(), 64u * 32u);
        for (std::size_t i = 0; i < linear.values.size(); ++i) {
            ASSERT_EQ(linear.values[i], image.values[3 * i + c]);
        }
    }

    const std::string png = folder.File("dome.png");
    const Image bytes = MakeImage(64, 32, 3, OIIO::TypeUInt8);
    Write(png, bytes);
    for (std::uint32_t c = 0; c < 3; ++c) {
        const hds::ImageChannel decoded = hds::LoadImageChannel(Whole(png), "auto", c);
        ASSERT_EQ(decoded.values.size(), 64u * 32u);
        for (std::size_t i = 0; i < decoded.values.size(); ++i) {
            ASSERT_NEAR(decoded.values[i], static_cast<double>(SrgbOracle(bytes.values[3 * i + c])),
                        2e-7);
        }
    }
}

/// An ICC profile of a header and `numTags` text tags whose names no profile has.
std::vector<unsigned char> MakeProfile(int file, int numTags) {
    const std::size_t textBegin = 132 + 12 * static_cast<std::size_t>(numTags);
    std::vector<unsigned char> profile(textBegin + 16);
    const auto put = [&profile](std::size_t at, std::uint32_t value) {
        for (std::size_t i = 0; i < 4; ++i) {
            profile[at + i] = static_cast<unsigned char>(value >> (24 - 8 * i));
        }
    };
    put(0, static_cast<std::uint32_t>(profile.size()));
    put(36, 0x61637370); // "acsp"
    put(128, static_cast<std::uint32_t>(numTags));
    for (int tag = 0; tag < numTags; ++tag) {
        const std::size_t entry = 132 + 12 * static_cast<std::size_t>(tag);
        put(entry, 0x78000000U + static_cast<std::uint32_t>(file * numTags + tag));
        put(entry + 4, static_cast<std::uint32_t>(textBegin));
        put(entry + 8, 16);
    }
    put(textBegin, 0x74657874); // "text"
    return profile;
}

TEST(ImageReader, ProfilesMayBeReadByManyThreads) {
    // OpenImageIO 2.4 crashes here when files are opened side by side.
    const TemporaryFolder folder;
    constexpr int kNumFiles = 200;
    for (int file = 0; file < kNumFiles; ++file) {
        Image image = MakeImage(8, 8, 3, OIIO::TypeUInt8);
        const std::vector<unsigned char> profile = MakeProfile(file, 60);
        image.spec.attribute(
            "ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(profile.size())),
            profile.data());
        Write(folder.File(std::to_string(file) + ".jpg"), image);
    }
    std::atomic<int> next{0};
    std::atomic<int> numRead{0};
    std::vector<std::thread> threads;
    for (int thread = 0; thread < 8; ++thread) {
        threads.emplace_back([&] {
            for (int file = next++; file < kNumFiles; file = next++) {
                numRead +=
                    MeanColor(Whole(folder.File(std::to_string(file) + ".jpg")), "auto").Ok();
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(numRead, kNumFiles);
}

} // namespace
