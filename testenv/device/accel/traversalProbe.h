// SPDX-License-Identifier: Apache-2.0
// Runs the traversal's entry points over arrays of rays, and a brute-force kernel that tests every
// triangle of every instance without any hierarchy.
#pragma once

#include "testenv/support/accelScene.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/pageView.h"

#include <glm/vec3.hpp>

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace hds::test {

/// A ray as the probe's kernels read it.
struct ProbeRay {
    float origin[3];
    float tMin; ///< with HDS_FEATURE_MOTION: the time, and tMin is 0
    float direction[3];
    float tMax;
};
static_assert(sizeof(ProbeRay) == 32);

/// The key after which hits count, as kernels take it: bits of t, path index low and high, primId.
struct ProbeKey {
    std::uint32_t word[4] = {0, 0, 0, 0};
};

inline const char* const kProbeText = R"(
#include "accel/traverse.clh"
HdsTraversalRay probe_load(global const float* rays, uint i) {
    HdsTraversalRay ray;
    ray.origin = vload3(0, rays + 8u * i);
    ray.tMin = rays[8u * i + 3u];
    ray.direction = vload3(0, rays + 8u * i + 4u);
    ray.tMax = rays[8u * i + 7u];
#if HDS_FEATURE_MOTION
    ray.time = ray.tMin;
    ray.tMin = 0.0f;
#endif
    return ray;
}
kernel void probe_closest(global const float* rays, uint count, global HdsHit* hits, uint flagMask,
                          global const uint4* after, HDS_GEOMETRY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HDS_GEOMETRY_VIEW(view);
    HdsHit hit;
#if HDS_FEATURE_CUTOUT
    traverse_closestAfter(&view, probe_load(rays, i), flagMask, after[i], &hit);
#else
    traverse_closest(&view, probe_load(rays, i), flagMask, &hit);
#endif
    hits[i] = hit;
}
/* Hit: the candidate. Its triangle is 0xfffffffe when the ray is blocked. */
kernel void probe_occluded(global const float* rays, uint count, global HdsHit* hits, uint flagMask,
                           global const uint4* after, HDS_GEOMETRY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HDS_GEOMETRY_VIEW(view);
    HdsHit hit = hit_none();
#if HDS_FEATURE_CUTOUT
    const bool isBlocked = traverse_occludedAfter(&view, probe_load(rays, i), after[i], &hit);
#else
    const bool isBlocked = traverse_occluded(&view, probe_load(rays, i));
#endif
    if (isBlocked) {
        hit = hit_none();
        hit.triangle = 0xfffffffeu;
    }
    hits[i] = hit;
}
#if HDS_FEATURE_FLAT && HDS_WIDE
#include "math/wideBegin.clh"

#include "math/vector.clh"
#include "math/wideEnd.clh"

#include "accel/traverseFlatPacket.clh"
/* Eight rays at once. The triangle of their hits is 0xfffffffd when they do not go the same way. */
kernel void probe_packets(global const float* rays, uint count, global HdsHit* hits, uint flagMask,
                          global const uint4* after, HDS_GEOMETRY_ARGS) {
    const uint first = (uint)get_global_id(0);
    if (first % HDS_PACKET_RAYS != 0u || first + HDS_PACKET_RAYS > count) {
        return;
    }
    HDS_GEOMETRY_VIEW(view);
    HdsPacket packet;
    float lanes[8][HDS_PACKET_RAYS];
    for (uint k = 0u; k < HDS_PACKET_RAYS; ++k) {
        const HdsTraversalRay ray = probe_load(rays, first + k);
        for (uint word = 0u; word < 8u; ++word) {
            lanes[word][k] = rays[8u * (first + k) + word];
        }
        packet.tMax[k] = ray.tMax;
#if HDS_FEATURE_MOTION
        packet.time[k] = ray.time;
        lanes[3][k] = 0.0f;
#endif
        packet.best[k] = hit_begin(&ray, after[first + k]);
    }
    packet.origin = real_make3(vload8(0, lanes[0]), vload8(0, lanes[1]), vload8(0, lanes[2]));
    packet.direction = real_make3(vload8(0, lanes[4]), vload8(0, lanes[5]), vload8(0, lanes[6]));
    packet.tMin = vload8(0, lanes[3]);
    packet.limit = vload8(0, lanes[7]);
    const bool isTraced = traverse_packet(&view, flagMask, &packet);
    for (uint k = 0u; k < HDS_PACKET_RAYS; ++k) {
        HdsHit hit = hit_none();
        if (isTraced) {
            hit_end(&packet.best[k], &hit);
        } else {
            hit.triangle = 0xfffffffdu;
        }
        hits[first + k] = hit;
    }
}
#endif
/* Every triangle of every instance; scenes without groups. flagMask carries the instance count. */
kernel void probe_bruteForce(global const float* rays, uint count, global HdsHit* hits,
                             uint numInstances, global const uint4* after, HDS_GEOMETRY_ARGS) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
    HDS_GEOMETRY_VIEW(view);
    const HdsTraversalRay ray = probe_load(rays, i);
    HdsBest best = hit_begin(&ray, after[i]);
    for (uint n = 0u; n < numInstances; ++n) {
        global const HdsInstance* instance = view.instances + n;
        const HdsObject object = view.objects[instance->object];
        float3 origin = ray.origin;
        float3 direction = ray.direction;
        ray_toObject(&view, instance, ray_time(&ray), &origin, &direction);
        const HdsShear shear = triangle_shear(origin, direction);
        HdsLeafInstance leaf =
            leaf_instance(n, instance->flags, leaf_pathOffset(instance), false, &ray, &best);
        for (uint c = object.itemBase; c < object.itemBase + object.numItems; ++c) {
            const HdsResidentChunk chunk =
                leaf_chunk(&view, &leaf, c, scene_pageAddress(&view, c, HDS_PAGE_GEOMETRY));
            const uint mask = (1u << HDS_PRIMITIVE_SHIFT) - 1u;
            for (uint t = 0u; t < (chunk.page->numTriangles & mask); ++t) {
#if HDS_FEATURE_CURVES
                if (chunk.kind != HDS_PRIMITIVE_TRIANGLES) {
                    leaf_testTriangle(&chunk, t, &shear, &leaf, ray.tMax, &best);
                    continue;
                }
#endif
                if (page_segments(chunk.page) != 0u) {
                    leaf_testTriangle(&chunk, t, &shear, &leaf, ray.tMax, &best);
                    continue;
                }
                const HdsTriangle triangle = chunk.triangles[t];
                HdsTriangleHit found;
                if (triangle_intersect(&shear, chunk.vertices.first + 3u * page_corner(triangle, 0u),
                                       chunk.vertices.first + 3u * page_corner(triangle, 1u),
                                       chunk.vertices.first + 3u * page_corner(triangle, 2u), best.tMin,
                                       leaf.limit, &found)) {
                    leaf_accept(&leaf, c, t, page_primIds(chunk.page)[t], &found, ray.tMax, &best);
                }
            }
        }
    }
    HdsHit hit;
    hit_end(&best, &hit);
    hits[i] = hit;
}
)";

/// Kernels of one form with all features but curves, splats and motion, unless `defines` says
/// otherwise.
class TraversalProbe {
public:
    TraversalProbe(const std::shared_ptr<Device>& device, bool simd8, ProgramDefines defines = {})
        : TraversalProbe(device, simd8 ? AccelForm::Simd8 : AccelForm::Scalar, std::move(defines)) {
    }
    TraversalProbe(const std::shared_ptr<Device>& device, AccelForm form,
                   ProgramDefines defines = {})
        : _device(device), _hasMotion(defines["HDS_FEATURE_MOTION"] == "1"),
          _isFlat(form == AccelForm::Flat) {
        defines["HDS_FEATURE_MOTION"] = _hasMotion ? "1" : "0";
        defines.merge(DefinesOf(form));
        defines.emplace("HDS_NUM_POOLS", "1");
        defines.emplace("HDS_FEATURE_CURVES", "0");
        defines.emplace("HDS_FEATURE_SPLATS", defines["HDS_FEATURE_CURVES"]); // they need them
        const std::string text = kProbeText;
        _program = std::make_unique<Program>(device, "probe.cl", defines, nullptr, &text);
    }

    std::vector<shared::HdsHit> Closest(const DeviceAccelScene& scene,
                                        const std::vector<ProbeRay>& rays,
                                        std::uint32_t flagMask = 0,
                                        const std::vector<ProbeKey>& after = {}) const {
        return Run("probe_closest", scene, rays, flagMask, after);
    }
    /// Eight rays at once; needs HDS_ITEMS_PER_WORK_ITEM 8. kApart: they do
    /// not go the same way.
    std::vector<shared::HdsHit> Packets(const DeviceAccelScene& scene,
                                        const std::vector<ProbeRay>& rays,
                                        std::uint32_t flagMask = 0,
                                        const std::vector<ProbeKey>& after = {}) const {
        return Run("probe_packets", scene, rays, flagMask, after);
    }
    std::vector<shared::HdsHit> Occluded(const DeviceAccelScene& scene,
                                         const std::vector<ProbeRay>& rays,
                                         const std::vector<ProbeKey>& after = {}) const {
        return Run("probe_occluded", scene, rays, 0, after);
    }
    std::vector<shared::HdsHit> BruteForce(const DeviceAccelScene& scene,
                                           const std::vector<ProbeRay>& rays,
                                           const std::vector<ProbeKey>& after = {}) const {
        return Run("probe_bruteForce", scene, rays, scene.NumInstances(), after);
    }

private:
    std::vector<shared::HdsHit> Run(const char* name, const DeviceAccelScene& scene,
                                    const std::vector<ProbeRay>& rays, std::uint32_t number,
                                    std::vector<ProbeKey> after) const {
        after.resize(rays.size());
        const auto count = static_cast<std::uint32_t>(rays.size());
        const Buffer input = UploadVector(_device, "rays", rays);
        const Buffer keys = UploadVector(_device, "keys", after);
        const Buffer output(_device, "hits", rays.size() * sizeof(shared::HdsHit));
        Kernel kernel = _program->GetKernel(name);
        kernel.SetBuffer(0, input);
        kernel.SetBytes(1, &count, sizeof(count));
        kernel.SetBuffer(2, output);
        kernel.SetBytes(3, &number, sizeof(number));
        kernel.SetBuffer(4, keys);
        scene.Bind(&kernel, 5, _hasMotion, _isFlat);
        kernel.Enqueue(rays.size());
        _device->Finish();
        std::vector<shared::HdsHit> hits(rays.size());
        output.Read(hits.data(), hits.size() * sizeof(hits[0]));
        return hits;
    }

    std::shared_ptr<Device> _device;
    bool _hasMotion;
    bool _isFlat;
    std::unique_ptr<Program> _program;
};

constexpr std::uint32_t kBlocked = 0xfffffffeU; ///< HdsHit.triangle of a blocked ray
constexpr std::uint32_t kApart = 0xfffffffdU;   ///< of rays that are no packet

inline bool IsHit(const shared::HdsHit& hit) {
    return hit.chunk != HDS_NONE;
}
inline std::uint64_t PathOf(const shared::HdsHit& hit) {
    return std::uint64_t{hit.pathIndex[1]} << 32U | hit.pathIndex[0];
}

/// Uniform numbers in [-1, 1), the same on every platform.
class UniformSource {
public:
    explicit UniformSource(std::uint32_t seed) : _random(seed) {}
    float operator()() { return static_cast<float>(_random() >> 8U) * 0x1p-23F - 1.0F; }
    glm::vec3 Vector() {
        const float x = (*this)();
        const float y = (*this)();
        return {x, y, (*this)()};
    }

private:
    std::mt19937 _random;
};

inline ProbeRay MakeProbeRay(const glm::vec3& origin, const glm::vec3& direction,
                             float tMax = INFINITY, float tMin = 0.0F) {
    return {{origin.x, origin.y, origin.z}, tMin, {direction.x, direction.y, direction.z}, tMax};
}

} // namespace hds::test
