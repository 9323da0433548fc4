// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/imageFile.h"

#include "hdStream/base/letters.h"
#include "hdStream/texture/imageFormat.h"
#include "hdStream/texture/jpegHeader.h"
#include "hdStream/texture/oneLine.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <random>

namespace hds {

namespace {

constexpr int kRowAlignment = 64;                            ///< multiple of EXR's blocks of rows
constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 33; ///< a header beyond this is a lie
constexpr int kMaxChannels = 1024;

/// Readers of OpenImageIO 2.4 that write beyond their memory where a file is damaged, of formats
/// that renderers do not meet (testenv/bench/fuzz.py image).
bool IsUnsafe(const std::string& format) {
    return format == "iff" || format == "ico";
}

/// Held while a reader opens its file: OpenImageIO's decoder of ICC profiles, which runs then, adds
/// to static tables without a lock before version 3 (2.4: icc.cpp, tag and colour space names).
std::mutex openMutex;

/// A file with those bytes in the system's folder for temporary files; empty on failure.
std::string WriteTemporary(const std::vector<char>& bytes, const std::string& extension) {
    static std::atomic<std::uint64_t> counter{0};
    std::error_code code;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(code);
    if (code) {
        return {};
    }
    std::random_device random;
    const std::string name = "hdstream-" + std::to_string(random()) + "-" +
                             std::to_string(random()) + "-" + std::to_string(counter++) +
                             (extension.empty() ? "" : "." + extension);
    std::string path = (folder / name).string();
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
        std::filesystem::remove(path, code);
        return {};
    }
    return path;
}

/// Reads at most so many bytes of a byte range, or of a whole file.
std::string ReadBytes(const ImageSource& source, std::uint64_t mostBytes,
                      std::vector<char>* bytes) {
    std::error_code code;
    const auto status = std::filesystem::status(source.file, code);
    if (!std::filesystem::exists(status)) {
        const bool isInPackage = !source.file.empty() && source.file.back() == ']';
        return isInPackage ? "is compressed or damaged in its package" : "no such file";
    }
    if (std::filesystem::is_directory(status)) {
        return "is a folder";
    }
    if (!std::filesystem::is_regular_file(status)) { // opening a pipe would wait for its writer
        return "is not a file";
    }
    std::ifstream file(source.file, std::ios::binary | std::ios::ate);
    if (!file) {
        return "cannot be opened for reading";
    }
    const std::streamoff end = file.tellg();
    const std::uint64_t fileSize = end < 0 ? 0 : static_cast<std::uint64_t>(end);
    if (source.offset > fileSize || source.size > fileSize - source.offset) {
        return "the byte range " + std::to_string(source.offset) + "+" +
               std::to_string(source.size) + " is beyond the end of the file (" +
               std::to_string(fileSize) + " bytes)";
    }
    const std::uint64_t count =
        std::min(source.size ? source.size : fileSize - source.offset, mostBytes);
    if (count == 0) {
        return "is empty";
    }
    bytes->resize(count);
    file.seekg(static_cast<std::streamoff>(source.offset));
    if (!file.read(bytes->data(), static_cast<std::streamsize>(count))) {
        return "cannot be read";
    }
    return {};
}

std::string CheckSpec(const OIIO::ImageSpec& spec) {
    if (spec.deep) {
        return "deep images are not read: flatten it first, with oiiotool --flatten, say";
    }
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) {
        return "the image has no pixels";
    }
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
    if (pixels > kMaxPixels || spec.nchannels > kMaxChannels) {
        return "the image claims " + std::to_string(spec.width) + "x" +
               std::to_string(spec.height) + " pixels of " + std::to_string(spec.nchannels) +
               " channels, which is beyond the limits";
    }
    return {};
}

} // namespace

ImageFile::~ImageFile() {
    _input.reset();
    if (!_temporaryFile.empty()) {
        std::error_code ignored;
        std::filesystem::remove(_temporaryFile, ignored);
    }
}

std::unique_ptr<ImageFile> ImageFile::Open(const ImageSource& source, std::string* error) {
    return OpenPart(source, false, error);
}

std::unique_ptr<ImageFile> ImageFile::OpenHeader(const ImageSource& source, std::string* error) {
    return OpenPart(source, true, error);
}

std::unique_ptr<ImageFile> ImageFile::OpenPart(const ImageSource& source, bool isHeaderOnly,
                                               std::string* error) {
    std::unique_ptr<ImageFile> image(new ImageFile);
    const bool isRange = source.offset != 0 || source.size != 0;
    image->_name = source.name.empty() ? source.file : source.name;
    if (isRange && source.name.empty()) {
        image->_name += "[" + std::to_string(source.offset) + "]";
    }
    if (source.file.empty()) {
        *error = image->Error("no such file");
        return nullptr;
    }
    constexpr std::uint64_t kHeadBytes = 64;
    *error = ReadBytes(source, kHeadBytes, &image->_bytes);
    if (!error->empty()) {
        *error = image->Error(*error);
        return nullptr;
    }
    const std::string content =
        FormatOfContent(std::string(image->_bytes.begin(), image->_bytes.end()));
    std::optional<JpegHeader> progressive;
    bool canHaveProfile = true;
    if (content == "png" || content == "jpeg") {
        std::ifstream file(source.file, std::ios::binary);
        std::error_code code;
        const std::uint64_t size =
            isRange && source.size ? source.size
                                   : std::filesystem::file_size(source.file, code) - source.offset;
        if (content == "png" && (code || !HasPngEnd(file, source.offset, size))) {
            *error = image->Error("is not a readable image (the file is cut off)");
            return nullptr;
        }
        if (content == "jpeg" && !code) {
            progressive = ReadProgressiveHeader(file, source.offset, size);
            canHaveProfile =
                !progressive || isHeaderOnly || NamesProfile(file, source.offset, size);
        }
    }
    const bool isHeaderRead = isHeaderOnly && progressive;
    if (isHeaderRead) {
        image->_bytes = std::move(progressive->bytes);
    } else if (isRange) {
        *error = ReadBytes(source, UINT64_MAX, &image->_bytes);
        if (!error->empty()) {
            *error = image->Error(*error);
            return nullptr;
        }
    }
    *error = image->OpenWith(content.empty() ? FormatOfName(image->_name) : content, source.file,
                             isRange || isHeaderRead, canHaveProfile);
    if (error->empty() && isHeaderRead) {
        image->_spec.width = static_cast<int>(progressive->width);
        image->_spec.height = static_cast<int>(progressive->height);
    }
    return error->empty() ? std::move(image) : nullptr;
}

std::string ImageFile::OpenWith(const std::string& format, std::string file, bool isInMemory,
                                bool canHaveProfile) {
    if (IsUnsafe(format)) {
        return Error("images of the format " + format + " are not read: save it as another one");
    }
    // A bare format name makes OpenImageIO create that reader and try no other.
    _input = format.empty() ? nullptr : OIIO::ImageInput::create(format);
    if (!_input) {
        OIIO::geterror();
        return Error("is not an image of a known format");
    }
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    if (isInMemory) {
        if (_input->supports("ioproxy")) {
            _proxy = std::make_unique<OIIO::Filesystem::IOMemReader>(_bytes.data(), _bytes.size());
            _input->set_ioproxy(_proxy.get());
            file = "memory." + format;
        } else {
            _temporaryFile = WriteTemporary(_bytes, format);
            file = _temporaryFile;
            if (file.empty()) {
                return Error("no temporary file can be written for it");
            }
        }
    }
    bool opened = false;
    std::string reason;
    try {
        const auto lock = canHaveProfile ? std::unique_lock<std::mutex>(openMutex)
                                         : std::unique_lock<std::mutex>();
        opened = _input->open(file, _spec, config);
    } catch (const std::exception& failure) {
        reason = failure.what();
    }
    if (!opened) {
        reason = OneLine(reason.empty() ? _input->geterror() : reason);
        return Error("is not a readable image" + (reason.empty() ? "" : " (" + reason + ")"));
    }
    const std::string wrong = CheckSpec(_spec);
    return wrong.empty() ? std::string() : Error(wrong);
}

std::string ImageFile::ReadBands(const OIIO::TypeDesc& type, int channelBegin, int channelEnd,
                                 const BandCallback& onBand, std::uint64_t bandBytes) {
    std::uint64_t pixelBytes = 0;
    if (type == OIIO::TypeUnknown) {
        pixelBytes = _spec.pixel_bytes(channelBegin, channelEnd, true);
    } else {
        pixelBytes = type.size() * static_cast<std::uint64_t>(channelEnd - channelBegin);
    }
    const std::uint64_t rowBytes = pixelBytes * Width();
    // Else OpenImageIO 2.4 allocates 64 MiB for each band, and the system clears what it uses.
    const bool isAsStored =
        type == OIIO::TypeUnknown || (type == _spec.format && _spec.channelformats.empty());
    const int alignment = _spec.tile_height > 0 ? _spec.tile_height : kRowAlignment;
    const int fitting = static_cast<int>(std::min<std::uint64_t>(bandBytes / rowBytes, 1u << 20));
    const int bandRows =
        std::min(_spec.height, std::max(alignment, fitting / alignment * alignment));
    try {
        std::vector<char> band(rowBytes * static_cast<std::uint64_t>(bandRows));
        for (int y = 0; y < _spec.height; y += bandRows) {
            const int rows = std::min(bandRows, _spec.height - y);
            const int begin = _spec.y + y;
            bool read = false;
            if (_spec.tile_width > 0) {
                read = _input->read_tiles(0, 0, _spec.x, _spec.x + _spec.width, begin, begin + rows,
                                          _spec.z, _spec.z + 1, channelBegin, channelEnd, type,
                                          band.data());
            } else if (isAsStored) {
                read = _input->read_native_scanlines(0, 0, begin, begin + rows, _spec.z,
                                                     channelBegin, channelEnd, band.data());
            } else {
                read = _input->read_scanlines(0, 0, begin, begin + rows, _spec.z, channelBegin,
                                              channelEnd, type, band.data());
            }
            const std::string reason = OneLine(_input->geterror());
            if (!read || !reason.empty()) {
                return Error("cannot be decoded" + (reason.empty() ? "" : " (" + reason + ")"));
            }
            onBand(static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(rows), band.data());
        }
    } catch (const std::bad_alloc&) {
        return Error("there is not enough memory to decode it");
    } catch (const std::exception& failure) {
        return Error("cannot be decoded (" + OneLine(failure.what()) + ")");
    }
    return {};
}

int ColorChannels::Begin() const {
    const int color = std::min({red, green, blue < 0 ? red : blue});
    return alpha < 0 ? color : std::min(color, alpha);
}

int ColorChannels::End() const {
    return std::max({red, green, blue, alpha}) + 1;
}

ColorChannels FindColorChannels(const OIIO::ImageSpec& spec) {
    const auto find = [&spec](char upper) {
        const char lower = LowerLetter(upper);
        for (int c = 0; c < spec.nchannels; ++c) {
            const std::string name = spec.channel_name(c);
            if (name.size() == 1 && (name[0] == upper || name[0] == lower)) {
                return c;
            }
        }
        return -1;
    };
    ColorChannels channels;
    channels.alpha = spec.alpha_channel >= 0 ? spec.alpha_channel : find('A');
    if (spec.nchannels == 2 && channels.alpha < 0) { // as UsdUVTexture has it, whatever their names
        channels.red = channels.green = channels.blue = 0;
        channels.alpha = 1;
        return channels;
    }
    const std::array<int, 3> rgb{find('R'), find('G'), find('B')};
    if (rgb[0] >= 0 && rgb[1] >= 0) {
        channels.red = rgb[0];
        channels.green = rgb[1];
        channels.blue = rgb[2];
        return channels;
    }
    // Luminance, unless it is the second of three coordinates. A Z beside it may be depth.
    if (find('Y') >= 0 && find('X') < 0) {
        channels.red = channels.green = channels.blue = find('Y');
        return channels;
    }
    std::vector<int> colors;
    for (int c = 0; c < spec.nchannels; ++c) {
        if (c != channels.alpha) {
            colors.push_back(c);
        }
    }
    if (colors.empty()) { // an alpha channel alone: gray, as UsdUVTexture's "r" of a mask
        colors.push_back(channels.alpha);
        channels.alpha = -1;
    }
    channels.red = colors[0];
    channels.green = colors.size() > 1 ? colors[1] : colors[0];
    channels.blue = colors.size() > 2 ? colors[2] : (colors.size() > 1 ? -1 : colors[0]);
    return channels;
}

} // namespace hds
