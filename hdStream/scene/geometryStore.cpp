// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/geometryStore.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <thread>

namespace hds {

namespace {

/// One worker may take one prim at a time: prims differ in size by orders of magnitude.
constexpr std::size_t kGrain = 1;

} // namespace

bool GeometryStore::Prepare(const SceneDescription& scene, const std::vector<Drawn>& drawn,
                            Warnings& warnings, const CancelCallback& isCancelled) {
    ForgetOthers(scene);
    // All of this is in the order of paths: nothing is looked up by name.
    std::vector<Missing> missing;
    _drawn.assign(drawn.size(), nullptr);
    auto item = _items.begin();
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        while (item != _items.end() && item->first < *drawn[i].first) {
            ++item;
        }
        const bool isKnown = item != _items.end() && item->first == *drawn[i].first;
        if (isKnown && item->second.inputs->Suffice(*drawn[i].second)) {
            _drawn[i] = item->second.prepared.get();
        } else {
            missing.push_back({i, item});
        }
    }
    std::vector<std::shared_ptr<const PlannedGeometry>> prepared(missing.size());
    std::atomic<bool> isStopped{false};
    const std::thread::id caller = std::this_thread::get_id();
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, missing.size(), kGrain),
        [&](const tbb::blocked_range<std::size_t>& range) {
            if (std::this_thread::get_id() == caller && isCancelled && isCancelled()) {
                isStopped = true;
            }
            for (std::size_t i = range.begin(); i < range.end() && !isStopped; ++i) {
                prepared[i] = std::make_shared<const PlannedGeometry>(
                    PlanGeometry(*drawn[missing[i].index].first, drawn[missing[i].index].second,
                                 _pageStore, warnings, _sources));
            }
        });
    for (std::size_t i = 0; i < missing.size(); ++i) {
        if (prepared[i]) {
            ++_numPrepared;
            const Drawn& one = drawn[missing[i].index];
            _drawn[missing[i].index] = prepared[i].get();
            _items.try_emplace(missing[i].place, *one.first)->second = {one.second, prepared[i],
                                                                        nullptr};
        }
    }
    return !isStopped;
}

/// Forgets what the scene has no more, or has anew.
void GeometryStore::ForgetOthers(const SceneDescription& scene) {
    auto prim = scene.geometry.begin();
    for (auto item = _items.begin(); item != _items.end();) {
        while (prim != scene.geometry.end() && prim->first < item->first) {
            ++prim;
        }
        const bool isCurrent = prim != scene.geometry.end() && prim->first == item->first &&
                               prim->second.geometry == item->second.inputs->geometry;
        item = isCurrent ? std::next(item) : _items.erase(item);
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
