// SPDX-License-Identifier: Apache-2.0
// The transforms of an instancer's instances from the parts that Hydra keeps them in.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/base/gf/rotation.h>
#include <pxr/base/vt/array.h>
#include <pxr/base/vt/value.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// Instance transforms [count][16], memory as GfMatrix4d: transforms, then scales, rotations and
/// translations, of this level only. Parts that are empty are the identity; an array that is
/// shorter than the longest one is the identity beyond its end. Matrices alone are shared.
/// \param turns to follow the rotations.
hds::SharedSpan<double> HdStreamInstanceTransforms(const VtValue& translations,
                                                   const VtValue& rotations, const VtValue& scales,
                                                   const VtValue& transforms,
                                                   const VtArray<GfRotation>& turns = {});

PXR_NAMESPACE_CLOSE_SCOPE
