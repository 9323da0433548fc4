// SPDX-License-Identifier: Apache-2.0
// Images written for a test, and textures prepared from them with a page store of the test's own.
#pragma once

#include "hdStream/texture/texturePreparer.h"
#include "kernels/shared/textureCodec.h"
#include "testenv/support/temporaryFolder.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// What a test image holds at (x, y), channel c, before its type rounds it.
using ImageFormula = std::function<double(int x, int y, int c)>;

/// Slow waves and a little noise, in [0, 1].
inline double Waves(int x, int y, int c) {
    const double noise = ((x * 73856093 ^ y * 19349663 ^ c * 83492791) & 255) / 255.0;
    return 0.5 + 0.3 * std::sin(0.11 * x + 0.07 * y + c) + 0.1 * std::cos(0.31 * y) + 0.05 * noise;
}

class TextureTest : public ::testing::Test {
protected:
    /// \param name with the extension that chooses the file format
    std::string WriteImage(const std::string& name, int width, int height, int channels,
                           OIIO::TypeDesc type, const ImageFormula& formula = Waves) {
        OIIO::ImageSpec spec(width, height, channels, type);
        spec.attribute("oiio:UnassociatedAlpha", 1);
        std::vector<float> values;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                for (int c = 0; c < channels; ++c) {
                    values.push_back(static_cast<float>(formula(x, y, c)));
                }
            }
        }
        const std::string path = folder.File(name);
        const auto output = OIIO::ImageOutput::create(path);
        EXPECT_TRUE(output && output->open(path, spec)) << OIIO::geterror();
        EXPECT_TRUE(output->write_image(OIIO::TypeFloat, values.data())) << output->geterror();
        EXPECT_TRUE(output->close());
        return path;
    }

    static TextureRequest Request(const std::string& colorSpace, std::uint32_t channels = 15) {
        TextureRequest request;
        request.colorSpace = colorSpace;
        request.channels = channels;
        return request;
    }

    std::shared_ptr<PageStore> OpenStore() {
        PageStoreOptions options;
        options.directory = folder.File("cache");
        return std::make_shared<PageStore>(options, &warnings);
    }

    /// Prepared without a store.
    std::shared_ptr<const PreparedTexture> Prepare(const std::string& path,
                                                   const std::string& colorSpace = "raw",
                                                   std::uint32_t channels = 15) {
        return TexturePreparer(nullptr, &warnings)
            .Prepare({path, 0, 0, ""}, Request(colorSpace, channels));
    }

    static std::vector<TextureLine> AllLines(const PreparedTexture& texture) {
        std::vector<TextureLine> lines(texture.NumLines());
        for (std::uint32_t line = 0; line < texture.NumLines(); ++line) {
            EXPECT_TRUE(texture.ReadLine(line, &lines[line])) << line;
        }
        return lines;
    }

    /// RGBA of a texel of a mip.
    static std::vector<float> Texel(const PreparedTexture& texture, std::uint32_t mip,
                                    std::uint32_t x, std::uint32_t y) {
        const std::vector<float> pixels = texture.DecodeMip(mip);
        const std::uint32_t width = std::max(1u, texture.Record().width >> mip);
        const std::size_t at = std::size_t{4} * (y * width + x);
        return {pixels.begin() + static_cast<std::ptrdiff_t>(at),
                pixels.begin() + static_cast<std::ptrdiff_t>(at + 4)};
    }

    test::TemporaryFolder folder;
    Warnings warnings;
};

} // namespace hds
