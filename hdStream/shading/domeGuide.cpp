// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/domeGuide.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numeric>

namespace hds {

namespace {

constexpr std::uint32_t kColumns = HDS_GUIDE_COLUMNS;
constexpr std::uint32_t kRows = HDS_GUIDE_ROWS;
constexpr std::uint32_t kCells = kColumns * kRows;
constexpr double kPi = 3.14159265358979323846;
/// Of all that rays have added at a place, which is up to 255 each: with less nothing is known.
constexpr std::uint64_t kLeastTotal = 512;
/// Of the mean of the cells around one, and of all cells: what each has besides its own.
constexpr double kNeighbours = 0.5;
constexpr double kFloor = 0.05;

/// Luminance above so many times the mean counts as that: by the image itself light samples find
/// the sun.
constexpr double kBright = 4.0;
/// Of the mean luminance: what cells count as at least.
constexpr double kDark = 0.05;
/// Of the light samples at a place: without an image, with one, and where its sun comes in.
constexpr double kShare = 0.9;
constexpr double kShareBesideImage = 0.8;
constexpr double kShareInSun = 0.2;
/// Most texels of a row or a column that are looked at.
constexpr std::uint32_t kMostLooks = 512;

/// The cell of a direction of any length (domeGuide_cell).
std::uint32_t CellOf(const glm::dvec3& d) {
    const glm::dvec3 unit = glm::normalize(d);
    const double x = (std::atan2(unit.y, unit.x) / (2.0 * kPi) + 0.5) * kColumns;
    const double y = (0.5 * unit.z + 0.5) * kRows;
    const auto column = std::min(static_cast<std::uint32_t>(std::max(x, 0.0)), kColumns - 1);
    const auto row = std::min(static_cast<std::uint32_t>(std::max(y, 0.0)), kRows - 1);
    return row * kColumns + column;
}

/// Of a texel of the image that lies in lightCdf (light/domeImage).
double LuminanceOf(const float* texel) {
    std::uint32_t first = 0;
    std::uint32_t second = 0;
    std::memcpy(&first, texel, sizeof(first));
    std::memcpy(&second, texel + 1, sizeof(second));
    const double scale = std::ldexp(1.0, static_cast<int>(second >> 16U) - 127);
    return scale *
           (0.2126 * (first & 0xffffU) + 0.7152 * (first >> 16U) + 0.0722 * (second & 0xffffU));
}

/// The part of light samples at a place that the guide takes: all but a few where no sun of the
/// image comes in, as far as rays have seen. Samples by the image find suns.
double ShareOf(const std::uint32_t* cells, const DomeLight& light) {
    double sky = 0.0;
    double sun = 0.0;
    for (std::uint32_t i = 0; i < kCells; ++i) {
        sky += cells[i] * light.sky[i];
        sun += cells[i] * light.sun[i];
    }
    const double isSunny = std::min(2.0 * sun / (sky + sun), 1.0);
    return light.hasImage ? kShareBesideImage + (kShareInSun - kShareBesideImage) * isSunny
                          : kShare;
}

/// The share of a place and its cumulative distribution, [1 + kCells + 1].
void AppendPlace(const std::uint32_t* cells, std::uint64_t total, const DomeLight& light,
                 std::vector<float>* words) {
    words->push_back(static_cast<float>(ShareOf(cells, light)));
    std::array<double, kCells> weights{};
    for (std::uint32_t y = 0; y < kRows; ++y) {
        for (std::uint32_t x = 0; x < kColumns; ++x) {
            const std::uint32_t above = std::min(y + 1, kRows - 1) * kColumns;
            const std::uint32_t below = (std::max(y, 1U) - 1) * kColumns;
            const std::uint32_t row = y * kColumns;
            const double around = double(cells[above + x]) + cells[below + x] +
                                  cells[row + (x + 1) % kColumns] +
                                  cells[row + (x + kColumns - 1) % kColumns];
            weights[row + x] = light.sky[row + x] * (cells[row + x] + kNeighbours * 0.25 * around +
                                                     kFloor * double(total) / kCells);
        }
    }
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    double running = 0.0;
    words->push_back(0.0F);
    for (const double weight : weights) {
        running += weight / sum;
        words->push_back(static_cast<float>(std::min(running, 1.0)));
    }
    words->back() = 1.0F;
}

} // namespace

bool MayHaveGuide(const shared::HdsLight& light) {
    const bool isPlain = light.treePlace == HDS_NONE && light.shapingBase == HDS_NONE &&
                         light.controlBase == HDS_NONE; // treePlace: portals
    return light.type == HDS_LIGHT_DOME && isPlain && (light.flags & HDS_LIGHT_SAMPLED) == 0;
}

bool MayHaveGuide(const LightTable& lights) {
    for (const shared::HdsLight& light : lights.lights) {
        if (light.boundRadius < HDS_LIGHT_FAR) {
            break; // those at infinity come first
        }
        if (MayHaveGuide(light)) {
            return true;
        }
    }
    return false;
}

DomeLight LightOfCells(const shared::HdsLight& light, const std::vector<float>& cdf) {
    DomeLight result;
    result.sky.fill(1.0);
    result.hasImage = (light.flags & HDS_LIGHT_TEXTURED) != 0;
    if (!result.hasImage) {
        return result;
    }
    const std::uint32_t width = light.dataSize[0];
    const std::uint32_t height = light.dataSize[1] - 1;
    const std::size_t first =
        light.cdfBase + light.dataSize[1] + 1 + std::size_t{light.dataSize[1]} * (width + 1);
    struct Look {
        std::uint32_t cell;
        double luminance, solidAngle;
    };
    std::vector<Look> looks;
    double sum = 0.0;
    double sumOfAngles = 0.0;
    const std::uint32_t stepX = (width - 1) / kMostLooks + 1;
    const std::uint32_t stepY = (height - 1) / kMostLooks + 1;
    for (std::uint32_t y = stepY / 2; y < height; y += stepY) {
        const double polar = kPi * (y + 0.5) / height;
        for (std::uint32_t x = stepX / 2; x < width; x += stepX) {
            const double longitude = kPi - 2.0 * kPi * (x + 0.5) / width;
            const glm::dvec3 d(std::sin(polar) * std::sin(longitude), std::cos(polar),
                               std::sin(polar) * std::cos(longitude));
            const float* m = light.worldFromLight;
            const glm::dvec3 inWorld(m[0] * d.x + m[1] * d.y + m[2] * d.z,
                                     m[4] * d.x + m[5] * d.y + m[6] * d.z,
                                     m[8] * d.x + m[9] * d.y + m[10] * d.z);
            const double luminance = LuminanceOf(&cdf[first + 2 * (std::size_t{y} * width + x)]);
            looks.push_back({CellOf(inWorld), luminance, std::sin(polar)});
            sum += luminance * std::sin(polar);
            sumOfAngles += std::sin(polar);
        }
    }
    const double mean = sum / sumOfAngles;
    if (!(mean > 0.0)) {
        return result;
    }
    DomeCells sky{};
    DomeCells angles{};
    for (const Look& look : looks) {
        const double luminance = look.luminance / mean;
        const double bounded = std::min(luminance, kBright);
        sky[look.cell] += look.solidAngle * bounded;
        result.sun[look.cell] += look.solidAngle * (luminance - bounded);
        angles[look.cell] += look.solidAngle;
    }
    for (std::uint32_t i = 0; i < kCells; ++i) {
        if (angles[i] > 0.0) {
            result.sky[i] = std::max(sky[i] / angles[i], kDark);
            result.sun[i] /= angles[i];
        }
    }
    return result;
}

std::vector<float> BuildDomeGuide(const std::array<float, 3>& camera,
                                  const std::vector<std::uint32_t>& cells, const DomeLight& light,
                                  std::uint32_t base) {
    std::vector<float> words(camera.begin(), camera.end());
    words.resize(camera.size() + HDS_GUIDE_PLACES, shared::FloatOfBits(HDS_NONE));
    const std::size_t sizeOfNone = words.size();
    for (std::uint32_t place = 0; place < HDS_GUIDE_PLACES; ++place) {
        const std::uint32_t* own = &cells[std::size_t{place} * kCells];
        const std::uint64_t total = std::accumulate(own, own + kCells, std::uint64_t{0});
        if (total >= kLeastTotal) {
            words[camera.size() + place] =
                shared::FloatOfBits(base + static_cast<std::uint32_t>(words.size()) + 1);
            AppendPlace(own, total, light, &words);
        }
    }
    if (words.size() == sizeOfNone) {
        words.clear();
    }
    return words;
}

} // namespace hds
