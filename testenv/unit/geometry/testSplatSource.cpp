// SPDX-License-Identifier: Apache-2.0
// Gaussian splats as chunks: shapes, boxes that hold their ellipsoids, values of all their tuples.
#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/splatSource.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/splat.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

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
