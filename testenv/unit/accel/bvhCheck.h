// SPDX-License-Identifier: Apache-2.0
// Walks a finished BVH and checks every invariant of the node format against the items' true boxes,
// decoding nodes on its own (not with the builder's functions).
#pragma once

#include "hdStream/accel/bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace hds::test {

/// What a walk found.
struct BvhFacts {
    std::uint32_t depth = 0; ///< nodes on the longest path
    std::vector<std::uint32_t>
        timesSeen;                  ///< [numItems] leaf references of each position of the order
    std::uint64_t numOutside = 0;   ///< items that stick out of a box above them
    std::uint64_t numMalformed = 0; ///< meta bytes or indices that break the format
    std::uint64_t numClosed = 0;    ///< inner children that no ray visits (BvhRefit)
};

class BvhWalker {
public:
    /// \param boxes true boxes in leaf order.
    BvhWalker(const std::vector<shared::HdsBvhNode>& nodes, const std::vector<Bounds>& boxes)
        : _nodes(nodes), _boxes(boxes) {
        _facts.timesSeen.resize(boxes.size());
    }

    BvhFacts Walk() {
        if (!_nodes.empty()) {
            VisitNode(0, 1);
        }
        return _facts;
    }

private:
    std::uint32_t MetaByte(const shared::HdsBvhNode& node, std::uint32_t slot) const {
        return node.meta[slot / 4] >> (8 * (slot % 4)) & 0xffU;
    }

    /// Whether the slot's decoded box contains an item. long double: exact for these sums.
    bool Contains(const shared::HdsBvhNode& node, std::uint32_t slot, const Bounds& box) const {
        for (int axis = 0; axis < 3; ++axis) {
            const int exponent = static_cast<int>(node.exponentsImask >> (8 * axis) & 0xffU) - 127;
            const long double scale = std::ldexp(1.0L, exponent);
            const auto lo = node.qlo[axis][slot / 4] >> (8 * (slot % 4)) & 0xffU;
            const auto hi = node.qhi[axis][slot / 4] >> (8 * (slot % 4)) & 0xffU;
            const long double origin = node.origin[axis];
            if (scale * lo > static_cast<long double>(box.min[axis]) - origin ||
                scale * hi < static_cast<long double>(box.max[axis]) - origin) {
                return false;
            }
        }
        return true;
    }

    /// \return range of the order below the node, as pairs of positions that were seen.
    std::vector<std::uint32_t> VisitNode(std::uint32_t index, std::uint32_t depth) {
        _facts.depth = std::max(_facts.depth, depth);
        std::vector<std::uint32_t> below;
        if (index >= _nodes.size() || depth > 200) {
            ++_facts.numMalformed;
            return below;
        }
        const shared::HdsBvhNode& node = _nodes[index];
        std::uint32_t child = node.childBase;
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            const std::uint32_t meta = MetaByte(node, slot);
            const bool isInner = (node.exponentsImask >> (24 + slot) & 1U) != 0;
            std::vector<std::uint32_t> items;
            if (isInner && meta == 0) {
                ++_facts.numClosed;
                ++child;
            } else if (isInner) {
                _facts.numMalformed += meta != (0x20U | (24 + slot)) ? 1 : 0;
                items = VisitNode(child++, depth + 1);
            } else if (meta != 0) {
                items = LeafItems(node, meta);
            }
            for (const std::uint32_t item : items) {
                _facts.numOutside += Contains(node, slot, _boxes[item]) ? 0 : 1;
            }
            below.insert(below.end(), items.begin(), items.end());
        }
        return below;
    }

    std::vector<std::uint32_t> LeafItems(const shared::HdsBvhNode& node, std::uint32_t meta) {
        const std::uint32_t unary = meta >> 5U;
        const std::uint32_t count = unary == 1 ? 1 : (unary == 3 ? 2 : (unary == 7 ? 3 : 0));
        const std::uint32_t offset = meta & 31U;
        _facts.numMalformed += count == 0 || offset + count > 24 ? 1 : 0;
        std::vector<std::uint32_t> items;
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t item = node.itemBase + offset + i;
            if (item >= _boxes.size()) {
                ++_facts.numMalformed;
                continue;
            }
            ++_facts.timesSeen[item];
            items.push_back(item);
        }
        return items;
    }

    const std::vector<shared::HdsBvhNode>& _nodes;
    const std::vector<Bounds>& _boxes;
    BvhFacts _facts;
};

/// Fails the test unless the BVH is well formed, conservative and holds every item once.
inline void ExpectSound(const Bvh& bvh, const std::vector<Bounds>& items) {
    ASSERT_EQ(bvh.order.size(), items.size());
    std::vector<std::uint32_t> timesOrdered(items.size());
    std::vector<Bounds> inOrder;
    for (const std::uint32_t item : bvh.order) {
        ASSERT_LT(item, items.size());
        ++timesOrdered[item];
        inOrder.push_back(items[item]);
    }
    const BvhFacts facts = BvhWalker(bvh.nodes, inOrder).Walk();
    EXPECT_EQ(facts.numMalformed, 0U);
    EXPECT_EQ(facts.numOutside, 0U);
    EXPECT_EQ(facts.numClosed, 0U);
    EXPECT_LE(facts.depth, static_cast<std::uint32_t>(HDS_BVH_MAX_DEPTH));
    for (std::size_t i = 0; i < items.size(); ++i) {
        ASSERT_EQ(timesOrdered[i], 1U) << i;
        ASSERT_EQ(facts.timesSeen[i], 1U) << i;
    }
}

} // namespace hds::test
