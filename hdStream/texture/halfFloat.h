// SPDX-License-Identifier: Apache-2.0
// Floats to IEEE 754 binary16; the other way is codec_floatOfHalf (kernels/shared/textureCodec.h).
#pragma once

#include <cstdint>
#include <cstring>

namespace hds {

constexpr float kLargestHalf = 65504.0f;
constexpr float kSmallestNormalHalf = 6.103515625e-5f; ///< 2^-14

/// The nearest half, ties to even. \param value finite, magnitude at most kLargestHalf
inline std::uint16_t HalfOfFloat(float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    const std::uint32_t sign = (bits >> 16) & 0x8000u;
    std::uint32_t magnitude = bits & 0x7fffffffu;
    if (magnitude < 0x38800000u) { // subnormal: a multiple of 2^-24, which adding 2^-1 rounds to
        float scaled = 0.0f;
        std::memcpy(&scaled, &magnitude, sizeof(scaled));
        scaled += 0.5f;
        std::memcpy(&magnitude, &scaled, sizeof(magnitude));
        return static_cast<std::uint16_t>(sign | (magnitude - 0x3f000000u));
    }
    magnitude -= 0x38000000u; // exponent bias 127 to 15
    return static_cast<std::uint16_t>(sign |
                                      ((magnitude + 0xfffu + ((magnitude >> 13) & 1u)) >> 13));
}

} // namespace hds
