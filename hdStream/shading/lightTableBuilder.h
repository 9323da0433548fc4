// SPDX-License-Identifier: Apache-2.0
// What BuildLightTable builds with. Of layer shading alone. Explained in docs/lights.md.
#pragma once

#include "hdStream/shading/lightTable.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cstring>

namespace hds {

constexpr double kLightPi = 3.14159265358979323846;

/// A light that shines alike in all directions on everything.
shared::HdsLight PlainLight();

/// What floats can sum over lights, areas and bounces.
bool IsUsableRadiance(const glm::dvec3& radiance);

/// Emission after `normalize`, 0 where it is negative; for delta lights the intensity (sphere) or
/// irradiance (distant). \param light the record: its area, and whether it is a point.
glm::dvec3 RadianceOf(const LightDescription& description, const shared::HdsLight& light);

/// Whether a light's shadows are those of geometry.
bool IsShadowPlain(const LightShadow& shadow);

/// What a light sends out in all, for choices among lights: at infinity the irradiance at normal
/// incidence, of points 4 pi times the intensity. Images, shaping and filters aside.
double PowerOf(const LightDescription& light, bool isPoint, const glm::dvec3& radiance,
               double area);

/// Writes what a light emits. \param power of PowerOf, with images, shaping and filters.
void SetEmission(const glm::dvec3& radiance, double power, shared::HdsLight* light);

inline double Luminance(const glm::dvec3& rgb) {
    return glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// Grows the tables light by light. Lights are in lightTable.cpp, meshes in lightTableMeshes.cpp,
/// lights that change over the shutter in lightTableCells.cpp.
class LightTableBuilder {
public:
    LightTableBuilder(const LightTableInput& input, Warnings& warnings)
        : _input(input), _warnings(warnings) {
        AddLinks();
    }

    void AddLight(const PlacedLight& placed);
    void AddMesh(const EmissiveMesh& mesh);
    LightTable Finish();

private:
    std::uint32_t GroupOf(const PlacedLight& placed);
    bool Radiance(const PlacedLight& placed, const shared::HdsLight& light, glm::dvec3* radiance);
    bool AddImage(const PlacedLight& placed, shared::HdsLight* light, double* meanLuminance);
    std::uint32_t LinkOf(std::uint32_t category) const {
        return category == HDS_NONE ? HDS_NONE : _linkBases[category];
    }
    bool IsSampledAlone(const PlacedLight& placed) const {
        return !IsShadowPlain(placed.light.shadow) || LinkOf(placed.shadowLink) != HDS_NONE;
    }
    void AddLinks();
    void AddShaping(const PlacedLight& placed, shared::HdsLight* light, double* power);
    void AddControls(const PlacedLight& placed, double basePower, shared::HdsLight* light,
                     double* power);
    void AddCells(const PlacedLight& placed, double factor, shared::HdsLight* light, double* power,
                  shared::HdsLightControls* controls);
    void TurnShaping(const PlacedLight& placed, const LightCell& cell, shared::HdsLight* record);
    void AddFilters(const PlacedLight& placed, shared::HdsLightControls* controls, double* power);
    void AddKeys(const std::vector<LightKey>& lightKeys, shared::HdsLightControls* controls);
    void AppendControls(const shared::HdsLightControls& controls, shared::HdsLight* light);
    void AddMeshMotion(const EmissiveMesh& mesh, const EmissiveClusters& all,
                       const EmissiveCluster& cluster, std::uint32_t matrixBase,
                       shared::HdsLight* light);
    void AddPortals(const PlacedLight& placed, shared::HdsLight* light);
    void WarnIgnored(const PlacedLight& placed);
    void Push(shared::HdsLight light, const glm::dvec3& radiance, double power);
    bool MeshRadiance(const EmissiveMesh& mesh, glm::dvec3* radiance);
    shared::HdsLight BeginMesh(const EmissiveMesh& mesh, bool isWeighed, double* factor);
    void AddTriangle(const EmissiveMesh& mesh, const EmissiveTriangle& triangle);
    void AddCluster(const EmissiveMesh& mesh, const EmissiveClusters& all,
                    const EmissiveCluster& cluster, shared::HdsLight light,
                    const glm::dvec3& radiance, double factor, std::uint32_t matrixBase);
    void AddMeshTable(std::uint32_t firstLight, std::uint32_t firstTriangle, bool isOneLight);
    std::uint32_t BitsAt(std::uint32_t word) const {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &_table.cdf[word], sizeof(bits));
        return bits;
    }

    const LightTableInput& _input;
    Warnings& _warnings;
    std::vector<std::uint32_t> _linkBases; ///< of each category
    LightTable _table;
};

} // namespace hds
