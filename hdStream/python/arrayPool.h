// SPDX-License-Identifier: Apache-2.0
// Small arrays of many prims in few large allocations: Python's objects around an array of a
// thousand bytes take as much again.
#pragma once

#include "hdStream/session/session.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace hds::python {

/// Copies of arrays. A block lives as long as one of its arrays. Externally synchronised.
class ArrayPool {
public:
    ArrayPool();
    ~ArrayPool();
    ArrayPool(const ArrayPool&) = delete;
    ArrayPool& operator=(const ArrayPool&) = delete;

    /// Arrays of more bytes take no part in it.
    static constexpr std::size_t kMostBytes = std::size_t{1} << 16U;

    /// A copy of the bytes: an equal one that was added not long ago, where there is one.
    /// \pre 0 < bytes <= kMostBytes.
    ArrayBytes Add(const void* data, std::size_t bytes);

private:
    struct Block;
    struct Known {
        std::size_t hash = 0;
        std::weak_ptr<Block> block;
        const std::uint8_t* data = nullptr;
        std::size_t bytes = 0;
        std::uint32_t uses = 0; ///< what is used often stays among others that are not
    };

    std::shared_ptr<Block> _block; ///< that is being filled
    std::vector<Known> _known;     ///< by the hash
};

} // namespace hds::python
