// SPDX-License-Identifier: Apache-2.0
// The arrays of structs that list their members (fields.h): whatever array a struct gains is found.
#pragma once

#include "hdStream/base/apart.h"
#include "hdStream/base/fields.h"
#include "hdStream/base/sharedSpan.h"

#include <type_traits>
#include <vector>

namespace hds {

template <typename T>
struct IsSpanTrait : std::false_type {};
template <typename T>
struct IsSpanTrait<SharedSpan<T>> : std::true_type {};

template <typename T>
struct IsVectorTrait : std::false_type {};
template <typename T>
struct IsVectorTrait<std::vector<T>> : std::true_type {};

/// Calls `function` with each SharedSpan of an object that lists its members, and of the members of
/// these. What pointers point to is no part of it.
template <typename T, typename Function>
void ForEachArray(T& object, const Function& function) {
    using Plain = std::remove_const_t<T>;
    if constexpr (IsSpanTrait<Plain>::value) {
        function(object);
    } else if constexpr (IsVectorTrait<Plain>::value) {
        for (auto& item : object) {
            ForEachArray(item, function);
        }
    } else if constexpr (IsApartTrait<Plain>::value) {
        if (object.IsApart()) {
            if constexpr (std::is_const_v<T>) {
                ForEachArray(*object, function);
            } else {
                ForEachArray(object.Edit(), function);
            }
        }
    } else if constexpr (kHasFields<Plain>) {
        ForEachField<Plain>(
            [&](const auto& field) { ForEachArray(object.*field.member, function); });
    }
}

} // namespace hds
