// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/keptArrays.h"

#include "hdStream/base/forEachArray.h"

namespace hds {

namespace {

template <typename T>
std::uint64_t KeptBytes(const T& object) {
    std::uint64_t bytes = 0;
    ForEachArray(object, [&bytes](const auto& array) {
        bytes += array.Source() == nullptr ? array.size() * sizeof(array[0]) : 0;
    });
    return bytes;
}

} // namespace

KeptArrays CountKeptArrays(const SceneDescription& scene) {
    KeptArrays kept;
    for (const auto& [path, prim] : scene.geometry) {
        kept.geometryBytes += prim.geometry ? KeptBytes(*prim.geometry) : 0;
        kept.instanceBytes += KeptBytes(prim.placement);
    }
    for (const auto& [path, prim] : scene.instancers) {
        kept.instanceBytes += KeptBytes(prim);
    }
    return kept;
}

} // namespace hds
