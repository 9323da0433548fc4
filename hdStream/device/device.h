// SPDX-License-Identifier: Apache-2.0
// An OpenCL device with its context and queue. The only layer that includes OpenCL headers; other
// layers see Device, Buffer and Program.
// Explained in docs/device.md.
#pragma once

#include "hdStream/base/error.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// What an OpenCL device says of itself.
struct DeviceProperties {
    std::string name;
    std::string platform;
    std::string version;       ///< CL_DEVICE_VERSION
    std::string driverVersion; ///< CL_DRIVER_VERSION
    std::uint64_t memoryBytes = 0;
    std::uint64_t maxAllocationBytes = 0;
    std::uint32_t computeUnits = 0;
    bool isCpu = false;
    /// Host and device may share buffers: between commands the host reads and writes them in place.
    bool sharesBuffers = false;
    /// To hand out a binary the driver compiles each kernel once more, for work-groups of any size
    /// (PoCL): binaries are asked for when there is time.
    bool hasSlowBinaries = false;
    /// Division and square roots are rounded to the nearest only when a program asks for it (GPUs).
    bool roundsWhenAsked = false;
};

/// All devices of all platforms, in our order (deviceOrder.h). Never throws.
std::vector<DeviceProperties> ListDeviceProperties();

/// The device that Device::Create takes by that name. \throws Error as it.
DeviceProperties FindDevice(const std::string& name);

class KernelCompilers;

/// A device, its context and one in-order queue. Externally synchronised.
class Device {
public:
    /// Picks the first device whose name or platform contains `name` (case-insensitive); an empty
    /// name picks the first GPU, else the first device.
    /// \throws Error when there is none.
    static std::shared_ptr<Device> Create(const std::string& name);
    /// \overload the first device whose texts are those of `properties`.
    static std::shared_ptr<Device> Create(const DeviceProperties& properties);
    /// As Create by name; where a device that was had in this way has come to its end, its context
    /// and queue go on, with the programs it has built. Of PoCL alone, where to load a program
    /// takes longer than a small render. Thread-safe.
    static std::shared_ptr<Device> Reuse(const std::string& name);
    /// Of a device that has met an error: it leaves nothing to the next user.
    void LeaveNothing();
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceProperties& Properties() const { return _properties; }

    /// Who compiles programs besides this process; null: nobody.
    KernelCompilers* Compilers() const { return _compilers.get(); }
    void SetCompilers(std::unique_ptr<KernelCompilers> compilers);

    /// Blocks until everything queued has run.
    /// \throws Error when the device reports a failure.
    void Finish();
    /// Whether nothing was queued since the last call that has waited for all.
    bool IsIdle() const { return _isIdle; }

    /// Bytes allocated now, and the most that were allocated at once since BeginPeak.
    std::uint64_t AllocatedBytes() const { return _allocatedBytes; }
    std::uint64_t PeakBytes() const { return _peakBytes; }
    void BeginPeak() { _peakBytes = _allocatedBytes; }

    struct Handles; ///< OpenCL objects, for this layer's own files
    const Handles& GetHandles() const { return *_handles; }

private:
    friend class Buffer;
    friend class BufferView;
    friend class Kernel;
    Device();
    static std::shared_ptr<Device> Open(const struct FoundDevice& chosen, bool mayReuse = false);
    /// The handles wait for the next user. \return whether they do.
    bool LeaveHandles();
    void CountAllocation(std::int64_t bytes);

    DeviceProperties _properties;
    std::unique_ptr<Handles> _handles;
    bool _leavesHandles = true; ///< where it keeps programs
    bool _isIdle = true;
    std::unique_ptr<KernelCompilers> _compilers;
    std::uint64_t _allocatedBytes = 0;
    std::uint64_t _peakBytes = 0;
};

/// A piece of host memory and where it goes in a buffer. Bytes.
struct BufferCopy {
    const void* data = nullptr;
    std::uint64_t bytes = 0;
    std::uint64_t offset = 0;
};

/// For tests: of the allocations to come, of any device, number `index` fails as if memory had run
/// out; -1: none does. Thread-safe.
void FailAllocation(std::int64_t index);

/// How kernels use a buffer.
enum class BufferAccess { ReadOnly, ReadWrite };

/// Whether memory of the host that a device reads is among what its allocator has given out.
enum class HostMemoryCount { AsDeviceMemory, NotAtAll };

/// Device memory. Moves, never copies; freed on destruction. Externally synchronised.
class Buffer {
public:
    Buffer() = default;
    /// \param label names the buffer in error messages.
    /// \throws Error with label and size when the device cannot allocate it. Size 0 allocates 16
    /// bytes, so that every kernel argument is a valid buffer.
    Buffer(std::shared_ptr<Device> device, std::string label, std::uint64_t bytes,
           BufferAccess access = BufferAccess::ReadWrite);
    /// Memory of the host that kernels read in place, on CPU devices without a copy; it must
    /// outlive their use of the buffer. \throws Error as above.
    static Buffer OfHostMemory(std::shared_ptr<Device> device, std::string label, const void* data,
                               std::uint64_t bytes, HostMemoryCount count);
    ~Buffer();
    Buffer(Buffer&& other) noexcept;
    Buffer& operator=(Buffer&& other) noexcept;
    Buffer(const Buffer&) = delete;
    Buffer& operator=(const Buffer&) = delete;

    bool IsValid() const { return _memory != nullptr; }
    std::uint64_t Bytes() const { return _bytes; }

    /// Blocking copies. \throws Error.
    void Write(const void* data, std::uint64_t bytes, std::uint64_t offset = 0);
    void Read(void* data, std::uint64_t bytes, std::uint64_t offset = 0) const;
    /// Blocking copy of many pieces, in any order; they do not overlap. On CPU devices all cores
    /// copy into the buffer itself. \throws Error.
    void WriteMany(const std::vector<BufferCopy>& copies);
    /// Fills with a 32-bit pattern, in the order of what is queued; `bytes` and `offset` are
    /// multiples of 4.
    void Fill(std::uint32_t pattern, std::uint64_t bytes, std::uint64_t offset = 0);

    void* Memory() const { return _memory; } ///< cl_mem

private:
    friend class BufferView;
    void Create(std::uint64_t flags, void* hostMemory);
    void CreateInHugePages(std::uint64_t flags, void* pages);
    void CreateShared(std::uint64_t flags);
    void Release() noexcept;

    std::shared_ptr<Device> _device;
    std::string _label;
    std::uint64_t _bytes = 0;
    bool _isCounted = true;
    void* _memory = nullptr;
    std::uint8_t* _shared = nullptr; ///< its bytes, where the host reaches them; may be null
};

/// The bytes of a buffer for the host to read while this lives, without a copy where the device's
/// memory is the host's. Kernels may read the buffer meanwhile; nobody writes to it.
class BufferView {
public:
    /// Blocks. \throws Error. \param buffer must outlive this.
    explicit BufferView(const Buffer& buffer);
    ~BufferView();
    BufferView(const BufferView&) = delete;
    BufferView& operator=(const BufferView&) = delete;

    const std::uint8_t* Data() const { return _data; }

private:
    const Buffer& _buffer;
    const std::uint8_t* _data = nullptr;
};

/// A buffer that holds a vector's contents; an empty vector gives a valid tiny buffer.
template <typename T>
Buffer UploadVector(const std::shared_ptr<Device>& device, const std::string& label,
                    const std::vector<T>& values) {
    Buffer buffer(device, label, values.size() * sizeof(T), BufferAccess::ReadOnly);
    if (!values.empty()) {
        buffer.Write(values.data(), values.size() * sizeof(T));
    }
    return buffer;
}

} // namespace hds
