// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/compare.h"

#include "hdStream/texture/imageFile.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

namespace hds {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One channel inside a natively packed pixel.
struct Channel {
    std::string name;
    OIIO::TypeDesc type;
    std::size_t offset = 0; ///< bytes
};

struct ChannelTable {
    std::vector<Channel> channels;
    std::size_t pixelBytes = 0;
};

ChannelTable ListChannels(const OIIO::ImageSpec& spec) {
    ChannelTable table;
    for (int c = 0; c < spec.nchannels; ++c) {
        const OIIO::TypeDesc type = spec.channelformat(c);
        table.channels.push_back({spec.channel_name(c), type, table.pixelBytes});
        table.pixelBytes += type.size();
    }
    return table;
}

template <typename T>
T Load(const char* at) {
    T value;
    std::memcpy(&value, at, sizeof(T));
    return value;
}

/// IEEE 754 binary16: 1 sign, 5 exponent (bias 15) and 10 fraction bits.
double FromHalf(std::uint16_t bits) {
    const int exponent = (bits >> 10) & 31;
    const int fraction = bits & 1023;
    double value = 0.0;
    if (exponent == 31) {
        value = fraction ? std::numeric_limits<double>::quiet_NaN() : kInfinity;
    } else if (exponent == 0) {
        value = std::ldexp(fraction, -24);
    } else {
        value = std::ldexp(1024 + fraction, exponent - 25);
    }
    return bits & 0x8000 ? -value : value;
}

/// The number a stored value stands for. 32-bit integers are ids and stand for themselves.
double ValueOf(const char* at, const OIIO::TypeDesc& type) {
    switch (type.basetype) {
    case OIIO::TypeDesc::UINT8:
        return Load<std::uint8_t>(at) / 255.0;
    case OIIO::TypeDesc::UINT16:
        return Load<std::uint16_t>(at) / 65535.0;
    case OIIO::TypeDesc::INT8:
        return Load<std::int8_t>(at) / 127.0;
    case OIIO::TypeDesc::INT16:
        return Load<std::int16_t>(at) / 32767.0;
    case OIIO::TypeDesc::UINT32:
        return Load<std::uint32_t>(at);
    case OIIO::TypeDesc::INT32:
        return Load<std::int32_t>(at);
    case OIIO::TypeDesc::HALF:
        return FromHalf(Load<std::uint16_t>(at));
    case OIIO::TypeDesc::FLOAT:
        return Load<float>(at);
    case OIIO::TypeDesc::DOUBLE:
        return Load<double>(at);
    default:
        return std::numeric_limits<double>::quiet_NaN();
    }
}

std::string LayerOf(const std::string& channelName) {
    const std::size_t dot = channelName.find_last_of('.');
    return dot == std::string::npos ? "color" : channelName.substr(0, dot);
}

/// Sums of one layer, filled row by row: each row is summed for itself first, so that rounding
/// does not grow with the number of pixels.
struct LayerSums {
    std::vector<std::pair<Channel, Channel>> channels; ///< of file and reference
    LayerDifference difference;
    double squares = 0.0;
    double relativeSquares = 0.0;

    void AddRow(const char* a, const char* b, std::size_t width, std::size_t strideA,
                std::size_t strideB);
    LayerDifference Finish() const;
};

void LayerSums::AddRow(const char* a, const char* b, std::size_t width, std::size_t strideA,
                       std::size_t strideB) {
    double rowSquares = 0.0;
    double rowRelative = 0.0;
    for (std::size_t x = 0; x < width; ++x) {
        bool differs = false;
        for (const auto& [channelA, channelB] : channels) {
            const double valueA = ValueOf(a + x * strideA + channelA.offset, channelA.type);
            const double valueB = ValueOf(b + x * strideB + channelB.offset, channelB.type);
            if (!std::isfinite(valueA) || !std::isfinite(valueB)) {
                ++difference.numNonFinite;
            }
            if (valueA == valueB || (std::isnan(valueA) && std::isnan(valueB))) {
                continue;
            }
            differs = true;
            double distance = std::abs(valueA - valueB);
            double relative = distance * distance / (valueB * valueB + 0.01);
            if (!std::isfinite(valueA) || !std::isfinite(valueB)) {
                distance = relative = kInfinity;
            }
            difference.maxAbs = std::max(difference.maxAbs, distance);
            rowSquares += distance * distance;
            rowRelative += relative;
        }
        difference.numDifferingPixels += differs ? 1 : 0;
    }
    squares += rowSquares;
    relativeSquares += rowRelative;
    difference.numPixels += width;
}

LayerDifference LayerSums::Finish() const {
    LayerDifference result = difference;
    const double count =
        static_cast<double>(result.numPixels) * static_cast<double>(channels.size());
    result.rmse = std::sqrt(squares / count);
    result.relMse = relativeSquares / count;
    result.psnr = -20.0 * std::log10(result.rmse);
    return result;
}

std::string NamesOf(const ChannelTable& table) {
    std::vector<std::string> names;
    for (const Channel& channel : table.channels) {
        names.push_back(channel.name);
    }
    std::sort(names.begin(), names.end());
    std::string text;
    for (const std::string& name : names) {
        text += (text.empty() ? "" : ",") + name;
    }
    return text;
}

std::map<std::string, LayerSums> PairChannels(const ChannelTable& a, const ChannelTable& b) {
    std::map<std::string, LayerSums> layers;
    for (const Channel& channel : a.channels) {
        const auto other = std::find_if(b.channels.begin(), b.channels.end(),
                                        [&](const Channel& c) { return c.name == channel.name; });
        layers[LayerOf(channel.name)].channels.emplace_back(channel, *other);
    }
    return layers;
}

/// Whether two files of data windows hold different parts of one picture.
bool AreElsewhere(const OIIO::ImageSpec& a, const OIIO::ImageSpec& b) {
    const bool isOnePicture = a.full_x == b.full_x && a.full_y == b.full_y &&
                              a.full_width == b.full_width && a.full_height == b.full_height;
    return isOnePicture && (a.x != b.x || a.y != b.y);
}

/// Why the two cannot be compared; empty when they can.
std::string CheckComparable(const ImageFile& file, const ImageFile& reference) {
    const auto size = [](const ImageFile& image) {
        return std::to_string(image.Width()) + "x" + std::to_string(image.Height());
    };
    if (size(file) != size(reference)) {
        return file.Name() + ": is " + size(file) + " pixels but " + reference.Name() + " is " +
               size(reference);
    }
    if (AreElsewhere(file.Spec(), reference.Spec())) {
        const auto place = [](const OIIO::ImageSpec& spec) {
            return "(" + std::to_string(spec.x) + ", " + std::to_string(spec.y) + ")";
        };
        return file.Name() + ": its data window begins at " + place(file.Spec()) + " but that of " +
               reference.Name() + " at " + place(reference.Spec());
    }
    const std::string names = NamesOf(ListChannels(file.Spec()));
    const std::string otherNames = NamesOf(ListChannels(reference.Spec()));
    if (names != otherNames) {
        return file.Name() + ": has channels " + names + " but " + reference.Name() + " has " +
               otherNames;
    }
    return {};
}

} // namespace

bool ImageComparison::IsAbove(double threshold) const {
    return std::any_of(layers.begin(), layers.end(), [threshold](const LayerDifference& layer) {
        return !(layer.relMse <= threshold);
    });
}

ImageComparison CompareImages(const std::string& file, const std::string& referenceFile) {
    ImageComparison result;
    const std::unique_ptr<ImageFile> a = ImageFile::Open({file, 0, 0, {}}, &result.error);
    const std::unique_ptr<ImageFile> b =
        a ? ImageFile::Open({referenceFile, 0, 0, {}}, &result.error) : nullptr;
    if (!b) {
        return result;
    }
    result.error = CheckComparable(*a, *b);
    if (!result.Ok()) {
        return result;
    }
    result.width = a->Width();
    result.height = a->Height();
    const ChannelTable tableA = ListChannels(a->Spec());
    const ChannelTable tableB = ListChannels(b->Spec());
    std::map<std::string, LayerSums> layers = PairChannels(tableA, tableB);

    const std::size_t width = a->Width();
    const std::size_t rowBytesA = width * tableA.pixelBytes;
    const std::size_t rowBytesB = width * tableB.pixelBytes;
    std::vector<char> pixels(rowBytesA * a->Height());
    result.error = a->ReadBands(OIIO::TypeUnknown, 0, a->Spec().nchannels,
                                [&](std::uint32_t y, std::uint32_t rows, const void* data) {
                                    std::memcpy(&pixels[y * rowBytesA], data, rows * rowBytesA);
                                });
    if (result.Ok()) {
        result.error =
            b->ReadBands(OIIO::TypeUnknown, 0, b->Spec().nchannels,
                         [&](std::uint32_t y, std::uint32_t rows, const void* data) {
                             for (std::uint32_t row = 0; row < rows; ++row) {
                                 for (auto& [name, sums] : layers) {
                                     sums.AddRow(&pixels[(y + row) * rowBytesA],
                                                 static_cast<const char*>(data) + row * rowBytesB,
                                                 width, tableA.pixelBytes, tableB.pixelBytes);
                                 }
                             }
                         });
    }
    for (auto& [name, sums] : layers) {
        sums.difference.name = name;
        const auto where = name == "color" ? result.layers.begin() : result.layers.end();
        result.layers.insert(where, sums.Finish());
    }
    return result;
}

} // namespace hds
