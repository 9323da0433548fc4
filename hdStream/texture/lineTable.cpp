// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/lineTable.h"

#include <algorithm>

namespace hds {

LineTable::LineTable() : _words(HDS_LINE_PAGE_WORDS, HDS_NONE), _wasSet(HDS_LINE_PAGE_WORDS) {}

void LineTable::Reserve(std::uint32_t numLines) {
    const std::uint32_t needed = (numLines + HDS_LINE_PAGE_WORDS - 1U) >> HDS_LINE_PAGE_SHIFT;
    if (needed <= _numPages) {
        return;
    }
    const std::uint32_t numPages = std::max(needed, 2 * _numPages);
    const std::uint32_t shift = numPages - _numPages;
    for (std::uint32_t page = 0; page < _numPages; ++page) {
        _words[page] += shift;
    }
    // New pages share the empty one, which comes after the first level.
    _words.insert(_words.begin() + _numPages, shift, numPages);
    _wasSet.insert(_wasSet.begin() + _numPages, shift, false);
    _numPages = numPages;
    _changed.clear();
    _isMoved = true;
}

bool LineTable::Set(std::uint32_t line, std::uint32_t slot) {
    const std::uint32_t page = line >> HDS_LINE_PAGE_SHIFT;
    if (_words[page] == _numPages) { // the empty one
        if (slot == HDS_NONE) {
            return false;
        }
        _words[page] = static_cast<std::uint32_t>(_words.size());
        _words.resize(_words.size() + HDS_LINE_PAGE_WORDS, HDS_NONE);
        _wasSet.resize(_words.size());
        _changed.push_back(page);
    }
    const std::uint32_t word = WordOf(line);
    const bool wasSet = _wasSet[word];
    _wasSet[word] = wasSet || slot != HDS_NONE;
    _words[word] = slot;
    _changed.push_back(word);
    return wasSet;
}

void LineTable::Clear() {
    std::fill(_words.begin() + _numPages, _words.end(), HDS_NONE);
    _changed.clear();
    _isMoved = true;
}

std::vector<shared::HdsTableUpdate> LineTable::TakeUpdates(bool* isMoved) {
    std::sort(_changed.begin(), _changed.end());
    _changed.erase(std::unique(_changed.begin(), _changed.end()), _changed.end());
    std::vector<shared::HdsTableUpdate> updates;
    for (const std::uint32_t word : _changed) {
        updates.push_back({word, _words[word]});
    }
    *isMoved = _isMoved;
    _changed.clear();
    _isMoved = false;
    return updates;
}

} // namespace hds
