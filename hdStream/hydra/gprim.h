// SPDX-License-Identifier: Apache-2.0
// What meshes, curves and points of Hydra have in common on their way into the core.
#pragma once

#include "hdStream/hydra/geometryVariants.h"
#include "hdStream/session/session.h"

#include <pxr/base/tf/token.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// The purpose of a render tag.
std::string HdStreamPurpose(const TfToken& renderTag);

/// Comparing costs a pass over memory; preparing the same geometry again costs far more.
bool HdStreamEqual(const hds::GeometryDescription& a, const hds::GeometryDescription& b);

/// Bits are set for more than has changed: with display styles, reprs, and refine levels too.
bool HdStreamEqual(const hds::GeometryPrim& a, const hds::GeometryPrim& b);

/// Splits a prim by the primvars of its instances. \return true when that changed anything.
bool HdStreamSyncVariants(HdSceneDelegate* delegate, const SdfPath& instancerId,
                          const std::string& scenePath, const hds::GeometryPrim& prim,
                          HdStreamRenderParam* param, HdStreamGeometryVariants* variants);

/// Reads where a prim is, and reserves its path in the scene (HdStreamReservePath).
/// \return true when the prim had another path
bool HdStreamSyncPlacement(HdSceneDelegate* delegate, const SdfPath& id, const SdfPath& instancerId,
                           HdDirtyBits bits, HdStreamRenderParam* param, hds::Placement* placement,
                           std::string* scenePath, bool* isPathProvisional);

PXR_NAMESPACE_CLOSE_SCOPE
