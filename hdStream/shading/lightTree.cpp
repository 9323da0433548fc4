// SPDX-License-Identifier: Apache-2.0
// Light tree by the surface area orientation heuristic: a binary one, whose levels are then put
// together until nodes have eight children. Source: Conty Estevez and Kulla 2018, "Importance
// Sampling of Many Lights with Adaptive Tree Splitting", section 4. Deviates: extents in place of
// areas, which is as good here; the directions of a node are their mean vector.
#include "hdStream/shading/lightTree.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <limits>

namespace hds {

namespace {

constexpr double kPi = 3.14159265358979323846;
/// Bounds are padded by more than the rounding of centre and radius to float.
constexpr double kBoundPadding = 1.0 + 1e-5;
constexpr std::size_t kNumBins = 16;
constexpr std::uint32_t kMaxDepth = 31;
constexpr std::uint32_t kWidth = 8; ///< children of a node

/// What the tree knows of a light.
struct Emitter {
    glm::dvec3 center;
    double radius;
    double strength;   ///< HdsLight's
    double even;       ///< what it sends alike in all directions, as its strength
    glm::dvec3 facing; ///< what it sends by the cosine, times the direction to it
    bool isBothWays;   ///< and as much in the opposite direction
    bool isMoving;
};

/// Of a light that sends nothing into the half space behind its axis, whose emission is shaped.
constexpr double kBeam = 2.0;
/// Of a flat light: intensity at the normal over that of the same power spread evenly.
constexpr double kFlat = 4.0;

bool IsBothWays(const shared::HdsLight& light) {
    return light.type == HDS_LIGHT_MESH && (light.flags & HDS_LIGHT_TWO_SIDED) != 0;
}

/// What the light sends by the cosine, as a factor on its strength, times the direction in which
/// the light is seen from where it sends most.
glm::dvec3 FacingOf(const shared::HdsLight& light, const std::vector<float>& cdf) {
    if (light.type == HDS_LIGHT_RECT || light.type == HDS_LIGHT_DISK) {
        return kFlat * glm::dvec3(light.lightFromWorld[3], light.lightFromWorld[7],
                                  light.lightFromWorld[11]);
    }
    if (light.type == HDS_LIGHT_MESH) {
        return (IsBothWays(light) ? -0.5 : -1.0) * kFlat * double(light.params[0]) *
               glm::dvec3(light.worldFromLight[0], light.worldFromLight[1],
                          light.worldFromLight[2]);
    }
    if (light.shapingBase == HDS_NONE) {
        return glm::dvec3(0.0);
    }
    shared::HdsLightShaping shaping;
    std::memcpy(&shaping, &cdf[light.shapingBase], sizeof(shaping));
    return shaping.cutoff <= float(0.5 * kPi)
               ? -kBeam * glm::dvec3(shaping.axis[0], shaping.axis[1], shaping.axis[2])
               : glm::dvec3(0.0);
}

/// Of the arc between two keys, as part of the distance from the pivot: they turn by less.
constexpr double kArc = 0.05;

/// The sphere that holds a light wherever it moves, or false when it rests. That of a light that
/// changes holds all of its shapes.
bool HoldMotion(const shared::HdsLight& light, const std::vector<float>& cdf, Emitter* emitter) {
    shared::HdsLightControls controls{};
    if (light.controlBase != HDS_NONE) {
        std::memcpy(&controls, &cdf[light.controlBase], sizeof(controls));
    }
    if (controls.motionSegments == 0) {
        return controls.numCells != 0;
    }
    const glm::dvec3 pivot(light.worldFromLight[3], light.worldFromLight[7],
                           light.worldFromLight[11]);
    const glm::dvec3 fromPivot = emitter->center - pivot;
    std::vector<glm::dvec3> centers;
    for (std::uint32_t i = 0; i <= controls.motionSegments; ++i) {
        shared::HdsLightKey key;
        std::memcpy(&key, &cdf[controls.motionBase + i * sizeof(key) / sizeof(cdf[0])],
                    sizeof(key));
        const glm::dvec3 axis(key.turn[0], key.turn[1], key.turn[2]);
        const glm::dvec3 twice = 2.0 * glm::cross(axis, fromPivot);
        centers.push_back(pivot + glm::dvec3(key.offset[0], key.offset[1], key.offset[2]) +
                          fromPivot + double(key.turn[3]) * twice + glm::cross(axis, twice));
    }
    glm::dvec3 low = centers[0];
    glm::dvec3 high = centers[0];
    for (const glm::dvec3& center : centers) {
        low = glm::min(low, center);
        high = glm::max(high, center);
    }
    emitter->center = 0.5 * (low + high);
    emitter->radius += 0.5 * glm::length(high - low) + kArc * glm::length(fromPivot);
    return true;
}

Emitter EmitterOf(const shared::HdsLight& light, const std::vector<float>& cdf) {
    Emitter moving{{light.center[0], light.center[1], light.center[2]},
                   light.boundRadius,
                   light.strength,
                   light.strength,
                   glm::dvec3(0.0),
                   false,
                   true};
    if (HoldMotion(light, cdf, &moving)) {
        return moving; // it may face anywhere
    }
    const glm::dvec3 facing = FacingOf(light, cdf);
    double even = light.strength;
    if (light.type == HDS_LIGHT_MESH) {
        even *= std::max(1.0 - double(light.params[0]), 0.0);
    } else if (glm::length(facing) > 0.0) {
        even = 0.0;
    }
    return {{light.center[0], light.center[1], light.center[2]},
            light.boundRadius,
            light.strength,
            even,
            facing * double(light.strength),
            IsBothWays(light),
            false};
}

/// Of several lights.
struct Sum {
    std::size_t count = 0;
    double strength = 0.0;
    double even = 0.0;
    double cosine = 0.0; ///< lengths of facing
    glm::dvec3 facing{0.0};
    glm::dvec3 low{std::numeric_limits<double>::max()};
    glm::dvec3 high{std::numeric_limits<double>::lowest()};

    void Add(const Emitter& emitter) {
        ++count;
        strength += emitter.strength;
        if (emitter.isBothWays) {
            even += emitter.strength;
        } else {
            even += emitter.even;
            cosine += glm::length(emitter.facing);
            facing += emitter.facing;
        }
        low = glm::min(low, emitter.center - emitter.radius);
        high = glm::max(high, emitter.center + emitter.radius);
    }
    void Add(const Sum& sum) {
        count += sum.count;
        strength += sum.strength;
        even += sum.even;
        cosine += sum.cosine;
        facing += sum.facing;
        low = glm::min(low, sum.low);
        high = glm::max(high, sum.high);
    }
    /// How badly a node of these lights can be estimated. Directions that are all alike halve it.
    double Cost() const {
        const double alike = strength > 0.0 ? glm::length(facing) / (kFlat * strength) : 0.0;
        return strength * glm::length(high - low) * (2.0 - alike);
    }
};

/// Two parts of a range of lights.
struct Split {
    double cost = std::numeric_limits<double>::max();
    int axis = 0;
    std::size_t bin = 0; ///< the last of the first part
};

/// Cuts the range from `low` to `high` of one axis into bins.
struct Binning {
    double low;
    double perUnit; ///< bins in a unit of length; 0: the range has no length

    std::size_t At(double value) const {
        return std::min(std::size_t(std::max((value - low) * perUnit, 0.0)), kNumBins - 1);
    }
};

using Bins = std::array<Sum, kNumBins>;

/// Keeps in `best` the best split of one axis, if it is better.
void FindSplit(const Bins& bins, int axis, double stretch, Split* best) {
    std::array<double, kNumBins> after{}; ///< cost of the bins from this one on
    Sum sum;
    for (std::size_t i = kNumBins - 1; i > 0; --i) {
        sum.Add(bins[i]);
        after[i] = sum.count > 0 ? sum.Cost() : -1.0;
    }
    sum = Sum();
    for (std::size_t i = 0; i + 1 < kNumBins; ++i) {
        sum.Add(bins[i]);
        if (sum.count > 0 && after[i + 1] >= 0.0) {
            const double cost = stretch * (sum.Cost() + after[i + 1]);
            if (cost < best->cost) {
                *best = {cost, axis, i};
            }
        }
    }
}

std::uint32_t BitWidth(std::size_t value) {
    std::uint32_t width = 0;
    for (; value > 0; value >>= 1U) {
        ++width;
    }
    return width;
}

class TreeBuilder {
public:
    TreeBuilder(std::vector<shared::HdsLight>& lights, const std::vector<float>& cdf)
        : _lights(lights) {
        _emitters.reserve(lights.size());
        for (const shared::HdsLight& light : lights) {
            _emitters.push_back(EmitterOf(light, cdf));
        }
    }

    /// Builds the subtree over [begin, end) of the order. \return cluster, or HDS_LIGHT_LEAF |
    /// light.
    std::uint32_t Build(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
                        std::uint32_t depth) {
        if (end - begin == 1) {
            return HDS_LIGHT_LEAF | order[begin];
        }
        const auto index = std::uint32_t(_clusters.size());
        _clusters.push_back(ClusterOf(order, begin, end));
        const std::size_t middle = Partition(order, begin, end, depth);
        const std::uint32_t left = Build(order, begin, middle, depth + 1);
        const std::uint32_t right = Build(order, middle, end, depth + 1);
        _clusters[index].child = {left, right};
        _clusters[index].isMet = Get(left).isMet || Get(right).isMet;
        return index;
    }

    /// Adds the node of the clusters below `top`. \param place of the node: 8 * parent + slot.
    void AddNode(std::uint32_t top, std::uint32_t place) {
        const auto index = std::uint32_t(nodes.size());
        nodes.emplace_back();
        const std::vector<std::uint32_t> children = ChildrenOf(top);
        FillNode(children, place, &nodes[index]);
        for (std::uint32_t slot = 0; slot < children.size(); ++slot) {
            const std::uint32_t child = children[slot];
            if ((child & HDS_LIGHT_LEAF) != 0) {
                _lights[child & ~HDS_LIGHT_LEAF].treePlace = kWidth * index + slot;
                continue;
            }
            nodes[index].child[slot] = std::uint32_t(nodes.size());
            AddNode(child, kWidth * index + slot);
        }
    }

    std::vector<shared::HdsLightNode> nodes;

private:
    /// Lights that are close, as the tree knows them.
    struct Cluster {
        glm::dvec3 center{0.0};
        double radius = 0.0;
        glm::dvec3 facing{0.0}; ///< what they send by the cosine, times the direction to them
        double even = 0.0;      ///< what they send alike in all directions
        bool isBothWays = false;
        bool isMet = false; ///< rays can meet some of them
        std::array<std::uint32_t, 2> child{HDS_NONE, HDS_NONE};
    };

    static Cluster ClusterOf(const shared::HdsLight& light, const Emitter& emitter) {
        const bool isMet = light.type != HDS_LIGHT_MESH && (light.flags & HDS_LIGHT_POINT) == 0;
        return {emitter.center,     emitter.radius, emitter.facing,      emitter.even,
                emitter.isBothWays, isMet,          {HDS_NONE, HDS_NONE}};
    }

    Cluster ClusterOf(const std::vector<std::uint32_t>& order, std::size_t begin,
                      std::size_t end) const {
        Sum sum;
        glm::dvec3 weighted(0.0);
        for (std::size_t i = begin; i < end; ++i) {
            const Emitter& emitter = _emitters[order[i]];
            sum.Add(emitter);
            weighted += emitter.strength * emitter.center;
        }
        Cluster cluster;
        // Around the centre of what they send: that is where the estimate takes it all to be.
        cluster.center = sum.strength > 0.0 ? weighted / sum.strength : 0.5 * (sum.low + sum.high);
        for (std::size_t i = begin; i < end; ++i) {
            const Emitter& emitter = _emitters[order[i]];
            cluster.radius = std::max(cluster.radius, glm::length(emitter.center - cluster.center) +
                                                          emitter.radius);
        }
        cluster.facing = sum.facing;
        // What the directions cancel out is sent everywhere.
        cluster.even = sum.even + std::max(sum.cosine - glm::length(sum.facing), 0.0) / kFlat;
        return cluster;
    }

    /// \param child as Build returns it.
    Cluster Get(std::uint32_t child) const {
        const std::uint32_t light = child & ~HDS_LIGHT_LEAF;
        return (child & HDS_LIGHT_LEAF) != 0 ? ClusterOf(_lights[light], _emitters[light])
                                             : _clusters[child];
    }

    /// Up to eight parts of a cluster in the order of the binary tree. The part whose estimate is
    /// worst at equal distance is cut first.
    std::vector<std::uint32_t> ChildrenOf(std::uint32_t top) const {
        std::vector<std::uint32_t> children{top};
        while (children.size() < kWidth) {
            std::size_t worst = children.size();
            double largest = -1.0;
            for (std::size_t i = 0; i < children.size(); ++i) {
                if ((children[i] & HDS_LIGHT_LEAF) == 0) {
                    const Cluster& cluster = _clusters[children[i]];
                    const double error =
                        (cluster.even + glm::length(cluster.facing)) * cluster.radius;
                    if (error > largest) {
                        largest = error;
                        worst = i;
                    }
                }
            }
            if (worst == children.size()) {
                break;
            }
            const std::array<std::uint32_t, 2> parts = _clusters[children[worst]].child;
            children[worst] = parts[1];
            children.insert(children.begin() + std::ptrdiff_t(worst), parts[0]);
        }
        return children;
    }

    void FillNode(const std::vector<std::uint32_t>& children, std::uint32_t place,
                  shared::HdsLightNode* node) const {
        node->place = place;
        std::fill(std::begin(node->child), std::end(node->child), HDS_NONE);
        for (std::size_t slot = 0; slot < children.size(); ++slot) {
            const std::uint32_t bit = 1U << slot;
            const std::uint32_t child = children[slot];
            const Cluster cluster = Get(child);
            const double facing = glm::length(cluster.facing);
            const glm::dvec3 axis = facing > 0.0 ? cluster.facing / facing : glm::dvec3(0.0);
            const double magnitude =
                std::max({std::abs(cluster.center.x), std::abs(cluster.center.y),
                          std::abs(cluster.center.z)});
            node->centerX[slot] = float(cluster.center.x);
            node->centerY[slot] = float(cluster.center.y);
            node->centerZ[slot] = float(cluster.center.z);
            node->radius[slot] = float(cluster.radius * kBoundPadding + magnitude * 1e-6);
            node->axisX[slot] = float(axis.x);
            node->axisY[slot] = float(axis.y);
            node->axisZ[slot] = float(axis.z);
            node->strength[slot] = float(cluster.even);
            node->cosineStrength[slot] = float(facing);
            node->child[slot] = child;
            node->metByRays |= cluster.isMet ? bit : 0U;
            if ((child & HDS_LIGHT_LEAF) != 0) {
                const std::uint32_t index = child & ~HDS_LIGHT_LEAF;
                const shared::HdsLight& light = _lights[index];
                const bool isInDetail = light.shapingBase != HDS_NONE ||
                                        light.lightLink != HDS_NONE || _emitters[index].isMoving;
                node->bothWays |= cluster.isBothWays ? bit : 0U;
                node->inDetail |= isInDetail ? bit : 0U;
            }
        }
    }

    /// Reorders the range into two parts. \return where the second begins.
    std::size_t Partition(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
                          std::uint32_t depth) const {
        glm::dvec3 low(std::numeric_limits<double>::max());
        glm::dvec3 high(std::numeric_limits<double>::lowest());
        for (std::size_t i = begin; i < end; ++i) {
            low = glm::min(low, _emitters[order[i]].center);
            high = glm::max(high, _emitters[order[i]].center);
        }
        const glm::dvec3 size = high - low;
        const int longest =
            size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
        // Halves, where the rest of the depth is needed for halves.
        if (size[longest] > 0.0 && depth + 1 + BitWidth(end - begin) <= kMaxDepth) {
            std::array<Binning, 3> binnings{};
            for (int axis = 0; axis < 3; ++axis) {
                binnings[axis] = {low[axis],
                                  size[axis] > 0.0 ? double(kNumBins) / size[axis] : 0.0};
            }
            const Split best = BestSplit(order, begin, end, binnings, size / size[longest]);
            const auto first = order.begin() + std::ptrdiff_t(begin);
            const auto middle = std::stable_partition(
                first, order.begin() + std::ptrdiff_t(end), [&](std::uint32_t i) {
                    return binnings[best.axis].At(_emitters[i].center[best.axis]) <= best.bin;
                });
            return begin + std::size_t(middle - first);
        }
        const std::size_t middle = begin + (end - begin) / 2;
        std::nth_element(
            order.begin() + std::ptrdiff_t(begin), order.begin() + std::ptrdiff_t(middle),
            order.begin() + std::ptrdiff_t(end), [&](std::uint32_t a, std::uint32_t b) {
                const double ca = _emitters[a].center[longest];
                const double cb = _emitters[b].center[longest];
                return ca != cb ? ca < cb : a < b;
            });
        return middle;
    }

    /// \param relative sizes of the range, the longest 1: thin slices cost more
    Split BestSplit(const std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
                    const std::array<Binning, 3>& binnings, const glm::dvec3& relative) const {
        std::array<Bins, 3> bins;
        for (std::size_t i = begin; i < end; ++i) {
            const Emitter& emitter = _emitters[order[i]];
            for (int axis = 0; axis < 3; ++axis) {
                bins[axis][binnings[axis].At(emitter.center[axis])].Add(emitter);
            }
        }
        Split best;
        for (int axis = 0; axis < 3; ++axis) {
            if (binnings[axis].perUnit > 0.0) {
                FindSplit(bins[axis], axis, 1.0 / relative[axis], &best);
            }
        }
        return best;
    }

    std::vector<shared::HdsLight>& _lights;
    std::vector<Emitter> _emitters;
    std::vector<Cluster> _clusters;
};

} // namespace

std::vector<shared::HdsLightNode> BuildLightTree(std::vector<shared::HdsLight>& lights,
                                                 const std::vector<float>& cdf) {
    std::vector<std::uint32_t> order;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (lights[i].boundRadius < HDS_LIGHT_FAR) {
            order.push_back(std::uint32_t(i));
        }
    }
    if (order.empty()) {
        return {};
    }
    TreeBuilder builder(lights, cdf);
    builder.AddNode(builder.Build(order, 0, order.size(), 0), HDS_NONE);
    return std::move(builder.nodes);
}

} // namespace hds
