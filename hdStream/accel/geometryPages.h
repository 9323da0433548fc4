// SPDX-License-Identifier: Apache-2.0
// The geometry payload of the streaming layer: page 2 * chunk is the chunk's geometry page, page
// 2 * chunk + 1 its attribute page (kernels/shared/geometry.h).
#pragma once

#include "hdStream/stream/pageProvider.h"

#include <memory>
#include <vector>

namespace hds {

/// Bytes of a page with an identity. Shared by the scene versions that have the page.
class PreparedPage {
public:
    /// Takes the bytes and an id that no other page of the process has.
    explicit PreparedPage(std::vector<std::uint8_t> data);

    std::uint64_t Id() const { return _id; }
    std::uint64_t Bytes() const { return _bytes; }
    const std::uint8_t* Data() const { return _data.data(); }
    void Drop() { std::vector<std::uint8_t>().swap(_data); }

private:
    std::uint64_t _id;
    std::uint64_t _bytes;
    std::vector<std::uint8_t> _data; ///< empty once dropped
};

/// Prepared pages of all chunks, in chunk order.
class GeometryPages final : public PageProvider {
public:
    void AddChunk(std::shared_ptr<PreparedPage> geometry,
                  std::shared_ptr<PreparedPage> attributes) {
        _pages.push_back(std::move(geometry));
        _pages.push_back(std::move(attributes));
    }

    std::uint32_t NumPages() const override { return static_cast<std::uint32_t>(_pages.size()); }
    std::uint64_t PageBytes(std::uint32_t page) const override { return _pages[page]->Bytes(); }
    std::uint64_t PageId(std::uint32_t page) const override { return _pages[page]->Id(); }
    const std::uint8_t* Page(std::uint32_t page) const override { return _pages[page]->Data(); }
    void Drop(std::uint32_t page) const override { _pages[page]->Drop(); }

private:
    std::vector<std::shared_ptr<PreparedPage>> _pages;
};

} // namespace hds
