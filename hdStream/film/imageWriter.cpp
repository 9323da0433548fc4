// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/imageWriter.h"

#include "hdStream/base/error.h"
#include "hdStream/base/letters.h"
#include "hdStream/film/aov.h"
#include "hdStream/film/atomicFile.h"
#include "hdStream/film/quantise.h"
#include "hdStream/texture/colorConfig.h"
#include "hdStream/texture/halfFloat.h"
#include "hdStream/texture/oneLine.h"

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <set>

namespace hds {

namespace {

enum class FileKind { Exr, Png, Jpeg, Tiff, Hdr };

FileKind KindOf(const std::string& file) {
    const std::size_t dot = file.find_last_of("./\\");
    std::string extension =
        dot == std::string::npos || file[dot] != '.' ? "" : file.substr(dot + 1);
    std::transform(extension.begin(), extension.end(), extension.begin(), LowerLetter);
    static const std::map<std::string, FileKind> kinds{
        {"exr", FileKind::Exr},   {"png", FileKind::Png},  {"jpg", FileKind::Jpeg},
        {"jpeg", FileKind::Jpeg}, {"tif", FileKind::Tiff}, {"tiff", FileKind::Tiff},
        {"hdr", FileKind::Hdr}};
    const auto found = kinds.find(extension);
    if (found == kinds.end()) {
        throw Error("cannot write '" + file +
                        "': its extension is none of .exr .png .jpg .tif .hdr",
                    ErrorKind::Usage);
    }
    return found->second;
}

const char* FormatName(FileKind kind) {
    switch (kind) {
    case FileKind::Exr:
        return "openexr";
    case FileKind::Png:
        return "png";
    case FileKind::Jpeg:
        return "jpeg";
    case FileKind::Tiff:
        return "tiff";
    case FileKind::Hdr:
        return "hdr";
    }
    return "";
}

/// Lets an OpenImageIO encoder write into an atomic file.
class AtomicFileProxy : public OIIO::Filesystem::IOProxy {
public:
    AtomicFileProxy(AtomicFile* file, const std::string& name)
        : IOProxy(name, IOProxy::Write), _file(file) {}
    const char* proxytype() const override { return "hdstream"; }
    // OpenImageIO 3 made it const; without `override`, each version finds its own.
    std::int64_t tell() { return _file->Tell(); }
    std::int64_t tell() const { return _file->Tell(); }
    bool seek(std::int64_t offset) override { return _file->Seek(offset); }
    std::size_t write(const void* data, std::size_t bytes) override {
        const std::size_t written = _file->Write(data, bytes);
        _size = std::max(_size, static_cast<std::size_t>(std::max<std::int64_t>(0, tell())));
        return written;
    }
    std::size_t size() const override { return _size; }

private:
    AtomicFile* _file;
    std::size_t _size = 0;
};

/// What an encoder needs: a spec, and rows in its native layout on demand, so that the image is
/// never in memory twice.
struct EncodedImage {
    OIIO::ImageSpec spec;
    std::function<void(std::size_t y, char* row)> packRow;
};

void AddMatrix(OIIO::ImageSpec* spec, const char* name,
               const std::optional<std::array<double, 16>>& matrix) {
    if (matrix) {
        float values[16];
        std::copy(matrix->begin(), matrix->end(), values);
        spec->attribute(name, OIIO::TypeMatrix, values);
    }
}

/// Two decimal digits as SMPTE 12M packs them.
std::uint32_t PackDigits(std::uint32_t value) {
    return value / 10 % 10 << 4U | value % 10;
}

/// Frame and time as SMPTE 12M counts them: whole frames a second, 30 at most, none dropped.
void AddFrame(OIIO::ImageSpec* spec, const ImageMetadata& metadata) {
    const auto [numerator, denominator] = metadata.framesPerSecond;
    if (numerator == 0 || denominator == 0) {
        return;
    }
    const int rate[2] = {static_cast<int>(numerator), static_cast<int>(denominator)};
    spec->attribute("framesPerSecond", OIIO::TypeRational, rate); // by OpenEXR's name
    constexpr std::uint32_t kMostFrames = 30;                     // the digits of a frame go to 39
    const std::uint32_t rounded = (numerator + denominator - 1) / denominator;
    if (!metadata.frameNumber || rounded > kMostFrames) {
        return;
    }
    constexpr std::uint32_t kSixty = 60;
    constexpr std::uint32_t kHours = 24;
    const std::uint32_t frame = *metadata.frameNumber;
    const std::uint32_t seconds = frame / rounded;
    const std::uint32_t code[2] = {PackDigits(frame % rounded) |
                                       PackDigits(seconds % kSixty) << 8U |
                                       PackDigits(seconds / kSixty % kSixty) << 16U |
                                       PackDigits(seconds / kSixty / kSixty % kHours) << 24U,
                                   0};
    spec->attribute("smpte:TimeCode", OIIO::TypeTimeCode, code);
}

void AddMetadata(OIIO::ImageSpec* spec, const ImageMetadata& metadata) {
    spec->attribute("Software", metadata.software);
    spec->attribute("DateTime", ""); // else the encoders write the present time
    spec->attribute("PixelAspectRatio", static_cast<float>(metadata.pixelAspectRatio));
    if (metadata.samples > 0) {
        spec->attribute("hdStream:samples", static_cast<int>(metadata.samples));
    }
    if (!metadata.camera.empty()) {
        spec->attribute("hdStream:camera", metadata.camera);
    }
    AddMatrix(spec, "worldtocamera", metadata.worldToCamera);
    AddMatrix(spec, "worldtoNDC", metadata.worldToNdc);
    AddFrame(spec, metadata);
    for (const auto& [name, text] : metadata.texts) {
        spec->attribute(name, text);
    }
}

void AddWindows(OIIO::ImageSpec* spec, const ImageMetadata& metadata) {
    if (metadata.displayWindowSize[0] > 0) {
        spec->x = metadata.dataWindowMin[0];
        spec->y = metadata.dataWindowMin[1];
        spec->full_width = static_cast<int>(metadata.displayWindowSize[0]);
        spec->full_height = static_cast<int>(metadata.displayWindowSize[1]);
    }
}

/// What colours are in. Of a working space its name is said, and its primaries where it is built
/// in.
void AddColorSpace(OIIO::ImageSpec* spec, const std::string& workingSpace) {
    spec->attribute("oiio:ColorSpace", "Linear");
    if (!workingSpace.empty()) {
        spec->attribute("hdStream:workingSpace", workingSpace);
    }
    const bool isKnown = !workingSpace.empty() || !HasUserColorConfig();
    const auto xy = isKnown ? ChromaticitiesOf(workingSpace.empty() ? "lin_rec709" : workingSpace)
                            : std::nullopt;
    if (xy) {
        spec->attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), xy->data());
    }
}

void CheckLayers(const std::string& file, const std::vector<ImageLayer>& layers) {
    if (layers.empty()) {
        throw Error("cannot write '" + file + "': there is no layer to write");
    }
    std::set<std::string> names;
    for (const ImageLayer& layer : layers) {
        const std::size_t expected =
            std::size_t{layer.width} * layer.height * layer.channels.size();
        HDS_VERIFY(layer.width == layers[0].width && layer.height == layers[0].height,
                   "layers of different sizes: " + layer.name);
        HDS_VERIFY((layer.isInteger ? layer.ids.size() : layer.values.size()) == expected,
                   "layer '" + layer.name + "' does not have width * height * channels values");
        HDS_VERIFY(names.insert(layer.name).second, "layer '" + layer.name + "' appears twice");
    }
    if (layers[0].width == 0 || layers[0].height == 0) {
        throw Error("cannot write '" + file + "': the image has no pixels");
    }
}

/// The nearest half; what is finite stays so.
std::uint16_t PackHalf(float value) {
    if (std::isfinite(value)) {
        return HalfOfFloat(std::clamp(value, -kLargestHalf, kLargestHalf));
    }
    constexpr std::uint16_t kInfinity = 0x7c00;
    constexpr std::uint16_t kNan = 0x7e00;
    constexpr std::uint16_t kSign = 0x8000;
    return std::isnan(value) ? kNan : value < 0.0F ? kSign | kInfinity : kInfinity;
}

/// Writes row `y` of a layer to pixels that are `stride` bytes apart; returns its bytes in each.
std::size_t PackLayer(const ImageLayer& layer, std::size_t y, std::size_t stride, char* row) {
    const std::size_t numChannels = layer.channels.size();
    const std::size_t first = y * layer.width * numChannels;
    if (layer.isHalf && !layer.isInteger) {
        for (std::size_t x = 0; x < layer.width; ++x) {
            for (std::size_t c = 0; c < numChannels; ++c) {
                const std::uint16_t half = PackHalf(layer.values[first + x * numChannels + c]);
                std::memcpy(row + x * stride + c * sizeof(half), &half, sizeof(half));
            }
        }
        return numChannels * sizeof(std::uint16_t);
    }
    const std::size_t bytes = 4 * numChannels;
    const char* source = layer.isInteger ? reinterpret_cast<const char*>(&layer.ids[first])
                                         : reinterpret_cast<const char*>(&layer.values[first]);
    for (std::size_t x = 0; x < layer.width; ++x) {
        std::memcpy(row + x * stride, source + x * bytes, bytes);
    }
    return bytes;
}

/// The AOV that a layer is, whatever the file calls it.
const std::string& AovOf(const ImageLayer& layer, const ImageWriteOptions& options) {
    const auto found = options.aovs.find(layer.name);
    return found != options.aovs.end() ? found->second : layer.name;
}

/// What is known of an AOV, of those too that have no row in the table; null: nothing.
std::shared_ptr<const AovInfo> Describe(const std::string& aov) {
    return HasAov(aov) ? MakeAovLayout({aov}).slots.front().info : nullptr;
}

bool IsColor(const ImageLayer& layer, const ImageWriteOptions& options) {
    const std::shared_ptr<const AovInfo> info = Describe(AovOf(layer, options));
    return info != nullptr && info->isColor;
}

/// All layers side by side. The layers must outlive the result.
EncodedImage EncodeExr(const std::vector<ImageLayer>& layers, const ImageWriteOptions& options) {
    EncodedImage image;
    image.spec = OIIO::ImageSpec(static_cast<int>(layers[0].width),
                                 static_cast<int>(layers[0].height), 0, OIIO::TypeFloat);
    image.spec.channelnames.clear();
    bool isMixed = false;
    for (const ImageLayer& layer : layers) {
        for (const std::string& channel : layer.channels) {
            const bool isMain = layer.name == "color";
            if (isMain && channel == "A") {
                image.spec.alpha_channel = static_cast<int>(image.spec.channelnames.size());
            }
            image.spec.channelnames.push_back(isMain ? channel : layer.name + "." + channel);
            image.spec.channelformats.push_back(layer.isInteger ? OIIO::TypeUInt32
                                                : layer.isHalf  ? OIIO::TypeHalf
                                                                : OIIO::TypeFloat);
            isMixed = isMixed || layer.isInteger || layer.isHalf;
        }
    }
    for (const ImageLayer& layer : layers) {
        for (const auto& [name, text] : layer.header) {
            image.spec.attribute(name, text);
        }
    }
    image.spec.nchannels = static_cast<int>(image.spec.channelnames.size());
    if (!isMixed) {
        image.spec.channelformats.clear();
    }
    image.spec.attribute("compression", "zip");
    if (std::any_of(layers.begin(), layers.end(),
                    [&](const ImageLayer& layer) { return IsColor(layer, options); })) {
        AddColorSpace(&image.spec, options.metadata.workingSpace);
    } else {
        image.spec.attribute("oiio:ColorSpace", "Linear");
    }

    const std::size_t stride = image.spec.pixel_bytes(true);
    image.packRow = [&layers, stride](std::size_t y, char* row) {
        std::size_t offset = 0;
        for (const ImageLayer& layer : layers) {
            offset += PackLayer(layer, y, stride, row + offset);
        }
    };
    return image;
}

/// Display-referred 8-bit pixels.
EncodedImage EncodeDisplay(const ImageLayer& layer, FileKind kind,
                           const ImageWriteOptions& options) {
    const AlphaMode alphaMode =
        kind == FileKind::Png ? AlphaMode::Unpremultiplied : AlphaMode::OverBlack;
    // Data that is no colour (depth, normals) is stored as it is.
    const DisplayTransform transform(IsColor(layer, options) ? options.colorCorrection
                                                             : ColorCorrection::Disabled,
                                     options.metadata.workingSpace);
    QuantisedImage quantised = QuantiseLayer(layer, transform, alphaMode);
    EncodedImage image;
    image.spec = OIIO::ImageSpec(static_cast<int>(layer.width), static_cast<int>(layer.height),
                                 static_cast<int>(quantised.numChannels), OIIO::TypeUInt8);
    image.spec.attribute("oiio:ColorSpace", transform.IsLinear() ? "Linear" : "sRGB");
    image.spec.attribute("oiio:UnassociatedAlpha", 1); // the encoder shall not divide again
    if (kind == FileKind::Jpeg) {
        image.spec.attribute("compression", "jpeg:95");
        image.spec.attribute("jpeg:subsampling", "4:4:4");
    }
    const std::size_t rowBytes = std::size_t{layer.width} * quantised.numChannels;
    image.packRow = [values = std::move(quantised.values), rowBytes](std::size_t y, char* row) {
        std::memcpy(row, &values[y * rowBytes], rowBytes);
    };
    return image;
}

/// Linear float pixels of one layer, which must outlive the result.
EncodedImage EncodeLinear(const ImageLayer& layer, FileKind kind) {
    const std::size_t sourceChannels = layer.channels.size();
    const std::size_t channels =
        kind == FileKind::Hdr ? 3 : sourceChannels; // .hdr is RGB whatever the layer
    EncodedImage image;
    image.spec = OIIO::ImageSpec(static_cast<int>(layer.width), static_cast<int>(layer.height),
                                 static_cast<int>(channels), OIIO::TypeFloat);
    image.spec.attribute("oiio:ColorSpace", "Linear");
    image.spec.attribute("compression", "zip");
    image.packRow = [&layer, channels, sourceChannels](std::size_t y, char* row) {
        const float* source = &layer.values[y * layer.width * sourceChannels];
        for (std::size_t x = 0; x < layer.width; ++x) {
            for (std::size_t c = 0; c < channels; ++c) {
                const std::size_t from = std::min(c, sourceChannels - 1); // one channel: gray
                std::memcpy(row, source + x * sourceChannels + from, sizeof(float));
                row += sizeof(float);
            }
        }
    };
    return image;
}

/// What the choice of a layer depends on.
struct LayerKind {
    std::string name; ///< of the AOV
    std::size_t numChannels;
    bool hasIds; ///< as integers, or as the bits of a Cryptomatte's floats
};

bool HasIds(const AovInfo* info) {
    return info != nullptr && (info->isInteger || info->filter == AovFilter::Matte);
}

/// Which layer a format with room for one layer stores. Throws (Usage) where it cannot hold that.
std::size_t MainLayer(const std::string& file, const std::vector<LayerKind>& layers) {
    const auto color = std::find_if(layers.begin(), layers.end(),
                                    [](const LayerKind& layer) { return layer.name == "color"; });
    const auto main = color != layers.end() ? color : layers.begin();
    if (main->hasIds) {
        throw Error("cannot write '" + file + "': ids ('" + main->name +
                        "') can only be stored in an .exr file",
                    ErrorKind::Usage);
    }
    if (main->numChannels == 2 && KindOf(file) != FileKind::Tiff) {
        throw Error("cannot write '" + file + "': two channels ('" + main->name +
                        "') can only be stored in an .exr or .tif file",
                    ErrorKind::Usage);
    }
    return static_cast<std::size_t>(main - layers.begin());
}

/// Feeds all rows to an open encoder, in bands that let it compress in parallel.
bool WriteRows(const EncodedImage& image, OIIO::ImageOutput* output) {
    constexpr int kBandRows = 256;
    const std::size_t rowBytes = image.spec.scanline_bytes(true);
    std::vector<char> band(rowBytes *
                           static_cast<std::size_t>(std::min(kBandRows, image.spec.height)));
    for (int y = 0; y < image.spec.height; y += kBandRows) {
        const int end = std::min(y + kBandRows, image.spec.height);
        for (int row = y; row < end; ++row) {
            image.packRow(static_cast<std::size_t>(row),
                          &band[static_cast<std::size_t>(row - y) * rowBytes]);
        }
        // Strides said: without them OpenImageIO 3.2 writes the first row again and again.
        const int top = image.spec.y; // of the data window
        if (!output->write_scanlines(top + y, top + end, 0, OIIO::TypeUnknown, band.data(),
                                     static_cast<OIIO::stride_t>(image.spec.pixel_bytes(true)),
                                     static_cast<OIIO::stride_t>(rowBytes))) {
            return false;
        }
    }
    return true;
}

/// As WriteRows, a row of tiles at a time.
bool WriteTiles(const EncodedImage& image, OIIO::ImageOutput* output) {
    const OIIO::ImageSpec& spec = image.spec;
    const std::size_t rowBytes = spec.scanline_bytes(true);
    std::vector<char> band(rowBytes *
                           static_cast<std::size_t>(std::min(spec.tile_height, spec.height)));
    for (int y = 0; y < spec.height; y += spec.tile_height) {
        const int end = std::min(y + spec.tile_height, spec.height);
        for (int row = y; row < end; ++row) {
            image.packRow(static_cast<std::size_t>(row),
                          &band[static_cast<std::size_t>(row - y) * rowBytes]);
        }
        if (!output->write_tiles(spec.x, spec.x + spec.width, spec.y + y, spec.y + end, 0, 1,
                                 OIIO::TypeUnknown, band.data(),
                                 static_cast<OIIO::stride_t>(spec.pixel_bytes(true)),
                                 static_cast<OIIO::stride_t>(rowBytes))) {
            return false;
        }
    }
    return true;
}

/// All samples, in bands, so that they are not in memory twice.
bool WriteDeepRows(const DeepImage& image, const OIIO::ImageSpec& spec, bool isHalf,
                   OIIO::ImageOutput* output) {
    constexpr int kBandRows = 64;
    constexpr int kChannels = 6;
    const float bound = isHalf ? kLargestHalf : std::numeric_limits<float>::max();
    std::size_t first = 0;
    for (int y = 0; y < spec.height; y += kBandRows) {
        const int end = std::min(y + kBandRows, spec.height);
        const auto begin = image.counts.begin() + std::ptrdiff_t{y} * spec.width;
        const std::vector<std::uint32_t> counts(begin,
                                                begin + std::ptrdiff_t{end - y} * spec.width);
        OIIO::DeepData data;
        data.init(static_cast<std::int64_t>(counts.size()), kChannels, spec.channelformats,
                  spec.channelnames);
        data.set_all_samples(counts);
        for (std::size_t pixel = 0; pixel < counts.size(); ++pixel) {
            for (std::uint32_t i = 0; i < counts[pixel]; ++i) {
                const DeepSample& sample = image.samples[first++];
                const auto set = [&](int channel, float value) {
                    data.set_deep_value(static_cast<std::int64_t>(pixel), channel,
                                        static_cast<int>(i), value);
                };
                for (int c = 0; c < 4; ++c) {
                    set(c, std::clamp(sample.color[static_cast<std::size_t>(c)], -bound, bound));
                }
                set(4, sample.z);
                set(5, sample.zBack);
            }
        }
        if (!output->write_deep_scanlines(spec.y + y, spec.y + end, 0, data)) {
            return false;
        }
    }
    return true;
}

/// Whether the last row of a deep file is there: not every version of OpenImageIO says when the
/// disk was full.
bool HasLastDeepRow(const std::string& file, const OIIO::ImageSpec& spec) {
    const std::unique_ptr<OIIO::ImageInput> input =
        OIIO::ImageInput::create(FormatName(FileKind::Exr));
    OIIO::ImageSpec found;
    OIIO::DeepData row;
    const int end = spec.y + spec.height;
    const bool isThere =
        input && input->open(file, found) &&
        input->read_native_deep_scanlines(0, 0, end - 1, end, 0, 0, spec.nchannels, row);
    OIIO::geterror();
    return isThere;
}

/// \param write what writes the pixels to the open encoder; false: it failed.
void EncodeToFile(const std::string& file, FileKind kind, const OIIO::ImageSpec& spec,
                  const std::function<bool(OIIO::ImageOutput*)>& write) {
    AtomicFile atomic(file);
    AtomicFileProxy proxy(&atomic, file);
    std::string reason;
    bool written = false;
    try {
        std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(FormatName(kind));
        if (!output || !output->supports("ioproxy")) {
            OIIO::geterror();
            throw Error("cannot write '" + file + "': OpenImageIO has no usable writer for it");
        }
        if (spec.deep) { // OpenImageIO 2.4 writes what is deep by name, whatever proxy it has
            written = output->open(atomic.TemporaryPath(), spec);
        } else {
            output->set_ioproxy(&proxy);
            written = output->open(file, spec);
        }
        written = written && write(output.get()) && output->close();
        reason = OneLine(output->geterror());
        output.reset();
        written = written && (!spec.deep || HasLastDeepRow(atomic.TemporaryPath(), spec));
    } catch (const Error&) {
        throw;
    } catch (const std::exception& failure) {
        reason = OneLine(failure.what());
    }
    // The disk's own reason first: encoders report it as some failure of theirs, or not at all.
    if (!written) {
        atomic.ThrowIfFailed();
        throw Error("cannot write '" + file +
                    "': " + (reason.empty() ? "encoding failed" : reason));
    }
    atomic.Commit();
}

} // namespace

void CheckImageFile(const std::string& file, const std::vector<std::string>& aovs) {
    if (KindOf(file) != FileKind::Exr && !aovs.empty()) {
        std::vector<LayerKind> layers;
        for (const std::string& name : aovs) {
            const std::shared_ptr<const AovInfo> info = Describe(name);
            layers.push_back({name, info ? info->channels.size() : 3, HasIds(info.get())});
        }
        MainLayer(file, layers);
    }
    const AtomicFile probe(file);
}

std::vector<std::string> WriteImage(const std::string& file, const std::vector<ImageLayer>& layers,
                                    const ImageWriteOptions& options) {
    const FileKind kind = KindOf(file);
    CheckLayers(file, layers);
    std::vector<std::string> left;
    EncodedImage image;
    if (kind == FileKind::Exr) {
        image = EncodeExr(layers, options);
    } else {
        std::vector<LayerKind> kinds;
        for (const ImageLayer& one : layers) {
            const std::string& aov = AovOf(one, options);
            kinds.push_back(
                {aov, one.channels.size(), one.isInteger || HasIds(Describe(aov).get())});
        }
        const ImageLayer& layer = layers[MainLayer(file, kinds)];
        for (const ImageLayer& other : layers) {
            if (&other != &layer) {
                left.push_back(other.name);
            }
        }
        image = kind == FileKind::Png || kind == FileKind::Jpeg
                    ? EncodeDisplay(layer, kind, options)
                    : EncodeLinear(layer, kind);
    }
    AddMetadata(&image.spec, options.metadata);
    if (kind == FileKind::Exr) {
        AddWindows(&image.spec, options.metadata);
    }
    const auto [tileWidth, tileHeight] = options.metadata.tileSize;
    const bool isTiled = kind == FileKind::Exr && tileWidth > 0 && tileHeight > 0;
    if (isTiled) {
        image.spec.tile_width = static_cast<int>(tileWidth);
        image.spec.tile_height = static_cast<int>(tileHeight);
    }
    EncodeToFile(file, kind, image.spec, [&](OIIO::ImageOutput* output) {
        return isTiled ? WriteTiles(image, output) : WriteRows(image, output);
    });
    return left;
}

void WriteDeepImage(const std::string& file, const DeepImage& image, bool isHalf,
                    const ImageMetadata& metadata) {
    if (KindOf(file) != FileKind::Exr) {
        throw Error("cannot write '" + file + "': only .exr files are deep", ErrorKind::Usage);
    }
    if (image.counts.empty()) {
        throw Error("cannot write '" + file + "': the image has no pixels");
    }
    OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 0,
                         OIIO::TypeFloat);
    spec.deep = true;
    spec.channelnames = {"R", "G", "B", "A", "Z", "ZBack"};
    spec.nchannels = static_cast<int>(spec.channelnames.size());
    spec.alpha_channel = 3;
    spec.z_channel = 4;
    const OIIO::TypeDesc colorType = isHalf ? OIIO::TypeHalf : OIIO::TypeFloat;
    spec.channelformats = {colorType, colorType,       colorType,
                           colorType, OIIO::TypeFloat, OIIO::TypeFloat};
    AddColorSpace(&spec, metadata.workingSpace);
    AddMetadata(&spec, metadata);
    AddWindows(&spec, metadata);
    const std::string compression = spec.get_string_attribute("compression");
    spec.attribute("compression",
                   compression == "none" || compression == "rle" ? compression : "zips");
    EncodeToFile(file, FileKind::Exr, spec, [&](OIIO::ImageOutput* output) {
        return WriteDeepRows(image, spec, isHalf, output);
    });
}

} // namespace hds
