// SPDX-License-Identifier: Apache-2.0
// Vt and Gf values as the core's: arrays are shared, never copied, where their items are of the
// same type. Thread-safe.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/base/gf/matrix4d.h>
#include <pxr/base/vt/array.h>
#include <pxr/pxr.h>

#include <glm/mat4x4.hpp>

#include <algorithm>
#include <cstring>
#include <memory>

PXR_NAMESPACE_OPEN_SCOPE

/// The items of an array (vectors, quaternions: their components) as a span that keeps the array
/// alive. `Item` is what the array's items are made of.
template <typename Item, typename Value>
hds::SharedSpan<Item> HdStreamShareArray(const VtArray<Value>& array) {
    static_assert(sizeof(Value) % sizeof(Item) == 0, "items are made of components");
    if (array.empty()) {
        return {};
    }
    auto held = std::make_shared<const VtArray<Value>>(array);
    const auto* items = reinterpret_cast<const Item*>(held->cdata());
    const std::size_t count = held->size() * (sizeof(Value) / sizeof(Item));
    return {items, count, std::move(held)};
}

/// True when two spans hold the same values.
template <typename Item>
bool HdStreamEqual(const hds::SharedSpan<Item>& a, const hds::SharedSpan<Item>& b) {
    return a.size() == b.size() &&
           (a.data() == b.data() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Item)) == 0);
}

/// Row vectors times GfMatrix4d is glm::dmat4 times column vectors: the memory is the same.
inline glm::dmat4 HdStreamToGlm(const GfMatrix4d& matrix) {
    glm::dmat4 result(1.0);
    static_assert(sizeof(result) == 16 * sizeof(double));
    std::copy_n(matrix.GetArray(), 16, &result[0][0]);
    return result;
}

PXR_NAMESPACE_CLOSE_SCOPE
