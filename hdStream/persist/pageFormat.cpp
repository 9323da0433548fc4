// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/pageFormat.h"

#include <cstring>

namespace hds {

namespace {

constexpr char kMagic[8] = {'h', 'd', 's', 'P', 'a', 'g', 'e', 's'};
constexpr std::uint32_t kEndianMark = 0x01020304U;

std::uint64_t HeaderChecksum(const SegmentHeader& header) {
    return PayloadChecksum(&header, offsetof(SegmentHeader, checksum));
}

std::uint64_t EntryChecksum(const IndexEntry& entry, std::uint64_t slot) {
    Hasher hasher;
    hasher.Append(&entry, offsetof(IndexEntry, checksum));
    hasher.Append(slot);
    return hasher.Words()[0];
}

} // namespace

std::uint64_t PayloadChecksum(const void* data, std::size_t bytes) {
    Hasher hasher;
    hasher.Append(data, bytes);
    return hasher.Words()[0];
}

SegmentHeader MakeSegmentHeader(std::uint64_t capacity) {
    SegmentHeader header{};
    std::memcpy(header.magic, kMagic, sizeof(kMagic));
    header.version = kPageFormatVersion;
    header.endianMark = kEndianMark;
    header.capacity = capacity;
    header.checksum = HeaderChecksum(header);
    return header;
}

bool IsValid(const SegmentHeader& header) {
    return std::memcmp(header.magic, kMagic, sizeof(kMagic)) == 0 &&
           header.version == kPageFormatVersion && header.endianMark == kEndianMark &&
           header.capacity >= kBlockBytes && header.capacity % kPageAlignment == 0 &&
           header.checksum == HeaderChecksum(header);
}

void Seal(IndexEntry* entry, std::uint64_t slot) {
    entry->checksum = EntryChecksum(*entry, slot);
}

bool IsValid(const IndexEntry& entry, std::uint64_t slot, std::uint64_t capacity) {
    const bool isKnown = entry.kind == EntryKind::Page || entry.kind == EntryKind::RejectedPage ||
                         entry.kind == EntryKind::Link;
    return isKnown && entry.offset >= kBlockBytes && entry.offset % kPageAlignment == 0 &&
           entry.offset <= capacity && entry.bytes <= capacity - entry.offset &&
           entry.checksum == EntryChecksum(entry, slot);
}

bool IsEmpty(const IndexEntry& entry) {
    const IndexEntry empty{};
    return std::memcmp(&entry, &empty, sizeof(entry)) == 0;
}

} // namespace hds
