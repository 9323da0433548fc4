// SPDX-License-Identifier: Apache-2.0
// Device memory in which kernels find the pages of a provider: what the resident, the streaming and
// the mapped pool have in common. Explained in docs/architecture.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/stream/pageProvider.h"
#include "hdStream/stream/poolCounters.h"
#include "hdStream/stream/rangeAllocator.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>

namespace hds {

/// Buffers of pages, and the table that tells kernels where each page is. Externally synchronised.
class PagePool {
public:
    virtual ~PagePool() = default;
    PagePool(const PagePool&) = delete;
    PagePool& operator=(const PagePool&) = delete;

    /// Serves the pages of `provider`, which must live until the next call. Pages that are in the
    /// pool (known by their ids) stay. Blocks.
    /// \param budgetBytes of device memory, for a pool that can do with less than all pages.
    /// \return false when edits have scattered the free room; the pool is of no use then.
    /// \throws Error that names an option when the pages do not fit.
    virtual bool Update(PageProvider* provider, std::uint64_t budgetBytes) = 0;

    /// The residency table (kernels/shared/residency.h).
    const Buffer& Addresses() const { return _addresses; }
    /// Buffer `i` of the signature; unused ones are tiny but valid.
    const Buffer& PoolBuffer(std::uint32_t i) const { return _buffers[i]; }
    virtual std::uint32_t NumBuffers() const = 0;

    /// Bytes of device memory for pages, and for the tables that tell of them.
    virtual std::uint64_t Bytes() const = 0;
    virtual std::uint64_t TableBytes() const { return _addresses.Bytes(); }
    /// Bytes of pages that are resident and leave with the scene only, though others may leave.
    virtual std::uint64_t PinnedBytes() const { return 0; }
    /// The most bytes of pages that were resident at a time since BeginStatistics.
    virtual std::uint64_t PeakUsedBytes() const = 0;

    /// Counts from 0 again.
    virtual void BeginStatistics() = 0;
    virtual StreamingStatistics Statistics() const = 0;

protected:
    /// No pages. \param label names the pool in error messages.
    PagePool(std::shared_ptr<Device> device, std::string label);

    std::shared_ptr<Device> _device;
    std::string _label;
    std::array<Buffer, kMaxPoolBuffers> _buffers;
    Buffer _addresses;
};

} // namespace hds
