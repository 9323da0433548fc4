// SPDX-License-Identifier: Apache-2.0
#include "testenv/bench/traversalEmbree.h"

#include <embree3/rtcore.h>

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <thread>

namespace hds::bench {
namespace {

bool CountBytes(void* bytes, ssize_t change, bool /*post*/) {
    *static_cast<std::size_t*>(bytes) += static_cast<std::size_t>(change);
    return true;
}

RTCScene AsScene(void* scene) {
    return static_cast<RTCScene>(scene);
}

RTCRay MakeRay(const BenchRay& source) {
    RTCRay ray{};
    ray.org_x = source.origin[0];
    ray.org_y = source.origin[1];
    ray.org_z = source.origin[2];
    ray.tnear = source.tMin;
    ray.dir_x = source.direction[0];
    ray.dir_y = source.direction[1];
    ray.dir_z = source.direction[2];
    ray.tfar = source.tMax;
    ray.mask = 0xffffffffU;
    return ray;
}

RTCScene NewScene(RTCDevice device, bool compactRobust) {
    RTCScene scene = rtcNewScene(device);
    if (compactRobust) {
        rtcSetSceneFlags(
            scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_COMPACT | RTC_SCENE_FLAG_ROBUST));
    }
    return scene;
}

void AttachMesh(RTCDevice device, RTCScene scene, const TriangleMesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const std::size_t vertexBytes = mesh.positions.size() * sizeof(glm::vec3);
    const std::size_t indexBytes = mesh.triangles.size() * sizeof(glm::uvec3);
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                        sizeof(glm::vec3), mesh.positions.size()),
                mesh.positions.data(), vertexBytes);
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                        sizeof(glm::uvec3), mesh.triangles.size()),
                mesh.triangles.data(), indexBytes);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
}

/// Calls work(begin, end) for ranges that cover all of `count`, on so many threads.
template <typename Work>
void ForRanges(std::size_t count, unsigned numThreads, const Work& work) {
    constexpr std::size_t kRange = 4096;
    std::atomic<std::size_t> next{0};
    const auto takeRanges = [&] {
        for (std::size_t begin = 0; (begin = next.fetch_add(kRange)) < count;) {
            work(begin, std::min(begin + kRange, count));
        }
    };
    std::vector<std::thread> threads;
    for (unsigned i = 1; i < numThreads; ++i) {
        threads.emplace_back(takeRanges);
    }
    takeRanges();
    for (std::thread& thread : threads) {
        thread.join();
    }
}

} // namespace

double ProcessSeconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

EmbreeScene::EmbreeScene(const std::vector<TriangleMesh>& meshes,
                         const std::vector<BenchPlacement>& placements, bool compactRobust)
    : _hasInstances(!placements.empty()) {
    RTCDevice device = rtcNewDevice("threads=1");
    if (device == nullptr) {
        throw std::runtime_error("Embree has no device");
    }
    _device = device;
    rtcSetDeviceMemoryMonitorFunction(device, CountBytes, &_bytes);
    RTCScene scene = NewScene(device, compactRobust);
    _scene = scene;
    std::vector<RTCScene> below; // of each mesh, where they are instanced
    for (const TriangleMesh& mesh : meshes) {
        below.push_back(_hasInstances ? NewScene(device, compactRobust) : scene);
        AttachMesh(device, below.back(), mesh);
    }
    const std::size_t bufferBytes = _bytes;
    const double start = ProcessSeconds();
    for (std::size_t i = 0; _hasInstances && i < below.size(); ++i) {
        rtcCommitScene(below[i]);
    }
    for (const BenchPlacement& placement : placements) {
        RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, below[placement.mesh]);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                                &placement.worldFromMesh[0][0]);
        rtcCommitGeometry(instance);
        rtcAttachGeometry(scene, instance);
        rtcReleaseGeometry(instance);
    }
    rtcCommitScene(scene);
    for (std::size_t i = 0; _hasInstances && i < below.size(); ++i) {
        rtcReleaseScene(below[i]); // instances hold them
    }
    _buildSeconds = ProcessSeconds() - start;
    _bytes -= bufferBytes;
}

EmbreeScene::~EmbreeScene() {
    rtcReleaseScene(AsScene(_scene));
    rtcSetDeviceMemoryMonitorFunction(static_cast<RTCDevice>(_device), nullptr, nullptr);
    rtcReleaseDevice(static_cast<RTCDevice>(_device));
}

std::vector<EmbreeHit> EmbreeScene::Closest(const std::vector<BenchRay>& rays,
                                            unsigned numThreads) const {
    std::vector<EmbreeHit> hits(rays.size());
    ForRanges(rays.size(), numThreads, [&](std::size_t begin, std::size_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t i = begin; i < end; ++i) {
            RTCRayHit query{};
            query.ray = MakeRay(rays[i]);
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(AsScene(_scene), &context, &query);
            hits[i] = {query.ray.tfar, _hasInstances ? query.hit.instID[0] : query.hit.geomID,
                       query.hit.primID};
        }
    });
    return hits;
}

std::vector<std::uint8_t> EmbreeScene::Occluded(const std::vector<BenchRay>& rays,
                                                unsigned numThreads) const {
    std::vector<std::uint8_t> results(rays.size());
    ForRanges(rays.size(), numThreads, [&](std::size_t begin, std::size_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t i = begin; i < end; ++i) {
            RTCRay ray = MakeRay(rays[i]);
            rtcOccluded1(AsScene(_scene), &context, &ray);
            results[i] = ray.tfar < 0.0F ? 1 : 0;
        }
    });
    return results;
}

} // namespace hds::bench
