// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/settingsCheck.h"

#include "hdStream/base/error.h"

#include <cmath>

namespace hds {

namespace {

/// Most bounces; path depths are kept in 16 bits together with their sampling dimensions.
constexpr std::uint32_t kMaxDepth = 4096;
constexpr std::uint32_t kMaxWaveSize = 1U << 24U;
constexpr std::uint32_t kMaxRefineLevel = 8;
constexpr std::uint64_t kMinChunkBytes = 4U << 10U;
constexpr std::uint64_t kMaxChunkBytes = 256U << 20U;

[[noreturn]] void Fail(const std::string& option, const std::string& text) {
    throw Error(option + ": " + text, ErrorKind::Usage);
}

void CheckSize(const std::string& option, std::uint32_t size) {
    if (size < 1 || size > kMaxImageSize) {
        Fail(option, std::to_string(size) + " is not in 1.." + std::to_string(kMaxImageSize));
    }
}

void CheckRange(const std::string& option, std::uint64_t value, std::uint64_t low,
                std::uint64_t high) {
    if (value < low || value > high) {
        Fail(option, std::to_string(value) + " is not in " + std::to_string(low) + ".." +
                         std::to_string(high));
    }
}

void CheckNotNegative(const std::string& option, double value) {
    if (!(value >= 0.0) || !std::isfinite(value)) {
        Fail(option, "must be a finite number, 0 or more");
    }
}

TraversalForm FindTraversal(const std::string& name) {
    if (name == "auto") {
        return TraversalForm::Auto;
    }
    if (name == "wide") {
        return TraversalForm::Wide;
    }
    if (name == "lane") {
        return TraversalForm::Lane;
    }
    Fail("traversal", name + " is none of auto, wide, lane");
}

Subdivision FindSubdivision(const std::string& name) {
    if (name == "adaptive") {
        return Subdivision::Adaptive;
    }
    if (name == "complexity") {
        return Subdivision::Complexity;
    }
    if (name == "cage") {
        return Subdivision::Cage;
    }
    Fail("--subdivision", name + " is none of adaptive, complexity, cage");
}

} // namespace

void CheckSettings(const Settings& settings) {
    CheckSize("--imageWidth", settings.imageWidth);
    CheckSize("--imageHeight", settings.imageHeight);
    CheckRange("--samples", settings.samples, 1, 1U << 24U);
    CheckRange("--maxDepth", settings.maxDepth, 0, kMaxDepth);
    CheckNotNegative("--time", settings.timeLimit);
    CheckNotNegative("--noise", settings.noise);
    if (settings.waveSize != 0) {
        CheckRange("--waveSize", settings.waveSize, 16, kMaxWaveSize);
    }
    CheckRange("--chunkSize", settings.chunkBytes, kMinChunkBytes, kMaxChunkBytes);
    if (!(settings.pixelAspectRatio > 0.0) || !std::isfinite(settings.pixelAspectRatio)) {
        Fail("pixelAspectRatio", "must be a finite number above 0");
    }
    MakeAovLayout(settings.aovs);
    FindTraversal(settings.traversal);
    FindSubdivision(settings.subdivision);
    CheckRange("--complexity", settings.refineLevel, 0, kMaxRefineLevel);
}

RenderOptions MakeRenderOptions(const Settings& settings, const CameraPrim& camera) {
    RenderOptions options;
    options.camera = camera;
    options.imageWidth = settings.imageWidth;
    options.imageHeight = settings.imageHeight;
    options.pixelAspectRatio = settings.pixelAspectRatio;
    options.aovs = MakeAovLayout(settings.aovs);
    options.samples = settings.samples;
    options.maxDepth = settings.maxDepth;
    options.seed = settings.seed;
    options.timeLimit = settings.timeLimit;
    options.noise = settings.noise;
    options.pixelFilter = settings.pixelFilter;
    options.pixelFilterWidth = settings.pixelFilterWidth;
    options.russianRoulette = settings.russianRoulette;
    options.waveSize = settings.waveSize;
    options.traversal = FindTraversal(settings.traversal);
    return options;
}

CommitOptions MakeCommitOptions(const Settings& settings) {
    CommitOptions options;
    options.purposes = settings.purposes;
    options.meshes.chunkBytes = settings.chunkBytes;
    options.meshes.subdivision = FindSubdivision(settings.subdivision);
    options.meshes.refineLevel = settings.refineLevel;
    return options;
}

} // namespace hds
