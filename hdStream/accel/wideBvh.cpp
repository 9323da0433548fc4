// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/wideBvh.h"

#include "hdStream/accel/collapseCost.h"
#include "hdStream/accel/nodeQuantise.h"
#include "hdStream/base/error.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cstring>
#include <optional>

namespace hds {
namespace {

/// The nodes of a binary tree with their boxes when the shutter opens and when it closes.
struct BothPoses {
    std::vector<BinaryNode> open;
    std::vector<BinaryNode> close;
};

Bounds BoundsOf(const BinaryNode& node) {
    return {{node.lo[0], node.lo[1], node.lo[2]}, {node.hi[0], node.hi[1], node.hi[2]}};
}

Bounds Union(const Bounds& a, const Bounds& b) {
    return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

/// Writes wide nodes in depth-first order, the children of a node next to each other.
class WideEmitter {
public:
    /// \param plan null: balanced children. \param poses null: boxes do not move.
    WideEmitter(const std::vector<BoxRef>& refs, const std::vector<BinaryNode>& binary,
                const CollapsePlan* plan, std::uint32_t maxLeafItems, const BothPoses* poses)
        : _refs(refs), _binary(binary), _plan(plan), _maxLeafItems(maxLeafItems), _poses(poses) {}

    /// \return nodes on the longest path from the root.
    std::uint32_t Emit(Bvh* bvh) {
        bvh->order.reserve(_refs.size());
        bvh->nodes.reserve(_refs.size() / 3 + 1);
        bvh->nodes.emplace_back();
        std::vector<Pending> stack = {{0, 0, 0, 1}};
        std::uint32_t maxDepth = 0;
        while (!stack.empty()) {
            const Pending next = stack.back();
            stack.pop_back();
            maxDepth = std::max(maxDepth, next.depth);
            EmitNode(next, bvh, &stack);
        }
        return maxDepth;
    }

private:
    struct Pending {
        std::uint32_t wide;   ///< node to write
        std::uint32_t binary; ///< subtree that it stands for
        std::uint32_t begin;  ///< first reference of the subtree
        std::uint32_t depth;
    };

    /// \param binary the tree's nodes, with their boxes at some time.
    static SlotBox Box(const std::vector<BinaryNode>& binary, std::uint32_t node) {
        SlotBox box{};
        Store(box.lo, LoadBox(binary[node].lo));
        Store(box.hi, LoadBox(binary[node].hi));
        return box;
    }

    void EmitNode(const Pending& pending, Bvh* bvh, std::vector<Pending>* stack) {
        const CollapsedChildren children =
            _plan != nullptr
                ? _plan->Children(pending.binary, pending.begin)
                : GatherBalanced(_binary, pending.binary, pending.begin, _maxLeafItems);
        std::array<SlotBox, 8> boxes{};
        for (int c = 0; c < children.count; ++c) {
            boxes[c] = Box(_binary, children.child[c].node);
        }
        const std::array<int, 8> slotOf =
            AssignSlots(Box(_binary, pending.binary), boxes, children.count);
        std::array<const CollapsedChild*, 8> bySlot{};
        for (int c = 0; c < children.count; ++c) {
            bySlot[slotOf[c]] = &children.child[c];
        }
        shared::HdsBvhNode node{};
        node.childBase = static_cast<std::uint32_t>(bvh->nodes.size());
        node.itemBase = static_cast<std::uint32_t>(bvh->order.size());
        FillSlots(bySlot, &node, bvh);
        PushInner(pending, bySlot, bvh, stack);
        WriteBoxes(_poses != nullptr ? _poses->open : _binary, pending.binary, bySlot, &node);
        bvh->nodes[pending.wide] = node;
        if (_poses != nullptr) {
            WriteBoxes(_poses->close, pending.binary, bySlot, &node);
            bvh->closeNodes.resize(bvh->nodes.size());
            bvh->closeNodes[pending.wide] = node;
        }
    }

    static void WriteBoxes(const std::vector<BinaryNode>& binary, std::uint32_t parent,
                           const std::array<const CollapsedChild*, 8>& bySlot,
                           shared::HdsBvhNode* node) {
        std::array<SlotBox, 8> boxes{};
        std::uint32_t slotMask = 0;
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            if (bySlot[slot] != nullptr) {
                boxes[slot] = Box(binary, bySlot[slot]->node);
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
                const std::uint32_t count = _binary[child->node].count;
                const auto offset = static_cast<std::uint32_t>(bvh->order.size()) - node->itemBase;
                meta = ((1U << count) - 1U) << 5U | offset;
                for (std::uint32_t i = 0; i < count; ++i) {
                    bvh->order.push_back(_refs[child->begin + i].item);
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
                stack->push_back({wide++, child->node, child->begin, pending.depth + 1});
            }
        }
        bvh->nodes.resize(wide);
        // The first child is written next.
        std::reverse(stack->begin() + static_cast<std::ptrdiff_t>(first), stack->end());
    }

    const std::vector<BoxRef>& _refs;
    const std::vector<BinaryNode>& _binary;
    const CollapsePlan* _plan;
    std::uint32_t _maxLeafItems;
    const BothPoses* _poses;
};

/// The nodes with the boxes that `items` have. \param refs the leaves, from left to right.
std::vector<BinaryNode> WithBoxesOf(const std::vector<BoxRef>& items,
                                    const std::vector<BoxRef>& refs,
                                    std::vector<BinaryNode> nodes) {
    std::size_t leaf = refs.size();
    for (std::size_t i = nodes.size(); i-- > 0;) { // children come after their parents
        BinaryNode& node = nodes[i];
        const std::uint32_t count = node.count;
        const std::uint32_t right = node.right;
        if (count == 1) {
            const BoxRef& item = items[refs[--leaf].item];
            Store(node.lo, LoadBox(item.lo));
            Store(node.hi, LoadBox(item.hi));
        } else {
            Store(node.lo, Min(LoadBox(nodes[i + 1].lo), LoadBox(nodes[i + right].lo)));
            Store(node.hi, Max(LoadBox(nodes[i + 1].hi), LoadBox(nodes[i + right].hi)));
        }
        node.count = count; // four lanes were stored
        node.right = right;
    }
    return nodes;
}

struct BothBoxes {
    const std::vector<BoxRef>& open;
    const std::vector<BoxRef>& close;
};

/// \param moving null: `refs` are where they are.
Bvh BuildFrom(std::vector<BoxRef>& refs, const BothBoxes* moving, const BvhOptions& options) {
    HDS_VERIFY(options.maxLeafItems >= 1 && options.maxLeafItems <= HDS_BVH_MAX_LEAF_ITEMS,
               std::to_string(options.maxLeafItems));
    Bvh bvh;
    if (refs.empty()) {
        return bvh;
    }
    const auto emit = [&](const std::vector<BinaryNode>& binary, const CollapsePlan* plan) {
        std::optional<BothPoses> poses;
        if (moving != nullptr) {
            poses.emplace(BothPoses{WithBoxesOf(moving->open, refs, binary),
                                    WithBoxesOf(moving->close, refs, binary)});
            bvh.bounds = Union(BoundsOf(poses->open[0]), BoundsOf(poses->close[0]));
        } else {
            bvh.bounds = BoundsOf(binary[0]);
        }
        return WideEmitter(refs, binary, plan, options.maxLeafItems, poses ? &*poses : nullptr)
            .Emit(&bvh);
    };
    std::uint32_t depth = 0;
    {
        const std::vector<BinaryNode> binary = BuildBinaryBvh(refs, false);
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
    return BuildFrom(refs, nullptr, options);
}

Bvh BuildWideBvh(const std::vector<BoxRef>& open, const std::vector<BoxRef>& close,
                 const BvhOptions& options) {
    std::vector<BoxRef> refs = open;
    for (std::size_t i = 0; i < refs.size(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            // Halved before adding, so that they cannot overflow.
            refs[i].lo[axis] = 0.5F * open[i].lo[axis] + 0.5F * close[i].lo[axis] + 0.0F;
            refs[i].hi[axis] = 0.5F * open[i].hi[axis] + 0.5F * close[i].hi[axis] + 0.0F;
        }
    }
    const BothBoxes moving{open, close};
    return BuildFrom(refs, &moving, options);
}

} // namespace hds
