// SPDX-License-Identifier: Apache-2.0
// Device memory for lines: up to eight buffers that slots count through.
#pragma once

#include "hdStream/texture/textureBinding.h"

#include <array>
#include <memory>
#include <string>

namespace hds {

/// Buffers with `NumSlots` slots in all. Externally synchronised.
class LineBuffers {
public:
    static constexpr std::uint64_t kSlotsPerBuffer = std::uint64_t{1} << HDS_SLOT_BUFFER_SHIFT;

    /// Allocates. \throws Error.
    LineBuffers(const std::shared_ptr<Device>& device, std::uint64_t numSlots);

    /// Most slots that a device can have.
    static std::uint64_t MaxSlots(const Device& device);

    std::uint64_t NumSlots() const { return _numSlots; }
    std::uint32_t NumBuffers() const { return _numBuffers; }
    std::uint64_t Bytes() const { return _numSlots * HDS_LINE_BYTES; }
    /// Of the tiny buffers that stand in for unused ones.
    std::uint64_t UnusedBytes() const;
    const Buffer& At(std::uint32_t i) const { return _buffers[i]; }
    Buffer& At(std::uint32_t i) { return _buffers[i]; }
    void FillBinding(TextureBinding* binding) const;

private:
    std::array<Buffer, HDS_SLOT_MAX_BUFFERS> _buffers;
    std::uint64_t _numSlots;
    std::uint32_t _numBuffers = 0;
};

} // namespace hds
