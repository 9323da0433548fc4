// SPDX-License-Identifier: Apache-2.0
// Volumes whose coefficients are sums of products of fields: which grids they read, and between
// which values the sums are in each cell. Explained in docs/volumes.md.
#pragma once

#include "hdStream/shading/volumeShader.h"
#include "hdStream/volume/gridPreparer.h"
#include "hdStream/volume/gridTiles.h"
#include "kernels/shared/volume.h"

#include <functional>
#include <string>
#include <vector>

namespace hds {

/// The terms of a volume, and the grids of their factors.
struct TermPlan {
    std::vector<shared::HdsVolumeTerm> terms; ///< those with extinction or scattering first
    std::uint32_t numMedium = 0;              ///< of these
    std::vector<PreparedGrids> fields;        ///< one grid each, or those of red, green and blue
    std::size_t lattice = 0;                  ///< the field whose voxels the cells are laid along
};

/// \param find gives the grids of a field, or nothing, with a warning: its terms are left out then.
/// \param warn gets a line where there are more terms or fields than there may be.
TermPlan PlanTerms(const VolumeShading& shading,
                   const std::function<PreparedGrids(const std::string&)>& find,
                   const std::function<void(const std::string&)>& warn);

/// Cells along the voxels of a plan's lattice, without voxels.
struct TermBounds {
    /// Greatest and least channel of the extinction, and the mean of the channels as the value.
    GridDescription extinction;
    GridTiles emission; ///< greatest channel; without tiles where nothing glows
};

/// Whether a box of the lattice is small enough for cells of its own.
bool MayBound(glm::dvec3 least, glm::dvec3 most);

/// \param least, most a box of the lattice that holds all fields. \pre MayBound.
TermBounds BoundTerms(const TermPlan& plan, glm::dvec3 least, glm::dvec3 most);

} // namespace hds
