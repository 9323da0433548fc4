// SPDX-License-Identifier: Apache-2.0
// Pages for tests of pools: what is in a page follows from its id.
#pragma once

#include "hdStream/stream/pageProvider.h"

#include <cstdint>
#include <numeric>
#include <set>
#include <vector>

namespace hds::test {

/// Page of id i: an odd count of 16 bytes, or none; its bytes are a function of i.
inline std::vector<std::uint8_t> BytesOf(std::uint64_t id) {
    std::vector<std::uint8_t> bytes(id % 5 == 3 ? 0 : 16 * (1 + (id * 7919) % 63));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::uint8_t>(id * 31 + i);
    }
    return bytes;
}

class FakePages : public PageProvider {
public:
    explicit FakePages(std::vector<std::uint64_t> ids)
        : _ids(std::move(ids)), _pages(_ids.size()), _isKept(_ids.size()) {
        for (const std::uint64_t id : _ids) {
            _total += BytesOf(id).size();
        }
    }
    std::uint32_t NumPages() const override { return static_cast<std::uint32_t>(_ids.size()); }
    std::uint64_t PageBytes(std::uint32_t page) const override {
        return BytesOf(_ids[page]).size();
    }
    std::uint64_t PageId(std::uint32_t page) const override { return _ids[page]; }
    const std::uint8_t* Page(std::uint32_t page) const override { return _pages[page].data(); }
    bool IsExact(std::uint32_t) const override { return true; }
    std::uint32_t NumOuterPages() const override { return _numOuter; }
    /// The first `count` pages are such that others are reached through.
    void SetOuterPages(std::uint32_t count) { _numOuter = count; }
    bool ShouldStay(std::uint32_t page) const override { return _shouldStay.count(page) > 0; }
    void Keep(std::vector<std::uint32_t> pages) {
        _shouldStay = std::set<std::uint32_t>(pages.begin(), pages.end());
    }
    void Prepare(const std::vector<std::uint32_t>& pages,
                 const IsCancelled& isCancelled = {}) override {
        _numAskable += isCancelled ? 1 : 0;
        for (const std::uint32_t page : pages) {
            _pages[page] = BytesOf(_ids[page]);
            _isKept[page] = true;
            ++_numPrepared;
        }
    }
    bool Locate(std::uint32_t page, MappedPage* mapped) override {
        if (_file.empty() || !_isKept[page]) {
            return false;
        }
        *mapped = {_file.data(), _file.size(), _offsets[page]};
        return true;
    }
    /// Gives pages that have been prepared places in a file of their own.
    void MapPages() {
        _file.reserve(_total + 64); // stays where it is
        _offsets.resize(_ids.size());
        for (std::size_t page = 0; page < _ids.size(); ++page) {
            const std::vector<std::uint8_t> bytes = BytesOf(_ids[page]);
            _offsets[page] = _file.size();
            _file.insert(_file.end(), bytes.begin(), bytes.end());
        }
        _file.resize(_file.size() + 64);
    }
    void Drop(std::uint32_t page) override { _pages[page].clear(); }
    bool HasData(std::uint32_t page) const { return !_pages[page].empty(); }
    std::uint64_t TotalBytes() const { return _total; }
    std::size_t NumPrepared() const { return _numPrepared; }
    /// Calls of Prepare that could be cancelled.
    std::size_t NumAskable() const { return _numAskable; }

private:
    std::vector<std::uint64_t> _ids;
    std::vector<std::vector<std::uint8_t>> _pages;
    std::set<std::uint32_t> _shouldStay;
    std::uint32_t _numOuter = 0;
    std::vector<bool> _isKept;       ///< in the file, once prepared
    std::vector<std::uint8_t> _file; ///< empty: no page can be located
    std::vector<std::uint64_t> _offsets;
    std::uint64_t _total = 0;
    std::size_t _numPrepared = 0;
    std::size_t _numAskable = 0;
};

/// Ids begin, begin + 1, ... end - 1.
inline std::vector<std::uint64_t> Range(std::uint64_t begin, std::uint64_t end) {
    std::vector<std::uint64_t> ids(end - begin);
    std::iota(ids.begin(), ids.end(), begin);
    return ids;
}

} // namespace hds::test
