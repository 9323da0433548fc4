// SPDX-License-Identifier: Apache-2.0
// The AOV ambientOcclusion: a trace of its own for each wave. Explained in docs/film.md.
#pragma once

#include "hdStream/integrator/filmBuffers.h"
#include "hdStream/integrator/waveTracer.h"

#include <memory>

namespace hds {

/// Externally synchronised.
class AmbientOcclusion {
public:
    explicit AmbientOcclusion(std::shared_ptr<Device> device) : _device(std::move(device)) {}

    /// Traces a wave of so many paths, and keeps what they have gathered. \param frame constants.
    /// \param distance beyond which nothing occludes. \return false when it was cancelled.
    bool Trace(StageKernels* kernels, WaveTracer* tracer, std::uint32_t numPaths,
               const Buffer& frame, float distance, const WaveTracer::Generate& generate,
               const WaveTracer::IsCancelled& isCancelled);

    /// Adds the samples of the wave to the film.
    void Add(StageKernels* kernels, const shared::HdsWave& wave, const Buffer& pixels,
             const FilmBuffers& film) const;

private:
    std::shared_ptr<Device> _device;
    Buffer _kept; ///< float4 a path
};

} // namespace hds
