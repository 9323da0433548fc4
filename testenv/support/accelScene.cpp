// SPDX-License-Identifier: Apache-2.0
#include "testenv/support/accelScene.h"

#include "hdStream/accel/chunkPlan.h"
#include "hdStream/scene/transforms.h"
#include "kernels/shared/motionKeys.h"
#include "testenv/support/meshSource.h"

#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstring>

namespace hds::test {
namespace {

/// World box of a transformed box, widened by the rounding of the stored transform.
Bounds TransformedBounds(const glm::dmat4& matrix, const Bounds& bounds, int marginExponent) {
    if (bounds.min.x > bounds.max.x) {
        return bounds; // nothing inside
    }
    glm::dvec3 lo(1e300);
    glm::dvec3 hi(-1e300);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec4 p((corner & 1) != 0 ? bounds.max.x : bounds.min.x,
                           (corner & 2) != 0 ? bounds.max.y : bounds.min.y,
                           (corner & 4) != 0 ? bounds.max.z : bounds.min.z, 1.0);
        const glm::dvec3 q(matrix * p);
        lo = glm::min(lo, q);
        hi = glm::max(hi, q);
    }
    const glm::dvec3 margin =
        std::ldexp(1.0, marginExponent) * glm::max(glm::abs(lo), glm::abs(hi));
    Bounds result;
    result.min = glm::vec3(lo - margin);
    result.max = glm::vec3(hi + margin);
    return result;
}

void StoreRows(const glm::dmat4& matrix, float* rows) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            rows[4 * row + column] = static_cast<float>(matrix[column][row]);
        }
    }
}

BvhOptions TopOptions() {
    BvhOptions options;
    options.maxLeafItems = 1;
    return options;
}

} // namespace

std::uint32_t AccelScene::AddMesh(const TriangleMesh& mesh, std::uint32_t maxTriangles) {
    return AddSource(*SourceOf(mesh), maxTriangles);
}

std::uint32_t AccelScene::AddSource(const ChunkSource& source, std::uint32_t maxTriangles) {
    const ChunkPlan plan = PlanChunks(source, maxTriangles);
    const std::size_t numChunks = plan.NumChunks();
    std::vector<GeometryPage> built(numChunks);
    tbb::parallel_for(std::size_t{0}, numChunks, [&](std::size_t i) {
        ChunkGeometry chunk =
            source.Gather(plan.groups.data() + plan.begin[i], plan.begin[i + 1] - plan.begin[i]);
        built[i] = BuildGeometryPage(chunk);
    });
    std::vector<Bounds> boxes;
    Bounds all;
    for (const GeometryPage& page : built) {
        boxes.push_back(page.bounds);
        all.min = glm::min(all.min, page.bounds.min);
        all.max = glm::max(all.max, page.bounds.max);
    }
    const Bvh top = BuildBvh(boxes, TopOptions());
    const auto object = static_cast<std::uint32_t>(objects.size());
    objects.push_back({numChunks == 1 ? HDS_OBJECT_CHUNK : HDS_OBJECT_TOP_TREE,
                       static_cast<std::uint32_t>(topNodes.size()),
                       static_cast<std::uint32_t>(pages.size()),
                       static_cast<std::uint32_t>(numChunks)});
    if (numChunks > 1) {
        topNodes.insert(topNodes.end(), top.nodes.begin(), top.nodes.end());
    }
    for (const std::uint32_t i : top.order) {
        pages.push_back(std::move(built[i]));
    }
    _bounds.push_back(all);
    _numLeaves.push_back(1);
    return object;
}

std::uint32_t AccelScene::AddObject() {
    objects.emplace_back();
    _bounds.emplace_back();
    _numLeaves.push_back(0);
    return static_cast<std::uint32_t>(objects.size()) - 1;
}

std::uint32_t AccelScene::AddGroup(const std::vector<AccelPlacement>& placements,
                                   std::uint32_t numInChunk) {
    const std::uint32_t object = AddObject();
    Records made = MakeRecords(placements);
    if (numInChunk > 0) {
        PutInChunks(object, numInChunk, &made);
    }
    BuildGroup(object, made);
    return object;
}

void AccelScene::SetRoot(const std::vector<AccelPlacement>& placements, std::uint32_t numInChunk) {
    Records made = MakeRecords(placements);
    if (numInChunk > 0) {
        PutInChunks(0, numInChunk, &made);
    }
    BuildGroup(0, made);
}

/// Moves two of three records into instance chunks, which come before the pages of geometry.
void AccelScene::PutInChunks(std::uint32_t group, std::uint32_t numInChunk, Records* made) {
    Records top;
    top.numLeaves = made->numLeaves;
    std::vector<std::size_t> inChunks;
    for (std::size_t i = 0; i < made->records.size(); ++i) {
        if (i % 3 == 0) {
            top.records.push_back(made->records[i]);
            top.boxes.push_back(made->boxes[i]);
        } else {
            inChunks.push_back(i);
        }
    }
    std::vector<GeometryPage> chunks;
    for (std::size_t begin = 0; begin < inChunks.size(); begin += numInChunk) {
        std::vector<Bounds> boxes;
        for (std::size_t i = begin; i < std::min(inChunks.size(), begin + numInChunk); ++i) {
            boxes.push_back(made->boxes[inChunks[i]]);
        }
        const Bvh bvh = BuildBvh(boxes, TopOptions());
        std::vector<shared::HdsInstance> records;
        for (const std::uint32_t item : bvh.order) {
            records.push_back(made->records[inChunks[begin + item]]);
        }
        shared::HdsPageHeader header{};
        const std::size_t nodeBytes = bvh.nodes.size() * sizeof(bvh.nodes[0]);
        header.triangles = static_cast<std::uint32_t>(1 + nodeBytes / HDS_POOL_UNIT_BYTES);
        header.primIds = group;
        header.numTriangles = static_cast<std::uint32_t>(records.size()) |
                              HDS_PRIMITIVE_INSTANCES << HDS_PRIMITIVE_SHIFT;
        GeometryPage page;
        page.bytes.resize(sizeof(header) + nodeBytes + records.size() * sizeof(records[0]));
        std::memcpy(page.bytes.data(), &header, sizeof(header));
        std::memcpy(page.bytes.data() + sizeof(header), bvh.nodes.data(), nodeBytes);
        std::memcpy(page.bytes.data() + sizeof(header) + nodeBytes, records.data(),
                    records.size() * sizeof(records[0]));
        shared::HdsInstance record{};
        StoreRows(glm::dmat4(1.0), record.objectFromParent);
        record.object = AddObject();
        record.flags = HDS_INSTANCE_SEEN;
        record.pathOffset[0] = record.pathOffset[1] = HDS_NONE;
        record.prim = HDS_NONE;
        record.lightBase = HDS_NONE;
        objects.back() = {HDS_OBJECT_INSTANCES, 0,
                          numInstanceChunks + static_cast<std::uint32_t>(chunks.size()), 1};
        top.records.push_back(record);
        top.boxes.push_back(bvh.bounds);
        chunks.push_back(std::move(page));
    }
    top.closeBoxes = top.boxes;
    *made = std::move(top);
    for (shared::HdsObject& object : objects) {
        const std::uint32_t kind = object.kind & HDS_OBJECT_KIND;
        if (kind == HDS_OBJECT_TOP_TREE || kind == HDS_OBJECT_CHUNK) {
            object.itemBase += static_cast<std::uint32_t>(chunks.size());
        }
    }
    pages.insert(pages.begin() + numInstanceChunks, chunks.begin(), chunks.end());
    numInstanceChunks += static_cast<std::uint32_t>(chunks.size());
}

AccelScene::Records AccelScene::MakeRecords(const std::vector<AccelPlacement>& placements) {
    Records made;
    auto& [records, boxes, closeBoxes, numLeaves] = made;
    for (const AccelPlacement& placement : placements) {
        shared::HdsInstance record{};
        StoreRows(glm::inverse(placement.parentFromObject), record.objectFromParent);
        record.object = placement.object;
        record.flags =
            placement.flags | HDS_INSTANCE_SHADOW; // any hit counts, whatever a test is of
        Bounds box = TransformedBounds(placement.parentFromObject, _bounds[placement.object], -19);
        closeBoxes.push_back(box);
        if (placement.keys.empty()) {
            record.flags |= IsIdentity(record.objectFromParent) ? HDS_INSTANCE_IN_PLACE : 0U;
        } else {
            AddKeys(placement.keys, &record);
            const auto ends = TransformEnds(placement.keys, _bounds[placement.object]);
            box = ends[0];
            closeBoxes.back() = ends[1];
        }
        record.pathOffset[0] = static_cast<std::uint32_t>(numLeaves);
        record.pathOffset[1] = static_cast<std::uint32_t>(numLeaves >> 32U);
        const std::uint32_t kind = objects[placement.object].kind & HDS_OBJECT_KIND;
        record.prim = kind == HDS_OBJECT_GROUP ? HDS_NONE : 0;
        record.lightBase = HDS_NONE;
        record.instanceCount = placement.instanceCount;
        records.push_back(record);
        boxes.push_back(box);
        numLeaves += _numLeaves[placement.object];
    }
    return made;
}

void AccelScene::BuildGroup(std::uint32_t object, const Records& made) {
    const auto& [records, boxes, closeBoxes, numLeaves] = made;
    BvhOptions options = TopOptions();
    options.restingArea = 1.0F; // whatever moves has boxes that do
    const Bvh bvh = BuildMovingBvh({boxes, closeBoxes}, options);
    const auto numClose = static_cast<std::uint32_t>(bvh.laterNodes.size());
    objects[object] = {HDS_OBJECT_GROUP | numClose << HDS_OBJECT_CLOSE_SHIFT,
                       static_cast<std::uint32_t>(topNodes.size()),
                       static_cast<std::uint32_t>(instances.size()),
                       static_cast<std::uint32_t>(records.size())};
    topNodes.insert(topNodes.end(), bvh.nodes.begin(), bvh.nodes.end());
    topNodes.insert(topNodes.end(), bvh.laterNodes.begin(), bvh.laterNodes.end());
    const auto first = static_cast<std::uint32_t>(instances.size());
    instancesByPath.resize(first + records.size());
    for (const std::uint32_t i : bvh.order) {
        instancesByPath[first + i] = static_cast<std::uint32_t>(instances.size());
        instances.push_back(records[i]);
    }
    _bounds[object] = bvh.bounds;
    _numLeaves[object] = numLeaves;
}

void AccelScene::AddKeys(const std::vector<glm::dmat4>& keys, shared::HdsInstance* record) {
    const auto first = static_cast<std::uint32_t>(motionKeys.size());
    const auto numSegments = static_cast<std::uint32_t>(keys.size() - 1);
    // Both ways to invert are in use.
    const std::uint32_t segments = numSegments | (numSegments % 2 == 1 ? HDS_MOTION_PLAIN : 0U);
    record->flags |= HDS_INSTANCE_MOVES;
    std::memcpy(&record->objectFromParent[HDS_MOTION_FIRST_KEY], &first, sizeof(first));
    std::memcpy(&record->objectFromParent[HDS_MOTION_SEGMENTS], &segments, sizeof(segments));
    for (const glm::dmat4& key : keys) {
        motionKeys.emplace_back();
        StoreRows(key, motionKeys.back().data());
    }
}

const char* NameOf(AccelForm form) {
    return form == AccelForm::Flat ? "flat" : (form == AccelForm::Simd8 ? "simd8" : "scalar");
}

ProgramDefines DefinesOf(AccelForm form) {
    const char* isFlat = form == AccelForm::Flat ? "1" : "0";
    ProgramDefines defines = {{"HDS_TRAVERSAL_SIMD8", form == AccelForm::Scalar ? "0" : "1"},
                              {"HDS_FEATURE_FLAT", isFlat},
                              {"HDS_FEATURE_FLAT_INSTANCES", isFlat},
                              {"HDS_FEATURE_FLAT_COPIES", isFlat}};
    if (form == AccelForm::Flat) {
        defines["HDS_FEATURE_INSTANCE_CHUNKS"] = "0"; // hits have the names that tests expect
    }
    return defines;
}

FlatSource FlatSourceOf(const AccelScene& scene) {
    return {scene.topNodes.data(), scene.instances.data(), &scene.objects,
            [&scene](std::uint32_t chunk) { return scene.pages[chunk].bytes.data(); },
            scene.numInstanceChunks > 0};
}

DeviceAccelScene::DeviceAccelScene(const std::shared_ptr<Device>& device, const AccelScene& scene,
                                   const AccelUpload& upload)
    : _topNodes(UploadVector(device, "top nodes", scene.topNodes)),
      _instances(UploadVector(device, "instances", scene.instances)),
      _instancesByPath(UploadVector(device, "instances by path", scene.instancesByPath)),
      _objects(UploadVector(device, "objects", scene.objects)),
      _motionKeys(UploadVector(device, "motion keys", scene.motionKeys)),
      _numInstances(static_cast<std::uint32_t>(scene.instances.size())) {
    std::vector<std::uint32_t> addresses(2 * scene.pages.size(), HDS_NOT_RESIDENT);
    std::array<std::vector<std::uint8_t>, HDS_POOL_MAX_BUFFERS> pools;
    for (std::size_t i = 0; i < scene.pages.size(); ++i) {
        const std::size_t pool = i % upload.numPools;
        addresses[2 * i + HDS_PAGE_GEOMETRY] = static_cast<std::uint32_t>(
            pool << HDS_POOL_BUFFER_SHIFT | pools[pool].size() / HDS_POOL_UNIT_BYTES);
        pools[pool].insert(pools[pool].end(), scene.pages[i].bytes.begin(),
                           scene.pages[i].bytes.end());
    }
    for (const std::uint32_t chunk : upload.missing) {
        addresses[2 * std::size_t{chunk} + HDS_PAGE_GEOMETRY] = HDS_NOT_RESIDENT;
    }
    _addresses = UploadVector(device, "chunk addresses", addresses);
    if (upload.missing.empty() && !scene.pages.empty()) {
        _flat = BuildFlatBvh(FlatSourceOf(scene), upload.flat);
        _flatBuffer = Buffer(device, "flat hierarchy", _flat.buffer.size());
        if (!_flat.buffer.empty()) {
            _flatBuffer.Write(_flat.buffer.data(), _flat.buffer.size());
        }
    }
    for (std::size_t i = 0; i < pools.size(); ++i) {
        _pools[i] = UploadVector(device, "pool", pools[i]);
    }
}

void DeviceAccelScene::Bind(Kernel* kernel, unsigned first, bool hasMotion, bool isFlat) const {
    kernel->SetBuffer(first, _topNodes);
    kernel->SetBuffer(first + 1, _instances);
    kernel->SetBuffer(first + 2, _instancesByPath);
    kernel->SetBuffer(first + 3, _objects);
    kernel->SetBuffer(first + 4, _addresses);
    for (unsigned i = 0; i < _pools.size(); ++i) {
        kernel->SetBuffer(first + 5 + i, _pools[i]);
    }
    unsigned next = first + 5 + static_cast<unsigned>(_pools.size());
    if (hasMotion) {
        kernel->SetBuffer(next++, _motionKeys);
    }
    if (isFlat) {
        kernel->SetBuffer(next, _flatBuffer);
    }
}

} // namespace hds::test
