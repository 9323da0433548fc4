// SPDX-License-Identifier: Apache-2.0
// Resident mode: every page is uploaded once and stays as long as the scene
// has it. The address table has the form that the streaming pool will publish, so kernels see no
// difference. Explained in docs/architecture.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/stream/pageProvider.h"
#include "hdStream/stream/rangeAllocator.h"

#include <array>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace hds {

/// Device memory that holds all pages of a provider. Externally synchronised.
class ResidentPool {
public:
    /// An empty pool. \param label names it in error messages.
    ResidentPool(std::shared_ptr<Device> device, std::string label);

    /// Makes the pool hold the pages of `provider`: pages it holds already (by id) stay where they
    /// are, those the provider lacks leave, new ones are prepared, uploaded and dropped from the
    /// provider. Blocks. \return false when there is no room left in its buffers, which many edits
    /// may have scattered; the pool is of no use then.
    bool Update(PageProvider* provider);

    /// Address of each page in units of 16 bytes (0xffffffff: the page does not exist).
    const Buffer& Addresses() const { return _addresses; }
    /// Buffer `i` of the signature; unused ones are tiny but valid.
    const Buffer& PoolBuffer(std::uint32_t i) const { return _buffers[i]; }
    std::uint32_t NumBuffers() const { return _ranges.NumBuffers(); }
    std::uint64_t BufferLimit() const { return _bufferLimit; }
    /// Bytes of device memory.
    std::uint64_t Bytes() const { return _bytes; }
    /// Bytes of the pages it holds: all of the scene's.
    std::uint64_t PeakUsedBytes() const { return _bytes - _ranges.FreeBytes(); }
    /// Counts from 0 again.
    void BeginStatistics();
    /// Pages uploaded since BeginStatistics, and their bytes.
    std::uint64_t Uploads() const { return _uploads; }
    std::uint64_t UploadedBytes() const { return _uploadedBytes; }

private:
    void RemoveOthers(const PageProvider& provider);
    bool Upload(PageProvider* provider, const std::vector<std::uint32_t>& pages,
                std::uint64_t bytesToCome);
    bool Place(std::uint64_t bytes, std::uint64_t bytesToCome, PoolRange* range);
    bool AddBuffer(std::uint64_t bytes, std::uint64_t bytesToCome);

    std::shared_ptr<Device> _device;
    std::string _label;
    std::uint64_t _bufferLimit;
    std::array<Buffer, kMaxPoolBuffers> _buffers;
    RangeAllocator _ranges;
    std::unordered_map<std::uint64_t, PoolRange> _pages; ///< by page id
    std::vector<std::uint32_t> _missing;                 ///< pages of this update
    Buffer _addresses;
    std::uint64_t _bytes = 0;
    std::uint64_t _uploads = 0;
    std::uint64_t _uploadedBytes = 0;
};

} // namespace hds
