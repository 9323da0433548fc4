// SPDX-License-Identifier: Apache-2.0
// Edits of a committed scene's tables where prims only move, go or come back: what a commit would
// make anew for all prims is mended for these. Hits, and what rays are told of them, are those of a
// commit; the shape of the TLAS and the places of records may differ. Explained in
// docs/session.md, "What an edit costs".
#pragma once

#include "hdStream/accel/bvhRefit.h"
#include "hdStream/scene/commit.h"
#include "hdStream/scene/hierarchy.h"
#include "hdStream/scene/sceneCentre.h"

#include <cstdint>
#include <vector>

namespace hds {

/// What is to be uploaded again of a scene's tables.
struct PlaceChanges {
    std::vector<std::uint32_t> instances; ///< records
    std::vector<std::uint32_t> nodes;     ///< of topNodes
    std::vector<std::uint32_t> materials; ///< records
    bool areOthers = false;               ///< all records, instancesByPath and the TLAS's object
    bool areLights = false;               ///< the light table
    bool arePages = false;                ///< what pools have of it
};

/// Externally synchronised.
class PlaceTables {
public:
    /// \param leaves of the scene, in the order of paths; must outlive it. \param committed made of
    /// them; places may have changed since. \pre Serves
    PlaceTables(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                const CommittedScene& committed, const Shutter& shutter);

    /// Whether leaves of such a scene may be mended at all: of others nobody needs tables.
    static bool Serves(const CommittedScene& committed);
    /// Whether the leaf is a record of the TLAS that may be mended.
    bool IsMendable(std::size_t leaf) const { return _records[leaf].item != HDS_NONE; }
    /// Whether the tables have a mendable leaf as visible.
    bool IsShown(std::size_t leaf) const { return _records[leaf].isShown; }

    /// Puts leaves where they are now. \return false: the scene has to be committed; tables and
    /// this are of no use any more. \pre all are mendable; nothing else has changed.
    bool Mend(const std::vector<std::size_t>& leaves, CommittedScene* committed,
              PlaceChanges* changes);

private:
    struct Record {
        std::uint32_t item = HDS_NONE; ///< its place among those of the TLAS
        std::uint32_t rank = 0;        ///< of these, in the order of paths
        bool isShown = true;
    };

    bool PutRecord(std::size_t leaf, CommittedScene* committed, PlaceChanges* changes);
    void Renumber(std::uint32_t firstRank, CommittedScene* committed) const;
    void UpdateReach(std::size_t leaf);

    const std::vector<DrawnLeaf>& _leaves;
    Shutter _shutter;
    std::vector<Record> _records;    ///< by leaf
    std::vector<Reach> _reach;       ///< by leaf; of hidden ones nothing
    std::vector<Reach> _otherPieces; ///< of what is no leaf, as CentreOfReach takes them
    Reach _reachOfOthers;
    Reach _reachOfAll;
    bool _isReachOld = false; ///< something that reached as far has moved
    shared::HdsObject _tlas{};
    BvhRefit _refit;
    std::vector<std::uint32_t> _byPath;       ///< all records of the TLAS in the order of paths
    std::vector<std::uint64_t> _offsetByRank; ///< pathOffset, as committed
    std::vector<std::uint8_t> _isHidden;      ///< by rank
};

} // namespace hds
