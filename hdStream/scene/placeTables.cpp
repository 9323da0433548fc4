// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/placeTables.h"

#include "hdStream/scene/groupRecords.h"
#include "hdStream/scene/motion.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <utility>

namespace hds {

namespace {

/// The scene is committed anew, with another TLAS, once its nodes have so many times the area that
/// they were built with.
constexpr double kMostGrowth = 1.25;

std::uint64_t OffsetOf(const shared::HdsInstance& record) {
    return std::uint64_t{record.pathOffset[1]} << 32U | record.pathOffset[0];
}

void SetOffset(std::uint64_t offset, shared::HdsInstance* record) {
    record->pathOffset[0] = static_cast<std::uint32_t>(offset);
    record->pathOffset[1] = static_cast<std::uint32_t>(offset >> 32U);
}

/// Nodes of the TLAS, which are the last ones; none where their boxes move.
std::uint32_t NumNodes(const CommittedScene& scene) {
    const shared::HdsObject& tlas = scene.objects[0];
    const bool rests = tlas.kind == HDS_OBJECT_GROUP;
    return rests ? static_cast<std::uint32_t>(scene.topNodes.size()) - tlas.nodeBase : 0;
}

/// What is not placed by an instancer, lights nothing and holds no medium: no other table knows
/// where it is.
bool IsPlain(const DrawnLeaf& leaf) {
    const LeafObject& object = leaf.object;
    return leaf.Prim().placement.instancerPath.empty() && !object.worldInstance &&
           !object.isLinkedByInstance &&
           (object.flags & (HDS_INSTANCE_MEDIUM | HDS_INSTANCE_CATCHER)) == 0;
}

bool Touches(const Reach& inner, const Reach& outer) {
    bool touches = false;
    for (int axis = 0; axis < 3; ++axis) {
        touches =
            touches || inner.min[axis] <= outer.min[axis] || inner.max[axis] >= outer.max[axis];
    }
    return touches;
}

} // namespace

bool PlaceTables::Serves(const CommittedScene& committed) {
    return NumNodes(committed) > 0 && !committed.hasInstanceChunks && !committed.hasCatchers &&
           committed.motionKeys.empty();
}

PlaceTables::PlaceTables(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                         const CommittedScene& committed, const Shutter& shutter)
    : _leaves(leaves), _shutter(shutter), _records(leaves.size()), _reach(leaves.size()),
      _reachOfOthers(ReachBesideLeaves(scene, &_otherPieces)), _tlas(committed.objects[0]),
      _refit(committed.topNodes.data() + _tlas.nodeBase, NumNodes(committed), _tlas.numItems) {
    std::vector<std::uint32_t> leafOfPrim(committed.prims.size(), HDS_NONE);
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        _reach[leaf] = leaves[leaf].Prim().placement.visible ? ReachOfLeaf(leaves[leaf]) : Reach();
        if (IsPlain(leaves[leaf])) {
            leafOfPrim[leaves[leaf].object.prim] = static_cast<std::uint32_t>(leaf);
        }
    }
    _isReachOld = true;
    const auto first = committed.instancesByPath.begin() + _tlas.itemBase;
    _byPath.assign(first, first + _tlas.numItems);
    _isHidden.resize(_byPath.size());
    for (std::uint32_t rank = 0; rank < _byPath.size(); ++rank) {
        const shared::HdsInstance& record = committed.instances[_byPath[rank]];
        _offsetByRank.push_back(OffsetOf(record));
        if (record.prim != HDS_NONE && leafOfPrim[record.prim] != HDS_NONE) {
            _records[leafOfPrim[record.prim]] = {_byPath[rank] - _tlas.itemBase, rank, true};
        }
    }
}

bool PlaceTables::Mend(const std::vector<std::size_t>& leaves, CommittedScene* committed,
                       PlaceChanges* changes) {
    for (const std::size_t leaf : leaves) {
        UpdateReach(leaf);
    }
    if (_isReachOld) {
        _reachOfAll = _reachOfOthers;
        for (const Reach& reach : _reach) {
            _reachOfAll.Extend(reach);
        }
        _isReachOld = false;
    }
    if (CentreOfReach(_reachOfAll, _reach, _otherPieces) != committed->centre) {
        return false;
    }
    std::uint32_t firstRank = HDS_NONE; // of those that went or came back
    for (const std::size_t leaf : leaves) {
        Record& record = _records[leaf];
        const bool isVisible = _leaves[leaf].Prim().placement.visible;
        if (isVisible && !PutRecord(leaf, committed, changes)) {
            return false;
        }
        if (isVisible != record.isShown) {
            record.isShown = isVisible;
            _isHidden[record.rank] = isVisible ? 0 : 1;
            firstRank = std::min(firstRank, record.rank);
        }
        if (!isVisible) {
            _refit.Set(record.item, Bounds());
        }
    }
    for (const std::uint32_t node : _refit.Write(committed->topNodes.data() + _tlas.nodeBase)) {
        changes->nodes.push_back(_tlas.nodeBase + node);
    }
    if (firstRank != HDS_NONE) {
        Renumber(firstRank, committed);
        changes->areOthers = true;
    }
    return _refit.Growth() <= kMostGrowth;
}

/// A visible leaf, by the arithmetic of a commit.
bool PlaceTables::PutRecord(std::size_t leaf, CommittedScene* committed, PlaceChanges* changes) {
    const DrawnLeaf& drawn = _leaves[leaf];
    const Placement& placement = drawn.Prim().placement;
    const MovingTransform centreFromWorld = glm::translate(glm::dmat4(1.0), -committed->centre);
    GroupRecords one(_shutter);
    const PlacedRecord* added = one.Add(
        {&drawn.object,
         centreFromWorld * MovingTransform(placement.worldFromObject, placement.samples, _shutter),
         0, 0, 0, HDS_NONE});
    if (added == nullptr || one.Moves()) {
        return false;
    }
    const std::uint32_t place = _tlas.itemBase + _records[leaf].item;
    shared::HdsInstance& record = committed->instances[place];
    const std::uint64_t offset = OffsetOf(record);
    one.Write({0}, &record, nullptr);
    SetOffset(offset, &record);
    changes->instances.push_back(place);
    _refit.Set(_records[leaf].item, one.TakeBoxes().open.front());
    return true;
}

/// From a rank on: those that are shown, without gaps. A record that is hidden stands for one leaf.
void PlaceTables::Renumber(std::uint32_t firstRank, CommittedScene* committed) const {
    const auto numHiddenBefore = static_cast<std::uint32_t>(
        std::count(_isHidden.begin(), _isHidden.begin() + firstRank, std::uint8_t{1}));
    std::uint32_t numHidden = numHiddenBefore;
    std::uint32_t* shown = committed->instancesByPath.data() + _tlas.itemBase;
    for (std::uint32_t rank = firstRank; rank < _byPath.size(); ++rank) {
        if (_isHidden[rank] != 0) {
            ++numHidden;
            continue;
        }
        shown[rank - numHidden] = _byPath[rank];
        SetOffset(_offsetByRank[rank] - numHidden, &committed->instances[_byPath[rank]]);
    }
    committed->objects[0].numItems = _tlas.numItems - numHidden;
}

void PlaceTables::UpdateReach(std::size_t leaf) {
    const bool isVisible = _leaves[leaf].Prim().placement.visible;
    const Reach before =
        std::exchange(_reach[leaf], isVisible ? ReachOfLeaf(_leaves[leaf]) : Reach());
    _isReachOld = _isReachOld || Touches(before, _reachOfAll);
    if (!_isReachOld) {
        _reachOfAll.Extend(_reach[leaf]);
    }
}

} // namespace hds
