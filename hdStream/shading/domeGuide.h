// SPDX-License-Identifier: Apache-2.0
// The guide of domes without images (kernels/light/domeGuide.clh): the distributions of directions
// that it is made of. Explained in docs/lights.md, "Guided domes".
#pragma once

#include "hdStream/shading/lightTable.h"

#include <array>
#include <cstdint>
#include <vector>

namespace hds {

/// Whether a light is a dome that may have a guide: without image, portals, shaping and controls,
/// and found by BSDF samples too.
bool MayHaveGuide(const shared::HdsLight& light);
bool MayHaveGuide(const LightTable& lights);

/// The words that follow lightCdf, of HdsLight::cdfBase. Places that few rays left have none.
/// \param camera relative to the scene centre. \param cells of HDS_GUIDE_CELLS. \param base where
/// the words will be in lightCdf. \return empty where no place has one.
std::vector<float> BuildDomeGuide(const std::array<float, 3>& camera,
                                  const std::vector<std::uint32_t>& cells, std::uint32_t base);

} // namespace hds
