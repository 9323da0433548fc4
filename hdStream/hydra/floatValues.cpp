// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/floatValues.h"

#include "hdStream/hydra/arrays.h"

#include <pxr/base/gf/half.h>
#include <pxr/base/gf/quatd.h>
#include <pxr/base/gf/quatf.h>
#include <pxr/base/gf/quath.h>
#include <pxr/base/gf/vec2d.h>
#include <pxr/base/gf/vec2f.h>
#include <pxr/base/gf/vec2h.h>
#include <pxr/base/gf/vec2i.h>
#include <pxr/base/gf/vec3d.h>
#include <pxr/base/gf/vec3f.h>
#include <pxr/base/gf/vec3h.h>
#include <pxr/base/gf/vec3i.h>
#include <pxr/base/gf/vec4d.h>
#include <pxr/base/gf/vec4f.h>
#include <pxr/base/gf/vec4h.h>
#include <pxr/base/gf/vec4i.h>
#include <pxr/base/vt/types.h>

#include <type_traits>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

using Rows = std::optional<HdStreamFloatRows>;

/// Rows of an array whose items consist of `Scalar`s.
template <typename Value, typename Scalar>
Rows RowsOfArray(const VtArray<Value>& array) {
    if (array.empty()) {
        return {};
    }
    HdStreamFloatRows rows;
    rows.numComponents = static_cast<std::uint32_t>(sizeof(Value) / sizeof(Scalar));
    if constexpr (std::is_same_v<Scalar, float>) {
        rows.values = HdStreamShareArray<float>(array);
    } else {
        const auto* scalars = reinterpret_cast<const Scalar*>(array.cdata());
        std::vector<float> values(array.size() * rows.numComponents);
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = static_cast<float>(scalars[i]);
        }
        rows.values = std::move(values);
    }
    return rows;
}

/// Tries an array of `Value` and a single one.
template <typename Value, typename Scalar>
bool Try(const VtValue& value, Rows* rows) {
    if (value.IsHolding<VtArray<Value>>()) {
        *rows = RowsOfArray<Value, Scalar>(value.UncheckedGet<VtArray<Value>>());
        return true;
    }
    if (value.IsHolding<Value>()) {
        *rows = RowsOfArray<Value, Scalar>(VtArray<Value>(1, value.UncheckedGet<Value>()));
        return true;
    }
    return false;
}

} // namespace

std::optional<HdStreamFloatRows> HdStreamGetFloatRows(const VtValue& value) {
    Rows rows;
    // The usual types first.
    (void)(Try<GfVec3f, float>(value, &rows) || Try<GfVec2f, float>(value, &rows) ||
           Try<float, float>(value, &rows) || Try<GfVec4f, float>(value, &rows) ||
           Try<int, int>(value, &rows) || Try<bool, bool>(value, &rows) ||
           Try<double, double>(value, &rows) || Try<GfHalf, GfHalf>(value, &rows) ||
           Try<GfVec2d, double>(value, &rows) || Try<GfVec3d, double>(value, &rows) ||
           Try<GfVec4d, double>(value, &rows) || Try<GfVec2h, GfHalf>(value, &rows) ||
           Try<GfVec3h, GfHalf>(value, &rows) || Try<GfVec4h, GfHalf>(value, &rows) ||
           Try<GfVec2i, int>(value, &rows) || Try<GfVec3i, int>(value, &rows) ||
           Try<GfVec4i, int>(value, &rows) || Try<GfQuatf, float>(value, &rows) ||
           Try<GfQuatd, double>(value, &rows) || Try<GfQuath, GfHalf>(value, &rows) ||
           Try<unsigned int, unsigned int>(value, &rows) ||
           Try<std::int64_t, std::int64_t>(value, &rows) ||
           Try<std::uint64_t, std::uint64_t>(value, &rows) ||
           Try<unsigned char, unsigned char>(value, &rows));
    return rows;
}

PXR_NAMESPACE_CLOSE_SCOPE
