// SPDX-License-Identifier: Apache-2.0
// How shadow rays are launched. Explained in docs/wavefront.md, section "Cut-outs".
#pragma once

#include "hdStream/integrator/kernelFeatures.h"
#include "kernels/shared/launchConditions.h"

namespace hds {

/// Whether there is no launch for what shadow rays pass: they do so where they are cast.
inline bool PassesShadowsAtOnce(const KernelFeatures& features) {
    const bool HDS_FEATURE_CUTOUT = features.cutouts;
    const bool HDS_FEATURE_STREAMING = features.streaming;
    const bool HDS_FEATURE_TEXTURE_STREAMING = features.textureStreaming;
    return HDS_PASSES_SHADOWS_AT_ONCE;
}

} // namespace hds
