// SPDX-License-Identifier: Apache-2.0
// Quantised boxes contain the true ones and are at most one step larger; slots follow the octants.
#include "hdStream/accel/nodeQuantise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hds {
namespace {

/// A node over `children` whose parent box is their union, in slots 0, 1, 2...
struct Quantised {
    SlotBox parent{};
    std::array<SlotBox, 8> children{};
    shared::HdsBvhNode node{};

    explicit Quantised(const std::vector<SlotBox>& boxes) {
        parent = boxes[0];
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            children[i] = boxes[i];
            for (int axis = 0; axis < 3; ++axis) {
                parent.lo[axis] = std::min(parent.lo[axis], boxes[i].lo[axis]);
                parent.hi[axis] = std::max(parent.hi[axis], boxes[i].hi[axis]);
            }
        }
        QuantiseNode(parent, children, (1U << boxes.size()) - 1U, &node);
    }
};

SlotBox MakeBox(float lo, float hi) {
    return {{lo, lo, lo, 0.0F}, {hi, hi, hi, 0.0F}};
}

/// Containment is exact: differences of floats and q * 2^e are compared in long double.
void ExpectConservative(const Quantised& q, int count) {
    for (int slot = 0; slot < count; ++slot) {
        for (int axis = 0; axis < 3; ++axis) {
            const int exponent =
                static_cast<int>(q.node.exponentsImask >> (8 * axis) & 0xffU) - 127;
            const long double step = std::ldexp(1.0L, exponent);
            const long double origin = q.node.origin[axis];
            const auto lo = q.node.qlo[axis][slot / 4] >> (8 * (slot % 4)) & 0xffU;
            const auto hi = q.node.qhi[axis][slot / 4] >> (8 * (slot % 4)) & 0xffU;
            const long double trueLo = static_cast<long double>(q.children[slot].lo[axis]) - origin;
            const long double trueHi = static_cast<long double>(q.children[slot].hi[axis]) - origin;
            EXPECT_LE(step * lo, trueLo);
            EXPECT_GE(step * hi, trueHi);
            EXPECT_LE(trueLo - step * lo, step) << "a low plane is more than a step off";
            EXPECT_LE(step * hi - trueHi, step) << "a high plane is more than a step off";
        }
    }
}

TEST(NodeQuantise, ContainsRandomBoxesOfAnyScale) {
    std::mt19937 random(1);
    const auto uniform = [&] { return static_cast<float>(random() >> 8U) * 0x1p-24F; };
    for (int trial = 0; trial < 20000; ++trial) {
        const float scale = std::ldexp(1.0F, static_cast<int>(uniform() * 160.0F) - 80);
        const float offset = (uniform() - 0.5F) * scale * std::ldexp(1.0F, trial % 24);
        std::vector<SlotBox> boxes;
        for (int i = 0; i < 8; ++i) {
            SlotBox box{};
            for (int axis = 0; axis < 3; ++axis) {
                const float a = offset + scale * uniform();
                const float b = offset + scale * uniform();
                box.lo[axis] = std::min(a, b);
                box.hi[axis] = std::max(a, b);
            }
            boxes.push_back(box);
        }
        ExpectConservative(Quantised(boxes), 8);
        if (HasFailure()) {
            FAIL() << "trial " << trial;
        }
    }
}

// The scale is the smallest power of two that reaches the far side with 255 steps.
TEST(NodeQuantise, ChoosesTheExponentAtTheBoundary) {
    const auto exponentOf = [](float extent) {
        return static_cast<int>(Quantised({MakeBox(0.0F, extent)}).node.exponentsImask & 0xffU) -
               127;
    };
    EXPECT_EQ(exponentOf(255.0F), 0);
    EXPECT_EQ(exponentOf(std::nextafter(255.0F, 256.0F)), 1);
    EXPECT_EQ(exponentOf(256.0F), 1);
    EXPECT_EQ(exponentOf(std::nextafter(255.0F, 0.0F)), 0);
    EXPECT_EQ(exponentOf(127.5F), -1);
    for (const float extent : {255.0F, 256.0F, 127.5F, 510.0F, 510.00003F}) {
        ExpectConservative(Quantised({MakeBox(0.0F, extent), MakeBox(extent, extent)}), 2);
        ExpectConservative(Quantised({MakeBox(-extent, 0.0F), MakeBox(-extent, -extent)}), 2);
    }
}

TEST(NodeQuantise, KeepsExponentsInRange) {
    const auto exponentOf = [](float lo, float hi) {
        const Quantised q({MakeBox(lo, hi)});
        ExpectConservative(q, 1);
        return q.node.exponentsImask & 0xffU;
    };
    EXPECT_EQ(exponentOf(1.0F, 1.0F), 1U) << "a flat box has the smallest normal scale";
    EXPECT_EQ(exponentOf(0.0F, 1e-45F), 1U);
    EXPECT_LE(exponentOf(-3.4e38F, 3.4e38F), 254U);
}

TEST(NodeQuantise, EmptySlotsHoldEmptyBoxes) {
    const Quantised q({MakeBox(0.0F, 1.0F)});
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(q.node.qlo[axis][1], 0xffffffffU);
        EXPECT_EQ(q.node.qhi[axis][1], 0U);
    }
}

// A ray to +x +y +z visits slot 0 first, so slot 0 must be the octant at the low corner.
TEST(NodeQuantise, AssignsSlotsByOctant) {
    std::array<SlotBox, 8> children{};
    for (int i = 0; i < 8; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const bool isHigh = (i >> (2 - axis) & 1) != 0;
            children[i].lo[axis] = isHigh ? 1.0F : 0.0F;
            children[i].hi[axis] = isHigh ? 2.0F : 1.0F;
        }
    }
    const std::array<int, 8> slots = AssignSlots(MakeBox(0.0F, 2.0F), children, 8);
    for (int i = 0; i < 8; ++i) {
        EXPECT_EQ(slots[i], i);
    }
}

TEST(NodeQuantise, AssignsDistinctSlots) {
    std::mt19937 random(2);
    for (int trial = 0; trial < 1000; ++trial) {
        std::array<SlotBox, 8> children{};
        const int count = 1 + trial % 8;
        for (int i = 0; i < count; ++i) {
            // Some trials have equal boxes, some huge ones.
            const float x = trial % 3 == 0 ? 0.0F : static_cast<float>(random() >> 8U);
            children[i] = MakeBox(x, trial % 5 == 0 ? 3e38F : x + 1.0F);
        }
        const std::array<int, 8> slots = AssignSlots(MakeBox(-3e38F, 3e38F), children, count);
        std::uint32_t seen = 0;
        for (int i = 0; i < count; ++i) {
            ASSERT_GE(slots[i], 0);
            ASSERT_LT(slots[i], 8);
            seen |= 1U << slots[i];
        }
        EXPECT_EQ(__builtin_popcount(seen), count);
    }
}

} // namespace
} // namespace hds
