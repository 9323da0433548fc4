// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/mappedPool.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace hds {

namespace {

/// Bytes of the pages that are prepared together.
constexpr std::uint64_t kBatchBytes = 64U << 20U;

} // namespace

MappedPool::MappedPool(std::shared_ptr<Device> device, std::string label)
    : PagePool(std::move(device), std::move(label)) {
    if (!_device->Properties().isCpu) {
        throw Error("--residency mapped: needs a CPU device, " + _device->Properties().name +
                    " is none");
    }
}

bool MappedPool::Update(PageProvider* provider, std::uint64_t /*budgetBytes*/) {
    std::vector<std::uint32_t> addresses(provider->NumPages(), HDS_NOT_RESIDENT);
    std::vector<std::uint32_t> missing;
    MappedPage mapped;
    for (std::uint32_t page = 0; page < provider->NumPages(); ++page) {
        if (provider->PageBytes(page) == 0) {
            continue;
        }
        if (provider->Locate(page, &mapped)) {
            addresses[page] = AddressOf(mapped);
        } else {
            missing.push_back(page);
        }
    }
    for (std::size_t begin = 0; begin < missing.size();) {
        std::vector<std::uint32_t> batch;
        std::uint64_t bytes = 0;
        for (; begin < missing.size() && bytes < kBatchBytes; ++begin) {
            batch.push_back(missing[begin]);
            bytes += provider->PageBytes(missing[begin]);
        }
        provider->Prepare(batch);
        for (const std::uint32_t page : batch) {
            if (!provider->Locate(page, &mapped)) {
                throw Error("--residency mapped: the persistent cache does not hold the " + _label);
            }
            addresses[page] = AddressOf(mapped);
            provider->Drop(page);
        }
    }
    _addresses = UploadVector(_device, _label + " addresses", addresses);
    return true;
}

std::uint32_t MappedPool::AddressOf(const MappedPage& mapped) {
    const auto [found, isNew] =
        _bufferByFile.emplace(mapped.file, static_cast<std::uint32_t>(_bufferByFile.size()));
    if (isNew) {
        if (found->second >= kMaxPoolBuffers || mapped.fileBytes > kMaxPoolBufferBytes) {
            throw Error("--residency mapped: the " + _label + " lies in more than " +
                        std::to_string(kMaxPoolBuffers) +
                        " files of the persistent cache (hdstream cache --clear)");
        }
        _buffers[found->second] = Buffer::OfHostMemory(_device, _label + " file", mapped.file,
                                                       mapped.fileBytes, HostMemoryCount::NotAtAll);
    }
    return PoolRange{found->second, mapped.offset, 0}.Address();
}

} // namespace hds
