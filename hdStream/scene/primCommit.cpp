// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/primCommit.h"

#include "hdStream/geometry/awayArrays.h"
#include "hdStream/geometry/subdivSource.h"
#include "hdStream/scene/drawnPrims.h"
#include "hdStream/scene/geometryMotion.h"
#include "hdStream/scene/lightCommit.h"
#include "hdStream/scene/meshDisplacement.h"
#include "hdStream/scene/rayVisibility.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace hds {

namespace {

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

/// Whether how far a material moves a surface varies.
bool Varies(const DisplacementInput& displacement) {
    return displacement.network || displacement.lookup;
}

/// Whether a prim's own primvars say that shading adds nothing to its displacement. Of several the
/// first counts.
bool RefusesAutobump(const std::vector<Primvar>& primvars) {
    for (const char* const name : {"hdstream:autobump", "arnold:autobump"}) {
        for (const Primvar& primvar : primvars) {
            if (primvar.name == name && primvar.values.size() == 1) {
                return primvar.values[0] == 0.0F;
            }
        }
    }
    return false;
}

/// Whether geometry can be put in the place of other geometry without a change of other tables.
bool IsAlike(const PlannedGeometry& a, const PlannedGeometry& b) {
    return a.chunks.size() == b.chunks.size() && a.topNodes.size() == b.topNodes.size() &&
           a.leftHanded == b.leftHanded && a.origin == b.origin &&
           std::equal(a.attributes.begin(), a.attributes.end(), b.attributes.begin(),
                      b.attributes.end(), [](const AttributeName& one, const AttributeName& other) {
                          return one.name == other.name && one.numComponents == other.numComponents;
                      });
}

} // namespace

PrimCommit::PrimCommit(const SceneDescription& scene, CommitOptions options, CommitCache* cache,
                       Warnings& warnings)
    : materials(scene, &cache->materials, cache->images, options.glassShadows, warnings),
      links(scene), _scene(scene), _options(std::move(options)), _cache(*cache),
      _warnings(warnings), _instancePrimvars(scene, warnings) {}

bool PrimCommit::Run(const CancelCallback& isCancelled) {
    const std::vector<const GeometryEntry*> drawn = FindDrawn();
    _cache.images.BeginCommit();
    materials.textures = LoadLightTextures(_scene, &_cache);
    materials.Compile(drawn);
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        const GeometryPrim& prim = drawn[i]->second;
        if (prim.geometry->primitives == PrimitiveKind::Faces && materials.MayBeFilled(i, prim)) {
            _cache.closedMeshes.Ask(prim.geometry);
        }
    }
    if (!_cache.geometry.Prepare(_scene, InputsOf(drawn), _warnings, isCancelled,
                                 &_cache.closedMeshes)) {
        return false;
    }
    _cache.closedMeshes.LookAtOthers(); // of what is prepared already
    if (isCancelled && isCancelled()) {
        return false;
    }
    AddObjects(drawn.size());
    primInfos.reserve(drawn.size());
    _leaves.reserve(drawn.size());
    for (std::uint32_t i = 0; i < drawn.size(); ++i) {
        AddPrim(i);
    }
    prims.instancePrimvars = _instancePrimvars.Take();
    return true;
}

std::vector<const PrimCommit::GeometryEntry*> PrimCommit::FindDrawn() {
    std::vector<const GeometryEntry*> drawn;
    for (const GeometryEntry& entry : _scene.geometry) {
        const bool mayBeDrawn = MayBeDrawn(entry, _options);
        if (mayBeDrawn && IsVisible(entry)) {
            drawn.push_back(&entry);
        } else if (entry.second.geometry) {
            DropArrays(*entry.second.geometry);
        }
        if (mayBeDrawn && !IsVisible(entry)) {
            _hidden.push_back(&entry);
        }
    }
    _drawn.resize(drawn.size());
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        _drawn[i].entry = drawn[i];
    }
    return drawn;
}

/// What the drawn geometry is made of.
std::vector<GeometryStore::Drawn>
PrimCommit::InputsOf(const std::vector<const GeometryEntry*>& drawn) {
    GeometryInputs input; // its lists keep their memory from prim to prim
    const bool isAdaptive = _options.subdivision == Subdivision::Adaptive;
    std::vector<DisplacementInput> held; // images are dropped where nobody holds them
    if (isAdaptive && _options.dicingCamera) {
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            if (!drawn[i]->second.placement.instancerPath.empty()) {
                materials.GetDisplacements(i, &input.displacements);
                held.insert(held.end(), input.displacements.begin(), input.displacements.end());
            }
        }
        _views = FindViews(drawn);
    }
    const bool isDiced =
        isAdaptive || (_options.subdivision == Subdivision::Complexity && _options.refineLevel > 0);
    std::vector<GeometryStore::Drawn> inputs;
    inputs.reserve(drawn.size());
    GeometryStore::InputsReader known(_cache.geometry);
    input.chunkBytes = _options.chunkBytes;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        const GeometryEntry* entry = drawn[i];
        input.geometry = entry->second.geometry;
        materials.GetDisplacements(i, &input.displacements);
        input.autobump =
            _options.autobump &&
            std::any_of(input.displacements.begin(), input.displacements.end(), Varies) &&
            !RefusesAutobump(input.geometry->primvars);
        ReadPrimvars(i, *input.geometry, &input.primvars);
        input.shutter = Shutter();
        if (Deforms(*input.geometry, _options.shutter)) {
            input.shutter = _options.shutter;
            _drawn[i].deforms = true;
        }
        input.dicing = {};
        if (isDiced && IsSubdivisionScheme(input.geometry->subdivisionScheme)) {
            DicingOptions& dicing = input.dicing.Edit().emplace();
            dicing.isAdaptive = isAdaptive;
            dicing.level = isAdaptive ? kAdaptiveLevel : _options.refineLevel;
            const auto view = _views.find(entry->first);
            if (view != _views.end()) {
                dicing.view = view->second;
            }
        }
        inputs.emplace_back(&entry->first, known.Get(entry->first, input));
    }
    return inputs;
}

/// Of those that the geometry of a drawn prim has, sorted.
void PrimCommit::ReadPrimvars(std::size_t index, const GeometryDescription& geometry,
                              std::vector<std::string>* read) const {
    const std::vector<std::string>& shown = _options.shownPrimvars;
    read->clear();
    for (const Primvar& primvar : geometry.primvars) {
        bool isRead = std::find(shown.begin(), shown.end(), primvar.name) != shown.end();
        materials.ForEachEntry(index, [&](const MaterialCommit::Entry& entry) {
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
void PrimCommit::AddObjects(std::size_t numDrawn) {
    prims.objects.emplace_back(); // the TLAS
    prims.pages = std::make_shared<GeometryPages>(&_cache.pages);
    _cache.geometry.ForEach([&](const std::string&, const PlannedGeometry& prepared) {
        const std::size_t drawn = _objectOfDrawn.size();
        if (drawn < numDrawn && &_cache.geometry.OfDrawn(drawn) == &prepared) {
            _objectOfDrawn.push_back(static_cast<std::uint32_t>(prims.objects.size()));
        }
        AddObject(prepared);
    });
}

void PrimCommit::AddObject(const PlannedGeometry& prepared) {
    shared::HdsObject object{};
    object.kind = prepared.topNodes.empty() ? HDS_OBJECT_CHUNK : HDS_OBJECT_TOP_TREE;
    object.nodeBase = static_cast<std::uint32_t>(prims.topNodes.size());
    object.itemBase = prims.pages->NumChunks();
    object.numItems = static_cast<std::uint32_t>(prepared.chunks.size());
    prims.objects.push_back(object);
    prims.topNodes.insert(prims.topNodes.end(), prepared.topNodes.begin(), prepared.topNodes.end());
    for (const std::shared_ptr<ChunkPages>& chunk : prepared.chunks) {
        prims.pages->AddChunk(chunk);
    }
}

void PrimCommit::AddPrim(std::uint32_t index) {
    const GeometryEntry& entry = *_drawn[index].entry;
    const auto& [path, prim] = entry;
    const PlannedGeometry& prepared = _cache.geometry.OfDrawn(index);
    std::vector<const std::set<std::string>*> asked;
    if (_instancePrimvars.HasAny()) {
        asked = materials.PrimvarsOf(index);
    }
    primInfos.push_back(materials.AddPrim(
        index, path, prim, prepared, _instancePrimvars.Add(prim, asked, _options.shownPrimvars)));
    PrimMaterialInfo& info = primInfos.back();
    const bool hasFaces = prim.geometry->primitives == PrimitiveKind::Faces;
    if (hasFaces && info.isFilled && !_cache.closedMeshes.IsClosed(prim.geometry)) {
        _warnings.Add(path, "its mesh is not closed: the medium in it has no end where rays leave "
                            "through a hole");
    }
    const bool hasSplats = prim.geometry->primitives == PrimitiveKind::Splats;
    const std::uint32_t cullFlags = hasFaces ? CullFlags(prim, _options.cullStyle) : 0U;
    shared::HdsPrim record{};
    record.materialBase = info.materialBase;
    record.flags = (prepared.leftHanded ? HDS_PRIM_LEFT_HANDED : 0U) | cullFlags;
    record.primId = prim.primId >= 0 ? prim.primId : static_cast<std::int32_t>(index);
    record.numPrimvars = static_cast<std::uint32_t>(prepared.attributes.size());
    prims.prims.push_back(record);
    prims.primAttributes.push_back(&prepared.attributes);
    if (_options.keepsNames) {
        prims.primPaths.push_back(path);
        materials.ForEachEntry(index, [&](const MaterialCommit::Entry& material) {
            prims.entryMaterials.push_back(*material.path);
        });
    }
    if (prepared.chunks.empty()) {
        return;
    }
    DrawnPrim& drawn = _drawn[index];
    drawn.hasChunks = true;
    drawn.firstLeaf = _leaves.size();
    drawn.numPrimitives = prepared.numTriangles;
    drawn.isGlass = info.isGlass;
    drawn.mayPass = info.hasCutouts || info.isGlass || cullFlags != 0;
    LeafObject leaf;
    leaf.object = _objectOfDrawn[index];
    leaf.prim = index;
    leaf.flags = (drawn.mayPass ? HDS_INSTANCE_CUTOUT : 0U) |
                 (info.isHair ? HDS_INSTANCE_FIBRE : 0U) |
                 (info.hasMedium ? HDS_INSTANCE_MEDIUM : 0U);
    leaf.numPrimitives = static_cast<float>(prepared.numTriangles);
    leaf.numFlat = prim.geometry->primitives == PrimitiveKind::Faces ? leaf.numPrimitives : 0.0F;
    leaf.origin = prepared.origin;
    leaf.bounds = prepared.bounds;
    leaf.worldInstance = info.isEmissive && !hasSplats;
    leaf.isLinkedByInstance = links.IsLinkedByInstance(prim.placement);
    if (!leaf.isLinkedByInstance) {
        leaf.flags |= links.FlagsOf(prim.categories);
    }
    if (leaf.worldInstance) {
        const shared::HdsObject& object = prims.objects[leaf.object];
        prims.pages->Keep(object.itemBase, object.numItems); // light paths end there
    } else {
        std::vector<MaterialEntryInfo>().swap(info.entries); // lights ask for no others
    }
    AddLeaves(entry, leaf);
}

/// A leaf, or one for each way in which rays see instances of the prim.
void PrimCommit::AddLeaves(const GeometryEntry& entry, const LeafObject& leaf) {
    bool isUnreadable = false;
    std::vector<InstancesSeen> seen = RayVisibilityByInstance(_scene, entry.second, &isUnreadable);
    if (seen.empty()) {
        seen.push_back({RayVisibilityFlags(entry.second.geometry->primvars, &isUnreadable), {}});
    }
    if (isUnreadable) {
        _warnings.Add(entry.first,
                      std::string(kKarmaVisibility) + " cannot be read; it is ignored");
    }
    for (InstancesSeen& part : seen) {
        _leaves.push_back({&entry, leaf, std::move(part.instances)});
        _leaves.back().object.flags |= part.flags;
    }
}

bool PrimCommit::OutlivesPlaces() const {
    // Link sets are numbered as they are met, those of instances with the hierarchy.
    return !links.AreUsed() && !links.HaveUnshadowing();
}

bool PrimCommit::IsStillTrue() const {
    return !_isSpoilt &&
           std::none_of(_hidden.begin(), _hidden.end(),
                        [](const GeometryEntry* entry) { return IsVisible(*entry); }) &&
           AreTablesOfTheVisible() && AreViewsAsBefore();
}

/// Whether tables know prims by numbers, or by their order.
bool PrimCommit::ArePrimsKnownByNumber() const {
    return _options.keepsNames || !materials.meshMedia.empty() ||
           !prims.instancePrimvars.slots.empty() ||
           std::any_of(_drawn.begin(), _drawn.end(),
                       [](const DrawnPrim& drawn) { return drawn.entry->second.primId < 0; });
}

/// Whether tables of the prims that were visible say nothing that those of the ones that still are
/// would not say, but for records that nobody asks for.
bool PrimCommit::AreTablesOfTheVisible() const {
    const auto isHidden = [](const DrawnPrim& drawn) { return !IsVisible(*drawn.entry); };
    if (std::none_of(_drawn.begin(), _drawn.end(), isHidden)) {
        return true;
    }
    if (ArePrimsKnownByNumber()) {
        return false;
    }
    std::set<const CachedMaterial*> all;
    std::set<const CachedMaterial*> used; // what nobody uses any more has kernels of its own
    for (std::size_t i = 0; i < _drawn.size(); ++i) {
        materials.ForEachEntry(i, [&](const MaterialCommit::Entry& entry) {
            all.insert(entry.material);
            if (!isHidden(_drawn[i])) {
                used.insert(entry.material);
            }
        });
    }
    return all.size() == used.size();
}

/// Whether subdivided meshes that are visible are as fine as they were; what is hidden beside them
/// counts for how fine that is.
bool PrimCommit::AreViewsAsBefore() const {
    if (_views.empty()) {
        return true;
    }
    std::vector<const GeometryEntry*> visible;
    for (const DrawnPrim& drawn : _drawn) {
        if (IsVisible(*drawn.entry)) {
            visible.push_back(drawn.entry);
        }
    }
    return AreViewsAsBefore(visible);
}

/// \pre there is a camera that dices.
std::map<std::string, DicingView>
PrimCommit::FindViews(const std::vector<const GeometryEntry*>& wanted) const {
    const auto reachOf = [this](const GeometryEntry& entry) {
        const std::size_t index = IndexOf(entry.first);
        std::vector<DisplacementInput> inputs;
        if (index < _drawn.size()) {
            materials.GetDisplacements(index, &inputs);
        }
        return DisplacementReachOf(*entry.second.geometry, inputs);
    };
    return FindDicingViews(_scene, wanted, *_options.dicingCamera, _options.shutter, reachOf);
}

bool PrimCommit::AreViewsAsBefore(const std::vector<const GeometryEntry*>& visible) const {
    const auto views = FindViews(visible);
    return std::all_of(views.begin(), views.end(), [this](const auto& view) {
        const auto before = _views.find(view.first);
        return before != _views.end() && before->second == view.second;
    });
}

/// In `_drawn`; its size: the prim was not drawn.
std::size_t PrimCommit::IndexOf(const std::string& path) const {
    const auto drawn = std::lower_bound(
        _drawn.begin(), _drawn.end(), path,
        [](const DrawnPrim& one, const std::string& wanted) { return one.entry->first < wanted; });
    const bool isThere = drawn != _drawn.end() && drawn->entry->first == path;
    return isThere ? static_cast<std::size_t>(drawn - _drawn.begin()) : _drawn.size();
}

/// Where the prims at `paths` are in `_drawn`; nothing: other tables depend on the shape of some.
std::optional<std::vector<std::size_t>>
PrimCommit::FindReshaped(const std::set<std::string>& paths) const {
    std::vector<std::size_t> indices;
    for (const std::string& path : paths) {
        const std::size_t index = IndexOf(path);
        if (index == _drawn.size()) {
            return std::nullopt;
        }
        const DrawnPrim& drawn = _drawn[index];
        if (!IsVisible(*drawn.entry) || !drawn.hasChunks || drawn.deforms ||
            drawn.entry->second.geometry->primitives == PrimitiveKind::Splats) {
            return std::nullopt;
        }
        indices.push_back(index);
    }
    return indices;
}

PrimCommit::Reshaped PrimCommit::Reshape(const std::set<std::string>& paths,
                                         const CancelCallback& isCancelled) {
    const auto indices = FindReshaped(paths);
    if (!indices || !materials.meshMedia.empty()) { // which are looked at for holes
        return Reshaped::Otherwise;
    }
    std::vector<GeometryStore::Drawn> inputs;
    for (const std::size_t index : *indices) {
        const GeometryEntry& entry = *_drawn[index].entry;
        auto input = std::make_shared<GeometryInputs>(*_cache.geometry.InputsOf(entry.first));
        input->geometry = entry.second.geometry;
        inputs.emplace_back(&entry.first, std::move(input));
    }
    const auto planned = _cache.geometry.Plan(inputs, _warnings, isCancelled);
    if (std::find(planned.begin(), planned.end(), nullptr) != planned.end()) {
        return Reshaped::Cancelled;
    }
    bool areAlike = true;
    for (std::size_t i = 0; i < planned.size(); ++i) {
        const std::size_t index = (*indices)[i];
        areAlike = areAlike && IsAlike(_cache.geometry.OfDrawn(index), *planned[i]);
        _cache.geometry.Replace(index, inputs[i], planned[i]); // nothing is planned twice
    }
    if (!areAlike) {
        _isSpoilt = true; // tables are of shapes that the store has no more
        return Reshaped::Otherwise;
    }
    auto pages = std::make_shared<GeometryPages>(*prims.pages); // other scenes keep theirs
    for (const std::size_t index : *indices) {
        TakeShape(index, pages.get());
    }
    prims.pages = std::move(pages);
    return Reshaped::Done;
}

/// What the geometry of a prim says of its shape goes where that of before was.
void PrimCommit::TakeShape(std::size_t index, GeometryPages* pages) {
    const PlannedGeometry& prepared = _cache.geometry.OfDrawn(index);
    const shared::HdsObject& object = prims.objects[_objectOfDrawn[index]];
    std::copy(prepared.topNodes.begin(), prepared.topNodes.end(),
              prims.topNodes.begin() + object.nodeBase);
    for (std::uint32_t i = 0; i < object.numItems; ++i) {
        pages->ReplaceChunk(object.itemBase + i, prepared.chunks[i]);
    }
    prims.primAttributes[index] = &prepared.attributes;
    DrawnPrim& drawn = _drawn[index];
    drawn.numPrimitives = prepared.numTriangles;
    auto leaf = _leaves.begin() + static_cast<std::ptrdiff_t>(drawn.firstLeaf);
    for (; leaf != _leaves.end() && leaf->entry == drawn.entry; ++leaf) {
        leaf->object.bounds = prepared.bounds;
    }
}

std::vector<DrawnLeaf> PrimCommit::VisibleLeaves() const {
    std::vector<DrawnLeaf> leaves;
    leaves.reserve(_leaves.size());
    std::copy_if(_leaves.begin(), _leaves.end(), std::back_inserter(leaves),
                 [](const DrawnLeaf& leaf) { return IsVisible(*leaf.entry); });
    return leaves;
}

void PrimCommit::Describe(CommittedScene* scene) const {
    for (const DrawnPrim& drawn : _drawn) {
        if (!IsVisible(*drawn.entry)) {
            continue;
        }
        scene->hasMotion = scene->hasMotion || drawn.deforms;
        if (drawn.hasChunks) {
            scene->hasGlassShadows = scene->hasGlassShadows || drawn.isGlass;
            scene->hasCutouts = scene->hasCutouts || drawn.mayPass;
            const GeometryDescription& geometry = *drawn.entry->second.geometry;
            scene->hasCurves = scene->hasCurves || geometry.primitives != PrimitiveKind::Faces;
            scene->hasSplats = scene->hasSplats || geometry.primitives == PrimitiveKind::Splats;
            CountPrim(geometry, drawn.numPrimitives, &scene->counts);
        }
    }
    for (const DrawnLeaf& leaf : _leaves) {
        if (IsVisible(*leaf.entry)) {
            const std::uint32_t seen = leaf.object.flags & kSeenFlags;
            scene->hasRayVisibility = scene->hasRayVisibility || seen != HDS_INSTANCE_SEEN;
            scene->hasCatchers = scene->hasCatchers || (seen & HDS_INSTANCE_CATCHER) != 0;
        }
    }
}

} // namespace hds
