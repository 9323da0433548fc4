// SPDX-License-Identifier: Apache-2.0
// Mapped mode: on CPU devices kernels read pages where the persistent cache
// has them, in files that are mapped into memory. Nothing is copied and no memory is held: what is
// not read is not loaded, and the system takes back what is read no more. Kernels see a resident
// scene. Explained in docs/streaming.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/stream/pageProvider.h"
#include "hdStream/stream/rangeAllocator.h"

#include <array>
#include <memory>
#include <string>
#include <unordered_map>

namespace hds {

/// Buffers over mapped files. Externally synchronised.
class MappedPool {
public:
    /// \param label names it in error messages.
    MappedPool(std::shared_ptr<Device> device, std::string label);

    /// Serves all pages of `provider`; those that are in no file are prepared, which puts them
    /// there. Blocks. \throws Error when the cache cannot hold them, or spreads them over more
    /// files than there are buffers.
    void Update(PageProvider* provider);

    /// As ResidentPool's.
    const Buffer& Addresses() const { return _addresses; }
    const Buffer& PoolBuffer(std::uint32_t i) const { return _buffers[i]; }
    std::uint32_t NumBuffers() const { return static_cast<std::uint32_t>(_bufferByFile.size()); }

private:
    std::uint32_t AddressOf(const MappedPage& mapped);

    std::shared_ptr<Device> _device;
    std::string _label;
    std::array<Buffer, kMaxPoolBuffers> _buffers;
    std::unordered_map<const std::uint8_t*, std::uint32_t> _bufferByFile;
    Buffer _addresses;
};

} // namespace hds
