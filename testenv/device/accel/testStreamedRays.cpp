// SPDX-License-Identifier: Apache-2.0
// A ray that waits for chunks comes to the result of the walk with everything resident, whatever is
// resident when, in both forms, also when its list of missing chunks is much too short.
#include "testenv/device/accel/traversalProbe.h"
#include "testenv/support/traversalMeshes.h"

#include <glm/gtc/matrix_transform.hpp>

#include <array>
#include <cstring>
#include <random>
#include <string>

namespace hds::test {
namespace {

/// What a ray keeps from launch to launch.
struct RayState {
    shared::HdsHit hit;
    std::uint32_t pending[HDS_WAIT_LIST][2][4];
    std::uint32_t bound[2][4];
    std::uint32_t size, primId, state, isShadow;
};

const char* const kText = R"(
#include "accel/traverse.clh"
typedef struct {
    HdsHit hit;
    uint4 pending[HDS_WAIT_LIST][2];
    uint4 bound[2];
    uint size, primId, state, isShadow;
} RayState;
HdsPending load(const uint4* words) {
    HdsPending pending;
    HDS_PENDING_AT(pending) = words[0];
#if HDS_FEATURE_INSTANCE_CHUNKS
    pending.outer = words[1];
#endif
    return pending;
}
void store(HdsPending pending, uint4* words) {
    words[0] = HDS_PENDING_AT(pending);
#if HDS_FEATURE_INSTANCE_CHUNKS
    words[1] = pending.outer;
#endif
}
kernel void probe_stream(global const float* rays, uint count, uint isFirst, global RayState* states,
                         HDS_GEOMETRY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HDS_GEOMETRY_VIEW(view);
    HdsTraversalRay ray;
    ray.origin = vload3(0, rays + 8u * i);
    ray.tMin = rays[8u * i + 3u];
    ray.direction = vload3(0, rays + 8u * i + 4u);
    ray.tMax = rays[8u * i + 7u];
    RayState s = states[i];
    HdsWaitList list = wait_begin();
    const uint4 none = (uint4)(0u);
    if (isFirst != 0u) {
        s.state = s.isShadow != 0u
                      ? streamed_beginOccluded(&view, ray, none, &s.hit, &s.primId, &list)
                      : streamed_beginClosest(&view, ray, 0u, none, &s.hit, &s.primId, &list);
    } else if (s.state == HDS_RAY_WAITS) {
        list.size = s.size;
        list.bound = load(s.bound);
        for (uint k = 0u; k < s.size; ++k) {
            list.pending[k] = load(s.pending[k]);
        }
        s.state = s.isShadow != 0u
                      ? streamed_resumeOccluded(&view, ray, none, &s.hit, &s.primId, &list)
                      : streamed_resumeClosest(&view, ray, 0u, none, &s.hit, &s.primId, &list);
    }
    s.size = list.size;
    store(list.bound, s.bound);
    for (uint k = 0u; k < list.size; ++k) {
        store(list.pending[k], s.pending[k]);
    }
    states[i] = s;
}
)";

constexpr std::uint32_t kRayBlocked = 2; ///< HDS_RAY_BLOCKED
constexpr std::uint32_t kRayWaits = 1;   ///< HDS_RAY_WAITS

struct SceneKind {
    bool hasGroups = false;
    std::uint32_t numInChunk = 0;      ///< as of AccelScene::SetRoot
    bool isNested = false;             ///< groups in groups
    std::uint32_t numInGroupChunk = 0; ///< of the group of balls, as of AccelScene::AddGroup

    bool HasInstanceChunks() const { return numInChunk + numInGroupChunk > 0; }
    SceneKind InTables() const { return {hasGroups, 0, isNested, 0}; }
};

/// Overlapping bumpy balls of many small chunks, in groups and alone, half of them cut-outs.
AccelScene OverlappingScene(const SceneKind& kind) {
    AccelScene scene;
    const std::uint32_t ball = scene.AddMesh(BumpySphere(24), 60);
    const std::uint32_t small = scene.AddMesh(BumpySphere(6), 1000); // one chunk
    UniformSource uniform(3);
    std::vector<AccelPlacement> placements;
    for (int i = 0; i < 12; ++i) {
        glm::dmat4 matrix = glm::translate(glm::dmat4(1.0), 0.3 * glm::dvec3(uniform.Vector()));
        matrix = glm::rotate(matrix, 3.0 * uniform(), glm::dvec3(1.0, 0.5, 0.2));
        placements.push_back({i % 3 == 0 ? small : ball,
                              glm::scale(matrix, glm::dvec3(1.0 + 0.1 * i)),
                              HDS_INSTANCE_SEEN | (i % 2 == 0 ? HDS_INSTANCE_CUTOUT : 0U)});
    }
    if (kind.hasGroups) {
        const std::uint32_t group = scene.AddGroup(placements, kind.numInGroupChunk);
        glm::dmat4 shifted(1.0);
        shifted[3].x = 0.5;
        placements = {{group, glm::dmat4(1.0)}, {group, shifted}, {ball, shifted}};
        if (kind.isNested) {
            const std::uint32_t pair = scene.AddGroup(placements);
            glm::dmat4 raised(1.0);
            raised[3].y = 0.25;
            placements = {{pair, glm::dmat4(1.0)}, {pair, raised}, {group, shifted * raised}};
        }
    }
    scene.SetRoot(placements, kind.numInChunk);
    return scene;
}

class StreamedRays : public DeviceFixture {
protected:
    void Check(bool isWide, const SceneKind& kind) {
        const AccelScene built = OverlappingScene(kind);
        const DeviceAccelScene all(device, built);
        const std::vector<ProbeRay> rays = Rays(600);
        const TraversalProbe oracle(device, isWide, FeaturesOf(kind));
        const auto hits = oracle.Closest(all, rays);
        const auto shadows = oracle.Occluded(all, rays);
        const std::vector<RayState> states = Stream(built, rays, isWide, kind);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            EXPECT_EQ(std::memcmp(&states[i].hit, &hits[i], sizeof(hits[i])), 0) << "ray " << i;
            const RayState& shadow = states[rays.size() + i];
            const bool isBlocked = shadows[i].triangle == kBlocked;
            EXPECT_EQ(shadow.state == kRayBlocked, isBlocked) << "shadow ray " << i;
            EXPECT_TRUE(isBlocked || std::memcmp(&shadow.hit, &shadows[i], sizeof(hits[i])) == 0)
                << "shadow ray " << i;
        }
        if (kind.HasInstanceChunks()) {
            CheckTables(isWide, kind, built.numInstanceChunks, rays, {hits, shadows});
        }
    }

private:
    static ProgramDefines FeaturesOf(const SceneKind& kind) {
        return {{"HDS_FEATURE_GROUPS", kind.hasGroups ? "1" : "0"},
                {"HDS_FEATURE_INSTANCE_CHUNKS", kind.HasInstanceChunks() ? "1" : "0"}};
    }

    /// What was found with instance chunks equals what is found with all records in the table.
    void CheckTables(bool isWide, const SceneKind& kind, std::uint32_t numInstanceChunks,
                     const std::vector<ProbeRay>& rays,
                     const std::array<std::vector<shared::HdsHit>, 2>& found) {
        ASSERT_GT(numInstanceChunks, 1U);
        const DeviceAccelScene tables(device, OverlappingScene(kind.InTables()));
        const TraversalProbe oracle(device, isWide, FeaturesOf(kind.InTables()));
        const std::array<std::vector<shared::HdsHit>, 2> wanted = {oracle.Closest(tables, rays),
                                                                   oracle.Occluded(tables, rays)};
        std::size_t numInChunks = 0;
        for (std::size_t kind = 0; kind < 2; ++kind) {
            for (std::size_t i = 0; i < rays.size(); ++i) {
                shared::HdsHit hit = found[kind][i];
                numInChunks += IsHit(hit) && (hit.instance & HDS_RECORD_IN_CHUNK) != 0 ? 1 : 0;
                hit.chunk -= IsHit(hit) ? numInstanceChunks : 0;
                hit.instance = wanted[kind][i].instance; // records have other numbers
                EXPECT_EQ(std::memcmp(&hit, &wanted[kind][i], sizeof(hit)), 0)
                    << "ray " << i << " of kind " << kind;
            }
        }
        EXPECT_GT(numInChunks, rays.size() / 4);
    }

    static std::vector<ProbeRay> Rays(std::size_t count) {
        UniformSource uniform(29);
        std::vector<ProbeRay> rays;
        for (std::size_t i = 0; i < count; ++i) { // from outside, and from inside many boxes
            const glm::vec3 origin = (i % 2 == 0 ? 4.0F : 0.5F) * uniform.Vector();
            const glm::vec3 target = i % 2 == 0 ? uniform.Vector() : origin + uniform.Vector();
            rays.push_back(MakeProbeRay(origin, target - origin, i % 7 == 0 ? 1.5F : INFINITY));
        }
        return rays;
    }

    /// States of all rays as closest, then of all as shadow rays, once none waits. In each launch
    /// only few chunks are resident, others than before.
    std::vector<RayState> Stream(const AccelScene& built, std::vector<ProbeRay> rays, bool isWide,
                                 const SceneKind& kind) {
        ProgramDefines defines = FeaturesOf(kind);
        defines.insert({{"HDS_TRAVERSAL_SIMD8", isWide ? "1" : "0"},
                        {"HDS_FEATURE_STREAMING", "1"},
                        {"HDS_FEATURE_MOTION", "0"},
                        {"HDS_NUM_POOLS", "1"}});
        const std::string text = kText;
        const Program program(device, "streamed.cl", defines, nullptr, &text);
        Kernel kernel = program.GetKernel("probe_stream");
        std::vector<RayState> states(2 * rays.size());
        for (std::size_t i = rays.size(); i < states.size(); ++i) {
            states[i].isShadow = 1;
        }
        rays.insert(rays.end(), rays.begin(), rays.end());
        const Buffer input = Upload(rays);
        const Buffer output = Upload(states);
        const Buffer uses =
            Zeros((HDS_USE_HEADER + 2 * built.pages.size()) * sizeof(std::uint32_t));
        const auto count = static_cast<std::uint32_t>(rays.size());
        std::mt19937 random(5);
        bool isWaiting = true;
        for (std::uint32_t launch = 0; isWaiting && launch < 2000; ++launch) {
            AccelUpload upload;
            for (std::uint32_t chunk = 0; chunk < built.pages.size(); ++chunk) {
                if (random() % 8 != 0) {
                    upload.missing.push_back(chunk);
                }
            }
            const DeviceAccelScene scene(device, built, upload);
            const std::uint32_t isFirst = launch == 0 ? 1 : 0;
            kernel.SetBuffer(0, input);
            kernel.SetBytes(1, &count, sizeof(count));
            kernel.SetBytes(2, &isFirst, sizeof(isFirst));
            kernel.SetBuffer(3, output);
            scene.Bind(&kernel, 4);
            kernel.SetBuffer(4 + 5 + HDS_POOL_MAX_BUFFERS, uses);
            kernel.Enqueue(count);
            device->Finish();
            states = Download<RayState>(output, states.size());
            isWaiting = false;
            for (const RayState& state : states) {
                isWaiting = isWaiting || state.state == kRayWaits;
            }
        }
        EXPECT_FALSE(isWaiting) << "every ray comes to an end";
        return states;
    }

    Buffer Zeros(std::uint64_t bytes) { return Upload(std::vector<std::uint8_t>(bytes)); }
};

TEST_F(StreamedRays, Simd8FormEqualsTheResidentWalk) {
    Check(true, {});
}
TEST_F(StreamedRays, ScalarFormEqualsTheResidentWalk) {
    Check(false, {});
}
TEST_F(StreamedRays, Simd8FormEqualsTheResidentWalkInGroups) {
    Check(true, {true});
}
TEST_F(StreamedRays, ScalarFormEqualsTheResidentWalkInGroups) {
    Check(false, {true});
}
TEST_F(StreamedRays, Simd8FormEqualsTheResidentWalkInInstanceChunks) {
    for (const std::uint32_t numInChunk : {1U, 3U, 6U}) {
        Check(true, {false, numInChunk});
    }
}
TEST_F(StreamedRays, ScalarFormEqualsTheResidentWalkInInstanceChunks) {
    for (const std::uint32_t numInChunk : {1U, 3U, 6U}) {
        Check(false, {false, numInChunk});
    }
}
TEST_F(StreamedRays, Simd8FormEqualsTheResidentWalkInGroupsInInstanceChunks) {
    Check(true, {true, 1});
}
TEST_F(StreamedRays, ScalarFormEqualsTheResidentWalkInGroupsInInstanceChunks) {
    Check(false, {true, 1});
}
TEST_F(StreamedRays, Simd8FormEqualsTheResidentWalkInInstanceChunksOfGroups) {
    for (const std::uint32_t numInChunk : {1U, 3U, 6U}) {
        Check(true, {true, 0, true, numInChunk});
    }
}
TEST_F(StreamedRays, ScalarFormEqualsTheResidentWalkInInstanceChunksOfGroups) {
    for (const std::uint32_t numInChunk : {1U, 3U, 6U}) {
        Check(false, {true, 0, true, numInChunk});
    }
}

} // namespace
} // namespace hds::test
