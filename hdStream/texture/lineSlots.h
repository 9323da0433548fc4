// SPDX-License-Identifier: Apache-2.0
// Which line lies in which slot of the texture pool: the set-associative part, its overflow, and
// the slots that are never given away. Explained in docs/texturing.md.
#pragma once

#include "hdStream/base/fields.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace hds {

/// How a pool's slots are used: first the overflow, then the sets, then the pinned ones.
struct SlotPlan {
    static constexpr std::uint32_t kWays = 8;

    std::uint32_t numOverflow = 0;
    std::uint32_t numSets = 0;
    std::uint32_t numPinned = 0;

    std::uint32_t NumSlots() const { return numOverflow + kWays * numSets + numPinned; }
    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(SlotPlan, numOverflow), HDS_FIELD(SlotPlan, numSets),
                         HDS_FIELD(SlotPlan, numPinned));
    }
};

/// Fewest slots with which every item can be shaded that reads `linesPerItem` lines.
std::uint32_t FewestSlots(std::uint32_t linesPerItem);

/// Slots with which `maxLines` lines never come into each other's way.
std::uint64_t EnoughSlots(std::uint64_t maxLines, std::uint32_t linesPerItem,
                          std::uint32_t numPinned);

/// Divides `numSlots`: as many as an item needs can be used at once, whatever sets its lines fall
/// into; at most a quarter of the rest is pinned. \pre numSlots >= FewestSlots(linesPerItem).
SlotPlan MakeSlotPlan(std::uint32_t numSlots, std::uint32_t linesPerItem, std::uint32_t numPinned);

/// The lines in a pool's slots. 8 bytes a slot. Externally synchronised.
class LineSlots {
public:
    /// Stamps of all slots as kernels have left them; called when a line has to leave.
    using ReadStamps = std::function<const std::uint32_t*()>;

    /// A slot for a line, and the line that left it.
    struct Placement {
        std::uint32_t slot;    ///< HDS_NONE: all that the line may take are in use
        std::uint32_t evicted; ///< HDS_NONE: the slot was empty
        bool isConflict;       ///< all of the line's set is in use
    };

    /// \param firstSlot the number of its first slot, among those of other such parts.
    explicit LineSlots(const SlotPlan& plan, std::uint32_t firstSlot = 0);

    /// Finds a slot: an empty one of the sets, the first ones first, so that what is used together
    /// lies together; when all are in use, the one of the line's set that was used least recently,
    /// where one that was used for its first readers alone counts as older, else one of the
    /// overflow. Lines that were used or placed in `epoch` stay.
    Placement Place(std::uint32_t line, std::uint32_t epoch, const ReadStamps& readStamps);
    /// A pinned slot, or HDS_NONE when there is none left. What is in it only leaves by Free.
    std::uint32_t PlacePinned(std::uint32_t line);
    /// Empties a slot that is not empty.
    void Free(std::uint32_t slot);

    /// The line in a slot, or HDS_NONE.
    std::uint32_t Line(std::uint32_t slot) const { return _lines[slot - _firstSlot]; }
    const SlotPlan& Plan() const { return _plan; }
    std::uint32_t NumUsed() const { return _numUsed; }
    /// The most slots that were in use at a time since BeginMost.
    std::uint32_t MostUsed() const { return _mostUsed; }
    void BeginMost() { _mostUsed = _numUsed; }
    std::uint32_t NumPinned() const {
        return _plan.numPinned - static_cast<std::uint32_t>(_freePinned.size());
    }

private:
    std::uint32_t EndOfSets() const { return _plan.NumSlots() - _plan.numPinned; }
    std::uint32_t TakeEmptyOfSets();
    void CountPlaced();
    std::uint32_t FindEmpty(std::uint32_t begin, std::uint32_t end) const;
    std::uint32_t FindOldest(std::uint32_t begin, std::uint32_t end, std::uint32_t epoch,
                             const std::uint32_t* stamps) const;

    SlotPlan _plan;
    std::uint32_t _firstSlot;
    /// Here and below slots count from the first one of this part.
    std::vector<std::uint32_t> _lines;
    std::vector<std::uint32_t> _placedIn; ///< epoch
    std::vector<std::uint32_t> _freePinned;
    std::uint32_t _firstUnused;        ///< slots of sets from here on were never in use
    std::vector<std::uint32_t> _freed; ///< slots of sets that Free has emptied
    std::uint32_t _numUsed = 0;
    std::uint32_t _mostUsed = 0;
};

} // namespace hds
