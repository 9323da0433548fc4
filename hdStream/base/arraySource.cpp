// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/arraySource.h"

#include "hdStream/base/error.h"
#include "hdStream/base/hash.h"

#include <atomic>
#include <utility>

namespace hds {

namespace {

std::atomic<std::uint64_t> allBytes{0};
std::atomic<std::uint64_t> allKeptBytes{0};
std::atomic<std::uint64_t> allReadBytes{0};

std::array<std::uint64_t, 2> HashOf(const ArrayBytes& array) {
    Hasher hasher;
    AppendParallel(&hasher, array.data, array.bytes);
    return hasher.Words();
}

} // namespace

ArraySource::ArraySource(std::string name, ArrayBytes first, Reader readAgain,
                         std::uint64_t mostKeptBytes)
    : _name(std::move(name)), _bytes(first.bytes), _readAgain(std::move(readAgain)),
      _kept(std::move(first)), _alive(_kept.owner), _data(_kept.data) {
    allBytes += _bytes;
    if ((allKeptBytes += _bytes) > mostKeptBytes) {
        Drop();
    }
}

ArraySource::~ArraySource() {
    allBytes -= _bytes;
    if (_kept.owner) {
        allKeptBytes -= _bytes;
    }
}

ArrayBytes ArraySource::Hold() const {
    ArrayBytes array;
    Hash hash{};
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        if (_kept.owner) {
            return _kept;
        }
        array = {_alive.lock(), _data, _bytes};
        hash = _hash;
    }
    const bool isRead = array.owner == nullptr;
    if (isRead) {
        try {
            array = _readAgain();
        } catch (const Error& error) {
            throw Error(_name + ": cannot be read again: " + error.what(), error.kind());
        }
    }
    // Also what others hold: it may be mapped from a file that has been written into.
    if (array.bytes != _bytes || HashOf(array) != hash) {
        throw Error(_name + ": has changed since the stage was translated");
    }
    if (isRead) {
        allReadBytes += _bytes;
        const std::lock_guard<std::mutex> lock(_mutex);
        _alive = array.owner;
        _data = array.data;
    }
    return array;
}

void ArraySource::Drop() const {
    ArrayBytes kept;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        kept = _kept;
    }
    if (!kept.owner) {
        return;
    }
    const Hash hash = HashOf(kept);
    const std::lock_guard<std::mutex> lock(_mutex);
    if (_kept.owner) {
        _hash = hash;
        _kept = {};
        allKeptBytes -= _bytes;
    }
}

ArrayCounts ArraySource::Counts() {
    return {allBytes, allKeptBytes, allReadBytes};
}

} // namespace hds
