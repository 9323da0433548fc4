// SPDX-License-Identifier: Apache-2.0
// The shaping of a light as kernels read it (kernels/light/shaping.clh).
// Explained in docs/lights.md.
#pragma once

#include "hdStream/shading/iesProfile.h"
#include "hdStream/shading/lightDescription.h"
#include "kernels/shared/light.h"

#include <glm/mat4x4.hpp>

#include <vector>

namespace hds {

/// Appends the record of a light's shaping to `data`, and its profile before it.
/// \param profile of the light's IES file; null: none
/// \return the record as appended; profileBase is an index into data
shared::HdsLightShaping AppendShaping(const LightDescription& light,
                                      const glm::dmat4& worldFromLight, const IesProfile* profile,
                                      std::vector<float>* data);

} // namespace hds
