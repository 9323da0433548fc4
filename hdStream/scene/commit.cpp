// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/commit.h"

#include "hdStream/scene/hierarchy.h"
#include "hdStream/scene/imageLibrary.h"
#include "hdStream/scene/lightCommit.h"
#include "hdStream/scene/materialCommit.h"
#include "hdStream/scene/meshCommit.h"
#include "hdStream/scene/sceneCentre.h"
#include "hdStream/scene/transforms.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>

namespace hds {

namespace {

using MeshEntry = std::pair<const std::string, MeshPrim>;

bool IsDrawn(const MeshPrim& prim, const std::vector<std::string>& purposes) {
    return prim.placement.visible &&
           (prim.purpose == "default" ||
            std::find(purposes.begin(), purposes.end(), prim.purpose) != purposes.end());
}

/// Carries one commit through its steps.
class Committer {
public:
    Committer(const SceneDescription& scene, const CommitOptions& options, Warnings& warnings)
        : _scene(scene), _options(options), _warnings(warnings), _images(warnings),
          _materials(scene, _images, warnings), _result(std::make_unique<CommittedScene>()) {}

    std::unique_ptr<CommittedScene> Run() {
        const auto start = std::chrono::steady_clock::now();
        std::vector<const MeshEntry*> drawn;
        for (const MeshEntry& entry : _scene.meshes) {
            if (IsDrawn(entry.second, _options.purposes)) {
                drawn.push_back(&entry);
            }
        }
        _materials.Compile(drawn);
        _prepared = PrepareMeshes(drawn, _options.meshes, _warnings);
        _result->objects.emplace_back(); // the TLAS
        std::uint32_t numChunks = 0;
        for (const PreparedMesh& mesh : _prepared) {
            numChunks += static_cast<std::uint32_t>(mesh.chunks.size());
        }
        _result->pages = std::make_unique<GeometryPages>(numChunks);
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            AddMesh(*drawn[i], &_prepared[i], static_cast<std::uint32_t>(i));
        }
        _result->centre = ChooseSceneCentre(_scene, _leaves);
        AddHierarchy();
        AddLights();
        _result->materials = std::move(_materials.materials);
        _result->meshMaterials = std::move(_materials.meshMaterials);
        _result->textures = _images.Uses();
        Count();
        _result->seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return std::move(_result);
    }

private:
    void AddMesh(const MeshEntry& entry, PreparedMesh* prepared, std::uint32_t index) {
        const TriangleMesh& triangles = *prepared->triangles;
        const MeshMaterialInfo info = _materials.AddMesh(entry.first, entry.second, triangles);
        _meshInfos.push_back(info);
        shared::HdsMesh mesh{};
        mesh.materialBase = info.materialBase;
        mesh.flags = (triangles.doubleSided ? HDS_MESH_DOUBLE_SIDED : 0U) |
                     (triangles.leftHanded ? HDS_MESH_LEFT_HANDED : 0U) |
                     (info.isEmissive ? HDS_MESH_EMISSIVE : 0U);
        mesh.primId =
            entry.second.primId >= 0 ? entry.second.primId : static_cast<std::int32_t>(index);
        mesh.numPrimvars = static_cast<std::uint32_t>(triangles.attributes.size());
        _result->meshes.push_back(mesh);
        const std::uint32_t object = AddObject(prepared);
        if (prepared->chunks.empty()) {
            return;
        }
        LeafObject leaf;
        leaf.object = object;
        leaf.mesh = index;
        leaf.flags = HDS_INSTANCE_CAMERA | (info.hasCutouts ? HDS_INSTANCE_CUTOUT : 0U);
        leaf.origin = triangles.origin;
        leaf.bounds = prepared->bounds;
        leaf.ownRecord = info.isEmissive;
        _leaves[entry.first] = leaf;
        _result->hasCutouts = _result->hasCutouts || info.hasCutouts;
        _result->counts.triangles += triangles.triangles.size();
        ++_result->counts.meshes;
    }

    /// Appends the mesh's object, chunks and pages; the pages leave `prepared`.
    std::uint32_t AddObject(PreparedMesh* prepared) {
        const auto index = static_cast<std::uint32_t>(_result->objects.size());
        shared::HdsObject object{};
        object.kind = prepared->topNodes.empty() ? HDS_OBJECT_CHUNK : HDS_OBJECT_MESH;
        object.nodeBase = static_cast<std::uint32_t>(_result->topNodes.size());
        object.itemBase = static_cast<std::uint32_t>(_result->chunks.size());
        object.numItems = static_cast<std::uint32_t>(prepared->chunks.size());
        _result->objects.push_back(object);
        _result->topNodes.insert(_result->topNodes.end(), prepared->topNodes.begin(),
                                 prepared->topNodes.end());
        for (PreparedChunk& chunk : prepared->chunks) {
            shared::HdsChunk record{};
            record.triangleOffset = chunk.geometry.triangleOffset;
            record.vertexOffset = chunk.geometry.vertexOffset;
            record.numTriangles = chunk.numTriangles;
            record.object = index;
            _result->pages->SetChunk(static_cast<std::uint32_t>(_result->chunks.size()),
                                     std::move(chunk.geometry.bytes), std::move(chunk.attributes));
            _result->chunks.push_back(record);
        }
        return index;
    }

    void AddHierarchy() {
        Hierarchy hierarchy =
            BuildHierarchy(_scene, _leaves, _result->centre,
                           static_cast<std::uint32_t>(_result->objects.size()), _warnings);
        const auto nodeBase = static_cast<std::uint32_t>(_result->topNodes.size());
        for (shared::HdsObject& group : hierarchy.groups) {
            group.nodeBase += nodeBase;
        }
        _result->objects[0] = hierarchy.groups[0];
        _result->objects.insert(_result->objects.end(), hierarchy.groups.begin() + 1,
                                hierarchy.groups.end());
        _result->topNodes.insert(_result->topNodes.end(), hierarchy.nodes.begin(),
                                 hierarchy.nodes.end());
        _result->instances = std::move(hierarchy.instances);
        _result->instancesByPath = std::move(hierarchy.instancesByPath);
        _result->hasGroups = hierarchy.depth > 0;
        _result->counts.instances = hierarchy.numLeaves;
        _ownRecords = std::move(hierarchy.ownRecords);
    }

    void AddLights() {
        LightCommitInput input;
        input.scene = &_scene;
        input.centre = _result->centre;
        input.meshes = &_prepared;
        input.meshInfos = &_meshInfos;
        input.materials = &_materials;
        input.ownRecords = &_ownRecords;
        CommittedLights lights = CommitLights(input, _images, _warnings);
        _result->lights = std::move(lights.table);
        _result->lightByEntry = std::move(lights.lightByEntry);
        _result->counts.emissiveTriangles = lights.emissiveTriangles;
        // The hierarchy left the index of the own record.
        for (shared::HdsInstance& instance : _result->instances) {
            if (instance.lightBase != HDS_NONE) {
                instance.lightBase = lights.firstEntryByRecord[instance.lightBase];
            }
        }
    }

    void Count() {
        SceneCounts& counts = _result->counts;
        counts.chunks = _result->chunks.size();
        for (std::uint32_t page = 0; page < _result->pages->NumPages(); ++page) {
            counts.pageBytes += _result->pages->PageBytes(page);
        }
        counts.alwaysResidentBytes =
            _result->topNodes.size() * sizeof(shared::HdsBvhNode) +
            _result->instances.size() * (sizeof(shared::HdsInstance) + sizeof(std::uint32_t)) +
            _result->objects.size() * sizeof(shared::HdsObject) +
            _result->chunks.size() * (sizeof(shared::HdsChunk) + 2 * sizeof(std::uint32_t));
        counts.textures = _result->textures.size();
        for (const TextureUse& texture : _result->textures) {
            counts.textureSourceBytes += texture.bytesSource;
        }
        counts.lights = _scene.lights.size();
    }

    const SceneDescription& _scene;
    const CommitOptions& _options;
    Warnings& _warnings;
    ImageLibrary _images;
    MaterialCommit _materials;
    std::unique_ptr<CommittedScene> _result;
    std::vector<PreparedMesh> _prepared;
    std::vector<MeshMaterialInfo> _meshInfos; ///< by mesh index
    std::map<std::string, LeafObject> _leaves;
    std::vector<OwnRecord> _ownRecords;
};

} // namespace

std::unique_ptr<CommittedScene> CommitScene(const SceneDescription& scene,
                                            const CommitOptions& options, Warnings& warnings) {
    return Committer(scene, options, warnings).Run();
}

} // namespace hds
