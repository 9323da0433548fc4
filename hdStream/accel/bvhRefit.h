// SPDX-License-Identifier: Apache-2.0
// Gives items of a finished BVH other boxes, and takes items out and in again: only the nodes above
// them are quantised anew. The tree keeps its shape, so the wider items move, the more nodes a ray
// visits; what it hits is the same. Explained in docs/accel.md, "Refitting".
#pragma once

#include "hdStream/geometry/chunkSource.h"
#include "kernels/shared/bvhNode.h"

#include <array>
#include <cstdint>
#include <set>
#include <vector>

namespace hds {

/// Externally synchronised.
class BvhRefit {
public:
    /// \param nodes a BVH with boxes at rest, root first, a single item in each leaf slot. Boxes
    /// are taken from its planes, which contain those that it was built of.
    BvhRefit(const shared::HdsBvhNode* nodes, std::uint32_t numNodes, std::uint32_t numItems);

    /// \param box empty (min > max): no ray finds the item.
    void Set(std::uint32_t item, const Bounds& box);

    /// Writes what has changed since the last call. \param nodes those of the constructor, as this
    /// has left them. \return which were written, ascending.
    std::vector<std::uint32_t> Write(shared::HdsBvhNode* nodes);

    /// The area of all nodes, over what it was in the tree as built: about how many more of them
    /// rays visit. As of the last Write.
    double Growth() const { return _area / _areaAsBuilt; }

private:
    /// A node with the boxes of its slots.
    struct Node {
        std::array<Bounds, 8> boxes{};
        std::uint32_t meta[2] = {0, 0}; ///< as built
        std::uint8_t present = 0;       ///< slots that hold something to hit
        std::uint8_t slotInParent = 0;
        std::uint32_t parent = HDS_NONE;
    };
    struct Place {
        std::uint32_t node = HDS_NONE;
        std::uint8_t slot = 0;
    };

    void ReadNode(const shared::HdsBvhNode& read, std::uint32_t index);
    void Put(std::uint32_t node, std::uint32_t slot, const Bounds& box, bool isPresent);
    static Bounds BoxOf(const Node& node);
    static double AreaOf(const Node& node);

    std::vector<Node> _nodes;
    std::vector<Place> _places; ///< of the items
    std::set<std::uint32_t> _changed;
    double _areaAsBuilt = 0.0;
    double _area = 0.0;
};

} // namespace hds
