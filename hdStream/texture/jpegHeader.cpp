// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/jpegHeader.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace hds {

namespace {

using namespace std::string_view_literals;

enum Marker : unsigned char {
    kFirstFrame = 0xc0,
    kProgressiveFrame = 0xc2,
    kHuffmanTables = 0xc4,
    kExtension = 0xc8,
    kArithmeticTables = 0xcc,
    kLastFrame = 0xcf,
    kStartOfImage = 0xd8,
    kEndOfImage = 0xd9,
    kStartOfScan = 0xda
};
constexpr unsigned char kPrefix = 0xff;
constexpr std::string_view kProfileName = "ICC_PROFILE\0"sv;
constexpr std::size_t kMaxBytes = std::size_t{64} << 20; ///< nobody says so much of an image
constexpr char kSideOfNothing = 8;

/// Markers that no length follows, and what none has defined.
bool IsAlone(unsigned char marker) {
    constexpr unsigned char kFirstRestart = 0xd0;
    return marker < kFirstFrame || (marker >= kFirstRestart && marker <= kEndOfImage);
}

bool IsFrame(unsigned char marker) {
    return marker >= kFirstFrame && marker <= kLastFrame && marker != kHuffmanTables &&
           marker != kExtension && marker != kArithmeticTables;
}

/// A segment: its marker, then the length of the rest in two bytes, which counts these.
class Segments {
public:
    Segments(std::istream& file, std::uint64_t size) : _file(file), _left(size) {}

    /// Appends the next one to `bytes`. \return where it begins, or nothing
    std::optional<std::size_t> Read(std::vector<char>* bytes) {
        std::array<unsigned char, 4> head{};
        if (!Take(head.data(), 2) || head[0] != kPrefix) {
            return std::nullopt;
        }
        while (head[1] == kPrefix) { // filled up
            if (!Take(&head[1], 1)) {
                return std::nullopt;
            }
        }
        if (IsAlone(head[1]) || !Take(&head[2], 2)) {
            return std::nullopt;
        }
        const std::size_t length = std::size_t{head[2]} << 8U | head[3];
        const std::size_t begin = bytes->size();
        if (length < 2 || begin + length > kMaxBytes) {
            return std::nullopt;
        }
        bytes->insert(bytes->end(), head.begin(), head.end());
        bytes->resize(begin + 2 + length);
        return Take(bytes->data() + begin + 4, length - 2) ? std::make_optional(begin)
                                                           : std::nullopt;
    }

    bool Take(void* bytes, std::size_t count) {
        if (count > _left) {
            return false;
        }
        _left -= count;
        return static_cast<bool>(
            _file.read(static_cast<char*>(bytes), static_cast<std::streamsize>(count)));
    }

private:
    std::istream& _file;
    std::uint64_t _left;
};

/// Two bytes of the frame's segment: first the precision, then height and width.
std::uint32_t TakeSide(std::vector<char>* bytes, std::size_t place) {
    const auto byte = [&](std::size_t i) {
        return std::uint32_t{static_cast<unsigned char>((*bytes)[place + i])};
    };
    const std::uint32_t side = byte(0) << 8U | byte(1);
    (*bytes)[place] = 0;
    (*bytes)[place + 1] = kSideOfNothing;
    return side;
}

} // namespace

std::optional<JpegHeader> ReadProgressiveHeader(std::istream& file, std::uint64_t begin,
                                                std::uint64_t size) {
    constexpr std::size_t kFrameBytes = 10; ///< up to the width, at least
    file.seekg(static_cast<std::streamoff>(begin));
    Segments segments(file, size);
    JpegHeader header;
    header.bytes.resize(2);
    if (!segments.Take(header.bytes.data(), 2) ||
        static_cast<unsigned char>(header.bytes[1]) != kStartOfImage) {
        return std::nullopt;
    }
    while (const std::optional<std::size_t> place = segments.Read(&header.bytes)) {
        const auto marker = static_cast<unsigned char>(header.bytes[*place + 1]);
        if (marker == kStartOfScan) {
            header.bytes.push_back(static_cast<char>(kPrefix));
            header.bytes.push_back(static_cast<char>(kEndOfImage));
            return header.width > 0 && header.height > 0 ? std::make_optional(std::move(header))
                                                         : std::nullopt;
        }
        if (IsFrame(marker)) {
            if (marker != kProgressiveFrame || header.bytes.size() < *place + kFrameBytes) {
                return std::nullopt;
            }
            header.height = TakeSide(&header.bytes, *place + 5);
            header.width = TakeSide(&header.bytes, *place + 7);
        }
    }
    return std::nullopt;
}

bool NamesProfile(std::istream& file, std::uint64_t begin, std::uint64_t size) {
    constexpr std::size_t kBytesAtOnce = std::size_t{1} << 16;
    std::vector<char> bytes;
    file.clear();
    file.seekg(static_cast<std::streamoff>(begin));
    for (std::uint64_t left = size; left > 0;) {
        // The end of what was read may be the name's beginning.
        const std::size_t kept = std::min(bytes.size(), kProfileName.size() - 1);
        bytes.erase(bytes.begin(), bytes.end() - static_cast<std::ptrdiff_t>(kept));
        const std::size_t count = std::min<std::uint64_t>(left, kBytesAtOnce);
        bytes.resize(kept + count);
        if (!file.read(bytes.data() + kept, static_cast<std::streamsize>(count))) {
            return true; // nobody knows
        }
        left -= count;
        if (std::string_view(bytes.data(), bytes.size()).find(kProfileName) !=
            std::string_view::npos) {
            return true;
        }
    }
    return false;
}

} // namespace hds
