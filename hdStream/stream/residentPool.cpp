// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/residentPool.h"

#include "hdStream/base/error.h"
#include "kernels/shared/geometry.h"

#include <algorithm>
#include <cstring>

namespace hds {

static_assert(kMaxPoolBuffers == HDS_POOL_MAX_BUFFERS, "the kernels' signature");
static_assert(kMaxPoolBufferBytes == (std::uint64_t{HDS_POOL_UNIT_BYTES} << HDS_POOL_BUFFER_SHIFT),
              "address format");

namespace {

/// Places pages one after another; none straddles two buffers.
struct Placement {
    std::vector<std::uint32_t> addresses;
    std::vector<std::uint64_t> bufferBytes;
};

Placement PlacePages(const PageProvider& provider, std::uint64_t bufferLimit,
                     const std::string& label) {
    Placement placement;
    placement.addresses.resize(provider.NumPages(), HDS_NOT_RESIDENT);
    placement.bufferBytes.push_back(0);
    for (std::uint32_t page = 0; page < provider.NumPages(); ++page) {
        const std::uint64_t bytes = provider.PageBytes(page);
        if (bytes == 0) {
            continue;
        }
        HDS_VERIFY(bytes % HDS_POOL_UNIT_BYTES == 0, label + " page " + std::to_string(page));
        if (placement.bufferBytes.back() + bytes > bufferLimit) {
            placement.bufferBytes.push_back(0);
        }
        if (bytes > bufferLimit || placement.bufferBytes.size() > kMaxPoolBuffers) {
            throw Error(label + ": the scene does not fit the device's memory (" +
                        std::to_string(kMaxPoolBuffers) + " buffers of " +
                        std::to_string(bufferLimit) + " bytes)");
        }
        const auto buffer = static_cast<std::uint32_t>(placement.bufferBytes.size() - 1);
        placement.addresses[page] =
            (buffer << HDS_POOL_BUFFER_SHIFT) |
            static_cast<std::uint32_t>(placement.bufferBytes.back() / HDS_POOL_UNIT_BYTES);
        placement.bufferBytes.back() += bytes;
    }
    return placement;
}

/// Uploads go through a staging block, so that many small pages cost few transfers.
class StagedUpload {
public:
    StagedUpload(Buffer* buffer, std::uint64_t blockBytes) : _buffer(buffer) {
        _block.reserve(blockBytes);
    }
    void Append(const std::uint8_t* data, std::uint64_t bytes) {
        if (_block.size() + bytes > _block.capacity()) {
            Flush();
        }
        if (bytes > _block.capacity()) {
            _buffer->Write(data, bytes, _offset);
            _offset += bytes;
            return;
        }
        _block.insert(_block.end(), data, data + bytes);
    }
    void Flush() {
        if (!_block.empty()) {
            _buffer->Write(_block.data(), _block.size(), _offset);
            _offset += _block.size();
            _block.clear();
        }
    }

private:
    Buffer* _buffer;
    std::uint64_t _offset = 0;
    std::vector<std::uint8_t> _block;
};

constexpr std::uint64_t kStagingBytes = 4U << 20U;

} // namespace

ResidentPool::ResidentPool(const std::shared_ptr<Device>& device, const std::string& label,
                           const PageProvider& provider) {
    const std::uint64_t limit =
        std::min(kMaxPoolBufferBytes, device->Properties().maxAllocationBytes);
    const Placement placement = PlacePages(provider, limit, label);
    _numBuffers = static_cast<std::uint32_t>(placement.bufferBytes.size());
    std::uint32_t page = 0;
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        const std::uint64_t bytes = i < _numBuffers ? placement.bufferBytes[i] : 0;
        _buffers[i] =
            Buffer(device, label + " pool " + std::to_string(i), bytes, BufferAccess::ReadOnly);
        _bytes += bytes;
        StagedUpload upload(&_buffers[i], kStagingBytes);
        for (; page < provider.NumPages(); ++page) {
            const std::uint32_t address = placement.addresses[page];
            if (address != HDS_NOT_RESIDENT && (address >> HDS_POOL_BUFFER_SHIFT) != i) {
                break;
            }
            upload.Append(provider.Page(page), provider.PageBytes(page));
        }
        upload.Flush();
    }
    _addresses = UploadVector(device, label + " addresses", placement.addresses);
}

} // namespace hds
