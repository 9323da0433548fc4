// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/emissiveMeshes.h"

#include "hdStream/scene/emissionGuess.h"
#include "hdStream/scene/motion.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace hds {

namespace {

/// The rounding of float transforms and positions, against the magnitudes that are rounded.
constexpr int kPositionErrorExponent = -21;
/// So many of them where the device interpolates and inverts what it rounds.
constexpr double kMotionErrors = 4.0;

glm::dvec3 EmissionOf(const shared::HdsMaterial& material) {
    const shared::float4& color = material.constants[HDS_INPUT_EMISSIVE_COLOR];
    return {color.x, color.y, color.z};
}

class Collector {
public:
    Collector(const LightCommitInput& input, CommitCache* cache, Warnings& warnings)
        : _input(input), _cache(*cache), _warnings(warnings) {}

    EmissiveMeshes Run() {
        for (auto& [key, image] : _cache.emissionImages) {
            image.isUsed = false;
        }
        for (const WorldInstance& record : *_input.worldInstances) {
            const PrimMaterialInfo& info = (*_input.primInfos)[record.prim];
            _result.firstEntryByRecord.push_back(std::uint32_t(_result.meshByEntry.size()));
            for (std::uint32_t entry = 0; entry < info.entries.size(); ++entry) {
                _result.meshByEntry.push_back(HDS_NONE);
                AddEntry(record, info, entry);
            }
        }
        if (_numLeftOut > 0) {
            _warnings.Add(_firstLeftOut,
                          "emits but is not sampled as a light" +
                              (_numLeftOut > 1
                                   ? ", and " + std::to_string(_numLeftOut - 1) + " more"
                                   : std::string()) +
                              ": the scene has more than " + std::to_string(kMaxEmissiveTriangles) +
                              " emissive triangles");
        }
        DropImages();
        return std::move(_result);
    }

private:
    /// Every edit of a factor makes an image: those of before must not stay.
    void DropImages() {
        for (auto image = _cache.emissionImages.begin(); image != _cache.emissionImages.end();) {
            image = image->second.isUsed ? std::next(image) : _cache.emissionImages.erase(image);
        }
    }

    void AddEntry(const WorldInstance& record, const PrimMaterialInfo& info, std::uint32_t entry) {
        const GeometryPrim& prim = _input.scene->geometry.at(record.path);
        const shared::HdsMaterial& material =
            _input.materials->materials[_input.materials->primMaterials[info.materialBase + entry]];
        if ((material.flags & HDS_MATERIAL_EMISSIVE) == 0 ||
            prim.geometry->primitives != PrimitiveKind::Faces) {
            return; // what curves and points emit is found by BSDF sampling alone
        }
        // A light that is not sampled still replaces what its material emits.
        const std::uint64_t bound = _cache.geometry.Find(record.path).numTriangles;
        const bool isTooLarge = bound > kMaxEmissiveTriangles;
        EmissiveMesh mesh;
        if (!isTooLarge || prim.light) {
            mesh = MakeMesh(record, prim, material, info.entries[entry], entry, !isTooLarge);
        }
        if (isTooLarge || _result.numTriangles + mesh.triangles.size() > kMaxEmissiveTriangles) {
            _firstLeftOut = _numLeftOut++ == 0 ? record.path : _firstLeftOut;
            mesh.triangles.clear();
        }
        if (!mesh.triangles.empty() || mesh.lux) {
            _result.numTriangles += mesh.triangles.size();
            _result.meshByEntry.back() = std::uint32_t(_result.meshes.size());
            _result.meshes.push_back(std::move(mesh));
        }
    }

    /// \param isSampled its triangles are kept.
    EmissiveMesh MakeMesh(const WorldInstance& record, const GeometryPrim& prim,
                          const shared::HdsMaterial& material, const MaterialEntryInfo& info,
                          std::uint32_t entry, bool isSampled) {
        EmissiveMesh mesh;
        mesh.name = record.path;
        mesh.twoSided = !prim.light || prim.doubleSided;
        const bool asksMaterial = !prim.light || info.syncMode == MaterialSyncMode::GlowTintsLight;
        mesh.hasTexturedEmission = asksMaterial && !HasConstantEmission(material);
        mesh.radiance =
            asksMaterial && !mesh.hasTexturedEmission ? EmissionOf(material) : glm::dvec3(1.0);
        if (prim.light) {
            mesh.lux.emplace();
            mesh.lux->name = record.path;
            mesh.lux->light = prim.light->light;
            mesh.lux->light.visibleToCamera = info.syncMode == MaterialSyncMode::NoMaterialResponse;
            mesh.lux->worldFromLight = record.worldFromObject;
            mesh.lux->lightLink = _input.links->IndexOf(prim.light->links.lightLink);
            mesh.lux->shadowLink = _input.links->IndexOf(prim.light->links.shadowLink);
            if (asksMaterial && !mesh.hasTexturedEmission && mesh.radiance == glm::dvec3(0.0)) {
                _warnings.Add(record.path, "its material emits nothing: as a mesh light of "
                                           "materialGlowTintsLight it is dark");
            }
            if (mesh.hasTexturedEmission) {
                DropControls(record.path, &mesh.lux->light);
            }
        }
        // What is normalized asks for its area though it is not sampled.
        if (isSampled || mesh.lux->light.normalize) {
            const bool isGuessed = isSampled && mesh.hasTexturedEmission;
            AddTriangles(record, isGuessed ? info.emission : EmissionInput(), entry, isSampled,
                         &mesh);
            if (mesh.lux && !(mesh.wholeArea > 0.0)) {
                _warnings.Add(record.path, "mesh light has no area; it lights nothing");
            }
        }
        return mesh;
    }

    /// Shadow rays to such lights end at geometry, so that they cannot be cut short.
    void DropControls(const std::string& path, LightDescription* light) {
        const LightShadow plain;
        if (light->shadow.enable != plain.enable || light->shadow.color != plain.color ||
            light->shadow.distance != plain.distance) {
            _warnings.Add(path, "shadow controls of a mesh light whose material varies its "
                                "emission are ignored");
            light->shadow = plain;
        }
    }

    void AddTriangles(const WorldInstance& record, const EmissionInput& emission,
                      std::uint32_t entry, bool isSampled, EmissiveMesh* mesh) {
        const ChunkGeometry& chunk = _cache.geometry.Triangles(record.path);
        const EmissionGuess guess(emission, chunk, *_input.materials, &_cache);
        // A reflection turns the winding; emission keeps to the side of the object's normals.
        const bool isTurned = (glm::determinant(glm::dmat3(record.worldFromObject)) < 0.0) !=
                              _cache.geometry.Find(record.path).leftHanded;
        const bool moves = !chunk.keys.empty() || !record.keys.empty();
        if (moves && isSampled) {
            BeginMotion(record, chunk, mesh);
        }
        for (std::uint32_t i = 0; i < chunk.triangles.size(); ++i) {
            EmissiveMesh::Triangle triangle;
            for (int k = 0; k < 3; ++k) {
                const glm::dvec3 position(chunk.positions[chunk.triangles[i][k]]);
                const int to = isTurned ? 2 - k : k;
                triangle.p[to] = glm::dvec3(record.worldFromObject * glm::dvec4(position, 1.0));
            }
            mesh->wholeArea += 0.5 * glm::length(glm::cross(triangle.p[1] - triangle.p[0],
                                                            triangle.p[2] - triangle.p[0]));
            const bool isOfEntry =
                (chunk.materialEntries.empty() ? 0 : chunk.materialEntries[i]) == entry;
            if (isSampled && isOfEntry) {
                triangle.primId = chunk.primIds[i];
                triangle.meanEmission = guess.Of(i);
                mesh->triangles.push_back(triangle);
                AddShapes(chunk, chunk.triangles[i], isTurned, mesh);
            }
        }
        SetPositionError(record, chunk, mesh);
    }

    static void BeginMotion(const WorldInstance& record, const ChunkGeometry& chunk,
                            EmissiveMesh* mesh) {
        mesh->shapes.resize(chunk.keys.size() + 1);
        mesh->worldFromObject = record.keys;
        if (record.keys.empty()) {
            mesh->worldFromObject = {record.worldFromObject};
        } else {
            bool isRigid = true;
            mesh->turns = TurnsOf(record.keys, record.worldFromObject, &isRigid);
        }
    }

    /// The triangle at the keys of its vertices, where the mesh moves.
    static void AddShapes(const ChunkGeometry& chunk, const glm::uvec3& corners, bool isTurned,
                          EmissiveMesh* mesh) {
        for (std::size_t key = 0; key < mesh->shapes.size(); ++key) {
            const std::vector<glm::vec3>& positions =
                key == 0 ? chunk.positions : chunk.keys[key - 1].positions;
            EmissiveMesh::Shape shape;
            for (int k = 0; k < 3; ++k) {
                shape.p[isTurned ? 2 - k : k] = positions[corners[k]];
            }
            mesh->shapes[key].push_back(shape);
        }
    }

    static void SetPositionError(const WorldInstance& record, const ChunkGeometry& chunk,
                                 EmissiveMesh* mesh) {
        glm::dvec3 reach(0.0);
        const auto grow = [&reach](const std::vector<glm::vec3>& positions) {
            for (const glm::vec3& position : positions) {
                reach = glm::max(reach, glm::dvec3(glm::abs(position)));
            }
        };
        grow(chunk.positions);
        for (const ChunkKey& key : chunk.keys) {
            grow(key.positions);
        }
        const auto errorOf = [&reach](const glm::dmat4& worldFromObject) {
            glm::dvec3 magnitude = glm::abs(glm::dvec3(worldFromObject[3]));
            for (int column = 0; column < 3; ++column) {
                magnitude += glm::abs(glm::dvec3(worldFromObject[column])) * reach[column];
            }
            return std::ldexp(glm::length(magnitude), kPositionErrorExponent);
        };
        mesh->positionError = errorOf(record.worldFromObject);
        for (const glm::dmat4& key : mesh->worldFromObject) {
            mesh->positionError = std::max(mesh->positionError, kMotionErrors * errorOf(key));
        }
    }

    const LightCommitInput& _input;
    CommitCache& _cache;
    Warnings& _warnings;
    EmissiveMeshes _result;
    std::size_t _numLeftOut = 0;
    std::string _firstLeftOut;
};

} // namespace

EmissiveMeshes CollectEmissiveMeshes(const LightCommitInput& input, CommitCache* cache,
                                     Warnings& warnings) {
    return Collector(input, cache, warnings).Run();
}

} // namespace hds
