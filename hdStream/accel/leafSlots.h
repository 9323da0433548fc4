// SPDX-License-Identifier: Apache-2.0
// The leaf slots of a compressed BVH (kernels/shared/bvhNode.h), from its root down.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "kernels/shared/bvhNode.h"

#include <cstdint>
#include <vector>

namespace hds {

/// Calls visit(node, slot, firstItem, numItems) for each slot that holds items. Items count from
/// the BVH's item base. The order is always the same: depth first.
/// \param nodes of the BVH; there is a root.
template <typename Visit>
void ForEachLeafSlot(const shared::HdsBvhNode* nodes, const Visit& visit) {
    std::vector<std::uint32_t> stack = {0};
    while (!stack.empty()) {
        const shared::HdsBvhNode& node = nodes[stack.back()];
        stack.pop_back();
        std::uint32_t child = node.childBase;
        for (int slot = 0; slot < 8; ++slot) {
            const std::uint32_t meta = node.meta[slot / 4] >> (8 * (slot % 4)) & 0xffU;
            if ((node.exponentsImask >> (24 + slot) & 1U) != 0) {
                stack.push_back(child++);
            } else if (meta != 0) {
                const std::uint32_t unary = meta >> 5U; // 001, 011 or 111
                const std::uint32_t numItems = (unary & 1U) + (unary >> 1U & 1U) + (unary >> 2U);
                visit(node, slot, node.itemBase + (meta & 31U), numItems);
            }
        }
    }
}

} // namespace hds
