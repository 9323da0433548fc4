// SPDX-License-Identifier: Apache-2.0
// One step of a mip chain while rows arrive: half the width and height, rounded down but at least
// 1. Every target texel is the mean of the area it covers, with exact weights where a size is odd,
// so the image's mean is kept. Explained in docs/texturing.md, section "Mips".
#pragma once

#include <cstdint>
#include <vector>

namespace hds {

/// Halves rows of interleaved floats. Memory: two rows of the target. Not thread-safe.
class HalvingFilter {
public:
    /// \param numChannels 1 to 4
    HalvingFilter(std::uint32_t width, std::uint32_t height, std::uint32_t numChannels);

    std::uint32_t TargetWidth() const { return _targetWidth; }

    /// Starts anew at a row of the target: the next row is the first of the source that it covers.
    void Begin(std::uint32_t targetRow);

    /// Takes the next row. \return the target row that it completes, valid until the next call, or
    /// null.
    const float* AddRow(const float* row);

private:
    void ReduceRow(const float* row);
    void Accumulate(float weight, bool isFirst);

    std::uint32_t _width;
    std::uint32_t _height;
    std::uint32_t _channels;
    std::uint32_t _targetWidth;
    std::uint32_t _targetHeight;
    std::uint32_t _firstRow = 0; ///< of the source
    std::uint32_t _nextRow = 0;
    bool _isCarried = false;     ///< the present row has its part in the next target row too
    std::vector<float> _reduced; ///< the present row at target width
    std::vector<float> _sum;     ///< of the target row that is being filled
};

} // namespace hds
