// SPDX-License-Identifier: Apache-2.0
// Median-split light tree.
#include "hdStream/shading/lightTree.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cstddef>

namespace hds {

namespace {

/// Bounds are padded by more than the rounding of centre and radius to float.
constexpr double kBoundPadding = 1.0 + 1e-5;

glm::dvec3 CenterOf(const shared::HdsLight& light) {
    return {light.center[0], light.center[1], light.center[2]};
}

class TreeBuilder {
public:
    explicit TreeBuilder(std::vector<shared::HdsLight>& lights) : _lights(lights) {}

    /// Builds the subtree over [begin, end) of the order. \return node, or HDS_LIGHT_LEAF | light.
    std::uint32_t Build(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
                        std::uint32_t path, std::uint32_t depth) {
        if (end - begin == 1) {
            _lights[order[begin]].treePath = path;
            return HDS_LIGHT_LEAF | order[begin];
        }
        const std::uint32_t index = std::uint32_t(nodes.size());
        nodes.push_back(Bound(order, begin, end));
        const std::size_t middle = begin + (end - begin) / 2;
        const int axis = LongestAxis(order, begin, end);
        std::nth_element(
            order.begin() + std::ptrdiff_t(begin), order.begin() + std::ptrdiff_t(middle),
            order.begin() + std::ptrdiff_t(end), [&](std::uint32_t a, std::uint32_t b) {
                const float ca = _lights[a].center[axis];
                const float cb = _lights[b].center[axis];
                return ca != cb ? ca < cb : a < b;
            });
        const std::uint32_t left = Build(order, begin, middle, path, depth + 1);
        const std::uint32_t right = Build(order, middle, end, path | (1U << depth), depth + 1);
        nodes[index].child[0] = left;
        nodes[index].child[1] = right;
        return index;
    }

    std::vector<shared::HdsLightNode> nodes;

private:
    /// A sphere around the centre of the box of the lights' spheres, and the sum of their
    /// strengths.
    shared::HdsLightNode Bound(const std::vector<std::uint32_t>& order, std::size_t begin,
                               std::size_t end) const {
        glm::dvec3 low(1e300);
        glm::dvec3 high(-1e300);
        double strength = 0.0;
        for (std::size_t i = begin; i < end; ++i) {
            const shared::HdsLight& light = _lights[order[i]];
            low = glm::min(low, CenterOf(light) - double(light.boundRadius));
            high = glm::max(high, CenterOf(light) + double(light.boundRadius));
            strength += light.strength;
        }
        const glm::dvec3 center = 0.5 * (low + high);
        double radius = 0.0;
        for (std::size_t i = begin; i < end; ++i) {
            const shared::HdsLight& light = _lights[order[i]];
            radius = std::max(radius, glm::length(CenterOf(light) - center) + light.boundRadius);
        }
        shared::HdsLightNode node{};
        double magnitude = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            node.center[axis] = float(center[axis]);
            magnitude = std::max(magnitude, std::abs(center[axis]));
        }
        node.radius = float(radius * kBoundPadding + magnitude * 1e-6);
        node.strength = float(strength);
        return node;
    }

    int LongestAxis(const std::vector<std::uint32_t>& order, std::size_t begin,
                    std::size_t end) const {
        glm::dvec3 low(1e300);
        glm::dvec3 high(-1e300);
        for (std::size_t i = begin; i < end; ++i) {
            low = glm::min(low, CenterOf(_lights[order[i]]));
            high = glm::max(high, CenterOf(_lights[order[i]]));
        }
        const glm::dvec3 size = high - low;
        return size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
    }

    std::vector<shared::HdsLight>& _lights;
};

} // namespace

std::vector<shared::HdsLightNode> BuildLightTree(std::vector<shared::HdsLight>& lights) {
    std::vector<std::uint32_t> order;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (lights[i].boundRadius < HDS_LIGHT_FAR) {
            order.push_back(std::uint32_t(i));
        }
    }
    if (order.size() < 2) {
        return {};
    }
    TreeBuilder builder(lights);
    builder.Build(order, 0, order.size(), 0, 0);
    return std::move(builder.nodes);
}

} // namespace hds
