// SPDX-License-Identifier: Apache-2.0
// Transparent BSDFs in Mix Shaders, as Blender's exporter hands them over: as opacity of the
// surface, and as white diffuse BSDFs in the mixes.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

/// The opacity of the surface becomes what mixes cover; the exporter forgets the sides that are
/// neither Principled nor Transparent BSDFs. Below it other sides than transparent ones are left:
/// each mix gets the shares that they have of what it covers, of reflection and of emission.
void HdStreamTakeTransparentOut(hds::MaterialNetwork* network);

PXR_NAMESPACE_CLOSE_SCOPE
