// SPDX-License-Identifier: Apache-2.0
// Oracle: files are read back with OIIO::ImageBuf, which shares no code with the writer; expected
// numbers are the layers' own or follow from the sRGB formula.
#include "hdStream/film/imageWriter.h"

#include "hdStream/base/error.h"
#include "hdStream/film/aov.h"
#include "testenv/support/fileSizeLimit.h"
#include "testenv/support/temporaryFolder.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <regex>

namespace {

using hds::test::ReadFile;
using hds::test::TemporaryFolder;
using hds::test::WriteFile;

constexpr std::uint32_t kWidth = 67;
constexpr std::uint32_t kHeight = 35;

/// Every AOV with values that differ in each pixel and channel.
std::vector<hds::ImageLayer> MakeLayers() {
    std::vector<hds::ImageLayer> layers;
    float seed = 0.0f;
    for (const hds::AovInfo& info : hds::AovTable()) {
        hds::ImageLayer layer = hds::MakeClearLayer(info, kWidth, kHeight);
        for (std::size_t i = 0; i < layer.values.size(); ++i) {
            layer.values[i] = std::fmod(seed + 0.618034f * static_cast<float>(i), 1.0f) * 3.0f;
        }
        for (std::size_t i = 0; i < layer.ids.size(); ++i) {
            layer.ids[i] = i % 5 == 0 ? -1 : static_cast<std::int32_t>(i * 40503u % 2000000011u);
        }
        layers.push_back(layer);
        seed += 0.1f;
    }
    layers[0].values[8] = std::numeric_limits<float>::infinity();
    layers[0].values[9] = -2.5f;
    return layers;
}

hds::ImageLayer MakeColor(float r, float g, float b, float a) {
    hds::ImageLayer layer = hds::MakeClearLayer(*hds::FindAov("color"), kWidth, kHeight);
    for (std::size_t i = 0; i < layer.values.size(); i += 4) {
        layer.values[i] = r;
        layer.values[i + 1] = g;
        layer.values[i + 2] = b;
        layer.values[i + 3] = a;
    }
    return layer;
}

int ChannelIndex(const OIIO::ImageSpec& spec, const std::string& name) {
    for (int c = 0; c < spec.nchannels; ++c) {
        if (spec.channel_name(c) == name) {
            return c;
        }
    }
    return -1;
}

TEST(ImageWriter, ExrHoldsEveryLayerBitForBit) {
    const TemporaryFolder folder;
    const std::string file = folder.File("all.exr");
    const std::vector<hds::ImageLayer> layers = MakeLayers();
    EXPECT_TRUE(hds::WriteImage(file, layers).empty());

    const auto input = OIIO::ImageInput::open(file);
    ASSERT_TRUE(input) << OIIO::geterror();
    const OIIO::ImageSpec spec = input->spec();
    ASSERT_EQ(spec.width, static_cast<int>(kWidth));
    ASSERT_EQ(spec.height, static_cast<int>(kHeight));
    const std::size_t pixelBytes = spec.pixel_bytes(true);
    std::vector<char> pixels(pixelBytes * kWidth * kHeight);
    ASSERT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeUnknown, pixels.data()));
    int numChannels = 0;
    for (const hds::ImageLayer& layer : layers) {
        const std::size_t count = layer.channels.size();
        for (std::size_t c = 0; c < count; ++c, ++numChannels) {
            const std::string name =
                layer.name == "color" ? layer.channels[c] : layer.name + "." + layer.channels[c];
            const int index = ChannelIndex(spec, name);
            ASSERT_GE(index, 0) << name;
            EXPECT_EQ(spec.channelformat(index),
                      layer.isInteger ? OIIO::TypeUInt32 : OIIO::TypeFloat)
                << name;
            const std::size_t offset = 4 * static_cast<std::size_t>(index);
            for (std::size_t p = 0; p < std::size_t{kWidth} * kHeight; ++p) {
                const char* expected =
                    layer.isInteger ? reinterpret_cast<const char*>(&layer.ids[p * count + c])
                                    : reinterpret_cast<const char*>(&layer.values[p * count + c]);
                ASSERT_EQ(std::memcmp(&pixels[p * pixelBytes + offset], expected, 4), 0)
                    << name << " pixel " << p;
            }
        }
    }
    EXPECT_EQ(spec.nchannels, numChannels);
    EXPECT_EQ(spec.alpha_channel, ChannelIndex(spec, "A"));
}

TEST(ImageWriter, ExrMetadata) {
    const TemporaryFolder folder;
    const std::string file = folder.File("meta.exr");
    hds::ImageWriteOptions options;
    options.metadata.software = "hdStream 9.9";
    options.metadata.samples = 48;
    options.metadata.camera = "/World/Camera";
    options.metadata.pixelAspectRatio = 1.5;
    std::array<double, 16> matrix{};
    for (std::size_t i = 0; i < 16; ++i) {
        matrix[i] = static_cast<double>(i) * 0.5;
    }
    options.metadata.worldToCamera = matrix;
    options.metadata.texts["hdStream:note"] = "text";
    hds::WriteImage(file, {MakeColor(1, 2, 3, 1)}, options);
    const auto input = OIIO::ImageInput::open(file);
    ASSERT_TRUE(input);
    const OIIO::ImageSpec& spec = input->spec();
    EXPECT_EQ(spec.get_string_attribute("Software"), "hdStream 9.9");
    EXPECT_EQ(spec.get_int_attribute("hdStream:samples"), 48);
    EXPECT_EQ(spec.get_string_attribute("hdStream:camera"), "/World/Camera");
    EXPECT_EQ(spec.get_string_attribute("hdStream:note"), "text");
    EXPECT_EQ(spec.get_float_attribute("PixelAspectRatio"), 1.5f);
    const OIIO::ParamValue* stored = spec.find_attribute("worldtocamera");
    ASSERT_NE(stored, nullptr);
    for (std::size_t i = 0; i < 16; ++i) {
        EXPECT_EQ(static_cast<const float*>(stored->data())[i], static_cast<float>(matrix[i]));
    }
}

/// Attributes of an EXR file's header are a name and a type that end in 0, and their length.
std::string ExrAttribute(const std::string& bytes, const std::string& name, std::size_t length) {
    const std::string begin = std::string(1, '\0') + name + std::string(1, '\0');
    const std::size_t found = bytes.find(begin);
    if (found == std::string::npos) {
        return "";
    }
    const std::size_t type = found + begin.size();
    return bytes.substr(bytes.find('\0', type) + 5, length);
}

TEST(ImageWriter, ColoursHaveTheirChromaticitiesAndDataHasNone) {
    const TemporaryFolder folder;
    const auto chromaticitiesOf = [&](const std::vector<hds::ImageLayer>& layers) {
        const std::string file = folder.File("a.exr");
        hds::WriteImage(file, layers);
        return ExrAttribute(ReadFile(file), "chromaticities", 32);
    };
    const std::string bytes = chromaticitiesOf({MakeColor(1, 2, 3, 1)});
    ASSERT_EQ(bytes.size(), 32U);
    float values[8];
    std::memcpy(values, bytes.data(), sizeof(values));
    const float expected[] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
    EXPECT_TRUE(std::equal(expected, expected + 8, values));
    EXPECT_EQ(chromaticitiesOf({hds::MakeClearLayer(*hds::FindAov("depth"), kWidth, kHeight)}), "");
}

TEST(ImageWriter, PngIsSrgbAndNotPremultiplied) {
    const TemporaryFolder folder;
    const std::string file = folder.File("out.png");
    hds::ImageWriteOptions options;
    options.colorCorrection = hds::ColorCorrection::Srgb;
    hds::WriteImage(file, {MakeColor(0.09f, 0.25f, 0.5f, 0.5f)}, options);
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(file, &config);
    ASSERT_TRUE(input);
    EXPECT_EQ(input->spec().format, OIIO::TypeUInt8);
    EXPECT_EQ(input->spec().get_string_attribute("oiio:ColorSpace"), "sRGB");
    ASSERT_EQ(input->spec().nchannels, 4);
    std::vector<unsigned char> pixels(4 * kWidth * kHeight);
    ASSERT_TRUE(input->read_image(0, 0, 0, 4, OIIO::TypeUInt8, pixels.data()));
    // sRGB of 0.18, 0.5 and 1: 0.461356, 0.735357 and 1, times 255
    EXPECT_EQ(pixels[0], 118);
    EXPECT_EQ(pixels[1], 188);
    EXPECT_EQ(pixels[2], 255);
    EXPECT_EQ(pixels[3], 128);
    EXPECT_EQ(std::memcmp(&pixels[0], &pixels[4 * (kWidth * kHeight - 1)], 4), 0);
}

TEST(ImageWriter, JpegIsOverBlack) {
    const TemporaryFolder folder;
    const std::string file = folder.File("out.jpg");
    hds::ImageWriteOptions options;
    options.colorCorrection = hds::ColorCorrection::Srgb;
    hds::WriteImage(file, {MakeColor(0.18f, 0.5f, 0.02f, 0.5f)}, options);
    OIIO::ImageBuf image(file);
    ASSERT_TRUE(image.read(0, 0, true, OIIO::TypeUInt8)) << image.geterror();
    ASSERT_EQ(image.nchannels(), 3);
    const int expected[3] = {118, 188, 39};
    for (int c = 0; c < 3; ++c) {
        // a constant block loses at most the rounding of YCbCr
        EXPECT_NEAR(image.getchannel(30, 20, 0, c) * 255, expected[c], 2.0);
    }
}

TEST(ImageWriter, LinearFormatsHoldPremultipliedFloats) {
    const TemporaryFolder folder;
    const std::vector<hds::ImageLayer> layers{MakeColor(0.25f, 4.0f, 0.0625f, 0.5f)};
    hds::WriteImage(folder.File("out.tif"), layers);
    hds::WriteImage(folder.File("out.hdr"), layers);
    for (const char* name : {"out.tif", "out.hdr"}) {
        OIIO::ImageBuf image(folder.File(name));
        ASSERT_TRUE(image.read(0, 0, true, OIIO::TypeFloat)) << image.geterror();
        EXPECT_EQ(image.getchannel(3, 3, 0, 0), 0.25f) << name;
        EXPECT_EQ(image.getchannel(3, 3, 0, 1), 4.0f) << name;
        EXPECT_EQ(image.getchannel(3, 3, 0, 2), 0.0625f) << name;
        EXPECT_EQ(image.nchannels(), name == std::string("out.tif") ? 4 : 3);
    }
}

TEST(ImageWriter, OnlyTheColourGoesToPng) {
    const TemporaryFolder folder;
    std::vector<hds::ImageLayer> layers = MakeLayers();
    std::swap(layers[0], layers[3]);
    const std::vector<std::string> left = hds::WriteImage(folder.File("out.png"), layers);
    EXPECT_EQ(left.size(), layers.size() - 1);
    EXPECT_EQ(std::count(left.begin(), left.end(), "color"), 0);
    // without colour: the first layer, as stored
    hds::ImageLayer depth = hds::MakeClearLayer(*hds::FindAov("depth"), 2, 2);
    depth.values = {0.0f, 0.25f, 0.5f, 1.0f};
    hds::WriteImage(folder.File("depth.png"), {depth});
    OIIO::ImageBuf image(folder.File("depth.png"));
    ASSERT_TRUE(image.read(0, 0, true, OIIO::TypeUInt8));
    EXPECT_EQ(image.nchannels(), 1);
    EXPECT_NEAR(image.getchannel(1, 0, 0, 0) * 255, 64, 1e-3);
    EXPECT_NEAR(image.getchannel(0, 1, 0, 0) * 255, 128, 1e-3);
}

TEST(ImageWriter, ColourIsWhatTheAovIsWhateverItsName) {
    const TemporaryFolder folder;
    constexpr const char* kName = "beauty";
    const auto greenOf = [&](hds::ImageLayer layer, const std::string& aov) {
        layer.name = kName;
        const hds::ImageLayer first = hds::MakeClearLayer(*hds::FindAov("depth"), kWidth, kHeight);
        hds::ImageWriteOptions options;
        options.aovs = {{kName, aov}};
        std::vector<hds::ImageLayer> layers{layer};
        if (aov == "color") { // it is the one that is written, wherever it stands
            layers.insert(layers.begin(), first);
        }
        hds::WriteImage(folder.File("out.png"), layers, options);
        OIIO::ImageBuf image(folder.File("out.png"));
        EXPECT_TRUE(image.read(0, 0, true, OIIO::TypeUInt8));
        return std::lround(255.0F * image.getchannel(0, 0, 0, 1));
    };
    constexpr long kLinearHalf = 128;
    constexpr long kDisplayHalf = 188; // of IEC 61966-2-1
    const hds::ImageLayer half = MakeColor(0.5F, 0.5F, 0.5F, 1.0F);
    for (const char* aov : {"color", "diffuse", "lpe:C<RD>.*L", "lightGroup:key"}) {
        EXPECT_EQ(greenOf(half, aov), kDisplayHalf) << aov;
    }
    for (const char* aov : {"normal", "primvars:st", "no such AOV"}) {
        EXPECT_EQ(greenOf(half, aov), kLinearHalf) << aov;
    }
}

TEST(ImageWriter, SameLayersSameBytes) {
    const TemporaryFolder folder;
    for (const char* extension : {"exr", "png", "jpg", "tif", "hdr"}) {
        const std::string first = folder.File(std::string("a.") + extension);
        const std::string second = folder.File(std::string("b.") + extension);
        hds::WriteImage(first, MakeLayers());
        hds::WriteImage(second, MakeLayers());
        EXPECT_EQ(ReadFile(first), ReadFile(second)) << extension;
        // no encoder wrote the time of day
        const std::regex date("[0-9]{4}:[0-9]{2}:[0-9]{2} [0-9]{2}:[0-9]{2}");
        EXPECT_FALSE(std::regex_search(ReadFile(first), date)) << extension;
    }
}

TEST(ImageWriter, OnePixel) {
    const TemporaryFolder folder;
    hds::ImageLayer layer = hds::MakeClearLayer(*hds::FindAov("color"), 1, 1);
    layer.values = {1.0f, 0.5f, 0.25f, 1.0f};
    for (const char* extension : {"exr", "png", "jpg", "tif", "hdr"}) {
        const std::string file = folder.File(std::string("one.") + extension);
        hds::WriteImage(file, {layer});
        OIIO::ImageBuf image(file);
        ASSERT_TRUE(image.read()) << image.geterror();
        EXPECT_NEAR(image.getchannel(0, 0, 0, 0), 1.0f, 0.01f) << extension;
    }
}

std::string WriteError(const std::string& file, const std::vector<hds::ImageLayer>& layers,
                       hds::ErrorKind kind) {
    try {
        hds::WriteImage(file, layers);
    } catch (const hds::Error& error) {
        EXPECT_EQ(error.kind(), kind);
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find(file), std::string::npos) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "no error for " << file;
    return {};
}

TEST(ImageWriter, FullDiskKeepsTheOldFileAndLeavesNothing) {
    const TemporaryFolder folder;
    for (const char* extension : {"exr", "png", "jpg", "tif", "hdr"}) {
        const std::string file = folder.File(std::string("out.") + extension);
        WriteFile(file, "precious");
        const std::size_t numEntries = folder.NumEntries();
        std::string message;
        for (const unsigned bytes : {20u, 900u}) { // inside the header, inside the pixels
            {
                const hds::test::FileSizeLimit limit(bytes);
                message = WriteError(file, MakeLayers(), hds::ErrorKind::Failure);
            }
            EXPECT_NE(message.find("too large"), std::string::npos) << message;
            EXPECT_EQ(ReadFile(file), "precious") << extension;
            EXPECT_EQ(folder.NumEntries(), numEntries) << extension;
        }
    }
}

TEST(ImageWriter, WrongTargets) {
    const TemporaryFolder folder;
    const std::vector<hds::ImageLayer> layers{MakeColor(1, 1, 1, 1)};
    WriteError(folder.File("no/such/folder/out.exr"), layers, hds::ErrorKind::Failure);
    WriteError(folder.File("out.xyz"), layers, hds::ErrorKind::Usage);
    WriteError(folder.File("out"), layers, hds::ErrorKind::Usage);
    WriteError(folder.File("a.exr/out"), layers, hds::ErrorKind::Usage);
    WriteError(folder.File("ids.png"), {hds::MakeClearLayer(*hds::FindAov("primId"), 2, 2)},
               hds::ErrorKind::Usage);
    // Bits of ids in floats are no less ids.
    hds::ImageLayer matte = hds::MakeClearLayer(*hds::FindAov("crypto_object00"), 2, 2);
    for (const char* file : {"matte.png", "matte.jpg", "matte.tif", "matte.hdr"}) {
        WriteError(folder.File(file), {matte}, hds::ErrorKind::Usage);
    }
    hds::ImageLayer motion = hds::MakeClearLayer(*hds::FindAov("motionForward"), 2, 2);
    for (const char* name : {"color", "motionForward"}) { // a product may call it anything
        motion.name = name;
        for (const char* file : {"motion.png", "motion.jpg", "motion.hdr"}) {
            WriteError(folder.File(file), {motion}, hds::ErrorKind::Usage);
        }
    }
    WriteError(folder.File("none.exr"), {}, hds::ErrorKind::Failure);
    std::filesystem::create_directory(folder.File("folder.exr"));
    WriteError(folder.File("folder.exr"), layers, hds::ErrorKind::Failure);
    EXPECT_EQ(folder.NumEntries(), 1u);
}

TEST(ImageWriter, CheckFindsWrongTargetsEarlyAndLeavesNothing) {
    const TemporaryFolder folder;
    EXPECT_NO_THROW(hds::CheckImageFile(folder.File("out.exr")));
    EXPECT_THROW(hds::CheckImageFile(folder.File("out.xyz")), hds::Error);
    EXPECT_THROW(hds::CheckImageFile(folder.File("no/out.exr")), hds::Error);
    for (const char* aov : {"motionForward", "primId", "crypto_object", "crypto_material01"}) {
        EXPECT_NO_THROW(hds::CheckImageFile(folder.File("out.exr"), {aov}));
        EXPECT_NO_THROW(hds::CheckImageFile(folder.File("out.png"), {aov, "color"}));
        EXPECT_THROW(hds::CheckImageFile(folder.File("out.png"), {aov, "depth"}), hds::Error);
    }
    EXPECT_NO_THROW(hds::CheckImageFile(folder.File("out.tif"), {"motionBackward"}));
    EXPECT_NO_THROW(hds::CheckImageFile(folder.File("out.png"), {"primvars:st"}));
    EXPECT_EQ(folder.NumEntries(), 0u);
}

TEST(ImageWriter, TwoChannelsBecomeATiff) {
    const TemporaryFolder folder;
    hds::ImageLayer motion = hds::MakeClearLayer(*hds::FindAov("motionForward"), 2, 1);
    motion.values = {1.0F, -2.5F, 3.0F, 4.25F};
    hds::WriteImage(folder.File("motion.tif"), {motion});
    const auto input = OIIO::ImageInput::open(folder.File("motion.tif"));
    std::vector<float> read(4);
    ASSERT_TRUE(input && input->spec().nchannels == 2);
    ASSERT_TRUE(input->read_image(0, 0, 0, 2, OIIO::TypeFloat, read.data()));
    EXPECT_EQ(read, motion.values);
}

} // namespace
