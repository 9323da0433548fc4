// SPDX-License-Identifier: Apache-2.0
// The geometry payload of the streaming layer: page 2 * chunk is the chunk's geometry page, page
// 2 * chunk + 1 its attribute page (kernels/shared/geometry.h).
#pragma once

#include "hdStream/stream/pageProvider.h"

#include <vector>

namespace hds {

/// Prepared pages of all chunks, in chunk order. Immutable once filled; then thread-safe.
class GeometryPages final : public PageProvider {
public:
    explicit GeometryPages(std::uint32_t numChunks) : _pages(2 * std::size_t{numChunks}) {}

    void SetChunk(std::uint32_t chunk, std::vector<std::uint8_t> geometry,
                  std::vector<std::uint8_t> attributes) {
        _pages[2 * std::size_t{chunk}] = std::move(geometry);
        _pages[2 * std::size_t{chunk} + 1] = std::move(attributes);
    }

    std::uint32_t NumPages() const override { return static_cast<std::uint32_t>(_pages.size()); }
    std::uint64_t PageBytes(std::uint32_t page) const override { return _pages[page].size(); }
    const std::uint8_t* Page(std::uint32_t page) const override { return _pages[page].data(); }

private:
    std::vector<std::vector<std::uint8_t>> _pages;
};

} // namespace hds
