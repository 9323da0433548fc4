// SPDX-License-Identifier: Apache-2.0
// What of meshes, curves and points changes while the shutter is open. Explained in
// docs/motionBlur.md.
#pragma once

#include "hdStream/scene/sceneDescription.h"

#include <memory>

namespace hds {

/// Whether points, widths, normals or shapes change while the shutter is open.
bool Deforms(const GeometryDescription& geometry, const Shutter& shutter);

/// The geometry when the shutter opens, with keys: as few as hold all samples to within a small
/// part of the way that the furthest value goes, at most HDS_MAX_DEFORMATION_SEGMENTS. \pre it
/// deforms.
std::shared_ptr<const GeometryDescription> AtShutter(const GeometryDescription& geometry,
                                                     const Shutter& shutter);

} // namespace hds
