// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/nodeQuantise.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace hds {
namespace {

constexpr int kMinExponent = -126; ///< the smallest scale is a normal float
constexpr int kMaxExponent = 127;

/// a - b, exactly: the rounded difference and what it lacks. Source: Knuth 1997, TAOCP 2, 4.2.2,
/// theorem B.
struct Difference {
    double value;
    double error;

    Difference(float a, float b) : value(double{a} - double{b}) {
        const double minusB = value - double{a};
        error = (double{a} - (value - minusB)) - (double{b} + minusB);
    }
};

/// Smallest exponent with 255 * 2^e >= the difference.
int ExponentFor(const Difference& difference) {
    const double extent =
        difference.error > 0.0 ? std::nextafter(difference.value, HUGE_VAL) : difference.value;
    if (!(extent > 0.0)) {
        return kMinExponent;
    }
    int exponent = 0;
    // extent / 255 = fraction * 2^exponent with fraction in [0.5, 1): 2^exponent is enough.
    const double fraction = std::frexp(extent / 255.0, &exponent);
    if (fraction == 0.5 && 255.0 * std::ldexp(1.0, exponent - 1) >= extent) {
        --exponent;
    }
    exponent = exponent < kMinExponent ? kMinExponent : exponent;
    HDS_VERIFY(exponent <= kMaxExponent, "a box is larger than the node format holds");
    return exponent;
}

/// 2^e for e in [kMinExponent, kMaxExponent], and its inverse, as exact doubles.
double PowerOfTwo(int exponent) {
    const std::uint64_t bits = static_cast<std::uint64_t>(exponent + 1023) << 52U;
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
}

/// The planes of one axis; q * scale is exact in a double.
struct AxisQuantiser {
    float origin;
    double scale;
    double inverse;

    std::uint32_t Low(float lo) const {
        const Difference distance(lo, origin);
        const auto isBeyond = [&](int q) {
            return q * scale > distance.value ||
                   (q * scale == distance.value && distance.error < 0.0);
        };
        int q = std::min(static_cast<int>(distance.value * inverse), 255);
        while (q > 0 && isBeyond(q)) {
            --q;
        }
        HDS_VERIFY(q >= 0 && !isBeyond(q), "a low plane does not contain its box");
        return static_cast<std::uint32_t>(q);
    }

    std::uint32_t High(float hi) const {
        const Difference distance(hi, origin);
        const auto isShort = [&](int q) {
            return q * scale < distance.value ||
                   (q * scale == distance.value && distance.error > 0.0);
        };
        int q = std::min(static_cast<int>(std::ceil(distance.value * inverse)), 255);
        while (q < 255 && isShort(q)) {
            ++q;
        }
        HDS_VERIFY(!isShort(q), "a high plane does not contain its box");
        return static_cast<std::uint32_t>(q);
    }
};

} // namespace

void QuantiseNode(const SlotBox& parent, const std::array<SlotBox, 8>& slots,
                  std::uint32_t slotMask, shared::HdsBvhNode* node) {
    node->exponentsImask &= 0xff000000U;
    for (int axis = 0; axis < 3; ++axis) {
        const int exponent = ExponentFor(Difference(parent.hi[axis], parent.lo[axis]));
        node->origin[axis] = parent.lo[axis];
        node->exponentsImask |= static_cast<std::uint32_t>(exponent + 127) << (8 * axis);
        const AxisQuantiser quantiser = {parent.lo[axis], PowerOfTwo(exponent),
                                         PowerOfTwo(-exponent)};
        std::uint32_t lo[2] = {0, 0};
        std::uint32_t hi[2] = {0, 0};
        for (int slot = 0; slot < 8; ++slot) {
            const bool isUsed = (slotMask >> slot & 1U) != 0;
            const std::uint32_t low = isUsed ? quantiser.Low(slots[slot].lo[axis]) : 255U;
            const std::uint32_t high = isUsed ? quantiser.High(slots[slot].hi[axis]) : 0U;
            lo[slot / 4] |= low << (8 * (slot % 4));
            hi[slot / 4] |= high << (8 * (slot % 4));
        }
        for (int half = 0; half < 2; ++half) {
            node->qlo[axis][half] = lo[half];
            node->qhi[axis][half] = hi[half];
        }
    }
}

std::array<int, 8> AssignSlots(const SlotBox& parent, const std::array<SlotBox, 8>& children,
                               int count) {
    float cost[8][8];
    for (int c = 0; c < count; ++c) {
        float d[3];
        for (int axis = 0; axis < 3; ++axis) {
            // An eighth of the sum of both corners' offsets: it cannot overflow.
            d[axis] = (children[c].lo[axis] * 0.125F - parent.lo[axis] * 0.125F) +
                      (children[c].hi[axis] * 0.125F - parent.hi[axis] * 0.125F);
        }
        for (int slot = 0; slot < 8; ++slot) {
            cost[c][slot] = ((slot & 4) != 0 ? -d[0] : d[0]) + ((slot & 2) != 0 ? -d[1] : d[1]) +
                            ((slot & 1) != 0 ? -d[2] : d[2]);
        }
    }
    // The cheapest pair first. A child's best slot changes only when another child takes it.
    std::array<int, 8> slotOf{};
    std::array<int, 8> bestSlot{};
    std::uint32_t freeSlots = 0xffU;
    const auto findSlot = [&](int c) {
        int best = -1;
        for (std::uint32_t left = freeSlots; left != 0; left &= left - 1U) {
            const int slot = __builtin_ctz(left);
            best = best < 0 || cost[c][slot] < cost[c][best] ? slot : best;
        }
        bestSlot[c] = best;
    };
    for (int c = 0; c < count; ++c) {
        findSlot(c);
    }
    for (std::uint32_t freeChildren = (1U << count) - 1U; freeChildren != 0;) {
        int chosen = -1;
        for (std::uint32_t left = freeChildren; left != 0; left &= left - 1U) {
            const int c = __builtin_ctz(left);
            chosen =
                chosen < 0 || cost[c][bestSlot[c]] < cost[chosen][bestSlot[chosen]] ? c : chosen;
        }
        const int taken = bestSlot[chosen];
        slotOf[chosen] = taken;
        freeChildren &= ~(1U << chosen);
        freeSlots &= ~(1U << taken);
        for (std::uint32_t left = freeChildren; left != 0; left &= left - 1U) {
            if (bestSlot[__builtin_ctz(left)] == taken) {
                findSlot(__builtin_ctz(left));
            }
        }
    }
    return slotOf;
}

} // namespace hds
