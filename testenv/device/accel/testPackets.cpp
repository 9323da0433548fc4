// SPDX-License-Identifier: Apache-2.0
// Eight rays that walk the flat hierarchy together find what each of them finds alone, to the bit.
#include "testenv/device/accel/mixedScene.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hds::test {
namespace {

constexpr std::size_t kLanes = 8;

/// Bunches of eight rays: like those of a pixel, of a lens, and ever wider ones, some of which go
/// apart. They begin and end at different distances.
std::vector<ProbeRay> Bunches(std::size_t count) {
    UniformSource uniform(23);
    std::vector<ProbeRay> rays;
    for (std::size_t i = 0; i < count; ++i) {
        glm::vec3 origin = 4.0F * uniform.Vector();
        glm::vec3 direction = uniform.Vector();
        const float spread = std::pow(10.0F, -static_cast<float>(i % 5)); // 1 to 1e-4
        const float lens = i % 3 == 0 ? 0.0F : 0.1F * spread;
        if (i % 7 == 1) {
            direction = {i % 2 == 0 ? 1.0F : -1.0F, 0.0F, -0.0F}; // along an axis
        }
        if (i % 7 == 2) {
            direction.y = direction.x; // two axes are the largest by turns
        }
        if (i % 7 == 3) {
            origin -= 1000.0F * direction;
        }
        const float size = i % 11 == 5 ? 1e-4F : 1.0F;
        for (std::size_t k = 0; k < kLanes; ++k) {
            const glm::vec3 way =
                i % 7 == 1 ? direction : direction + spread * 0.3F * uniform.Vector();
            rays.push_back(MakeProbeRay(origin + lens * uniform.Vector(), size * way,
                                        k % 4 == 3 ? 3.0F : INFINITY, k % 5 == 4 ? 0.5F : 0.0F));
        }
    }
    return rays;
}

class PacketTest : public CpuDeviceFixture {
protected:
    const ProgramDefines defines = {{"HDS_ITEMS_PER_WORK_ITEM", "8"}};

    /// Compares packets with the form that walks level by level. \return the part of the packets
    /// that were traced together.
    double ExpectSameHits(const DeviceAccelScene& scene, const std::vector<ProbeRay>& rays,
                          std::uint32_t flagMask, const std::vector<ProbeKey>& after, Hits* hits) {
        *hits = TraversalProbe(device, AccelForm::Simd8, {{"HDS_FEATURE_INSTANCE_CHUNKS", "0"}})
                    .Closest(scene, rays, flagMask, after);
        const Hits found =
            TraversalProbe(device, AccelForm::Flat, defines).Packets(scene, rays, flagMask, after);
        std::size_t numTogether = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (found[i].triangle != kApart) {
                ++numTogether;
                EXPECT_EQ(std::memcmp(&found[i], &(*hits)[i], sizeof(found[i])), 0) << "ray " << i;
            }
        }
        return static_cast<double>(numTogether) / static_cast<double>(rays.size());
    }
};

TEST_F(PacketTest, FindsWhatEachRayFindsAlone) {
    const std::vector<ProbeRay> rays = Bunches(1500);
    for (const auto& [isRigid, areCopies] :
         {std::pair(true, false), std::pair(false, false), std::pair(true, true)}) {
        const MixedScene mixed(!isRigid, isRigid);
        const DeviceAccelScene scene(device, mixed.scene, areCopies ? kCopies : AccelUpload());
        ASSERT_EQ(scene.Flat().hasInstances, !isRigid) << "both are walked";
        ASSERT_EQ(scene.Flat().numCopies > 0, areCopies);
        Hits hits;
        for (const std::uint32_t flagMask : {0U, std::uint32_t{HDS_INSTANCE_CAMERA}}) {
            const double together = ExpectSameHits(scene, rays, flagMask, {}, &hits);
            EXPECT_GT(together, 0.6);
            EXPECT_LT(together, 0.95) << "wide bunches go apart";
        }
        std::vector<ProbeKey> after(rays.size());
        std::size_t numHits = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (IsHit(hits[i]) && i % 3 != 0) { // of one packet some go on, and some begin
                ++numHits;
                std::memcpy(after[i].word, &hits[i].t, sizeof(float));
                after[i].word[1] = hits[i].pathIndex[0];
                after[i].word[2] = hits[i].pathIndex[1];
                after[i].word[3] = 0;
            }
        }
        EXPECT_GT(numHits, 1000U);
        EXPECT_GT(ExpectSameHits(scene, rays, 0, after, &hits), 0.6);
    }
}

TEST_F(PacketTest, LeavesWhatGoesApartOrNowhere) {
    const MixedScene mixed(false, true);
    const DeviceAccelScene scene(device, mixed.scene);
    std::vector<ProbeRay> rays(3 * kLanes,
                               MakeProbeRay({0.0F, 0.0F, -9.0F}, {0.01F, -0.02F, 1.0F}));
    rays[kLanes + 5].direction[0] = -0.01F;
    rays[2 * kLanes + 7].direction[1] = NAN;
    const Hits hits = TraversalProbe(device, AccelForm::Flat, defines).Packets(scene, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(hits[i].triangle == kApart, i >= kLanes);
    }
}

TEST_F(PacketTest, GivesUpWhereRaysShareLittle) {
    AccelScene dense;
    const std::uint32_t foliage = dense.AddMesh(Foliage(20000, 5));
    dense.SetRoot({{foliage, glm::dmat4(1.0), HDS_INSTANCE_SEEN}});
    const DeviceAccelScene scene(device, dense);
    const TraversalProbe probe(device, AccelForm::Flat, defines);
    const auto partTogether = [&](float spread) {
        UniformSource uniform(3);
        std::vector<ProbeRay> rays;
        for (std::size_t packet = 0; packet < 100; ++packet) {
            const glm::vec3 eye(6.0F, 5.0F, 4.0F);
            const glm::vec3 target = 0.5F * uniform.Vector();
            for (std::size_t k = 0; k < kLanes; ++k) {
                rays.push_back(MakeProbeRay(eye, target + spread * uniform.Vector() - eye));
            }
        }
        const Hits hits = probe.Packets(scene, rays);
        return static_cast<double>(
                   std::count_if(hits.begin(), hits.end(),
                                 [](const auto& hit) { return hit.triangle != kApart; })) /
               static_cast<double>(hits.size());
    };
    EXPECT_GT(partTogether(1e-3F), 0.95);
    EXPECT_LT(partTogether(0.7F), 0.05) << "the directions of each have equal signs";
}

} // namespace
} // namespace hds::test
