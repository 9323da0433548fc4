// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/firstHits.h"

#include <algorithm>

namespace hds {

bool TraceFirstHits(const std::shared_ptr<Device>& device, const FirstHitPicture& picture,
                    StageKernels* kernels, WaveTracer* tracer, FilmBuffers* film,
                    const std::function<bool()>& goesOn,
                    const WaveTracer::IsCancelled& isCancelled) {
    const Shutter& shutter = picture.options->shutter;
    const shared::HdsAovOffsets offsets = film->FirstHitOffsets(
        picture.scene->centre, shutter.IsOpen() ? shutter.close - shutter.open : 0.0);
    const Buffer primvarSlots = UploadVector(
        device, "primvar slots", FindSlots(*picture.scene, picture.options->aovs.primvars));
    const Buffer& paths = tracer->Paths();
    const std::uint32_t numSlots = tracer->NumSlots();
    const std::uint32_t maxPaths = tracer->MaxPaths();
    for (std::uint32_t firstPixel = 0; firstPixel < picture.numPixels; firstPixel += maxPaths) {
        if (firstPixel > 0 && !goesOn()) {
            return false;
        }
        const std::uint32_t numPixels = std::min(maxPaths, picture.numPixels - firstPixel);
        const shared::HdsWave wave{firstPixel, numPixels, 0, 1};
        const bool isTraced = tracer->Trace(
            numPixels,
            [&](std::uint32_t first, std::uint32_t count, const Buffer& queue,
                std::uint32_t queueFirst) {
                kernels->generateCentre.Launch(count, *picture.frame, wave, first, count, paths,
                                               numSlots, *picture.order, queue, queueFirst);
            },
            [&](const Buffer& queue, std::uint32_t count, const Buffer& waiting,
                const Buffer& next) {
                kernels->aov.Launch(count, *picture.frame, paths, numSlots, queue, count, waiting,
                                    next, tracer->Counters(), film->Floats(), film->Ints(), offsets,
                                    primvarSlots);
            },
            isCancelled);
        if (!isTraced) {
            return false;
        }
    }
    film->SetHasFirstHits();
    return true;
}

} // namespace hds
