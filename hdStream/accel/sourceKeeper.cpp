// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/sourceKeeper.h"

#include <algorithm>

namespace hds {

// What is dropped is destroyed without the lock: it may take a while, or the locks of others.

void SourceKeeper::SetLimit(std::uint64_t bytes) {
    Order dropped;
    const std::lock_guard<std::mutex> lock(_mutex);
    _limit = bytes;
    MakeRoom(&dropped);
}

std::uint64_t SourceKeeper::Bytes() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    return _bytes;
}

std::uint64_t SourceKeeper::PeakBytes() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    return _peakBytes;
}

void SourceKeeper::BeginStatistics() {
    _numMade = 0;
    _numAhead = 0;
    const std::lock_guard<std::mutex> lock(_mutex);
    _peakBytes = _bytes;
}

void SourceKeeper::Use(const void* owner, const std::shared_ptr<const void>& object,
                       std::uint64_t bytes) {
    Order dropped;
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto place = _places.find(owner);
    if (place != _places.end()) {
        _order.splice(_order.end(), _order, place->second);
        return;
    }
    _places[owner] = _order.insert(_order.end(), {owner, object, bytes});
    _bytes += bytes;
    MakeRoom(&dropped);
    _peakBytes = std::max(_peakBytes, _bytes);
}

void SourceKeeper::Forget(const void* owner) {
    Order dropped;
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto place = _places.find(owner);
    if (place != _places.end()) {
        Take(place->second, &dropped);
    }
}

void SourceKeeper::MakeRoom(Order* dropped) {
    while (_bytes > _limit && _order.size() > 1) {
        Take(_order.begin(), dropped);
    }
}

void SourceKeeper::Take(Order::iterator place, Order* dropped) {
    _bytes -= place->bytes;
    _places.erase(place->owner);
    dropped->splice(dropped->end(), _order, place);
}

} // namespace hds
