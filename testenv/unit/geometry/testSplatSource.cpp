// SPDX-License-Identifier: Apache-2.0
// Gaussian splats as chunks: shapes, boxes that hold their ellipsoids, values of all their tuples.
#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/splatSource.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/splat.h"

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

namespace hds::test {
namespace {

Primvar Vertex(const char* name, std::uint32_t numComponents, std::vector<float> values) {
    return {name, Interpolation::Vertex, numComponents, std::move(values), {}};
}

/// Random ellipsoids, with harmonics of degree 1.
GeometryDescription RandomSplats(std::size_t count) {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    const auto numbers = [&](std::size_t n, float scale) {
        std::vector<float> values(n);
        for (float& value : values) {
            value = scale * normal(random);
        }
        return values;
    };
    GeometryDescription splats;
    splats.primitives = PrimitiveKind::Splats;
    splats.points = numbers(3 * count, 5.0F);
    std::vector<float> opacities = numbers(count, 1.0F);
    for (float& opacity : opacities) {
        opacity = 1.0F / (1.0F + std::exp(-opacity));
    }
    splats.primvars = {Vertex(kSplatOrientations, 4, numbers(4 * count, 1.0F)),
                       Vertex(kSplatScales, 3, numbers(3 * count, 0.5F)),
                       Vertex(kSplatOpacities, 1, std::move(opacities)),
                       Vertex(kSplatHarmonics, 3, numbers(12 * count, 1.0F)),
                       {kSplatDegree, Interpolation::Constant, 1, std::vector<float>{1.0F}, {}}};
    return splats;
}

std::vector<float> UnitTurns(const SharedSpan<float>& turns) {
    std::vector<float> values(turns.begin(), turns.end());
    for (std::size_t i = 0; i < values.size(); i += 4) {
        const glm::dvec4 turn(values[i], values[i + 1], values[i + 2], values[i + 3]);
        for (int k = 0; k < 4; ++k) {
            values[i + k] = static_cast<float>(turn[k] / glm::length(turn));
        }
    }
    return values;
}

std::shared_ptr<const ChunkSource> Make(const GeometryDescription& splats, Warnings& warnings) {
    return MakeSplatSource(std::make_shared<GeometryDescription>(splats), "/s", warnings);
}

/// v turned by the quaternion (i, j, k, real), in double.
glm::dvec3 Turned(const float* q, const glm::dvec3& v) {
    const glm::dvec3 axis(q[0], q[1], q[2]);
    const double norm = glm::dot(axis, axis) + double{q[3]} * q[3];
    const glm::dvec3 twice = 2.0 * glm::cross(axis, v);
    return v + (double{q[3]} * twice + glm::cross(axis, twice)) / norm;
}

TEST(SplatSource, BoxesHoldAllThatIsNotBelowTheLeastAlphaAndTouchIt) {
    constexpr std::uint32_t kCount = 40;
    const GeometryDescription splats = RandomSplats(kCount);
    Warnings warnings;
    const auto source = Make(splats, warnings);
    std::mt19937 random(8);
    std::normal_distribution<double> normal;
    for (std::uint32_t i = 0; i < kCount; ++i) {
        const float opacity = splats.primvars[2].values[i];
        ASSERT_EQ(source->GroupTriangles(i), opacity > HDS_SPLAT_LEAST_ALPHA ? 1U : 0U);
        const Bounds box = source->GroupBounds(i);
        const double reach = std::sqrt(2.0 * std::log(255.0 * opacity));
        glm::dvec3 most(-1e30);
        for (int k = 0; k < 20000; ++k) {
            const glm::dvec3 direction =
                glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
            const float* scales = splats.primvars[1].values.data() + 3 * i;
            const glm::dvec3 offset =
                Turned(splats.primvars[0].values.data() + 4 * i,
                       reach * direction * glm::dvec3(scales[0], scales[1], scales[2]));
            for (int axis = 0; axis < 3; ++axis) {
                const double at = splats.points[3 * i + axis] + offset[axis];
                ASSERT_LE(box.min[axis], at);
                ASSERT_GE(box.max[axis], at);
                most[axis] = std::max(most[axis], at);
            }
        }
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(most[axis], box.max[axis], 0.01 * (box.max[axis] - box.min[axis]));
        }
    }
    EXPECT_TRUE(warnings.Lines().empty());
}

/// Splats whose shapes and places differ in three poses.
GeometryDescription MovingSplats(std::uint32_t count) {
    GeometryDescription splats = RandomSplats(count);
    std::mt19937 random(9);
    std::normal_distribution<float> normal;
    for (Primvar& primvar : splats.primvars) { // of unit length, as commit has them
        if (primvar.name == kSplatOrientations) {
            primvar.values = UnitTurns(primvar.values);
        }
    }
    for (int key = 0; key < 2; ++key) {
        const auto changed = [&](const SharedSpan<float>& from, float amount) {
            std::vector<float> values(from.begin(), from.end());
            for (float& value : values) {
                value += amount * normal(random);
            }
            return values;
        };
        ShutterKey later;
        const ShutterKey* before = key == 0 ? nullptr : &splats.keys[0];
        later.points = changed(splats.points, 0.5F);
        later.orientations = UnitTurns(
            changed(before != nullptr ? before->orientations : splats.primvars[0].values, 0.2F));
        later.scales = changed(splats.primvars[1].values, 0.3F);
        std::vector<float> opacities = changed(splats.primvars[2].values, 0.5F);
        for (float& opacity : opacities) {
            opacity = std::min(1.0F, std::max(0.0F, opacity));
        }
        later.opacities = std::move(opacities);
        splats.keys.push_back(std::move(later));
    }
    return splats;
}

/// Boxes between those of two keys, linear in time, hold the ellipsoid as kernels have it then.
TEST(SplatSource, BoxesBetweenKeysHoldWhatMovesThere) {
    constexpr std::uint32_t kCount = 30;
    const GeometryDescription splats = MovingSplats(kCount);
    Warnings warnings;
    const auto source = Make(splats, warnings);
    std::vector<std::uint32_t> groups;
    for (std::uint32_t i = 0; i < kCount; ++i) {
        ASSERT_EQ(source->GroupTriangles(i), 1U) << i;
        groups.push_back(i);
    }
    const ChunkGeometry chunk = source->Gather(groups.data(), groups.size());
    EXPECT_EQ(chunk.primitives, HDS_PRIMITIVE_SPLATS | HDS_PRIMITIVE_SHAPES_MOVE);
    ASSERT_EQ(chunk.keys.size(), 2U);
    std::mt19937 random(8);
    std::normal_distribution<double> normal;
    double largestPart = 0.0;
    for (int segment = 0; segment < 2; ++segment) {
        const bool isFirst = segment == 0;
        const auto& fromPositions = isFirst ? chunk.positions : chunk.keys[0].positions;
        const auto& fromRadii = isFirst ? chunk.radii : chunk.keys[0].radii;
        const auto& fromShapes = isFirst ? chunk.shapes : chunk.keys[0].shapes;
        const auto& fromBoxes = isFirst ? chunk.primitiveBounds : chunk.keys[0].primitiveBounds;
        const ChunkKey& to = chunk.keys[segment];
        for (std::uint32_t i = 0; i < kCount; ++i) {
            for (int step = 0; step <= 8; ++step) {
                const double part = step / 8.0;
                const auto between = [&](double a, double b) { return a + part * (b - a); };
                const double opacity = between(fromRadii[i], to.radii[i]);
                if (!(opacity > HDS_SPLAT_LEAST_ALPHA)) {
                    continue;
                }
                const double reach = std::sqrt(2.0 * std::log(255.0 * opacity));
                float turn[4];
                for (int k = 0; k < 4; ++k) {
                    turn[k] =
                        static_cast<float>(between(fromShapes[i].turn[k], to.shapes[i].turn[k]));
                }
                glm::dvec3 sizes;
                glm::dvec3 centre;
                glm::dvec3 least;
                glm::dvec3 most;
                for (int k = 0; k < 3; ++k) {
                    sizes[k] = between(fromShapes[i].sizes[k], to.shapes[i].sizes[k]);
                    centre[k] = between(fromPositions[i][k], to.positions[i][k]);
                    least[k] = between(fromBoxes[i].min[k], to.primitiveBounds[i].min[k]);
                    most[k] = between(fromBoxes[i].max[k], to.primitiveBounds[i].max[k]);
                }
                for (int axis = 0; axis < 3; ++axis) {
                    // The point of the ellipsoid that is furthest along the axis.
                    const float back[4] = {-turn[0], -turn[1], -turn[2], turn[3]};
                    glm::dvec3 unit(0.0);
                    unit[axis] = 1.0;
                    const double far = reach * glm::length(sizes * Turned(back, unit));
                    ASSERT_LE(centre[axis] + far, most[axis]) << i << " at " << part;
                    ASSERT_GE(centre[axis] - far, least[axis]) << i << " at " << part;
                    largestPart = std::max(largestPart, 2.0 * far / (most[axis] - least[axis]));
                }
            }
        }
    }
    EXPECT_GT(largestPart, 0.95) << "boxes are much larger than they need be";
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST(SplatSource, PagesHaveAllTuplesOfASplat) {
    const GeometryDescription splats = RandomSplats(5);
    Warnings warnings;
    const auto source = Make(splats, warnings);
    const std::uint32_t groups[] = {3, 1};
    const ChunkGeometry chunk = source->Gather(groups, 2);
    ASSERT_EQ(chunk.shapes.size(), 2U);
    EXPECT_EQ(chunk.radii[0], splats.primvars[2].values[3]);
    const std::vector<std::uint8_t> page = BuildAttributePage(chunk);
    std::uint32_t word = 0;
    std::memcpy(&word, page.data() + HDS_SLOT_USER * sizeof(word), sizeof(word));
    EXPECT_EQ(word >> 26, HDS_ATTR_VERTEX << 3U | 3U);
    float values[24];
    std::memcpy(values, page.data() + std::size_t{16} * (word & 0x3ffffffU), sizeof(values));
    for (int k = 0; k < 12; ++k) {
        EXPECT_EQ(values[k], splats.primvars[3].values[12 * 3 + k]);
        EXPECT_EQ(values[12 + k], splats.primvars[3].values[12 + k]);
    }
    const std::size_t most = std::size_t{2} * source->BoundBytes().attributes + 64;
    EXPECT_LE(page.size(), most);
}

TEST(SplatSource, DegreesAreThoseOfThePaper) {
    GeometryDescription splats = RandomSplats(1);
    for (const auto& [value, degree] : {std::pair{0.0F, 0}, {3.0F, 3}, {4.0F, -1}, {-1.0F, -1}}) {
        splats.primvars[4].values = std::vector<float>{value};
        EXPECT_EQ(SplatDegree(splats),
                  degree < 0 ? std::nullopt : std::optional<std::uint32_t>(degree));
    }
    splats.primvars.pop_back();
    EXPECT_EQ(SplatDegree(splats), 3U);
}

} // namespace
} // namespace hds::test
