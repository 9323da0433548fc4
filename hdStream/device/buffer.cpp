// SPDX-License-Identifier: Apache-2.0
#include "hdStream/base/hugePages.h"
#include "hdStream/device/openclHandles.h"
#include "hdStream/device/resizeBuffer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <utility>

namespace hds {

namespace {

constexpr std::uint64_t kMinBytes = 16;

/// Allocations until one fails (FailAllocation); negative: none does.
std::atomic<std::int64_t> allocationsLeft{-1};

/// Shared memory that an OpenCL buffer lives in, freed as large pages are.
struct SharedMemory {
    cl_context context;
    void* memory;
};

/// Large pages that an OpenCL buffer lives in: freed when the device has ended all use of it.
struct HugePages {
    void* memory;
    std::uint64_t bytes;
};

[[noreturn]] void ThrowNoMemory(const Device& device, const std::string& label, std::uint64_t bytes,
                                cl_int code) {
    throw Error("device memory for " + label + ": " + std::to_string(bytes) +
                " bytes: " + OpenClErrorName(code) + " (" + std::to_string(code) + "); " +
                std::to_string(device.AllocatedBytes()) +
                " bytes are in use, one allocation may have " +
                std::to_string(device.Properties().maxAllocationBytes));
}

void CL_CALLBACK OnMemoryUnused(cl_mem, void* data) {
    const std::unique_ptr<HugePages> pages(static_cast<HugePages*>(data));
    FreeHugePages(pages->memory, pages->bytes);
}

void CL_CALLBACK OnSharedUnused(cl_mem, void* data) {
    const std::unique_ptr<SharedMemory> shared(static_cast<SharedMemory*>(data));
    clSVMFree(shared->context, shared->memory);
    clReleaseContext(shared->context);
}

} // namespace

void FailAllocation(std::int64_t index) {
    allocationsLeft = index;
}

Buffer::Buffer(std::shared_ptr<Device> device, std::string label, std::uint64_t bytes,
               BufferAccess access)
    : _device(std::move(device)), _label(std::move(label)),
      _bytes(bytes < kMinBytes ? kMinBytes : bytes) {
    const std::uint64_t flags =
        access == BufferAccess::ReadOnly ? CL_MEM_READ_ONLY : CL_MEM_READ_WRITE;
    const bool isLarge = _bytes >= kMinHugePageBytes && _device->Properties().isCpu;
    if (isLarge) {
        // PoCL takes memory at the first use and ends the process when there is none.
        void* pages = AllocateHugePages(_bytes);
        if (pages == nullptr) {
            ThrowNoMemory(*_device, _label, _bytes, CL_MEM_OBJECT_ALLOCATION_FAILURE);
        }
        CreateInHugePages(flags, pages);
    } else if (_device->Properties().sharesBuffers) {
        CreateShared(flags);
    } else {
        Create(flags, nullptr);
    }
    _device->CountAllocation(static_cast<std::int64_t>(_bytes));
}

Buffer Buffer::OfHostMemory(std::shared_ptr<Device> device, std::string label, const void* data,
                            std::uint64_t bytes, HostMemoryCount count) {
    Buffer buffer;
    buffer._device = std::move(device);
    buffer._label = std::move(label);
    buffer._bytes = bytes;
    buffer._isCounted = count == HostMemoryCount::AsDeviceMemory;
    // Kernels only read it; the interface takes no const pointer.
    buffer.Create(CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR, const_cast<void*>(data));
    if (buffer._isCounted) {
        buffer._device->CountAllocation(static_cast<std::int64_t>(bytes));
    }
    return buffer;
}

void Buffer::Create(std::uint64_t flags, void* hostMemory) {
    cl_int code = CL_SUCCESS;
    // Drivers of GPUs promise more than there is, and take memory at the first use, which is here.
    const std::uint64_t memoryBytes = _device->Properties().memoryBytes; // 0: nobody says
    const bool isTooLarge = memoryBytes > 0 && _bytes > memoryBytes;
    if (isTooLarge || (allocationsLeft >= 0 && allocationsLeft-- == 0)) {
        code = CL_MEM_OBJECT_ALLOCATION_FAILURE;
    } else {
        _memory = clCreateBuffer(_device->GetHandles().context, flags, _bytes, hostMemory, &code);
    }
    if (code == CL_SUCCESS && !_device->Properties().isCpu) {
        const auto memory = static_cast<cl_mem>(_memory);
        code = clEnqueueMigrateMemObjects(_device->GetHandles().queue, 1, &memory,
                                          CL_MIGRATE_MEM_OBJECT_CONTENT_UNDEFINED, 0, nullptr,
                                          nullptr);
        if (code != CL_SUCCESS) {
            clReleaseMemObject(memory);
        }
    }
    if (code != CL_SUCCESS) {
        _memory = nullptr;
        ThrowNoMemory(*_device, _label, _bytes, code);
    }
}

void Buffer::CreateInHugePages(std::uint64_t flags, void* pages) {
    auto owner = std::make_unique<HugePages>(HugePages{pages, _bytes});
    try {
        Create(flags | CL_MEM_USE_HOST_PTR, pages);
    } catch (...) {
        FreeHugePages(pages, _bytes);
        throw;
    }
    CheckOpenCl(clSetMemObjectDestructorCallback(static_cast<cl_mem>(_memory), OnMemoryUnused,
                                                 owner.release()),
                "device memory for " + _label);
}

/// In memory that host and device share, so that the host needs no command to reach it: a command
/// costs as much as tracing some hundred rays.
void Buffer::CreateShared(std::uint64_t flags) {
    cl_context context = _device->GetHandles().context;
    void* memory = clSVMAlloc(context, CL_MEM_READ_WRITE | CL_MEM_SVM_FINE_GRAIN_BUFFER, _bytes, 0);
    if (memory == nullptr) {
        ThrowNoMemory(*_device, _label, _bytes, CL_MEM_OBJECT_ALLOCATION_FAILURE);
    }
    try {
        Create(flags | CL_MEM_USE_HOST_PTR, memory);
    } catch (...) {
        clSVMFree(context, memory);
        throw;
    }
    clRetainContext(context);
    auto owner = std::make_unique<SharedMemory>(SharedMemory{context, memory});
    CheckOpenCl(clSetMemObjectDestructorCallback(static_cast<cl_mem>(_memory), OnSharedUnused,
                                                 owner.release()),
                "device memory for " + _label);
    _shared = static_cast<std::uint8_t*>(memory);
}

Buffer::~Buffer() {
    Release();
}

Buffer::Buffer(Buffer&& other) noexcept {
    *this = std::move(other);
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
    if (this != &other) {
        Release();
        _device = std::move(other._device);
        _label = std::move(other._label);
        _bytes = std::exchange(other._bytes, 0);
        _isCounted = other._isCounted;
        _memory = std::exchange(other._memory, nullptr);
        _shared = std::exchange(other._shared, nullptr);
    }
    return *this;
}

void Buffer::Release() noexcept {
    if (_memory != nullptr) {
        clReleaseMemObject(static_cast<cl_mem>(_memory));
        if (_isCounted) {
            _device->CountAllocation(-static_cast<std::int64_t>(_bytes));
        }
        _memory = nullptr;
        _shared = nullptr;
    }
}

void Buffer::Write(const void* data, std::uint64_t bytes, std::uint64_t offset) {
    HDS_VERIFY(offset + bytes <= _bytes, "write past the end of " + _label);
    if (bytes == 0) {
        return;
    }
    if (_shared != nullptr) {
        _device->Finish();
        std::memcpy(_shared + offset, data, bytes);
        return;
    }
    CheckOpenCl(clEnqueueWriteBuffer(_device->GetHandles().queue, static_cast<cl_mem>(_memory),
                                     CL_TRUE, offset, bytes, data, 0, nullptr, nullptr),
                "writing " + _label);
    _device->_isIdle = true; // commands run in order
}

void Buffer::Read(void* data, std::uint64_t bytes, std::uint64_t offset) const {
    HDS_VERIFY(offset + bytes <= _bytes, "read past the end of " + _label);
    if (bytes == 0) {
        return;
    }
    if (_shared != nullptr) {
        _device->Finish();
        std::memcpy(data, _shared + offset, bytes);
        return;
    }
    CheckOpenCl(clEnqueueReadBuffer(_device->GetHandles().queue, static_cast<cl_mem>(_memory),
                                    CL_TRUE, offset, bytes, data, 0, nullptr, nullptr),
                "reading " + _label);
    _device->_isIdle = true;
}

void Buffer::WriteMany(const std::vector<BufferCopy>& copies) {
    if (copies.empty()) {
        return;
    }
    std::uint64_t begin = _bytes;
    std::uint64_t end = 0;
    for (const BufferCopy& copy : copies) {
        HDS_VERIFY(copy.offset + copy.bytes <= _bytes, "write past the end of " + _label);
        begin = std::min(begin, copy.offset);
        end = std::max(end, copy.offset + copy.bytes);
    }
    if (_shared != nullptr) {
        for (const BufferCopy& copy : copies) {
            Write(copy.data, copy.bytes, copy.offset);
        }
        return;
    }
    cl_command_queue queue = _device->GetHandles().queue;
    if (!_device->Properties().isCpu) { // to wait for each takes as long as to copy a page
        cl_int code = CL_SUCCESS;
        for (const BufferCopy& copy : copies) {
            if (copy.bytes > 0 && code == CL_SUCCESS) {
                code =
                    clEnqueueWriteBuffer(queue, static_cast<cl_mem>(_memory), CL_FALSE, copy.offset,
                                         copy.bytes, copy.data, 0, nullptr, nullptr);
            }
        }
        _device->_isIdle = false;
        _device->Finish(); // in any case: what is copied may go
        CheckOpenCl(code, "writing " + _label);
        return;
    }
    // What is between the pieces keeps its contents: the map is for reading too. It costs nothing
    // where the device's memory is the host's.
    cl_int code = CL_SUCCESS;
    auto* target = static_cast<std::uint8_t*>(
        clEnqueueMapBuffer(queue, static_cast<cl_mem>(_memory), CL_TRUE, CL_MAP_READ | CL_MAP_WRITE,
                           begin, end - begin, 0, nullptr, nullptr, &code));
    CheckOpenCl(code, "mapping " + _label);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, copies.size()), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            if (copies[i].bytes > 0) { // an empty one may have no address
                std::memcpy(target + (copies[i].offset - begin), copies[i].data, copies[i].bytes);
            }
        }
    });
    CheckOpenCl(
        clEnqueueUnmapMemObject(queue, static_cast<cl_mem>(_memory), target, 0, nullptr, nullptr),
        "unmapping " + _label);
    _device->_isIdle = false;
    _device->Finish();
}

void Buffer::Fill(std::uint32_t pattern, std::uint64_t bytes, std::uint64_t offset) {
    HDS_VERIFY(offset + bytes <= _bytes, "fill past the end of " + _label);
    if (bytes == 0) {
        return;
    }
    if (_shared != nullptr && _device->IsIdle()) {
        std::fill_n(reinterpret_cast<std::uint32_t*>(_shared + offset), bytes / sizeof(pattern),
                    pattern);
        return;
    }
    CheckOpenCl(clEnqueueFillBuffer(_device->GetHandles().queue, static_cast<cl_mem>(_memory),
                                    &pattern, sizeof(pattern), offset, bytes, 0, nullptr, nullptr),
                "filling " + _label);
    _device->_isIdle = false;
}

void ResizeBuffer(const std::shared_ptr<Device>& device, const char* label, std::uint64_t bytes,
                  Buffer* buffer) {
    if (!buffer->IsValid() || buffer->Bytes() != std::max(bytes, kMinBytes)) {
        *buffer = Buffer(); // frees first
        *buffer = Buffer(device, label, bytes);
    }
}

BufferView::BufferView(const Buffer& buffer) : _buffer(buffer) {
    if (_buffer._shared != nullptr) {
        _buffer._device->Finish();
        _data = _buffer._shared;
        return;
    }
    cl_int code = CL_SUCCESS;
    _data = static_cast<const std::uint8_t*>(clEnqueueMapBuffer(
        _buffer._device->GetHandles().queue, static_cast<cl_mem>(_buffer._memory), CL_TRUE,
        CL_MAP_READ, 0, _buffer._bytes, 0, nullptr, nullptr, &code));
    CheckOpenCl(code, "mapping " + _buffer._label);
}

BufferView::~BufferView() {
    if (_buffer._shared == nullptr) {
        // Nothing was written, so that it does not matter whether it fails.
        cl_command_queue queue = _buffer._device->GetHandles().queue;
        clEnqueueUnmapMemObject(queue, static_cast<cl_mem>(_buffer._memory),
                                const_cast<std::uint8_t*>(_data), 0, nullptr, nullptr);
        clFinish(queue);
    }
}

} // namespace hds
