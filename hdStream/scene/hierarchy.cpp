// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/hierarchy.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/scene/motion.h"

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

/// Deepest chain of instancers that is followed; longer ones are cycles in all likelihood.
constexpr int kMaxChain = 64;
/// Single records with larger boxes stay out of instance chunks: part of the group's box, by axis.
constexpr float kLargestInChunks = 1.0F / 16.0F;

Bounds Union(const Bounds& a, const Bounds& b) {
    return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

MovingTransform PlacementTransform(const Placement& placement, const Shutter& shutter) {
    return {placement.worldFromObject, placement.samples, shutter};
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

    /// Nothing: it is a group.
    const Member* OnlyLeaf() const {
        return members.size() == 1 && members[0].leaf != nullptr ? members.data() : nullptr;
    }
};

bool SameInstances(const SharedSpan<std::int32_t>& a, const SharedSpan<std::int32_t>& b) {
    return a.size() == b.size() &&
           (a.data() == b.data() || std::equal(a.begin(), a.end(), b.begin()));
}

/// A prim in world space. id: its parent-major instanceId; -1: not instanced.
struct Placed {
    MovingTransform worldFromObject;
    std::int64_t id = -1;
    std::set<std::string> categories; ///< of the instances
};

/// The parent's categories and those of one of the instancer's instances.
std::set<std::string> CategoriesOf(const Placed& parent, const InstancerPrim& instancer,
                                   std::int32_t index) {
    std::set<std::string> categories = parent.categories;
    if (static_cast<std::size_t>(index) < instancer.instanceCategories.size()) {
        const std::set<std::string>& own =
            instancer.instanceCategories[static_cast<std::size_t>(index)];
        categories.insert(own.begin(), own.end());
    }
    return categories;
}

/// Parent-major: the parent's placements are the outer loop.
std::vector<Placed> PlacementsOf(const SceneDescription& scene, const Placement& placement,
                                 const Shutter& shutter, int chain) {
    if (placement.instancerPath.empty()) {
        return {{PlacementTransform(placement, shutter), -1, {}}};
    }
    const auto found = scene.instancers.find(placement.instancerPath);
    if (found == scene.instancers.end() || !found->second.placement.visible || chain >= kMaxChain) {
        return {};
    }
    const InstancerPrim& instancer = found->second;
    const std::size_t limit = instancer.instanceTransforms.Size();
    const SharedSpan<std::int32_t>& instances = placement.instances;
    const auto count = static_cast<std::int64_t>(instances.size());
    std::vector<Placed> placements;
    for (const Placed& parent : PlacementsOf(scene, instancer.placement, shutter, chain + 1)) {
        for (std::size_t rank = 0; rank < instances.size(); ++rank) {
            const std::int32_t index = instances[rank];
            if (index >= 0 && static_cast<std::size_t>(index) < limit) {
                placements.push_back(
                    {parent.worldFromObject * InstanceTransform(instancer, index, shutter) *
                         PlacementTransform(placement, shutter),
                     std::max<std::int64_t>(parent.id, 0) * count + std::int64_t(rank),
                     CategoriesOf(parent, instancer, index)});
            }
        }
    }
    return placements;
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
        CollectMembers();
        if (_chunking.leastInstances > 0) {
            _numToChunk = ChooseChunked(nullptr, _roots);
            std::sort(_chunked.begin(), _chunked.end(), std::less<>());
        }
        _result.groups.resize(1); // the TLAS, filled last
        GroupRecords records(_shutter, !IsChunked(nullptr));
        records.Reserve(_roots.size() + _ownLeaves.size());
        const glm::dmat4 centreFromWorld = glm::translate(glm::dmat4(1.0), -_centre);
        for (const Member& member : _roots) {
            AppendMember(member, centreFromWorld, 0, &records);
        }
        std::vector<Member>().swap(_roots); // of many prims they take more than their records
        AppendWorldInstances(centreFromWorld, &records);
        _result.numLeaves = records.NumLeaves();
        Finish(std::move(records), IsChunked(nullptr), 0, &_result.bounds);
        return std::move(_result);
    }

private:
    /// Chooses groups whose records lie in chunks, if they rest: no two on one path, since a ray
    /// remembers one instance chunk around what it waits for, and of one and those below it what
    /// has more instances. Only counts are looked at: one that moves after all, or places nothing
    /// that is drawn, keeps its place. \param group null: the TLAS. \return about so many instances
    /// lie in chunks then.
    std::uint64_t ChooseChunked(const Prototype* group, const std::vector<Member>& members) {
        const std::size_t numBefore = _chunked.size();
        std::uint64_t numOwn = 0;
        std::uint64_t numBelow = 0;
        for (const Member& member : members) {
            const auto prototypes =
                member.leaf == nullptr ? _prototypes.find(*member.path) : _prototypes.end();
            if (prototypes == _prototypes.end() || !_active.insert(*member.path).second) {
                continue;
            }
            for (const Prototype& prototype : prototypes->second) {
                // Instances that another member has, or that are not there, are negative.
                numOwn += static_cast<std::uint64_t>(
                    std::count_if(prototype.instances.begin(), prototype.instances.end(),
                                  [](std::int32_t index) { return index >= 0; }));
                if (prototype.OnlyLeaf() == nullptr) {
                    numBelow += ChooseChunked(&prototype, prototype.members);
                }
            }
            _active.erase(*member.path);
        }
        if (numOwn < _chunking.leastInstances || numOwn < numBelow) {
            return numBelow;
        }
        _chunked.resize(numBefore);
        _chunked.push_back(group);
        return numOwn;
    }

    bool IsChunked(const Prototype* group) const {
        return std::binary_search(_chunked.begin(), _chunked.end(), group, std::less<>());
    }

    /// Sorts every drawn prim and instancer under the instancer that places it, in path order.
    void CollectMembers() {
        _roots.reserve(_leaves.size());
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
    }

    void AddInstancer(const std::string& path, const InstancerPrim& instancer) {
        if (instancer.placement.visible) {
            AddMember(instancer.placement, {&path, nullptr, nullptr, &instancer,
                                            PlacementTransform(instancer.placement, _shutter)});
        }
    }

    void AddMember(const Placement& placement, Member member) {
        if (placement.instancerPath.empty()) {
            _roots.push_back(std::move(member));
        } else {
            AddToPrototype(placement.instancerPath, std::move(member));
        }
    }

    std::uint32_t ChainLength(const Placement& placement) const {
        std::uint32_t length = 0;
        std::string parent = placement.instancerPath;
        while (!parent.empty() && length < kMaxChain) {
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
        prototypes.push_back({instances, {std::move(member)}});
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
            if (groupLeaves == 0) {
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
        const bool isChunked = IsChunked(&prototype);
        GroupRecords records(_shutter, !isChunked);
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
        Finish(std::move(records), isChunked, index, &group.bounds);
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
                    _result.worldInstances.push_back(
                        {path, leaf.prim,
                         GroupFromDevice(centreFromWorld * placed.worldFromObject.AtFrame(), leaf),
                         KeysFromDevice(MovingTransform(centreFromWorld) * placed.worldFromObject,
                                        leaf),
                         0, HDS_NONE});
                }
            }
        }
    }

    /// The number of a group among the objects.
    std::uint32_t ObjectOf(std::uint32_t groupIndex) const {
        return groupIndex == 0 ? 0 : _firstGroup + groupIndex - 1;
    }

    /// Makes the group of its records. \param isChunked they lie in chunks, if they can.
    void Finish(GroupRecords records, bool isChunked, std::uint32_t groupIndex, Bounds* bounds) {
        const bool mayBeChunked =
            isChunked && records.NumInRuns() >= _chunking.leastInstances && !records.Moves();
        if (!mayBeChunked || !FinishInChunks(&records, groupIndex, bounds)) {
            FinishGroup(std::move(records), groupIndex, bounds);
        }
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
    std::vector<Member> _roots;
    std::vector<const DrawnLeaf*> _ownLeaves;
    std::map<std::string, std::vector<Prototype>> _prototypes;
    std::map<const Prototype*, std::pair<LeafObject, std::uint64_t>> _groupByPrototype;
    std::set<std::string> _active;          ///< instancers being expanded, against cycles
    std::vector<const Prototype*> _chunked; ///< groups whose records lie in chunks; null: the TLAS
    std::uint64_t _numToChunk = 0;          ///< about so many records
    std::uint32_t _numInstanceChunks = 0;   ///< so far
    Hierarchy _result;
};

} // namespace

void ForEachPlacement(const SceneDescription& scene, const Placement& placement,
                      const std::function<void(const glm::dmat4&)>& onPlacement) {
    for (const Placed& placed : PlacementsOf(scene, placement, Shutter(), 0)) {
        onPlacement(placed.worldFromObject.AtFrame());
    }
}

void ForEachPlacement(const SceneDescription& scene, const Placement& placement,
                      const Shutter& shutter,
                      const std::function<void(const MovingTransform&)>& onPlacement) {
    for (const Placed& placed : PlacementsOf(scene, placement, shutter, 0)) {
        onPlacement(placed.worldFromObject);
    }
}

Hierarchy BuildHierarchy(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                         const glm::dvec3& centre, std::uint32_t firstGroup, LightLinks* links,
                         const Shutter& shutter, Warnings& warnings,
                         const InstanceChunkOptions& chunking,
                         HugeVector<shared::HdsBvhNode> nodes) {
    return Builder(scene, leaves, centre, firstGroup, links, shutter, warnings, chunking)
        .Build(std::move(nodes));
}

} // namespace hds
