// SPDX-License-Identifier: Apache-2.0
// Volumes whose coefficients are sums of products of fields: which grids they read, and between
// which values the sums are in each cell. Explained in docs/volumes.md.
#pragma once

#include "hdStream/scene/volumeMaterial.h"
#include "hdStream/shading/displacementNetwork.h"
#include "hdStream/volume/gridPreparer.h"
#include "hdStream/volume/gridTiles.h"
#include "kernels/shared/volume.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// A pattern of a volume: its program for kernels, and the same in steps for bounds.
struct PlannedPattern {
    std::vector<std::uint32_t> program;
    DisplacementNetwork network;
    std::vector<std::uint32_t> fields; ///< of the plan, by the network's primvars
};

/// A factor of terms.
struct PlannedField {
    PreparedGrids grids; ///< one, or those of red, green and blue; none: it is a pattern
    std::optional<PlannedPattern> pattern;
};

/// The terms of a volume, and their factors.
struct TermPlan {
    std::vector<shared::HdsVolumeTerm> terms; ///< those with extinction or scattering first
    std::uint32_t numMedium = 0;              ///< of these
    std::vector<PlannedField> fields;
    std::size_t lattice = 0; ///< the field whose voxels the cells are laid along
    glm::dvec3 least{0.0};   ///< box of the lattice that holds all fields
    glm::dvec3 most{0.0};

    /// \pre there is a grid.
    const GridDescription& Lattice() const { return fields[lattice].grids[0]->description; }
};

/// \param find gives the grids of a field, or nothing, with a warning: its terms are left out then,
/// and patterns have their defaults in its place. \param images of patterns. \param warn gets a
/// line for what is left out. \return without fields where nothing has a grid.
TermPlan PlanTerms(const VolumeMaterial& material,
                   const std::function<PreparedGrids(const std::string&)>& find,
                   ImageLibrary* images, const std::function<void(const std::string&)>& warn);

/// Makes a box of the lattice hold a grid too.
void ExtendBox(const GridDescription& grid, const GridDescription& lattice, glm::dvec3* least,
               glm::dvec3* most);

/// Cells along the voxels of a plan's lattice, without voxels.
struct TermBounds {
    /// Greatest and least channel of the extinction, and the mean of the channels as the value.
    GridDescription extinction;
    GridTiles emission; ///< greatest channel; without tiles where nothing glows
};

/// Whether a box of the lattice is small enough for cells of its own.
bool MayBound(glm::dvec3 least, glm::dvec3 most);

/// \pre MayBound of the plan's box.
TermBounds BoundTerms(const TermPlan& plan);

} // namespace hds
