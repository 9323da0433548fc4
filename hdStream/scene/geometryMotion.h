// SPDX-License-Identifier: Apache-2.0
// Points of meshes, curves and points while the shutter is open. Explained in docs/motionBlur.md.
#pragma once

#include "hdStream/scene/sceneDescription.h"

#include <memory>

namespace hds {

/// Whether the points differ when the shutter opens and when it closes.
bool Deforms(const GeometryDescription& geometry, const Shutter& shutter);

/// The geometry with its points when the shutter opens, and closePoints. \pre it deforms.
std::shared_ptr<const GeometryDescription> AtShutter(const GeometryDescription& geometry,
                                                     const Shutter& shutter);

} // namespace hds
