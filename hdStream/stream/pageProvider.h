// SPDX-License-Identifier: Apache-2.0
// What the streaming layer knows of its payload: numbered pages of bytes. Geometry and textures
// implement it; neither triangles nor texels are known here.
// Explained in docs/architecture.md.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hds {

/// A source of pages. Implementations are immutable and thread-safe.
class PageProvider {
public:
    virtual ~PageProvider() = default;
    virtual std::uint32_t NumPages() const = 0;
    /// Bytes of a page, a multiple of 16; 0 for a page that does not exist.
    virtual std::uint64_t PageBytes(std::uint32_t page) const = 0;
    /// The page's bytes; valid until the next call from this thread.
    virtual const std::uint8_t* Page(std::uint32_t page) const = 0;
};

} // namespace hds
