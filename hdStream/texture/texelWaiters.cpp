// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/texelWaiters.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace hds {

namespace {

constexpr std::size_t kShrink = 4;
constexpr std::size_t kGrow = 2;

} // namespace

TexelWaiters::TexelWaiters(std::uint32_t numLaunched, std::vector<std::uint32_t> waiting)
    : _items(std::move(waiting)), _numLaunched(numLaunched), _numWaiting(_items.size()),
      _limit(std::numeric_limits<std::size_t>::max()) {}

void TexelWaiters::Continue(const TexturePool::Outcome& outcome) {
    const bool wasDenied = std::exchange(_isAloneDenied, false);
    if (_numWaiting < _numLaunched) {
        _limit = std::max(_limit, std::min(_limit, _items.size()) * kGrow);
    } else if (outcome.numDenied > 0) {
        _isAloneDenied = _numLaunched == 1;
        if (wasDenied && _isAloneDenied) {
            throw Error("--textureMemory: too small for the texture lines of one surface point");
        }
        _limit = std::max<std::size_t>(1, _numLaunched / kShrink);
    }
}

std::vector<std::uint32_t> TexelWaiters::Take() {
    const std::size_t count = std::min(_limit, _items.size());
    std::vector<std::uint32_t> batch(_items.end() - static_cast<std::ptrdiff_t>(count),
                                     _items.end());
    _items.resize(_items.size() - count);
    _numLaunched = count;
    return batch;
}

void TexelWaiters::Return(const std::vector<std::uint32_t>& waiting) {
    _items.insert(_items.end(), waiting.begin(), waiting.end());
    _numWaiting = waiting.size();
}

} // namespace hds
