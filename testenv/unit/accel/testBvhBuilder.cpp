// SPDX-License-Identifier: Apache-2.0
// The builder holds every item once, in conservative boxes, at bounded depth, whatever the items
// and the number of threads.
#include "testenv/unit/accel/bvhCheck.h"

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace hds::test {
namespace {

std::vector<Bounds> RandomBoxes(std::size_t count, float size, std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<float>(random() >> 8U) * 0x1p-24F; };
    std::vector<Bounds> boxes(count);
    for (Bounds& box : boxes) {
        const glm::vec3 a(uniform(), uniform(), uniform());
        const glm::vec3 b = a + size * glm::vec3(uniform(), uniform(), uniform());
        box.min = glm::min(a, b);
        box.max = glm::max(a, b);
    }
    return boxes;
}

Bounds PointBox(float x, float y, float z) {
    Bounds box;
    box.min = box.max = glm::vec3(x, y, z);
    return box;
}

TEST(BvhBuilder, HoldsRandomBoxes) {
    for (const std::size_t count : {1, 2, 3, 4, 5, 8, 9, 24, 25, 100, 5000, 70000}) {
        const std::vector<Bounds> items = RandomBoxes(count, 0.02F, 3);
        ExpectSound(BuildBvh(items, {}), items);
    }
}

/// Expects a node set that differs from another one in its boxes only.
void ExpectSameTree(const std::vector<shared::HdsBvhNode>& a,
                    const std::vector<shared::HdsBvhNode>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_EQ(a[i].exponentsImask >> 24U, b[i].exponentsImask >> 24U);
        ASSERT_EQ(a[i].childBase, b[i].childBase);
        ASSERT_EQ(a[i].itemBase, b[i].itemBase);
        ASSERT_EQ(std::memcmp(a[i].meta, b[i].meta, sizeof(a[i].meta)), 0);
    }
}

TEST(BvhBuilder, HoldsMovingBoxesAtBothEnds) {
    for (const std::size_t count : {1, 2, 4, 25, 5000}) {
        const std::vector<Bounds> open = RandomBoxes(count, 0.02F, 3);
        const std::vector<Bounds> close = RandomBoxes(count, 0.5F, 9);
        const Bvh bvh = BuildMovingBvh({open, close}, {});
        ExpectSameTree(bvh.nodes, bvh.laterNodes);
        ExpectSound(bvh, open);
        Bvh closed = bvh;
        closed.nodes = bvh.laterNodes;
        ExpectSound(closed, close);
        for (const std::vector<Bounds>* boxes : {&open, &close}) {
            for (const Bounds& box : *boxes) {
                EXPECT_TRUE(glm::all(glm::lessThanEqual(bvh.bounds.min, box.min)));
                EXPECT_TRUE(glm::all(glm::lessThanEqual(box.max, bvh.bounds.max)));
            }
        }
    }
}

TEST(BvhBuilder, HoldsMovingBoxesAtAllKeys) {
    std::vector<std::vector<Bounds>> keys;
    for (unsigned seed = 3; seed < 8; ++seed) {
        keys.push_back(RandomBoxes(2000, seed == 5 ? 0.5F : 0.02F, seed));
    }
    const Bvh bvh = BuildMovingBvh(keys, {});
    const std::size_t numNodes = bvh.nodes.size();
    ASSERT_EQ(bvh.laterNodes.size(), (keys.size() - 1) * numNodes);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        Bvh posed = bvh;
        if (i > 0) {
            posed.nodes.assign(bvh.laterNodes.begin() + std::ptrdiff_t((i - 1) * numNodes),
                               bvh.laterNodes.begin() + std::ptrdiff_t(i * numNodes));
        }
        ExpectSameTree(bvh.nodes, posed.nodes);
        ExpectSound(posed, keys[i]);
    }
}

// Half way all boxes are the same point: the tree is cut at medians.
TEST(BvhBuilder, HoldsMovingBoxesThatMeetHalfWay) {
    const std::vector<Bounds> open = RandomBoxes(3000, 0.0F, 3);
    std::vector<Bounds> close;
    for (const Bounds& box : open) {
        close.push_back({-box.min, -box.max});
    }
    const Bvh bvh = BuildMovingBvh({open, close}, {});
    ExpectSound(bvh, open);
    Bvh closed = bvh;
    closed.nodes = bvh.laterNodes;
    ExpectSound(closed, close);
}

TEST(BvhBuilder, NoItemsGiveNoNodes) {
    const Bvh bvh = BuildBvh({}, {});
    EXPECT_TRUE(bvh.nodes.empty());
    EXPECT_TRUE(bvh.order.empty());
}

TEST(BvhBuilder, HonoursTheLeafSize) {
    const std::vector<Bounds> items = RandomBoxes(1000, 0.02F, 4);
    BvhOptions options;
    options.maxLeafItems = 1;
    const Bvh bvh = BuildBvh(items, options);
    ExpectSound(bvh, items);
    for (const shared::HdsBvhNode& node : bvh.nodes) {
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            EXPECT_LE(node.meta[slot / 4] >> (8 * (slot % 4)) >> 5 & 7U, 1U);
        }
    }
}

TEST(BvhBuilder, TakesEqualFlatAndPointBoxes) {
    std::vector<Bounds> equal(10000, RandomBoxes(1, 1.0F, 5)[0]);
    ExpectSound(BuildBvh(equal, {}), equal);
    std::vector<Bounds> points;
    std::vector<Bounds> flat;
    for (int i = 0; i < 5000; ++i) {
        points.push_back(PointBox(0.0F, static_cast<float>(i % 70), 0.0F));
        Bounds box = PointBox(static_cast<float>(i % 71), 3.0F, static_cast<float>(i / 71));
        box.max.x += 1.0F;
        flat.push_back(box);
    }
    ExpectSound(BuildBvh(points, {}), points);
    ExpectSound(BuildBvh(flat, {}), flat);
}

// An instance of an empty group has no box; it must not disturb the others.
TEST(BvhBuilder, TakesEmptyBoxes) {
    std::vector<Bounds> items = RandomBoxes(50, 0.1F, 8);
    items[20] = Bounds();
    const Bvh bvh = BuildBvh(items, {});
    items[20] = PointBox(0.0F, 0.0F, 0.0F);
    ExpectSound(bvh, items);
}

// Positions 2^k make the heuristic peel off one end at a time: the fallback must bound the depth.
TEST(BvhBuilder, BoundsTheDepthOfExponentialPositions) {
    std::vector<Bounds> items;
    for (int i = 0; i < 20000; ++i) {
        const float x = std::exp2(static_cast<float>(i % 250) - 125.0F);
        items.push_back(PointBox(x * (1.0F + 1e-5F * static_cast<float>(i)), 0.0F, 0.0F));
    }
    ExpectSound(BuildBvh(items, {}), items);
}

TEST(BvhBuilder, TakesManyCollinearPoints) {
    std::vector<Bounds> items;
    for (int i = 0; i < 300000; ++i) {
        items.push_back(PointBox(static_cast<float>(i), 0.0F, 0.0F));
    }
    ExpectSound(BuildBvh(items, {}), items);
}

TEST(BvhBuilder, TakesHugeAndTinyCoordinates) {
    std::vector<Bounds> items = RandomBoxes(2000, 0.01F, 6);
    for (Bounds& box : items) {
        box.min += glm::vec3(1e7F);
        box.max += glm::vec3(1e7F);
    }
    ExpectSound(BuildBvh(items, {}), items);
    const float largest = std::numeric_limits<float>::max();
    items = {PointBox(largest, -largest, 0.0F), PointBox(-largest, largest, largest)};
    for (int i = 0; i < 100; ++i) {
        items.push_back(PointBox(std::ldexp(1.0F, -140 + i), -0.0F, largest / (1.0F + i)));
    }
    ExpectSound(BuildBvh(items, {}), items);
}

// The same scene gives the same bits whatever the thread count.
TEST(BvhBuilder, DoesNotDependOnTheThreadCount) {
    const std::vector<Bounds> items = RandomBoxes(200000, 0.01F, 7);
    const auto build = [&](std::size_t threads) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        return BuildBvh(items, {});
    };
    const Bvh one = build(1);
    for (const std::size_t threads : {2, 7}) {
        const Bvh many = build(threads);
        EXPECT_EQ(one.order, many.order);
        ASSERT_EQ(one.nodes.size(), many.nodes.size());
        EXPECT_EQ(std::memcmp(one.nodes.data(), many.nodes.data(),
                              one.nodes.size() * sizeof(one.nodes[0])),
                  0);
    }
}

} // namespace
} // namespace hds::test
