// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/flatTree.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/accel/objectNumber.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace hds {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::size_t kGrain = 1024; ///< leaves of a task

/// Of a leaf, whatever it holds, relative to that of a node.
constexpr float kLeafCost = 1.0F;

void AddTriangle(const PageParts& page, std::uint32_t triangle, shared::HdsFlatLeaf* leaf) {
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

} // namespace

void FlatTree::AddMesh(const FlatSource& source, std::uint32_t place,
                       const FlatPlacement& placement) {
    const shared::HdsObject object = ObjectOf(*source.objects, placement.object);
    for (std::uint32_t i = 0; i < object.numItems; ++i) {
        const std::uint32_t chunk = object.itemBase + i;
        const std::uint8_t* page = source.page(chunk);
        _units.push_back({place, chunk, page, &placement, {}, 0});
        _numTriangles += NumPrimitivesOfPage(page);
    }
}

bool FlatTree::Build() {
    PlanLeaves();
    MakeItems();
    if (_refs.empty()) {
        return false;
    }
    _binary = BuildBinaryBvh(_refs, false);
    BvhOptions options;
    options.maxLeafItems = HDS_FLAT_TRIANGLES;
    options.itemCost = kLeafCost;
    options.unitOfItem = _unitOfItem.data();
    options.sizeOfItem = _sizeOfItem.data();
    return EmitNodes(CollapsePlan(_binary, options));
}

void FlatTree::PlanLeaves() {
    tbb::parallel_for(std::size_t{0}, _units.size(), [&](std::size_t index) {
        Unit& unit = _units[index];
        unit.leaves = PlanFlatLeaves(PageParts(unit.page), *unit.placement);
    });
    std::size_t numItems = 0;
    for (Unit& unit : _units) {
        unit.firstItem = numItems;
        numItems += unit.leaves.size();
    }
    _triangles.resize(numItems);
}

void FlatTree::MakeItems() {
    std::vector<Bounds> bounds;
    for (const FlatBox& box : _boxes) {
        bounds.push_back(box.bounds);
    }
    const std::vector<BoxRef> boxes = MakeRefs(bounds);
    const std::size_t numLeaves = _triangles.size();
    _refs.resize(numLeaves + boxes.size());
    _unitOfItem.resize(_refs.size());
    _sizeOfItem.assign(_refs.size(), 1);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        _refs[numLeaves + i] = boxes[i];
        _refs[numLeaves + i].item = static_cast<std::uint32_t>(numLeaves + i);
        _unitOfItem[numLeaves + i] = static_cast<std::uint32_t>(_units.size() + i);
    }
    tbb::parallel_for(std::size_t{0}, _units.size(), [&](std::size_t index) {
        Unit& unit = _units[index];
        std::size_t item = unit.firstItem;
        for (const FlatLeafPlan& leaf : unit.leaves) {
            _refs[item] = leaf.box;
            _refs[item].item = static_cast<std::uint32_t>(item);
            _unitOfItem[item] = static_cast<std::uint32_t>(index);
            _sizeOfItem[item] = leaf.count;
            _triangles[item] = leaf.triangles;
            ++item;
        }
        unit.leaves = {};
    });
}

bool FlatTree::EmitNodes(const CollapsePlan& plan) {
    // What a ray of no direction meets in slots without a child.
    _leaves.push_back({0, 0});
    _nodes.reserve(_binary.count / 6 + 1);
    _leaves.reserve(_binary.count + 1);
    _nodes.emplace_back();
    std::vector<Pending> stack = {{0, _binary.Root(), 1}};
    while (!stack.empty()) {
        const Pending next = stack.back();
        stack.pop_back();
        if (next.depth > HDS_BVH_MAX_DEPTH) {
            return false;
        }
        EmitNode(plan.Children(next.tree), next, &stack);
    }
    return true;
}

void FlatTree::EmitNode(CollapsedChildren children, const Pending& pending,
                        std::vector<Pending>* stack) {
    // Rays that anything stops take slots from the last one on: the largest boxes first.
    const auto area = [&](const CollapsedChild& child) {
        const BoxRef& box = _binary.Box(child.tree);
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
        const BoxRef& box = _binary.Box(child.tree);
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
        const std::uint32_t item = _binary.refs[child.tree.begin].item;
        if (item >= _triangles.size()) {
            node.child[slot] = _boxes[item - _triangles.size()].child;
        } else {
            node.child[slot] = HDS_FLAT_LEAF | static_cast<std::uint32_t>(_leaves.size());
            _leaves.push_back({child.tree.begin, child.tree.count});
        }
    }
    // The first child is written next.
    std::reverse(stack->begin() + static_cast<std::ptrdiff_t>(firstPushed), stack->end());
    _nodes[pending.node] = node;
}

shared::HdsFlatLeaf FlatTree::MakeLeaf(const PlannedLeaf& planned) const {
    shared::HdsFlatLeaf leaf{};
    const Unit& unit = _units[_unitOfItem[_binary.refs[planned.begin].item]];
    const PageParts page(unit.page);
    leaf.place = unit.place;
    leaf.chunk = unit.chunk;
    for (std::uint32_t i = 0; i < planned.count; ++i) {
        const std::uint32_t item = _binary.refs[planned.begin + i].item;
        for (std::uint32_t k = 0; k < _sizeOfItem[item]; ++k) {
            AddTriangle(page, _triangles[item][k], &leaf);
        }
    }
    return leaf;
}

void FlatTree::WriteNodes(std::uint32_t firstNode, std::uint32_t firstLeaf,
                          shared::HdsFlatNode* out) const {
    for (const shared::HdsFlatNode& own : _nodes) {
        shared::HdsFlatNode node = own;
        for (std::uint32_t& child : node.child) {
            const std::uint32_t kind = child & HDS_FLAT_KIND;
            if (kind == HDS_FLAT_NODE) {
                child += firstNode;
            } else if (kind == HDS_FLAT_LEAF && child != HDS_FLAT_LEAF) {
                child += firstLeaf;
            }
        }
        *out++ = node;
    }
}

void FlatTree::WriteLeaves(shared::HdsFlatLeaf* out) const {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(1, _leaves.size(), kGrain),
                      [&](const auto& range) {
                          for (std::size_t i = range.begin(); i != range.end(); ++i) {
                              out[i - 1] = MakeLeaf(_leaves[i]);
                          }
                      });
}

} // namespace hds
