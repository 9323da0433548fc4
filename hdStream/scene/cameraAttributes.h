// SPDX-License-Identifier: Apache-2.0
// Attributes of cameras beside UsdGeomCamera's: OpenUSD's newer ones of exposure, those that hosts
// author for other renderers, and our own. Front ends hand them over by name; they are interpreted
// here. Explained in docs/cameras.md.
#pragma once

#include "hdStream/scene/sceneDescription.h"

#include <map>
#include <string>
#include <vector>

namespace hds {

using CameraAttributes = std::map<std::string, ParameterValue>;

/// The names that SetCameraAttributes reads, in the order in which they count: the last one wins.
std::vector<std::string> CameraAttributeNames();

/// The names that LinearExposureScale reads.
std::vector<std::string> ExposureAttributeNames();

/// Sets what attributes say of a camera's lens.
/// \return what is wrong with them, a line each; a value that is out of its range counts as the
/// nearest one in it.
std::vector<std::string> SetCameraAttributes(const CameraAttributes& attributes,
                                             CameraPrim* camera);

/// The factor on radiance, time * iso * 2^exposure * responsivity / (100 * fStop^2), with floats.
/// Source: UsdGeomCamera::ComputeLinearExposureScale (OpenUSD 25.05). \param exposure the attribute
/// `exposure`, in stops. \param attributes others of exposure; absent ones change nothing. It is
/// not finite where the formula is not, which MendCamera tells of.
float LinearExposureScale(float exposure, const CameraAttributes& attributes);

} // namespace hds
