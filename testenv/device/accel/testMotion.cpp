// SPDX-License-Identifier: Apache-2.0
// Rays at a time find what they find in a still scene in the pose of that time; both forms of the
// traversal agree with a kernel without hierarchy to the bit, so boxes hold what moves.
#include "hdStream/geometry/curveSource.h"
#include "hdStream/geometry/pointSource.h"
#include "hdStream/geometry/polygonSource.h"
#include "testenv/device/accel/traversalProbe.h"
#include "testenv/support/pageView.h"
#include "testenv/support/traversalMeshes.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hds::test {
namespace {

using Hits = std::vector<shared::HdsHit>;

const ProgramDefines kMotion{{"HDS_FEATURE_MOTION", "1"}, {"HDS_FEATURE_CURVES", "1"}};

/// \param time of all rays; below 0: each has one of its own.
std::vector<ProbeRay> RaysAt(float time, std::size_t count) {
    UniformSource uniform(5);
    std::vector<ProbeRay> rays;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 origin = 4.0F * uniform.Vector();
        const glm::vec3 target = 1.5F * uniform.Vector();
        const float own = 0.5F + 0.5F * uniform();
        rays.push_back(MakeProbeRay(origin, target - origin, INFINITY, time < 0.0F ? own : time));
    }
    return rays;
}

std::size_t CountDifferentBits(const Hits& a, const Hits& b) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        count += std::memcmp(&a[i], &b[i], sizeof(a[i])) != 0 ? 1 : 0;
    }
    return count;
}

/// The pose between keys, with textbook arithmetic.
glm::dmat4 PoseAt(const std::vector<glm::dmat4>& keys, double time) {
    const double scaled = time * double(keys.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(scaled), keys.size() - 2);
    const double part = scaled - double(i);
    return (1.0 - part) * keys[i] + part * keys[i + 1];
}

/// Placements with 1 to 4 segments of turns, stretches and ways; every fourth is at rest.
std::vector<AccelPlacement> MovingPlacements(const std::vector<std::uint32_t>& objects) {
    UniformSource uniform(17);
    std::vector<AccelPlacement> placements;
    for (std::uint32_t i = 0; i < 12; ++i) {
        AccelPlacement placement;
        placement.object = objects[i % objects.size()];
        const glm::dvec3 centre = 1.5 * glm::dvec3(uniform.Vector());
        const glm::dvec3 way = glm::dvec3(uniform.Vector());
        const glm::dvec3 axis = glm::dvec3(uniform.Vector()) + glm::dvec3(0.0, 0.0, 1.1);
        const std::uint32_t segments = 1 + i % 4;
        for (std::uint32_t k = 0; k <= segments; ++k) {
            const double time = double(k) / segments;
            glm::dmat4 pose = glm::translate(glm::dmat4(1.0), centre + time * way);
            pose = glm::rotate(pose, time * 1.2, axis);
            placement.keys.push_back(glm::scale(pose, glm::dvec3(0.5 + 0.3 * time, 0.6, 0.4)));
        }
        placement.parentFromObject = placement.keys[0];
        if (i % 4 == 3) {
            placement.keys.clear();
        }
        placements.push_back(placement);
    }
    return placements;
}

/// Equal hits but for a few at silhouettes, and for rounding.
void ExpectSameHits(const Hits& found, const Hits& expected) {
    std::size_t numHits = 0;
    std::size_t numDifferent = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        numHits += IsHit(expected[i]) ? 1 : 0;
        const bool isSame =
            IsHit(found[i]) == IsHit(expected[i]) &&
            (!IsHit(found[i]) || (PathOf(found[i]) == PathOf(expected[i]) &&
                                  std::fabs(found[i].t - expected[i].t) < 1e-4F * expected[i].t));
        numDifferent += isSame ? 0 : 1;
    }
    EXPECT_GT(numHits, found.size() / 10) << "the test would show little";
    EXPECT_LT(numDifferent, found.size() / 500);
}

class Motion : public DeviceFixture {
protected:
    void ExpectBitsOfBruteForce(const AccelScene& scene) {
        const DeviceAccelScene onDevice(device, scene);
        const std::vector<ProbeRay> rays = RaysAt(-1.0F, 2500);
        const TraversalProbe simd8(device, true, kMotion);
        const TraversalProbe scalar(device, false, kMotion);
        const Hits expected = scalar.BruteForce(onDevice, rays);
        EXPECT_EQ(CountDifferentBits(simd8.Closest(onDevice, rays), expected), 0U);
        EXPECT_EQ(CountDifferentBits(scalar.Closest(onDevice, rays), expected), 0U);
        for (const TraversalProbe* probe : {&simd8, &scalar}) {
            const Hits blocked = probe->Occluded(onDevice, rays);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(blocked[i].triangle == kBlocked, IsHit(expected[i])) << "ray " << i;
            }
        }
    }
};

TEST_F(Motion, InstancesAreWhereTheirPoseIs) {
    const TraversalProbe moving(device, true, kMotion);
    const TraversalProbe still(device, true);
    AccelScene scene;
    const std::uint32_t inner = scene.AddMesh(BumpySphere(12), 100);
    const std::vector<AccelPlacement> members = MovingPlacements({inner});
    const std::uint32_t group = scene.AddGroup({members.begin(), members.begin() + 2});
    const std::vector<AccelPlacement> roots = MovingPlacements({inner, group});
    scene.SetRoot(roots);
    const DeviceAccelScene onDevice(device, scene);
    for (const double time : {0.0, 0.31, 0.75, 1.0}) {
        const auto pose = [time](std::vector<AccelPlacement> placements) {
            for (AccelPlacement& placement : placements) {
                if (!placement.keys.empty()) {
                    placement.parentFromObject = PoseAt(placement.keys, time);
                    placement.keys.clear();
                }
            }
            return placements;
        };
        AccelScene posed;
        posed.AddMesh(BumpySphere(12), 100);
        posed.AddGroup(pose({members.begin(), members.begin() + 2}));
        posed.SetRoot(pose(roots));
        ExpectSameHits(moving.Closest(onDevice, RaysAt(static_cast<float>(time), 1500)),
                       still.Closest(DeviceAccelScene(device, posed), RaysAt(0.0F, 1500)));
    }
}

TEST_F(Motion, BoxesOfInstancesHoldAllPoses) {
    AccelScene scene;
    const std::uint32_t sphere = scene.AddMesh(BumpySphere(12), 100);
    const std::uint32_t box = scene.AddMesh(Box(0.7F));
    scene.SetRoot(MovingPlacements({sphere, box}));
    ExpectBitsOfBruteForce(scene);
}

// What rests is flattened, and what moves stays an instance: moving placements, and groups that
// move or hold what moves.
TEST_F(Motion, TheFlatHierarchyWalksWhatMoves) {
    if (!device->Properties().isCpu) {
        GTEST_SKIP() << "of CPUs alone";
    }
    AccelScene scene;
    const std::uint32_t sphere = scene.AddMesh(BumpySphere(12), 100);
    const std::uint32_t box = scene.AddMesh(Box(0.7F));
    const std::vector<AccelPlacement> members = MovingPlacements({sphere});
    const std::uint32_t moving = scene.AddGroup({members.begin() + 2, members.begin() + 4});
    const std::uint32_t resting = scene.AddGroup({members[3], members[7]});
    scene.SetRoot(MovingPlacements({sphere, box, moving, resting, box}));
    const DeviceAccelScene onDevice(device, scene);
    ASSERT_GT(onDevice.Flat().numTriangles, 500U);
    ASSERT_TRUE(onDevice.Flat().hasInstances);
    ASSERT_NE(scene.objects[0].kind >> HDS_OBJECT_CLOSE_SHIFT, 0U) << "boxes of the TLAS move";
    std::vector<ProbeRay> rays;
    for (const ProbeRay& ray : RaysAt(-1.0F, 1000)) {
        for (int k = 0; k < 8; ++k) {
            rays.push_back(ray);
            rays.back().tMin = std::fmod(ray.tMin + 0.3F * static_cast<float>(k), 1.0F);
            rays.back().direction[k % 3] += 0.01F * static_cast<float>(k);
        }
    }
    ProgramDefines wide = kMotion;
    wide["HDS_ITEMS_PER_WORK_ITEM"] = "8";
    const TraversalProbe levels(
        device, AccelForm::Simd8,
        {{"HDS_FEATURE_MOTION", "1"}, {"HDS_FEATURE_INSTANCE_CHUNKS", "0"}});
    const TraversalProbe flat(device, AccelForm::Flat, wide);
    const Hits expected = levels.Closest(onDevice, rays);
    EXPECT_EQ(CountDifferentBits(flat.Closest(onDevice, rays), expected), 0U);
    EXPECT_EQ(CountDifferentBits(flat.Occluded(onDevice, rays), levels.Occluded(onDevice, rays)),
              0U);
    const Hits together = flat.Packets(onDevice, rays);
    std::size_t numTogether = 0;
    std::size_t numHits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (together[i].triangle != kApart) {
            ++numTogether;
            numHits += IsHit(expected[i]) ? 1 : 0;
            ASSERT_EQ(std::memcmp(&together[i], &expected[i], sizeof(expected[i])), 0) << i;
        }
    }
    EXPECT_GT(numTogether, rays.size() / 2);
    EXPECT_GT(numHits, numTogether / 10);
}

/// A wavy sheet of quads that folds over while the shutter is open.
std::shared_ptr<GeometryDescription> Sheet() {
    constexpr int kSize = 24;
    auto mesh = std::make_shared<GeometryDescription>();
    std::vector<float> open;
    std::vector<float> close;
    std::vector<std::int32_t> counts;
    std::vector<std::int32_t> indices;
    for (int y = 0; y <= kSize; ++y) {
        for (int x = 0; x <= kSize; ++x) {
            const float u = 2.0F * static_cast<float>(x) / kSize - 1.0F;
            const float v = 2.0F * static_cast<float>(y) / kSize - 1.0F;
            const float bump = 0.3F * std::sin(9.0F * u) * std::cos(7.0F * v);
            open.insert(open.end(), {2.0F * u, 2.0F * v, bump});
            close.insert(close.end(), {2.0F * bump, 1.5F * v - u, 2.0F * u});
            if (x < kSize && y < kSize) {
                const int i = y * (kSize + 1) + x;
                counts.push_back(4);
                indices.insert(indices.end(), {i, i + 1, i + kSize + 2, i + kSize + 1});
            }
        }
    }
    mesh->points = std::move(open);
    mesh->keys = {{std::move(close), {}, {}}};
    mesh->faceVertexCounts = std::move(counts);
    mesh->faceVertexIndices = std::move(indices);
    return mesh;
}

AccelScene SceneOf(const ChunkSource& source) {
    AccelScene scene;
    const std::uint32_t object = scene.AddSource(source, 150);
    scene.SetRoot({{object, glm::dmat4(1.0), HDS_INSTANCE_SEEN, {}}});
    return scene;
}

AccelScene SceneOf(const std::shared_ptr<GeometryDescription>& mesh) {
    Warnings warnings;
    return SceneOf(*MakePolygonSource(mesh, "/Sheet", {}, warnings));
}

/// Hairs that bend while the shutter is open, and dust between them.
std::shared_ptr<GeometryDescription> Solids(PrimitiveKind kind) {
    constexpr std::size_t kCount = 120;
    constexpr std::size_t kVertices = 4;
    UniformSource uniform(23);
    auto solids = std::make_shared<GeometryDescription>();
    solids->primitives = kind;
    solids->curves.Edit().type = "cubic";
    solids->curves.Edit().basis = "bezier";
    std::vector<float> open;
    std::vector<float> close;
    for (std::size_t i = 0; i < kCount; ++i) {
        const glm::vec3 root = 1.5F * uniform.Vector();
        const glm::vec3 way = 0.8F * uniform.Vector();
        const glm::vec3 bend = 0.6F * uniform.Vector();
        for (std::size_t k = 0; k < kVertices; ++k) {
            const float at = static_cast<float>(k) / (kVertices - 1);
            const glm::vec3 first = root + at * (1.0F - at) * bend + glm::vec3(0.0F, at, 0.0F);
            const glm::vec3 last = root + way + at * at * glm::vec3(bend.y, bend.z, bend.x);
            open.insert(open.end(), {first.x, first.y, first.z});
            close.insert(close.end(), {last.x, last.y, last.z});
        }
    }
    solids->points = std::move(open);
    solids->keys = {{std::move(close), {}, {}}};
    solids->faceVertexCounts = std::vector<std::int32_t>(kCount, kVertices);
    Primvar widths;
    widths.name = "widths";
    widths.values = std::vector<float>{0.05F};
    solids->primvars = {widths};
    return solids;
}

/// How many of the pages' BVHs have boxes that move.
std::size_t CountMovingPages(const AccelScene& scene) {
    return static_cast<std::size_t>(
        std::count_if(scene.pages.begin(), scene.pages.end(), [](const GeometryPage& page) {
            return (PageView(page.bytes.data()).header.vertices & HDS_PAGE_BOXES_MOVE) != 0;
        }));
}

TEST_F(Motion, VerticesAreOnTheirWay) {
    const TraversalProbe moving(device, true, kMotion);
    const TraversalProbe still(device, true);
    const auto sheet = Sheet();
    const AccelScene scene = SceneOf(sheet);
    const DeviceAccelScene onDevice(device, scene);
    for (const float time : {0.0F, 0.31F, 0.75F, 1.0F}) {
        std::vector<float> points(sheet->points.begin(), sheet->points.end());
        for (std::size_t i = 0; i < points.size(); ++i) {
            points[i] += time * (sheet->keys[0].points[i] - points[i]);
        }
        auto posed = std::make_shared<GeometryDescription>(*sheet);
        posed->points = std::move(points);
        posed->keys.clear();
        ExpectSameHits(moving.Closest(onDevice, RaysAt(time, 1500)),
                       still.Closest(DeviceAccelScene(device, SceneOf(posed)), RaysAt(0.0F, 1500)));
    }
}

/// The sheet at three keys more, after which it is back: a way that no line is near.
std::shared_ptr<GeometryDescription> RoundTrip(const std::shared_ptr<GeometryDescription>& once) {
    auto mesh = std::make_shared<GeometryDescription>(*once);
    const SharedSpan<float>& open = mesh->points;
    const SharedSpan<float> far = mesh->keys[0].points;
    std::vector<float> beyond(far.begin(), far.end());
    for (std::size_t i = 0; i < beyond.size(); i += 3) {
        beyond[i] = 0.5F * open[i + 1] - far[i];
        beyond[i + 1] += 0.7F;
    }
    mesh->keys = {{far, {}, {}}, {std::move(beyond), {}, {}}, {open, {}, {}}};
    return mesh;
}

TEST_F(Motion, VerticesGoFromKeyToKey) {
    const TraversalProbe moving(device, true, kMotion);
    const TraversalProbe still(device, true);
    const auto sheet = RoundTrip(Sheet());
    const AccelScene scene = SceneOf(sheet);
    EXPECT_EQ(CountMovingPages(scene), scene.pages.size());
    const DeviceAccelScene onDevice(device, scene);
    for (const float time : {0.0F, 0.2F, 1.0F / 3.0F, 0.45F, 0.9F, 1.0F}) {
        const auto segment = std::min(static_cast<std::size_t>(3.0F * time), std::size_t{2});
        const float part = 3.0F * time - static_cast<float>(segment);
        const SharedSpan<float>& from =
            segment == 0 ? sheet->points : sheet->keys[segment - 1].points;
        std::vector<float> points(from.begin(), from.end());
        for (std::size_t i = 0; i < points.size(); ++i) {
            points[i] += part * (sheet->keys[segment].points[i] - points[i]);
        }
        auto posed = std::make_shared<GeometryDescription>(*sheet);
        posed->points = std::move(points);
        posed->keys.clear();
        ExpectSameHits(moving.Closest(onDevice, RaysAt(time, 1500)),
                       still.Closest(DeviceAccelScene(device, SceneOf(posed)), RaysAt(0.0F, 1500)));
    }
}

TEST_F(Motion, BoxesHoldAllPosesBetweenKeys) {
    const AccelScene scene = SceneOf(RoundTrip(Sheet()));
    EXPECT_EQ(CountMovingPages(scene), scene.pages.size());
    ExpectBitsOfBruteForce(scene);
    Warnings warnings;
    auto hair = RoundTrip(Solids(PrimitiveKind::Curves));
    auto dust = RoundTrip(Solids(PrimitiveKind::Points));
    auto ribbons = std::make_shared<GeometryDescription>(*hair);
    Primvar normals;
    normals.name = "normals";
    normals.numComponents = 3;
    normals.values = std::vector<float>{0.0F, 0.0F, 1.0F};
    ribbons->primvars.push_back(normals);
    for (const auto& solids : {hair, dust, ribbons}) {
        for (std::size_t i = 0; i < solids->keys.size(); ++i) {
            solids->keys[i].widths = std::vector<float>{0.02F + 0.04F * static_cast<float>(i)};
        }
        ExpectBitsOfBruteForce(SceneOf(solids == dust
                                           ? *MakePointSource(solids, "/Dust", warnings)
                                           : *MakeCurveSource(solids, "/Hair", warnings)));
    }
    EXPECT_TRUE(warnings.Lines().empty());
}

TEST_F(Motion, BoxesOfTrianglesHoldAllPoses) {
    const AccelScene scene = SceneOf(Sheet());
    EXPECT_EQ(CountMovingPages(scene), scene.pages.size());
    ExpectBitsOfBruteForce(scene);
}

TEST_F(Motion, BoxesOfCurvesAndPointsHoldAllPoses) {
    Warnings warnings;
    for (const auto& source : {MakeCurveSource(Solids(PrimitiveKind::Curves), "/Hair", warnings),
                               MakePointSource(Solids(PrimitiveKind::Points), "/Dust", warnings)}) {
        const AccelScene scene = SceneOf(*source);
        EXPECT_EQ(CountMovingPages(scene), scene.pages.size());
        ExpectBitsOfBruteForce(scene);
    }
    EXPECT_TRUE(warnings.Lines().empty());
}

// Boxes at rest serve what goes less far than it is large.
TEST_F(Motion, BoxesOfShortWaysAreAtRest) {
    const auto sheet = Sheet();
    std::vector<float> close(sheet->points.begin(), sheet->points.end());
    for (std::size_t i = 2; i < close.size(); i += 3) {
        close[i] += 0.02F;
    }
    sheet->keys[0].points = std::move(close);
    const AccelScene scene = SceneOf(sheet);
    EXPECT_EQ(CountMovingPages(scene), 0U);
    ExpectBitsOfBruteForce(scene);
}

} // namespace
} // namespace hds::test
