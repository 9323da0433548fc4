// SPDX-License-Identifier: Apache-2.0
// One tree of the flat hierarchy: that in world space, or that of a mesh with many copies.
// Private to the layer. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/binaryBvh.h"
#include "hdStream/accel/collapseCost.h"
#include "hdStream/accel/flatLeaves.h"
#include "hdStream/accel/flatPlaces.h"

#include <cstdint>
#include <vector>

namespace hds {

/// What a tree has a box for, beside triangles.
struct FlatBox {
    std::uint32_t child = 0; ///< HdsFlatNode.child
    Bounds bounds;           ///< widened
};

/// Numbers of nodes and leaves count from the tree's own first ones; leaf 0 is that of nothing.
class FlatTree {
public:
    /// Adds a mesh. \param place to which its leaves belong. \param placement must outlive the
    /// tree.
    void AddMesh(const FlatSource& source, std::uint32_t place, const FlatPlacement& placement);
    void AddBox(const FlatBox& box) { _boxes.push_back(box); }

    /// Uses all cores. \return whether there is a tree: something was added, and no path is longer
    /// than the stacks of kernels are.
    bool Build();

    std::uint64_t NumTriangles() const { return _numTriangles; }
    std::size_t NumNodes() const { return _nodes.size(); }
    std::size_t NumLeaves() const { return _leaves.size(); }
    /// Writes the nodes, root first. \param firstNode, firstLeaf what is added to the numbers of
    /// nodes, and of leaves but that of nothing.
    void WriteNodes(std::uint32_t firstNode, std::uint32_t firstLeaf,
                    shared::HdsFlatNode* out) const;
    /// Writes the leaves but that of nothing. Uses all cores.
    void WriteLeaves(shared::HdsFlatLeaf* out) const;

private:
    /// A chunk in a place: the triangles of a leaf are of one.
    struct Unit {
        std::uint32_t place = 0;
        std::uint32_t chunk = 0;
        const std::uint8_t* page = nullptr;
        const FlatPlacement* placement = nullptr;
        std::vector<FlatLeafPlan> leaves; ///< until they are items
        std::size_t firstItem = 0;
    };
    /// A leaf before it is written: items refs[begin, begin + count).
    struct PlannedLeaf {
        std::uint32_t begin;
        std::uint32_t count;
    };
    struct Pending {
        std::uint32_t node; ///< to write
        BinarySubtree tree;
        std::uint32_t depth;
    };

    void PlanLeaves();
    void MakeItems();
    bool EmitNodes(const CollapsePlan& plan);
    void EmitNode(CollapsedChildren children, const Pending& pending, std::vector<Pending>* stack);
    shared::HdsFlatLeaf MakeLeaf(const PlannedLeaf& planned) const;

    std::vector<Unit> _units;
    std::vector<FlatBox> _boxes;
    std::uint64_t _numTriangles = 0;
    // Of the items, which are leaves of pages, then boxes:
    std::vector<BoxRef> _refs;
    std::vector<std::uint32_t> _unitOfItem;
    std::vector<std::uint8_t> _sizeOfItem; ///< triangles
    std::vector<FlatTriangles> _triangles; ///< of those that are leaves of pages
    BinaryBvh _binary;
    std::vector<shared::HdsFlatNode> _nodes;
    std::vector<PlannedLeaf> _leaves;
};

} // namespace hds
