// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/settings.h"

#include <tuple>

namespace hds {

namespace {

/// Every member, in the order of the struct.
auto Members(const Settings& s) {
    return std::tie(s.camera, s.imageWidth, s.imageHeight, s.pixelAspectRatio, s.displayWindow,
                    s.dataWindowMin, s.conformPolicy, s.aovs, s.purposes, s.cullStyle,
                    s.cameraMoves, s.domeVisible, s.samples, s.maxDepth, s.seed, s.timeLimit,
                    s.noise, s.pixelFilter, s.pixelFilterWidth, s.russianRoulette, s.motionBlur,
                    s.denoise, s.mipBias, s.subdivision, s.refineLevel, s.waveSize, s.device,
                    s.cacheDirectory, s.noCache, s.traversal, s.chunkBytes, s.residency,
                    s.geometryMemory, s.textureMemory, s.geometryEviction, s.request,
                    s.shadeIterations, s.plainTextures, s.hostMemory, s.prepare);
}

} // namespace

bool Settings::operator==(const Settings& other) const {
    return Members(*this) == Members(other);
}

} // namespace hds
