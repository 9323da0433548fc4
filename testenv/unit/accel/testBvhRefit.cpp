// SPDX-License-Identifier: Apache-2.0
// A BVH of which items move, go and come back holds those that are there, in conservative boxes,
// and no others.
#include "hdStream/accel/bvhRefit.h"
#include "testenv/unit/accel/bvhCheck.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace hds::test {
namespace {

class Scene {
public:
    Scene(std::uint32_t count, float size, std::uint32_t seed) : _random(seed), _size(size) {
        for (std::uint32_t i = 0; i < count; ++i) {
            items.push_back(RandomBox());
        }
        BvhOptions options;
        options.maxLeafItems = 1;
        Bvh bvh = BuildBvh(items, options);
        nodes = bvh.nodes;
        std::vector<Bounds> inOrder;
        for (const std::uint32_t item : bvh.order) {
            inOrder.push_back(items[item]);
        }
        items = inOrder;
    }

    Bounds RandomBox() {
        const auto uniform = [&] { return static_cast<float>(_random() >> 8U) * 0x1p-24F; };
        Bounds box;
        box.min = _spread * glm::vec3(uniform(), uniform(), uniform());
        box.max = box.min + _size * glm::vec3(uniform(), uniform(), uniform());
        return box;
    }

    std::uint32_t Below(std::uint32_t count) { return _random() % count; }
    void Spread(float spread) { _spread = spread; }

    std::vector<shared::HdsBvhNode> nodes;
    std::vector<Bounds> items; ///< in leaf order

private:
    std::mt19937 _random;
    float _size;
    float _spread = 1.0F;
};

bool IsThere(const Bounds& box) {
    return box.min.x <= box.max.x;
}

void ExpectHolds(const Scene& scene) {
    const BvhFacts facts = BvhWalker(scene.nodes, scene.items).Walk();
    EXPECT_EQ(facts.numMalformed, 0U);
    EXPECT_EQ(facts.numOutside, 0U);
    for (std::size_t i = 0; i < scene.items.size(); ++i) {
        ASSERT_EQ(facts.timesSeen[i], IsThere(scene.items[i]) ? 1U : 0U) << i;
    }
}

TEST(BvhRefit, HoldsWhatIsThere) {
    for (const std::uint32_t count : {1, 2, 7, 9, 60, 3000}) {
        for (const float size : {0.05F, 0.0F}) { // points are met all over a node of points
            Scene scene(count, size, count);
            BvhRefit refit(scene.nodes.data(), static_cast<std::uint32_t>(scene.nodes.size()),
                           count);
            for (int round = 0; round < 60; ++round) {
                scene.Spread(round % 7 == 0 ? 50.0F : 1.0F);
                for (std::uint32_t k = 0; k <= scene.Below(8); ++k) {
                    const std::uint32_t item = scene.Below(count);
                    scene.items[item] = scene.Below(3) == 0 ? Bounds() : scene.RandomBox();
                    refit.Set(item, scene.items[item]);
                }
                const auto before = scene.nodes;
                const std::vector<std::uint32_t> written = refit.Write(scene.nodes.data());
                for (std::uint32_t i = 0; i < before.size(); ++i) {
                    const bool isSame =
                        std::memcmp(&before[i], &scene.nodes[i], sizeof(shared::HdsBvhNode)) == 0;
                    EXPECT_TRUE(isSame || std::binary_search(written.begin(), written.end(), i));
                }
                ExpectHolds(scene);
            }
            EXPECT_TRUE(refit.Write(scene.nodes.data()).empty());
        }
    }
}

TEST(BvhRefit, ComesBackFromNothing) {
    Scene scene(40, 0.1F, 5);
    const std::vector<Bounds> first = scene.items;
    BvhRefit refit(scene.nodes.data(), static_cast<std::uint32_t>(scene.nodes.size()), 40);
    for (std::uint32_t i = 0; i < 40; ++i) {
        refit.Set(i, scene.items[i] = Bounds());
    }
    refit.Write(scene.nodes.data());
    ExpectHolds(scene);
    EXPECT_NEAR(refit.Growth(), 0.0, 1e-9);
    for (std::uint32_t i = 0; i < 40; ++i) {
        refit.Set(i, scene.items[i] = first[i]);
    }
    refit.Write(scene.nodes.data());
    ExpectHolds(scene);
    EXPECT_NEAR(refit.Growth(), 1.0, 0.1) << "planes are a step off at most";
}

TEST(BvhRefit, KnowsHowMuchWorseItIs) {
    Scene scene(500, 0.02F, 9);
    BvhRefit refit(scene.nodes.data(), static_cast<std::uint32_t>(scene.nodes.size()), 500);
    EXPECT_EQ(refit.Growth(), 1.0);
    Bounds far;
    far.min = far.max = glm::vec3(30.0F);
    refit.Set(3, far);
    refit.Write(scene.nodes.data());
    EXPECT_GT(refit.Growth(), 10.0);
}

} // namespace
} // namespace hds::test
