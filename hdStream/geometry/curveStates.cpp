// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/curveStates.h"

#include <algorithm>

namespace hds {

std::optional<std::uint32_t> CurveStates::Next(std::uint32_t segment, int step) const {
    std::uint32_t at = segment;
    for (std::uint32_t i = 0; i < count; ++i) {
        const bool isLast = step > 0 ? at + 1 == count : at == 0;
        if (isLast && !isPeriodic) {
            return std::nullopt;
        }
        if (isLast) {
            at = step > 0 ? 0 : count - 1;
        } else {
            at = step > 0 ? at + 1 : at - 1;
        }
        if (states[at] != kStill) {
            return states[at] == kDropped ? std::nullopt : std::optional(at);
        }
    }
    return std::nullopt; // all are still
}

void SettleStates(SegmentState* states, std::uint32_t count, bool isPeriodic) {
    if (std::find(states, states + count, kStill) == states + count) {
        return;
    }
    // A closed curve is walked from a segment that is dropped, so that no row goes over its seam.
    SegmentState* const seam = std::find(states, states + count, kDropped);
    const auto first =
        isPeriodic && seam != states + count ? static_cast<std::uint32_t>(seam - states) : 0U;
    const auto at = [&](std::uint64_t i) {
        return static_cast<std::uint32_t>((first + i) % count);
    };
    const bool isRing = isPeriodic && seam == states + count;
    for (std::uint32_t begin = 0, end = 0; begin < count; begin = end + 1) {
        bool isAnyDrawn = false;
        for (end = begin; end < count && states[at(end)] != kDropped; ++end) {
            isAnyDrawn = isAnyDrawn || IsDrawn(states[at(end)]);
        }
        if (end > begin && !isAnyDrawn) {
            states[at(begin)] = 0;
        }
        for (std::uint32_t i = begin; i < end; ++i) {
            const bool hasNext = i + 1 < end || isRing;
            if (hasNext && IsDrawn(states[at(i)]) && states[at(i + 1)] == kStill) {
                states[at(i)] |= kStands;
            }
        }
    }
}

} // namespace hds
