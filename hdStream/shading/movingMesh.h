// SPDX-License-Identifier: Apache-2.0
// Mesh lights that move while the shutter is open: the keys of their triangles, and of what they
// are chosen by. Pure functions; any thread. Explained in docs/lights.md, "Moving lights".
#pragma once

#include "hdStream/shading/emissiveMesh.h"
#include "kernels/shared/light.h"

#include <vector>

namespace hds {

/// How a cluster moves, as far as the choice of a light knows: its sphere at equal steps in time.
struct ClusterWay {
    std::vector<LightKey> keys; ///< turned about the cluster's centre, then moved; at least two
    double radius = 0.0;        ///< of a sphere around the centre that holds it at all times
    bool isBent = false;        ///< its vertices move against each other, so that it has no axis
};

/// \pre the mesh moves.
ClusterWay FollowCluster(const EmissiveMesh& mesh, const EmissiveClusters& all,
                         const EmissiveCluster& cluster);

/// Appends the keys of a cluster's triangles to lightCdf, and what tells of them behind these.
/// \param matrixBase where AppendMatrices has put the mesh's. \return where that begins.
std::uint32_t AppendMeshMotion(const EmissiveMesh& mesh, const EmissiveClusters& all,
                               const EmissiveCluster& cluster, std::uint32_t matrixBase,
                               std::vector<float>* cdf);

/// Appends the matrices of a mesh that moves to lightCdf. \return where they begin.
std::uint32_t AppendMatrices(const EmissiveMesh& mesh, std::vector<float>* cdf);

} // namespace hds
