// SPDX-License-Identifier: Apache-2.0
// AOVs of first hits: what rays through the centres of pixels meet, in passes of their own.
// Explained in docs/film.md.
#pragma once

#include "hdStream/integrator/filmBuffers.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/integrator/waveTracer.h"
#include "hdStream/scene/commit.h"

#include <cstdint>
#include <functional>
#include <memory>

namespace hds {

struct FirstHitPicture {
    const CommittedScene* scene = nullptr;
    const RenderOptions* options = nullptr;
    const Buffer* frame = nullptr; ///< constants
    const Buffer* order = nullptr; ///< the pixels, each once
    std::uint32_t numPixels = 0;   ///< of `order`
};

/// Fills the film's AOVs of first hits, wave by wave. Counts of the tracer's statistics are added
/// to. \param goesOn asked between the waves. \return false when that said no, or a wave was
/// cancelled: the film has them in part. Externally synchronised.
bool TraceFirstHits(const std::shared_ptr<Device>& device, const FirstHitPicture& picture,
                    StageKernels* kernels, WaveTracer* tracer, FilmBuffers* film,
                    const std::function<bool()>& goesOn,
                    const WaveTracer::IsCancelled& isCancelled);

} // namespace hds
