// SPDX-License-Identifier: Apache-2.0
// Traversal finds what testing every triangle finds: the same bits as a kernel without hierarchy,
// and the same hits as double precision on the host.
#include "testenv/device/accel/mixedScene.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

namespace hds::test {
namespace {

class Traversal : public DeviceFixture {};

TEST_F(Traversal, AllFormsMatchBruteForceBitForBit) {
    const MixedScene mixed;
    const DeviceAccelScene scene(device, mixed.scene);
    const std::vector<ProbeRay> rays = MixedRays(2500);
    const TraversalProbe simd8(device, true);
    const TraversalProbe scalar(device, false);
    const TraversalProbe flat(device, AccelForm::Flat);
    const Hits expected = scalar.BruteForce(scene, rays);
    std::size_t numHits = 0;
    for (const shared::HdsHit& hit : expected) {
        numHits += IsHit(hit) ? 1 : 0;
    }
    EXPECT_GT(numHits, rays.size() / 10) << "the test would show little";
    // The SIMD8 form has another text of the triangle test.
    EXPECT_EQ(CountDifferentBits(simd8.BruteForce(scene, rays), expected), 0U);
    EXPECT_EQ(CountDifferentBits(simd8.Closest(scene, rays), expected), 0U);
    EXPECT_EQ(CountDifferentBits(scalar.Closest(scene, rays), expected), 0U);
    EXPECT_EQ(CountDifferentBits(flat.Closest(scene, rays), expected), 0U);
    for (const TraversalProbe* probe : {&simd8, &scalar, &flat}) {
        const Hits blocked = probe->Occluded(scene, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(blocked[i].triangle == kBlocked, IsHit(expected[i])) << "ray " << i;
        }
    }
}

TEST_F(Traversal, OneDistantThingMovesNoHit) {
    const MixedScene mixed(true);
    const DeviceAccelScene scene(device, mixed.scene);
    std::vector<ProbeRay> rays = MixedRays(2500);
    for (std::size_t i = 0; i < rays.size(); i += 4) { // along axes, past corners of the boxes
        const shared::HdsBvhNode& node = mixed.scene.topNodes[i % mixed.scene.topNodes.size()];
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = axis == 0 ? -7.0F : node.origin[axis];
            rays[i].direction[axis] = axis == 0 ? 1.0F : 0.0F;
        }
    }
    const TraversalProbe simd8(device, true);
    const TraversalProbe scalar(device, false);
    const Hits expected = scalar.BruteForce(scene, rays);
    EXPECT_GT(CountDifferentBits(expected, Hits(rays.size(), expected[0])), rays.size() / 10);
    EXPECT_EQ(CountDifferentBits(simd8.Closest(scene, rays), expected), 0U);
    EXPECT_EQ(CountDifferentBits(scalar.Closest(scene, rays), expected), 0U);
    const TraversalProbe flat(device, AccelForm::Flat);
    EXPECT_EQ(CountDifferentBits(flat.Closest(scene, rays), expected), 0U);
}

TEST_F(Traversal, VariantsGiveTheSameBits) {
    const MixedScene mixed;
    const std::vector<ProbeRay> rays = MixedRays(3000);
    const DeviceAccelScene scene(device, mixed.scene);
    const Hits expected = TraversalProbe(device, false).Closest(scene, rays);
    const DeviceAccelScene threePools(device, mixed.scene, {3, {}});
    for (const bool simd8 : {false, true}) {
        for (const ProgramDefines& defines :
             {ProgramDefines{{"HDS_FEATURE_GROUPS", "0"}, {"HDS_FEATURE_CUTOUT", "0"}},
              ProgramDefines{{"HDS_FEATURE_GROUPS", "1"}, {"HDS_FEATURE_CUTOUT", "0"}}}) {
            EXPECT_EQ(CountDifferentBits(
                          TraversalProbe(device, simd8, defines).Closest(scene, rays), expected),
                      0U);
        }
        for (const char* numPools : {"3", "8"}) {
            const TraversalProbe probe(device, simd8, {{"HDS_NUM_POOLS", numPools}});
            EXPECT_EQ(CountDifferentBits(probe.Closest(threePools, rays), expected), 0U);
        }
    }
}

/// Closest hit in double precision. \return t, or infinity; `margin` is how far the ray is from the
/// nearest edge of any triangle it meets, in barycentric units.
double HostClosest(const MixedScene& mixed, const ProbeRay& ray, double* margin) {
    double best = INFINITY;
    *margin = INFINITY;
    const glm::dvec3 worldOrigin(ray.origin[0], ray.origin[1], ray.origin[2]);
    const glm::dvec3 worldDirection(ray.direction[0], ray.direction[1], ray.direction[2]);
    for (std::size_t n = 0; n < mixed.placements.size(); ++n) {
        const glm::dmat4 inverse = glm::inverse(mixed.placements[n].parentFromObject);
        const glm::dvec3 o(inverse * glm::dvec4(worldOrigin, 1.0));
        const glm::dvec3 d(inverse * glm::dvec4(worldDirection, 0.0));
        const TriangleMesh& mesh = mixed.meshes[mixed.meshOf[n]];
        for (const glm::uvec3& triangle : mesh.triangles) {
            const glm::dvec3 p0(mesh.positions[triangle.x]);
            const glm::dvec3 e1 = glm::dvec3(mesh.positions[triangle.y]) - p0;
            const glm::dvec3 e2 = glm::dvec3(mesh.positions[triangle.z]) - p0;
            // Source: Moller, Trumbore 1997.
            const glm::dvec3 p = glm::cross(d, e2);
            const double determinant = glm::dot(e1, p);
            if (std::abs(determinant) < 1e-300) {
                continue;
            }
            const glm::dvec3 s = o - p0;
            const glm::dvec3 q = glm::cross(s, e1);
            const double u = glm::dot(s, p) / determinant;
            const double v = glm::dot(d, q) / determinant;
            const double t = glm::dot(e2, q) / determinant;
            const double inside = std::min({u, v, 1.0 - u - v});
            // Grazing triangles magnify what the ray's rounding does to their barycentrics.
            const double slope =
                std::abs(determinant) / (glm::length(glm::cross(e1, e2)) * glm::length(d));
            *margin = std::min(*margin, std::abs(inside) * slope);
            if (inside >= 0.0 && t > ray.tMin && t < ray.tMax) {
                best = std::min(best, t);
            }
        }
    }
    return best;
}

TEST_F(Traversal, MatchesDoublePrecision) {
    const MixedScene mixed;
    const DeviceAccelScene scene(device, mixed.scene);
    UniformSource uniform(13);
    std::vector<ProbeRay> rays;
    for (int i = 0; i < 400; ++i) {
        const glm::vec3 origin = 3.0F * uniform.Vector();
        rays.push_back(MakeProbeRay(origin, uniform.Vector() - 0.3F * origin));
    }
    const Hits hits = TraversalProbe(device, true).Closest(scene, rays);
    int numCompared = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        double margin = 0.0;
        const double expected = HostClosest(mixed, rays[i], &margin);
        // Single precision decides an edge up to about 2^-24 * distance / size of the triangle,
        // here below 1e-5; such rays are left out.
        if (margin < 1e-5) {
            continue;
        }
        ++numCompared;
        ASSERT_EQ(IsHit(hits[i]), std::isfinite(expected)) << "ray " << i;
        if (IsHit(hits[i])) {
            // The instance transforms are rounded to float and may be far from orthogonal.
            EXPECT_NEAR(hits[i].t, expected, 1e-4 * (1.0 + expected)) << "ray " << i;
        }
    }
    EXPECT_GT(numCompared, 250);
}

/// A quad in the plane z = 0 as two triangles, `copies` times over.
TriangleMesh StackedQuads(std::uint32_t copies) {
    TriangleMesh mesh;
    mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    for (std::uint32_t i = 0; i < copies; ++i) {
        mesh.triangles.emplace_back(0, 1, 2);
        mesh.triangles.emplace_back(0, 2, 3);
    }
    return mesh;
}

// Ties go to the smaller (path index, primId), never to build order.
TEST_F(Traversal, TiesGoToTheSmallerKey) {
    AccelScene built;
    const std::uint32_t quads = built.AddMesh(StackedQuads(40), 8);
    std::vector<AccelPlacement> placements;
    for (int i = 0; i < 12; ++i) {
        placements.push_back({quads, glm::dmat4(1.0), 0});
    }
    built.SetRoot(placements);
    const DeviceAccelScene scene(device, built);
    UniformSource uniform(17);
    std::vector<ProbeRay> rays;
    for (int i = 0; i < 500; ++i) {
        rays.push_back(
            MakeProbeRay({0.9F * uniform(), 0.9F * uniform(), 1.0F}, {0.0F, 0.0F, -1.0F}));
    }
    rays.push_back(MakeProbeRay({0.0F, 0.0F, 1.0F}, {0.0F, 0.0F, -1.0F})); // on the diagonal
    for (const AccelForm form : kAccelForms) {
        const Hits hits = TraversalProbe(device, form).Closest(scene, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_TRUE(IsHit(hits[i]));
            EXPECT_NEAR(hits[i].t, 1.0F, 2e-7F); // two roundings
            EXPECT_EQ(PathOf(hits[i]), 0U);
            const float x = rays[i].origin[0];
            const float y = rays[i].origin[1];
            const std::uint32_t half = y > x ? 1 : 0;
            const PageView page(built.pages[hits[i].chunk].bytes.data());
            EXPECT_EQ(page.primIds[hits[i].triangle], half) << "ray " << i;
        }
    }
}

// The same placements as nested groups and flat. Maps by powers of two and whole numbers compose
// without rounding, so even the bits agree.
TEST_F(Traversal, NestedGroupsMatchFlattened) {
    const auto place = [](double x, double scale) {
        glm::dmat4 matrix(scale);
        matrix[3] = glm::dvec4(x, 0.5 * x, -x, 1.0);
        return matrix;
    };
    AccelScene nested;
    AccelScene flat;
    const std::uint32_t nestedMesh = nested.AddMesh(BumpySphere(12), 100);
    const std::uint32_t flatMesh = flat.AddMesh(BumpySphere(12), 100);
    std::vector<AccelPlacement> flattened = {{flatMesh, glm::dmat4(1.0), 0}};
    std::uint32_t object = nestedMesh;
    for (int level = 0; level < HDS_MAX_GROUP_DEPTH; ++level) {
        const std::vector<glm::dmat4> maps = {place(2.0, 0.5), place(-2.0, 1.0)};
        std::vector<AccelPlacement> group;
        std::vector<AccelPlacement> next;
        for (const glm::dmat4& map : maps) {
            group.push_back({object, map, 0});
            for (const AccelPlacement& leaf : flattened) {
                next.push_back({flatMesh, map * leaf.parentFromObject, 0});
            }
        }
        object = nested.AddGroup(group);
        flattened = next;
    }
    nested.SetRoot({{object, glm::dmat4(1.0), 0}, {nestedMesh, place(8.0, 4.0), 0}});
    flattened.push_back({flatMesh, place(8.0, 4.0), 0});
    flat.SetRoot(flattened);
    const DeviceAccelScene nestedScene(device, nested);
    const DeviceAccelScene flatScene(device, flat);
    UniformSource uniform(19);
    std::vector<ProbeRay> rays;
    for (int i = 0; i < 4000; ++i) {
        // Origins on a coarse grid stay exact in every space.
        const glm::vec3 origin = glm::round(12.0F * uniform.Vector());
        rays.push_back(
            MakeProbeRay(origin, glm::round(64.0F * (uniform.Vector() - origin / 16.0F))));
    }
    for (const AccelForm form : kAccelForms) {
        const TraversalProbe probe(device, form);
        const Hits a = probe.Closest(nestedScene, rays);
        const Hits b = probe.Closest(flatScene, rays);
        int numHits = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(IsHit(a[i]), IsHit(b[i])) << "ray " << i;
            if (IsHit(a[i])) {
                ++numHits;
                EXPECT_EQ(PathOf(a[i]), PathOf(b[i]));
                EXPECT_EQ(std::memcmp(&a[i], &b[i], 20), 0) << "t, u, v, triangle, chunk";
            }
        }
        EXPECT_GT(numHits, 200);
    }
}

TEST_F(Traversal, SkipsInstancesWithoutTheFlag) {
    AccelScene built;
    const std::uint32_t quad = built.AddMesh(StackedQuads(1));
    glm::dmat4 behind(1.0);
    behind[3].z = -1.0;
    built.SetRoot({{quad, glm::dmat4(1.0), 0}, {quad, behind, HDS_INSTANCE_CAMERA}});
    const DeviceAccelScene scene(device, built);
    const std::vector<ProbeRay> rays = {MakeProbeRay({0.25F, 0.0F, 1.0F}, {0.0F, 0.0F, -1.0F})};
    for (const AccelForm form : kAccelForms) {
        const TraversalProbe probe(device, form);
        EXPECT_EQ(probe.Closest(scene, rays)[0].t, 1.0F);
        EXPECT_EQ(probe.Closest(scene, rays, HDS_INSTANCE_CAMERA)[0].t, 2.0F);
        EXPECT_FALSE(IsHit(probe.Closest(scene, rays, HDS_INSTANCE_CAMERA | 0x100U)[0]));
    }
}

TEST_F(Traversal, SkipsChunksThatAreNotResident) {
    const MixedScene mixed;
    const std::vector<ProbeRay> rays = MixedRays(2000);
    AccelUpload upload;
    for (std::uint32_t chunk = 0; chunk < mixed.scene.pages.size(); ++chunk) {
        if (chunk % 2 == 0) {
            upload.missing.push_back(chunk);
        }
    }
    const DeviceAccelScene half(device, mixed.scene, upload);
    const Hits simd8 = TraversalProbe(device, true).Closest(half, rays);
    const Hits scalar = TraversalProbe(device, false).Closest(half, rays);
    EXPECT_EQ(CountDifferentBits(simd8, scalar), 0U);
    int numHits = 0;
    for (const shared::HdsHit& hit : simd8) {
        numHits += IsHit(hit) ? 1 : 0;
        EXPECT_TRUE(!IsHit(hit) || hit.chunk % 2 == 1);
    }
    EXPECT_GT(numHits, 50);
}

TEST_F(Traversal, TakesScenesOfNothing) {
    AccelScene empty;
    empty.topNodes.emplace_back();
    AccelScene emptyGroup;
    const std::uint32_t group = emptyGroup.AddGroup({});
    const std::uint32_t quad = emptyGroup.AddMesh(StackedQuads(1));
    emptyGroup.SetRoot({{group, glm::dmat4(1.0), 0}, {quad, glm::dmat4(1.0), 0}});
    const std::vector<ProbeRay> rays = {MakeProbeRay({0.25F, 0.0F, 1.0F}, {0.0F, 0.0F, -1.0F})};
    for (const AccelForm form : {AccelForm::Simd8, AccelForm::Scalar}) {
        const TraversalProbe probe(device, form);
        EXPECT_FALSE(IsHit(probe.Closest(DeviceAccelScene(device, empty), rays)[0]));
        EXPECT_TRUE(IsHit(probe.Closest(DeviceAccelScene(device, emptyGroup), rays)[0]));
    }
}

// Both ends of a ray are left out, so a hit at exactly tMin or tMax is none.
TEST_F(Traversal, LeavesOutBothEnds) {
    AccelScene built;
    built.SetRoot({{built.AddMesh(StackedQuads(1)), glm::dmat4(1.0), 0}});
    const DeviceAccelScene scene(device, built);
    const glm::vec3 origin(0.25F, 0.0F, 1.0F);
    const glm::vec3 down(0.0F, 0.0F, -1.0F);
    const std::vector<ProbeRay> rays = {
        MakeProbeRay(origin, down, 1.0F), MakeProbeRay(origin, down, std::nextafter(1.0F, 2.0F)),
        MakeProbeRay(origin, down, INFINITY, 1.0F),
        MakeProbeRay(origin, down, INFINITY, std::nextafter(1.0F, 0.0F))};
    for (const AccelForm form : kAccelForms) {
        const TraversalProbe probe(device, form);
        const Hits closest = probe.Closest(scene, rays);
        const Hits any = probe.Occluded(scene, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            EXPECT_EQ(IsHit(closest[i]), i % 2 == 1) << i;
            EXPECT_EQ(any[i].triangle == kBlocked, i % 2 == 1) << i;
        }
    }
}

// Two or three equal corners. (Triangles of three distinct corners on a line never get here:
// hds::Triangulate drops them.)
TEST_F(Traversal, TrianglesWithEqualCornersAreNeverHit) {
    TriangleMesh mesh;
    mesh.positions = {{-1, 0, 0}, {1, 0, 0}, {0.5F, 0, 0}, {0.3F, 0.7F, 0.1F}};
    mesh.triangles = {{0, 1, 0}, {0, 1, 1}, {2, 2, 1}, {3, 3, 3}, {3, 0, 3}};
    AccelScene built;
    built.SetRoot({{built.AddMesh(mesh), glm::dmat4(1.0), 0}});
    const DeviceAccelScene scene(device, built);
    UniformSource uniform(23);
    std::vector<ProbeRay> rays;
    for (int i = 0; i < 5000; ++i) {
        const glm::vec3 origin = uniform.Vector() + glm::vec3(0.0F, 0.0F, 2.0F);
        const glm::vec3 target = i % 2 == 0 ? glm::vec3(uniform(), 0.0F, 0.0F) : mesh.positions[3];
        rays.push_back(MakeProbeRay(origin, target - origin));
    }
    for (const AccelForm form : kAccelForms) {
        for (const shared::HdsHit& hit : TraversalProbe(device, form).Closest(scene, rays)) {
            EXPECT_FALSE(IsHit(hit));
        }
    }
}

} // namespace
} // namespace hds::test
