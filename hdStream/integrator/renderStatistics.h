// SPDX-License-Identifier: Apache-2.0
// What a render has done and how long it took.
#pragma once

#include "hdStream/integrator/renderOptions.h"

#include <cstdint>
#include <optional>

namespace hds {

/// Seconds by kind of work (docs/statistics.md) and what was traced.
struct RenderStatistics {
    double compileSeconds = 0.0; ///< of kernels, also of those that a render changes to
    double traceSeconds = 0.0;
    double shadeSeconds = 0.0;
    double transferSeconds = 0.0;
    double renderSeconds = 0.0;     ///< generate to the last resolve
    double firstImageSeconds = 0.0; ///< since rendering began, first complete 1-sample image
    std::uint64_t cameraRays = 0;
    std::uint64_t indirectRays = 0;
    std::uint64_t shadowRays = 0;
    /// Sets of rays that are traced to completion together: a bounce of a wave; while geometry
    /// streams with lists all of a wave.
    std::uint64_t rayBatches = 0;
    std::uint64_t briefBatches = 0; ///< of these: of few rays, with one wait (docs/wavefront.md)
    std::uint64_t iterations = 0;   ///< launches over all rays under way; resident: one a batch
    std::uint32_t maxIterationsPerBatch = 0;
    std::uint64_t raysRelaunched = 0;
    /// While textures stream: launches that evaluate materials, without and with those of items
    /// that had to come again.
    std::uint64_t shadePasses = 0;
    std::uint64_t shadeIterations = 0;
    std::uint64_t nanSamples = 0;
    std::uint64_t clampedSamples = 0; ///< times that what a path added was clamped
    std::uint64_t endedPasses = 0;    ///< rays that passed HDS_MAX_PASSES cut-out surfaces
    std::uint64_t endedWalks = 0;     ///< paths that media scattered HDS_MEDIUM_MAX_STEPS times
    std::optional<double> meanRelativeError; ///< none of what an edit has ended
    std::uint32_t samples = 0;               ///< per pixel, the least over all pixels
    std::uint32_t streamedSamples = 0;       ///< of these, the last one for which geometry streamed
    std::uint64_t streamedPaths = 0;         ///< camera rays that began while geometry streamed
    std::uint32_t waveSize = 0;
    TraversalForm traversal = TraversalForm::Scalar; ///< never Auto
    bool hasGeneralKernels = false;                  ///< at the end, as generalKernels.h
    double flattenSeconds = 0.0;                     ///< the flat hierarchy was built in
    std::uint64_t pathStateBytes = 0;
    std::uint64_t filmBytes = 0;
    std::uint64_t deepBytes = 0;   ///< of host memory, for a deep picture
    std::uint64_t deepCrowded = 0; ///< samples that have joined another surface there

    /// Takes the counts of rays and launches back to what they were, for what is traced for no
    /// picture.
    void TakeCounts(const RenderStatistics& before) {
        cameraRays = before.cameraRays;
        indirectRays = before.indirectRays;
        shadowRays = before.shadowRays;
        rayBatches = before.rayBatches;
        briefBatches = before.briefBatches;
        iterations = before.iterations;
        maxIterationsPerBatch = before.maxIterationsPerBatch;
        raysRelaunched = before.raysRelaunched;
        shadePasses = before.shadePasses;
        shadeIterations = before.shadeIterations;
    }
};

} // namespace hds
