// SPDX-License-Identifier: Apache-2.0
// Counts rays that leak out of closed meshes: rays start inside and are aimed at vertices, at
// edges, in axis-parallel and in random directions, so every one must hit. Rays are made on the
// device.
#pragma once

#include "testenv/support/accelScene.h"

#include <string>
#include <vector>

namespace hds::test {

/// A closed, star-shaped mesh about the origin that contains the ball of radius `innerRadius`.
struct WatertightCase {
    std::string name;
    TriangleMesh mesh;
    float innerRadius = 0.5F;
    std::uint32_t maxTriangles = 700;   ///< a chunk; small, so that many edges are chunk borders
    std::vector<glm::dmat4> transforms; ///< from the root to the mesh, one group a level
    /// Where chunks come from, if not from the mesh, which then has all its triangles to aim at.
    std::shared_ptr<const ChunkSource> source;
};

/// Spheres, bumps, a box with long edges; rotated, stretched, nested, far away, tiny. Diced
/// surfaces: displaced, creased, with edges of very different rates.
std::vector<WatertightCase> MakeWatertightCases();

/// Casts rays with one form of the traversal.
class LeakCounter {
public:
    LeakCounter(std::shared_ptr<Device> device, AccelForm form);

    /// Casts `numRays` rays, closest and any hit.
    /// \return rays for which either found nothing.
    std::uint64_t Count(const WatertightCase& watertight, std::uint64_t numRays);

private:
    std::shared_ptr<Device> _device;
    AccelForm _form;
    std::unique_ptr<Program> _plainProgram; ///< without groups
    std::unique_ptr<Program> _nestedProgram;
};

} // namespace hds::test
