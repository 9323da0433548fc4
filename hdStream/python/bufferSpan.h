// SPDX-License-Identifier: Apache-2.0
// Python buffers (numpy arrays, Vt arrays) as SharedSpans, without a copy unless they are small,
// and back. The span keeps the buffer alive. A buffer may be dropped by any thread, with or without
// the GIL: those dropped without it wait in a list that the main thread empties under the GIL, so
// that the core never blocks on Python.
#pragma once

#include "hdStream/python/stageArray.h"
#include "hdStream/session/session.h"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace hds::python {

/// An exported Python buffer and the reference that keeps it. Created and destroyed under the GIL.
class HeldBuffer {
public:
    /// \throws nanobind::type_error unless `object` exports a C-contiguous buffer of `format`.
    HeldBuffer(nanobind::handle object, char format, std::size_t itemBytes, const char* what);
    ~HeldBuffer();
    HeldBuffer(const HeldBuffer&) = delete;
    HeldBuffer& operator=(const HeldBuffer&) = delete;

    const void* data() const { return _view.buf; }
    std::size_t numBytes() const { return static_cast<std::size_t>(_view.len); }
    std::size_t numItems() const;
    /// Items of all dimensions but the first; 1 for a flat array.
    std::size_t itemsPerRow() const;

private:
    Py_buffer _view{};
};

/// What a span shares: the buffer itself or, of a small array that OpenUSD does not map, a copy in
/// the pool of the process (arrayPool.h). Call under the GIL.
ArrayBytes KeepBuffer(std::unique_ptr<HeldBuffer> buffer, bool isOfFloats);

/// Shared ownership of a buffer whose last owner may be any thread. Call under the GIL.
std::shared_ptr<const void> ShareBuffer(std::unique_ptr<HeldBuffer> buffer);

/// A Python object that any thread may drop.
std::shared_ptr<nanobind::object> ShareObject(nanobind::object object);

/// Number of buffers that wait to be released by the main thread.
std::size_t NumBuffersToRelease();

template <typename T>
constexpr char BufferFormat();
template <>
constexpr char BufferFormat<float>() {
    return 'f';
}
template <>
constexpr char BufferFormat<double>() {
    return 'd';
}
template <>
constexpr char BufferFormat<std::uint16_t>() {
    return 'e'; // the bits of halves
}
template <>
constexpr char BufferFormat<std::int32_t>() {
    return 'i';
}

/// The items of a buffer, or of a StageArray, as a span and their number a row. Call under the GIL.
/// \param what names the member in the error.
/// \throws nanobind::type_error for another item type or a strided buffer.
template <typename T>
std::pair<SharedSpan<T>, std::size_t> SpanFromBuffer(nanobind::handle object, const char* what) {
    if (nanobind::isinstance<StageArray>(object)) {
        const auto& array = nanobind::cast<const StageArray&>(object);
        if (array.Format() != BufferFormat<T>()) {
            throw nanobind::type_error((std::string(what) + ": items of another type").c_str());
        }
        return {SharedSpan<T>(array.Source()), array.ItemsPerRow()};
    }
    auto buffer = std::make_unique<HeldBuffer>(object, BufferFormat<T>(), sizeof(T), what);
    const std::size_t itemsPerRow = buffer->itemsPerRow();
    ArrayBytes kept = KeepBuffer(std::move(buffer), std::is_floating_point_v<T>);
    return {SharedSpan<T>(static_cast<const T*>(kept.data), kept.bytes / sizeof(T),
                          std::move(kept.owner)),
            itemsPerRow};
}

/// A read-only numpy array [size / itemsPerRow][itemsPerRow] that shares the span's memory.
template <typename T>
nanobind::object ArrayFromSpan(const SharedSpan<T>& span, std::size_t itemsPerRow) {
    auto held = std::make_unique<SharedSpan<T>>(span.Held());
    nanobind::capsule owner(held.get(), [](void* spanPointer) noexcept {
        delete static_cast<SharedSpan<T>*>(spanPointer);
    });
    const T* data = held.release()->data();
    const std::size_t shape[2] = {span.size() / itemsPerRow, itemsPerRow};
    const std::size_t numDimensions = itemsPerRow == 1 ? 1 : 2;
    return nanobind::cast(
        nanobind::ndarray<nanobind::numpy, const T>(data, numDimensions, shape, owner));
}

} // namespace hds::python
