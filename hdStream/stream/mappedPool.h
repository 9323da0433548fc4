// SPDX-License-Identifier: Apache-2.0
// Mapped mode: on CPU devices kernels read pages where the persistent cache
// has them, in files that are mapped into memory. Nothing is copied and no memory is held: what is
// not read is not loaded, and the system takes back what is read no more. Kernels see a resident
// scene. Explained in docs/streaming.md.
#pragma once

#include "hdStream/stream/pagePool.h"

#include <memory>
#include <string>
#include <unordered_map>

namespace hds {

/// Buffers over mapped files. Externally synchronised.
class MappedPool : public PagePool {
public:
    /// An empty pool. \throws Error when the device is no CPU.
    MappedPool(std::shared_ptr<Device> device, std::string label);

    /// Serves all pages; those that are in no file are prepared, which puts them there. There is no
    /// budget. \return true. \throws Error when the cache cannot hold them, or spreads them over
    /// more files than there are buffers.
    bool Update(PageProvider* provider, std::uint64_t budgetBytes) override;

    std::uint32_t NumBuffers() const override {
        return static_cast<std::uint32_t>(_bufferByFile.size());
    }
    /// No memory is held, and nothing is counted.
    std::uint64_t Bytes() const override { return 0; }
    std::uint64_t PeakUsedBytes() const override { return 0; }
    void BeginStatistics() override {}
    StreamingStatistics Statistics() const override { return {}; }

private:
    std::uint32_t AddressOf(const MappedPage& mapped);

    std::unordered_map<const std::uint8_t*, std::uint32_t> _bufferByFile;
};

} // namespace hds
