// SPDX-License-Identifier: Apache-2.0
// Which segments of a curve are drawn, and which of them are neighbours: those that stand still
// (all their points are one) lie in the ball at the end of another and are passed over. Internal to
// geometry. Explained in docs/curves.md.
#pragma once

#include <cstdint>
#include <optional>

namespace hds {

/// Of a segment: the power of two of its pieces (kLevelBits), and kStands; or one of the last two.
using SegmentState = std::uint8_t;
constexpr SegmentState kLevelBits = 0x07;
/// The curve stands still where the segment ends, so that its vertices alone do not tell how it
/// goes on.
constexpr SegmentState kStands = 0x10;
constexpr SegmentState kStill = 0xfe;   ///< all its points are one in all poses: not drawn
constexpr SegmentState kDropped = 0xff; ///< not drawn: content that cannot be used

inline bool IsDrawn(SegmentState state) {
    return state < kStill;
}

/// The states of one curve's segments, owned by another.
struct CurveStates {
    const SegmentState* states;
    std::uint32_t count;
    bool isPeriodic;

    /// The next drawn segment before (step -1) or behind (1) a drawn one; nothing where the curve
    /// ends.
    std::optional<std::uint32_t> Next(std::uint32_t segment, int step) const;
};

/// To be called once all states of a curve are known: where none of the segments between two ends
/// is drawn and one is still, the first such is: a ball. Marks those before still ones (kStands).
void SettleStates(SegmentState* states, std::uint32_t count, bool isPeriodic);

} // namespace hds
