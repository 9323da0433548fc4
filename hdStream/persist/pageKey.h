// SPDX-License-Identifier: Apache-2.0
// The name of a page: the 128-bit hash of everything its content depends on.
#pragma once

#include "hdStream/base/hash.h"

#include <cstdint>
#include <functional>

namespace hds {

struct PageKey {
    std::uint64_t words[2] = {0, 0};
    bool operator==(const PageKey& other) const {
        return words[0] == other.words[0] && words[1] == other.words[1];
    }
    bool operator!=(const PageKey& other) const { return !(*this == other); }
};

/// \param hasher has been given the code version and all inputs of the page.
inline PageKey MakePageKey(const Hasher& hasher) {
    const auto words = hasher.Words();
    return {{words[0], words[1]}};
}

} // namespace hds

template <>
struct std::hash<hds::PageKey> {
    /// Keys are hashes already.
    std::size_t operator()(const hds::PageKey& key) const noexcept {
        return static_cast<std::size_t>(key.words[0] ^ key.words[1]);
    }
};
