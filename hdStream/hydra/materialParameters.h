// SPDX-License-Identifier: Apache-2.0
// Material networks of Hydra as the core's. Names and types are converted, nothing is interpreted.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/base/vt/value.h>
#include <pxr/imaging/hd/material.h>
#include <pxr/pxr.h>

#include <optional>

PXR_NAMESPACE_OPEN_SCOPE

/// A parameter's value: boolean, integer, number, text, asset, or the components of vectors,
/// matrices and arrays as floats; none for other types. Thread-safe.
std::optional<hds::ParameterValue> HdStreamParameterFrom(const VtValue& value);

/// The network of a material. Thread-safe.
/// \param scenePath the material's path in the scene, below which its nodes are named
/// \param materialId its id in Hydra
hds::MaterialNetwork HdStreamMaterialNetworkFrom(const SdfPath& scenePath,
                                                 const SdfPath& materialId,
                                                 const HdMaterialNetworkMap& map);

PXR_NAMESPACE_CLOSE_SCOPE
