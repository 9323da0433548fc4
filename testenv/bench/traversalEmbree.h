// SPDX-License-Identifier: Apache-2.0
// Embree 3 as the yardstick of the traversal benchmark: the same meshes, the same rays.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <glm/mat4x4.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hds::bench {

/// A ray as the benchmark's kernels read it; tMin is 0 and tMax infinite where nothing else is
/// said.
struct BenchRay {
    float origin[3];
    float tMin;
    float direction[3];
    float tMax;
};
static_assert(sizeof(BenchRay) == 32);

/// What Embree answers.
struct EmbreeHit {
    float t;
    std::uint32_t mesh; ///< or placement, where there are some; 0xffffffff: no hit
    std::uint32_t triangle;
};

/// Where a mesh is placed.
struct BenchPlacement {
    std::uint32_t mesh = 0;
    glm::mat4 worldFromMesh{1.0F};
};

/// A committed Embree scene; committed by one thread.
class EmbreeScene {
public:
    /// \param placements of the meshes as instances; none: each mesh once, as it is.
    /// \param compactRobust RTC_SCENE_FLAG_COMPACT | ROBUST, else the default flags.
    EmbreeScene(const std::vector<TriangleMesh>& meshes,
                const std::vector<BenchPlacement>& placements, bool compactRobust);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    std::vector<EmbreeHit> Closest(const std::vector<BenchRay>& rays, unsigned numThreads) const;
    std::vector<std::uint8_t> Occluded(const std::vector<BenchRay>& rays,
                                       unsigned numThreads) const;

    /// Bytes that Embree allocated for the hierarchy (vertices and indices are shared with us).
    std::size_t Bytes() const { return _bytes; }
    /// CPU seconds of the commit.
    double BuildSeconds() const { return _buildSeconds; }

private:
    void* _device = nullptr;
    void* _scene = nullptr;
    bool _hasInstances = false;
    std::size_t _bytes = 0;
    double _buildSeconds = 0.0;
};

/// CPU seconds that this process has used in all threads: unlike wall time it does not count what
/// other processes take.
double ProcessSeconds();

} // namespace hds::bench
