// SPDX-License-Identifier: Apache-2.0
// Four channels of 8 bits, and the choice of the encoder. See blockEncoder.h.
#include "hdStream/texture/blockEncoder.h"

#include "kernels/shared/textureCodec.h"

#include <algorithm>
#include <array>
#include <limits>

namespace hds {

namespace {

using shared::codec_interpolate;
using Plane = std::array<int, 16>; ///< a channel of a block

constexpr int kMaxWidth = 9;
/// Alpha decides what is seen at all; an error of it counts as one of two colour channels.
constexpr float kAlphaWeight = 2.0f;
/// Blocks that are expected to lose more than this (weighted mean square error, all channels) try
/// every allocation.
constexpr float kMeasuredAbove = 1.5f;

/// Mean square error of a channel of some range quantised with some width: [range][width]. Without
/// an index it is taken as the worst there is, so that each further bit gains less than the last.
using ErrorTable = std::array<std::array<float, kMaxWidth + 1>, 512>;

ErrorTable MakeErrorTable() {
    ErrorTable table{};
    for (std::size_t range = 1; range < table.size(); ++range) {
        const float square = static_cast<float>(range * range);
        table[range][0] = square / 4.0f;
        for (std::size_t width = 1; width <= kMaxWidth; ++width) {
            const float last = static_cast<float>((1u << width) - 1u);
            table[range][width] =
                range < (std::size_t{1} << width) ? 0.0f : square / (12.0f * last * last);
        }
    }
    return table;
}

const ErrorTable& Errors() {
    static const ErrorTable table = MakeErrorTable();
    return table;
}

/// A way to store a block: intervals and index widths of up to four channels.
struct Fit {
    std::array<int, 4> low{};
    std::array<int, 4> range{};
    std::array<int, 4> width{};
    bool isYCoCg = false;
    bool hasAlpha = false;
    float error = 0.0f; ///< expected sum over the channels of weighted square errors
};

void SetInterval(Fit* fit, std::size_t channel, const Plane& plane) {
    int low = plane[0];
    int high = plane[0];
    for (const int value : plane) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    fit->low[channel] = low;
    fit->range[channel] = high - low;
}

/// Most bits of each channel's index: what the fields of the head hold, and what a range can use.
std::array<int, 4> WidthCaps(const Fit& fit) {
    return {8, 7, fit.hasAlpha ? 7 : kMaxWidth, 8};
}

/// Gives bit after bit to the channel that is expected to gain most.
void AllocateExpected(Fit* fit, const std::array<float, 4>& weights) {
    const ErrorTable& errors = Errors();
    const std::size_t numChannels = fit->hasAlpha ? 4 : 3;
    const int numBits = fit->hasAlpha ? HDS_CODEC_ALPHA_BITS : HDS_CODEC_COLOR_BITS;
    const std::array<int, 4> caps = WidthCaps(*fit);
    std::array<float, 4> error{};
    for (std::size_t c = 0; c < numChannels; ++c) {
        error[c] = weights[c] * errors[static_cast<std::size_t>(fit->range[c])][0];
    }
    for (int bit = 0; bit < numBits; ++bit) {
        std::size_t best = numChannels;
        float bestGain = 0.0f;
        float bestError = 0.0f;
        for (std::size_t c = 0; c < numChannels; ++c) {
            if (fit->width[c] == caps[c]) {
                continue;
            }
            const float next = weights[c] * errors[static_cast<std::size_t>(fit->range[c])]
                                                  [static_cast<std::size_t>(fit->width[c]) + 1];
            const float gain = error[c] - next;
            if (best == numChannels || gain > bestGain) {
                best = c;
                bestGain = gain;
                bestError = next;
            }
        }
        ++fit->width[best];
        error[best] = bestError;
    }
    fit->error = error[0] + error[1] + error[2] + error[3];
}

/// Mean square errors of a channel of a block for each width.
std::array<float, kMaxWidth + 1> MeasureErrors(const Plane& plane, int low, int range) {
    std::array<float, kMaxWidth + 1> errors{};
    for (int width = 0; width <= kMaxWidth; ++width) {
        const std::uint32_t last = (1u << width) - 1u;
        const float scale = range > 0 ? static_cast<float>(last) / static_cast<float>(range) : 0.0f;
        const int base = width == 0 ? low + range / 2 : low;
        int sum = 0;
        for (std::size_t i = 0; i < 16; ++i) {
            const float position = static_cast<float>(plane[i] - low) * scale + 0.5f;
            const auto q = static_cast<std::uint32_t>(static_cast<int>(position));
            const int value =
                base + static_cast<int>(codec_interpolate(static_cast<std::uint32_t>(range), q,
                                                          static_cast<std::uint32_t>(width)));
            sum += (value - plane[i]) * (value - plane[i]);
        }
        errors[static_cast<std::size_t>(width)] = static_cast<float>(sum) / 16.0f;
        if (sum == 0) {
            break; // further bits gain nothing
        }
    }
    return errors;
}

/// The best of all allocations by the errors they really make.
void AllocateMeasured(Fit* fit, const std::array<const Plane*, 4>& planes,
                      const std::array<float, 4>& weights) {
    std::array<std::array<float, kMaxWidth + 1>, 4> errors{};
    for (std::size_t c = 0; c < (fit->hasAlpha ? 4u : 3u); ++c) {
        errors[c] = MeasureErrors(*planes[c], fit->low[c], fit->range[c]);
        for (float& error : errors[c]) {
            error *= weights[c];
        }
    }
    const std::array<int, 4> caps = WidthCaps(*fit);
    const int numBits = fit->hasAlpha ? HDS_CODEC_ALPHA_BITS : HDS_CODEC_COLOR_BITS;
    fit->error = std::numeric_limits<float>::max();
    for (int w0 = 0; w0 <= caps[0]; ++w0) {
        for (int w1 = 0; w1 <= caps[1] && w0 + w1 <= numBits; ++w1) {
            const int rest = numBits - w0 - w1;
            const float colors =
                errors[0][static_cast<std::size_t>(w0)] + errors[1][static_cast<std::size_t>(w1)];
            for (int w2 = fit->hasAlpha ? 0 : rest; w2 <= std::min(caps[2], rest); ++w2) {
                const int w3 = rest - w2;
                if (w3 > caps[3]) {
                    continue;
                }
                const float error = colors + errors[2][static_cast<std::size_t>(w2)] +
                                    errors[3][static_cast<std::size_t>(w3)];
                if (error < fit->error) {
                    fit->error = error;
                    fit->width = {w0, w1, w2, w3};
                }
            }
        }
    }
}

/// A channel without bits is its interval's middle everywhere.
void CentreEmptyChannels(Fit* fit) {
    for (std::size_t c = 0; c < 4; ++c) {
        if (fit->width[c] == 0) {
            fit->low[c] += fit->range[c] / 2;
            fit->range[c] = 0;
        }
    }
}

/// Index of the nearest value. A range below 2^width is kept exactly: values are then no further
/// apart than the indices' values, and those are rounded to integers.
void Quantise(const Plane& plane, int low, int range, int width, std::array<std::uint32_t, 16>* q,
              int shift) {
    const float last = static_cast<float>((1u << width) - 1u);
    const float scale = range > 0 ? last / static_cast<float>(range) : 0.0f;
    for (std::size_t i = 0; i < 16; ++i) {
        const float position = static_cast<float>(plane[i] - low) * scale + 0.5f;
        (*q)[i] |= static_cast<std::uint32_t>(static_cast<int>(position)) << shift;
    }
}

void Write(const Fit& fit, const std::array<std::uint32_t, 16>& q, std::uint32_t* block) {
    const auto field = [](int value, int shift) {
        return static_cast<std::uint64_t>(value) << shift;
    };
    const int offset = fit.isYCoCg ? 255 : 0;
    const int ends = fit.hasAlpha ? 12 : 9;
    std::uint64_t head = (fit.isYCoCg ? HDS_CODEC_COLOR_YCOCG : 0u) |
                         (fit.hasAlpha ? HDS_CODEC_ALPHA : 0u) | field(fit.width[0], 2) |
                         field(fit.width[1], 6) | (fit.hasAlpha ? field(fit.width[2], 9) : 0u);
    head |= field(fit.low[0], ends) | field(fit.range[0], ends + 8) |
            field(fit.low[1] + offset, ends + 16) | field(fit.range[1], ends + 25) |
            field(fit.low[2] + offset, ends + 34) | field(fit.range[2], ends + 43);
    block[0] = static_cast<std::uint32_t>(head);
    block[1] = static_cast<std::uint32_t>(head >> 32);
    std::fill_n(block + 2, 6, 0u);
    for (std::size_t i = 0; i < 16; ++i) {
        block[2 + i / 4] |= (q[i] & 255u) << (8 * (i % 4));
        block[6 + i / 8] |= (q[i] >> 8) << ((fit.hasAlpha ? 3 : 4) * (i % 8));
    }
    if (fit.hasAlpha) {
        block[6] |= static_cast<std::uint32_t>(fit.low[3]) << 24;
        block[7] |= static_cast<std::uint32_t>(fit.range[3]) << 24;
    }
}

} // namespace

void EncodeColor8(const std::uint8_t* rgba, std::uint32_t* block) {
    std::array<Plane, 4> rgb;
    std::array<Plane, 3> yCoCg;
    for (std::size_t i = 0; i < 16; ++i) {
        const int r = rgba[4 * i];
        const int g = rgba[4 * i + 1];
        const int b = rgba[4 * i + 2];
        const int co = r - b;
        const int t = b + (co >> 1);
        const int cg = g - t;
        rgb[0][i] = r;
        rgb[1][i] = g;
        rgb[2][i] = b;
        rgb[3][i] = rgba[4 * i + 3];
        yCoCg[0][i] = t + (cg >> 1);
        yCoCg[1][i] = co;
        yCoCg[2][i] = cg;
    }
    Fit plain;
    SetInterval(&plain, 3, rgb[3]);
    plain.hasAlpha = plain.low[3] != 255;
    Fit luma = plain;
    luma.isYCoCg = true;
    for (std::size_t c = 0; c < 3; ++c) {
        SetInterval(&plain, c, rgb[c]);
        SetInterval(&luma, c, yCoCg[c]);
    }
    // An error of Y is one of R, G and B; of Cg half of it, of Co a half of two (YCoCg to RGB).
    const std::array<float, 4> plainWeights = {1.0f, 1.0f, 1.0f, kAlphaWeight};
    const std::array<float, 4> lumaWeights = {3.0f, 0.5f, 0.75f, kAlphaWeight};
    AllocateExpected(&plain, plainWeights);
    AllocateExpected(&luma, lumaWeights);
    if (std::min(plain.error, luma.error) > kMeasuredAbove) {
        AllocateMeasured(&plain, {&rgb[0], &rgb[1], &rgb[2], &rgb[3]}, plainWeights);
        AllocateMeasured(&luma, {&yCoCg[0], &yCoCg[1], &yCoCg[2], &rgb[3]}, lumaWeights);
    }
    Fit& fit = luma.error < plain.error ? luma : plain;
    CentreEmptyChannels(&fit);
    std::array<std::uint32_t, 16> q{};
    int shift = 0;
    for (std::size_t c = 0; c < (fit.hasAlpha ? 4u : 3u); ++c) {
        const Plane& plane = fit.isYCoCg && c < 3 ? yCoCg[c] : rgb[c];
        Quantise(plane, fit.low[c], fit.range[c], fit.width[c], &q, shift);
        shift += fit.width[c];
    }
    Write(fit, q, block);
}

void EncodeBlock(std::uint32_t format, const void* texels, std::uint32_t* block) {
    if ((format & HDS_TEXEL_TYPE_MASK) != HDS_TEXEL_U8) {
        EncodeWide(format, texels, block);
        return;
    }
    const auto* codes = static_cast<const std::uint8_t*>(texels);
    const std::uint32_t channelsLog2 = format & HDS_TEXEL_CHANNELS_LOG2_MASK;
    if (channelsLog2 == 2) {
        EncodeColor8(codes, block);
        return;
    }
    EncodeScalar8(codes, 1u << channelsLog2, block);
    if (channelsLog2 == 1) {
        EncodeScalar8(codes + 1, 2, block + 2);
    }
}

} // namespace hds
