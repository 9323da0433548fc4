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

KeptArrays KeptArraysOf(const GeometryPrim& prim) {
    return {prim.geometry ? KeptBytes(*prim.geometry) : 0, KeptBytes(prim.placement)};
}

KeptArrays KeptArraysOf(const InstancerPrim& prim) {
    return {0, KeptBytes(prim)};
}

} // namespace hds
