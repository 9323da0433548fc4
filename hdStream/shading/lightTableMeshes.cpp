// SPDX-License-Identifier: Apache-2.0
// Emissive meshes in the tables of kernels/light.
#include "hdStream/shading/lightTableBuilder.h"
#include "hdStream/shading/lightUnits.h"
#include "hdStream/shading/movingMesh.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace hds {

namespace {

/// Most of a mesh that moves: its turns between keys are not quite those of its triangles, and so
/// its estimate must not become 0.
constexpr float kMovingFlatness = 0.99F;

} // namespace

/// What a mesh emits where its material does not vary the emission; false: nothing.
bool LightTableBuilder::MeshRadiance(const EmissiveMesh& mesh, glm::dvec3* radiance) {
    if (mesh.lux && mesh.lux->light.normalize && !(mesh.wholeArea > 0.0)) {
        return false;
    }
    *radiance = glm::max(mesh.radiance, glm::dvec3(0.0));
    if (mesh.lux) {
        shared::HdsLight light{};
        light.area = float(mesh.wholeArea);
        glm::dvec3 factor;
        if (!Radiance(*mesh.lux, light, &factor)) {
            return false;
        }
        *radiance *= factor;
    }
    if (!IsUsableRadiance(*radiance)) {
        _warnings.Add(mesh.name, "emission is not finite or above 1e30; not sampled as a light");
        return false;
    }
    return Luminance(*radiance) > 0.0;
}

/// What all clusters of a mesh have in common.
shared::HdsLight LightTableBuilder::BeginMesh(const EmissiveMesh& mesh, bool isWeighed,
                                              double* factor) {
    shared::HdsLight light = PlainLight();
    light.type = HDS_LIGHT_MESH;
    light.dataSize[1] = HDS_NONE;
    light.flags = (mesh.twoSided ? HDS_LIGHT_TWO_SIDED : 0U) |
                  (mesh.hasTexturedEmission ? HDS_LIGHT_TEXTURED_EMISSION : 0U) |
                  (isWeighed || mesh.Moves() ? HDS_LIGHT_WEIGHED : 0U) |
                  (mesh.lux ? HDS_LIGHT_REPLACES : 0U);
    *factor = kLightPi * (mesh.twoSided ? 2.0 : 1.0);
    if (mesh.lux) {
        light.flags |= mesh.lux->light.visibleToCamera ? HDS_LIGHT_VISIBLE : 0U;
        light.flags |= GroupOf(*mesh.lux) << HDS_LIGHT_GROUP_SHIFT;
        AddShaping(*mesh.lux, &light, factor);
        AddControls(*mesh.lux, *factor, &light, factor);
    }
    _table.hasMeshes = true;
    _table.hasTexturedEmission = _table.hasTexturedEmission || mesh.hasTexturedEmission;
    return light;
}

void LightTableBuilder::AddTriangle(const EmissiveMesh& mesh, const EmissiveTriangle& triangle) {
    constexpr double kRounding = 8.0 / 16777216.0; ///< of the float positions and their use
    glm::dvec3 p[3];
    for (int i = 0; i < 3; ++i) {
        p[i] = mesh.Moves() ? glm::dvec3(mesh.shapes[0][triangle.source].p[i]) : triangle.p[i];
    }
    const glm::dvec3 e1 = p[1] - p[0];
    const glm::dvec3 e2 = p[2] - p[0];
    shared::HdsLightTriangle out{};
    double largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        out.p0[i] = float(p[0][i]);
        out.e1[i] = float(e1[i]);
        out.e2[i] = float(e2[i]);
        largest = std::max({largest, std::abs(triangle.p[0][i]), std::abs(triangle.p[1][i]),
                            std::abs(triangle.p[2][i])});
    }
    out.light = std::uint32_t(_table.lights.size());
    out.primId = triangle.primId;
    out.error = float(kRounding * largest + mesh.positionError);
    _table.triangles.push_back(out);
}

/// What is chosen by goes with its sphere; directions are bounds only where nothing bends.
void LightTableBuilder::AddMeshMotion(const EmissiveMesh& mesh, const EmissiveClusters& all,
                                      const EmissiveCluster& cluster, std::uint32_t matrixBase,
                                      shared::HdsLight* light) {
    const ClusterWay way = FollowCluster(mesh, all, cluster);
    light->dataSize[1] = AppendMeshMotion(mesh, all, cluster, matrixBase, &_table.cdf);
    for (int i = 0; i < 3; ++i) {
        light->worldFromLight[4 * i + 3] = light->center[i];
    }
    light->params[0] = way.isBent ? 0.0F : std::min(light->params[0], kMovingFlatness);
    light->boundRadius = float(way.radius * (1.0 + 1e-5));
    shared::HdsLightControls controls = LightControls(LightDescription());
    if (light->controlBase != HDS_NONE) {
        std::memcpy(&controls, &_table.cdf[light->controlBase], sizeof(controls));
    }
    AddKeys(way.keys, &controls);
    AppendControls(controls, light);
}

/// A cluster's triangles, their distribution, and the light that it is.
void LightTableBuilder::AddCluster(const EmissiveMesh& mesh, const EmissiveClusters& all,
                                   const EmissiveCluster& cluster, shared::HdsLight light,
                                   const glm::dvec3& radiance, double factor,
                                   std::uint32_t matrixBase) {
    light.area = float(cluster.area);
    light.dataBase = std::uint32_t(_table.triangles.size());
    light.dataSize[0] = std::uint32_t(cluster.end - cluster.begin);
    light.cdfBase = std::uint32_t(_table.cdf.size());
    double sum = 0.0;
    _table.cdf.push_back(0.0F);
    for (std::size_t i = cluster.begin; i < cluster.end; ++i) {
        AddTriangle(mesh, all.triangles[i]);
        sum += all.triangles[i].weight;
        _table.cdf.push_back(i + 1 == cluster.end ? 1.0F : float(sum / cluster.weight));
    }
    const glm::dvec3 center = 0.5 * (cluster.low + cluster.high);
    for (int i = 0; i < 3; ++i) {
        light.center[i] = float(center[i]);
        light.worldFromLight[i] = float(cluster.axis[i]);
    }
    light.params[0] = float(cluster.flatness);
    light.boundRadius = float(0.5 * glm::length(cluster.high - cluster.low) * (1.0 + 1e-5));
    if (mesh.Moves()) {
        AddMeshMotion(mesh, all, cluster, matrixBase, &light);
    }
    Push(light, radiance, Luminance(radiance) * factor * cluster.weight);
}

/// Where a hit finds its triangle's light.
void LightTableBuilder::AddMeshTable(std::uint32_t firstLight, std::uint32_t firstTriangle,
                                     bool isOneLight) {
    _table.tableByMesh.back() = std::uint32_t(_table.cdf.size());
    const auto add = [&](std::uint32_t word) { _table.cdf.push_back(shared::FloatOfBits(word)); };
    if (isOneLight) {
        add(firstLight);
        add(0);
        return;
    }
    std::vector<std::uint32_t> order(_table.triangles.size() - firstTriangle);
    std::iota(order.begin(), order.end(), firstTriangle);
    const auto primId = [&](std::uint32_t i) { return _table.triangles[i].primId; };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return primId(a) < primId(b); });
    add(HDS_NONE);
    add(std::uint32_t(order.size()));
    for (const std::uint32_t i : order) {
        add(primId(i));
    }
    std::for_each(order.begin(), order.end(), add);
}

void LightTableBuilder::AddMesh(const EmissiveMesh& mesh) {
    _table.tableByMesh.push_back(HDS_NONE);
    const EmissiveClusters all = ClusterTriangles(mesh);
    glm::dvec3 radiance;
    double factor = 0.0;
    const auto firstLight = std::uint32_t(_table.lights.size());
    const auto firstTriangle = std::uint32_t(_table.triangles.size());
    const bool isUsable = MeshRadiance(mesh, &radiance);
    if (isUsable && all.weight > 0.0) {
        const shared::HdsLight light = BeginMesh(mesh, all.isWeighed, &factor);
        const std::uint32_t matrixBase = mesh.Moves() ? AppendMatrices(mesh, &_table.cdf) : 0;
        for (const EmissiveCluster& cluster : all.clusters) {
            AddCluster(mesh, all, cluster, light, radiance, factor, matrixBase);
        }
        AddMeshTable(firstLight, firstTriangle,
                     all.clusters.size() == 1 && (light.flags & HDS_LIGHT_WEIGHED) == 0);
    } else if (mesh.lux) {
        // Not sampled, but rays that find it see what it emits, which may be nothing.
        Push(BeginMesh(mesh, false, &factor), isUsable ? radiance : glm::dvec3(0.0), 0.0);
        AddMeshTable(firstLight, firstTriangle, true);
    }
}

} // namespace hds
