// SPDX-License-Identifier: Apache-2.0
// What the integrator needs to know besides the scene.
#pragma once

#include "hdStream/film/aov.h"
#include "hdStream/scene/sceneDescription.h"

#include <cstdint>
#include <functional>
#include <string>

namespace hds {

/// Which form of the traversal kernel runs (docs/accel.md).
enum class TraversalForm {
    Auto, ///< Wide on CPU devices, Lane on others
    Wide, ///< 8-wide vectors inside a work-item
    Lane, ///< one lane a ray
};

/// Options of a render; units and defaults as in session/settings.h.
struct RenderOptions {
    CameraPrim camera;
    std::uint32_t imageWidth = 0;
    std::uint32_t imageHeight = 0;
    double pixelAspectRatio = 1.0;
    AovLayout aovs;
    std::uint32_t samples = 64;
    std::uint32_t maxDepth = 8;
    std::uint32_t seed = 0;
    double timeLimit = 0.0;
    double noise = 0.0;
    std::string pixelFilter;
    double pixelFilterWidth = 3.0;
    bool russianRoulette = true;
    std::uint32_t waveSize = 0;
    TraversalForm traversal = TraversalForm::Auto;
};

/// Progress while rendering.
struct Progress {
    std::uint32_t samplesDone = 0; ///< per pixel, of the pixels that are done least
    std::uint32_t samplesTotal = 0;
    double fraction = 0.0;       ///< of all work
    double secondsElapsed = 0.0; ///< since rendering began
    double secondsLeft = 0.0;    ///< estimate
};

/// Return false to stop; what was rendered so far stays in the film.
using ProgressCallback = std::function<bool(const Progress&)>;

/// How a render ended.
enum class RenderResult { Complete, Stopped };

} // namespace hds
