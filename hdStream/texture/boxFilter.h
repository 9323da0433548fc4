// SPDX-License-Identifier: Apache-2.0
// Reduces images by area averaging while their rows arrive: every target pixel is the exact mean of
// the source area it covers, so the image's mean is kept for any pair of sizes.
#pragma once

#include <cstdint>
#include <vector>

namespace hds {

/// Width and height of at most `maxPixels` pixels (0: no limit) with nearly the same aspect; never
/// larger than the source, at least 1x1.
struct ReducedSize {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
};
ReducedSize ReduceSize(std::uint32_t width, std::uint32_t height, std::uint64_t maxPixels);

/// A streaming box filter for RGB. Not thread-safe.
class BoxFilter {
public:
    /// \param sourceWidth, sourceHeight at least targetWidth, targetHeight, all at least 1
    BoxFilter(std::uint32_t sourceWidth, std::uint32_t sourceHeight, std::uint32_t targetWidth,
              std::uint32_t targetHeight);

    /// Takes the next source row, `sourceWidth` RGB triples, top row first.
    void AddRow(const float* rgb);

    /// The target image, RGB [height][width][3]; complete after the last row. Leaves the filter
    /// empty.
    std::vector<float> TakePixels() { return std::move(_pixels); }

private:
    void ReduceRow(const float* rgb);

    std::uint32_t _sourceWidth;
    std::uint32_t _sourceHeight;
    std::uint32_t _targetWidth;
    std::uint32_t _targetHeight;
    std::uint32_t _nextRow = 0;
    std::vector<double> _reducedRow; ///< the present source row at target width
    std::vector<double> _sum;        ///< of the target row that is being filled, by coverage
    std::vector<float> _pixels;
};

} // namespace hds
