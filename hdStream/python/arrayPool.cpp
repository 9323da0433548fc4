// SPDX-License-Identifier: Apache-2.0
#include "hdStream/python/arrayPool.h"

#include "hdStream/session/frontEndArrays.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <string_view>

namespace hds::python {

namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20U;
constexpr std::size_t kNumKnown = 1024;
constexpr std::uint32_t kMostUses = 1000;
/// What arrays begin at multiples of.
constexpr std::size_t kAlignment = 16;

} // namespace

struct ArrayPool::Block {
    Block() : bytes(new std::uint8_t[kBlockBytes]) { arrayBlockBytes += kBlockBytes; }
    ~Block() { arrayBlockBytes -= kBlockBytes; }
    Block(const Block&) = delete;
    Block& operator=(const Block&) = delete;

    std::unique_ptr<std::uint8_t[]> bytes; ///< not initialised: memory is taken as it is filled
    std::size_t used = 0;
};

ArrayPool::ArrayPool() : _known(kNumKnown) {}

ArrayPool::~ArrayPool() = default;

ArrayBytes ArrayPool::Add(const void* data, std::size_t bytes) {
    const std::size_t hash = std::hash<std::string_view>()({static_cast<const char*>(data), bytes});
    Known& known = _known[hash % kNumKnown];
    if (known.hash == hash && known.bytes == bytes) {
        auto block = known.block.lock();
        if (block && std::memcmp(known.data, data, bytes) == 0) {
            known.uses = std::min(known.uses + 1, kMostUses);
            return {std::move(block), known.data, bytes};
        }
    }
    if (!_block || _block->used + bytes > kBlockBytes) {
        _block = std::make_shared<Block>();
    }
    std::uint8_t* copy = _block->bytes.get() + _block->used;
    std::memcpy(copy, data, bytes);
    _block->used += (bytes + kAlignment - 1) / kAlignment * kAlignment;
    if (known.uses > 0 && !known.block.expired()) {
        --known.uses;
    } else {
        known = {hash, _block, copy, bytes};
    }
    return {_block, copy, bytes};
}

} // namespace hds::python
