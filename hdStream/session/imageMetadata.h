// SPDX-License-Identifier: Apache-2.0
// What image files say of the camera and the data window of a render. Explained in docs/film.md.
#pragma once

#include "hdStream/film/imageWriter.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/session/settings.h"

namespace hds {

/// Samples, camera, its matrices and the windows of a render with these settings. The matrices are
/// those of the display window as it is rendered: fitted by the conform policy, at the frame's own
/// time. worldToNdc goes from -1 to 1 in all of it, x to the right and y up, and from the near to
/// the far plane (OpenGL's normalised device coordinates, as GfFrustum).
ImageMetadata MakeImageMetadata(const Settings& settings, const CameraPrim& camera);

} // namespace hds
