// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/imageReader.h"

#include "hdStream/texture/boxFilter.h"
#include "hdStream/texture/colorDecoder.h"
#include "hdStream/texture/imageFile.h"

#include <cmath>
#include <memory>
#include <new>

namespace hds {

namespace {

/// Sums RGBA of rows of decoded floats, row by row, so that rounding errors do not grow with the
/// size of the image and the result does not depend on the bands.
class FloatMean {
public:
    FloatMean(const ColorDecoder& decoder, const ColorChannels& channels)
        : _decoder(decoder), _channels(channels) {}

    void AddRow(const float* pixels, std::uint32_t width) {
        const int stride = _channels.End() - _channels.Begin();
        const int begin = _channels.Begin();
        _rgb.resize(std::size_t{3} * width);
        double alphaSum = 0.0;
        for (std::uint32_t x = 0; x < width; ++x) {
            const float* pixel = pixels + std::size_t{x} * static_cast<std::size_t>(stride);
            float* rgb = &_rgb[std::size_t{3} * x];
            rgb[0] = Finite(pixel[_channels.red - begin]);
            rgb[1] = Finite(pixel[_channels.green - begin]);
            rgb[2] = _channels.blue < 0 ? 0.0f : Finite(pixel[_channels.blue - begin]);
            alphaSum += _channels.alpha < 0 ? 1.0 : Finite(pixel[_channels.alpha - begin]);
        }
        _decoder.DecodeRgb(_rgb.data(), width);
        double rowSum[3] = {0, 0, 0};
        for (std::uint32_t x = 0; x < width; ++x) {
            for (int c = 0; c < 3; ++c) {
                rowSum[c] += _rgb[std::size_t{3} * x + c];
            }
        }
        for (int c = 0; c < 3; ++c) {
            _sum[c] += rowSum[c];
        }
        _sum[3] += alphaSum;
    }

    double Sum(int c) const { return _sum[c]; }
    std::uint64_t NumNonFinite() const { return _numNonFinite; }

private:
    float Finite(float value) {
        if (std::isfinite(value)) {
            return value;
        }
        ++_numNonFinite;
        return 0.0f;
    }

    const ColorDecoder& _decoder;
    ColorChannels _channels;
    std::vector<float> _rgb;
    double _sum[4] = {0, 0, 0, 0};
    std::uint64_t _numNonFinite = 0;
};

/// Means of 8 and 16 bit images: counting values is exact, and each value is decoded once.
template <typename T>
std::string HistogramMean(ImageFile& file, const ColorDecoder& decoder,
                          const ColorChannels& channels, std::array<double, 4>* rgba) {
    constexpr std::size_t kNumValues = std::size_t{1} << (8 * sizeof(T));
    const int begin = channels.Begin();
    const int stride = channels.End() - begin;
    std::vector<std::vector<std::uint64_t>> counts(static_cast<std::size_t>(stride),
                                                   std::vector<std::uint64_t>(kNumValues, 0));
    const OIIO::TypeDesc type(sizeof(T) == 1 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16);
    const std::uint64_t width = file.Width();
    std::string error = file.ReadBands(
        type, begin, channels.End(), [&](std::uint32_t, std::uint32_t rows, const void* data) {
            const T* values = static_cast<const T*>(data);
            for (int c = 0; c < stride; ++c) {
                std::uint64_t* count = counts[static_cast<std::size_t>(c)].data();
                for (std::uint64_t i = 0; i < width * rows; ++i) {
                    ++count[values[i * static_cast<std::uint64_t>(stride) +
                                   static_cast<std::uint64_t>(c)]];
                }
            }
        });
    const double numPixels = static_cast<double>(width) * file.Height();
    const int order[4] = {channels.red, channels.green, channels.blue, channels.alpha};
    for (int c = 0; c < 4; ++c) {
        if (order[c] < 0) {
            continue;
        }
        const std::vector<std::uint64_t>& count =
            counts[static_cast<std::size_t>(order[c] - begin)];
        double sum = 0.0;
        for (std::size_t v = 0; v < kNumValues; ++v) {
            const double encoded = static_cast<double>(v) / static_cast<double>(kNumValues - 1);
            const double value = c < 3 ? decoder.DecodeChannel(encoded) : encoded;
            sum += static_cast<double>(count[v]) * value;
        }
        (*rgba)[static_cast<std::size_t>(c)] = sum / numPixels;
    }
    return error;
}

/// Radiance is finite and not negative; what was not is counted.
void SanitiseRadiance(float* values, std::size_t count, LinearImage* image) {
    constexpr float kLargestHalf = 65504.0f;
    for (std::size_t i = 0; i < count; ++i) {
        if (!std::isfinite(values[i])) {
            values[i] = values[i] > 0.0f ? kLargestHalf : 0.0f;
            ++image->numNonFinite;
        } else if (values[i] < 0.0f) {
            values[i] = 0.0f;
            ++image->numNegative;
        }
    }
}

/// Linear floats of all codes of an integer type, for spaces that decode each channel for itself.
template <typename T>
std::vector<float> DecodeTable(const ColorDecoder& decoder) {
    constexpr std::size_t kNumValues = std::size_t{1} << (8 * sizeof(T));
    std::vector<float> table(kNumValues);
    for (std::size_t v = 0; v < kNumValues; ++v) {
        const double encoded = static_cast<double>(v) / static_cast<double>(kNumValues - 1);
        table[v] = static_cast<float>(decoder.DecodeChannel(encoded));
    }
    return table;
}

/// Reads rows of channels of type T; `decodeRow` turns them into linear RGB.
template <typename T, typename DecodeRow>
std::string LoadRows(ImageFile& file, const OIIO::TypeDesc& type, const ColorChannels& channels,
                     const DecodeRow& decodeRow, LinearImage* image) {
    const auto stride = static_cast<std::size_t>(channels.End() - channels.Begin());
    const std::uint32_t width = file.Width();
    BoxFilter filter(width, file.Height(), image->width, image->height);
    std::vector<float> rgb(std::size_t{3} * width);
    std::string error = file.ReadBands(
        type, channels.Begin(), channels.End(),
        [&](std::uint32_t, std::uint32_t rows, const void* data) {
            for (std::uint32_t row = 0; row < rows; ++row) {
                decodeRow(static_cast<const T*>(data) + stride * width * row, rgb.data());
                SanitiseRadiance(rgb.data(), rgb.size(), image);
                filter.AddRow(rgb.data());
            }
        });
    image->pixels = filter.TakePixels();
    return error;
}

template <typename T>
std::string LoadIntegerRows(ImageFile& file, const OIIO::TypeDesc& type,
                            const ColorDecoder& decoder, LinearImage* image) {
    const ColorChannels channels = FindColorChannels(file.Spec());
    const std::vector<float> table = DecodeTable<T>(decoder);
    const int begin = channels.Begin();
    const auto stride = static_cast<std::size_t>(channels.End() - begin);
    const std::uint32_t width = file.Width();
    const auto decodeRow = [&](const T* pixel, float* rgb) {
        for (std::uint32_t x = 0; x < width; ++x, pixel += stride, rgb += 3) {
            rgb[0] = table[pixel[channels.red - begin]];
            rgb[1] = table[pixel[channels.green - begin]];
            rgb[2] = channels.blue < 0 ? 0.0f : table[pixel[channels.blue - begin]];
        }
    };
    return LoadRows<T>(file, type, channels, decodeRow, image);
}

std::string LoadFloatRows(ImageFile& file, const ColorDecoder& decoder, LinearImage* image) {
    const ColorChannels channels = FindColorChannels(file.Spec());
    const int begin = channels.Begin();
    const auto stride = static_cast<std::size_t>(channels.End() - begin);
    const std::uint32_t width = file.Width();
    const auto decodeRow = [&](const float* pixel, float* rgb) {
        float* out = rgb;
        for (std::uint32_t x = 0; x < width; ++x, pixel += stride, out += 3) {
            out[0] = pixel[channels.red - begin];
            out[1] = pixel[channels.green - begin];
            out[2] = channels.blue < 0 ? 0.0f : pixel[channels.blue - begin];
        }
        decoder.DecodeRgb(rgb, width);
    };
    return LoadRows<float>(file, OIIO::TypeFloat, channels, decodeRow, image);
}

std::string LoadPixels(ImageFile& file, const ColorDecoder& decoder, LinearImage* image) {
    const OIIO::TypeDesc type = file.Spec().format;
    if (decoder.IsPerChannel() && type == OIIO::TypeUInt8) {
        return LoadIntegerRows<std::uint8_t>(file, type, decoder, image);
    }
    if (decoder.IsPerChannel() && type == OIIO::TypeUInt16) {
        return LoadIntegerRows<std::uint16_t>(file, type, decoder, image);
    }
    return LoadFloatRows(file, decoder, image);
}

std::string NamedWarning(const ImageSource& source, const std::string& warning) {
    return warning.empty() ? warning
                           : (source.name.empty() ? source.file : source.name) + ": " + warning;
}

} // namespace

ImageInfo DescribeImage(const ImageFile& file) {
    const OIIO::ImageSpec& spec = file.Spec();
    ImageInfo info;
    info.width = file.Width();
    info.height = file.Height();
    info.channels = static_cast<std::uint32_t>(spec.nchannels);
    info.fileFormat = file.FormatName();
    info.channelType = spec.format.c_str();
    info.autoColorSpace = AutoColorSpace(spec);
    info.hasAlpha = FindColorChannels(spec).alpha >= 0;
    // "black,periodic": s, then t; one mode is for both.
    const std::string wraps = spec.get_string_attribute("wrapmodes");
    const std::size_t comma = wraps.find(',');
    info.wrapS = wraps.substr(0, comma);
    info.wrapT = comma == std::string::npos ? wraps : wraps.substr(comma + 1);
    // What UsdUVTexture's text asks for comes first.
    info.wrapS = spec.get_string_attribute("wrapS", info.wrapS);
    info.wrapT = spec.get_string_attribute("wrapT", info.wrapT);
    info.bytesDecoded = std::uint64_t{info.width} * info.height * spec.pixel_bytes(true);
    return info;
}

ImageInfo ProbeImage(const ImageSource& source) {
    ImageInfo info;
    const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &info.error);
    return file ? DescribeImage(*file) : info;
}

MeanColorResult MeanColor(const ImageSource& source, const std::string& colorSpace) {
    MeanColorResult result;
    const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &result.error);
    if (!file) {
        return result;
    }
    result.info = DescribeImage(*file);
    const ColorDecoder decoder(colorSpace, file->Spec(), &result.warning);
    result.warning = NamedWarning(source, result.warning);
    const ColorChannels channels = FindColorChannels(file->Spec());
    if (decoder.IsPerChannel() && file->Spec().format == OIIO::TypeUInt8) {
        result.error = HistogramMean<std::uint8_t>(*file, decoder, channels, &result.rgba);
    } else if (decoder.IsPerChannel() && file->Spec().format == OIIO::TypeUInt16) {
        result.error = HistogramMean<std::uint16_t>(*file, decoder, channels, &result.rgba);
    } else {
        FloatMean mean(decoder, channels);
        const auto stride = static_cast<std::size_t>(channels.End() - channels.Begin());
        const std::uint32_t width = file->Width();
        result.error = file->ReadBands(
            OIIO::TypeFloat, channels.Begin(), channels.End(),
            [&](std::uint32_t, std::uint32_t rows, const void* data) {
                for (std::uint32_t row = 0; row < rows; ++row) {
                    mean.AddRow(static_cast<const float*>(data) + stride * width * row, width);
                }
            });
        for (int c = 0; c < 4; ++c) {
            result.rgba[static_cast<std::size_t>(c)] =
                mean.Sum(c) / (static_cast<double>(width) * file->Height());
        }
        result.numNonFinite = mean.NumNonFinite();
    }
    return result;
}

LinearImage LoadLinearImage(const ImageSource& source, const std::string& colorSpace,
                            std::uint64_t maxPixels) {
    LinearImage image;
    const std::unique_ptr<ImageFile> file = ImageFile::Open(source, &image.error);
    if (!file) {
        return image;
    }
    image.info = DescribeImage(*file);
    const ColorDecoder decoder(colorSpace, file->Spec(), &image.warning);
    const ReducedSize size = ReduceSize(file->Width(), file->Height(), maxPixels);
    image.width = size.width;
    image.height = size.height;
    try {
        image.error = LoadPixels(*file, decoder, &image);
    } catch (const std::bad_alloc&) {
        image.error = file->Name() + ": there is not enough memory to load it";
    }
    if (image.warning.empty() && image.numNonFinite + image.numNegative > 0) {
        image.warning = std::to_string(image.numNonFinite) + " NaN or infinite and " +
                        std::to_string(image.numNegative) + " negative values were replaced";
    }
    image.warning = NamedWarning(source, image.warning);
    if (!image.error.empty()) {
        image.pixels.clear();
    }
    return image;
}

} // namespace hds
