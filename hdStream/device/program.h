// SPDX-License-Identifier: Apache-2.0
// Kernel programs: binaries are cached per device.
// Explained in docs/device.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/device/kernelSource.h"
#include "hdStream/device/programSource.h"
#include "hdStream/persist/store.h"

#include <memory>
#include <string>
#include <vector>

namespace hds {

/// A kernel of a program, with a launch helper. Externally synchronised.
class Kernel {
public:
    Kernel() = default;
    Kernel(std::shared_ptr<Device> device, void* kernel, std::string name);
    ~Kernel();
    Kernel(Kernel&& other) noexcept;
    Kernel& operator=(Kernel&& other) noexcept;
    Kernel(const Kernel&) = delete;
    Kernel& operator=(const Kernel&) = delete;

    /// Sets argument `index` (buffers by handle, PODs by value).
    void SetBuffer(unsigned index, const Buffer& buffer);
    void SetBytes(unsigned index, const void* data, std::size_t bytes);

    /// The first `count` arguments are set and stay from launch to launch; none at first.
    void KeepFirst(unsigned count) { _numKept = count; }

    /// Sets all other arguments in order and queues the kernel over `numItems` work-items (rounded
    /// up to the group size; kernels compare get_global_id(0) with their own count).
    /// \pre the kernel has as many arguments as are kept and given.
    template <typename... Args>
    void Launch(std::size_t numItems, const Args&... args) {
        unsigned index = _numKept;
        ForgetFrom(index);
        (SetArgument(index++, args), ...);
        Enqueue(numItems);
    }

    /// Each work-item takes so many items one after another (kernels/integrator/itemLoop.clh); 1 at
    /// first.
    void SetItemsPerWorkItem(std::uint32_t length);

    /// Queues with the arguments as set. No-op for numItems 0. \pre all arguments are set.
    void Enqueue(std::size_t numItems);

private:
    void ForgetFrom(unsigned index);
    void SetArgument(unsigned index, const Buffer& buffer) { SetBuffer(index, buffer); }
    template <typename T>
    void SetArgument(unsigned index, const T& value) {
        static_assert(std::is_trivially_copyable_v<T>, "kernel arguments are PODs or buffers");
        SetBytes(index, &value, sizeof(value));
    }

    static constexpr std::size_t kGroupSize = 64;

    std::shared_ptr<Device> _device;
    void* _kernel = nullptr;
    std::string _name;
    std::vector<bool> _isSet; ///< by argument
    unsigned _numKept = 0;
    std::size_t _itemsPerWorkItem = 1;
    std::size_t _groupSize = kGroupSize;
};

/// A built program. Externally synchronised.
class Program {
public:
    /// Takes what the device keeps, where the store has no use for a binary; else the binary from
    /// the store, else from the device's KernelCompilers, else builds from the source. A binary
    /// that the device rejects is built again from source. \throws Error with the build log on
    /// failure.
    Program(std::shared_ptr<Device> device, const ProgramSource& source, Store* store = nullptr);
    /// \overload of a root of kernels/ or, for tests, of `text`.
    Program(const std::shared_ptr<Device>& device, const std::string& root,
            const ProgramDefines& defines, Store* store = nullptr,
            const std::string* text = nullptr);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    /// \throws Error when the program has no such kernel.
    Kernel GetKernel(const std::string& name) const;

    /// Whether the binary of such a program is in the store.
    static bool IsInStore(const ProgramSource& source, const Store& store);

    /// Lets the device's KernelCompilers begin to compile what is not in the store, where that is
    /// faster than to build it here; does nothing else.
    static void Announce(const Device& device, const std::vector<ProgramSource>& sources,
                         const Store* store);

    /// Saves the binary of a program that was built from source and is not saved yet: the
    /// constructor does, except where that takes long (DeviceProperties::hasSlowBinaries).
    void SaveBinary(Store* store);
    /// \overload of a binary that was made elsewhere.
    static void SaveBinary(const ProgramSource& source, const void* binary, std::size_t bytes,
                           Store* store);

    /// Empty: there is none in the store.
    static std::vector<unsigned char> StoredBinary(const ProgramSource& source, Store* store);

    /// Empty: the device hands out none. May take as long as building.
    std::vector<unsigned char> Binary() const;

    bool IsFromCache() const { return _isFromCache; }
    double BuildSeconds() const { return _buildSeconds; }

private:
    bool TakeKept(const ProgramSource& source, const Store* store);
    bool BuildFromStore(const ProgramSource& source, Store* store);
    bool BuildFromCompilers(const ProgramSource& source, const Store* store);
    bool BuildFromBinary(const ProgramSource& source, const unsigned char* data, std::size_t bytes);
    void BuildFromSource(const ProgramSource& source);

    std::shared_ptr<Device> _device;
    std::string _root;
    std::string _key;
    void* _program = nullptr;
    std::string _unsavedKey; ///< empty: nothing is to be saved
    bool _isFromCache = false;
    double _buildSeconds = 0.0;
};

} // namespace hds
