// SPDX-License-Identifier: Apache-2.0
// The block scheme as the report words it (a representative value and differences): per channel a
// base, a power-of-two shift and differences of so many bits; and plain quantisation, the least
// that a codec must beat. Only for comparison: nothing renders with them.
#pragma once

#include <algorithm>
#include <cstdint>

namespace hds::bench {

/// Bits of a difference at our rate, half of 8 bits a channel: 4 in an opaque block of four
/// channels, whose alpha needs none, else 3.
inline int ReportDeltaBits(const std::uint8_t* texels, std::uint32_t channels) {
    for (std::uint32_t i = 0; i < 16 && channels == 4; ++i) {
        if (texels[i * channels + 3] != texels[3]) {
            return 3;
        }
    }
    return channels == 4 ? 4 : 3;
}

/// The texels of a block as they come back.
inline void RoundTripReport(const std::uint8_t* texels, std::uint32_t channels, int deltaBits,
                            std::uint8_t* decoded) {
    const int last = (1 << deltaBits) - 1;
    for (std::uint32_t c = 0; c < channels; ++c) {
        int low = 255;
        int high = 0;
        for (std::uint32_t i = 0; i < 16; ++i) {
            low = std::min<int>(low, texels[i * channels + c]);
            high = std::max<int>(high, texels[i * channels + c]);
        }
        int shift = 0;
        while (((high - low + ((1 << shift) >> 1)) >> shift) > last) {
            ++shift;
        }
        for (std::uint32_t i = 0; i < 16; ++i) {
            const int delta = (texels[i * channels + c] - low + ((1 << shift) >> 1)) >> shift;
            decoded[i * channels + c] =
                static_cast<std::uint8_t>(std::min(255, low + (delta << shift)));
        }
    }
}

/// As RoundTripReport, every channel rounded to `bits` bits.
inline void RoundTripPlain(const std::uint8_t* texels, std::uint32_t channels, int bits,
                           std::uint8_t* decoded) {
    const int last = (1 << bits) - 1;
    for (std::uint32_t i = 0; i < 16 * channels; ++i) {
        const int code = (texels[i] * last + 127) / 255;
        decoded[i] = static_cast<std::uint8_t>((code * 255 + last / 2) / last);
    }
}

} // namespace hds::bench
