// SPDX-License-Identifier: Apache-2.0
// Material networks of Hydra as the core's. Names and types are converted, nothing is interpreted.
#pragma once

#include "hdStream/shading/materialNetwork.h"

#include <pxr/base/vt/value.h>
#include <pxr/imaging/hd/material.h>
#include <pxr/pxr.h>

#include <optional>

PXR_NAMESPACE_OPEN_SCOPE

/// A parameter's value: boolean, integer, number, text, asset, or the components of vectors,
/// matrices and arrays as floats; none for other types. Thread-safe.
std::optional<hds::ParameterValue> HdStreamParameterFrom(const VtValue& value);

/// The network of a material. Node paths are absolute. Thread-safe.
hds::MaterialNetwork HdStreamMaterialNetworkFrom(const SdfPath& materialId,
                                                 const HdMaterialNetworkMap& map);

PXR_NAMESPACE_CLOSE_SCOPE
