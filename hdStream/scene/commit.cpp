// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/commit.h"

#include "hdStream/geometry/awayArrays.h"
#include "hdStream/geometry/subdivSource.h"
#include "hdStream/scene/drawnPaths.h"
#include "hdStream/scene/geometryMotion.h"
#include "hdStream/scene/hierarchy.h"
#include "hdStream/scene/lightCommit.h"
#include "hdStream/scene/materialCommit.h"
#include "hdStream/scene/mediaBounds.h"
#include "hdStream/scene/rayVisibility.h"
#include "hdStream/scene/sceneCentre.h"
#include "hdStream/scene/textureImages.h"
#include "hdStream/scene/transforms.h"
#include "hdStream/shading/programWriter.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>
#include <set>

namespace hds {

namespace {

using GeometryEntry = GeometryStore::Entry;

bool IsDrawn(const GeometryEntry& entry, const CommitOptions& options) {
    const auto& [path, prim] = entry;
    const std::vector<std::string>& purposes = options.purposes;
    return prim.geometry && prim.placement.visible &&
           std::find(purposes.begin(), purposes.end(), prim.purpose) != purposes.end() &&
           IsDrawnPath(path, options.drawnPaths, options.hiddenPaths);
}

/// HDS_PRIM_CULL_* of a prim.
std::uint32_t CullFlags(const GeometryPrim& prim, CullStyle fallback) {
    switch (prim.cullStyle == CullStyle::DontCare ? fallback : prim.cullStyle) {
    case CullStyle::Back:
        return HDS_PRIM_CULL_BACK;
    case CullStyle::Front:
        return HDS_PRIM_CULL_FRONT;
    case CullStyle::BackUnlessDoubleSided:
        return prim.doubleSided ? 0U : HDS_PRIM_CULL_BACK;
    case CullStyle::FrontUnlessDoubleSided:
        return prim.doubleSided ? 0U : HDS_PRIM_CULL_FRONT;
    case CullStyle::DontCare:
    case CullStyle::Nothing:
        break;
    }
    return 0U;
}

/// Carries one commit through its steps.
class Committer {
public:
    Committer(const SceneDescription& scene, const CommitOptions& options, CommitCache* cache,
              Warnings& warnings)
        : _scene(scene), _options(options), _cache(*cache), _warnings(warnings),
          _materials(scene, &cache->materials, cache->images, options.glassShadows, warnings),
          _instancePrimvars(scene, warnings), _result(std::make_unique<CommittedScene>()),
          _links(scene) {}

    std::unique_ptr<CommittedScene> Run(const CancelCallback& isCancelled) {
        const auto start = std::chrono::steady_clock::now();
        std::vector<const GeometryEntry*> drawn;
        for (const GeometryEntry& entry : _scene.geometry) {
            if (IsDrawn(entry, _options)) {
                drawn.push_back(&entry);
            } else if (entry.second.geometry) {
                DropArrays(*entry.second.geometry);
            }
        }
        _cache.images.BeginCommit();
        _materials.textures = LoadLightTextures(_scene, &_cache);
        _materials.Compile(drawn);
        if (!_cache.geometry.Prepare(_scene, InputsOf(drawn), _warnings, isCancelled)) {
            return nullptr;
        }
        if (isCancelled && isCancelled()) {
            return nullptr;
        }
        AddObjects(drawn.size());
        _primInfos.reserve(drawn.size());
        _leaves.reserve(drawn.size());
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            AddPrim(*drawn[i], static_cast<std::uint32_t>(i));
        }
        if (isCancelled && isCancelled()) {
            return nullptr;
        }
        _result->centre = ChooseSceneCentre(_scene, _leaves);
        _result->mediaBounds = FindMediaBounds(_scene, _leaves, _result->centre);
        AddHierarchy();
        AddLights();
        AddCatchers();
        VolumeMaterials ofVolumes = ReadVolumeMaterials(
            _scene, _options.purposes,
            [this](const std::string& path) {
                return IsDrawnPath(path, _options.drawnPaths, _options.hiddenPaths);
            },
            &_materials, _warnings);
        _result->instancePrimvars = _instancePrimvars.Take();
        _result->materials = std::move(_materials.materials);
        _result->primMaterials = std::move(_materials.primMaterials);
        _result->programs = std::move(_materials.programs);
        _result->hasClosures = HasClosures(_result->programs);
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
        _result->textureTable = std::move(_materials.textures);
        _result->images = &_cache.images;
        _result->textureLines = std::make_unique<TextureLines>(
            _cache.textures, MakeTextureImages(_result->textureTable, _cache.images));
        AddVolumes(std::move(ofVolumes));
        _result->hasPatterns = HasPatterns(_result->programs) || _result->volumes.havePatterns;
        AddMeshMedia();
        _result->textures = _cache.images.Uses();
        Count();
        _result->seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return std::move(_result);
    }

private:
    /// What the drawn geometry is made of.
    std::vector<GeometryStore::Drawn> InputsOf(const std::vector<const GeometryEntry*>& drawn) {
        std::map<std::string, DicingView> views;
        const bool isAdaptive = _options.subdivision == Subdivision::Adaptive;
        if (isAdaptive && _options.dicingCamera) {
            views = FindDicingViews(_scene, drawn, *_options.dicingCamera);
        }
        const bool isDiced = isAdaptive || (_options.subdivision == Subdivision::Complexity &&
                                            _options.refineLevel > 0);
        std::vector<GeometryStore::Drawn> inputs;
        inputs.reserve(drawn.size());
        GeometryStore::InputsReader known(_cache.geometry);
        GeometryInputs input; // its lists keep their memory from prim to prim
        input.chunkBytes = _options.chunkBytes;
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            const GeometryEntry* entry = drawn[i];
            input.geometry = entry->second.geometry;
            _materials.GetDisplacements(i, &input.displacements);
            ReadPrimvars(i, *input.geometry, &input.primvars);
            input.shutter = Shutter();
            if (Deforms(*input.geometry, _options.shutter)) {
                input.shutter = _options.shutter;
                _result->hasMotion = true;
            }
            input.dicing = {};
            if (isDiced && IsSubdivisionScheme(input.geometry->subdivisionScheme)) {
                DicingOptions& dicing = input.dicing.Edit().emplace();
                dicing.isAdaptive = isAdaptive;
                dicing.level = isAdaptive ? kAdaptiveLevel : _options.refineLevel;
                const auto view = views.find(entry->first);
                if (view != views.end()) {
                    dicing.view = view->second;
                }
            }
            inputs.emplace_back(&entry->first, known.Get(entry->first, input));
        }
        return inputs;
    }

    /// Of those that the geometry of a drawn prim has, sorted.
    void ReadPrimvars(std::size_t index, const GeometryDescription& geometry,
                      std::vector<std::string>* read) const {
        const std::vector<std::string>& shown = _options.shownPrimvars;
        read->clear();
        for (const Primvar& primvar : geometry.primvars) {
            bool isRead = std::find(shown.begin(), shown.end(), primvar.name) != shown.end();
            _materials.ForEachEntry(index, [&](const MaterialCommit::Entry& entry) {
                isRead = isRead || entry.material->primvars.count(primvar.name) > 0;
            });
            if (isRead) {
                read->push_back(primvar.name);
            }
        }
        std::sort(read->begin(), read->end());
        read->erase(std::unique(read->begin(), read->end()), read->end());
    }

    /// Objects, chunks and pages of all planned geometry: what is hidden keeps its pages.
    void AddObjects(std::size_t numDrawn) {
        _result->objects.emplace_back(); // the TLAS
        _result->pages = std::make_unique<GeometryPages>(&_cache.pages);
        _cache.geometry.ForEach([&](const std::string&, const PlannedGeometry& prepared) {
            const std::size_t drawn = _objectOfDrawn.size();
            if (drawn < numDrawn && &_cache.geometry.OfDrawn(drawn) == &prepared) {
                _objectOfDrawn.push_back(static_cast<std::uint32_t>(_result->objects.size()));
            }
            AddObject(prepared);
        });
    }

    void AddObject(const PlannedGeometry& prepared) {
        shared::HdsObject object{};
        object.kind = prepared.topNodes.empty() ? HDS_OBJECT_CHUNK : HDS_OBJECT_TOP_TREE;
        object.nodeBase = static_cast<std::uint32_t>(_result->topNodes.size());
        object.itemBase = _result->pages->NumChunks();
        object.numItems = static_cast<std::uint32_t>(prepared.chunks.size());
        _result->objects.push_back(object);
        _result->topNodes.insert(_result->topNodes.end(), prepared.topNodes.begin(),
                                 prepared.topNodes.end());
        for (const std::shared_ptr<ChunkPages>& chunk : prepared.chunks) {
            _result->pages->AddChunk(chunk);
        }
    }

    void AddPrim(const GeometryEntry& entry, std::uint32_t index) {
        const auto& [path, prim] = entry;
        const PlannedGeometry& prepared = _cache.geometry.OfDrawn(index);
        std::vector<const std::set<std::string>*> asked;
        if (_instancePrimvars.HasAny()) {
            asked = _materials.PrimvarsOf(index);
        }
        _primInfos.push_back(
            _materials.AddPrim(index, path, prim, prepared,
                               _instancePrimvars.Add(prim, asked, _options.shownPrimvars)));
        const PrimMaterialInfo& info = _primInfos.back();
        const bool hasFaces = prim.geometry->primitives == PrimitiveKind::Faces;
        const bool hasSplats = prim.geometry->primitives == PrimitiveKind::Splats;
        const std::uint32_t cullFlags = hasFaces ? CullFlags(prim, _options.cullStyle) : 0U;
        shared::HdsPrim record{};
        record.materialBase = info.materialBase;
        record.flags = (prepared.leftHanded ? HDS_PRIM_LEFT_HANDED : 0U) | cullFlags;
        record.primId = prim.primId >= 0 ? prim.primId : static_cast<std::int32_t>(index);
        record.numPrimvars = static_cast<std::uint32_t>(prepared.attributes.size());
        _result->prims.push_back(record);
        _result->primAttributes.push_back(&prepared.attributes);
        if (_options.keepsNames) {
            _result->primPaths.push_back(path);
            _materials.ForEachEntry(index, [&](const MaterialCommit::Entry& material) {
                _result->entryMaterials.push_back(*material.path);
            });
        }
        if (prepared.chunks.empty()) {
            return;
        }
        const bool mayPass = info.hasCutouts || info.isGlass || cullFlags != 0;
        _result->hasGlassShadows = _result->hasGlassShadows || info.isGlass;
        LeafObject leaf;
        leaf.object = _objectOfDrawn[index];
        leaf.prim = index;
        leaf.flags = (mayPass ? HDS_INSTANCE_CUTOUT : 0U) |
                     (info.isHair ? HDS_INSTANCE_FIBRE : 0U) |
                     (info.hasMedium ? HDS_INSTANCE_MEDIUM : 0U);
        leaf.origin = prepared.origin;
        leaf.bounds = prepared.bounds;
        leaf.worldInstance = info.isEmissive && !hasSplats;
        leaf.isLinkedByInstance = _links.IsLinkedByInstance(prim.placement);
        if (!leaf.isLinkedByInstance) {
            leaf.flags |= _links.FlagsOf(prim.categories);
        }
        if (leaf.worldInstance) {
            const shared::HdsObject& object = _result->objects[leaf.object];
            _result->pages->Keep(object.itemBase, object.numItems); // light paths end there
        }
        AddLeaves(entry, leaf);
        _result->hasCutouts = _result->hasCutouts || mayPass;
        CountPrim(*prim.geometry, prepared.numTriangles);
    }

    /// A leaf, or one for each way in which rays see instances of the prim.
    void AddLeaves(const GeometryEntry& entry, const LeafObject& leaf) {
        bool isUnreadable = false;
        std::vector<InstancesSeen> seen =
            RayVisibilityByInstance(_scene, entry.second, &isUnreadable);
        if (seen.empty()) {
            seen.push_back(
                {RayVisibilityFlags(entry.second.geometry->primvars, &isUnreadable), {}});
        }
        if (isUnreadable) {
            _warnings.Add(entry.first,
                          std::string(kKarmaVisibility) + " cannot be read; it is ignored");
        }
        for (InstancesSeen& part : seen) {
            const std::uint32_t flags = part.flags;
            _result->hasRayVisibility = _result->hasRayVisibility || flags != HDS_INSTANCE_SEEN;
            _result->hasCatchers = _result->hasCatchers || (flags & HDS_INSTANCE_CATCHER) != 0;
            _leaves.push_back({&entry, leaf, std::move(part.instances)});
            _leaves.back().object.flags |= flags;
        }
    }

    void CountPrim(const GeometryDescription& geometry, std::uint64_t numPrimitives) {
        SceneCounts& counts = _result->counts;
        switch (geometry.primitives) {
        case PrimitiveKind::Faces:
            counts.triangles += numPrimitives;
            ++counts.meshes;
            return;
        case PrimitiveKind::Curves:
            counts.curves += geometry.faceVertexCounts.size();
            break;
        case PrimitiveKind::Points:
            counts.points += numPrimitives;
            break;
        case PrimitiveKind::Splats:
            counts.splats += numPrimitives;
            _result->hasSplats = true;
            break;
        }
        _result->hasCurves = true;
    }

    void AddHierarchy() {
        Hierarchy hierarchy = BuildHierarchy(_scene, _leaves, _result->centre,
                                             static_cast<std::uint32_t>(_result->objects.size()),
                                             &_links, _options.shutter, _warnings,
                                             // Catchers need a second table of all instances.
                                             {_result->hasCatchers ? 0U : _options.instanceChunks,
                                              _options.chunkBytes, _cache.geometry.Pages()},
                                             std::move(_result->topNodes));
        if (hierarchy.instanceChunks) {
            AddInstanceChunks(hierarchy.instanceChunks);
        }
        _result->hasCutouts = _result->hasCutouts || _links.HaveUnshadowing();
        _links.WarnOfOverflow(_warnings);
        _result->objects[0] = hierarchy.groups[0];
        _result->objects.insert(_result->objects.end(), hierarchy.groups.begin() + 1,
                                hierarchy.groups.end());
        _result->topNodes = std::move(hierarchy.nodes);
        _result->instances = std::move(hierarchy.instances);
        _result->instancesByPath = std::move(hierarchy.instancesByPath);
        _result->hasGroups = hierarchy.depth > 0;
        _result->hasMotion = _result->hasMotion || !hierarchy.motionKeys.empty();
        _result->motionKeys = std::move(hierarchy.motionKeys);
        _result->counts.instances = hierarchy.numLeaves;
        _worldInstances = std::move(hierarchy.worldInstances);
    }

    /// Their chunks come before all others.
    void AddInstanceChunks(const std::shared_ptr<const InstanceChunks>& instances) {
        std::vector<std::shared_ptr<ChunkPages>> chunks;
        for (std::uint32_t chunk = 0; chunk < instances->NumChunks(); ++chunk) {
            chunks.push_back(std::make_shared<ChunkPages>(instances, chunk));
        }
        for (std::size_t i = 1; i < _result->objects.size(); ++i) { // of geometry, so far
            _result->objects[i].itemBase += instances->NumChunks();
        }
        _result->pages->AddInstanceChunks(chunks);
        _result->hasInstanceChunks = true;
    }

    void AddLights() {
        LightCommitInput input;
        input.scene = &_scene;
        input.centre = _result->centre;
        input.domeVisible = _options.domeVisible;
        input.lightsVisible = _options.lightsVisible;
        input.primInfos = &_primInfos;
        input.materials = &_materials;
        input.worldInstances = &_worldInstances;
        input.links = &_links;
        input.shutter = _options.shutter;
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
    void AddVolumes(VolumeMaterials materials) {
        std::vector<std::uint32_t>& programs = _result->programs;
        _result->volumes =
            CommitVolumes(_scene, std::move(materials), _options.shutter, _result->centre,
                          {static_cast<std::uint32_t>(_result->textureTable.size()),
                           static_cast<std::uint32_t>(programs.size())},
                          {_cache.grids.get(), &_cache.images}, _warnings);
        const std::vector<std::uint32_t>& patterns = _result->volumes.programs;
        programs.insert(programs.end(), patterns.begin(), patterns.end());
        _result->maxLookups = std::max(_result->maxLookups, _result->volumes.maxLookups);
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
        _result->meshMedia = std::move(_materials.meshMedia);
        if (!_result->meshMedia.empty()) { // kernels have what they need
            _result->hasMedia = true;
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
        for (const auto& grid : volumes.prepared) {
            counts.bricks += grid->description.numBricks;
        }
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
    MaterialCommit _materials;
    InstancePrimvarCollector _instancePrimvars;
    std::unique_ptr<CommittedScene> _result;
    LightLinks _links;
    std::vector<std::uint32_t> _objectOfDrawn; ///< in the order of paths
    std::vector<PrimMaterialInfo> _primInfos;  ///< by the index of the prim
    std::vector<DrawnLeaf> _leaves;            ///< in the order of paths
    std::vector<WorldInstance> _worldInstances;
};

/// \param first slot of the list.
std::uint32_t SlotIn(const std::vector<AttributeName>& list, std::uint32_t first,
                     const std::string& name) {
    const auto found = std::find_if(list.begin(), list.end(),
                                    [&name](const AttributeName& one) { return one.name == name; });
    return found == list.end() ? HDS_NONE
                               : first + static_cast<std::uint32_t>(found - list.begin());
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
    const SceneDescription& inWorkingSpace =
        cache->colors.Convert(scene, options.workingSpace, warnings);
    return Committer(inWorkingSpace, options, cache, warnings).Run(isCancelled);
}

} // namespace hds
