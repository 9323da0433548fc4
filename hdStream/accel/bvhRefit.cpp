// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/bvhRefit.h"

#include "hdStream/accel/nodeQuantise.h"
#include "hdStream/base/error.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hds {

namespace {

/// Of meta: a slot holds an inner child.
constexpr std::uint32_t kFirstInnerOffset = 24;

std::uint32_t ByteOf(const std::uint32_t* words, std::uint32_t slot) {
    return words[slot / 4] >> (8 * (slot % 4)) & 0xffU;
}

/// The float next to a value that is no larger, or no smaller.
float RoundDown(double value) {
    const auto rounded = static_cast<float>(value);
    return double{rounded} > value ? std::nextafter(rounded, -HUGE_VALF) : rounded;
}
float RoundUp(double value) {
    const auto rounded = static_cast<float>(value);
    return double{rounded} < value ? std::nextafter(rounded, HUGE_VALF) : rounded;
}

/// What a slot's planes hold: of their sums, which are rounded once, a double further out.
Bounds DecodedBox(const shared::HdsBvhNode& node, std::uint32_t slot) {
    Bounds box;
    for (int axis = 0; axis < 3; ++axis) {
        const int exponent = static_cast<int>(node.exponentsImask >> (8 * axis) & 0xffU) - 127;
        const double scale = std::ldexp(1.0, exponent);
        const double low = double{node.origin[axis]} + scale * ByteOf(node.qlo[axis], slot);
        const double high = double{node.origin[axis]} + scale * ByteOf(node.qhi[axis], slot);
        box.min[axis] = RoundDown(std::nextafter(low, -HUGE_VAL));
        box.max[axis] = RoundUp(std::nextafter(high, HUGE_VAL));
    }
    return box;
}

SlotBox SlotBoxOf(const Bounds& box) {
    return {{box.min.x, box.min.y, box.min.z, 0.0F}, {box.max.x, box.max.y, box.max.z, 0.0F}};
}

} // namespace

BvhRefit::BvhRefit(const shared::HdsBvhNode* nodes, std::uint32_t numNodes, std::uint32_t numItems)
    : _nodes(numNodes), _places(numItems) {
    for (std::uint32_t i = 0; i < numNodes; ++i) {
        ReadNode(nodes[i], i);
    }
    for (const Node& node : _nodes) {
        _areaAsBuilt += AreaOf(node);
    }
    _area = _areaAsBuilt;
    // What all lies in one point has no area: it may not grow.
    _areaAsBuilt = std::max(_areaAsBuilt, std::numeric_limits<double>::min());
}

void BvhRefit::ReadNode(const shared::HdsBvhNode& read, std::uint32_t index) {
    Node& node = _nodes[index];
    std::copy_n(read.meta, 2, node.meta);
    std::uint32_t child = read.childBase;
    for (std::uint32_t slot = 0; slot < 8; ++slot) {
        const std::uint32_t meta = ByteOf(read.meta, slot);
        const bool isInner = (read.exponentsImask >> (24 + slot) & 1U) != 0;
        if (meta == 0 && !isInner) {
            continue;
        }
        node.boxes[slot] = DecodedBox(read, slot);
        node.present |= static_cast<std::uint8_t>(1U << slot);
        if (isInner) {
            _nodes[child].parent = index;
            _nodes[child].slotInParent = static_cast<std::uint8_t>(slot);
            ++child;
        } else {
            HDS_VERIFY(meta >> 5 == 1 && (meta & 31U) < kFirstInnerOffset, "a leaf of several");
            _places.at(read.itemBase + (meta & 31U)) = {index, static_cast<std::uint8_t>(slot)};
        }
    }
}

void BvhRefit::Put(std::uint32_t node, std::uint32_t slot, const Bounds& box, bool isPresent) {
    Node& changed = _nodes[node];
    const auto bit = static_cast<std::uint8_t>(1U << slot);
    if (_changed.insert(node).second) {
        _area -= AreaOf(changed);
    }
    changed.boxes[slot] = box;
    changed.present =
        static_cast<std::uint8_t>(isPresent ? changed.present | bit : changed.present & ~bit);
}

void BvhRefit::Set(std::uint32_t item, const Bounds& box) {
    const Place& place = _places.at(item);
    const bool isEmpty = box.min.x > box.max.x || box.min.y > box.max.y || box.min.z > box.max.z;
    Put(place.node, place.slot, box, !isEmpty);
}

std::vector<std::uint32_t> BvhRefit::Write(shared::HdsBvhNode* nodes) {
    std::vector<std::uint32_t> written;
    while (!_changed.empty()) {
        const std::uint32_t index = *_changed.rbegin(); // children come behind their parents
        const Node& node = _nodes[index];
        const Bounds all = BoxOf(node);
        shared::HdsBvhNode& result = nodes[index];
        if (node.present != 0) {
            std::array<SlotBox, 8> boxes{};
            std::transform(node.boxes.begin(), node.boxes.end(), boxes.begin(), SlotBoxOf);
            QuantiseNode(SlotBoxOf(all), boxes, node.present, &result);
        }
        // Boxes of points are met wherever they are in their node: a slot without meta never is.
        for (std::uint32_t word = 0; word < 2; ++word) {
            result.meta[word] = 0;
            for (std::uint32_t byte = 0; byte < 4; ++byte) {
                const bool isPresent = (node.present >> (4 * word + byte) & 1U) != 0;
                result.meta[word] |= isPresent ? node.meta[word] & 0xffU << (8 * byte) : 0U;
            }
        }
        _area += AreaOf(node);
        _changed.erase(index);
        written.push_back(index);
        if (node.parent != HDS_NONE) {
            Put(node.parent, node.slotInParent, all, node.present != 0);
        }
    }
    std::reverse(written.begin(), written.end());
    return written;
}

/// What holds all that is in a node; of nothing it is inside out.
Bounds BvhRefit::BoxOf(const Node& node) {
    Bounds all;
    for (std::uint32_t slot = 0; slot < 8; ++slot) {
        if ((node.present >> slot & 1U) != 0) {
            all.min = glm::min(all.min, node.boxes[slot].min);
            all.max = glm::max(all.max, node.boxes[slot].max);
        }
    }
    return all;
}

double BvhRefit::AreaOf(const Node& node) {
    if (node.present == 0) {
        return 0.0;
    }
    const Bounds box = BoxOf(node);
    const glm::dvec3 size = glm::dvec3(box.max) - glm::dvec3(box.min);
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

} // namespace hds
