// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/wideBvh.h"

#include "hdStream/accel/collapseCost.h"
#include "hdStream/accel/nodeQuantise.h"
#include "hdStream/base/error.h"

#include <algorithm>
#include <cstring>
#include <optional>

namespace hds {
namespace {

/// Writes wide nodes in depth-first order, the children of a node next to each other.
class WideEmitter {
public:
    /// \param plan null: balanced children.
    WideEmitter(const std::vector<BoxRef>& refs, const std::vector<BinaryNode>& binary,
                const CollapsePlan* plan, std::uint32_t maxLeafItems)
        : _refs(refs), _binary(binary), _plan(plan), _maxLeafItems(maxLeafItems) {}

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

    SlotBox Box(std::uint32_t node) const {
        SlotBox box{};
        Store(box.lo, LoadBox(_binary[node].lo));
        Store(box.hi, LoadBox(_binary[node].hi));
        return box;
    }

    void EmitNode(const Pending& pending, Bvh* bvh, std::vector<Pending>* stack) {
        const CollapsedChildren children =
            _plan != nullptr
                ? _plan->Children(pending.binary, pending.begin)
                : GatherBalanced(_binary, pending.binary, pending.begin, _maxLeafItems);
        const SlotBox parent = Box(pending.binary);
        std::array<SlotBox, 8> boxes{};
        for (int c = 0; c < children.count; ++c) {
            boxes[c] = Box(children.child[c].node);
        }
        const std::array<int, 8> slotOf = AssignSlots(parent, boxes, children.count);
        std::array<const CollapsedChild*, 8> bySlot{};
        std::array<SlotBox, 8> slotBoxes{};
        std::uint32_t slotMask = 0;
        for (int c = 0; c < children.count; ++c) {
            bySlot[slotOf[c]] = &children.child[c];
            slotBoxes[slotOf[c]] = boxes[c];
            slotMask |= 1U << slotOf[c];
        }
        shared::HdsBvhNode node{};
        node.childBase = static_cast<std::uint32_t>(bvh->nodes.size());
        node.itemBase = static_cast<std::uint32_t>(bvh->order.size());
        FillSlots(bySlot, &node, bvh);
        QuantiseNode(parent, slotBoxes, slotMask, &node);
        PushInner(pending, bySlot, bvh, stack);
        bvh->nodes[pending.wide] = node;
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
};

} // namespace

Bvh BuildWideBvh(std::vector<BoxRef>& refs, const BvhOptions& options) {
    HDS_VERIFY(options.maxLeafItems >= 1 && options.maxLeafItems <= HDS_BVH_MAX_LEAF_ITEMS,
               std::to_string(options.maxLeafItems));
    Bvh bvh;
    if (refs.empty()) {
        return bvh;
    }
    std::uint32_t depth = 0;
    {
        const std::vector<BinaryNode> binary = BuildBinaryBvh(refs, false);
        const CollapsePlan plan(binary, options);
        depth = WideEmitter(refs, binary, &plan, options.maxLeafItems).Emit(&bvh);
        const BinaryNode& root = binary[0];
        bvh.bounds = {{root.lo[0], root.lo[1], root.lo[2]}, {root.hi[0], root.hi[1], root.hi[2]}};
    }
    if (depth > HDS_BVH_MAX_DEPTH) {
        bvh.nodes.clear();
        bvh.order.clear();
        const std::vector<BinaryNode> binary = BuildBinaryBvh(refs, true);
        depth = WideEmitter(refs, binary, nullptr, options.maxLeafItems).Emit(&bvh);
        HDS_VERIFY(depth <= HDS_BVH_MAX_DEPTH, std::to_string(depth));
    }
    return bvh;
}

} // namespace hds
