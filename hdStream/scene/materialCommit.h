// SPDX-License-Identifier: Apache-2.0
// Materials of the drawn prims: compiled once, resolved against each prim's primvars; equal
// records, programs and textures shared.
#pragma once

#include "hdStream/scene/geometryStore.h"
#include "hdStream/scene/imageLibrary.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace hds {

/// What lights ask of a material entry that emits.
struct MaterialEntryInfo {
    EmissionInput emission;
    MaterialSyncMode syncMode = MaterialSyncMode::GlowTintsLight; ///< of mesh lights
};

/// What a prim's material entries say about the prim.
struct PrimMaterialInfo {
    std::uint32_t materialBase = 0; ///< first of its entries in primMaterials
    std::vector<MaterialEntryInfo> entries;
    bool hasCutouts = false; ///< some entry may let rays pass
    bool isEmissive = false; ///< some entry emits
    bool isHair = false;     ///< some entry is hair
    bool isGlass = false;    ///< shadow rays may pass some entry where it refracts
    bool hasMedium = false;  ///< some entry has a medium inside (kernels/shared/meshMedium.h)
    bool isFilled = false;   ///< the same, or some surface scatters below by its own inputs
};

/// A compiled material and what it was made of.
struct CachedMaterial {
    std::shared_ptr<const MaterialNetwork> network;
    CompiledMaterial compiled;
    std::set<std::string> primvars;     ///< that it may read
    std::vector<AssetReference> images; ///< asked for, readable or not
};

/// By path. Networks are told apart by identity.
using MaterialCache = std::map<std::string, CachedMaterial>;

/// Collects the records. Externally synchronised.
class MaterialCommit {
public:
    /// \param glassShadows as CommitOptions::glassShadows
    MaterialCommit(const SceneDescription& scene, MaterialCache* cache, ImageLibrary& images,
                   bool glassShadows, Warnings& warnings)
        : _scene(scene), _cache(*cache), _images(images), _glassShadows(glassShadows),
          _warnings(warnings) {}

    /// A material of a prim: its own, or that of a subset.
    struct Entry {
        const std::string* path;
        const CachedMaterial* material;
    };

    /// Compiles the materials the prims use, on all cores, unless the cache has them. Below, prims
    /// are told by their index in this list.
    void Compile(const std::vector<const std::pair<const std::string, GeometryPrim>*>& prims);

    /// Calls `function` with each entry of a prim: its own material, then one for each subset.
    template <typename Function>
    void ForEachEntry(std::size_t index, const Function& function) const {
        std::for_each(_entries.begin() + _firstEntry[index],
                      _entries.begin() + _firstEntry[index + 1], function);
    }

    /// Appends the entries of a prim. \param ofInstances its primvars with a value an instance.
    PrimMaterialInfo AddPrim(std::size_t index, const std::string& path, const GeometryPrim& prim,
                             const PlannedGeometry& prepared,
                             const std::vector<AttributeName>& ofInstances);

    /// Whether AddPrim may say that a prim is filled.
    bool MayBeFilled(std::size_t index, const GeometryPrim& prim) const;

    /// By entry; reads images of heights.
    void GetDisplacements(std::size_t index, std::vector<DisplacementInput>* displacements) const;

    /// Names of the primvars that the materials of a prim may read, by entry.
    std::vector<const std::set<std::string>*> PrimvarsOf(std::size_t index) const;

    /// What networks ask of images. \param asked gets each that is asked for; may be null.
    ImageQueries Images(std::vector<AssetReference>* asked) const;

    /// Adds textures that programs read. \return the index of each in `textures`.
    std::vector<std::uint32_t> AddTextures(const std::vector<MaterialTexture>& added);

    std::vector<shared::HdsMaterial> materials;
    std::vector<std::uint32_t> primMaterials;
    std::vector<std::uint32_t> programs;   ///< of all materials, one after another
    std::vector<MaterialTexture> textures; ///< that programs read, each once, after those of lights
    std::uint32_t maxLookups = 0;          ///< of textures in one program
    std::uint32_t lobes = 0;               ///< HDS_LOBE_* of all materials
    bool hasMedia = false;                 ///< some material has HDS_MATERIAL_MEDIUM
    bool hasHair = false;                  ///< some material has HDS_MATERIAL_HAIR
    std::vector<shared::HdsMeshMedium> meshMedia; ///< that fill meshes; materials count from 1

private:
    std::optional<shared::HdsMeshMedium> MediumOf(const std::string& path, const GeometryPrim& prim,
                                                  const CompiledMaterial& material);
    std::uint32_t AddMedium(const std::string& path, const GeometryPrim& prim,
                            const shared::HdsMeshMedium& medium);
    std::uint32_t AddRecord(const shared::HdsMaterial& record);
    std::uint32_t AddProgram(const std::vector<std::uint32_t>& words);
    MaterialSyncMode SyncModeOf(const GeometryPrim& prim, const std::string& materialPath) const;
    CachedMaterial CompileNetwork(const std::string& path,
                                  const std::shared_ptr<const MaterialNetwork>& network);

    const SceneDescription& _scene;
    MaterialCache& _cache;
    ImageLibrary& _images;
    bool _glassShadows;
    Warnings& _warnings;
    std::map<std::string, const CachedMaterial*> _used; ///< by path; "": no material
    std::vector<Entry> _entries;                        ///< of all prims
    std::vector<std::uint32_t> _firstEntry = {0};       ///< by prim, and the end
    CachedMaterial _displayColor;
    CachedMaterial _splats;
    CompiledMaterial _black = BlackMaterial();
    std::map<std::string, std::uint32_t> _indexByBytes;
    std::map<std::string, std::uint32_t> _mediumByBytes;
    std::map<std::vector<std::uint32_t>, std::uint32_t> _programByWords;
    std::map<std::string, std::uint32_t> _textureByKey;
};

} // namespace hds
