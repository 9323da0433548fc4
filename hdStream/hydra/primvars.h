// SPDX-License-Identifier: Apache-2.0
// Primvars of a prim as the core's, computed ones (skinning) included.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/base/tf/token.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/types.h>
#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>

#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Brings points and primvars up to date: pulls those that are dirty, keeps the others, drops what
/// the prim has no longer. Thread-safe during Sync, as is all of a scene delegate.
/// \param pointsName the primvar that has the points.
void HdStreamSyncPrimvars(HdSceneDelegate* delegate, const SdfPath& id, const TfToken& pointsName,
                          HdDirtyBits dirtyBits, hds::SharedSpan<float>* points,
                          std::vector<hds::Primvar>* primvars);

/// Attributes of motion blur that UsdImaging lists as primvars, and what only skinning reads.
bool HdStreamIsSkippedPrimvar(const TfToken& name);

/// True when two lists hold the same primvars in the same order.
bool HdStreamEqual(const std::vector<hds::Primvar>& a, const std::vector<hds::Primvar>& b);

PXR_NAMESPACE_CLOSE_SCOPE
