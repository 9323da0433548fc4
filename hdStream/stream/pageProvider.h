// SPDX-License-Identifier: Apache-2.0
// What the streaming layer knows of its payload: numbered pages of bytes. Geometry and textures
// implement it; neither triangles nor texels are known here.
// Explained in docs/architecture.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace hds {

/// A page in a file that is mapped into memory.
struct MappedPage {
    const std::uint8_t* file = nullptr; ///< its first byte; mapped as long as the process needs it
    std::uint64_t fileBytes = 0;
    std::uint64_t offset = 0; ///< of the page, a multiple of 16
};

/// A source of pages, which are prepared when they are needed. Externally synchronised.
class PageProvider {
public:
    virtual ~PageProvider() = default;
    virtual std::uint32_t NumPages() const = 0;
    /// How many pages, the first ones, others are reached through: one of them and the group of
    /// another page may be needed at once.
    virtual std::uint32_t NumOuterPages() const { return 0; }
    /// Bytes of a page, a multiple of 16: exact once it has been prepared, before that an upper
    /// bound. 0 for a page that does not exist.
    virtual std::uint64_t PageBytes(std::uint32_t page) const = 0;
    /// Whether PageBytes is exact.
    virtual bool IsExact(std::uint32_t page) const = 0;
    /// What tells pages apart across providers: two pages with the same id have the same bytes.
    virtual std::uint64_t PageId(std::uint32_t page) const = 0;
    /// Whether a page is better kept once it has been loaded, as far as a pool has room for such.
    virtual bool ShouldStay(std::uint32_t page) const = 0;
    using IsCancelled = std::function<bool()>;
    /// Makes the bytes of some pages ready, on all cores. Afterwards those of others may be gone.
    /// \param isCancelled asked by this thread while more than these are made; may be empty.
    virtual void Prepare(const std::vector<std::uint32_t>& pages,
                         const IsCancelled& isCancelled = {}) = 0;
    /// The bytes of a page of the last Prepare, valid until the next one.
    virtual const std::uint8_t* Page(std::uint32_t page) const = 0;
    /// Where a page lies in the persistent cache. \return false when it is not there.
    virtual bool Locate(std::uint32_t page, MappedPage* mapped) = 0;
    /// A pool holds the page for good: its bytes need not be kept. They can be prepared again.
    virtual void Drop(std::uint32_t page) = 0;
};

} // namespace hds
