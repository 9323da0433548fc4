// SPDX-License-Identifier: Apache-2.0
// Resident mode (DESIGN.md section 4.6): every page is uploaded once and stays. The address table
// has the form that the streaming pool will publish, so kernels see no difference. Explained in
// docs/architecture.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/stream/pageProvider.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// Most pool buffers in a kernel's signature, and the most bytes of one.
constexpr std::uint32_t kMaxPoolBuffers = 8;
constexpr std::uint64_t kMaxPoolBufferBytes = 1ULL << 30U;

/// Device memory that holds all pages of a provider. Externally synchronised.
class ResidentPool {
public:
    /// Uploads all pages. Blocks.
    /// \throws Error when they do not fit the device, with the bytes needed.
    ResidentPool(const std::shared_ptr<Device>& device, const std::string& label,
                 const PageProvider& provider);

    /// Address of each page in units of 16 bytes (0xffffffff: the page does not exist).
    const Buffer& Addresses() const { return _addresses; }
    /// Buffer `i` of the signature; unused ones are tiny but valid.
    const Buffer& PoolBuffer(std::uint32_t i) const { return _buffers[i]; }
    std::uint32_t NumBuffers() const { return _numBuffers; }
    std::uint64_t Bytes() const { return _bytes; }

private:
    std::array<Buffer, kMaxPoolBuffers> _buffers;
    Buffer _addresses;
    std::uint32_t _numBuffers = 0;
    std::uint64_t _bytes = 0;
};

} // namespace hds
