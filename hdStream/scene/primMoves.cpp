// SPDX-License-Identifier: Apache-2.0
// Of PrimCommit what mends the tables of a scene where prims only move, go or come back.
#include "hdStream/scene/drawnPrims.h"
#include "hdStream/scene/primCommit.h"

#include <algorithm>

namespace hds {

namespace {

/// Of more prims, and more than this part of all, a commit makes tables as fast, and a better TLAS.
constexpr std::size_t kMostMended = 8;
constexpr std::size_t kMostMendedPart = 8;

} // namespace

void PrimCommit::ForgetTables() {
    _places.reset();
    _shown.reset();
}

PrimCommit::Reshaped PrimCommit::Mend(const Edits& edits, CommittedScene* scene,
                                      PlaceChanges* changes, const CancelCallback& isCancelled) {
    const bool arePlaces = !edits.prims.empty() || !_cache.reshaped.empty();
    const std::size_t most = std::max(kMostMended, _leaves.size() / kMostMendedPart);
    if (arePlaces && (!PlaceTables::Serves(*scene) || edits.prims.size() > most)) {
        return Reshaped::Otherwise;
    }
    if (arePlaces && !_places) {
        _places = std::make_unique<PlaceTables>(_scene, _leaves, *scene, _options.shutter);
    }
    // Shapes first: who cancels their planning leaves all as it was.
    Reshaped result = GiveShapes(scene, changes, isCancelled);
    if (result == Reshaped::Cancelled) {
        return result;
    }
    if (result == Reshaped::Done) {
        const auto moved = FindMoved(edits.prims, scene);
        const bool isMended = moved && Recolour(scene, changes) &&
                              (!edits.areLights || MendLights(scene, changes)) &&
                              (!arePlaces || _places->Mend(*moved, scene, changes));
        result = isMended ? Reshaped::Done : Reshaped::Otherwise;
    }
    if (result != Reshaped::Done) {
        ForgetTables();
    }
    return result;
}

/// The leaves of prims that have moved, if all can be mended.
std::optional<std::vector<std::size_t>> PrimCommit::FindMoved(const std::set<std::string>& paths,
                                                              CommittedScene* scene) {
    std::vector<std::size_t> moved;
    std::vector<const GeometryEntry*> visible;
    for (const std::string& path : paths) {
        const GeometryEntry& entry = *_scene.geometry.find(path);
        const std::size_t index = IndexOf(path);
        if (index == _drawn.size()) {
            if (MayBeDrawn(entry, _options) && IsVisible(entry)) {
                return std::nullopt;
            }
            continue; // it was not drawn, and is not
        }
        const std::size_t leaf = _drawn[index].firstLeaf;
        if (!_drawn[index].hasChunks || !_places->IsMendable(leaf)) {
            return std::nullopt;
        }
        moved.push_back(leaf);
        if (IsVisible(entry)) {
            visible.push_back(&entry);
        }
        if (IsVisible(entry) != _places->IsShown(leaf) &&
            !HideOrShow(index, IsVisible(entry), scene)) {
            return std::nullopt;
        }
    }
    if (!_views.empty() && !AreViewsAsBefore(visible)) {
        return std::nullopt;
    }
    return moved;
}

/// New shapes, first to the prims.
PrimCommit::Reshaped PrimCommit::GiveShapes(CommittedScene* scene, PlaceChanges* changes,
                                            const CancelCallback& isCancelled) {
    if (_cache.reshaped.empty()) {
        return Reshaped::Done;
    }
    const auto indices = FindReshaped(_cache.reshaped);
    if (!indices) {
        return Reshaped::Otherwise;
    }
    std::vector<std::uint64_t> numBefore;
    for (const std::size_t index : *indices) {
        numBefore.push_back(_drawn[index].numPrimitives);
    }
    const Reshaped result = Reshape(_cache.reshaped, isCancelled);
    if (result != Reshaped::Done) {
        return result;
    }
    _cache.reshaped.clear();
    for (std::size_t i = 0; i < indices->size(); ++i) {
        const std::size_t index = (*indices)[i];
        if (_places->IsShown(_drawn[index].firstLeaf)) { // else it comes back as it is now
            Count(index, numBefore[i], false, scene);
            Count(index, _drawn[index].numPrimitives, true, scene);
        }
        scene->primAttributes[index] = prims.primAttributes[index];
        const std::uint32_t base = prims.objects[_objectOfDrawn[index]].nodeBase;
        const std::size_t numNodes = _cache.geometry.OfDrawn(index).topNodes.size();
        for (std::uint32_t node = base; node < base + numNodes; ++node) {
            scene->topNodes[node] = prims.topNodes[node];
            changes->nodes.push_back(node);
        }
    }
    scene->pages = prims.pages;
    changes->arePages = true;
    return result;
}

/// Adds a prim to what the scene counts, or takes it away.
void PrimCommit::Count(std::size_t index, std::uint64_t numPrimitives, bool isAdded,
                       CommittedScene* scene) const {
    SceneCounts own;
    CountPrim(*_drawn[index].entry->second.geometry, numPrimitives, &own);
    for (const auto count : {&SceneCounts::meshes, &SceneCounts::triangles, &SceneCounts::curves,
                             &SceneCounts::points, &SceneCounts::splats}) {
        scene->counts.*count += isAdded ? own.*count : std::uint64_t{0} - own.*count;
    }
}

std::array<bool, PrimCommit::Shown::kNumKinds> PrimCommit::KindsOf(std::size_t index) const {
    const DrawnPrim& drawn = _drawn[index];
    const PrimitiveKind kind = drawn.entry->second.geometry->primitives;
    const bool isSeenByAll = !drawn.hasChunks || (_leaves[drawn.firstLeaf].object.flags &
                                                  kSeenFlags) == HDS_INSTANCE_SEEN;
    return {drawn.deforms,
            drawn.hasChunks && drawn.isGlass,
            drawn.hasChunks && drawn.mayPass,
            drawn.hasChunks && kind != PrimitiveKind::Faces,
            drawn.hasChunks && kind == PrimitiveKind::Splats,
            !isSeenByAll};
}

/// As tables are before an edit: what they know nothing of has not changed.
void PrimCommit::CountShown() {
    _shown.emplace();
    // The light table knows meshes that glow by their path indices.
    _shown->mayHide = !ArePrimsKnownByNumber() &&
                      std::none_of(_leaves.begin(), _leaves.end(), [](const DrawnLeaf& leaf) {
                          return leaf.object.worldInstance && IsVisible(*leaf.entry);
                      });
    for (std::size_t i = 0; i < _drawn.size(); ++i) {
        const std::size_t leaf = _drawn[i].firstLeaf;
        const bool isShown = _drawn[i].hasChunks && _places->IsMendable(leaf)
                                 ? _places->IsShown(leaf)
                                 : IsVisible(*_drawn[i].entry);
        if (!isShown) {
            continue;
        }
        const auto kinds = KindsOf(i);
        for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
            _shown->kinds[kind] += kinds[kind] ? 1 : 0;
        }
        materials.ForEachEntry(
            i, [&](const MaterialCommit::Entry& entry) { ++_shown->users[entry.material]; });
    }
}

/// \return false where the last one of a kind, or of a material, goes: what is said of the whole
/// scene is another thing then.
bool PrimCommit::HideOrShow(std::size_t index, bool isVisible, CommittedScene* scene) {
    if (!_shown) {
        CountShown();
    }
    if (!_shown->mayHide) {
        return false;
    }
    bool isAnyLast = false;
    const std::uint32_t step = isVisible ? 1U : ~0U;
    const auto kinds = KindsOf(index);
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
        _shown->kinds[kind] += kinds[kind] ? step : 0U;
        isAnyLast = isAnyLast || (kinds[kind] && _shown->kinds[kind] == 0);
    }
    materials.ForEachEntry(index, [&](const MaterialCommit::Entry& entry) {
        std::uint32_t& users = _shown->users[entry.material];
        users += step;
        isAnyLast = isAnyLast || users == 0;
    });
    Count(index, _drawn[index].numPrimitives, isVisible, scene);
    scene->counts.instances += isVisible ? std::uint64_t{1} : ~std::uint64_t{0};
    return !isAnyLast;
}

} // namespace hds
