// SPDX-License-Identifier: Apache-2.0
// The guide of domes (kernels/light/domeGuide.clh): the distributions of directions
// that it is made of. Explained in docs/lights.md, "Guided domes".
#pragma once

#include "hdStream/shading/lightTable.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hds {

/// Whether a light is a dome that may have a guide: without portals, shaping and controls, and
/// found by BSDF samples too.
bool MayHaveGuide(const shared::HdsLight& light);
bool MayHaveGuide(const LightTable& lights);

/// A number for each cell of directions.
using DomeCells = std::array<double, std::size_t{HDS_GUIDE_COLUMNS} * HDS_GUIDE_ROWS>;

/// What a dome's image shows in each cell on average, against the mean of all.
struct DomeLight {
    DomeCells sky;         ///< without what is very bright; a little where it is dark
    DomeCells sun{};       ///< that
    bool hasImage = false; ///< else all of the sky is alike
};

/// \param cdf lightCdf.
DomeLight LightOfCells(const shared::HdsLight& light, const std::vector<float>& cdf);

/// The words of a dome's guide (HdsLight::params). Places that few rays left have none.
/// \param camera relative to the scene centre. \param cells of HDS_GUIDE_CELLS. \param light
/// LightOfCells. \param base where the words will be in lightCdf. \return empty where no place has
/// one.
std::vector<float> BuildDomeGuide(const std::array<float, 3>& camera,
                                  const std::vector<std::uint32_t>& cells, const DomeLight& light,
                                  std::uint32_t base);

} // namespace hds
