// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/awayArrays.h"

namespace hds {

namespace {

template <typename T>
struct IsSpan : std::false_type {};
template <typename T>
struct IsSpan<SharedSpan<T>> : std::true_type {};

template <typename T>
struct IsVector : std::false_type {};
template <typename T>
struct IsVector<std::vector<T>> : std::true_type {};

/// Calls `function` with each array of an object that lists its members, wherever it lies in it.
template <typename T, typename Function>
void ForEachArray(T& object, const Function& function) {
    using Plain = std::remove_const_t<T>;
    if constexpr (IsSpan<Plain>::value) {
        function(object);
    } else if constexpr (IsVector<Plain>::value) {
        for (auto& item : object) {
            ForEachArray(item, function);
        }
    } else if constexpr (kHasFields<Plain>) {
        ForEachField<Plain>(
            [&](const auto& field) { ForEachArray(object.*field.member, function); });
    }
}

} // namespace

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
