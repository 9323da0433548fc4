// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/flatLeaves.h"

#include "hdStream/accel/leafSlots.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace hds {
namespace {

/// Corners of triangles in world space, by vertices.
class WorldCorners {
public:
    WorldCorners(const PageParts& page, const FlatPlacement& placement)
        : _positions(page.vertices), _stride(3) {
        if (placement.isInPlace) {
            return;
        }
        std::uint32_t numVertices = 0;
        for (std::uint32_t i = 0; i < page.numTriangles; ++i) {
            for (std::uint32_t corner = 0; corner < 3; ++corner) {
                numVertices = std::max(numVertices, page.Corner(i, corner) + 1);
            }
        }
        _moved.resize(std::size_t{4} * numVertices);
        for (std::uint32_t i = 0; i < numVertices; ++i) {
            const float* p = page.vertices + std::size_t{3} * i;
            const glm::dvec4 position(p[0], p[1], p[2], 1.0);
            const glm::dvec3 moved(placement.worldFromObject * position);
            for (int axis = 0; axis < 3; ++axis) {
                _moved[std::size_t{4} * i + axis] = static_cast<float>(moved[axis]);
            }
        }
        _positions = _moved.data();
        _stride = 4;
    }

    Float4 At(std::uint32_t vertex) const {
        return LoadPosition(_positions + std::size_t{_stride} * vertex);
    }

private:
    const float* _positions;
    std::uint32_t _stride;
    std::vector<float> _moved;
};

/// A leaf that others of its node may join.
struct OpenLeaf {
    Float4 lo;
    Float4 hi;
    float area;
    std::uint32_t count;
    FlatTriangles triangles;
};

class LeafPlanner {
public:
    LeafPlanner(const PageParts& page, const FlatPlacement& placement)
        : _page(page), _corners(page, placement),
          _margin(std::ldexp(1.0F, placement.marginExponent)) {}

    std::vector<FlatLeafPlan> Plan() {
        _leaves.reserve(_page.numTriangles / 2 + 1);
        const shared::HdsBvhNode* last = nullptr;
        ForEachLeafSlot(_page.nodes, [&](const shared::HdsBvhNode& node, int, std::uint32_t first,
                                         std::uint32_t count) {
            if (&node != last) {
                Close();
                last = &node;
            }
            Open(first, count);
        });
        Close();
        return std::move(_leaves);
    }

private:
    void Open(std::uint32_t first, std::uint32_t count) {
        OpenLeaf& leaf = _open[_numOpen++];
        leaf.lo = Splat(std::numeric_limits<float>::max());
        leaf.hi = Splat(-std::numeric_limits<float>::max());
        leaf.count = count;
        for (std::uint32_t i = 0; i < count; ++i) {
            leaf.triangles[i] = first + i;
            for (std::uint32_t corner = 0; corner < 3; ++corner) {
                const Float4 position = _corners.At(_page.Corner(first + i, corner));
                leaf.lo = Min(leaf.lo, position);
                leaf.hi = Max(leaf.hi, position);
            }
        }
        leaf.area = HalfArea(leaf.lo, leaf.hi);
    }

    /// Ends the leaves of a node.
    void Close() {
        Join();
        for (std::uint32_t i = 0; i < _numOpen; ++i) {
            const OpenLeaf& leaf = _open[i];
            const Float4 zero = Splat(0.0F);
            const Float4 far = Max(Max(leaf.hi, zero - leaf.lo), Max(leaf.lo, zero - leaf.hi));
            alignas(16) float sizes[4];
            Store(sizes, far);
            const Float4 margin = Splat(std::max({sizes[0], sizes[1], sizes[2]}) * _margin);
            FlatLeafPlan& plan = _leaves.emplace_back();
            Store(plan.box.lo, leaf.lo - margin + zero); // -0 becomes +0
            Store(plan.box.hi, leaf.hi + margin + zero);
            plan.triangles = leaf.triangles;
            plan.count = static_cast<std::uint8_t>(leaf.count);
        }
        _numOpen = 0;
    }

    /// Joins leaves as long as that lowers the sum of their areas: each is one test, whatever it
    /// holds.
    void Join() {
        while (true) {
            float most = 0.0F;
            OpenLeaf* into = nullptr;
            OpenLeaf* joined = nullptr;
            for (std::uint32_t a = 0; a < _numOpen; ++a) {
                OpenLeaf& one = _open[a];
                for (std::uint32_t b = a + 1; b < _numOpen; ++b) {
                    OpenLeaf& other = _open[b];
                    if (one.count + other.count > HDS_FLAT_TRIANGLES) {
                        continue;
                    }
                    const float saved = one.area + other.area -
                                        HalfArea(Min(one.lo, other.lo), Max(one.hi, other.hi));
                    if (saved > most) {
                        most = saved;
                        into = &one;
                        joined = &other;
                    }
                }
            }
            if (joined == nullptr) {
                return;
            }
            into->lo = Min(into->lo, joined->lo);
            into->hi = Max(into->hi, joined->hi);
            into->area = HalfArea(into->lo, into->hi);
            std::copy_n(joined->triangles.begin(), joined->count,
                        into->triangles.begin() + into->count);
            into->count += joined->count;
            *joined = _open[--_numOpen];
        }
    }

    const PageParts& _page;
    WorldCorners _corners;
    float _margin;
    std::array<OpenLeaf, 8> _open; ///< of the node that is visited
    std::uint32_t _numOpen = 0;
    std::vector<FlatLeafPlan> _leaves;
};

} // namespace

PageParts::PageParts(const std::uint8_t* page) {
    shared::HdsPageHeader header{};
    std::memcpy(&header, page, sizeof(header));
    const auto part = [&](std::uint32_t offset) {
        return page + std::size_t{offset} * HDS_POOL_UNIT_BYTES;
    };
    nodes = reinterpret_cast<const shared::HdsBvhNode*>(page + sizeof(header));
    triangles = reinterpret_cast<const shared::HdsTriangle*>(part(header.triangles));
    primIds = reinterpret_cast<const std::uint32_t*>(part(header.primIds));
    vertices = reinterpret_cast<const float*>(part(header.vertices));
    numTriangles = NumPrimitivesOfPage(page);
}

std::vector<FlatLeafPlan> PlanFlatLeaves(const PageParts& page, const FlatPlacement& placement) {
    return LeafPlanner(page, placement).Plan();
}

} // namespace hds
