// SPDX-License-Identifier: Apache-2.0
// Meshes of the traversal tests and benchmark: closed bumpy sphere, box, foliage-like soup.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <glm/common.hpp>
#include <glm/vec4.hpp>

#include <cmath>
#include <random>

namespace hds::test {

/// A closed sphere with bumps, about 4 * rows^2 triangles: rings share their vertices all around,
/// and each pole is one vertex.
inline TriangleMesh BumpySphere(std::uint32_t rows, float bump = 0.03F) {
    constexpr double kPi = 3.14159265358979323846;
    TriangleMesh mesh;
    const std::uint32_t columns = 2 * rows;
    const auto point = [&](double theta, double phi) {
        const double radius = 1.0 + bump * std::sin(40.0 * phi) * std::sin(37.0 * theta) +
                              0.3 * bump * std::sin(171.0 * phi) * std::sin(133.0 * theta);
        mesh.positions.emplace_back(radius * std::sin(theta) * std::cos(phi),
                                    radius * std::sin(theta) * std::sin(phi),
                                    radius * std::cos(theta));
    };
    point(0.0, 0.0);
    for (std::uint32_t row = 1; row < rows; ++row) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            point(kPi * row / rows, 2.0 * kPi * column / columns);
        }
    }
    point(kPi, 0.0);
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    const auto index = [&](std::uint32_t row, std::uint32_t column) {
        return row == 0 ? 0 : (row == rows ? last : 1 + (row - 1) * columns + column % columns);
    };
    for (std::uint32_t row = 0; row < rows; ++row) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            const glm::uvec4 q(index(row, column), index(row + 1, column),
                               index(row + 1, column + 1), index(row, column + 1));
            if (row + 1 < rows) {
                mesh.triangles.emplace_back(q.x, q.y, q.z);
            }
            if (row > 0) {
                mesh.triangles.emplace_back(q.x, q.z, q.w);
            }
        }
    }
    return mesh;
}

/// A closed axis-parallel box of half size `extent`.
inline TriangleMesh Box(float extent) {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < 8; ++i) {
        mesh.positions.emplace_back((i & 1U) != 0 ? extent : -extent,
                                    (i & 2U) != 0 ? extent : -extent,
                                    (i & 4U) != 0 ? extent : -extent);
    }
    const glm::uvec4 faces[6] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                 {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const glm::uvec4& face : faces) {
        mesh.triangles.emplace_back(face.x, face.y, face.z);
        mesh.triangles.emplace_back(face.x, face.z, face.w);
    }
    return mesh;
}

/// Leaves in the unit ball: `numLeaves` pairs of triangles of random direction, and of sizes that
/// vary by a factor of ten.
inline TriangleMesh Foliage(std::uint32_t numLeaves, std::uint32_t seed) {
    TriangleMesh mesh;
    std::mt19937 random(seed);
    const auto uniform = [&random] {
        return static_cast<float>(random() >> 8U) * 0x1p-24F * 2.0F - 1.0F;
    };
    const float size = 1.5F / std::cbrt(static_cast<float>(numLeaves));
    for (std::uint32_t leaf = 0; leaf < numLeaves; ++leaf) {
        glm::vec3 centre(2.0F);
        while (centre.x * centre.x + centre.y * centre.y + centre.z * centre.z > 1.0F) {
            centre = {uniform(), uniform(), uniform()};
        }
        const float scale = size * std::pow(10.0F, 0.5F * uniform() - 0.5F);
        const glm::vec3 a(uniform() * scale, uniform() * scale, uniform() * scale);
        const glm::vec3 b(uniform() * scale, uniform() * scale, uniform() * scale);
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(centre - a);
        mesh.positions.push_back(centre - b);
        mesh.positions.push_back(centre + a);
        mesh.positions.push_back(centre + b);
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.triangles.emplace_back(first, first + 2, first + 3);
    }
    return mesh;
}

} // namespace hds::test
