// SPDX-License-Identifier: Apache-2.0
// The flat hierarchy finds the hits of the other forms, to the bit, whatever it flattens.
#include "testenv/device/accel/mixedScene.h"

#include <algorithm>
#include <array>
#include <utility>

namespace hds::test {
namespace {

class FlatBvhTest : public DeviceFixture {
protected:
    /// Both kinds of hits against the form that walks level by level. \return hits.
    std::size_t ExpectSameHits(const AccelScene& built, const std::vector<ProbeRay>& rays,
                               const AccelUpload& upload = {}) {
        const DeviceAccelScene scene(device, built, upload);
        // With chunks of instances hits in groups name another record.
        const ProgramDefines defines = {
            {"HDS_FEATURE_INSTANCE_CHUNKS", built.numInstanceChunks > 0 ? "1" : "0"}};
        const TraversalProbe flat(device, AccelForm::Flat, defines);
        const TraversalProbe levels(device, AccelForm::Simd8, defines);
        const Hits expected = levels.Closest(scene, rays);
        EXPECT_EQ(CountDifferentBits(flat.Closest(scene, rays), expected), 0U);
        EXPECT_EQ(CountDifferentBits(flat.Occluded(scene, rays), levels.Occluded(scene, rays)), 0U);
        std::size_t numHits = 0;
        for (const shared::HdsHit& hit : expected) {
            numHits += IsHit(hit) ? 1 : 0;
        }
        return numHits;
    }
};

TEST_F(FlatBvhTest, MatchesBruteForceWhereAllIsFlat) {
    for (const auto& [isWide, areCopies] : {std::pair(false, false), std::pair(true, false),
                                            std::pair(false, true), std::pair(true, true)}) {
        const MixedScene mixed(isWide, true);
        const DeviceAccelScene scene(device, mixed.scene, areCopies ? kCopies : AccelUpload());
        ASSERT_GT(scene.Flat().numTriangles, areCopies ? 2000U : 20000U);
        ASSERT_EQ(scene.Flat().numCopies > 20, areCopies);
        ASSERT_FALSE(scene.Flat().hasInstances);
        const std::vector<ProbeRay> rays = MixedRays(2500);
        const Hits expected = TraversalProbe(device, AccelForm::Scalar).BruteForce(scene, rays);
        const ProgramDefines noInstances = {{"HDS_FEATURE_FLAT_INSTANCES", "0"},
                                            {"HDS_FEATURE_GROUPS", "0"}};
        for (const ProgramDefines& defines : {ProgramDefines(), noInstances}) {
            const TraversalProbe probe(device, AccelForm::Flat, defines);
            EXPECT_EQ(CountDifferentBits(probe.Closest(scene, rays), expected), 0U);
        }
    }
}

// Of random maps most are sheared too strongly: they stay instances.
TEST_F(FlatBvhTest, WalksInstancesThatAreNotFlattened) {
    const MixedScene mixed;
    const DeviceAccelScene scene(device, mixed.scene);
    ASSERT_TRUE(scene.Flat().hasInstances);
    ASSERT_GT(scene.Flat().numTriangles, 0U);
    EXPECT_GT(ExpectSameHits(mixed.scene, MixedRays(2500)), 250U);
    ASSERT_TRUE(DeviceAccelScene(device, mixed.scene, kCopies).Flat().hasInstances);
    ExpectSameHits(mixed.scene, MixedRays(2500), kCopies);
}

TEST_F(FlatBvhTest, FlattensWhatIsPlacedLeastOften) {
    AccelScene built;
    const std::uint32_t once = built.AddMesh(BumpySphere(12), 100);
    const std::uint32_t often = built.AddMesh(Box(0.7F), 100);
    std::vector<AccelPlacement> placements = {{once, glm::dmat4(1.0)}};
    for (int i = 0; i < 40; ++i) {
        placements.push_back(
            {often, glm::translate(glm::dmat4(1.0), glm::dvec3(i % 7, i % 5, i % 3) - 2.0)});
    }
    built.SetRoot(placements);
    const std::uint64_t ofAll = DeviceAccelScene(device, built).Flat().numTriangles;
    constexpr double kNoMatter = 1e9;
    for (const FlatAmount amount :
         {FlatAmount{ofAll - 1, kNoMatter, 0.1}, FlatAmount{ofAll, 39.0, 0.1, 0.0},
          FlatAmount{ofAll, 4.0, 0.5, static_cast<double>(ofAll - 1)}}) {
        const DeviceAccelScene scene(device, built, {1, {}, amount});
        const FlatBvh& flat = scene.Flat();
        EXPECT_EQ(ofAll - flat.numTriangles, 39 * 12U) << "the boxes";
        EXPECT_EQ(flat.numCopies, 40U);
        EXPECT_FALSE(flat.hasInstances);
        EXPECT_GT(ExpectSameHits(built, MixedRays(1000), {1, {}, amount}), 100U);
    }
    for (const FlatAmount amount :
         {FlatAmount{ofAll, 40.0, 1.0, 0.0},
          FlatAmount{ofAll, 4.0, 0.5, static_cast<double>(ofAll)}, FlatAmount{ofAll}}) {
        EXPECT_EQ(DeviceAccelScene(device, built, {1, {}, amount}).Flat().numTriangles, ofAll);
    }
    // A copy takes as much as 2.2 triangles.
    const std::uint64_t ofCopies = 12 + 22 * 40 / 10;
    EXPECT_EQ(DeviceAccelScene(device, built, {1, {}, {ofCopies - 1, kNoMatter, 0.0}})
                  .Flat()
                  .numTriangles,
              0U);
    EXPECT_EQ(
        DeviceAccelScene(device, built, {1, {}, {ofCopies, kNoMatter, 0.0}}).Flat().numTriangles,
        12U);
    EXPECT_TRUE(DeviceAccelScene(device, built, {1, {}, {ofCopies, kNoMatter, 0.8, 0.0}})
                    .Flat()
                    .buffer.empty())
        << "less than is asked for";
}

TEST_F(FlatBvhTest, FlattensGroupsOfAFewLevels) {
    for (int levels = 1; levels <= HDS_FLAT_MAX_RECORDS + 1; ++levels) {
        AccelScene built;
        const std::uint32_t mesh = built.AddMesh(BumpySphere(8), 60);
        const std::uint32_t floor = built.AddMesh(Box(3.0F), 60);
        UniformSource uniform(41);
        std::uint32_t object = mesh;
        const auto place = [&] {
            const glm::dmat4 moved =
                glm::translate(glm::dmat4(1.0), 1.5 * glm::dvec3(uniform.Vector()));
            return glm::scale(
                glm::rotate(moved, 3.0 * uniform(), glm::normalize(glm::dvec3(uniform.Vector()))),
                glm::dvec3(0.7));
        };
        for (int level = 1; level < levels; ++level) {
            object = built.AddGroup({{object, place()}, {object, place()}, {mesh, place()}});
        }
        built.SetRoot({{object, place()}, {floor, glm::dmat4(1.0)}, {object, place()}});
        const DeviceAccelScene scene(device, built);
        const FlatBvh& flat = scene.Flat();
        EXPECT_EQ(flat.hasInstances, levels > HDS_FLAT_MAX_RECORDS) << levels;
        EXPECT_GT(flat.numTriangles, 0U);
        EXPECT_GT(ExpectSameHits(built, MixedRays(1500)), 150U) << levels;
        const DeviceAccelScene copies(device, built, kCopies);
        EXPECT_EQ(copies.Flat().hasInstances, levels > HDS_FLAT_MAX_RECORDS) << levels;
        EXPECT_GT(copies.Flat().numCopies, 0U);
        ExpectSameHits(built, MixedRays(1500), kCopies);
    }
}

// However many records are on the way to a copy, its transforms are counted.
TEST_F(FlatBvhTest, CopiesBelowGroupsKeepTheLimit) {
    constexpr std::uint32_t kCopiesOfBox = 2000;
    constexpr std::uint64_t kTrianglesOfBox = 12;
    constexpr std::uint64_t kBytesOfBox = 2048; // its tree and the header, generously
    for (int levels = 1; levels <= HDS_FLAT_MAX_RECORDS; ++levels) {
        AccelScene built;
        std::uint32_t object = built.AddMesh(Box(0.1F), 60);
        for (int level = 1; level < levels; ++level) {
            object = built.AddGroup({{object, glm::translate(glm::dmat4(1.0), {0.1, 0.2, 0.3})}});
        }
        UniformSource uniform(43);
        std::vector<AccelPlacement> placements;
        for (std::uint32_t i = 0; i < kCopiesOfBox; ++i) {
            placements.push_back(
                {object, glm::translate(glm::dmat4(1.0), 20.0 * glm::dvec3(uniform.Vector()))});
        }
        built.SetRoot(placements);
        std::uint64_t fewest = 0; // triangles a copy, in tenths, of which there is a hierarchy
        for (std::uint64_t tenths = 10; tenths <= 40; ++tenths) {
            const std::uint64_t most = kTrianglesOfBox + tenths * kCopiesOfBox / 10;
            const DeviceAccelScene scene(device, built, {1, {}, {most, 0.0, 0.0, 0.0}});
            const FlatBvh& flat = scene.Flat();
            if (flat.numCopies > 0) {
                EXPECT_EQ(flat.numCopies, kCopiesOfBox);
                EXPECT_LE(flat.buffer.size(), most * kFlatBytesATriangle + kBytesOfBox)
                    << levels << " levels, " << tenths;
                fewest = fewest == 0 ? tenths : fewest;
            }
        }
        EXPECT_EQ(fewest, 14U + 8U * static_cast<std::uint64_t>(levels));
    }
}

// Meshes of one triangle fill no leaf, and each has a place and a transform of its own.
TEST_F(FlatBvhTest, PlacesOfFewTrianglesKeepTheLimit) {
    constexpr std::uint32_t kNumMeshes = 3000;
    AccelScene built;
    UniformSource uniform(44);
    std::vector<AccelPlacement> placements;
    for (std::uint32_t i = 0; i < kNumMeshes; ++i) {
        TriangleMesh mesh;
        mesh.positions = {{0.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}};
        mesh.triangles = {{0, 1, 2}};
        placements.push_back(
            {built.AddMesh(mesh, 60),
             glm::translate(glm::dmat4(1.0), 20.0 * glm::dvec3(uniform.Vector()))});
    }
    built.SetRoot(placements);
    const std::uint64_t whole = DeviceAccelScene(device, built).Flat().buffer.size();
    std::uint64_t most = 0; // triangles of any of them
    for (std::uint64_t percent = 20; percent <= 140; percent += 20) {
        FlatAmount amount{kNumMeshes, 4.0, 0.0};
        amount.maxBytes = static_cast<double>(whole * percent / 100);
        const DeviceAccelScene scene(device, built, {1, {}, amount});
        if (scene.Flat().numTriangles > 0) {
            // Instances that stay have boxes in its nodes.
            const std::uint64_t numLeft = kNumMeshes - scene.Flat().numTriangles;
            EXPECT_LE(scene.Flat().buffer.size(), amount.maxBytes + 80 * numLeft) << percent;
        }
        most = std::max(most, scene.Flat().numTriangles);
    }
    EXPECT_EQ(most, kNumMeshes);
}

/// A few groups and meshes all about, some of them an instancer's.
std::vector<AccelPlacement> PlaceAbout(const std::vector<std::uint32_t>& objects,
                                       std::uint32_t count, unsigned seed,
                                       std::uint32_t instanceCount) {
    UniformSource uniform(seed);
    std::vector<AccelPlacement> placements;
    for (std::uint32_t i = 0; i < count; ++i) {
        const glm::dmat4 moved =
            glm::translate(glm::dmat4(1.0), 2.0 * glm::dvec3(uniform.Vector()));
        placements.push_back(
            {objects[i % objects.size()],
             glm::rotate(moved, 3.0 * uniform(), glm::normalize(glm::dvec3(uniform.Vector())))});
        placements.back().instanceCount = i % 4 == 0 ? 0 : instanceCount;
    }
    return placements;
}

// Two of three records of the TLAS lie in chunks: those that no instancer places are flattened.
TEST_F(FlatBvhTest, FlattensWhatLiesInInstanceChunks) {
    for (const std::uint32_t numInChunk : {1U, 5U, 64U}) {
        std::uint64_t ofAll = 0;
        for (const std::uint32_t instanceCount : {0U, 9U}) {
            AccelScene built;
            const std::uint32_t mesh = built.AddMesh(BumpySphere(8), 60);
            const std::uint32_t box = built.AddMesh(Box(0.5F), 60);
            const std::uint32_t group = built.AddGroup(PlaceAbout({mesh, box}, 5, 51, 0));
            built.SetRoot(PlaceAbout({mesh, group, box}, 50, 53, instanceCount), numInChunk);
            ASSERT_GT(built.numInstanceChunks, 0U);
            const DeviceAccelScene scene(device, built);
            const FlatBvh& flat = scene.Flat();
            EXPECT_EQ(flat.hasInstances, instanceCount > 0);
            EXPECT_GT(flat.numTriangles, 0U);
            EXPECT_TRUE(instanceCount == 0 || flat.numTriangles < ofAll);
            ofAll = flat.numTriangles;
            EXPECT_GT(ExpectSameHits(built, MixedRays(1500)), 300U) << numInChunk;
            EXPECT_GT(DeviceAccelScene(device, built, kCopies).Flat().numCopies, 0U);
            ExpectSameHits(built, MixedRays(1500), kCopies);
        }
    }
}

// A group with chunks stays an instance, and what it places counts.
TEST_F(FlatBvhTest, FlattensWhatIsBesideAGroupWithChunks) {
    AccelScene built;
    const std::uint32_t mesh = built.AddMesh(BumpySphere(8), 60);
    const std::uint32_t large = built.AddMesh(BumpySphere(40), 200);
    const std::uint32_t inner = built.AddGroup(PlaceAbout({mesh}, 3, 57, 0));
    const std::uint32_t group = built.AddGroup(PlaceAbout({mesh, inner}, 60, 59, 60), 7);
    const std::uint32_t outer = built.AddGroup({{group, glm::dmat4(1.0)}, {mesh, glm::dmat4(1.0)}});
    built.SetRoot(PlaceAbout({group, large, outer}, 6, 61, 0));
    const DeviceAccelScene scene(device, built);
    const FlatBvh& flat = scene.Flat();
    EXPECT_TRUE(flat.hasInstances);
    const auto trianglesOf = [&](const AccelScene& alone) {
        return DeviceAccelScene(device, alone).Flat().numTriangles;
    };
    AccelScene alone;
    const std::uint32_t largeAlone = alone.AddMesh(BumpySphere(40), 200);
    alone.SetRoot({{largeAlone, glm::dmat4(1.0)}});
    EXPECT_EQ(flat.numTriangles, 2 * trianglesOf(alone));
    EXPECT_GT(ExpectSameHits(built, MixedRays(1500)), 300U);
    constexpr double kNoMatter = 1e9;
    const auto isThere = [&](double minShare) {
        const FlatAmount amount{1U << 28U, kNoMatter, minShare};
        return !DeviceAccelScene(device, built, {1, {}, amount}).Flat().buffer.empty();
    };
    AccelScene one;
    const std::uint32_t meshAlone = one.AddMesh(BumpySphere(8), 60);
    one.SetRoot({{meshAlone, glm::dmat4(1.0)}});
    // Four placements of the group, of 30 meshes and 30 times three; twice one mesh beside it.
    const double ofMesh = static_cast<double>(trianglesOf(one));
    const double placed = static_cast<double>(flat.numTriangles) + (4 * 120 + 2) * ofMesh;
    const double share = static_cast<double>(flat.numTriangles) / placed;
    EXPECT_TRUE(isThere(share * 0.999));
    EXPECT_FALSE(isThere(share * 1.001));
}

TEST_F(FlatBvhTest, TellsCutoutsFromBlockers) {
    UniformSource uniform(43);
    AccelScene built;
    const std::array<std::uint32_t, 2> meshes = {built.AddMesh(Foliage(400, 5), 100),
                                                 built.AddMesh(BumpySphere(6), 100)};
    std::vector<AccelPlacement> placements;
    for (std::uint32_t i = 0; i < 40; ++i) {
        const glm::dvec3 away = 2.5 * glm::dvec3(uniform.Vector());
        placements.push_back({meshes[i % 2], glm::translate(glm::dmat4(1.0), away),
                              HDS_INSTANCE_SEEN | (i % 3 == 0 ? 0U : HDS_INSTANCE_CUTOUT)});
    }
    built.SetRoot(placements);
    const DeviceAccelScene scene(device, built);
    ASSERT_FALSE(scene.Flat().hasInstances);
    const std::vector<ProbeRay> rays = MixedRays(3000);
    const Hits found = TraversalProbe(device, AccelForm::Simd8).Occluded(scene, rays);
    int numBlocked = 0;
    int numCandidates = 0;
    for (const shared::HdsHit& hit : found) {
        numBlocked += hit.triangle == kBlocked ? 1 : 0;
        numCandidates += IsHit(hit) ? 1 : 0;
    }
    EXPECT_GT(numBlocked, 300);
    EXPECT_GT(numCandidates, 300);
    ExpectSameHits(built, rays);
    ASSERT_EQ(DeviceAccelScene(device, built, kCopies).Flat().numCopies, 40U);
    ExpectSameHits(built, rays, kCopies);
}

TEST_F(FlatBvhTest, CopiesAreSeenByWhomTheyAreForAndGoneOnBehind) {
    UniformSource uniform(47);
    AccelScene built;
    const std::array<std::uint32_t, 2> meshes = {built.AddMesh(BumpySphere(9), 100),
                                                 built.AddMesh(Box(0.6F), 100)};
    std::vector<AccelPlacement> placements;
    for (std::uint32_t i = 0; i < 60; ++i) {
        const glm::dvec3 away = 2.5 * glm::dvec3(uniform.Vector());
        const std::uint32_t hidden = i % 3 == 0 ? std::uint32_t{HDS_INSTANCE_CAMERA} : 0U;
        placements.push_back(
            {meshes[i % 2], glm::translate(glm::dmat4(1.0), away), HDS_INSTANCE_SEEN & ~hidden});
    }
    built.SetRoot(placements);
    const DeviceAccelScene scene(device, built, kCopies);
    ASSERT_EQ(scene.Flat().numCopies, 60U);
    const std::vector<ProbeRay> rays = MixedRays(2000);
    const TraversalProbe flat(device, AccelForm::Flat);
    const TraversalProbe levels(device, AccelForm::Simd8);
    const Hits ofAll = levels.Closest(scene, rays, 0U);
    const Hits seen = levels.Closest(scene, rays, HDS_INSTANCE_CAMERA);
    EXPECT_GT(CountDifferentBits(ofAll, seen), 50U);
    EXPECT_EQ(CountDifferentBits(flat.Closest(scene, rays, 0U), ofAll), 0U);
    EXPECT_EQ(CountDifferentBits(flat.Closest(scene, rays, HDS_INSTANCE_CAMERA), seen), 0U);
    std::vector<ProbeKey> after(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (IsHit(ofAll[i])) {
            std::memcpy(after[i].word, &ofAll[i].t, sizeof(float));
            after[i].word[1] = ofAll[i].pathIndex[0];
            after[i].word[2] = ofAll[i].pathIndex[1];
            after[i].word[3] = HDS_NONE; // all of that place
        }
    }
    const Hits behind = levels.Closest(scene, rays, 0U, after);
    EXPECT_GT(CountDifferentBits(ofAll, behind), 200U);
    EXPECT_EQ(CountDifferentBits(flat.Closest(scene, rays, 0U, after), behind), 0U);
}

// Cameras without a focal length make such rays.
TEST_F(FlatBvhTest, TakesRaysThatAreNone) {
    const MixedScene mixed(false, true);
    std::vector<ProbeRay> rays = MixedRays(400);
    const float values[] = {NAN, INFINITY, -INFINITY, 0.0F};
    for (std::size_t i = 0; i < rays.size(); ++i) {
        float* of = i % 3 == 0 ? rays[i].origin : rays[i].direction;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (axis <= i % 5) { // one, two or all
                of[axis] = values[i % 4];
            }
        }
    }
    ExpectSameHits(mixed.scene, rays);
    ExpectSameHits(mixed.scene, rays, kCopies);
}

// With the shortest the distance of planes, in lengths of the direction, is no float.
TEST_F(FlatBvhTest, TakesDirectionsOfAnyLength) {
    const MixedScene mixed(false, true);
    const DeviceAccelScene scene(device, mixed.scene);
    const DeviceAccelScene copies(device, mixed.scene, kCopies);
    const TraversalProbe flat(device, AccelForm::Flat);
    const TraversalProbe scalar(device, AccelForm::Scalar);
    for (const float length : {1e-29F, 1e-20F, 1e20F}) {
        std::vector<ProbeRay> rays = MixedRays(1000);
        for (ProbeRay& ray : rays) {
            for (float& component : ray.direction) {
                component *= length;
            }
            ray.tMin = 0.0F;
            ray.tMax = INFINITY;
        }
        const Hits expected = scalar.BruteForce(scene, rays);
        EXPECT_GT(std::count_if(expected.begin(), expected.end(), IsHit), 100) << length;
        EXPECT_EQ(CountDifferentBits(flat.Closest(scene, rays), expected), 0U) << length;
        EXPECT_EQ(CountDifferentBits(flat.Closest(copies, rays), expected), 0U) << length;
    }
}

TEST_F(FlatBvhTest, TakesScenesOfNothing) {
    AccelScene built;
    const std::uint32_t group = built.AddGroup({});
    built.SetRoot({{group, glm::dmat4(1.0)}});
    built.AddMesh(Box(1.0F));
    EXPECT_EQ(DeviceAccelScene(device, built).Flat().numTriangles, 0U);
}

} // namespace
} // namespace hds::test
