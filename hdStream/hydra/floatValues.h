// SPDX-License-Identifier: Apache-2.0
// Values of any numeric Vt type as rows of floats, the core's form of primvars and points.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/base/vt/value.h>
#include <pxr/pxr.h>

#include <cstdint>
#include <optional>

PXR_NAMESPACE_OPEN_SCOPE

/// Rows of 1 to 4 floats.
struct HdStreamFloatRows {
    hds::SharedSpan<float> values; ///< [count][numComponents]
    std::uint32_t numComponents = 1;
};

/// The rows of an array or of a single value; none when it is empty or no tuple of 1 to 4 numbers
/// (strings, matrices). Arrays of floats and of vectors of floats are shared; all others, integers
/// and booleans too, are converted. Thread-safe.
std::optional<HdStreamFloatRows> HdStreamGetFloatRows(const VtValue& value);

PXR_NAMESPACE_CLOSE_SCOPE
