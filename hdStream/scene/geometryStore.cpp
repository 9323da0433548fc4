// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/geometryStore.h"

#include "hdStream/base/callerQuestion.h"
#include "hdStream/scene/hostRecords.h"

#include <tbb/parallel_for.h>

#include <utility>

namespace hds {

namespace {

/// One worker may take one prim at a time: prims differ in size by orders of magnitude.
constexpr std::size_t kGrain = 1;

} // namespace

std::shared_ptr<const GeometryInputs>
GeometryStore::InputsReader::Get(const std::string& path, const GeometryInputs& wanted) {
    int order = -1;
    while (_next != _end && (order = _next->first.compare(path)) < 0) {
        ++_next;
    }
    const bool isKnown = _next != _end && order == 0 && _next->second.inputs->Suffice(wanted);
    return isKnown ? _next->second.inputs : std::make_shared<const GeometryInputs>(wanted);
}

bool GeometryStore::Prepare(const SceneDescription& scene, const std::vector<Drawn>& drawn,
                            Warnings& warnings, const CancelCallback& isCancelled,
                            ClosedMeshes* closed) {
    ForgetOthers(scene);
    // All of this is in the order of paths: nothing is looked up by name.
    std::vector<Missing> missing;
    std::vector<Drawn> toPlan;
    _drawn.assign(drawn.size(), nullptr);
    auto item = _items.begin();
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        int order = -1;
        while (item != _items.end() && (order = item->first.compare(*drawn[i].first)) < 0) {
            ++item;
        }
        const bool isKnown = item != _items.end() && order == 0 &&
                             (item->second.inputs == drawn[i].second ||
                              item->second.inputs->Suffice(*drawn[i].second));
        if (isKnown) {
            _drawn[i] = item->second.prepared.get();
        } else {
            missing.push_back({i, item});
            toPlan.push_back(drawn[i]);
        }
    }
    const auto prepared = Plan(toPlan, warnings, isCancelled, closed);
    bool isWhole = true;
    for (std::size_t i = 0; i < missing.size(); ++i) {
        if (prepared[i]) {
            ++_numPrepared;
            _drawn[missing[i].index] = prepared[i].get();
            Put(missing[i].place, toPlan[i], prepared[i]);
        } else {
            isWhole = false;
        }
    }
    return isWhole;
}

std::vector<std::shared_ptr<const PlannedGeometry>>
GeometryStore::Plan(const std::vector<Drawn>& prims, Warnings& warnings,
                    const CancelCallback& isCancelled, ClosedMeshes* closed) const {
    std::vector<std::shared_ptr<const PlannedGeometry>> planned(prims.size());
    CallerQuestion isStopped(isCancelled);
    _numPlanned = 0;
    _numToPlan = prims.size();
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, prims.size(), kGrain),
        [&](const tbb::blocked_range<std::size_t>& range) {
            isStopped.Ask();
            for (std::size_t i = range.begin(); i < range.end() && !isStopped.IsYes(); ++i) {
                // Arrays that are read for it are not read again to plan.
                const auto held = closed != nullptr ? closed->Look(prims[i].second->geometry)
                                                    : std::shared_ptr<const void>();
                planned[i] = std::make_shared<const PlannedGeometry>(
                    PlanGeometry(*prims[i].first, prims[i].second, _pageStore, warnings, _sources));
                ++_numPlanned;
            }
        });
    return planned;
}

void GeometryStore::Replace(std::size_t index, const Drawn& drawn,
                            std::shared_ptr<const PlannedGeometry> prepared) {
    ++_numPrepared;
    _drawn[index] = prepared.get();
    Put(_items.find(*drawn.first), drawn, std::move(prepared));
}

/// \param place where the item is, or would come before.
void GeometryStore::Put(Items::iterator place, const Drawn& drawn,
                        std::shared_ptr<const PlannedGeometry> prepared) {
    const auto item = _items.try_emplace(place, *drawn.first);
    if (item->second.prepared) {
        _bytes -= PlannedBytes(item->first, *item->second.prepared);
    }
    item->second = {drawn.second, std::move(prepared), nullptr};
    _bytes += PlannedBytes(item->first, *item->second.prepared);
}

/// Forgets what the scene has no more, or has anew.
void GeometryStore::ForgetOthers(const SceneDescription& scene) {
    auto prim = scene.geometry.begin();
    for (auto item = _items.begin(); item != _items.end();) {
        int order = -1;
        while (prim != scene.geometry.end() && (order = prim->first.compare(item->first)) < 0) {
            ++prim;
        }
        const bool isCurrent = prim != scene.geometry.end() && order == 0 &&
                               prim->second.geometry == item->second.inputs->geometry;
        if (isCurrent) {
            ++item;
        } else {
            _bytes -= PlannedBytes(item->first, *item->second.prepared);
            item = _items.erase(item);
        }
    }
}

const PlannedGeometry& GeometryStore::Find(const std::string& path) const {
    return *_items.at(path).prepared;
}

const ChunkGeometry& GeometryStore::Triangles(const std::string& path) {
    Item& item = _items.at(path);
    if (!item.triangles) {
        item.triangles = std::make_shared<const ChunkGeometry>(GatherAll(*item.prepared));
    }
    return *item.triangles;
}

} // namespace hds
