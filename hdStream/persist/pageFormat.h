// SPDX-License-Identifier: Apache-2.0
// The bytes of a page segment (docs/cache-format.md): what is written, and what is believed.
#pragma once

#include "hdStream/persist/pageKey.h"

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

namespace hds {

/// Bump when the layout, or Hasher, changes: segments of other versions are removed.
constexpr std::uint32_t kPageFormatVersion = 1;
constexpr std::string_view kSegmentExtension = ".hdsp";

/// Pages start at multiples of it: a cache line, and what OpenCL wants of a sub-buffer at most.
constexpr std::uint64_t kPageAlignment = 64;
/// An index block is an array of slots; the segment's header is slot 0 of the first one.
constexpr std::uint64_t kSlotBytes = 64;
constexpr std::uint64_t kBlockSlots = 1024;
constexpr std::uint64_t kBlockBytes = kSlotBytes * kBlockSlots;

/// The first slot of a segment.
struct SegmentHeader {
    char magic[8];
    std::uint32_t version;
    std::uint32_t endianMark;
    std::uint64_t capacity; ///< bytes that the segment may grow to, a multiple of kPageAlignment
    std::uint64_t reserved[4];
    std::uint64_t checksum; ///< of all before
};
static_assert(sizeof(SegmentHeader) == kSlotBytes && std::is_trivially_copyable_v<SegmentHeader>);

/// What a slot says; 0 is a slot not (or never) used.
enum class EntryKind : std::uint32_t {
    Page = 1,
    RejectedPage = 2, ///< its payload was found to be wrong
    Link = 3          ///< the last slot of a full block: the next block is at `offset`
};

/// A slot of the index.
struct IndexEntry {
    PageKey key;
    std::uint64_t offset; ///< of the payload or block in the file, a multiple of kPageAlignment
    std::uint64_t bytes;
    std::uint64_t payloadChecksum;
    EntryKind kind;
    std::uint32_t reserved;
    std::uint64_t reserved2;
    std::uint64_t checksum; ///< of all before and of the slot's own place in the file
};
static_assert(sizeof(IndexEntry) == kSlotBytes && std::is_trivially_copyable_v<IndexEntry>);

/// `value` rounded up to a multiple of kPageAlignment.
constexpr std::uint64_t AlignPage(std::uint64_t value) {
    return (value + kPageAlignment - 1) / kPageAlignment * kPageAlignment;
}

std::uint64_t PayloadChecksum(const void* data, std::size_t bytes);

SegmentHeader MakeSegmentHeader(std::uint64_t capacity);
/// Whether this version of the program, on this machine, wrote it, unharmed.
bool IsValid(const SegmentHeader& header);

/// Fills in the checksum. \param slot the entry's offset in the file.
void Seal(IndexEntry* entry, std::uint64_t slot);
/// Whether it was sealed for this slot and lies within the capacity.
bool IsValid(const IndexEntry& entry, std::uint64_t slot, std::uint64_t capacity);
/// Whether nothing was written to the slot.
bool IsEmpty(const IndexEntry& entry);

} // namespace hds
