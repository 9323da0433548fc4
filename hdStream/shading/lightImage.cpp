// SPDX-License-Identifier: Apache-2.0
// Cumulative distributions of a light's image.
#include "hdStream/shading/lightImage.h"

#include "kernels/shared/compat.h"
#include "kernels/shared/texture.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace hds {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kMaxCells = 1ULL << 21U;
constexpr std::uint32_t kMaxCellsInARow = 8192;
/// Of a cumulative distribution: four times what floats below 1 tell apart, so that cells keep it.
constexpr double kLeastShare = 1.0 / (1U << 22U);
/// Of the mean luminance of a dome's image: what light samples leave to BSDF samples.
constexpr double kLeftToBsdfSamples = 0.5;

double Luminance(const float* rgb) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/// Luminance of all texels.
std::vector<double> LuminanceOf(const LightImage& image) {
    std::vector<double> values(std::size_t(image.width) * image.height);
    tbb::parallel_for(std::uint32_t(0), image.height, [&](std::uint32_t y) {
        for (std::size_t i = std::size_t(y) * image.width; i < (y + std::size_t{1}) * image.width;
             ++i) {
            values[i] = Luminance(&image.rgb[3 * i]);
        }
    });
    return values;
}

/// A row of a flat light's luminance after the horizontal part of the bilinear lookup's integral
/// over a cell: the tent of a texel lies 6/8 in its own cell and 1/8 in each neighbour's.
std::vector<double> FilteredRow(const double* row, std::size_t width) {
    std::vector<double> values(width);
    for (std::size_t x = 0; x < width; ++x) {
        const double left = row[x == 0 ? 0 : x - 1];
        const double right = row[std::min(x + 1, width - 1)];
        values[x] = 0.125 * (left + right) + 0.75 * row[x];
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

/// The mean of all cells; parameters are those of BuildTable.
template <typename ValuesOfRow, typename AreaOfRow>
double MeanOfCells(std::uint32_t numRows, double area, const ValuesOfRow& valuesOfRow,
                   const AreaOfRow& areaOfRow) {
    std::vector<double> rows(numRows);
    tbb::parallel_for(std::uint32_t(0), numRows, [&](std::uint32_t y) {
        const std::vector<double> values = valuesOfRow(y);
        rows[y] = std::accumulate(values.begin(), values.end(), 0.0) * areaOfRow(y);
    });
    return std::accumulate(rows.begin(), rows.end(), 0.0) / area;
}

/// \param valuesOfRow weights of a row's cells by area. \param areaOfRow of each of them; the
/// areas of all cells have the sum `area`.
template <typename ValuesOfRow, typename AreaOfRow>
LightImageTable BuildTable(std::uint32_t width, std::uint32_t numRows, double area,
                           const ValuesOfRow& valuesOfRow, const AreaOfRow& areaOfRow) {
    LightImageTable table;
    table.width = width;
    table.numRows = numRows;
    const std::size_t stride = std::size_t(width) + 1;
    table.cdf.resize(numRows + 1 + numRows * stride);
    std::vector<double> rowWeights(numRows);
    tbb::parallel_for(std::uint32_t(0), numRows, [&](std::uint32_t y) {
        const double sum = WriteCdf(valuesOfRow(y), &table.cdf[numRows + 1 + y * stride]);
        rowWeights[y] = sum * areaOfRow(y);
    });
    table.meanLuminance = WriteCdf(rowWeights, table.cdf.data()) / area;
    return table;
}

/// A texel in two words: three factors of 16 bits, then the exponent of what they are multiplied
/// with, as a float has it.
std::array<std::uint32_t, 2> PackTexel(const float* rgb) {
    const float largest = std::max({rgb[0], rgb[1], rgb[2]});
    int exponent = 0;
    std::frexp(largest, &exponent); // largest < 2^exponent
    exponent = std::max(exponent - 16, -126);
    std::array<std::uint32_t, 3> factors{};
    for (int i = 0; i < 3; ++i) {
        factors[i] = std::uint32_t(std::min(std::lround(std::ldexp(rgb[i], -exponent)), 65535L));
    }
    return {factors[0] | factors[1] << 16U, factors[2] | std::uint32_t(exponent + 127) << 16U};
}

void AppendTexels(const LightImage& image, std::vector<float>* words) {
    const std::size_t first = words->size();
    const std::size_t width = image.width;
    words->resize(first + 2 * width * image.height);
    tbb::parallel_for(std::size_t(0), std::size_t(image.height), [&](std::size_t y) {
        for (std::size_t i = y * width; i < (y + 1) * width; ++i) {
            const std::array<std::uint32_t, 2> texel = PackTexel(&image.rgb[3 * i]);
            (*words)[first + 2 * i] = shared::FloatOfBits(texel[0]);
            (*words)[first + 2 * i + 1] = shared::FloatOfBits(texel[1]);
        }
    });
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

LightImageTable BuildLatLongTable(const LightImage& image, bool leavesMean) {
    const std::size_t width = image.width;
    const std::size_t height = image.height;
    const std::vector<double> texels = LuminanceOf(image);
    const auto valuesOfRow = [&](std::size_t y) {
        const double* above = &texels[(std::max(y, std::size_t{1}) - 1) * width];
        const double* below = &texels[std::min(y, height - 1) * width];
        std::vector<double> values(width);
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t right = x + 1 < width ? x + 1 : 0;
            values[x] = 0.25 * ((above[x] + above[right]) + (below[x] + below[right]));
        }
        return values;
    };
    const auto areaOfRow = [&](std::size_t y) {
        const double begin = y == 0 ? 0.0 : double(y) - 0.5;
        const double end = std::min(double(y) + 0.5, double(height));
        const double step = 0.5 * kPi / double(height);
        return 4.0 * kPi / double(width) * std::sin((begin + end) * step) *
               std::sin((end - begin) * step);
    };
    const std::uint32_t numRows = image.height + 1;
    const double mean = MeanOfCells(numRows, 4.0 * kPi, valuesOfRow, areaOfRow);
    const double left = leavesMean ? kLeftToBsdfSamples * mean : 0.0;
    const auto weightsOfRow = [&](std::size_t y) {
        std::vector<double> values = valuesOfRow(y);
        for (double& value : values) {
            value = std::max(value - left, 0.0);
        }
        return values;
    };
    LightImageTable table = BuildTable(image.width, numRows, 4.0 * kPi, weightsOfRow, areaOfRow);
    table.meanLuminance = mean;
    AppendTexels(image, &table.cdf);
    return table;
}

LightImageTable BuildFlatTable(const LightImage& image) {
    const std::size_t width = image.width;
    const std::size_t height = image.height;
    const std::vector<double> texels = LuminanceOf(image);
    const auto valuesOfRow = [&](std::size_t y) {
        const auto filtered = [&](std::size_t row) {
            return FilteredRow(&texels[row * width], width);
        };
        const std::vector<double> above = filtered(y == 0 ? 0 : y - 1);
        const std::vector<double> below = filtered(std::min(y + 1, height - 1));
        std::vector<double> values = filtered(y);
        for (std::size_t x = 0; x < width; ++x) {
            values[x] = 0.125 * (above[x] + below[x]) + 0.75 * values[x];
        }
        return values;
    };
    const double cell = 1.0 / (double(width) * double(height));
    return BuildTable(image.width, image.height, 1.0, valuesOfRow,
                      [&](std::size_t) { return cell; });
}

std::vector<std::uint32_t> SumCells(const float* cdf, std::uint32_t width, std::uint32_t numRows) {
    const std::size_t stride = std::size_t(width) + 1;
    const double whole = double(~std::uint32_t{0}) - double(width) * double(numRows);
    std::vector<std::uint32_t> sums((numRows + 1) * stride);
    for (std::uint32_t y = 0; y < numRows; ++y) {
        const float* conditional = cdf + numRows + 1 + y * stride;
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
