// SPDX-License-Identifier: Apache-2.0
// The render's camera as dicing sees it.
#pragma once

#include "hdStream/integrator/renderOptions.h"
#include "hdStream/scene/dicingViews.h"

namespace hds {

/// Camera, conformed film and image size, to be recorded when the scene is diced.
DicingCamera MakeDicingCamera(const RenderOptions& options);

} // namespace hds
