// SPDX-License-Identifier: Apache-2.0
// Assets as (file, offset, size), resolved while syncing so that the core needs no resolver.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/pxr.h>
#include <pxr/usd/sdf/assetPath.h>

PXR_NAMESPACE_OPEN_SCOPE

/// The reference of an asset path; its `file` is empty when it could not be resolved. A file inside
/// a package (usdz) is a byte range of the package. Thread-safe.
hds::AssetReference HdStreamAssetReference(const SdfAssetPath& asset);

PXR_NAMESPACE_CLOSE_SCOPE
