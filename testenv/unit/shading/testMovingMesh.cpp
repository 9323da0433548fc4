// SPDX-License-Identifier: Apache-2.0
// The spheres by which mesh lights that move are chosen hold their triangles, by brute force.
#include "hdStream/shading/lightTable.h"
#include "hdStream/shading/movingMesh.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace hds::test {
namespace {

/// Between keys at equal steps.
template <typename T>
T At(const std::vector<T>& keys, double time) {
    if (keys.size() == 1) {
        return keys[0];
    }
    const double scaled = time * double(keys.size() - 1);
    const std::size_t i = std::min(std::size_t(scaled), keys.size() - 2);
    return keys[i] + (scaled - double(i)) * (keys[i + 1] - keys[i]);
}

/// A strip of triangles that turns, grows, and is bent by a sine, with so many keys of each.
EmissiveMesh MakeStrip(std::size_t numMatrices, std::size_t numShapes) {
    EmissiveMesh mesh;
    for (std::size_t i = 0; i < numMatrices; ++i) {
        const double part = numMatrices > 1 ? double(i) / double(numMatrices - 1) : 0.5;
        glm::dmat4 matrix = glm::translate(glm::dmat4(1.0), {9.0 * part, 0.0, 2.0});
        matrix = glm::rotate(matrix, 2.0 * part, {0.0, 1.0, 0.2});
        mesh.worldFromObject.push_back(glm::scale(matrix, glm::dvec3(1.0 + part)));
        if (numMatrices > 1) {
            const glm::dvec3 half = std::sin(part - 0.5) * glm::normalize(glm::dvec3(0, 1, 0.2));
            mesh.turns.push_back({half, std::cos(part - 0.5)});
        }
    }
    mesh.shapes.resize(numShapes);
    constexpr int kNumTriangles = 24;
    for (int i = 0; i < kNumTriangles; ++i) {
        for (std::size_t shape = 0; shape < numShapes; ++shape) {
            const auto bent = [&](float x, float y) {
                return glm::vec3(x, y, std::sin(float(shape)) * std::sin(x));
            };
            const auto x = 0.3F * float(i);
            mesh.shapes[shape].push_back({{bent(x, 0), bent(x + 0.3F, 0), bent(x, 1)}});
        }
        EmissiveMesh::Triangle triangle;
        triangle.primId = std::uint32_t(i);
        const glm::dmat4 rest = At(mesh.worldFromObject, 0.5);
        for (int k = 0; k < 3; ++k) {
            triangle.p[k] = rest * glm::dvec4(glm::dvec3(mesh.shapes[0].back().p[k]), 1.0);
        }
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

TEST(MovingMesh, SpheresHoldTheirTrianglesAtAllTimes) {
    std::mt19937 generator(5);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (const auto& [numMatrices, numShapes] :
         {std::pair<std::size_t, std::size_t>(9, 1), {1, 5}, {5, 4}, {2, 2}}) {
        const EmissiveMesh mesh = MakeStrip(numMatrices, numShapes);
        const EmissiveClusters all = ClusterTriangles(mesh);
        ASSERT_GT(all.clusters.size(), 1U);
        double widest = 0.0;
        for (const EmissiveCluster& cluster : all.clusters) {
            const ClusterWay way = FollowCluster(mesh, all, cluster);
            ASSERT_GT(way.keys.size(), 1U);
            EXPECT_EQ(way.isBent, numShapes > 1);
            std::vector<glm::dvec3> centers;
            for (const LightKey& key : way.keys) {
                centers.push_back(0.5 * (cluster.low + cluster.high) + key.offset);
            }
            for (int sample = 0; sample < 200; ++sample) {
                const double time = uniform(generator);
                const glm::dmat4 matrix = At(mesh.worldFromObject, time);
                for (std::size_t i = cluster.begin; i < cluster.end; ++i) {
                    for (int k = 0; k < 3; ++k) {
                        std::vector<glm::dvec3> vertex;
                        for (const auto& shape : mesh.shapes) {
                            vertex.emplace_back(shape[all.triangles[i].source].p[k]);
                        }
                        const glm::dvec3 p(matrix * glm::dvec4(At(vertex, time), 1.0));
                        const double distance = glm::length(p - At(centers, time));
                        ASSERT_LE(distance, way.radius * (1.0 + 1e-12));
                        widest = std::max(widest, distance / way.radius);
                    }
                }
            }
        }
        EXPECT_GT(widest, 0.9) << "spheres that hold anything";
    }
}

TEST(MovingMesh, TheTreeHoldsLightsWhereverTheyGo) {
    const EmissiveMesh mesh = MakeStrip(9, 1);
    Warnings warnings;
    const LightTable table = BuildLightTable({}, {mesh}, {}, warnings);
    ASSERT_TRUE(table.hasMotion);
    ASSERT_FALSE(table.nodes.empty());
    for (const shared::HdsLightTriangle& triangle : table.triangles) {
        const glm::dvec3 rest(mesh.shapes[0].at(triangle.primId).p[0]);
        std::uint32_t place = table.lights[triangle.light].treePlace;
        EXPECT_EQ(table.nodes[place / 8].inDetail >> place % 8 & 1U, 1U);
        for (; place != HDS_NONE; place = table.nodes[place / 8].place) {
            const shared::HdsLightNode& node = table.nodes[place / 8];
            const std::uint32_t slot = place % 8;
            const glm::dvec3 center(node.centerX[slot], node.centerY[slot], node.centerZ[slot]);
            for (const glm::dmat4& matrix : mesh.worldFromObject) {
                const glm::dvec3 p(matrix * glm::dvec4(rest, 1.0));
                EXPECT_LE(glm::length(p - center), double(node.radius[slot]));
            }
        }
    }
    for (const shared::HdsLight& light : table.lights) {
        ASSERT_NE(light.controlBase, HDS_NONE);
        shared::HdsLightControls controls;
        std::memcpy(&controls, &table.cdf[light.controlBase], sizeof(controls));
        EXPECT_EQ(controls.motionSegments, 8U);
        EXPECT_EQ(controls.diffuse, 1.0F);
        shared::HdsMeshMotion motion;
        std::memcpy(&motion, &table.cdf[light.dataSize[1]], sizeof(motion));
        EXPECT_EQ(motion.matrixSegments, 8U);
        EXPECT_EQ(motion.edgesSegments, 0U);
    }
}

} // namespace
} // namespace hds::test
