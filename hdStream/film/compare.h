// SPDX-License-Identifier: Apache-2.0
// The difference of two image files, channel by channel: max, RMSE, relMSE, PSNR.
// Explained in docs/film.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Difference of one layer; means run over its pixels and channels. a is the first file, b the
/// second, the reference. Equal infinities and a NaN in both are no difference; where only one
/// value is finite, or both are unlike, the measures are infinite.
struct LayerDifference {
    std::string name;    ///< "color" for channels without a layer's name
    double maxAbs = 0.0; ///< max |a - b|
    double rmse = 0.0;   ///< sqrt(mean (a - b)^2)
    double relMse = 0.0; ///< mean (a - b)^2 / (b^2 + 0.01)
    double psnr = 0.0;   ///< -20 log10(rmse): dB for a peak of 1; infinite without a difference
    std::uint64_t numPixels = 0;
    std::uint64_t numDifferingPixels = 0; ///< pixels with any channel unlike
    std::uint64_t numNonFinite = 0;       ///< values that are NaN or infinite in either file
};

/// Result of CompareImages.
struct ImageComparison {
    std::string error; ///< one line that names the file; empty when the images are comparable
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<LayerDifference> layers; ///< "color" first when there is one, others by name

    bool Ok() const { return error.empty(); }

    /// Whether any layer's relMSE is above the threshold (infinite and NaN are).
    bool IsAbove(double threshold) const;
};

/// Compares two files of any format: same size, same channel names. Integer ids are compared as
/// numbers, 8 and 16 bit values as fractions of their maximum. Memory: one decoded image.
ImageComparison CompareImages(const std::string& file, const std::string& referenceFile);

} // namespace hds
