// SPDX-License-Identifier: Apache-2.0
// A chunk's two pages, made when they are first needed. Shared by the scene versions that have the
// chunk. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/pageMaker.h"
#include "hdStream/base/apart.h"
#include "hdStream/stream/pageProvider.h"
#include "kernels/shared/geometry.h"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace hds {

/// Pages HDS_PAGE_GEOMETRY and HDS_PAGE_ATTRIBUTES of a chunk. Different objects may be used by
/// different threads at once, one object by one thread.
class ChunkPages {
public:
    static constexpr std::uint32_t kNumPages = 2;

    /// Where pages have come from; MadeAlways: they are never looked for in the store
    /// (PageMaker::Key).
    enum class Made { Loaded, Built, MadeAlways };

    /// Takes ids that no other page of the process has. \param chunk of the maker.
    ChunkPages(std::shared_ptr<const PageMaker> maker, std::uint32_t chunk);

    const PageMaker& Maker() const { return *_maker; }
    std::uint64_t Id(std::uint32_t page) const { return _firstId + page; }
    /// Exact once made, before that an upper bound.
    std::uint64_t Bytes(std::uint32_t page) const { return _bytes[page]; }
    bool IsExact() const { return _isExact; }
    /// Looks for exact sizes in the store.
    void FindSizes();
    const std::vector<std::uint8_t>& Data(std::uint32_t page) const { return (*_data)[page]; }
    /// Whether a page is there, or does not exist.
    bool HasData(std::uint32_t page) const { return !Data(page).empty() || _bytes[page] == 0; }
    std::uint64_t DataBytes() const { return Data(0).size() + Data(1).size(); }

    /// Makes the pages that are asked for ready: from the store, or else both are built and kept
    /// there. \param isWanted one flag a page.
    Made Prepare(const std::array<bool, kNumPages>& isWanted);
    /// Where a page lies in the store, mapped. \return false when it is not there.
    bool Locate(std::uint32_t page, MappedPage* mapped);
    void Drop(std::uint32_t page);

private:
    bool Load(const std::array<bool, kNumPages>& isWanted);

    std::shared_ptr<const PageMaker> _maker;
    std::uint32_t _chunk;
    std::uint64_t _firstId;
    bool _isExact = false;
    std::array<std::uint64_t, kNumPages> _bytes{};
    Apart<ChunkBytes> _data; ///< of a page empty: not there now
};

} // namespace hds
