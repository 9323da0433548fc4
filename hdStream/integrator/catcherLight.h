// SPDX-License-Identifier: Apache-2.0
// What shadow catchers get of light, with the rest of the scene and without it. Explained in
// docs/film.md.
#pragma once

#include "hdStream/integrator/filmBuffers.h"
#include "hdStream/integrator/waveTracer.h"

#include <functional>
#include <memory>

namespace hds {

/// Each wave is traced twice, with the same random numbers: first in a scene of catchers alone. So
/// a catcher that nothing shades is exactly as bright in both. Externally synchronised.
class CatcherLight {
public:
    explicit CatcherLight(std::shared_ptr<Device> device) : _device(std::move(device)) {}

    /// Traces a wave of so many paths in that scene, and keeps what they have gathered.
    /// \param trace the wave, as the kernels are bound. \return what it returns: false when it was
    /// cancelled.
    bool TraceAlone(StageKernels* kernels, SceneBuffers* buffers, const WaveTracer& tracer,
                    std::uint32_t numPaths, const std::function<bool()>& trace);

    /// Adds the samples of the wave, which has been traced in the whole scene since, to the film.
    void Add(StageKernels* kernels, const shared::HdsWave& wave, const WaveTracer& tracer,
             const Buffer& pixels, const FilmBuffers& film) const;

private:
    std::shared_ptr<Device> _device;
    Buffer _alone; ///< float4 a path
};

} // namespace hds
