// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/catcherLight.h"

namespace hds {

bool CatcherLight::TraceAlone(StageKernels* kernels, SceneBuffers* buffers,
                              const WaveTracer& tracer, std::uint32_t numPaths,
                              const std::function<bool()>& trace) {
    const std::uint64_t bytes = std::uint64_t{tracer.MaxPaths()} * 4 * sizeof(float);
    if (!_alone.IsValid() || _alone.Bytes() < bytes) {
        _alone = Buffer(); // frees first
        _alone = Buffer(_device, "light of catchers alone", bytes);
    }
    buffers->ShowCatchersAlone(true);
    kernels->Bind(*buffers);
    const bool isTraced = trace();
    buffers->ShowCatchersAlone(false);
    kernels->Bind(*buffers);
    if (isTraced) {
        kernels->keepSamples.Launch(numPaths, tracer.Sums(), tracer.NumSlots(), numPaths, _alone);
    }
    return isTraced;
}

void CatcherLight::Add(StageKernels* kernels, const shared::HdsWave& wave, const WaveTracer& tracer,
                       const Buffer& pixels, const FilmBuffers& film) const {
    kernels->addCatchers.Launch(wave.numPixels, wave, tracer.Sums(), tracer.NumSlots(), _alone,
                                pixels, film.Film(), film.LightPaths(),
                                film.NumLightPaths() * film.NumPixels(), film.NumPixels());
}

} // namespace hds
