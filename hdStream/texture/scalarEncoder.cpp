// SPDX-License-Identifier: Apache-2.0
// One channel of 8 bits: an interval, or a ramp with an interval about it. See blockEncoder.h.
#include "hdStream/texture/blockEncoder.h"
#include "kernels/shared/textureCodec.h"

#include <algorithm>
#include <array>

namespace hds {

namespace {

constexpr int kLastIndex = 7;

/// A block in one of the two modes, as far as it differs from the other.
struct Candidate {
    std::uint32_t head = 0;
    std::array<std::uint32_t, 16> q{};
    int error = 0; ///< sum of square errors
};

/// The least code whose range holds `range`.
std::uint32_t CodeOfRange(std::uint32_t range) {
    std::uint32_t code = std::min<std::uint32_t>(range, HDS_CODEC_EXACT_RANGE);
    if (range > HDS_CODEC_EXACT_RANGE) {
        code += (range - HDS_CODEC_EXACT_RANGE) *
                (HDS_CODEC_MAX_RANGE_CODE - HDS_CODEC_EXACT_RANGE) / (255 - HDS_CODEC_EXACT_RANGE);
    }
    return shared::codec_rangeOfCode(code) < range ? code + 1 : code;
}

/// The nearest integer, without the call that std::lround is. \param value above -4096
int Rounded(float value) {
    return static_cast<int>(value + 4096.5f) - 4096;
}

Candidate FitInterval(const std::array<int, 16>& values, int low, int range) {
    Candidate candidate;
    const std::uint32_t code = CodeOfRange(static_cast<std::uint32_t>(range));
    const int coded = static_cast<int>(shared::codec_rangeOfCode(code));
    candidate.head = (static_cast<std::uint32_t>(low) << 1) | (code << 9);
    const float scale = coded > 0 ? kLastIndex / static_cast<float>(coded) : 0.0f;
    for (std::size_t i = 0; i < 16; ++i) {
        const float position = static_cast<float>(values[i] - low) * scale + 0.5f;
        const std::uint32_t q = static_cast<std::uint32_t>(static_cast<int>(position));
        const int value = std::min(255, low + static_cast<int>(shared::codec_interpolate(
                                                  static_cast<std::uint32_t>(coded), q, 3)));
        candidate.q[i] = q;
        candidate.error += (value - values[i]) * (value - values[i]);
    }
    return candidate;
}

/// The plane that fits best (least squares) with slopes in whole steps, the window centred on what
/// is left. \param slopeX, slopeY codes a texel
Candidate FitRamp(const std::array<int, 16>& values, float slopeX, float slopeY,
                  std::uint32_t stepCode) {
    const float step = static_cast<float>(shared::codec_rampStep[stepCode]);
    const float inverse = 1.0f / step;
    const int qx = std::clamp(Rounded(slopeX * inverse), -4, 3);
    const int qy = std::clamp(Rounded(slopeY * inverse), -4, 3);
    std::array<float, 16> rest;
    for (std::size_t i = 0; i < 16; ++i) {
        const int x = 2 * static_cast<int>(i % 4) - 3;
        const int y = 2 * static_cast<int>(i / 4) - 3;
        rest[i] = static_cast<float>(values[i]) - 0.5f * step * static_cast<float>(qx * x + qy * y);
    }
    float low = rest[0];
    float high = rest[0];
    for (const float value : rest) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    const int base = std::clamp(Rounded((low + high) * 0.125f), 0, 63);
    Candidate candidate;
    candidate.head = 1u | (static_cast<std::uint32_t>(base) << 1) |
                     (static_cast<std::uint32_t>(qx + 4) << 7) |
                     (static_cast<std::uint32_t>(qy + 4) << 10) | (stepCode << 13);
    for (std::uint32_t i = 0; i < 16; ++i) {
        // The middle of the window is between indices 3 and 4.
        const float position = (rest[i] - 4.0f * static_cast<float>(base)) * inverse + 4.0f;
        const int q = static_cast<int>(std::min(std::max(position, 0.0f), kLastIndex + 0.5f));
        const int value = static_cast<int>(shared::codec_ramp(static_cast<std::uint32_t>(base), qx,
                                                              qy, shared::codec_rampStep[stepCode],
                                                              static_cast<std::uint32_t>(q), i));
        candidate.q[i] = static_cast<std::uint32_t>(q);
        candidate.error += (value - values[i]) * (value - values[i]);
    }
    return candidate;
}

/// Tries the steps about the one whose window just holds what the best plane leaves.
void TryRamps(const std::array<int, 16>& values, Candidate* best) {
    float slopeX = 0.0f;
    float slopeY = 0.0f;
    for (std::size_t i = 0; i < 16; ++i) {
        slopeX += static_cast<float>((2 * static_cast<int>(i % 4) - 3) * values[i]) / 40.0f;
        slopeY += static_cast<float>((2 * static_cast<int>(i / 4) - 3) * values[i]) / 40.0f;
    }
    float low = 1e9f;
    float high = -1e9f;
    for (std::size_t i = 0; i < 16; ++i) {
        const float rest = static_cast<float>(values[i]) -
                           slopeX * (static_cast<float>(i % 4) - 1.5f) -
                           slopeY * (static_cast<float>(i / 4) - 1.5f);
        low = std::min(low, rest);
        high = std::max(high, rest);
    }
    std::uint32_t fitting = 0;
    while (fitting < 7 &&
           static_cast<float>(kLastIndex * shared::codec_rampStep[fitting]) < high - low) {
        ++fitting;
    }
    const std::uint32_t first = fitting > 0 ? fitting - 1 : 0;
    for (std::uint32_t code = first; code <= std::min(7u, fitting + 1); ++code) {
        const Candidate ramp = FitRamp(values, slopeX, slopeY, code);
        if (ramp.error < best->error) {
            *best = ramp;
        }
    }
}

} // namespace

void EncodeScalar8(const std::uint8_t* texels, std::uint32_t stride, std::uint32_t* block) {
    std::array<int, 16> values;
    for (std::size_t i = 0; i < 16; ++i) {
        values[i] = texels[i * stride];
    }
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    Candidate best = FitInterval(values, *low, *high - *low);
    if (best.error > 0) {
        TryRamps(values, &best);
    }
    std::uint64_t bits = best.head;
    for (std::size_t i = 0; i < 16; ++i) {
        bits |= std::uint64_t{best.q[i]} << (16 + 3 * i);
    }
    block[0] = static_cast<std::uint32_t>(bits);
    block[1] = static_cast<std::uint32_t>(bits >> 32);
}

} // namespace hds
