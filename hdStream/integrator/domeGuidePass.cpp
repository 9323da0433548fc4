// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/domeGuidePass.h"

#include "hdStream/shading/domeGuide.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hds {

namespace {

constexpr double kFewPaths = 2048.0;
/// Of a round of all pixels, and rounds at most. Not by the samples of the render: parts of it have
/// the guide of all of it.
constexpr double kLeastPaths = 65536.0;
constexpr double kMostPaths = 262144.0;
constexpr double kMostRounds = 4.0;
/// Of the rays that surfaces send on, those that find the open: with fewer there is nothing to
/// learn, with more most light samples arrive without a guide.
constexpr double kLeastShare = 0.002;
constexpr double kMostShare = 0.15;
/// Random numbers are not those of the picture.
constexpr std::uint32_t kSeedOfFew = 0x9e3779b9U;
constexpr std::uint32_t kSeedOfMany = 0x85ebca6bU;

/// The whole display window in so many pixels, as paths that learn see it.
RenderOptions WholePicture(const RenderOptions& options, double numPixels, std::uint32_t seed) {
    RenderOptions whole = options;
    const std::array<double, 4>& window = options.displayWindow;
    const double aspect = (window[2] - window[0]) / (window[3] - window[1]);
    const double height = std::clamp(std::round(std::sqrt(numPixels / aspect)), 1.0, numPixels);
    const double width = std::max(1.0, std::floor(numPixels / height));
    whole.imageWidth = static_cast<std::uint32_t>(width);
    whole.imageHeight = static_cast<std::uint32_t>(height);
    whole.displayWindow = {0.0, 0.0, width, height};
    whole.dataWindowMin = {0, 0};
    whole.pixelAspectRatio = options.pixelAspectRatio * aspect * height / width;
    whole.seed = options.seed ^ seed;
    whole.learns = true;
    whole.russianRoulette = true; // counts are the same on average, for fewer rays
    return whole;
}

} // namespace

std::vector<std::uint32_t> PixelsOf(const RenderOptions& picture) {
    std::vector<std::uint32_t> pixels(std::size_t{picture.imageWidth} * picture.imageHeight);
    std::iota(pixels.begin(), pixels.end(), 0U);
    return pixels;
}

bool ForEachWave(const RenderOptions& picture, std::uint32_t maxPaths,
                 const std::function<bool(const shared::HdsWave&)>& trace) {
    const std::uint32_t numPixels = picture.imageWidth * picture.imageHeight;
    bool isDone = true;
    for (std::uint32_t first = 0; isDone && first < numPixels; first += maxPaths) {
        isDone = trace({first, std::min(maxPaths, numPixels - first), 0, 1});
    }
    return isDone;
}

void LearnDomeGuide(const RenderOptions& options, const std::array<float, 3>& camera,
                    WaveTracer* tracer, SceneBuffers* buffers, const TracePicture& trace) {
    const std::array<double, 4>& window = options.displayWindow;
    const double pixels = (window[2] - window[0]) * (window[3] - window[1]);
    tracer->BeginDomeGuide(camera, 1.0F / options.camera.exposureScale);
    const RenderOptions few = WholePicture(options, kFewPaths, kSeedOfFew);
    bool isDone = trace(few);
    const double share = tracer->ReadDomeGuideShare();
    std::vector<std::uint32_t> cells;
    if (isDone && share >= kLeastShare && share <= kMostShare) {
        const double numPaths = std::clamp(pixels, kLeastPaths, kMostPaths);
        const auto numRounds = static_cast<std::uint32_t>(
            std::clamp(kMostRounds * pixels / numPaths, 1.0, kMostRounds));
        isDone = trace(WholePicture(options, numPaths, kSeedOfMany));
        // Where time is up in a later round the guide has what there is.
        bool goesOn = isDone;
        for (std::uint32_t round = 1; goesOn && round < numRounds; ++round) {
            goesOn = trace(WholePicture(options, numPaths, kSeedOfMany + round));
        }
        cells = tracer->ReadDomeGuide();
    }
    tracer->EndDomeGuide();
    if (isDone && !cells.empty()) {
        buffers->SetDomeGuide(camera, cells);
    }
}

} // namespace hds
