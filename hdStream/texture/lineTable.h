// SPDX-License-Identifier: Apache-2.0
// The host's copy of the table that leads from a line to its slot (HDS_LINE_PAGE_SHIFT in
// kernels/shared/textureCache.h). Explained in docs/texturing.md.
#pragma once

#include "kernels/shared/textureCache.h"

#include <cstdint>
#include <vector>

namespace hds {

/// A table of two levels whose pages are made when their first line comes: 4 bytes for 256 lines,
/// and 1 KiB for a page. Externally synchronised.
class LineTable {
public:
    LineTable();

    /// Makes room for lines [0, numLines).
    void Reserve(std::uint32_t numLines);
    /// The slot of a line, or HDS_NONE. \pre line < reserved.
    std::uint32_t Slot(std::uint32_t line) const { return _words[WordOf(line)]; }
    /// \return whether the line had a slot before, since ForgetPast. \pre line < reserved.
    bool Set(std::uint32_t line, std::uint32_t slot);
    /// From now on no line had a slot before.
    void ForgetPast() { _wasSet.assign(_words.size(), false); }
    /// No line has a slot any more.
    void Clear();

    /// All words, as kernels read them.
    const std::vector<std::uint32_t>& Words() const { return _words; }
    /// Words that have changed since the last call, each once. \param[out] isMoved changes are not
    /// all: upload Words.
    std::vector<shared::HdsTableUpdate> TakeUpdates(bool* isMoved);

private:
    std::uint32_t WordOf(std::uint32_t line) const {
        return _words[line >> HDS_LINE_PAGE_SHIFT] + (line & (HDS_LINE_PAGE_WORDS - 1U));
    }

    std::uint32_t _numPages = 0; ///< words of the first level; the empty page follows
    std::vector<std::uint32_t> _words;
    std::vector<bool> _wasSet;           ///< by word, since ForgetPast
    std::vector<std::uint32_t> _changed; ///< words, some more than once
    bool _isMoved = true;
};

} // namespace hds
