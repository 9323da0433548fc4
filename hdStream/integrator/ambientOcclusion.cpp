// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/ambientOcclusion.h"

namespace hds {

bool AmbientOcclusion::Trace(StageKernels* kernels, WaveTracer* tracer, std::uint32_t numPaths,
                             const Buffer& frame, float distance,
                             const WaveTracer::Generate& generate,
                             const WaveTracer::IsCancelled& isCancelled) {
    const std::uint64_t bytes = std::uint64_t{tracer->MaxPaths()} * 4 * sizeof(float);
    if (!_kept.IsValid() || _kept.Bytes() < bytes) {
        _kept = Buffer(); // frees first
        _kept = Buffer(_device, "ambient occlusion of paths", bytes);
    }
    const bool isTraced = tracer->Trace(
        numPaths, generate,
        [&](const Buffer& queue, std::uint32_t count, const Buffer& waiting, const Buffer& next) {
            kernels->occlusion.Launch(count, frame, tracer->Paths(), tracer->NumSlots(), queue,
                                      count, waiting, next, tracer->Counters(), distance);
        },
        isCancelled);
    if (isTraced) {
        kernels->keepSamples.Launch(numPaths, tracer->Sums(), tracer->NumSlots(), numPaths, _kept);
    }
    return isTraced;
}

void AmbientOcclusion::Add(StageKernels* kernels, const shared::HdsWave& wave, const Buffer& pixels,
                           const FilmBuffers& film) const {
    kernels->addOcclusion.Launch(wave.numPixels, wave, _kept, pixels, film.Film(),
                                 film.LightPaths(), film.OcclusionSum() * film.NumPixels());
}

} // namespace hds
