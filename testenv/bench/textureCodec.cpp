// SPDX-License-Identifier: Apache-2.0
// What the texture codec loses, image by image, and how fast it is: benchTextureCodec FILES. One
// CSV row an image; testenv/bench/textureCodec.py makes the table and the chart of it. PSNR is of
// the stored codes of the colour channels, all texels of the finest level; the angle is of vectors
// 2 c / 255 - 1. Speeds are bytes of the decoded image by second of CPU time: of the encoder alone,
// and of preparing the texture as a whole (decoding the file, filtering, encoding) without a store.
// Images that are not of 8 bits are left out.
#include "kernels/shared/textureCodec.h"
#include "hdStream/texture/blockEncoder.h"
#include "hdStream/texture/imageFile.h"
#include "hdStream/texture/texturePreparer.h"
#include "testenv/bench/reportCodec.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

namespace {

using hds::shared::HdsTexel8;

/// Of a difference of the report's scheme and of plainly rounded codes: error against rate.
constexpr int kCurveBits[] = {2, 3, 4, 5, 6};

struct Image {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t channels = 0; ///< stored: 1, 2, 4
    std::uint32_t colors = 0;   ///< of them are measured
    bool isNormalMap = false;   ///< by its name
    std::vector<std::uint8_t> texels;
};

/// Sums over the texels of an image.
struct Loss {
    double squares = 0.0;
    double count = 0.0; ///< values in it
    double radians = 0.0;
};

bool Load(const char* path, Image* image) {
    std::string error;
    const auto file = hds::ImageFile::Open({path, 0, 0, ""}, &error);
    if (!file || file->Spec().format != OIIO::TypeUInt8) {
        return false;
    }
    const hds::ColorChannels order = hds::FindColorChannels(file->Spec());
    const bool isGray = order.red == order.green;
    image->isNormalMap = std::string(path).find("ormal") != std::string::npos;
    image->width = file->Width();
    image->height = file->Height();
    image->colors = isGray ? 1 : (order.blue < 0 ? 2 : 3);
    image->channels = isGray ? (order.alpha < 0 ? 1 : 2) : 4;
    const int sources[4] = {order.red, isGray ? order.alpha : order.green, order.blue, order.alpha};
    const int begin = order.Begin();
    const auto stride = static_cast<std::size_t>(order.End() - begin);
    image->texels.resize(std::size_t{image->channels} * image->width * image->height);
    error = file->ReadBands(
        OIIO::TypeUInt8, begin, order.End(),
        [&](std::uint32_t y, std::uint32_t rows, const void* band) {
            const auto* pixel = static_cast<const std::uint8_t*>(band);
            std::uint8_t* out = &image->texels[std::size_t{y} * image->width * image->channels];
            for (std::size_t i = 0; i < std::size_t{rows} * image->width; ++i, pixel += stride) {
                for (std::uint32_t c = 0; c < image->channels; ++c) {
                    *out++ = sources[c] < 0 ? (c == 3 ? 255 : 0) : pixel[sources[c] - begin];
                }
            }
        });
    return error.empty();
}

void Fetch(const Image& image, std::uint32_t blockX, std::uint32_t blockY, std::uint8_t* texels) {
    for (std::uint32_t i = 0; i < 16; ++i) {
        const std::size_t x = std::min(blockX * 4 + i % 4, image.width - 1);
        const std::size_t y = std::min(blockY * 4 + i / 4, image.height - 1);
        std::copy_n(&image.texels[(y * image.width + x) * image.channels], image.channels,
                    texels + std::size_t{i} * image.channels);
    }
}

void Decode(const std::uint32_t* block, std::uint32_t channels, std::uint8_t* texels) {
    for (std::uint32_t i = 0; i < 16; ++i) {
        if (channels == 4) {
            const HdsTexel8 texel = hds::shared::codec_color8(block, i);
            const std::uint32_t codes[4] = {texel.r, texel.g, texel.b, texel.a};
            std::copy_n(codes, 4, texels + std::size_t{4} * i);
        } else {
            for (std::uint32_t c = 0; c < channels; ++c) {
                texels[i * channels + c] =
                    static_cast<std::uint8_t>(hds::shared::codec_scalar8(block + 2 * c, i));
            }
        }
    }
}

double Angle(const std::uint8_t* a, const std::uint8_t* b) {
    double dot = 0.0;
    double lengths[2] = {0.0, 0.0};
    for (int c = 0; c < 3; ++c) {
        const double u = 2.0 * a[c] / 255.0 - 1.0;
        const double v = 2.0 * b[c] / 255.0 - 1.0;
        dot += u * v;
        lengths[0] += u * u;
        lengths[1] += v * v;
    }
    return std::acos(std::clamp(dot / std::sqrt(lengths[0] * lengths[1] + 1e-30), -1.0, 1.0));
}

/// Adds the texels of a block that are inside the image.
void Compare(const Image& image, std::uint32_t blockX, std::uint32_t blockY,
             const std::uint8_t* texels, const std::uint8_t* decoded, Loss* loss) {
    for (std::uint32_t i = 0; i < 16; ++i) {
        if (blockX * 4 + i % 4 >= image.width || blockY * 4 + i / 4 >= image.height) {
            continue;
        }
        for (std::uint32_t c = 0; c < image.colors; ++c) {
            const std::size_t at = std::size_t{i} * image.channels + c;
            const double error = double(texels[at]) - decoded[at];
            loss->squares += error * error;
        }
        loss->count += image.colors;
        if (image.isNormalMap && image.colors == 3) {
            loss->radians += Angle(&texels[std::size_t{4} * i], &decoded[std::size_t{4} * i]);
        }
    }
}

double Psnr(const Loss& loss) {
    return loss.squares == 0.0 ? 999.0
                               : 10.0 * std::log10(255.0 * 255.0 * loss.count / loss.squares);
}

double Degrees(const Loss& loss) {
    return loss.radians * 180.0 / std::acos(-1.0) / (loss.count / 3.0);
}

/// An image in blocks, in scan order.
struct Blocks {
    std::uint32_t across = 0;
    std::uint32_t count = 0;
    std::vector<std::uint8_t> texels;
};

Blocks CutBlocks(const Image& image) {
    Blocks blocks;
    blocks.across = (image.width + 3) / 4;
    blocks.count = blocks.across * ((image.height + 3) / 4);
    blocks.texels.resize(std::size_t{16} * image.channels * blocks.count);
    for (std::uint32_t i = 0; i < blocks.count; ++i) {
        Fetch(image, i % blocks.across, i / blocks.across,
              &blocks.texels[std::size_t{16} * image.channels * i]);
    }
    return blocks;
}

/// Of every `stride`-th block. \param roundTrip (index of a block, its texels, decoded texels)
template <typename RoundTrip>
Loss MeasureLoss(const Image& image, const Blocks& blocks, std::uint32_t stride,
                 const RoundTrip& roundTrip) {
    Loss loss;
    for (std::uint32_t i = 0; i < blocks.count; i += stride) {
        const std::uint8_t* texels = &blocks.texels[std::size_t{16} * image.channels * i];
        std::uint8_t decoded[64];
        roundTrip(i, texels, decoded);
        Compare(image, i % blocks.across, i / blocks.across, texels, decoded, &loss);
    }
    return loss;
}

/// CPU time of this process: other work on the machine disturbs it less than it does the clock.
double CpuSeconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double PrepareSeconds(const char* path) {
    const double begin = CpuSeconds();
    tbb::task_arena(1).execute([&] {
        hds::TextureRequest request;
        request.colorSpace = "auto";
        hds::TexturePreparer(nullptr).Prepare({path, 0, 0, ""}, request,
                                              hds::TexturePreparer::kAllTexels);
    });
    return std::max(CpuSeconds() - begin, 1e-6);
}

/// Error against rate, of every eighth block.
void PrintCurve(const Image& image, const Blocks& blocks) {
    for (const int bits : kCurveBits) {
        const Loss delta = MeasureLoss(image, blocks, 8,
                                       [&](std::uint32_t, const std::uint8_t* t, std::uint8_t* d) {
                                           hds::bench::RoundTripReport(t, image.channels, bits, d);
                                       });
        const Loss plain = MeasureLoss(image, blocks, 8,
                                       [&](std::uint32_t, const std::uint8_t* t, std::uint8_t* d) {
                                           hds::bench::RoundTripPlain(t, image.channels, bits, d);
                                       });
        std::printf(",%.3f,%.3f", Psnr(delta), Psnr(plain));
    }
    std::printf("\n");
    std::fflush(stdout);
}

void Measure(const char* path, const Image& image) {
    const Blocks blocks = CutBlocks(image);
    const std::uint32_t channels = image.channels;
    const std::uint32_t format = HDS_TEXEL_U8 | (channels == 4 ? 2u : channels - 1);
    const std::size_t words = (1u << hds::shared::texel_blockBytesLog2(format)) / 4;
    std::vector<std::uint32_t> encoded(words * blocks.count);
    const double begin = CpuSeconds();
    for (std::size_t i = 0; i < blocks.count; ++i) {
        hds::EncodeBlock(format, &blocks.texels[16 * channels * i], &encoded[words * i]);
    }
    const double seconds = std::max(CpuSeconds() - begin, 1e-6);
    const Loss ours = MeasureLoss(image, blocks, 1,
                                  [&](std::uint32_t i, const std::uint8_t*, std::uint8_t* decoded) {
                                      Decode(&encoded[words * i], channels, decoded);
                                  });
    const Loss report =
        MeasureLoss(image, blocks, 1, [&](std::uint32_t, const std::uint8_t* t, std::uint8_t* d) {
            hds::bench::RoundTripReport(t, channels, hds::bench::ReportDeltaBits(t, channels), d);
        });
    const double megabytes = 1e-6 * double(image.texels.size());
    std::printf("%s,%u,%u,%u,%.3f,%.3f,%.4f,%.4f,%.1f,%.1f", path, image.width, image.height,
                channels, Psnr(ours), Psnr(report), Degrees(ours), Degrees(report),
                megabytes / seconds, megabytes / PrepareSeconds(path));
    PrintCurve(image, blocks);
}

} // namespace

int main(int argc, char** argv) {
    std::printf("file,width,height,channels,ours,report,oursDegrees,reportDegrees,encodeMBps,"
                "prepareMBps");
    for (const int bits : kCurveBits) {
        std::printf(",report%d,plain%d", bits, bits);
    }
    std::printf("\n");
    for (int i = 1; i < argc; ++i) {
        Image image;
        if (Load(argv[i], &image)) {
            Measure(argv[i], image);
        }
    }
    return 0;
}
