// SPDX-License-Identifier: Apache-2.0
// Cumulative distributions of a light's image.
#include "hdStream/shading/lightImage.h"

#include "kernels/shared/texture.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hds {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kMaxCells = 1ULL << 21U;
constexpr std::uint32_t kMaxCellsInARow = 8192;
/// Of a cumulative distribution: four times what floats below 1 tell apart, so that cells keep it.
constexpr double kLeastShare = 1.0 / (1U << 22U);

double Luminance(const float* rgb) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/// What is beside the first and the last column.
enum class Sides { Wrap, Clamp };

/// Luminance of a row after the horizontal part of the bilinear lookup's integral over a cell: the
/// tent of a texel lies 6/8 in its own cell and 1/8 in each neighbour's.
std::vector<double> FilteredRow(const LightImage& image, Sides sides, std::uint32_t y) {
    const std::size_t width = image.width;
    const std::size_t beforeFirst = sides == Sides::Wrap ? width - 1 : 0;
    const std::size_t afterLast = sides == Sides::Wrap ? 0 : width - 1;
    const float* row = &image.rgb[std::size_t(y) * width * 3];
    std::vector<double> values(width);
    for (std::size_t x = 0; x < width; ++x) {
        const double left = Luminance(row + (x == 0 ? beforeFirst : x - 1) * 3);
        const double right = Luminance(row + (x + 1 == width ? afterLast : x + 1) * 3);
        values[x] = 0.125 * (left + right) + 0.75 * Luminance(row + x * 3);
    }
    return values;
}

/// Writes the running sums of the weights' shares to cdf[0 .. n]; they end at exactly 1, and none
/// is less than about kLeastShare. Weights that are all zero become equal.
/// \return the weights' sum.
double WriteCdf(const std::vector<double>& weights, float* cdf) {
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const auto shareOf = [&](double weight) {
        return sum > 0.0 ? std::max(weight / sum, kLeastShare) : 1.0 / double(weights.size());
    };
    double sumOfShares = 0.0;
    for (const double weight : weights) {
        sumOfShares += shareOf(weight);
    }
    double running = 0.0;
    cdf[0] = 0.0F;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        running += shareOf(weights[i]) / sumOfShares;
        cdf[i + 1] = float(std::min(running, 1.0));
    }
    cdf[weights.size()] = 1.0F;
    return sum;
}

/// \param areaOfRow of each cell of a row; the areas of all cells have the sum `area`.
template <typename AreaOfRow>
LightImageTable BuildTable(const LightImage& image, Sides sides, double area,
                           const AreaOfRow& areaOfRow) {
    const std::size_t width = image.width;
    const std::uint32_t height = image.height;
    std::vector<std::vector<double>> rows(height);
    tbb::parallel_for(std::uint32_t(0), height,
                      [&](std::uint32_t y) { rows[y] = FilteredRow(image, sides, y); });

    LightImageTable table;
    table.cdf.resize(height + 1 + std::size_t(height) * (width + 1));
    std::vector<double> rowWeights(height);
    tbb::parallel_for(std::uint32_t(0), height, [&](std::uint32_t y) {
        const std::vector<double>& above = rows[y == 0 ? 0 : y - 1];
        const std::vector<double>& below = rows[std::min(y + 1, height - 1)];
        std::vector<double> values(width);
        for (std::size_t x = 0; x < width; ++x) {
            values[x] = 0.125 * (above[x] + below[x]) + 0.75 * rows[y][x];
        }
        const double sum = WriteCdf(values, &table.cdf[height + 1 + y * (width + 1)]);
        rowWeights[y] = sum * areaOfRow(y);
    });
    table.meanLuminance = WriteCdf(rowWeights, table.cdf.data()) / area;
    return table;
}

} // namespace

std::uint32_t FindTableMip(std::uint32_t width, std::uint32_t height) {
    std::uint32_t mip = 0;
    const auto isTooLarge = [&] {
        const std::uint32_t columns = shared::texture_mipSize(width, mip);
        const std::uint32_t rows = shared::texture_mipSize(height, mip);
        return std::uint64_t{columns} * rows > kMaxCells ||
               std::max(columns, rows) > kMaxCellsInARow;
    };
    while (isTooLarge()) {
        ++mip;
    }
    return mip;
}

LightImageTable BuildLatLongTable(const LightImage& image) {
    return BuildTable(image, Sides::Wrap, 4.0 * kPi, [&](std::uint32_t y) {
        return 4.0 * kPi / double(image.width) * std::sin((y + 0.5) * kPi / image.height) *
               std::sin(0.5 * kPi / image.height);
    });
}

LightImageTable BuildFlatTable(const LightImage& image) {
    const double cell = 1.0 / (double(image.width) * double(image.height));
    return BuildTable(image, Sides::Clamp, 1.0, [&](std::uint32_t) { return cell; });
}

std::vector<std::uint32_t> SumCells(const float* cdf, std::uint32_t width, std::uint32_t height) {
    const std::size_t stride = std::size_t(width) + 1;
    const double whole = double(~std::uint32_t{0}) - double(width) * double(height);
    std::vector<std::uint32_t> sums((height + 1) * stride);
    for (std::uint32_t y = 0; y < height; ++y) {
        const float* conditional = cdf + height + 1 + y * stride;
        const double row = double(cdf[y + 1]) - double(cdf[y]);
        std::uint32_t running = 0;
        for (std::uint32_t x = 0; x < width; ++x) {
            const double share = row * (double(conditional[x + 1]) - double(conditional[x]));
            running += std::uint32_t(share * whole) + 1U;
            sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + running;
        }
    }
    return sums;
}

} // namespace hds
