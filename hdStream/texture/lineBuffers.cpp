// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/lineBuffers.h"

#include <algorithm>

namespace hds {

LineBuffers::LineBuffers(const std::shared_ptr<Device>& device, std::uint64_t numSlots)
    : _numSlots(numSlots) {
    std::uint64_t left = numSlots;
    for (std::uint32_t i = 0; i < HDS_SLOT_MAX_BUFFERS; ++i) {
        const std::uint64_t slots = std::min(left, kSlotsPerBuffer);
        _buffers[i] = Buffer(device, "texture pool " + std::to_string(i), slots * HDS_LINE_BYTES);
        _numBuffers += slots > 0 ? 1 : 0;
        left -= slots;
    }
}

std::uint64_t LineBuffers::MaxSlots(const Device& device) {
    const std::uint64_t largest = device.Properties().maxAllocationBytes / HDS_LINE_BYTES;
    // Smaller buffers than the slots' numbers count through can only be used alone.
    return largest < kSlotsPerBuffer ? largest : HDS_SLOT_MAX_BUFFERS * kSlotsPerBuffer;
}

std::uint64_t LineBuffers::UnusedBytes() const {
    std::uint64_t bytes = 0;
    for (std::uint32_t i = _numBuffers; i < HDS_SLOT_MAX_BUFFERS; ++i) {
        bytes += _buffers[i].Bytes();
    }
    return bytes;
}

void LineBuffers::FillBinding(TextureBinding* binding) const {
    for (std::uint32_t i = 0; i < HDS_SLOT_MAX_BUFFERS; ++i) {
        binding->pools[i] = &_buffers[i];
    }
}

} // namespace hds
