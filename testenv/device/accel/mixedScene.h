// SPDX-License-Identifier: Apache-2.0
// A scene of several meshes in many places, and rays of all kinds through it.
#pragma once

#include "testenv/device/accel/traversalProbe.h"
#include "testenv/support/traversalMeshes.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <cstring>
#include <vector>

namespace hds::test {

using Hits = std::vector<shared::HdsHit>;

inline std::size_t CountDifferentBits(const Hits& a, const Hits& b) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        count += std::memcmp(&a[i], &b[i], sizeof(a[i])) != 0 ? 1 : 0;
    }
    return count;
}

/// Meshes of one and of many chunks under random affine maps, some of them equal.
struct MixedScene {
    std::vector<TriangleMesh> meshes = {BumpySphere(24), Foliage(700, 3), BumpySphere(3),
                                        Box(0.7F)};
    std::vector<std::uint32_t> meshOf; ///< [placement]
    std::vector<AccelPlacement> placements;
    AccelScene scene;

    /// \param isWide something small lies far away: nodes above it are as large as the way there.
    /// \param isRigid maps turn, scale and mirror, and shear nothing.
    explicit MixedScene(bool isWide = false, bool isRigid = false) {
        UniformSource uniform(7);
        std::vector<std::uint32_t> objects;
        for (const TriangleMesh& mesh : meshes) {
            objects.push_back(scene.AddMesh(mesh, 400));
        }
        for (std::uint32_t i = 0; i < 24; ++i) {
            glm::dmat4 matrix(1.0);
            for (int column = 0; column < 3; ++column) {
                matrix[column] = glm::dvec4(uniform(), uniform(), uniform(), 0.0);
            }
            if (isRigid) {
                const glm::dvec3 axis = glm::normalize(glm::dvec3(matrix[0]));
                const double scale = (i % 3 == 0 ? -1.0 : 1.0) * (0.6 + 0.4 * uniform());
                matrix = glm::rotate(glm::scale(glm::dmat4(1.0), glm::dvec3(scale)),
                                     4.0 * uniform(), axis);
            }
            matrix[3] = glm::dvec4(3.0 * glm::dvec3(uniform.Vector()), 1.0);
            if (i % 8 == 7) {
                matrix = placements.back().parentFromObject;
            }
            if (i % 8 == 3) {
                matrix = glm::dmat4(1.0); // in place: boxes are tested with the ray outside
            }
            meshOf.push_back(i % 4);
            placements.push_back({objects[i % 4], matrix, HDS_INSTANCE_SEEN});
        }
        if (isWide) {
            glm::dmat4 away(1.0);
            away[3] = glm::dvec4(3e5, -2e5, 1e5, 1.0);
            meshOf.push_back(3);
            placements.push_back({objects[3], away, HDS_INSTANCE_SEEN});
        }
        scene.SetRoot(placements);
    }
};

/// In the flat hierarchy all meshes have trees of their own, however often they are placed.
inline const AccelUpload kCopies = {1, {}, {1U << 28U, 0.0, 0.0, 0.0}};

/// Random, axis-parallel (with +0 and -0), from far away, and bounded rays.
inline std::vector<ProbeRay> MixedRays(std::size_t count) {
    UniformSource uniform(11);
    std::vector<ProbeRay> rays;
    for (std::size_t i = 0; i < count; ++i) {
        glm::vec3 origin = 4.0F * uniform.Vector();
        glm::vec3 direction = uniform.Vector();
        if (i % 5 == 1) {
            const glm::vec3 axis(i % 3 == 0, i % 3 == 1, i % 3 == 2);
            direction = (i % 2 == 0 ? 1.0F : -1.0F) * axis;
        }
        if (i % 5 == 2) {
            direction *= 1e-4F;
        }
        if (i % 5 == 3) {
            origin -= 1000.0F * direction;
        }
        rays.push_back(MakeProbeRay(origin, direction, i % 4 == 3 ? 2.0F : INFINITY,
                                    i % 7 == 6 ? 0.5F : 0.0F));
    }
    return rays;
}

} // namespace hds::test
