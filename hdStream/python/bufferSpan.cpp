// SPDX-License-Identifier: Apache-2.0
#include "hdStream/python/bufferSpan.h"

#include "hdStream/python/arrayPool.h"

#include <mutex>
#include <string>

#ifdef Py_LIMITED_API
// Every CPython has it; only the headers of the stable ABI leave it out.
extern "C" int PyGILState_Check(void);
#endif

namespace nb = nanobind;

namespace hds::python {

namespace {

/// Buffers dropped by threads without the GIL. Thread-safe.
class ReleaseList {
public:
    /// Keeps the buffer for Drain and asks the main thread to call it.
    void Add(HeldBuffer* buffer) {
        const std::lock_guard<std::mutex> lock(_mutex);
        _buffers.emplace_back(buffer);
        if (!_isScheduled) {
            // When Python's own list of calls is full, the next Add or ShareBuffer tries again.
            _isScheduled = Py_AddPendingCall(&ReleaseList::OnPendingCall, this) == 0;
        }
    }

    /// Releases everything. Call under the GIL.
    void Drain() {
        std::vector<std::unique_ptr<HeldBuffer>> buffers;
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            buffers.swap(_buffers);
        }
        buffers.clear();
    }

    std::size_t Count() {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _buffers.size();
    }

private:
    static int OnPendingCall(void* self) {
        auto* list = static_cast<ReleaseList*>(self);
        {
            const std::lock_guard<std::mutex> lock(list->_mutex);
            list->_isScheduled = false;
        }
        list->Drain();
        return 0;
    }

    std::mutex _mutex;
    std::vector<std::unique_ptr<HeldBuffer>> _buffers;
    bool _isScheduled = false;
};

/// Never destroyed: buffers may be dropped while the interpreter shuts down.
ReleaseList& Releases() {
    static auto* list = new ReleaseList;
    return *list;
}

/// True when a buffer's format string is the wanted item type in native byte order.
bool IsFormat(const char* format, char wanted) {
    if (format == nullptr) {
        return false;
    }
    if (*format == '@' || *format == '=' || *format == '<') {
        ++format;
    }
    // The size is checked apart: 'l' is a 4-byte integer on some platforms.
    const bool isSame = *format == wanted || (wanted == 'i' && *format == 'l');
    return isSame && format[1] == '\0';
}

} // namespace

HeldBuffer::HeldBuffer(nb::handle object, char format, std::size_t itemBytes, const char* what) {
    if (PyObject_GetBuffer(object.ptr(), &_view, PyBUF_ND | PyBUF_FORMAT) != 0) {
        PyErr_Clear();
        const std::string text = std::string(what) + ": expected a C-contiguous array";
        throw nb::type_error(text.c_str());
    }
    if (!IsFormat(_view.format, format) || _view.itemsize != static_cast<Py_ssize_t>(itemBytes)) {
        const std::string text = std::string(what) + ": expected items of type '" + format +
                                 "', got '" + (_view.format ? _view.format : "B") + "'";
        PyBuffer_Release(&_view);
        throw nb::type_error(text.c_str());
    }
}

HeldBuffer::~HeldBuffer() {
    PyBuffer_Release(&_view);
}

std::size_t HeldBuffer::numItems() const {
    return static_cast<std::size_t>(_view.len / _view.itemsize);
}

std::size_t HeldBuffer::itemsPerRow() const {
    std::size_t items = 1;
    for (int dimension = 1; dimension < _view.ndim; ++dimension) {
        items *= static_cast<std::size_t>(_view.shape[dimension]);
    }
    return items;
}

ArrayBytes KeepBuffer(std::unique_ptr<HeldBuffer> buffer, bool isOfFloats) {
    // OpenUSD maps arrays of files of crate format from 2048 bytes on, but for compressed integers.
    constexpr std::size_t kLeastMapped = 2048;
    static auto* pool = new ArrayPool; // under the GIL
    const std::size_t bytes = buffer->numBytes();
    if (bytes > 0 && bytes <= (isOfFloats ? kLeastMapped - 1 : ArrayPool::kMostBytes)) {
        return pool->Add(buffer->data(), bytes);
    }
    const void* data = buffer->data();
    return {ShareBuffer(std::move(buffer)), data, bytes};
}

std::shared_ptr<const void> ShareBuffer(std::unique_ptr<HeldBuffer> buffer) {
    Releases().Drain();
    return {buffer.release(), [](const HeldBuffer* held) {
                if (!Py_IsInitialized()) {
                    return; // The interpreter took the object with it.
                }
                if (PyGILState_Check()) {
                    delete held;
                } else {
                    Releases().Add(const_cast<HeldBuffer*>(held));
                }
            }};
}

std::shared_ptr<nb::object> ShareObject(nb::object object) {
    return {new nb::object(std::move(object)), [](nb::object* held) {
                if (!Py_IsInitialized()) {
                    return; // The interpreter took the object with it.
                }
                const nb::gil_scoped_acquire gil;
                delete held;
            }};
}

std::size_t NumBuffersToRelease() {
    return Releases().Count();
}

} // namespace hds::python
