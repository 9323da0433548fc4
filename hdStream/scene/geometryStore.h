// SPDX-License-Identifier: Apache-2.0
// Planned geometry, kept from commit to commit: it is planned again only when what it is made of
// has changed.
#pragma once

#include "hdStream/base/workCount.h"
#include "hdStream/scene/closedMeshes.h"
#include "hdStream/scene/geometryCommit.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Asked between pieces of work, on the thread that commits; true: give up.
using CancelCallback = std::function<bool()>;

/// By prim path. Externally synchronised.
class GeometryStore {
    struct Item {
        std::shared_ptr<const GeometryInputs> inputs;
        std::shared_ptr<const PlannedGeometry> prepared;
        std::shared_ptr<const ChunkGeometry> triangles; ///< once asked for
    };

    using Items = std::map<std::string, Item>;

public:
    using Entry = std::pair<const std::string, GeometryPrim>;

    /// The path of a drawn prim and what its geometry is to be made of.
    using Drawn = std::pair<const std::string*, std::shared_ptr<const GeometryInputs>>;

    /// Finds out which inputs are there already. The store must stay as it is meanwhile.
    class InputsReader {
    public:
        explicit InputsReader(const GeometryStore& store)
            : _next(store._items.begin()), _end(store._items.end()) {}

        /// Inputs that serve where `wanted` is asked for: those that the geometry of the path is
        /// prepared of, else a copy. \pre paths come in their order.
        std::shared_ptr<const GeometryInputs> Get(const std::string& path,
                                                  const GeometryInputs& wanted);

    private:
        Items::const_iterator _next;
        Items::const_iterator _end;
    };

    /// Prepares those of `drawn` that are not prepared so yet, on all cores, and forgets the prims
    /// that `scene` has no more. What is hidden stays prepared. \return false when it was
    /// cancelled; what is prepared by then is kept.
    /// \param closed looks at what it was asked for while the arrays are held; may be null.
    /// \pre `drawn` is in the order of paths.
    bool Prepare(const SceneDescription& scene, const std::vector<Drawn>& drawn, Warnings& warnings,
                 const CancelCallback& isCancelled, ClosedMeshes* closed = nullptr);

    /// Plans the geometry of prims, on all cores, and keeps none of it. \return one for each of
    /// `prims`; where it was cancelled some are null.
    std::vector<std::shared_ptr<const PlannedGeometry>> Plan(const std::vector<Drawn>& prims,
                                                             Warnings& warnings,
                                                             const CancelCallback& isCancelled,
                                                             ClosedMeshes* closed = nullptr) const;

    /// Puts geometry in the place of that of drawn[index] of the last Prepare.
    /// \param drawn of the same path; what `prepared` is made of.
    void Replace(std::size_t index, const Drawn& drawn,
                 std::shared_ptr<const PlannedGeometry> prepared);

    /// What the geometry of a path is made of. Precondition: it was among `drawn`.
    const std::shared_ptr<const GeometryInputs>& InputsOf(const std::string& path) const {
        return _items.at(path).inputs;
    }

    /// Of drawn[index] of the last Prepare, which was not cancelled.
    const PlannedGeometry& OfDrawn(std::size_t index) const { return *_drawn[index]; }

    /// Precondition: it was among `drawn`.
    const PlannedGeometry& Find(const std::string& path) const;

    /// All triangles of a mesh, kept once asked for. Few need them: lights.
    /// Precondition: it was among `drawn` and has chunks.
    const ChunkGeometry& Triangles(const std::string& path);

    /// The geometry of every prim, also of those that are not drawn now, in the order of paths.
    template <typename Function>
    void ForEach(Function function) const {
        for (const auto& [path, item] : _items) {
            function(path, *item.prepared);
        }
    }

    /// Finished pages go there and come from there; null: nowhere. Forgets all geometry.
    void SetPageStore(std::shared_ptr<PageStore> pageStore) {
        _drawn.clear();
        _items.clear();
        _bytes = 0;
        _pageStore = std::move(pageStore);
    }

    /// What SetPageStore was given.
    const std::shared_ptr<PageStore>& Pages() const { return _pageStore; }

    /// What chunks are cut from, as far as it can be made again.
    SourceKeeper& Sources() const { return *_sources; }

    /// About the bytes of what is known of the chunks, without pages and sources.
    std::uint64_t Bytes() const { return _bytes; }

    /// Of the last Plan, or of one that goes on. Any thread.
    WorkCount Planned() const { return {_numPlanned, _numToPlan}; }
    /// Until the next Plan there is none.
    void ForgetPlanned() { _numPlanned = _numToPlan = 0; }

    /// Prims whose geometry was planned since the store was made.
    std::uint64_t NumPrepared() const { return _numPrepared; }

private:
    /// One of `drawn` that is not prepared, and where it comes before in `_items`.
    struct Missing {
        std::size_t index;
        Items::iterator place;
    };

    void ForgetOthers(const SceneDescription& scene);
    void Put(Items::iterator place, const Drawn& drawn,
             std::shared_ptr<const PlannedGeometry> prepared);

    std::shared_ptr<PageStore> _pageStore;
    std::shared_ptr<SourceKeeper> _sources = std::make_shared<SourceKeeper>();
    Items _items;
    std::vector<const PlannedGeometry*> _drawn; ///< in the order of Prepare's `drawn`
    std::uint64_t _bytes = 0;                   ///< of `_items`
    std::uint64_t _numPrepared = 0;
    mutable std::atomic<std::uint64_t> _numPlanned{0}; ///< of the last Plan
    mutable std::atomic<std::uint64_t> _numToPlan{0};
};

} // namespace hds
