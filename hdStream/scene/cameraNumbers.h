// SPDX-License-Identifier: Apache-2.0
// Numbers of a camera that no picture can be made with. Explained in docs/cameras.md.
#pragma once

#include "hdStream/scene/sceneDescription.h"

#include <string>
#include <vector>

namespace hds {

/// Makes numbers of a camera usable: what is not finite becomes UsdGeomCamera's fallback, as do
/// both apertures where one is not above 0. A focal length of 0 becomes one scene unit without a
/// lens, which is the frustum that OpenUSD has for it (GfCamera::GetFrustum).
/// \return what was wrong, a line each; also where no place lies between the clipping planes.
std::vector<std::string> MendCamera(CameraPrim* camera);

} // namespace hds
