// SPDX-License-Identifier: Apache-2.0
// The statistics object of docs/statistics.md. Its keys are API: those of what a scene does not use
// are present and zero.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/integrator/pathTracer.h"
#include "hdStream/scene/commit.h"
#include "hdStream/scene/keptArrays.h"

#include <string>
#include <vector>

namespace hds {

/// Everything the object is made of.
struct StatisticsInput {
    const Device* device = nullptr;
    const CommittedScene* scene = nullptr;
    const PreparedPages* pages = nullptr;
    const SourceKeeper* sources = nullptr;
    std::uint64_t sceneBytes = 0; ///< of host memory (scene/hostRecords.h)
    KeptArrays keptArrays;
    std::uint64_t arrayBytesReadBefore = 0; ///< this render (ArrayCounts)
    double commitSeconds = 0.0;    ///< of the scene; 0: it was there from the render before
    std::uint64_t primsMended = 0; ///< where an edit was no commit (PrimCommit::Mend)
    const PathTracer* tracer = nullptr;
    std::uint32_t imageWidth = 0;
    std::uint32_t imageHeight = 0;
    double loadSeconds = 0.0;
    double translateSeconds = 0.0;
    double beforeRenderingSeconds = 0.0; ///< from process start, or the edit, to the first ray
    double totalSeconds = 0.0;
    std::vector<std::string> warnings;
};

/// JSON text, indented.
std::string MakeStatistics(const StatisticsInput& input);

/// JSON text of what a scene contains (`hdstream info`).
std::string MakeInfo(const SceneDescription& scene, const CommittedScene& committed,
                     const std::vector<std::string>& warnings);

} // namespace hds
