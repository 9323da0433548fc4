// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/flatBvh.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/accel/collapseCost.h"
#include "hdStream/accel/flatLeaves.h"
#include "hdStream/accel/objectNumber.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>

namespace hds {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::size_t kGrain = 1024; ///< leaves of a task

/// Of a leaf, whatever it holds, relative to that of a node.
constexpr float kLeafCost = 1.0F;

/// A chunk in a place: the triangles of a leaf are of one.
struct Unit {
    std::uint32_t place = 0;
    std::uint32_t chunk = 0;
    const std::uint8_t* page = nullptr;
    std::vector<FlatLeafPlan> leaves; ///< until they are items
    std::size_t firstItem = 0;
};

/// A leaf before it is written: items refs[begin, begin + count).
struct PlannedLeaf {
    std::uint32_t begin;
    std::uint32_t count;
};

class FlatBuilder {
public:
    FlatBuilder(const FlatSource& source, FlatPlaces places)
        : _source(source), _places(std::move(places)) {}

    FlatBvh Build() {
        FlatBvh flat;
        ListUnits();
        std::vector<BoxRef> refs = MakeItems();
        if (refs.empty()) {
            return flat; // nothing is there, or too little would be flattened
        }
        const BinaryBvh binary = BuildBinaryBvh(refs, false);
        BvhOptions options;
        options.maxLeafItems = HDS_FLAT_TRIANGLES;
        options.itemCost = kLeafCost;
        options.unitOfItem = _unitOfItem.data();
        options.sizeOfItem = _sizeOfItem.data();
        const CollapsePlan plan(binary, options);
        if (!EmitNodes(binary, plan)) {
            return flat; // too deep for the stacks
        }
        Write(binary, &flat);
        flat.numTriangles = _numTriangles;
        flat.hasInstances = !_places.instances.empty();
        return flat;
    }

private:
    void ListUnits() {
        for (std::uint32_t place = 0; place < _places.places.size(); ++place) {
            const shared::HdsObject object =
                ObjectOf(*_source.objects, _places.placements[place].object);
            for (std::uint32_t i = 0; i < object.numItems; ++i) {
                const std::uint32_t chunk = object.itemBase + i;
                const std::uint8_t* page = _source.page(chunk);
                _units.push_back({place, chunk, page, {}, 0});
                _numTriangles += NumPrimitivesOfPage(page);
            }
        }
        tbb::parallel_for(std::size_t{0}, _units.size(), [&](std::size_t index) {
            Unit& unit = _units[index];
            unit.leaves = PlanFlatLeaves(PageParts(unit.page), _places.placements[unit.place]);
        });
        std::size_t numItems = 0;
        for (Unit& unit : _units) {
            unit.firstItem = numItems;
            numItems += unit.leaves.size();
        }
        _triangles.resize(numItems);
    }

    /// References to the leaves of all pages, then to the instances that stay.
    std::vector<BoxRef> MakeItems() {
        std::vector<Bounds> boxes;
        for (const FlatInstance& instance : _places.instances) {
            boxes.push_back(instance.bounds);
        }
        const std::vector<BoxRef> instances = MakeRefs(boxes);
        const std::size_t numLeaves = _triangles.size();
        std::vector<BoxRef> refs(numLeaves + instances.size());
        _unitOfItem.resize(refs.size());
        _sizeOfItem.assign(refs.size(), 1);
        for (std::size_t i = 0; i < instances.size(); ++i) {
            refs[numLeaves + i] = instances[i];
            refs[numLeaves + i].item = static_cast<std::uint32_t>(numLeaves + i);
            _unitOfItem[numLeaves + i] = static_cast<std::uint32_t>(_units.size() + i);
        }
        tbb::parallel_for(std::size_t{0}, _units.size(), [&](std::size_t index) {
            Unit& unit = _units[index];
            std::size_t item = unit.firstItem;
            for (const FlatLeafPlan& leaf : unit.leaves) {
                refs[item] = leaf.box;
                refs[item].item = static_cast<std::uint32_t>(item);
                _unitOfItem[item] = static_cast<std::uint32_t>(index);
                _sizeOfItem[item] = leaf.count;
                _triangles[item] = leaf.triangles;
                ++item;
            }
            unit.leaves = {};
        });
        return refs;
    }

    struct Pending {
        std::uint32_t node; ///< to write
        BinarySubtree tree;
        std::uint32_t depth;
    };

    /// \return false when a path is longer than the stacks of kernels are.
    bool EmitNodes(const BinaryBvh& binary, const CollapsePlan& plan) {
        // What a ray of no direction meets in slots without a child.
        _leaves.push_back({0, 0});
        if (_places.places.empty()) {
            _places.places.emplace_back();
        }
        _nodes.reserve(binary.count / 6 + 1);
        _leaves.reserve(binary.count + 1);
        _nodes.emplace_back();
        std::vector<Pending> stack = {{0, binary.Root(), 1}};
        while (!stack.empty()) {
            const Pending next = stack.back();
            stack.pop_back();
            if (next.depth > HDS_BVH_MAX_DEPTH) {
                return false;
            }
            EmitNode(binary, plan.Children(next.tree), next, &stack);
        }
        return true;
    }

    /// HdsFlatNode.child of an instance.
    static std::uint32_t ChildOf(std::uint32_t record) {
        return HDS_FLAT_INSTANCE | ((record & HDS_RECORD_IN_CHUNK) != 0
                                        ? HDS_FLAT_IN_CHUNK | (record & ~HDS_RECORD_IN_CHUNK)
                                        : record);
    }

    void EmitNode(const BinaryBvh& binary, CollapsedChildren children, const Pending& pending,
                  std::vector<Pending>* stack) {
        // Rays that anything stops take slots from the last one on: the largest boxes first.
        const auto area = [&](const CollapsedChild& child) {
            const BoxRef& box = binary.Box(child.tree);
            return HalfArea(LoadBox(box.lo), LoadBox(box.hi));
        };
        std::stable_sort(
            children.child.begin(), children.child.begin() + children.count,
            [&](const CollapsedChild& a, const CollapsedChild& b) { return area(a) < area(b); });
        shared::HdsFlatNode node{};
        for (int axis = 0; axis < 3; ++axis) {
            std::fill_n(node.lo[axis], kWidth, kInfinity);
            std::fill_n(node.hi[axis], kWidth, -kInfinity);
        }
        std::fill_n(node.child, kWidth, HDS_FLAT_LEAF); // the one of nothing
        const std::size_t firstPushed = stack->size();
        for (int slot = 0; slot < children.count; ++slot) {
            const CollapsedChild& child = children.child[slot];
            const BoxRef& box = binary.Box(child.tree);
            for (int axis = 0; axis < 3; ++axis) {
                node.lo[axis][slot] = box.lo[axis];
                node.hi[axis][slot] = box.hi[axis];
            }
            if (!child.isLeaf) {
                node.child[slot] = HDS_FLAT_NODE | static_cast<std::uint32_t>(_nodes.size());
                stack->push_back({node.child[slot], child.tree, pending.depth + 1});
                _nodes.emplace_back();
                continue;
            }
            const std::uint32_t item = binary.refs[child.tree.begin].item;
            if (item >= _triangles.size()) {
                node.child[slot] = ChildOf(_places.instances[item - _triangles.size()].record);
            } else {
                node.child[slot] = HDS_FLAT_LEAF | static_cast<std::uint32_t>(_leaves.size());
                _leaves.push_back({child.tree.begin, child.tree.count});
            }
        }
        // The first child is written next.
        std::reverse(stack->begin() + static_cast<std::ptrdiff_t>(firstPushed), stack->end());
        _nodes[pending.node] = node;
    }

    static void AddTriangle(const PageParts& page, std::uint32_t triangle,
                            shared::HdsFlatLeaf* leaf) {
        const std::uint32_t lane = leaf->numTriangles++;
        leaf->triangle[lane] = triangle;
        leaf->primId[lane] = page.primIds[triangle];
        for (std::uint32_t corner = 0; corner < 3; ++corner) {
            const float* p = page.vertices + std::size_t{3} * page.Corner(triangle, corner);
            for (int axis = 0; axis < 3; ++axis) {
                leaf->positions[corner][axis][lane] = p[axis];
            }
        }
    }

    shared::HdsFlatLeaf MakeLeaf(const BinaryBvh& binary, const PlannedLeaf& planned) const {
        shared::HdsFlatLeaf leaf{};
        if (planned.count == 0) {
            return leaf;
        }
        const Unit& unit = _units[_unitOfItem[binary.refs[planned.begin].item]];
        const PageParts page(unit.page);
        leaf.place = unit.place;
        leaf.chunk = unit.chunk;
        for (std::uint32_t i = 0; i < planned.count; ++i) {
            const std::uint32_t item = binary.refs[planned.begin + i].item;
            for (std::uint32_t k = 0; k < _sizeOfItem[item]; ++k) {
                AddTriangle(page, _triangles[item][k], &leaf);
            }
        }
        return leaf;
    }

    void Write(const BinaryBvh& binary, FlatBvh* flat) const {
        std::uint64_t bytes = sizeof(shared::HdsFlatHeader);
        const auto place = [&](std::uint64_t partBytes) {
            const std::uint64_t offset = bytes;
            bytes +=
                (partBytes + HDS_FLAT_UNIT_BYTES - 1) / HDS_FLAT_UNIT_BYTES * HDS_FLAT_UNIT_BYTES;
            return static_cast<std::uint32_t>(offset / HDS_FLAT_UNIT_BYTES);
        };
        shared::HdsFlatHeader header{};
        place(_nodes.size() * sizeof(_nodes[0]));
        header.leaves = place(_leaves.size() * sizeof(shared::HdsFlatLeaf));
        header.places = place(_places.places.size() * sizeof(_places.places[0]));
        header.transforms = place(_places.transforms.size() * sizeof(_places.transforms[0]));
        flat->buffer.resize(bytes);
        std::uint8_t* data = flat->buffer.data();
        std::memcpy(data, &header, sizeof(header));
        std::memcpy(data + sizeof(header), _nodes.data(), _nodes.size() * sizeof(_nodes[0]));
        const auto part = [&](std::uint32_t offset) {
            return data + std::size_t{offset} * HDS_FLAT_UNIT_BYTES;
        };
        std::memcpy(part(header.places), _places.places.data(),
                    _places.places.size() * sizeof(_places.places[0]));
        std::memcpy(part(header.transforms), _places.transforms.data(),
                    _places.transforms.size() * sizeof(_places.transforms[0]));
        std::uint8_t* leaves = part(header.leaves);
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, _leaves.size(), kGrain),
                          [&](const auto& range) {
                              for (std::size_t i = range.begin(); i != range.end(); ++i) {
                                  const shared::HdsFlatLeaf leaf = MakeLeaf(binary, _leaves[i]);
                                  std::memcpy(leaves + i * sizeof(leaf), &leaf, sizeof(leaf));
                              }
                          });
    }

    const FlatSource& _source;
    FlatPlaces _places;
    std::vector<Unit> _units;
    // Of the items:
    std::vector<std::uint32_t> _unitOfItem;
    std::vector<std::uint8_t> _sizeOfItem; ///< triangles
    std::vector<FlatTriangles> _triangles; ///< of those that are leaves of pages
    std::uint64_t _numTriangles = 0;
    std::vector<shared::HdsFlatNode> _nodes;
    std::vector<PlannedLeaf> _leaves;
};

} // namespace

FlatBvh BuildFlatBvh(const FlatSource& source, const FlatAmount& amount) {
    return FlatBuilder(source, FindFlatPlaces(source, amount)).Build();
}

} // namespace hds
