// SPDX-License-Identifier: Apache-2.0
// Small scenes for traversal tests and benchmarks, built without the scene layer: meshes, groups
// and a root group, with all device tables of kernels/shared/geometry.h.
#pragma once

#include "hdStream/accel/bvh.h"
#include "hdStream/accel/flatBvh.h"
#include "hdStream/device/device.h"
#include "hdStream/device/program.h"
#include "hdStream/geometry/triangleMesh.h"
#include "kernels/shared/geometry.h"

#include <glm/mat4x4.hpp>

#include <array>
#include <memory>
#include <vector>

namespace hds::test {

/// A placement in a group.
struct AccelPlacement {
    std::uint32_t object = 0;
    glm::dmat4 parentFromObject{1.0};
    std::uint32_t flags = HDS_INSTANCE_SEEN;
    std::vector<glm::dmat4> keys = {}; ///< of parentFromObject when it moves
    std::uint32_t instanceCount = 0;   ///< of its record; 0: no instancer places it
};

/// Tables of a scene. Objects are numbered in the order they are added, from 1 on; object 0 is the
/// root group.
class AccelScene {
public:
    AccelScene() : objects(1), _bounds(1), _numLeaves(1, 0) {}

    /// A mesh, cut into chunks of at most `maxTriangles`. \return its object.
    std::uint32_t AddMesh(const TriangleMesh& mesh, std::uint32_t maxTriangles = 12000);
    /// The same of a source of chunks.
    std::uint32_t AddSource(const ChunkSource& source, std::uint32_t maxTriangles);
    /// A group of placements; path indices follow their order. \param numInChunk two of three
    /// placements lie in instance chunks of so many, in their order, which need not be compact; 0:
    /// all are in the table. \return its object.
    std::uint32_t AddGroup(const std::vector<AccelPlacement>& placements,
                           std::uint32_t numInChunk = 0);
    /// Sets the TLAS. Call once, last. \param numInChunk as of AddGroup.
    void SetRoot(const std::vector<AccelPlacement>& placements, std::uint32_t numInChunk = 0);

    std::vector<shared::HdsBvhNode> topNodes;
    std::vector<shared::HdsInstance> instances;
    std::vector<std::uint32_t> instancesByPath;
    std::vector<shared::HdsObject> objects;
    std::vector<GeometryPage> pages; ///< geometry page of each chunk
    std::vector<std::array<float, 12>> motionKeys;
    std::uint32_t numInstanceChunks = 0; ///< the first of `pages`

private:
    /// Records of a group in the order of placements, with their boxes.
    struct Records {
        std::vector<shared::HdsInstance> records;
        std::vector<Bounds> boxes;
        std::vector<Bounds> closeBoxes;
        std::uint64_t numLeaves = 0;
    };
    Records MakeRecords(const std::vector<AccelPlacement>& placements);
    void PutInChunks(std::uint32_t group, std::uint32_t numInChunk, Records* made);
    std::uint32_t AddObject();
    void AddKeys(const std::vector<glm::dmat4>& keys, shared::HdsInstance* record);
    void BuildGroup(std::uint32_t object, const Records& made);

    std::vector<Bounds> _bounds;           ///< of each object
    std::vector<std::uint64_t> _numLeaves; ///< leaf instances that placing each object makes
};

/// Forms of the traversal, which have equal bits.
enum class AccelForm { Flat, Simd8, Scalar };
constexpr AccelForm kAccelForms[] = {AccelForm::Flat, AccelForm::Simd8, AccelForm::Scalar};
const char* NameOf(AccelForm form);
/// What chooses a form; the flat one with instances that it does not flatten.
ProgramDefines DefinesOf(AccelForm form);

/// What a flat hierarchy is built of; the scene must outlive it.
FlatSource FlatSourceOf(const AccelScene& scene);

/// How a scene lies in the pools.
struct AccelUpload {
    std::uint32_t numPools = 1;              ///< chunks go to the pools in turn
    std::vector<std::uint32_t> missing;      ///< chunks that are not resident
    FlatAmount flat = {1U << 28U, 1e9, 0.0}; ///< of the flat hierarchy
};

/// A scene on a device.
class DeviceAccelScene {
public:
    DeviceAccelScene(const std::shared_ptr<Device>& device, const AccelScene& scene,
                     const AccelUpload& upload = {});

    /// Sets HDS_GEOMETRY_ARGS from argument `first` on. \param hasMotion, isFlat the kernel has
    /// HDS_FEATURE_MOTION, HDS_FEATURE_FLAT.
    void Bind(Kernel* kernel, unsigned first, bool hasMotion = false, bool isFlat = false) const;
    /// Empty where chunks are missing or something moves.
    const FlatBvh& Flat() const { return _flat; }
    std::uint32_t NumInstances() const { return _numInstances; }

private:
    Buffer _topNodes, _instances, _instancesByPath, _objects, _addresses, _motionKeys;
    std::array<Buffer, HDS_POOL_MAX_BUFFERS> _pools;
    FlatBvh _flat;
    Buffer _flatBuffer;
    std::uint32_t _numInstances = 0;
};

} // namespace hds::test
