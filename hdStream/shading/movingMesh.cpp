// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/movingMesh.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cstring>

namespace hds {

namespace {

/// The vertices of a cluster in the world, with the instance at one key and the shape at another.
template <typename Function>
void ForEachVertex(const EmissiveMesh& mesh, const EmissiveClusters& all,
                   const EmissiveCluster& cluster, std::size_t matrix, std::size_t shape,
                   Function function) {
    for (std::size_t i = cluster.begin; i < cluster.end; ++i) {
        for (const glm::vec3& p : mesh.shapes[shape][all.triangles[i].source].p) {
            function(glm::dvec3(mesh.worldFromObject[matrix] * glm::dvec4(glm::dvec3(p), 1.0)));
        }
    }
}

} // namespace

ClusterWay FollowCluster(const EmissiveMesh& mesh, const EmissiveClusters& all,
                         const EmissiveCluster& cluster) {
    ClusterWay way;
    const std::size_t numMatrices = mesh.worldFromObject.size();
    const std::size_t numShapes = mesh.shapes.size();
    way.isBent = numShapes > 1;
    const glm::dvec3 atRest = 0.5 * (cluster.low + cluster.high);
    // What turns and bends at once is held by spheres that hold all shapes at each turn.
    const std::size_t numKeys = numMatrices > 1 ? numMatrices : numShapes;
    for (std::size_t key = 0; key < numKeys; ++key) {
        const std::size_t matrix = numMatrices > 1 ? key : 0;
        const std::size_t first = numMatrices > 1 ? 0 : key;
        const std::size_t last = numMatrices > 1 ? numShapes - 1 : key;
        glm::dvec3 low(1e300);
        glm::dvec3 high(-1e300);
        for (std::size_t shape = first; shape <= last; ++shape) {
            ForEachVertex(mesh, all, cluster, matrix, shape, [&](const glm::dvec3& p) {
                low = glm::min(low, p);
                high = glm::max(high, p);
            });
        }
        const glm::dvec3 center = 0.5 * (low + high);
        for (std::size_t shape = first; shape <= last; ++shape) {
            ForEachVertex(mesh, all, cluster, matrix, shape, [&](const glm::dvec3& p) {
                way.radius = std::max(way.radius, glm::length(p - center));
            });
        }
        LightKey pose;
        pose.turn = mesh.turns.empty() ? pose.turn : mesh.turns[key];
        pose.offset = center - atRest;
        way.keys.push_back(pose);
    }
    return way;
}

std::uint32_t AppendMatrices(const EmissiveMesh& mesh, std::vector<float>* cdf) {
    const auto base = std::uint32_t(cdf->size());
    for (const glm::dmat4& matrix : mesh.worldFromObject) {
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 4; ++column) {
                cdf->push_back(float(matrix[column][row]));
            }
        }
    }
    return base;
}

std::uint32_t AppendMeshMotion(const EmissiveMesh& mesh, const EmissiveClusters& all,
                               const EmissiveCluster& cluster, std::uint32_t matrixBase,
                               std::vector<float>* cdf) {
    shared::HdsMeshMotion motion{};
    motion.matrixBase = matrixBase;
    motion.matrixSegments = std::uint32_t(mesh.worldFromObject.size() - 1);
    motion.edgesBase = std::uint32_t(cdf->size());
    motion.edgesSegments = std::uint32_t(mesh.shapes.size() - 1);
    for (std::size_t shape = 1; shape < mesh.shapes.size(); ++shape) {
        for (std::size_t i = cluster.begin; i < cluster.end; ++i) {
            const EmissiveMesh::Shape& triangle = mesh.shapes[shape][all.triangles[i].source];
            for (const glm::vec3& v :
                 {triangle.p[0], triangle.p[1] - triangle.p[0], triangle.p[2] - triangle.p[0]}) {
                cdf->insert(cdf->end(), {v.x, v.y, v.z});
            }
        }
    }
    const auto base = std::uint32_t(cdf->size());
    cdf->resize(cdf->size() + sizeof(motion) / sizeof(float));
    std::memcpy(&(*cdf)[base], &motion, sizeof(motion));
    return base;
}

} // namespace hds
