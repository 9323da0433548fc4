// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/residentPool.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

namespace hds {

namespace {

/// Pages that follow each other in a buffer go through a staging block, so that many small ones
/// cost few transfers.
class StagedUpload {
public:
    explicit StagedUpload(std::uint64_t blockBytes) { _block.reserve(blockBytes); }
    void Append(Buffer* buffer, std::uint64_t offset, const std::uint8_t* data,
                std::uint64_t bytes) {
        const bool follows = buffer == _buffer && offset == _offset + _block.size();
        if (!follows || _block.size() + bytes > _block.capacity()) {
            Flush();
            _buffer = buffer;
            _offset = offset;
        }
        if (bytes > _block.capacity()) {
            buffer->Write(data, bytes, offset);
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
    Buffer* _buffer = nullptr;
    std::uint64_t _offset = 0; ///< of the block
    std::vector<std::uint8_t> _block;
};

constexpr std::uint64_t kStagingBytes = 4U << 20U;
/// Bytes of the pages that are prepared together.
constexpr std::uint64_t kBatchBytes = 64U << 20U;
/// A buffer that is added later is at least this part of the pool, so that many small edits do not
/// use up the buffers.
constexpr std::uint64_t kGrowthShare = 8;

} // namespace

ResidentPool::ResidentPool(std::shared_ptr<Device> device, std::string label)
    : PagePool(std::move(device), std::move(label)),
      _bufferLimit(std::min(kMaxPoolBufferBytes, _device->Properties().maxAllocationBytes) /
                   HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES) {}

void ResidentPool::BeginStatistics() {
    _statistics = {};
    _held.BeginPeak();
}

bool ResidentPool::Update(PageProvider* provider, std::uint64_t /*budgetBytes*/) {
    const bool isFirst = _ranges.NumBuffers() == 0;
    std::uint64_t totalBytes = 0;
    for (std::uint32_t page = 0; page < provider->NumPages(); ++page) {
        totalBytes += provider->PageBytes(page);
    }
    RemoveOthers(*provider);
    if (!LoadMissing(provider)) {
        if (!isFirst) {
            return false;
        }
        throw Error(_label + ": " + std::to_string(totalBytes) +
                    " bytes do not fit the device's memory (" + std::to_string(kMaxPoolBuffers) +
                    " buffers of " + std::to_string(_bufferLimit) +
                    " bytes); --residency stream needs less");
    }
    std::vector<std::uint32_t> addresses(provider->NumPages(), HDS_NOT_RESIDENT);
    for (std::uint32_t page = 0; page < provider->NumPages(); ++page) {
        const auto known = _pages.find(provider->PageId(page));
        if (known != _pages.end()) {
            addresses[page] = known->second.Address();
        }
    }
    _addresses = UploadVector(_device, _label + " addresses", addresses);
    return true;
}

/// \return false when there is no room for all pages.
bool ResidentPool::LoadMissing(PageProvider* provider) {
    _missing.clear();
    std::uint64_t bytesToCome = 0;
    for (std::uint32_t page = 0; page < provider->NumPages(); ++page) {
        if (provider->PageBytes(page) > 0 && _pages.count(provider->PageId(page)) == 0) {
            _missing.push_back(page);
            bytesToCome += provider->PageBytes(page);
        }
    }
    for (std::size_t begin = 0; begin < _missing.size();) {
        std::vector<std::uint32_t> batch;
        std::uint64_t bytes = 0;
        for (; begin < _missing.size() && bytes < kBatchBytes; ++begin) {
            batch.push_back(_missing[begin]);
            bytes += provider->PageBytes(_missing[begin]);
        }
        provider->Prepare(batch);
        if (!Upload(provider, batch, bytesToCome)) {
            return false;
        }
        bytesToCome -= bytes;
    }
    return true;
}

/// Uploads prepared pages. \return false when there is no room.
bool ResidentPool::Upload(PageProvider* provider, const std::vector<std::uint32_t>& pages,
                          std::uint64_t bytesToCome) {
    StagedUpload upload(kStagingBytes);
    for (const std::uint32_t page : pages) {
        const std::uint64_t bytes = provider->PageBytes(page);
        HDS_VERIFY(bytes % HDS_POOL_UNIT_BYTES == 0, _label + " page " + std::to_string(page));
        const auto [known, isNew] = _pages.emplace(provider->PageId(page), PoolRange());
        if (!isNew) {
            continue; // two pages with one id
        }
        if (!Place(bytes, bytesToCome, &known->second)) {
            _pages.erase(known);
            return false;
        }
        upload.Append(&_buffers[known->second.buffer], known->second.offset, provider->Page(page),
                      bytes);
        provider->Drop(page);
        ++_statistics.uploads;
        _statistics.uploadedBytes += bytes;
        _statistics.uniqueBytes += bytes;
        _held.Set(_held.Bytes() + bytes);
    }
    upload.Flush();
    return true;
}

void ResidentPool::RemoveOthers(const PageProvider& provider) {
    if (_pages.empty()) {
        return;
    }
    std::unordered_set<std::uint64_t> wanted;
    for (std::uint32_t page = 0; page < provider.NumPages(); ++page) {
        wanted.insert(provider.PageId(page));
    }
    for (auto page = _pages.begin(); page != _pages.end();) {
        if (wanted.count(page->first) > 0) {
            ++page;
        } else {
            _held.Set(_held.Bytes() - page->second.bytes);
            _ranges.Free(page->second);
            page = _pages.erase(page);
        }
    }
}

/// A new buffer when no free range is large enough.
bool ResidentPool::Place(std::uint64_t bytes, std::uint64_t bytesToCome, PoolRange* range) {
    return _ranges.Allocate(bytes, range) ||
           (AddBuffer(bytes, bytesToCome) && _ranges.Allocate(bytes, range));
}

bool ResidentPool::AddBuffer(std::uint64_t bytes, std::uint64_t bytesToCome) {
    if (bytes > _bufferLimit || _ranges.NumBuffers() == kMaxPoolBuffers) {
        return false;
    }
    std::uint64_t size = std::max(bytesToCome, _bytes / kGrowthShare);
    size = std::min(size / HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES, _bufferLimit);
    const std::uint32_t index = _ranges.NumBuffers();
    _buffers[index] =
        Buffer(_device, _label + " pool " + std::to_string(index), size, BufferAccess::ReadOnly);
    _ranges.AddBuffer(size);
    _bytes += size;
    return true;
}

} // namespace hds
