// SPDX-License-Identifier: Apache-2.0
// An odd size 2k + 1 becomes k: target i covers [i (2k + 1) / k, (i + 1) (2k + 1) / k), which is
// the part (k - i) / k of source 2i, all of 2i + 1, and the part (i + 1) / k of 2i + 2.
#include "hdStream/texture/halvingFilter.h"

#include <algorithm>
#include <array>

namespace hds {

namespace {

/// Of an even width.
template <std::size_t channels>
void ReducePairs(const float* row, std::size_t targetWidth, float* out) {
    for (std::size_t x = 0; x < targetWidth; ++x, row += 2 * channels, out += channels) {
        for (std::size_t c = 0; c < channels; ++c) {
            out[c] = 0.5f * (row[c] + row[channels + c]);
        }
    }
}

} // namespace

HalvingFilter::HalvingFilter(std::uint32_t width, std::uint32_t height, std::uint32_t numChannels)
    : _width(width), _height(height), _channels(numChannels), _targetWidth(std::max(1u, width / 2)),
      _targetHeight(std::max(1u, height / 2)), _reduced(std::size_t{numChannels} * _targetWidth),
      _sum(_reduced.size()) {}

void HalvingFilter::ReduceRow(const float* row) {
    const std::size_t channels = _channels;
    if (_width == 1) {
        std::copy_n(row, channels, _reduced.begin());
        return;
    }
    float* out = _reduced.data();
    if (_width % 2 == 0) {
        constexpr std::array kReduce = {ReducePairs<1>, ReducePairs<2>, ReducePairs<3>,
                                        ReducePairs<4>};
        kReduce[channels - 1](row, _targetWidth, out);
        return;
    }
    const float scale = 1.0f / static_cast<float>(_width);
    for (std::uint32_t x = 0; x < _targetWidth; ++x, row += 2 * channels, out += channels) {
        const float first = static_cast<float>(_targetWidth - x) * scale;
        const float middle = static_cast<float>(_targetWidth) * scale;
        const float last = static_cast<float>(x + 1) * scale;
        for (std::size_t c = 0; c < channels; ++c) {
            out[c] = first * row[c] + middle * row[channels + c] + last * row[2 * channels + c];
        }
    }
}

void HalvingFilter::Accumulate(float weight, bool isFirst) {
    if (isFirst) {
        for (std::size_t i = 0; i < _sum.size(); ++i) {
            _sum[i] = weight * _reduced[i];
        }
        return;
    }
    for (std::size_t i = 0; i < _sum.size(); ++i) {
        _sum[i] += weight * _reduced[i];
    }
}

void HalvingFilter::Begin(std::uint32_t targetRow) {
    _firstRow = 2 * targetRow;
    _nextRow = _firstRow;
    _isCarried = false;
}

const float* HalvingFilter::AddRow(const float* row) {
    if (_isCarried) { // the last row ended a target row; its other part begins the next one
        const std::uint32_t target = (_nextRow - 1) / 2;
        Accumulate(static_cast<float>(_targetHeight - target) / static_cast<float>(_height), true);
        _isCarried = false;
    }
    const std::uint32_t y = _nextRow++;
    ReduceRow(row);
    if (_height == 1) {
        return _reduced.data();
    }
    if (_height % 2 == 0) {
        Accumulate(0.5f, y % 2 == 0);
        return y % 2 == 1 ? _sum.data() : nullptr;
    }
    const float scale = 1.0f / static_cast<float>(_height);
    if (y == 0) {
        Accumulate(static_cast<float>(_targetHeight) * scale, true);
        return nullptr;
    }
    if (y % 2 == 1) {
        Accumulate(static_cast<float>(_targetHeight) * scale, false);
        return nullptr;
    }
    _isCarried = y + 1 < _height;
    if (y == _firstRow) { // the target row before is not wanted
        return nullptr;
    }
    Accumulate(static_cast<float>(y / 2) * scale, false); // the end of target y / 2 - 1
    return _sum.data();
}

} // namespace hds
