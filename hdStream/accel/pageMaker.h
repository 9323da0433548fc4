// SPDX-License-Identifier: Apache-2.0
// What the pages of chunks are made of, and where they are kept. Geometry and the instances of a
// scene implement it.
#pragma once

#include "hdStream/persist/pageStore.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace hds {

/// The bytes of a chunk's pages, HDS_PAGE_GEOMETRY and HDS_PAGE_ATTRIBUTES.
using ChunkBytes = std::array<std::vector<std::uint8_t>, 2>;

/// Makes the pages of numbered chunks. Immutable, thread-safe; the same chunk has the same bytes
/// however often it is made.
class PageMaker {
public:
    virtual ~PageMaker() = default;
    /// Upper bounds of the bytes of a chunk's pages, multiples of 16; 0: there is no such page.
    virtual std::array<std::uint64_t, 2> BoundBytes(std::uint32_t chunk) const = 0;
    virtual ChunkBytes Make(std::uint32_t chunk) const = 0;

    /// Between these two several chunks may be made: what they are all made of is not made twice.
    virtual void BeginMaking() const {}
    virtual void EndMaking() const {}
    /// Between them, after those that are wanted: makes chunks that nobody has asked for, and keeps
    /// them in the store, where that saves time. \param isCancelled asked before each of them, on
    /// any thread.
    virtual void MakeAhead(const std::function<bool()>& isCancelled) const {
        static_cast<void>(isCancelled);
    }

    /// Where finished pages are kept; null: nowhere.
    virtual PageStore* Store() const = 0;
    /// The name of a page in the store before it is made. Nothing: pages are made sooner than read,
    /// and kept only where they are to be mapped, by the hash of their bytes.
    virtual std::optional<PageKey> Key(std::uint32_t chunk, std::uint32_t page) const = 0;
};

} // namespace hds
