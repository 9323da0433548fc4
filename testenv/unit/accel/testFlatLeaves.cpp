// SPDX-License-Identifier: Apache-2.0
// The leaves of the flat hierarchy that a page gives: all triangles are there once, in boxes that
// hold them in world space with their margin, and leaves are joined.
#include "hdStream/accel/bvh.h"
#include "hdStream/accel/flatLeaves.h"
#include "hdStream/accel/leafSlots.h"
#include "testenv/support/meshSource.h"
#include "testenv/support/traversalMeshes.h"

#include <glm/ext/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hds::test {
namespace {

/// Whether a corner is so far inside of a box as roundoff asks for: 64 units of it for places below
/// one instance, of the largest coordinate `far`. Two of them are left to the rounding of the
/// corner and of the box.
bool IsInside(const BoxRef& box, const glm::dvec3& corner, double far) {
    const double margin = far * std::ldexp(62.0, -24);
    for (int axis = 0; axis < 3; ++axis) {
        if (!(double{box.lo[axis]} <= corner[axis] - margin &&
              double{box.hi[axis]} >= corner[axis] + margin)) {
            return false;
        }
    }
    return true;
}

struct LeafFacts {
    std::size_t numLeaves = 0;
    std::size_t numSlots = 0; ///< of the page, that hold triangles
};

LeafFacts ExpectSound(const TriangleMesh& mesh, const FlatPlacement& placement) {
    std::vector<std::uint32_t> groups(mesh.triangles.size());
    std::iota(groups.begin(), groups.end(), 0U);
    ChunkGeometry chunk = SourceOf(mesh)->Gather(groups.data(), groups.size());
    const GeometryPage geometry = BuildGeometryPage(chunk);
    const PageParts page(geometry.bytes.data());
    std::vector<std::uint32_t> timesSeen(mesh.triangles.size());
    LeafFacts facts;
    for (const FlatLeafPlan& leaf : PlanFlatLeaves(page, placement)) {
        ++facts.numLeaves;
        EXPECT_GT(leaf.count, 0);
        std::vector<glm::dvec3> corners;
        double far = 0.0;
        for (std::uint32_t k = 0; k < leaf.count; ++k) {
            const std::uint32_t triangle = leaf.triangles.at(k);
            for (std::uint32_t i = 0; i < 3; ++i) {
                const float* p = page.vertices + std::size_t{3} * page.Corner(triangle, i);
                const glm::dvec4 position(p[0], p[1], p[2], 1.0);
                corners.emplace_back(placement.worldFromObject * position);
                const glm::dvec3 size = glm::abs(corners.back());
                far = std::max({far, size.x, size.y, size.z});
            }
            ++timesSeen.at(triangle);
        }
        for (const glm::dvec3& corner : corners) {
            EXPECT_TRUE(IsInside(leaf.box, corner, far));
        }
    }
    EXPECT_EQ(timesSeen, std::vector<std::uint32_t>(mesh.triangles.size(), 1U));
    ForEachLeafSlot(page.nodes,
                    [&](const auto&, int, std::uint32_t, std::uint32_t) { ++facts.numSlots; });
    return facts;
}

FlatPlacement Turned() {
    FlatPlacement placement;
    placement.marginExponent = -18;
    placement.worldFromObject = glm::translate(glm::dmat4(1.0), glm::dvec3(100.0, -3.0, 0.25)) *
                                glm::rotate(glm::dmat4(1.0), 0.7, glm::dvec3(1.0, 2.0, 3.0));
    return placement;
}

FlatPlacement InPlace() {
    FlatPlacement placement;
    placement.marginExponent = -18;
    placement.isInPlace = true;
    return placement;
}

TEST(FlatLeaves, HoldAPage) {
    for (const FlatPlacement& placement : {InPlace(), Turned()}) {
        const TriangleMesh mesh = BumpySphere(40);
        const LeafFacts facts = ExpectSound(mesh, placement);
        EXPECT_LT(facts.numLeaves, facts.numSlots * 3 / 4) << "leaves are joined";
        EXPECT_LT(facts.numLeaves, mesh.triangles.size() / 2);
    }
}

TEST(FlatLeaves, HoldPagesOfFewTriangles) {
    const TriangleMesh sphere = BumpySphere(10);
    for (std::size_t count = 1; count < 40; ++count) {
        TriangleMesh mesh = sphere;
        mesh.triangles.resize(count);
        ExpectSound(mesh, InPlace());
    }
}

TEST(FlatLeaves, HoldEqualTriangles) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles.assign(500, {0, 1, 2});
    ExpectSound(mesh, Turned());
}

} // namespace
} // namespace hds::test
