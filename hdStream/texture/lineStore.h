// SPDX-License-Identifier: Apache-2.0
// The lines of one prepared texture, in groups: a group is a page of the persistent store, or,
// where the store does not take it, memory of its own. So one line is read without the rest of a
// large texture, and a texture larger than memory can be prepared. Explained in docs/texturing.md,
// section "Where lines are kept".
#pragma once

#include "hdStream/persist/pageStore.h"
#include "kernels/shared/texture.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace hds {

using TextureLine = std::array<std::uint32_t, HDS_LINE_BYTES / 4>;

/// Filled by one thread at a time; reading is thread-safe, also meanwhile.
class LineStore {
public:
    static constexpr std::uint32_t kGroupLines = 128; ///< 64 KiB: what one read of a page verifies

    /// \param store may be null
    /// \param key of the texture; the key of a group is made of it and of the group's number
    LineStore(std::shared_ptr<PageStore> store, const PageKey& key, std::uint32_t numLines);

    /// Whether a line is complete, here or in the store.
    bool Has(std::uint32_t line) const;

    /// Chooses what is to be filled in: all lines of those groups that are not there, from the
    /// group of `first` on. Without such a call it is all lines.
    void BeginFilling(std::uint32_t first);
    /// The same for the groups of some lines.
    void BeginFilling(const std::vector<std::uint32_t>& lines);
    bool IsFilling(std::uint32_t line) const { return _groups[line / kGroupLines].isFilling; }

    /// A line to be filled in, zeros at first; stays in place until it is complete.
    TextureLine* Open(std::uint32_t line);
    /// Says that lines [first, first + count) are filled in, once each.
    void Complete(std::uint32_t first, std::uint32_t count);

    /// Takes all groups out of the store again: they are not of the file that the key names.
    void ForgetSaved() const;

    /// Copies a line. \return false when its group is not there (any more).
    bool Read(std::uint32_t line, TextureLine* out) const;
    /// Copies lines [first, first + count) to `out`. \return false when one is not there.
    bool ReadRun(std::uint32_t first, std::uint32_t count, TextureLine* out) const;

    /// Bytes of memory that groups which the store did not take occupy.
    std::uint64_t HostBytes() const;

private:
    struct Group {
        ~Group() { delete page.load(std::memory_order_relaxed); }

        std::vector<TextureLine> lines; ///< while it is filled, and when the store did not take it
        std::uint32_t numComplete = 0;
        bool isFilling = true;
        std::atomic<const TextureLine*> data{nullptr}; ///< of complete `lines`
        /// Of the store, once a line was read of it; owned.
        mutable std::atomic<const OpenedPage*> page{nullptr};
    };

    std::uint32_t GroupSize(std::uint32_t group) const;
    PageKey KeyOf(std::uint32_t group) const;
    bool Keep(std::uint32_t group) const;
    const OpenedPage* PageOf(std::uint32_t group) const;
    bool ReadOfGroup(std::uint32_t line, std::uint32_t count, TextureLine* out) const;

    std::shared_ptr<PageStore> _store;
    PageKey _key;
    std::uint32_t _numLines;
    std::vector<Group> _groups;
};

} // namespace hds
