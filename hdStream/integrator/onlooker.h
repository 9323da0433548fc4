// SPDX-License-Identifier: Apache-2.0
// Private to the path tracer.
#pragma once

#include "hdStream/base/timer.h"
#include "hdStream/integrator/makeResident.h"
#include "hdStream/integrator/renderOptions.h"

namespace hds {

/// Who looks on while a render runs, and whether it is to end.
struct Onlooker {
    const ProgressCallback& onProgress;
    const RenderWatch& watch;
    Timer timer; ///< since rendering began
    bool isStopped = false;
    TracingRate rate = {};
    std::uint64_t judgedUploads = 0; ///< pages loaded when residency was last thought about
    std::uint64_t streamedPaths = 0; ///< when all pixels last had as many samples
};

} // namespace hds
