// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/hierarchy.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/scene/motion.h"
#include "hdStream/scene/placements.h"

#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/vector_relational.hpp>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <set>

namespace hds {

namespace {

/// Single records with larger boxes stay out of instance chunks: part of the group's box, by axis.
constexpr float kLargestInChunks = 1.0F / 16.0F;

Bounds Union(const Bounds& a, const Bounds& b) {
    return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

/// What a group may contain at a path: a prim or a child instancer.
struct Member {
    const std::string* path = nullptr;
    const DrawnLeaf* drawn = nullptr;           ///< a prim of the scene
    const LeafObject* leaf = nullptr;           ///< its, or a group's
    const InstancerPrim* instancer = nullptr;   ///< or an instancer
    MovingTransform transform{glm::dmat4(1.0)}; ///< of the member, in its prototype's space
};

/// Members that an instancer places with the same list of instances: one prototype.
struct Prototype {
    SharedSpan<std::int32_t> instances;
    std::vector<Member> members;
    /// Of the instances those that are there; others, or what another member has, are negative.
    /// Counted once: choosing what lies in chunks asks again whenever a group is refused.
    std::uint64_t numPlaced = 0;

    /// Nothing: it is a group.
    const Member* OnlyLeaf() const {
        return members.size() == 1 && members[0].leaf != nullptr ? members.data() : nullptr;
    }
    /// The paths of those of its members that are instancers.
    std::vector<const std::string*> Instancers() const {
        std::vector<const std::string*> paths;
        for (const Member& member : members) {
            if (member.leaf == nullptr) {
                paths.push_back(member.path);
            }
        }
        return paths;
    }
};

bool SameInstances(const SharedSpan<std::int32_t>& a, const SharedSpan<std::int32_t>& b) {
    return a.size() == b.size() &&
           (a.data() == b.data() || std::equal(a.begin(), a.end(), b.begin()));
}

class Builder {
public:
    Builder(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
            const glm::dvec3& centre, std::uint32_t firstGroup, LightLinks* links,
            const Shutter& shutter, Warnings& warnings, const InstanceChunkOptions& chunking)
        : _scene(scene), _leaves(leaves), _centre(centre), _firstGroup(firstGroup), _links(*links),
          _shutter(shutter), _warnings(warnings), _chunking(chunking) {}

    Hierarchy Build(HugeVector<shared::HdsBvhNode> nodes) {
        _result.nodes = std::move(nodes);
        _numNodesBefore = _result.nodes.size();
        CollectMembers();
        if (_chunking.leastInstances > 0) {
            ChooseChunked();
        }
        while (!BuildGroups()) {
            _result.nodes.resize(_numNodesBefore);
            Hierarchy again;
            again.nodes = std::move(_result.nodes);
            _result = std::move(again);
            _groupByPrototype.clear();
            _numInstanceChunks = 0;
            CollectMembers();
        }
        return std::move(_result);
    }

private:
    /// \return false when other groups have chunks than was thought: all is to be done again.
    bool BuildGroups() {
        _isChosenAgain = false;
        _result.groups.resize(1); // the TLAS, filled last
        GroupRecords records(_shutter, !IsChunked(nullptr));
        records.Reserve(_roots.size() + _ownLeaves.size());
        const glm::dmat4 centreFromWorld = glm::translate(glm::dmat4(1.0), -_centre);
        for (const Member& member : _roots) {
            AppendMember(member, centreFromWorld, 0, &records);
            if (_isChosenAgain) {
                return false;
            }
        }
        std::vector<Member>().swap(_roots); // of many prims they take more than their records
        AppendWorldInstances(centreFromWorld, &records);
        _result.numLeaves = records.NumLeaves();
        const float numPrimitives = records.NumPrimitives();
        const float ofSingles = records.NumFlatOfSingles();
        const float ofRuns = records.NumFlatOfRuns();
        const bool isInChunks = Finish(std::move(records), nullptr, 0, &_result.bounds);
        _result.flatPart =
            (ofSingles + (isInChunks ? 0.0F : ofRuns)) / std::max(numPrimitives, 1.0F);
        return !_isChosenAgain;
    }

    void ChooseChunked() {
        _chunked.clear();
        _numToChunk = ChooseChunked(nullptr, _rootInstancers);
        std::sort(_chunked.begin(), _chunked.end(), std::less<>());
    }

    /// A group that was chosen stays in the table: others may take its place.
    void Refuse(const Prototype* group) {
        std::vector<const Prototype*> others = _chunked;
        others.erase(std::find(others.begin(), others.end(), group));
        _refused.insert(group);
        ChooseChunked();
        _isChosenAgain = _isChosenAgain || _chunked != others;
    }

    /// Chooses groups whose records lie in chunks, if they can: no two on one path, since a ray
    /// remembers one instance chunk around what it waits for, and of one and those below it what
    /// has more instances. Only counts are looked at, and what was refused. \param group null: the
    /// TLAS. \param instancers in it. \return about so many instances lie in chunks then.
    std::uint64_t ChooseChunked(const Prototype* group,
                                const std::vector<const std::string*>& instancers) {
        const std::size_t numBefore = _chunked.size();
        std::uint64_t numOwn = 0;
        std::uint64_t numBelow = 0;
        for (const std::string* path : instancers) {
            const auto prototypes = _prototypes.find(*path);
            if (prototypes == _prototypes.end() || !_chosenWay.insert(*path).second) {
                continue;
            }
            for (const Prototype& prototype : prototypes->second) {
                numOwn += prototype.numPlaced;
                if (prototype.OnlyLeaf() == nullptr) {
                    numBelow += ChooseChunked(&prototype, prototype.Instancers());
                }
            }
            _chosenWay.erase(*path);
        }
        if (numOwn < _chunking.leastInstances || numOwn < numBelow || _refused.count(group) > 0) {
            return numBelow;
        }
        _chunked.resize(numBefore);
        _chunked.push_back(group);
        return numOwn;
    }

    bool IsChunked(const Prototype* group) const {
        return std::binary_search(_chunked.begin(), _chunked.end(), group, std::less<>());
    }

    /// Sorts every drawn prim and instancer under the instancer that places it, in path order; when
    /// it is called again, those that none places.
    void CollectMembers() {
        _roots.clear();
        _roots.reserve(_leaves.size());
        _ownLeaves.clear();
        auto instancer = _scene.instancers.begin();
        for (const DrawnLeaf& leaf : _leaves) {
            for (; instancer != _scene.instancers.end() && instancer->first < leaf.Path();
                 ++instancer) {
                AddInstancer(instancer->first, instancer->second);
            }
            const Placement& placement = leaf.Prim().placement;
            if (leaf.object.worldInstance || leaf.object.isLinkedByInstance ||
                ChainLength(placement) > HDS_MAX_GROUP_DEPTH) {
                _ownLeaves.push_back(&leaf);
            } else {
                AddMember(placement, {&leaf.Path(), &leaf, &leaf.object, nullptr,
                                      PlacementTransform(placement, _shutter)});
            }
        }
        for (; instancer != _scene.instancers.end(); ++instancer) {
            AddInstancer(instancer->first, instancer->second);
        }
        _hasPrototypes = true;
    }

    void AddInstancer(const std::string& path, const InstancerPrim& instancer) {
        if (instancer.placement.visible) {
            AddMember(instancer.placement, {&path, nullptr, nullptr, &instancer,
                                            PlacementTransform(instancer.placement, _shutter)});
        }
    }

    void AddMember(const Placement& placement, Member member) {
        if (placement.instancerPath.empty()) {
            if (member.leaf == nullptr && !_hasPrototypes) {
                _rootInstancers.push_back(member.path);
            }
            _roots.push_back(std::move(member));
        } else if (!_hasPrototypes) {
            AddToPrototype(placement.instancerPath, std::move(member));
        }
    }

    std::uint32_t ChainLength(const Placement& placement) const {
        std::uint32_t length = 0;
        std::string parent = placement.instancerPath;
        while (!parent.empty() && length < kMaxInstancerChain) {
            ++length;
            const auto found = _scene.instancers.find(parent);
            parent = found == _scene.instancers.end() ? std::string()
                                                      : found->second.placement.instancerPath;
        }
        return length;
    }

    void AddToPrototype(const std::string& parent, Member member) {
        const auto instancer = _scene.instancers.find(parent);
        if (instancer == _scene.instancers.end()) {
            _warnings.Add(*member.path, "its instancer " + parent + " does not exist; not drawn");
            return;
        }
        const SharedSpan<std::int32_t>& instances = member.drawn != nullptr
                                                        ? member.drawn->Instances()
                                                        : member.instancer->placement.instances;
        if (instances.empty()) {
            return; // placed nowhere
        }
        std::vector<Prototype>& prototypes = _prototypes[parent];
        for (Prototype& prototype : prototypes) {
            if (SameInstances(prototype.instances, instances)) {
                prototype.members.push_back(std::move(member));
                return;
            }
        }
        const bool isCounted = _chunking.leastInstances > 0;
        const auto numPlaced = static_cast<std::uint64_t>(
            isCounted ? std::count_if(instances.begin(), instances.end(),
                                      [](std::int32_t index) { return index >= 0; })
                      : 0);
        prototypes.push_back({instances, {std::move(member)}, numPlaced});
    }

    /// Records of a member in a group whose space is `groupFromPrototype` away from the member's.
    void AppendMember(const Member& member, const MovingTransform& groupFromPrototype,
                      std::uint32_t depth, GroupRecords* records) {
        if (member.leaf != nullptr) {
            AppendRecord(member, groupFromPrototype, 0, 0, records);
        } else {
            AppendInstancer(member, groupFromPrototype, depth, records);
        }
    }

    void AppendInstancer(const Member& member, const MovingTransform& groupFromPrototype,
                         std::uint32_t depth, GroupRecords* records) {
        if (!_active.insert(*member.path).second) {
            _warnings.Add(*member.path,
                          "instancers form a cycle; the inner placement is not drawn");
            return;
        }
        const auto prototypes = _prototypes.find(*member.path);
        if (prototypes != _prototypes.end()) {
            const MovingTransform groupFromInstancer = groupFromPrototype * member.transform;
            for (const Prototype& prototype : prototypes->second) {
                AppendPrototype(member, prototype, groupFromInstancer, depth, records);
            }
        }
        _active.erase(*member.path);
    }

    void AppendPrototype(const Member& instancer, const Prototype& prototype,
                         const MovingTransform& groupFromInstancer, std::uint32_t depth,
                         GroupRecords* records) {
        const Member* only = prototype.OnlyLeaf();
        Member group;
        LeafObject groupObject;
        std::uint64_t groupLeaves = 1;
        if (only == nullptr) {
            groupObject = BuildGroup(prototype, depth + 1, &groupLeaves);
            group.path = instancer.path;
            group.leaf = &groupObject;
            if (groupLeaves == 0 || _isChosenAgain) {
                return;
            }
        }
        const Member& placed = only != nullptr ? *only : group;
        const std::uint32_t numBad =
            records->Add(InstanceRun{*placed.leaf, groupLeaves, groupFromInstancer,
                                     instancer.instancer, prototype.instances, placed.transform});
        if (numBad > 0) {
            _warnings.Add(*instancer.path, std::to_string(numBad) +
                                               " instances dropped: transform singular, not "
                                               "finite or beyond 1e30, or index out of range");
        }
    }

    /// \return null when it cannot be drawn.
    PlacedRecord* AppendRecord(const Member& member, const MovingTransform& groupFromPrototype,
                               std::uint32_t rank, std::uint32_t count, GroupRecords* records) {
        PlacedRecord* added = records->Add(
            {member.leaf, groupFromPrototype * member.transform, count, rank, 0, HDS_NONE});
        if (added == nullptr) {
            _warnings.Add(*member.path,
                          "not drawn: its transform is singular, or its place or size is not "
                          "finite or beyond 1e30");
        }
        return added;
    }

    /// A group object that holds a prototype's members; built once per prototype.
    LeafObject BuildGroup(const Prototype& prototype, std::uint32_t depth,
                          std::uint64_t* numLeaves) {
        const auto known = _groupByPrototype.find(&prototype);
        if (known != _groupByPrototype.end()) {
            *numLeaves = known->second.second;
            return known->second.first;
        }
        _result.depth = std::max(_result.depth, depth);
        GroupRecords records(_shutter, !IsChunked(&prototype));
        for (const Member& member : prototype.members) {
            AppendMember(member, glm::dmat4(1.0), depth, &records);
        }
        LeafObject group;
        group.prim = HDS_NONE;
        // Visibility masks are tested on leaves; a group shows what any of its leaves shows.
        group.flags = records.Flags();
        const auto index = static_cast<std::uint32_t>(_result.groups.size());
        _result.groups.emplace_back();
        *numLeaves = records.NumLeaves();
        group.numPrimitives = records.NumPrimitives();
        group.numFlat = records.NumFlatOfSingles() + records.NumFlatOfRuns();
        if (Finish(std::move(records), &prototype, index, &group.bounds)) {
            group.numFlat = 0.0F;
        }
        group.object = ObjectOf(index);
        _groupByPrototype[&prototype] = {group, *numLeaves};
        return group;
    }

    void AppendWorldInstances(const glm::dmat4& centreFromWorld, GroupRecords* records) {
        for (const DrawnLeaf* drawn : _ownLeaves) {
            const std::string& path = drawn->Path();
            const LeafObject& leaf = drawn->object;
            Placement placement = drawn->Prim().placement;
            placement.instances = drawn->Instances();
            WarnOfTooMany(_scene, path, placement, _warnings);
            for (const Placed& placed : PlacementsOf(_scene, placement, _shutter, 0)) {
                const Member member{&path, drawn, &leaf, nullptr, placed.worldFromObject};
                // A record of the TLAS: its rank is the id, whatever the count.
                PlacedRecord* added =
                    AppendRecord(member, centreFromWorld,
                                 static_cast<std::uint32_t>(std::max<std::int64_t>(placed.id, 0)),
                                 placed.id < 0 ? 0 : 1, records);
                if (added != nullptr && leaf.isLinkedByInstance) {
                    added->moreFlags = _links.FlagsOf(drawn->Prim().categories, placed.categories);
                }
                if (added != nullptr && leaf.worldInstance) {
                    added->worldInstance =
                        static_cast<std::uint32_t>(_result.worldInstances.size());
                    std::vector<glm::dmat4> keys = KeysFromDevice(
                        MovingTransform(centreFromWorld) * placed.worldFromObject, leaf);
                    const glm::dmat4 atFrame = UsableAtFrame(
                        GroupFromDevice(centreFromWorld * placed.worldFromObject.AtFrame(), leaf),
                        keys);
                    _result.worldInstances.push_back(
                        {path, leaf.prim, atFrame, std::move(keys), 0, HDS_NONE});
                }
            }
        }
    }

    /// The number of a group among the objects.
    std::uint32_t ObjectOf(std::uint32_t groupIndex) const {
        return groupIndex == 0 ? 0 : _firstGroup + groupIndex - 1;
    }

    /// Makes a group of its records, in chunks if it was chosen for that and they rest.
    /// Where all is to be done again, nothing: some records are not there.
    /// \param group null: the TLAS. \return whether they lie in chunks.
    bool Finish(GroupRecords records, const Prototype* group, std::uint32_t groupIndex,
                Bounds* bounds) {
        if (!_isChosenAgain && IsChunked(group)) {
            const bool mayBe = records.NumInRuns() >= _chunking.leastInstances && !records.Moves();
            if (mayBe && FinishInChunks(&records, groupIndex, bounds)) {
                return true;
            }
            Refuse(group);
        }
        if (!_isChosenAgain) {
            FinishGroup(std::move(records), groupIndex, bounds);
        }
        return false;
    }

    /// Builds the group's BVH and appends its records in leaf order.
    void FinishGroup(GroupRecords records, std::uint32_t groupIndex, Bounds* bounds) {
        BvhOptions options;
        options.maxLeafItems = 1;
        BoxesOfRecords boxes = records.TakeBoxes();
        Bvh tree = records.Moves()
                       ? BuildMovingBvh({std::move(boxes.open), std::move(boxes.close)}, options)
                       : BuildBvh(std::move(boxes.open), options);
        if (tree.nodes.empty()) {
            tree.nodes.emplace_back(); // a root without children
        }
        shared::HdsObject& group = _result.groups[groupIndex];
        group.kind = HDS_OBJECT_GROUP | static_cast<std::uint32_t>(tree.laterNodes.size())
                                            << HDS_OBJECT_CLOSE_SHIFT;
        group.nodeBase = static_cast<std::uint32_t>(_result.nodes.size());
        group.itemBase = static_cast<std::uint32_t>(_result.instances.size());
        group.numItems = records.Size();
        _result.nodes.insert(_result.nodes.end(), tree.nodes.begin(), tree.nodes.end());
        _result.nodes.insert(_result.nodes.end(), tree.laterNodes.begin(), tree.laterNodes.end());
        *bounds = tree.bounds;
        const std::vector<std::uint32_t> order = std::move(tree.order);
        tree = Bvh(); // frees its nodes
        _result.instancesByPath.resize(group.itemBase + records.Size());
        std::uint32_t* placeOf = _result.instancesByPath.data() + group.itemBase;
        for (std::uint32_t place = 0; place < order.size(); ++place) {
            placeOf[order[place]] = group.itemBase + place;
        }
        _result.instances.resize(group.itemBase + records.Size());
        records.Write(order, _result.instances.data() + group.itemBase, &_result.motionKeys);
        for (const GroupRecords::World& world : records.WorldRecords()) {
            _result.worldInstances[world.worldInstance].pathIndex = world.pathOffset;
            _result.worldInstances[world.worldInstance].instance = placeOf[world.record];
        }
    }

    /// The same when its instances lie in chunks. Of single records those stay in the table that
    /// are world instances, or so large that they would make a chunk's box large. The table has a
    /// record more that stands in for each chunk. \return false: there would be too many chunks in
    /// the scene, and nothing is done.
    bool FinishInChunks(GroupRecords* records, std::uint32_t groupIndex, Bounds* bounds) {
        const std::vector<std::uint32_t> singles = records->Singles();
        std::vector<Bounds> boxes(singles.size());
        tbb::parallel_for(std::size_t{0}, singles.size(),
                          [&](std::size_t i) { boxes[i] = records->BoxOf(singles[i]); });
        const Bounds all =
            std::accumulate(boxes.begin(), boxes.end(), records->BoundsOfRuns(), Union);
        const glm::vec3 largest = kLargestInChunks * (all.max - all.min);
        std::vector<std::uint32_t> inTable;
        std::vector<Bounds> topBoxes;
        Bounds inChunks = records->BoundsOfRuns();
        for (std::size_t i = 0; i < singles.size(); ++i) {
            const bool isSmall = glm::all(glm::lessThanEqual(boxes[i].max - boxes[i].min, largest));
            if (isSmall && !records->IsWorldInstance(singles[i])) {
                ExtendBounds(&inChunks, boxes[i]);
            } else {
                inTable.push_back(singles[i]);
                topBoxes.push_back(boxes[i]);
            }
        }
        ChunkPlan plan =
            PlanInstanceChunks(*records, inTable, inChunks, _chunking.chunkBytes, _numToChunk);
        if (plan.NumChunks() + _numInstanceChunks >= HDS_MAX_INSTANCE_CHUNKS) {
            return false; // a record of the last one might have the number HDS_NONE
        }
        topBoxes.insert(topBoxes.end(), plan.bounds.begin(), plan.bounds.end());
        std::vector<shared::HdsInstance> items(inTable.size());
        records->Write(inTable, items.data(), nullptr);
        for (std::size_t chunk = 0; chunk < plan.NumChunks(); ++chunk) {
            items.push_back(InstanceOfChunk(_numInstanceChunks++, records->Flags()));
        }
        const std::vector<std::uint32_t> placeOf =
            FinishTable(std::move(topBoxes), items, groupIndex, bounds);
        for (const GroupRecords::World& world : records->WorldRecords()) {
            _result.worldInstances[world.worldInstance].pathIndex = world.pathOffset;
            const auto item = std::lower_bound(inTable.begin(), inTable.end(), world.record);
            _result.worldInstances[world.worldInstance].instance =
                placeOf[static_cast<std::size_t>(item - inTable.begin())];
        }
        _result.instanceChunks.push_back(std::make_shared<InstanceChunks>(
            std::move(*records), std::move(plan), ObjectOf(groupIndex), _chunking.store));
        return true;
    }

    /// The record that stands in for an instance chunk. \param flags of what it may hold.
    shared::HdsInstance InstanceOfChunk(std::uint32_t chunk, std::uint32_t flags) {
        shared::HdsInstance record{};
        for (const int diagonal : {0, 5, 10}) {
            record.objectFromParent[diagonal] = 1.0F;
        }
        record.object = ObjectOf(static_cast<std::uint32_t>(_result.groups.size()));
        record.flags = flags;
        record.pathOffset[0] = record.pathOffset[1] = HDS_NONE;
        record.prim = HDS_NONE;
        record.lightBase = HDS_NONE;
        _result.groups.push_back({HDS_OBJECT_INSTANCES, 0, chunk, 1});
        return record;
    }

    /// Builds the BVH of a group over boxes and writes the items into the table, which are in the
    /// order of pathOffset. \return their places.
    std::vector<std::uint32_t> FinishTable(std::vector<Bounds> boxes,
                                           const std::vector<shared::HdsInstance>& items,
                                           std::uint32_t groupIndex, Bounds* bounds) {
        BvhOptions options;
        options.maxLeafItems = 1;
        const Bvh tree = BuildBvh(std::move(boxes), options);
        const auto first = static_cast<std::uint32_t>(_result.instances.size());
        _result.groups[groupIndex] = {HDS_OBJECT_GROUP,
                                      static_cast<std::uint32_t>(_result.nodes.size()), first,
                                      static_cast<std::uint32_t>(items.size())};
        _result.nodes.insert(_result.nodes.end(), tree.nodes.begin(), tree.nodes.end());
        *bounds = tree.bounds;
        std::vector<std::uint32_t> placeOf(items.size());
        for (const std::uint32_t item : tree.order) {
            placeOf[item] = static_cast<std::uint32_t>(_result.instances.size());
            _result.instances.push_back(items[item]);
        }
        _result.instancesByPath.insert(_result.instancesByPath.end(), placeOf.begin(),
                                       placeOf.end());
        return placeOf;
    }

    const SceneDescription& _scene;
    const std::vector<DrawnLeaf>& _leaves;
    glm::dvec3 _centre;
    std::uint32_t _firstGroup;
    LightLinks& _links;
    const Shutter& _shutter;
    Warnings& _warnings;
    const InstanceChunkOptions& _chunking;
    std::size_t _numNodesBefore = 0; ///< nodes to begin with
    std::vector<Member> _roots;
    std::vector<const std::string*> _rootInstancers; ///< their paths
    bool _hasPrototypes = false;
    std::vector<const DrawnLeaf*> _ownLeaves;
    std::map<std::string, std::vector<Prototype>> _prototypes;
    std::map<const Prototype*, std::pair<LeafObject, std::uint64_t>> _groupByPrototype;
    std::set<std::string> _active;          ///< instancers being expanded, against cycles
    std::set<std::string> _chosenWay;       ///< the same of ChooseChunked
    std::vector<const Prototype*> _chunked; ///< groups whose records lie in chunks; null: the TLAS
    std::set<const Prototype*> _refused;    ///< of those that were chosen once: they cannot
    bool _isChosenAgain = false;            ///< since BuildGroups began, and otherwise
    std::uint64_t _numToChunk = 0;          ///< about so many records
    std::uint32_t _numInstanceChunks = 0;   ///< so far
    Hierarchy _result;
};

} // namespace

Hierarchy BuildHierarchy(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                         const glm::dvec3& centre, std::uint32_t firstGroup, LightLinks* links,
                         const Shutter& shutter, Warnings& warnings,
                         const InstanceChunkOptions& chunking,
                         HugeVector<shared::HdsBvhNode> nodes) {
    return Builder(scene, leaves, centre, firstGroup, links, shutter, warnings, chunking)
        .Build(std::move(nodes));
}

} // namespace hds
