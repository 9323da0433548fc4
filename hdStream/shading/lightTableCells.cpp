// SPDX-License-Identifier: Apache-2.0
// Lights whose size or emission changes over the shutter, in the tables of kernels/light: a record
// for each of equal parts of the interval. Explained in docs/lights.md, "Moving lights".
#include "hdStream/shading/lightPlacement.h"
#include "hdStream/shading/lightShaping.h"
#include "hdStream/shading/lightTableBuilder.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstring>

namespace hds {

/// The shaping of a cell: the light's, along the cell's axes.
void LightTableBuilder::TurnShaping(const PlacedLight& placed, const LightCell& cell,
                                    shared::HdsLight* record) {
    shared::HdsLightShaping all;
    std::memcpy(&all, &_table.cdf[record->shapingBase], sizeof(all));
    shared::HdsLightShaping own =
        AppendShaping(placed.light, cell.worldFromLight, nullptr, &_table.cdf);
    std::copy(own.axis, own.axis + 3, all.axis);
    std::copy(own.side, own.side + 3, all.side);
    std::copy(own.up, own.up + 3, all.up);
    record->shapingBase = std::uint32_t(_table.cdf.size() - sizeof(all) / sizeof(_table.cdf[0]));
    std::memcpy(&_table.cdf[record->shapingBase], &all, sizeof(all));
}

/// \param factor on PowerOf, by image, shaping and filters. \param[in,out] light gets a bound of
/// all cells. \param[in,out] power becomes their mean.
void LightTableBuilder::AddCells(const PlacedLight& placed, double factor, shared::HdsLight* light,
                                 double* power, shared::HdsLightControls* controls) {
    const bool isPoint = (light->flags & HDS_LIGHT_POINT) != 0;
    const glm::dvec3 center(light->center[0], light->center[1], light->center[2]);
    std::vector<shared::HdsLight> records;
    double sum = 0.0;
    bool hasUnusable = false;
    for (const LightCell& cell : placed.cells) {
        shared::HdsLight record = *light;
        glm::dvec3 radiance(0.0); // what has no size for a while is dark then
        if (PlaceLight(cell.light, cell.worldFromLight, &record)) {
            radiance = RadianceOf(cell.light, record);
            if (!IsUsableRadiance(radiance)) {
                radiance = glm::dvec3(0.0);
                hasUnusable = true;
            }
            if (record.shapingBase != HDS_NONE && cell.worldFromLight != placed.worldFromLight) {
                TurnShaping(placed, cell, &record);
            }
        } else {
            record = *light;
        }
        const double cellPower = factor * PowerOf(cell.light, isPoint, radiance, record.area);
        SetEmission(radiance, cellPower, &record);
        sum += cellPower;
        records.push_back(record);
    }
    if (hasUnusable) {
        _warnings.Add(placed.name, "light's emission is no number up to 1e30 for a part of the "
                                   "shutter's interval; dark then");
    }
    double bound = light->boundRadius;
    for (const shared::HdsLight& record : records) {
        const glm::dvec3 own(record.center[0], record.center[1], record.center[2]);
        bound = std::max(bound, record.boundRadius + glm::length(own - center) * (1.0 + 1e-5));
    }
    light->boundRadius = light->boundRadius >= HDS_LIGHT_FAR ? HDS_LIGHT_FAR : float(bound);
    *power = sum / double(records.size());
    controls->cellBase = std::uint32_t(_table.cdf.size());
    controls->numCells = std::uint32_t(records.size());
    const std::size_t bytes = records.size() * sizeof(records[0]);
    _table.cdf.resize(_table.cdf.size() + bytes / sizeof(_table.cdf[0]));
    std::memcpy(&_table.cdf[controls->cellBase], records.data(), bytes);
    _table.numCells += records.size();
    _table.hasMotion = true;
}

} // namespace hds
