// SPDX-License-Identifier: Apache-2.0
// Rays that go on after a key enumerate every hit once, in the order of (t, path index, primId);
// shadow rays tell opaque blockers from cut-out candidates.
#include "testenv/device/accel/traversalProbe.h"
#include "testenv/support/traversalMeshes.h"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace hds::test {
namespace {

using Hits = std::vector<shared::HdsHit>;
using Key = std::tuple<float, std::uint64_t, std::uint32_t>;

std::uint32_t PrimIdOf(const AccelScene& scene, const shared::HdsHit& hit) {
    return PageView(scene.pages[hit.chunk].bytes.data()).primIds[hit.triangle];
}

Key KeyOf(const AccelScene& scene, const shared::HdsHit& hit) {
    return {hit.t, PathOf(hit), PrimIdOf(scene, hit)};
}

ProbeKey Encode(const Key& key) {
    ProbeKey word;
    std::memcpy(&word.word[0], &std::get<0>(key), 4);
    word.word[1] = static_cast<std::uint32_t>(std::get<1>(key));
    word.word[2] = static_cast<std::uint32_t>(std::get<1>(key) >> 32U);
    word.word[3] = std::get<2>(key);
    return word;
}

/// Layers of quads, several of them at the same height and in several instances.
AccelScene LayeredScene(std::uint32_t flags) {
    TriangleMesh mesh;
    for (std::uint32_t layer = 0; layer < 10; ++layer) {
        const auto z = static_cast<float>(layer / 2);
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const glm::vec3& corner :
             {glm::vec3(-1, -1, z), glm::vec3(1, -1, z), glm::vec3(1, 1, z), glm::vec3(-1, 1, z)}) {
            mesh.positions.push_back(corner);
        }
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.triangles.emplace_back(first, first + 2, first + 3);
    }
    AccelScene scene;
    const std::uint32_t layers = scene.AddMesh(mesh, 4);
    glm::dmat4 shifted(1.0);
    shifted[3].z = 2.0;
    scene.SetRoot({{layers, glm::dmat4(1.0), flags},
                   {layers, shifted, flags},
                   {layers, glm::dmat4(1.0), flags}});
    return scene;
}

std::vector<ProbeRay> DownRays(std::size_t count) {
    UniformSource uniform(29);
    std::vector<ProbeRay> rays;
    for (std::size_t i = 0; i < count; ++i) {
        rays.push_back(MakeProbeRay({0.9F * uniform(), 0.9F * uniform(), 9.0F},
                                    {0.0F, 0.0F, i % 2 == 0 ? -1.0F : -0.5F}));
    }
    rays.push_back(MakeProbeRay({0.0F, 0.0F, 9.0F}, {0.0F, 0.0F, -1.0F})); // on every diagonal
    return rays;
}

class ContinuedRays : public DeviceFixture {
protected:
    /// Follows all rays hit by hit.
    template <typename Next>
    void ExpectEnumeration(const AccelScene& built, const std::vector<ProbeRay>& rays,
                           const Next& next) {
        std::vector<ProbeKey> after(rays.size());
        std::vector<std::vector<Key>> keys(rays.size());
        for (int pass = 0; pass < 70; ++pass) {
            const Hits hits = next(after);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                if (IsHit(hits[i])) {
                    keys[i].push_back(KeyOf(built, hits[i]));
                    after[i] = Encode(keys[i].back());
                }
            }
        }
        for (std::size_t i = 0; i < rays.size(); ++i) {
            // 3 instances of 10 quads; the last ray lies on the diagonals and meets both halves.
            EXPECT_EQ(keys[i].size(), i + 1 == rays.size() ? 60U : 30U) << "ray " << i;
            EXPECT_TRUE(std::is_sorted(keys[i].begin(), keys[i].end()));
            EXPECT_EQ(std::adjacent_find(keys[i].begin(), keys[i].end()), keys[i].end());
        }
    }
};

TEST_F(ContinuedRays, EnumerateEveryHitInOrder) {
    const AccelScene built = LayeredScene(0);
    const DeviceAccelScene scene(device, built);
    const std::vector<ProbeRay> rays = DownRays(60);
    for (const AccelForm form : kAccelForms) {
        const TraversalProbe probe(device, form);
        ExpectEnumeration(built, rays, [&](const std::vector<ProbeKey>& after) {
            return probe.Closest(scene, rays, 0, after);
        });
    }
}

TEST_F(ContinuedRays, ShadowRaysEnumerateCutouts) {
    const AccelScene built = LayeredScene(HDS_INSTANCE_CUTOUT);
    const DeviceAccelScene scene(device, built);
    const std::vector<ProbeRay> rays = DownRays(60);
    for (const AccelForm form : kAccelForms) {
        const TraversalProbe probe(device, form);
        ExpectEnumeration(built, rays, [&](const std::vector<ProbeKey>& after) {
            return probe.Occluded(scene, rays, after);
        });
    }
}

// A soup continued from random keys: the same bits as without hierarchy.
TEST_F(ContinuedRays, MatchBruteForceOnASoup) {
    AccelScene built;
    const std::uint32_t soup = built.AddMesh(Foliage(800, 31), 200);
    built.SetRoot({{soup, glm::dmat4(1.0), HDS_INSTANCE_CUTOUT}, {soup, glm::dmat4(1.5), 0}});
    const DeviceAccelScene scene(device, built);
    UniformSource uniform(37);
    std::vector<ProbeRay> rays;
    for (int i = 0; i < 1500; ++i) {
        rays.push_back(MakeProbeRay(2.0F * uniform.Vector(), uniform.Vector()));
    }
    const TraversalProbe simd8(device, true);
    const TraversalProbe scalar(device, false);
    const TraversalProbe flat(device, AccelForm::Flat);
    std::vector<ProbeKey> after(rays.size());
    for (int pass = 0; pass < 4; ++pass) {
        const Hits expected = scalar.BruteForce(scene, rays, after);
        const Hits bySimd8 = simd8.Closest(scene, rays, 0, after);
        const Hits byScalar = scalar.Closest(scene, rays, 0, after);
        const Hits byFlat = flat.Closest(scene, rays, 0, after);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(std::memcmp(&bySimd8[i], &expected[i], sizeof(expected[i])), 0) << i;
            ASSERT_EQ(std::memcmp(&byScalar[i], &expected[i], sizeof(expected[i])), 0) << i;
            ASSERT_EQ(std::memcmp(&byFlat[i], &expected[i], sizeof(expected[i])), 0) << i;
            if (IsHit(expected[i])) {
                after[i] = Encode(KeyOf(built, expected[i]));
            }
        }
    }
}

// Blocked means: some hit on an opaque instance counts, wherever the cut-outs are. Otherwise the
// candidate is the closest hit.
TEST_F(ContinuedRays, OpaqueBlockersWinOverCandidates) {
    AccelScene both;
    AccelScene opaqueOnly;
    std::vector<AccelPlacement> placements;
    std::vector<AccelPlacement> opaquePlacements;
    const std::uint32_t soup = both.AddMesh(Foliage(300, 41), 100);
    const std::uint32_t opaqueSoup = opaqueOnly.AddMesh(Foliage(300, 41), 100);
    UniformSource uniform(43);
    for (int i = 0; i < 8; ++i) {
        glm::dmat4 matrix(1.0);
        matrix[3] = glm::dvec4(2.0 * glm::dvec3(uniform.Vector()), 1.0);
        placements.push_back({soup, matrix, i % 2 == 0 ? HDS_INSTANCE_CUTOUT : 0U});
        if (i % 2 == 1) {
            opaquePlacements.push_back({opaqueSoup, matrix, 0});
        }
    }
    both.SetRoot(placements);
    opaqueOnly.SetRoot(opaquePlacements);
    const DeviceAccelScene bothScene(device, both);
    const DeviceAccelScene opaqueScene(device, opaqueOnly);
    std::vector<ProbeRay> rays;
    for (int i = 0; i < 3000; ++i) {
        rays.push_back(MakeProbeRay(3.0F * uniform.Vector(), uniform.Vector(), 3.0F));
    }
    int numBlocked = 0;
    int numCandidates = 0;
    for (const AccelForm form : kAccelForms) {
        const TraversalProbe probe(device, form);
        const Hits blockers = probe.BruteForce(opaqueScene, rays);
        const Hits closest = probe.BruteForce(bothScene, rays);
        const Hits answers = probe.Occluded(bothScene, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(answers[i].triangle == kBlocked, IsHit(blockers[i])) << i;
            if (IsHit(blockers[i])) {
                ++numBlocked;
                continue;
            }
            ASSERT_EQ(std::memcmp(&answers[i], &closest[i], sizeof(closest[i])), 0) << i;
            numCandidates += IsHit(closest[i]) ? 1 : 0;
        }
    }
    EXPECT_GT(numBlocked, 100);
    EXPECT_GT(numCandidates, 100);
}

} // namespace
} // namespace hds::test
