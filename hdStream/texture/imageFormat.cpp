// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/imageFormat.h"

#include "hdStream/base/letters.h"

#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <vector>

namespace hds {

namespace {

using namespace std::string_view_literals;

/// Bytes that a format's files have at an offset, and OpenImageIO's name of its reader.
struct Signature {
    std::size_t offset;
    std::string_view bytes;
    const char* format;
};

constexpr Signature kSignatures[] = {
    {0, "\x89PNG"sv, "png"},
    {0, "\xff\xd8\xff"sv, "jpeg"},
    {0, "\x76\x2f\x31\x01"sv, "openexr"},
    {0, "II*\0"sv, "tiff"},
    {0, "MM\0*"sv, "tiff"},
    {0, "II+\0"sv, "tiff"},
    {0, "MM\0+"sv, "tiff"},
    {0, "#?RADIANCE"sv, "hdr"},
    {0, "#?RGBE"sv, "hdr"},
    {8, "WEBP"sv, "webp"},
    {0, "GIF8"sv, "gif"},
    {0, "8BPS"sv, "psd"},
    {0, "DDS "sv, "dds"},
    {0, "SDPX"sv, "dpx"},
    {0, "XPDS"sv, "dpx"},
    {0, "\0\0\0\x0cjP  "sv, "jpeg2000"},
    {4, "ftyp"sv, "heif"},
    {0, "BM"sv, "bmp"},
};

/// Extension in lower case without its dot. "a.usdz[b/c.PNG]" gives "png".
std::string ExtensionOf(const std::string& name) {
    const std::size_t dot = name.find_last_of('.');
    std::string extension = dot == std::string::npos ? "" : name.substr(dot + 1);
    if (!extension.empty() && extension.back() == ']') {
        extension.pop_back();
    }
    std::transform(extension.begin(), extension.end(), extension.begin(), LowerLetter);
    return extension;
}

} // namespace

std::string FormatOfContent(const std::string& head) {
    for (const Signature& signature : kSignatures) {
        if (head.size() >= signature.offset + signature.bytes.size() &&
            head.compare(signature.offset, signature.bytes.size(), signature.bytes) == 0) {
            return signature.format;
        }
    }
    return {};
}

std::string FormatOfName(const std::string& name) {
    const std::string extension = ExtensionOf(name);
    const std::string list =
        OIIO::get_string_attribute("extension_list"); // "png:png;tiff:tif,tiff"
    for (const std::string& entry : OIIO::Strutil::splits(list, ";")) {
        const std::vector<std::string> parts = OIIO::Strutil::splits(entry, ":");
        if (extension.empty() || parts.size() != 2 || parts[0] == "null" || parts[0] == "ffmpeg") {
            continue;
        }
        for (const std::string& known : OIIO::Strutil::splits(parts[1], ",")) {
            if (known == extension) {
                return parts[0];
            }
        }
    }
    return {};
}

bool HasPngEnd(std::istream& file, std::uint64_t begin, std::uint64_t size) {
    constexpr std::uint64_t kSignatureBytes = 8;
    constexpr std::uint64_t kChunkBytes = 12; ///< of a chunk without data
    for (std::uint64_t at = kSignatureBytes; at + kChunkBytes <= size;) {
        std::array<unsigned char, 8> head{};
        file.seekg(static_cast<std::streamoff>(begin + at));
        if (!file.read(reinterpret_cast<char*>(head.data()), head.size())) {
            return false;
        }
        const std::uint64_t length =
            (std::uint64_t{head[0]} << 24) | (head[1] << 16) | (head[2] << 8) | head[3];
        at += kChunkBytes + length;
        if (std::memcmp(&head[4], "IEND", 4) == 0) {
            return at <= size;
        }
    }
    return false;
}

} // namespace hds
