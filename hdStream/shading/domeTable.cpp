// SPDX-License-Identifier: Apache-2.0
// Cumulative distributions of a dome image.
#include "hdStream/shading/domeTable.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace hds {

namespace {

constexpr double kPi = 3.14159265358979323846;

double Luminance(const float* rgb) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/// Luminance of a row after the horizontal part of the bilinear lookup's integral over a cell: the
/// tent of a texel lies 6/8 in its own cell and 1/8 in each neighbour's.
std::vector<double> FilteredRow(const DomeImage& image, std::uint32_t y) {
    const std::size_t width = image.width;
    const float* row = &image.rgb[std::size_t(y) * width * 3];
    std::vector<double> values(width);
    for (std::size_t x = 0; x < width; ++x) {
        const double left = Luminance(row + (x == 0 ? width - 1 : x - 1) * 3);
        const double right = Luminance(row + (x + 1 == width ? 0 : x + 1) * 3);
        values[x] = 0.125 * (left + right) + 0.75 * Luminance(row + x * 3);
    }
    return values;
}

/// Writes the running sums of `weights`, scaled to end at exactly 1, to cdf[0 .. n].
/// Weights that are all zero become equal. \return the sum.
double WriteCdf(const std::vector<double>& weights, float* cdf) {
    double sum = 0.0;
    for (const double weight : weights) {
        sum += weight;
    }
    double running = 0.0;
    cdf[0] = 0.0F;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        running += sum > 0.0 ? weights[i] / sum : 1.0 / double(weights.size());
        cdf[i + 1] = float(std::min(running, 1.0));
    }
    cdf[weights.size()] = 1.0F;
    return sum;
}

} // namespace

std::size_t SanitizeDomeImage(DomeImage& image) {
    std::size_t count = 0;
    for (float& value : image.rgb) {
        if (!(value >= 0.0F) || !std::isfinite(value)) {
            value = 0.0F;
            ++count;
        }
    }
    return count;
}

void ShrinkDomeImage(DomeImage& image, std::uint32_t maxWidth) {
    while (image.width > maxWidth && image.width >= 2 && image.height >= 2) {
        DomeImage half;
        half.width = image.width / 2;
        half.height = image.height / 2;
        half.rgb.resize(std::size_t(half.width) * half.height * 3);
        tbb::parallel_for(std::uint32_t(0), half.height, [&](std::uint32_t y) {
            const std::size_t stride = std::size_t(image.width) * 3;
            for (std::uint32_t x = 0; x < half.width; ++x) {
                const float* p = &image.rgb[std::size_t(y) * 2 * stride + std::size_t(x) * 6];
                float* out = &half.rgb[(std::size_t(y) * half.width + x) * 3];
                for (int c = 0; c < 3; ++c) {
                    out[c] = 0.25F * (p[c] + p[c + 3] + p[c + stride] + p[c + stride + 3]);
                }
            }
        });
        image = std::move(half);
    }
}

DomeTable BuildDomeTable(const DomeImage& image) {
    const std::size_t width = image.width;
    const std::uint32_t height = image.height;
    std::vector<std::vector<double>> rows(height);
    tbb::parallel_for(std::uint32_t(0), height,
                      [&](std::uint32_t y) { rows[y] = FilteredRow(image, y); });

    DomeTable table;
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
        const double solidAngle = 4.0 * kPi / double(width) * std::sin((y + 0.5) * kPi / height) *
                                  std::sin(0.5 * kPi / height);
        rowWeights[y] = sum * solidAngle;
    });
    table.meanLuminance = WriteCdf(rowWeights, table.cdf.data()) / (4.0 * kPi);
    return table;
}

} // namespace hds
