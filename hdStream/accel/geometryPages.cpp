// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/geometryPages.h"

#include <atomic>
#include <utility>

namespace hds {

namespace {

std::uint64_t NextPageId() {
    static std::atomic<std::uint64_t> next{1};
    return next.fetch_add(1, std::memory_order_relaxed);
}

} // namespace

PreparedPage::PreparedPage(std::vector<std::uint8_t> data)
    : _id(NextPageId()), _bytes(data.size()), _data(std::move(data)) {}

} // namespace hds
