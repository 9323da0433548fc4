// SPDX-License-Identifier: Apache-2.0
// The block scheme as the report words it (a representative value and differences), at the same
// rate as ours: per channel a base, a power-of-two shift and 4-bit differences, or 3-bit ones where
// no more fit: one or two channels, alpha that varies. Only for comparison: nothing renders with
// it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace hds::bench {

/// The texels of a block as they come back. \param channels 1, 2 (3-bit differences) or 4
inline void RoundTripReport(const std::uint8_t* texels, std::uint32_t channels,
                            std::uint8_t* decoded) {
    bool isOpaque = channels == 4;
    for (std::uint32_t i = 0; i < 16 && isOpaque; ++i) {
        isOpaque = texels[i * channels + 3] == texels[3];
    }
    const int last = isOpaque ? 15 : 7;
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

} // namespace hds::bench
