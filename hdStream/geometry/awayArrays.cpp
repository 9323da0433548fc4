// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/awayArrays.h"

#include "hdStream/base/forEachArray.h"

namespace hds {

std::shared_ptr<const GeometryDescription>
Held(const std::shared_ptr<const GeometryDescription>& geometry) {
    if (AwayBytes(*geometry) == 0) {
        return geometry;
    }
    auto held = std::make_shared<GeometryDescription>(*geometry);
    ForEachArray(*held, [](auto& array) { array = array.Held(); });
    return held;
}

Primvar Held(const Primvar& primvar) {
    Primvar held = primvar;
    ForEachArray(held, [](auto& array) { array = array.Held(); });
    return held;
}

void DropArrays(const GeometryDescription& geometry) {
    ForEachArray(geometry, [](const auto& array) {
        if (array.Source() != nullptr) {
            array.Source()->Drop();
        }
    });
}

std::uint64_t AwayBytes(const GeometryDescription& geometry) {
    std::uint64_t bytes = 0;
    ForEachArray(geometry, [&bytes](const auto& array) {
        bytes += array.Source() != nullptr ? array.Source()->Bytes() : 0;
    });
    return bytes;
}

} // namespace hds
