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
    for (auto item = _items.begin(); item != _items.end();) {
        const auto prim = scene.geometry.find(item->first);
        const bool isCurrent =
            prim != scene.geometry.end() && prim->second.geometry == item->second.inputs.geometry;
        item = isCurrent ? std::next(item) : _items.erase(item);
    }
    std::vector<const Drawn*> missing;
    for (const Drawn& one : drawn) {
        const auto item = _items.find(*one.first);
        if (item == _items.end() || !item->second.inputs.Suffice(one.second)) {
            missing.push_back(&one);
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
                    PlanGeometry(*missing[i]->first, missing[i]->second, _pageStore, warnings));
            }
        });
    for (std::size_t i = 0; i < missing.size(); ++i) {
        if (prepared[i]) {
            ++_numPrepared;
            _items[*missing[i]->first] = {missing[i]->second, prepared[i], nullptr};
        }
    }
    return !isStopped;
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
