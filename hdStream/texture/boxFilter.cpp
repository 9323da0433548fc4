// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/boxFilter.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <cmath>

namespace hds {

ReducedSize ReduceSize(std::uint32_t width, std::uint32_t height, std::uint64_t maxPixels) {
    const std::uint64_t pixels = std::uint64_t{width} * height;
    if (maxPixels == 0 || pixels <= maxPixels) {
        return {width, height};
    }
    const double scale = std::sqrt(static_cast<double>(maxPixels) / static_cast<double>(pixels));
    ReducedSize size;
    size.width = std::max(1u, static_cast<std::uint32_t>(width * scale));
    size.height = std::max(1u, static_cast<std::uint32_t>(height * scale));
    // A side that was lifted to 1 takes pixels from the other.
    size.width = static_cast<std::uint32_t>(std::min<std::uint64_t>(size.width, maxPixels));
    size.height =
        static_cast<std::uint32_t>(std::min<std::uint64_t>(size.height, maxPixels / size.width));
    return size;
}

BoxFilter::BoxFilter(std::uint32_t sourceWidth, std::uint32_t sourceHeight,
                     std::uint32_t targetWidth, std::uint32_t targetHeight)
    : _sourceWidth(sourceWidth), _sourceHeight(sourceHeight), _targetWidth(targetWidth),
      _targetHeight(targetHeight), _reducedRow(std::size_t{3} * targetWidth),
      _sum(std::size_t{3} * targetWidth, 0.0) {
    HDS_VERIFY(targetWidth >= 1 && targetHeight >= 1 && targetWidth <= sourceWidth &&
                   targetHeight <= sourceHeight,
               "a box filter only reduces");
    _pixels.reserve(std::size_t{3} * targetWidth * targetHeight);
}

/// One axis is cut into sourceSize * targetSize units: source pixel j covers
/// [j * targetSize, (j + 1) * targetSize), target pixel i [i * sourceSize, (i + 1) * sourceSize).
/// Overlaps are whole numbers of units, so weights of a target pixel add up to exactly sourceSize.
void BoxFilter::ReduceRow(const float* rgb) {
    if (_sourceWidth == _targetWidth) {
        std::copy_n(rgb, _reducedRow.size(), _reducedRow.begin());
        return;
    }
    std::uint64_t source = 0;
    for (std::uint64_t target = 0; target < _targetWidth; ++target) {
        const std::uint64_t begin = target * _sourceWidth;
        const std::uint64_t end = begin + _sourceWidth;
        double sum[3] = {0, 0, 0};
        for (source = begin / _targetWidth; source * _targetWidth < end; ++source) {
            const std::uint64_t from = std::max(begin, source * _targetWidth);
            const std::uint64_t to = std::min(end, (source + 1) * _targetWidth);
            const double weight = static_cast<double>(to - from);
            for (int c = 0; c < 3; ++c) {
                sum[c] += weight * rgb[3 * source + c];
            }
        }
        for (int c = 0; c < 3; ++c) {
            _reducedRow[3 * target + c] = sum[c] / _sourceWidth;
        }
    }
}

void BoxFilter::AddRow(const float* rgb) {
    HDS_VERIFY(_nextRow < _sourceHeight, "more rows than the source has");
    ReduceRow(rgb);
    const std::uint64_t begin = std::uint64_t{_nextRow} * _targetHeight;
    const std::uint64_t end = begin + _targetHeight;
    // A source row is no taller than a target row, so it touches one or two of them.
    std::uint64_t from = begin;
    while (from < end) {
        const std::uint64_t targetEnd = (from / _sourceHeight + 1) * _sourceHeight;
        const std::uint64_t to = std::min(end, targetEnd);
        const double weight = static_cast<double>(to - from);
        for (std::size_t i = 0; i < _sum.size(); ++i) {
            _sum[i] += weight * _reducedRow[i];
        }
        if (to == targetEnd) {
            for (double& value : _sum) {
                _pixels.push_back(static_cast<float>(value / _sourceHeight));
                value = 0.0;
            }
        }
        from = to;
    }
    ++_nextRow;
}

} // namespace hds
