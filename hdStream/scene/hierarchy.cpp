// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/hierarchy.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/scene/motion.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <set>

namespace hds {

namespace {

/// Deepest chain of instancers that is followed; longer ones are cycles in all likelihood.
constexpr int kMaxChain = 64;

/// In a list of instances: places nothing, but counts for the ranks of those after it, for prims
/// of which the front end has made several with instances of one list (primvars per instance).
constexpr std::int32_t kGap = -1;

glm::dmat4 MatrixAt(const SharedSpan<double>& transforms, std::int32_t index) {
    return glm::make_mat4(transforms.data() + 16 * static_cast<std::size_t>(index));
}

MovingTransform InstanceTransform(const InstancerPrim& instancer, std::int32_t index,
                                  const Shutter& shutter) {
    const glm::dmat4 atFrame = MatrixAt(instancer.instanceTransforms, index);
    if (!shutter.IsOpen() || instancer.samples.empty()) {
        return atFrame;
    }
    std::vector<TransformSample> samples;
    for (const InstanceSample& sample : instancer.samples) {
        if (sample.transforms.size() == instancer.instanceTransforms.size()) {
            samples.push_back({sample.time, MatrixAt(sample.transforms, index)});
        }
    }
    return {atFrame, samples, shutter};
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
    const std::size_t limit = instancer.instanceTransforms.size() / 16;
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

/// A record before its group's BVH gives it a place.
struct Record {
    shared::HdsInstance instance;
    Bounds bounds;      ///< when the shutter opens
    Bounds closeBounds; ///< when it closes
    std::uint64_t numLeaves = 0;
    std::vector<glm::dmat4> keys;           ///< of the map outwards, of what moves
    std::uint32_t worldInstance = HDS_NONE; ///< index in Hierarchy::worldInstances
};

class Builder {
public:
    Builder(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
            const glm::dvec3& centre, std::uint32_t firstGroup, LightLinks* links,
            const Shutter& shutter, Warnings& warnings)
        : _scene(scene), _leaves(leaves), _centre(centre), _firstGroup(firstGroup), _links(*links),
          _shutter(shutter), _warnings(warnings) {}

    Hierarchy Build() {
        CollectMembers();
        _result.groups.resize(1); // the TLAS, filled last
        std::vector<Record> records;
        const glm::dmat4 centreFromWorld = glm::translate(glm::dmat4(1.0), -_centre);
        records.reserve(_roots.size());
        for (const Member& member : _roots) {
            AppendMember(member, centreFromWorld, 0, &records);
        }
        AppendWorldInstances(centreFromWorld, &records);
        _result.numLeaves = FinishGroup(std::move(records), 0, &_result.bounds);
        return std::move(_result);
    }

private:
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
                                                        ? member.drawn->Prim().placement.instances
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
                      std::uint32_t depth, std::vector<Record>* records) {
        if (member.leaf != nullptr) {
            AppendRecord(member, groupFromPrototype, 0, 0, records);
        } else {
            AppendInstancer(member, groupFromPrototype, depth, records);
        }
    }

    void AppendInstancer(const Member& member, const MovingTransform& groupFromPrototype,
                         std::uint32_t depth, std::vector<Record>* records) {
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
                         std::vector<Record>* records) {
        const std::size_t limit = instancer.instancer->instanceTransforms.size() / 16;
        const Member* only = prototype.members.size() == 1 && prototype.members[0].leaf != nullptr
                                 ? &prototype.members[0]
                                 : nullptr;
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
        const auto count = static_cast<std::uint32_t>(prototype.instances.size());
        const std::size_t first = records->size();
        records->resize(first + count);
        std::atomic<std::uint32_t> numBad{0};
        std::atomic<bool> isComplete{true};
        tbb::parallel_for(std::uint32_t{0}, count, [&](std::uint32_t rank) {
            const std::int32_t index = prototype.instances[rank];
            const bool isInRange = index >= 0 && static_cast<std::size_t>(index) < limit;
            const MovingTransform transform =
                isInRange ? groupFromInstancer *
                                InstanceTransform(*instancer.instancer, index, _shutter) *
                                placed.transform
                          : MovingTransform(glm::dmat4(0.0));
            if (!FillRecord(placed, transform, rank, count, groupLeaves,
                            &(*records)[first + rank])) {
                isComplete = false;
                numBad += index == kGap ? 0 : 1;
            }
        });
        if (!isComplete) {
            records->erase(
                std::remove_if(records->begin() + static_cast<std::ptrdiff_t>(first),
                               records->end(),
                               [](const Record& record) { return record.numLeaves == 0; }),
                records->end());
        }
        if (numBad > 0) {
            _warnings.Add(*instancer.path, std::to_string(numBad) +
                                               " instances dropped: transform singular, not "
                                               "finite or beyond 1e30, or index out of range");
        }
    }

    void AppendRecord(const Member& member, const MovingTransform& groupFromPrototype,
                      std::uint32_t rank, std::uint32_t count, std::vector<Record>* records) {
        Record record;
        if (FillRecord(member, groupFromPrototype * member.transform, rank, count, 1, &record)) {
            records->push_back(std::move(record));
        } else {
            _warnings.Add(*member.path,
                          "not drawn: its transform is singular, not finite or beyond 1e30");
        }
    }

    static bool FillRecord(const Member& member, const MovingTransform& groupFromObject,
                           std::uint32_t rank, std::uint32_t count, std::uint64_t numLeaves,
                           Record* record) {
        const LeafObject& leaf = *member.leaf;
        const glm::dmat4 transform = glm::translate(groupFromObject.AtFrame(), leaf.origin);
        if (!IsUsableTransform(transform) || !IsWithinReach(transform, leaf.bounds)) {
            record->numLeaves = 0;
            return false;
        }
        shared::HdsInstance& instance = record->instance;
        const AffineRows inverse = RowsFromMatrix(glm::inverse(transform));
        std::copy(inverse.begin(), inverse.end(), instance.objectFromParent);
        instance.object = leaf.object;
        instance.flags = leaf.flags;
        instance.prim = leaf.prim;
        instance.lightBase = HDS_NONE;
        instance.instanceCount = count;
        instance.instanceRank = rank;
        record->bounds = record->closeBounds = TransformBounds(transform, leaf.bounds);
        record->numLeaves = numLeaves;
        if (groupFromObject.Moves()) {
            FillMotion(groupFromObject, leaf, record);
        }
        return true;
    }

    /// What passes through a pose that cannot be inverted stays where the frame has it.
    static void FillMotion(const MovingTransform& groupFromObject, const LeafObject& leaf,
                           Record* record) {
        const MovingTransform origin(glm::translate(glm::dmat4(1.0), leaf.origin));
        std::vector<glm::dmat4> keys = MakeMotionKeys(groupFromObject * origin, leaf.bounds);
        const bool areUsable =
            std::all_of(keys.begin(), keys.end(), [&leaf](const glm::dmat4& key) {
                return IsUsableTransform(key) && IsWithinReach(key, leaf.bounds);
            });
        if (areUsable) {
            const std::array<Bounds, 2> ends = TransformEnds(keys, leaf.bounds);
            record->bounds = ends[0];
            record->closeBounds = ends[1];
            record->keys = std::move(keys);
        }
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
        std::vector<Record> records;
        for (const Member& member : prototype.members) {
            AppendMember(member, glm::dmat4(1.0), depth, &records);
        }
        LeafObject group;
        group.prim = HDS_NONE;
        // Visibility masks are tested on leaves; a group shows what any of its leaves shows.
        for (const Record& record : records) {
            group.flags |= record.instance.flags;
        }
        const auto index = static_cast<std::uint32_t>(_result.groups.size());
        _result.groups.emplace_back();
        *numLeaves = FinishGroup(std::move(records), index, &group.bounds);
        group.object = _firstGroup + index - 1;
        _groupByPrototype[&prototype] = {group, *numLeaves};
        return group;
    }

    void AppendWorldInstances(const glm::dmat4& centreFromWorld, std::vector<Record>* records) {
        for (const DrawnLeaf* drawn : _ownLeaves) {
            const std::string& path = drawn->Path();
            const LeafObject& leaf = drawn->object;
            for (const Placed& placed :
                 PlacementsOf(_scene, drawn->Prim().placement, _shutter, 0)) {
                Member member{&path, drawn, &leaf, nullptr, placed.worldFromObject};
                if (leaf.worldInstance && placed.worldFromObject.Moves()) {
                    member.transform = placed.worldFromObject.AtFrame(); // as its light is
                    _warnings.Add(path, "emits light: not blurred by its motion");
                }
                const std::size_t before = records->size();
                // A record of the TLAS: its rank is the id, whatever the count.
                AppendRecord(member, centreFromWorld,
                             static_cast<std::uint32_t>(std::max<std::int64_t>(placed.id, 0)),
                             placed.id < 0 ? 0 : 1, records);
                if (records->size() > before && leaf.isLinkedByInstance) {
                    records->back().instance.flags |=
                        _links.FlagsOf(drawn->Prim().categories, placed.categories);
                }
                if (records->size() > before && leaf.worldInstance) {
                    records->back().worldInstance =
                        static_cast<std::uint32_t>(_result.worldInstances.size());
                    _result.worldInstances.push_back(
                        {path, leaf.prim,
                         glm::translate(centreFromWorld * placed.worldFromObject.AtFrame(),
                                        leaf.origin),
                         0, HDS_NONE});
                }
            }
        }
    }

    static std::vector<Bounds> CloseBoxes(const std::vector<Record>& records) {
        std::vector<Bounds> boxes;
        boxes.reserve(records.size());
        for (const Record& record : records) {
            boxes.push_back(record.closeBounds);
        }
        return boxes;
    }

    /// Builds the group's BVH, appends its records in leaf order and returns its leaf count.
    std::uint64_t FinishGroup(std::vector<Record> records, std::uint32_t groupIndex,
                              Bounds* bounds) {
        std::uint64_t numLeaves = 0;
        std::vector<Bounds> boxes;
        bool moves = false;
        boxes.reserve(records.size());
        for (Record& record : records) {
            record.instance.pathOffset[0] = static_cast<std::uint32_t>(numLeaves);
            record.instance.pathOffset[1] = static_cast<std::uint32_t>(numLeaves >> 32U);
            if (record.worldInstance != HDS_NONE) {
                _result.worldInstances[record.worldInstance].pathIndex = numLeaves;
            }
            numLeaves += record.numLeaves;
            boxes.push_back(record.bounds);
            moves = moves || !record.keys.empty();
        }
        BvhOptions options;
        options.maxLeafItems = 1;
        Bvh tree =
            moves ? BuildMovingBvh(boxes, CloseBoxes(records), options) : BuildBvh(boxes, options);
        if (tree.nodes.empty()) {
            tree.nodes.emplace_back(); // a root without children
        }
        shared::HdsObject& group = _result.groups[groupIndex];
        group.kind = HDS_OBJECT_GROUP | static_cast<std::uint32_t>(tree.closeNodes.size())
                                            << HDS_OBJECT_CLOSE_SHIFT;
        group.nodeBase = static_cast<std::uint32_t>(_result.nodes.size());
        group.itemBase = static_cast<std::uint32_t>(_result.instances.size());
        group.numItems = static_cast<std::uint32_t>(records.size());
        _result.nodes.insert(_result.nodes.end(), tree.nodes.begin(), tree.nodes.end());
        _result.nodes.insert(_result.nodes.end(), tree.closeNodes.begin(), tree.closeNodes.end());
        _result.instancesByPath.resize(_result.instances.size() + records.size());
        for (std::uint32_t slot = 0; slot < tree.order.size(); ++slot) {
            _result.instancesByPath[group.itemBase + tree.order[slot]] = group.itemBase + slot;
            const Record& record = records[tree.order[slot]];
            if (record.worldInstance != HDS_NONE) {
                _result.worldInstances[record.worldInstance].instance = group.itemBase + slot;
            }
            _result.instances.push_back(PlacedInstance(record));
        }
        *bounds = tree.bounds;
        return numLeaves;
    }

    /// The instance of a record, whose keys become the hierarchy's.
    shared::HdsInstance PlacedInstance(const Record& record) {
        shared::HdsInstance instance = record.instance;
        if (record.keys.empty()) {
            instance.flags |= IsIdentity(instance.objectFromParent) ? HDS_INSTANCE_IN_PLACE : 0U;
        } else {
            const auto first = static_cast<std::uint32_t>(_result.motionKeys.size());
            const auto numSegments = static_cast<std::uint32_t>(record.keys.size() - 1);
            instance.flags |= HDS_INSTANCE_MOVES;
            std::memcpy(&instance.objectFromParent[HDS_MOTION_FIRST_KEY], &first, sizeof(first));
            std::memcpy(&instance.objectFromParent[HDS_MOTION_SEGMENTS], &numSegments,
                        sizeof(numSegments));
            for (const glm::dmat4& key : record.keys) {
                _result.motionKeys.push_back(RowsFromMatrix(key));
            }
        }
        return instance;
    }

    const SceneDescription& _scene;
    const std::vector<DrawnLeaf>& _leaves;
    glm::dvec3 _centre;
    std::uint32_t _firstGroup;
    LightLinks& _links;
    const Shutter& _shutter;
    Warnings& _warnings;
    std::vector<Member> _roots;
    std::vector<const DrawnLeaf*> _ownLeaves;
    std::map<std::string, std::vector<Prototype>> _prototypes;
    std::map<const Prototype*, std::pair<LeafObject, std::uint64_t>> _groupByPrototype;
    std::set<std::string> _active; ///< instancers being expanded, against cycles
    Hierarchy _result;
};

} // namespace

void ForEachPlacement(const SceneDescription& scene, const Placement& placement,
                      const std::function<void(const glm::dmat4&)>& onPlacement) {
    for (const Placed& placed : PlacementsOf(scene, placement, Shutter(), 0)) {
        onPlacement(placed.worldFromObject.AtFrame());
    }
}

Hierarchy BuildHierarchy(const SceneDescription& scene, const std::vector<DrawnLeaf>& leaves,
                         const glm::dvec3& centre, std::uint32_t firstGroup, LightLinks* links,
                         const Shutter& shutter, Warnings& warnings) {
    return Builder(scene, leaves, centre, firstGroup, links, shutter, warnings).Build();
}

} // namespace hds
