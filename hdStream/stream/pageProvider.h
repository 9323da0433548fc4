// SPDX-License-Identifier: Apache-2.0
// What the streaming layer knows of its payload: numbered pages of bytes. Geometry and textures
// implement it; neither triangles nor texels are known here.
// Explained in docs/architecture.md.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hds {

/// A source of pages. Implementations are thread-safe; but for Drop they are immutable.
class PageProvider {
public:
    virtual ~PageProvider() = default;
    virtual std::uint32_t NumPages() const = 0;
    /// Bytes of a page, a multiple of 16; 0 for a page that does not exist.
    virtual std::uint64_t PageBytes(std::uint32_t page) const = 0;
    /// What tells pages apart across providers: two pages with the same id have the same bytes.
    virtual std::uint64_t PageId(std::uint32_t page) const = 0;
    /// The page's bytes; valid until the next call from this thread.
    virtual const std::uint8_t* Page(std::uint32_t page) const = 0;
    /// A pool holds the page for good: its bytes need not be kept, Page is not called again.
    virtual void Drop(std::uint32_t page) const = 0;
};

} // namespace hds
