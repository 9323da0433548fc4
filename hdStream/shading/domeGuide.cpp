// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/domeGuide.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace hds {

namespace {

constexpr std::uint32_t kColumns = HDS_GUIDE_COLUMNS;
constexpr std::uint32_t kRows = HDS_GUIDE_ROWS;
constexpr std::uint32_t kCells = kColumns * kRows;
/// Of all that rays have added at a place, which is up to 255 each: with less nothing is known.
constexpr std::uint64_t kLeastTotal = 512;
/// Of the mean of the cells around one, and of all cells: what each has besides its own.
constexpr double kNeighbours = 0.5;
constexpr double kFloor = 0.05;

/// The cumulative distribution of a place, [kCells + 1].
void AppendCdf(const std::uint32_t* cells, std::uint64_t total, std::vector<float>* words) {
    std::array<double, kCells> weights{};
    for (std::uint32_t y = 0; y < kRows; ++y) {
        for (std::uint32_t x = 0; x < kColumns; ++x) {
            const std::uint32_t above = std::min(y + 1, kRows - 1) * kColumns;
            const std::uint32_t below = (std::max(y, 1U) - 1) * kColumns;
            const std::uint32_t row = y * kColumns;
            const double around = double(cells[above + x]) + cells[below + x] +
                                  cells[row + (x + 1) % kColumns] +
                                  cells[row + (x + kColumns - 1) % kColumns];
            weights[row + x] =
                cells[row + x] + kNeighbours * 0.25 * around + kFloor * double(total) / kCells;
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
    return light.type == HDS_LIGHT_DOME && isPlain &&
           (light.flags & (HDS_LIGHT_TEXTURED | HDS_LIGHT_SAMPLED)) == 0;
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

std::vector<float> BuildDomeGuide(const std::array<float, 3>& camera,
                                  const std::vector<std::uint32_t>& cells, std::uint32_t base) {
    std::vector<float> words(camera.begin(), camera.end());
    words.resize(camera.size() + HDS_GUIDE_PLACES, shared::FloatOfBits(HDS_NONE));
    const std::size_t sizeOfNone = words.size();
    for (std::uint32_t place = 0; place < HDS_GUIDE_PLACES; ++place) {
        const std::uint32_t* own = &cells[std::size_t{place} * kCells];
        const std::uint64_t total = std::accumulate(own, own + kCells, std::uint64_t{0});
        if (total >= kLeastTotal) {
            words[camera.size() + place] =
                shared::FloatOfBits(base + static_cast<std::uint32_t>(words.size()));
            AppendCdf(own, total, &words);
        }
    }
    if (words.size() == sizeOfNone) {
        words.clear();
    }
    return words;
}

} // namespace hds
