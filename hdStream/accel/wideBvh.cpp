// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/wideBvh.h"

#include "hdStream/accel/collapseCost.h"
#include "hdStream/accel/nodeQuantise.h"
#include "hdStream/base/error.h"

#include <glm/common.hpp>

#include <algorithm>
#include <memory>

namespace hds {
namespace {

/// A binary tree with the boxes of its items at some time.
struct Pose {
    std::vector<BoxRef> refs;
    BinaryBvh tree;
};

Bounds BoundsOf(const BinaryBvh& tree) {
    const BoxRef& box = tree.Box(tree.Root());
    return {{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}};
}

Bounds Union(const Bounds& a, const Bounds& b) {
    return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

/// Writes wide nodes in depth-first order, the children of a node next to each other.
class WideEmitter {
public:
    /// \param plan null: balanced children. \param poses empty: boxes do not move.
    WideEmitter(const BinaryBvh& binary, const CollapsePlan* plan, std::uint32_t maxLeafItems,
                const std::vector<Pose>& poses)
        : _binary(binary), _plan(plan), _maxLeafItems(maxLeafItems), _poses(poses),
          _later(poses.empty() ? 0 : poses.size() - 1) {}

    /// \return nodes on the longest path from the root.
    std::uint32_t Emit(Bvh* bvh) {
        bvh->order.reserve(_binary.count);
        bvh->nodes.reserve(_binary.count / 3 + 1);
        bvh->nodes.emplace_back();
        std::vector<Pending> stack = {{0, _binary.Root(), 1}};
        std::uint32_t maxDepth = 0;
        while (!stack.empty()) {
            const Pending next = stack.back();
            stack.pop_back();
            maxDepth = std::max(maxDepth, next.depth);
            EmitNode(next, bvh, &stack);
        }
        for (const std::vector<shared::HdsBvhNode>& nodes : _later) {
            bvh->laterNodes.insert(bvh->laterNodes.end(), nodes.begin(), nodes.end());
        }
        return maxDepth;
    }

private:
    struct Pending {
        std::uint32_t wide; ///< node to write
        BinarySubtree tree; ///< that it stands for
        std::uint32_t depth;
    };

    /// \param binary the tree, with its boxes at some time.
    static SlotBox Box(const BinaryBvh& binary, const BinarySubtree& tree) {
        const BoxRef& ref = binary.Box(tree);
        SlotBox box{};
        Store(box.lo, LoadBox(ref.lo));
        Store(box.hi, LoadBox(ref.hi));
        return box;
    }

    void EmitNode(const Pending& pending, Bvh* bvh, std::vector<Pending>* stack) {
        const CollapsedChildren children =
            _plan != nullptr ? _plan->Children(pending.tree)
                             : GatherBalanced(_binary, pending.tree, _maxLeafItems);
        std::array<SlotBox, 8> boxes{};
        for (int c = 0; c < children.count; ++c) {
            boxes[c] = Box(_binary, children.child[c].tree);
        }
        const std::array<int, 8> slotOf =
            AssignSlots(Box(_binary, pending.tree), boxes, children.count);
        std::array<const CollapsedChild*, 8> bySlot{};
        for (int c = 0; c < children.count; ++c) {
            bySlot[slotOf[c]] = &children.child[c];
        }
        shared::HdsBvhNode node{};
        node.childBase = static_cast<std::uint32_t>(bvh->nodes.size());
        node.itemBase = static_cast<std::uint32_t>(bvh->order.size());
        FillSlots(bySlot, &node, bvh);
        PushInner(pending, bySlot, bvh, stack);
        WriteBoxes(_poses.empty() ? _binary : _poses[0].tree, pending.tree, bySlot, &node);
        bvh->nodes[pending.wide] = node;
        for (std::size_t i = 0; i < _later.size(); ++i) {
            WriteBoxes(_poses[i + 1].tree, pending.tree, bySlot, &node);
            _later[i].resize(bvh->nodes.size());
            _later[i][pending.wide] = node;
        }
    }

    static void WriteBoxes(const BinaryBvh& binary, const BinarySubtree& parent,
                           const std::array<const CollapsedChild*, 8>& bySlot,
                           shared::HdsBvhNode* node) {
        std::array<SlotBox, 8> boxes{};
        std::uint32_t slotMask = 0;
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            if (bySlot[slot] != nullptr) {
                boxes[slot] = Box(binary, bySlot[slot]->tree);
                slotMask |= 1U << slot;
            }
        }
        QuantiseNode(Box(binary, parent), boxes, slotMask, node);
    }

    /// Writes meta bytes and the imask; appends the items of leaf slots to the order.
    void FillSlots(const std::array<const CollapsedChild*, 8>& bySlot, shared::HdsBvhNode* node,
                   Bvh* bvh) const {
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            const CollapsedChild* child = bySlot[slot];
            if (child == nullptr) {
                continue;
            }
            std::uint32_t meta = 1U << 5U | (24U + slot);
            if (child->isLeaf) {
                const std::uint32_t count = child->tree.count;
                const auto offset = static_cast<std::uint32_t>(bvh->order.size()) - node->itemBase;
                meta = ((1U << count) - 1U) << 5U | offset;
                for (std::uint32_t i = 0; i < count; ++i) {
                    bvh->order.push_back(_binary.refs[child->tree.begin + i].item);
                }
            } else {
                node->exponentsImask |= 1U << (24U + slot);
            }
            node->meta[slot / 4] |= meta << (8 * (slot % 4));
        }
    }

    static void PushInner(const Pending& pending,
                          const std::array<const CollapsedChild*, 8>& bySlot, Bvh* bvh,
                          std::vector<Pending>* stack) {
        auto wide = static_cast<std::uint32_t>(bvh->nodes.size());
        const std::size_t first = stack->size();
        for (const CollapsedChild* child : bySlot) {
            if (child != nullptr && !child->isLeaf) {
                stack->push_back({wide++, child->tree, pending.depth + 1});
            }
        }
        bvh->nodes.resize(wide);
        // The first child is written next.
        std::reverse(stack->begin() + static_cast<std::ptrdiff_t>(first), stack->end());
    }

    const BinaryBvh& _binary;
    const CollapsePlan* _plan;
    std::uint32_t _maxLeafItems;
    const std::vector<Pose>& _poses;
    std::vector<std::vector<shared::HdsBvhNode>> _later; ///< nodes of the poses but the first
};

/// Gives the nodes of a subtree the boxes of the pose's items.
void Refit(Pose* pose, const BinarySubtree& tree) {
    if (tree.count == 1) {
        return;
    }
    const BinarySubtree left = pose->tree.Left(tree);
    const BinarySubtree right = pose->tree.Right(tree);
    Refit(pose, left);
    Refit(pose, right);
    const BoxRef& leftBox = pose->tree.Box(left);
    const BoxRef& rightBox = pose->tree.Box(right);
    BoxRef& node = pose->tree.nodes[tree.node];
    const std::uint32_t numLeft = node.item;
    Store(node.lo, Min(LoadBox(leftBox.lo), LoadBox(rightBox.lo)));
    Store(node.hi, Max(LoadBox(leftBox.hi), LoadBox(rightBox.hi)));
    node.item = numLeft; // four lanes were stored
}

/// The tree with the boxes that `items` have.
Pose WithBoxesOf(const std::vector<BoxRef>& items, const BinaryBvh& binary) {
    Pose pose;
    pose.refs.reserve(binary.count);
    for (std::uint32_t i = 0; i < binary.count; ++i) {
        pose.refs.push_back(items[binary.refs[i].item]);
    }
    pose.tree = {pose.refs.data(), std::make_unique<BoxRef[]>(binary.count), binary.count};
    std::copy_n(binary.nodes.get(), binary.count - 1, pose.tree.nodes.get());
    Refit(&pose, binary.Root());
    return pose;
}

/// \param keys boxes of the items over time; empty: they are where `refs` has them.
Bvh BuildFrom(std::vector<BoxRef>& refs, const std::vector<std::vector<BoxRef>>& keys,
              const BvhOptions& options) {
    HDS_VERIFY(options.maxLeafItems >= 1 && options.maxLeafItems <= HDS_BVH_MAX_LEAF_ITEMS,
               std::to_string(options.maxLeafItems));
    Bvh bvh;
    if (refs.empty()) {
        return bvh;
    }
    const auto emit = [&](const BinaryBvh& binary, const CollapsePlan* plan) {
        std::vector<Pose> poses;
        for (const std::vector<BoxRef>& key : keys) {
            poses.push_back(WithBoxesOf(key, binary));
            bvh.bounds = Union(bvh.bounds, BoundsOf(poses.back().tree));
        }
        if (keys.empty()) {
            bvh.bounds = BoundsOf(binary);
        }
        return WideEmitter(binary, plan, options.maxLeafItems, poses).Emit(&bvh);
    };
    std::uint32_t depth = 0;
    {
        const BinaryBvh binary = BuildBinaryBvh(refs, false);
        const CollapsePlan plan(binary, options);
        depth = emit(binary, &plan);
    }
    if (depth > HDS_BVH_MAX_DEPTH) {
        bvh = {};
        depth = emit(BuildBinaryBvh(refs, true), nullptr);
        HDS_VERIFY(depth <= HDS_BVH_MAX_DEPTH, std::to_string(depth));
    }
    return bvh;
}

} // namespace

Bvh BuildWideBvh(std::vector<BoxRef>& refs, const BvhOptions& options) {
    return BuildFrom(refs, {}, options);
}

Bvh BuildWideBvh(const std::vector<std::vector<BoxRef>>& keys, const BvhOptions& options) {
    std::vector<BoxRef> refs = keys.front();
    const float weight = 1.0F / static_cast<float>(keys.size()); // before adding: no overflow
    for (std::size_t i = 0; i < refs.size(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            refs[i].lo[axis] = refs[i].hi[axis] = 0.0F;
            for (const std::vector<BoxRef>& key : keys) {
                refs[i].lo[axis] += weight * key[i].lo[axis];
                refs[i].hi[axis] += weight * key[i].hi[axis];
            }
        }
    }
    return BuildFrom(refs, keys, options);
}

} // namespace hds
