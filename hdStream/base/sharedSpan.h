// SPDX-License-Identifier: Apache-2.0
// A read-only array view that keeps its memory alive through a type-erased owner.
// Front ends hand VtArrays, numpy arrays or our own vectors to the core without a copy. Large
// arrays of a scene may be away: then the view knows where they are read again, and has to be held.
#pragma once

#include "hdStream/base/arraySource.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace hds {

/// Read-only view of `size()` elements plus shared ownership of whatever holds them.
/// Copying copies the view and the owner's reference. Thread-safe as std::shared_ptr is.
template <typename T>
class SharedSpan {
public:
    SharedSpan() = default;
    SharedSpan(const T* data, std::size_t size, std::shared_ptr<const void> owner)
        : _data(data), _size(size), _owner(std::move(owner)) {}
    /// An array that is away.
    explicit SharedSpan(std::shared_ptr<const ArraySource> source)
        : _size(source->Bytes() / sizeof(T)), _owner(std::move(source)) {}
    /// Takes a vector over.
    SharedSpan(
        std::vector<T> values) { // NOLINT(google-explicit-constructor): a conversion by design
        auto held = std::make_shared<const std::vector<T>>(std::move(values));
        _data = held->data();
        _size = held->size();
        _owner = std::move(held);
    }

    /// Where the array is read again; null: it is in memory. What is away has a size, no elements.
    const ArraySource* Source() const {
        return _data == nullptr && _size > 0 ? static_cast<const ArraySource*>(_owner.get())
                                             : nullptr;
    }
    /// The array in memory, as long as the result lives. \throws Error where it cannot be read.
    SharedSpan Held() const {
        const ArraySource* source = Source();
        if (source == nullptr) {
            return *this;
        }
        ArrayBytes array = source->Hold();
        return {static_cast<const T*>(array.data), _size, std::move(array.owner)};
    }

    const T* data() const { return _data; }
    std::size_t size() const { return _size; }
    bool empty() const { return _size == 0; }
    const T& operator[](std::size_t i) const { return _data[i]; }
    const T* begin() const { return _data; }
    const T* end() const { return _data + _size; }

    /// Whether the values are equal, wherever they lie.
    bool operator==(const SharedSpan& other) const {
        if (_size != other._size || (_data == other._data && _owner == other._owner)) {
            return _size == other._size;
        }
        const SharedSpan mine = Held();
        const SharedSpan others = other.Held();
        return mine._data == others._data || std::equal(mine.begin(), mine.end(), others.begin());
    }

private:
    const T* _data = nullptr;
    std::size_t _size = 0;
    std::shared_ptr<const void> _owner;
};

} // namespace hds
