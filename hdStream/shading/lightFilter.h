// SPDX-License-Identifier: Apache-2.0
// Light filters (UsdLuxLightFilter): the nodes that front ends hand over, and what kernels read
// (kernels/light/filter.clh). Names are those of RenderMan's filters and of UsdRi's schemas of
// them. Explained in docs/lights.md, "Filters".
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/lightDescription.h"
#include "kernels/shared/light.h"

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace hds {

/// A filter of a light as authored.
struct LightFilter {
    MaterialNode node; ///< its prim, its kind (PxrBarnLightFilter), and what is authored
    glm::dmat4 worldFromFilter{1.0};

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LightFilter, node), HDS_FIELD(LightFilter, worldFromFilter));
    }
};

/// An image of a filter in linear light, top row first.
struct FilterImage {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<float> rgb; ///< [height][width][3]
};

/// Reads an image that a filter names; null, after a warning, when it cannot be used. May be empty.
using LoadFilterImage = std::function<std::shared_ptr<const FilterImage>(const AssetReference&)>;

/// The names of all inputs that some kind of filter reads, for front ends that cannot list what is
/// authored. Thread-safe.
const std::set<std::string>& LightFilterInputs();

/// The file of a filter's image; null: it has none.
const AssetReference* FilterImageFile(const LightFilter& filter);

/// Applies what filters do to the whole light, whatever the way of its light, to the description
/// (PxrIntMultLightFilter; the multipliers for lobes of all).
void ApplyFilterMultipliers(const std::vector<LightFilter>& filters, Warnings& warnings,
                            LightDescription* light);

/// Appends the other filters of a light to `data`, their records last and one behind the other.
/// Kinds and values that are not known give a warning that names the prim, and are left out.
/// \param filters their worldFromFilter relative to the scene centre
/// \param[out] peak bound on the luminance of the factor
/// \return their number
std::uint32_t AppendFilters(const std::vector<LightFilter>& filters, const LoadFilterImage& load,
                            Warnings& warnings, std::vector<float>* data, double* peak);

} // namespace hds
