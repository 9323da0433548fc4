// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/commit.h"

#include "hdStream/scene/drawnPaths.h"
#include "hdStream/scene/hierarchy.h"
#include "hdStream/scene/lightCommit.h"
#include "hdStream/scene/mediaBounds.h"
#include "hdStream/scene/pagedTables.h"
#include "hdStream/scene/primCommit.h"
#include "hdStream/scene/sceneCentre.h"
#include "hdStream/scene/textureImages.h"
#include "hdStream/shading/programWriter.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace hds {

namespace {

/// Carries one commit through its steps.
class Committer {
public:
    /// \param prims of the scene, with Run done. \param areKept they serve later commits, too.
    Committer(const SceneDescription& scene, const CommitOptions& options, CommitCache* cache,
              Warnings& warnings, std::shared_ptr<PrimCommit> prims, bool areKept)
        : _scene(scene), _options(options), _cache(*cache), _warnings(warnings),
          _prims(std::move(prims)), _areKept(areKept), _materials(_prims->materials),
          _result(std::make_unique<CommittedScene>()), _links(_prims->links) {}

    std::unique_ptr<CommittedScene> Run() {
        static_cast<CommittedPrims&>(*_result) = Handed(&_prims->prims);
        _prims->Describe(_result.get());
        _leaves = _areKept ? _prims->VisibleLeaves() : _prims->TakeLeaves();
        _result->centre = ChooseSceneCentre(_scene, _leaves);
        _result->mediaBounds = FindMediaBounds(_scene, _leaves, _result->centre, _options.shutter);
        AddHierarchy();
        AddLights();
        AddCatchers();
        AddMaterials();
        AddVolumes();
        AddMeshMedia();
        if (_result->hasInstanceChunks) {
            *_pagedTables = TakeFromTables(_result.get());
        }
        _result->textures = _cache.images.Uses();
        Count();
        return std::move(_result);
    }

private:
    /// Of the prims: a copy where they are kept.
    template <typename T>
    T Handed(T* value) const {
        if (_areKept) {
            return *value;
        }
        return std::move(*value);
    }

    /// Those of volumes first: they add textures.
    void AddMaterials() {
        _volumeMaterials = ReadVolumeMaterials(
            _scene, _options.purposes,
            [this](const std::string& path) {
                return IsDrawnPath(path, _options.drawnPaths, _options.hiddenPaths);
            },
            &_materials, _warnings);
        _result->materials = Handed(&_materials.materials);
        _result->primMaterials = Handed(&_materials.primMaterials);
        _result->programs = Handed(&_materials.programs);
        _result->hasClosures = HasClosures(_result->programs);
        _result->hasTransforms = HasTransforms(_result->programs);
        _result->hasAutobump = HasAutobump(_result->programs);
        _result->lobes = _materials.lobes;
        _result->hasMedia = _materials.hasMedia;
        _result->hasHair = _materials.hasHair;
        OffsetPositions(&_result->programs, HDS_SPACE_WORLD,
                        {static_cast<float>(_result->centre.x),
                         static_cast<float>(_result->centre.y),
                         static_cast<float>(_result->centre.z)});
        // Of lights those along a ray, and the one that is sampled.
        const std::uint32_t numImages = _result->lights->numImages;
        _result->maxLookups = _materials.maxLookups + (numImages > 0 ? numImages + 1 : 0);
        _result->textureTable = Handed(&_materials.textures);
        _result->images = &_cache.images;
        _result->textureLines = std::make_unique<TextureLines>(
            _cache.textures, MakeTextureImages(_result->textureTable, _cache.images));
    }

    void AddHierarchy() {
        Hierarchy hierarchy = BuildHierarchy(_scene, _leaves, _result->centre,
                                             static_cast<std::uint32_t>(_result->objects.size()),
                                             &_links, _options.shutter, _warnings,
                                             // Catchers need a second table of all instances.
                                             {_result->hasCatchers ? 0U : _options.instanceChunks,
                                              _options.chunkBytes, _cache.geometry.Pages()},
                                             std::move(_result->topNodes));
        if (!hierarchy.instanceChunks.empty()) {
            AddInstanceChunks(hierarchy.instanceChunks);
        }
        _result->hasCutouts = _result->hasCutouts || _links.HaveUnshadowing();
        _links.NumberVolumes();
        _links.WarnOfOverflow(_warnings);
        _result->objects[0] = hierarchy.groups[0];
        _result->objects.insert(_result->objects.end(), hierarchy.groups.begin() + 1,
                                hierarchy.groups.end());
        _result->topNodes = std::move(hierarchy.nodes);
        _result->instances = std::move(hierarchy.instances);
        _result->instancesByPath = std::move(hierarchy.instancesByPath);
        _result->hasGroups = hierarchy.depth > 0;
        _result->flatPart = hierarchy.flatPart;
        _result->hasMotion = _result->hasMotion || !hierarchy.motionKeys.empty();
        _result->motionKeys = std::move(hierarchy.motionKeys);
        _result->counts.instances = hierarchy.numLeaves;
        _worldInstances = std::move(hierarchy.worldInstances);
    }

    /// Their chunks come before all others.
    void AddInstanceChunks(const std::vector<std::shared_ptr<const InstanceChunks>>& instances) {
        std::vector<std::shared_ptr<ChunkPages>> chunks;
        for (const std::shared_ptr<const InstanceChunks>& ofGroup : instances) {
            const auto maker =
                std::make_shared<PagedInstances>(ofGroup, _pagedTables, _result->prims.size());
            for (std::uint32_t chunk = 0; chunk < ofGroup->NumChunks(); ++chunk) {
                chunks.push_back(std::make_shared<ChunkPages>(maker, chunk));
            }
        }
        for (std::size_t i = 1; i < _result->objects.size(); ++i) { // of geometry, so far
            _result->objects[i].itemBase += static_cast<std::uint32_t>(chunks.size());
        }
        _result->pages = std::make_shared<GeometryPages>(*_result->pages); // not those of others
        _result->pages->AddInstanceChunks(chunks);
        _result->hasInstanceChunks = true;
    }

    void AddLights() {
        LightCommitInput input = _prims->LightInput(_result->centre);
        input.worldInstances = &_worldInstances;
        input.links = &_links;
        CommittedLights lights = CommitLights(input, &_cache, _warnings);
        _result->lights = _cache.lights;
        _result->hasMotion = _result->hasMotion || _cache.lights->hasMotion;
        _result->lightByEntry = std::move(lights.lightByEntry);
        _result->counts.emissiveTriangles = lights.emissiveTriangles;
        _result->hasCutouts = _result->hasCutouts || _cache.lights->hasTexturedEmission;
        for (std::size_t i = 0; i < _worldInstances.size(); ++i) {
            if (_worldInstances[i].instance != HDS_NONE) {
                shared::HdsInstance& instance = _result->instances[_worldInstances[i].instance];
                instance.flags |= lights.texturedEmissionByRecord[i] ? HDS_INSTANCE_CUTOUT
                                                                     : 0U; // shadow rays end there
                instance.lightBase = lights.firstEntryByRecord[i];
            }
        }
        if (_areKept) {
            _prims->worldInstances = std::move(_worldInstances);
        }
    }

    /// The scene that tells what light catchers have without others: what emits is there, as all
    /// lights are.
    void AddCatchers() {
        if (!_result->hasCatchers) {
            return;
        }
        _result->catchersAlone = _result->instances;
        for (shared::HdsInstance& instance : _result->catchersAlone) {
            const bool stays = instance.prim == HDS_NONE || instance.lightBase != HDS_NONE ||
                               (instance.flags & HDS_INSTANCE_CATCHER) != 0;
            instance.flags &= stays ? ~0U : ~HDS_INSTANCE_SEEN;
        }
    }

    /// After the textures, whose numbers those of grids follow.
    void AddVolumes() {
        std::vector<std::uint32_t>& programs = _result->programs;
        _result->volumes =
            CommitVolumes(_scene, std::move(_volumeMaterials), _options.shutter, _result->centre,
                          {static_cast<std::uint32_t>(_result->textureTable.size()),
                           static_cast<std::uint32_t>(programs.size())},
                          {_cache.grids.get(), &_cache.images}, &_links, _warnings);
        const std::vector<std::uint32_t>& patterns = _result->volumes.programs;
        programs.insert(programs.end(), patterns.begin(), patterns.end());
        _result->maxLookups = std::max(_result->maxLookups, _result->volumes.maxLookups);
        _result->hasPatterns = HasPatterns(programs) || _result->volumes.havePatterns;
        _result->lines =
            std::make_unique<SceneLines>(_result->textureLines.get(), &_result->volumes.prepared);
        if (!_result->volumes.volumes.empty()) { // kernels have what volumes need
            _result->hasCutouts = true;
            _result->hasMedia = true;
            _result->lobes |= HDS_LOBE_BASE | HDS_LOBE_TRANSLUCENCY;
            _result->hasMotion = _result->hasMotion || _result->volumes.haveMotion;
            AddVolumeKeys();
        }
        if (const auto matrix = WorkingFromRec709(_options.workingSpace)) {
            for (shared::HdsVolume& volume : _result->volumes.volumes) {
                std::copy(matrix->begin(), matrix->end(), volume.workingFromRec709);
                _result->hasWorkingSpace = true;
            }
        }
    }

    /// Behind those of instances.
    void AddVolumeKeys() {
        const auto first = static_cast<std::uint32_t>(_result->motionKeys.size());
        for (shared::HdsVolume& volume : _result->volumes.volumes) {
            volume.firstKey += volume.numSegments > 0 ? first : 0;
        }
        std::vector<AffineRows>& keys = _result->volumes.motionKeys;
        _result->motionKeys.insert(_result->motionKeys.end(), keys.begin(), keys.end());
        keys.clear();
    }

    void AddMeshMedia() {
        _result->meshMedia = Handed(&_materials.meshMedia);
        if (!_result->meshMedia.empty()) { // kernels have what they need
            _result->hasMedia = true;
            _result->hasCutouts = true;
            _result->lobes |= HDS_LOBE_BASE | HDS_LOBE_TRANSLUCENCY;
        }
    }

    void Count() {
        SceneCounts& counts = _result->counts;
        counts.chunks = _result->pages->NumChunks();
        counts.alwaysResidentBytes =
            _result->topNodes.size() * sizeof(shared::HdsBvhNode) +
            _result->instances.size() * (sizeof(shared::HdsInstance) + sizeof(std::uint32_t)) +
            _result->motionKeys.size() * sizeof(AffineRows) +
            _result->catchersAlone.size() * sizeof(shared::HdsInstance) +
            _result->objects.size() * sizeof(shared::HdsObject) +
            _result->instancePrimvars.Bytes() + _result->pages->NumPages() * sizeof(std::uint32_t);
        const CommittedVolumes& volumes = _result->volumes;
        counts.volumes = volumes.volumes.size();
        counts.grids = volumes.grids.size();
        counts.bricks = volumes.numBricks;
        counts.volumeTableBytes = volumes.volumes.size() * sizeof(shared::HdsVolume) +
                                  volumes.terms.size() * sizeof(shared::HdsVolumeTerms) +
                                  volumes.grids.size() * sizeof(shared::HdsGrid) +
                                  volumes.tiles.size() * sizeof(shared::HdsGridTile) +
                                  volumes.cells.size() * sizeof(shared::HdsGridCell);
        counts.textures = _result->textures.size();
        for (const TextureUse& texture : _result->textures) {
            counts.textureSourceBytes += texture.bytesSource;
        }
        counts.lights = _scene.lights.size();
    }

    const SceneDescription& _scene;
    const CommitOptions& _options;
    CommitCache& _cache;
    Warnings& _warnings;
    std::shared_ptr<PrimCommit> _prims;
    bool _areKept;
    MaterialCommit& _materials; ///< of the prims
    std::unique_ptr<CommittedScene> _result;
    VolumeMaterials _volumeMaterials;
    LightLinks _links;
    std::vector<DrawnLeaf> _leaves; ///< in the order of paths
    std::vector<WorldInstance> _worldInstances;
    std::shared_ptr<PagedTables> _pagedTables = std::make_shared<PagedTables>(); ///< filled last
};

/// \param first slot of the list.
std::uint32_t SlotIn(const std::vector<AttributeName>& list, std::uint32_t first,
                     const std::string& name) {
    const auto found = std::find_if(list.begin(), list.end(),
                                    [&name](const AttributeName& one) { return one.name == name; });
    return found == list.end() ? HDS_NONE
                               : first + static_cast<std::uint32_t>(found - list.begin());
}

/// What the last commit has left of prims, if it is what another would make; null: it is not.
std::shared_ptr<PrimCommit> FindKeptPrims(const CommitOptions& options, const CommitCache& cache) {
    const bool isSame = cache.prims && cache.contentVersion != 0 &&
                        cache.primsVersion == cache.contentVersion &&
                        cache.prims->Options() == options && cache.prims->IsStillTrue();
    return isSame ? cache.prims : nullptr;
}

} // namespace

std::vector<std::uint32_t> FindSlots(const CommittedScene& scene,
                                     const std::vector<std::string>& names) {
    const std::vector<std::vector<AttributeName>>& ofInstances = scene.instancePrimvars.names;
    std::vector<std::uint32_t> slots;
    for (std::size_t prim = 0; prim < scene.primAttributes.size(); ++prim) {
        for (const std::string& name : names) {
            std::uint32_t slot = SlotIn(*scene.primAttributes[prim], HDS_SLOT_USER, name);
            if (slot == HDS_NONE && !ofInstances.empty()) {
                slot = SlotIn(ofInstances[prim], HDS_SLOT_INSTANCE, name);
            }
            slots.push_back(slot);
        }
    }
    return slots;
}

std::unique_ptr<CommittedScene> CommitScene(const SceneDescription& scene,
                                            const CommitOptions& options, CommitCache* cache,
                                            Warnings& warnings, const CancelCallback& isCancelled) {
    const auto start = std::chrono::steady_clock::now();
    std::shared_ptr<PrimCommit> prims = FindKeptPrims(options, *cache);
    if (prims && !cache->reshaped.empty()) {
        const PrimCommit::Reshaped reshaped = prims->Reshape(cache->reshaped, isCancelled);
        if (reshaped == PrimCommit::Reshaped::Cancelled) {
            return nullptr;
        }
        prims = reshaped == PrimCommit::Reshaped::Done ? prims : nullptr;
    }
    prims = prims && prims->Recolour(nullptr, nullptr) ? prims : nullptr;
    cache->reshaped.clear();
    const SceneDescription* inWorkingSpace = &scene;
    if (!prims) {
        cache->prims.reset(); // frees first
        inWorkingSpace = &cache->colors.Convert(scene, options.workingSpace, warnings);
        prims = std::make_shared<PrimCommit>(*inWorkingSpace, options, cache, warnings);
        if (!prims->Run(isCancelled)) {
            return nullptr;
        }
        // What was converted is converted anew, as another scene.
        if (cache->contentVersion != 0 && inWorkingSpace == &scene && prims->OutlivesPlaces()) {
            cache->prims = prims;
            cache->primsVersion = cache->contentVersion;
        }
    }
    if (isCancelled && isCancelled()) {
        return nullptr;
    }
    prims->ForgetTables();
    auto result =
        Committer(*inWorkingSpace, options, cache, warnings, prims, prims == cache->prims).Run();
    result->seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}

} // namespace hds
