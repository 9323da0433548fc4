// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/pageSegment.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace hds {

namespace {

// What the lock bytes mean.
constexpr std::uint64_t kWriterLock = 0;
constexpr std::uint64_t kUserLock = 1;
constexpr std::uint64_t kAllLocks = 2;

/// Segments with less room than this fraction are not continued.
constexpr std::uint64_t kUsefulFraction = 16;

} // namespace

bool RemoveSegmentFile(const std::string& path, const File& file) {
    return file.TryLock(0, kAllLocks, true) == LockResult::Acquired && ::unlink(path.c_str()) == 0;
}

PageSegment::PageSegment(File file, std::uint64_t capacity)
    : _file(std::move(file)), _capacity(capacity), _process(::getpid()) {}

std::shared_ptr<PageSegment> PageSegment::Open(const std::string& path, std::uint64_t mayGrowBy,
                                               std::vector<IndexedPage>* pages,
                                               Unreadable unreadable) {
    File file = File::Open(path);
    if (!file.IsOpen()) {
        return nullptr;
    }
    SegmentHeader header{};
    if (!file.Read(0, &header, sizeof(header)) || !IsValid(header)) {
        // Another version's, damaged, or being made just now: then its maker holds the lock.
        if (unreadable == Unreadable::Goes) {
            RemoveSegmentFile(path, file);
        }
        return nullptr;
    }
    std::shared_ptr<PageSegment> segment(new PageSegment(std::move(file), header.capacity));
    // The lock comes before the index, or another process might append in between.
    const bool isLocked = mayGrowBy > 0 && segment->_file.IsWritable() &&
                          segment->_file.TryLock(kWriterLock, 1, true) == LockResult::Acquired;
    segment->ReadIndex(pages);
    segment->_isWriter = isLocked && segment->IsFitForAppending(mayGrowBy);
    segment->_written = std::min(segment->_end, segment->_file.Size());
    if (isLocked && !segment->_isWriter) {
        segment->_file.Unlock(kWriterLock, 1);
    }
    return segment;
}

std::shared_ptr<PageSegment> PageSegment::Create(const std::string& path, std::uint64_t capacity) {
    File file = File::Create(path);
    if (!file.IsOpen()) {
        return nullptr;
    }
    if (file.TryLock(kWriterLock, 1, true) == LockResult::Busy || file.IsUnlinked()) {
        errno = EEXIST; // another process found it empty, and removes it as damaged
        return nullptr;
    }
    const SegmentHeader header = MakeSegmentHeader(capacity);
    if (!file.Write(0, &header, sizeof(header))) {
        const int reason = errno;
        ::unlink(path.c_str());
        errno = reason;
        return nullptr;
    }
    std::shared_ptr<PageSegment> segment(new PageSegment(std::move(file), capacity));
    segment->_isWriter = true;
    segment->_isTrimmed = true;
    return segment;
}

PageSegment::~PageSegment() {
    if (_mapping != nullptr) {
        ::munmap(const_cast<std::uint8_t*>(_mapping), MappedBytes());
        if (_isWriter && _process == ::getpid()) {
            _file.Resize(_end); // Map() made it longer
        }
    }
}

bool PageSegment::IsFitForAppending(std::uint64_t mayGrowBy) const {
    const std::uint64_t room = _capacity - _end;
    return _damagedEntries == 0 && !_file.IsUnlinked() && room >= _capacity / kUsefulFraction &&
           room <= mayGrowBy;
}

void PageSegment::MarkUsed() {
    if (!IsUsed() && !_isUsed.exchange(true)) {
        _file.TryLock(kUserLock, 1, false);
        _file.Touch();
    }
}

void PageSegment::ReadIndex(std::vector<IndexedPage>* pages) {
    for (std::uint64_t block = 0;;) {
        _block = block;
        _end = std::max(_end, block + kBlockBytes);
        const std::uint64_t next = ReadBlock(block, pages);
        if (next <= block) {
            break;
        }
        block = next;
    }
    _readableBytes = AlignPage(std::min(_end, _file.Size()));
}

std::uint64_t PageSegment::ReadBlock(std::uint64_t block, std::vector<IndexedPage>* pages) {
    std::vector<IndexEntry> entries(kBlockSlots);
    const std::uint64_t first = block == 0 ? 1 : 0; // behind the header
    const std::uint64_t size = _file.Size();
    if (!_file.Read(block, entries.data(),
                    std::min(size > block ? size - block : 0, kBlockBytes))) {
        ++_damagedEntries;
        return 0;
    }
    const std::uint64_t fileBytes = _file.Size(); // has the payloads of what was read
    std::uint64_t used = kBlockSlots;
    while (used > first && IsEmpty(entries[used - 1])) {
        --used;
    }
    // A last entry that is wrong is one whose writing was interrupted: its slot is free.
    if (used > first && !IsValid(entries[used - 1], block + (used - 1) * kSlotBytes, _capacity)) {
        --used;
    }
    _nextSlot = std::max(used, first);
    for (std::uint64_t i = first; i < used; ++i) {
        const std::uint64_t slot = block + i * kSlotBytes;
        if (IsEmpty(entries[i])) {
            continue; // reserved by a process that died before it wrote the page
        }
        if (!IsValid(entries[i], slot, _capacity)) {
            ++_damagedEntries;
        } else if (entries[i].kind == EntryKind::Link) {
            return entries[i].offset;
        } else {
            ReadEntry(entries[i], slot, fileBytes, pages);
        }
    }
    return 0;
}

void PageSegment::ReadEntry(const IndexEntry& entry, std::uint64_t slot, std::uint64_t fileBytes,
                            std::vector<IndexedPage>* pages) {
    _end = std::max(_end, AlignPage(entry.offset + entry.bytes));
    if (entry.kind == EntryKind::RejectedPage) {
        return;
    }
    if (entry.offset + entry.bytes > fileBytes) {
        ++_damagedEntries; // the file was cut
        return;
    }
    pages->push_back({entry.key, {entry.offset, entry.bytes, entry.payloadChecksum, slot}});
}

bool PageSegment::StartBlock() {
    IndexEntry link{};
    link.offset = _end;
    link.bytes = kBlockBytes;
    link.kind = EntryKind::Link;
    const std::uint64_t slot = _block + (kBlockSlots - 1) * kSlotBytes;
    Seal(&link, slot);
    if (!_file.Write(slot, &link, sizeof(link))) {
        return false;
    }
    _block = _end;
    _nextSlot = 0;
    _end += kBlockBytes;
    return true;
}

bool PageSegment::Trim() {
    // What a writer left that died; a new block must find zeros where it starts.
    _isTrimmed = _isTrimmed || _file.Resize(std::min(_end, _file.Size()));
    return _isTrimmed;
}

std::optional<StoredPage> PageSegment::Reserve(std::uint64_t bytes, bool* hasFailed) {
    const bool isBlockFull = _nextSlot == kBlockSlots - 1;
    const std::uint64_t room = _capacity - _end;
    const std::uint64_t overhead = isBlockFull ? kBlockBytes : 0;
    if (room < overhead || bytes > room - overhead || AlignPage(bytes) > room - overhead) {
        return std::nullopt;
    }
    if (!Trim() || (isBlockFull && !StartBlock())) {
        *hasFailed = true;
        return std::nullopt;
    }
    StoredPage page;
    page.offset = _end;
    page.bytes = bytes;
    page.slot = _block + _nextSlot * kSlotBytes;
    _end += AlignPage(bytes);
    ++_nextSlot;
    return page;
}

bool PageSegment::Write(const PageKey& key, const StoredPage& page, const void* data) const {
    IndexEntry entry{};
    entry.key = key;
    entry.offset = page.offset;
    entry.bytes = page.bytes;
    entry.payloadChecksum = page.checksum;
    entry.kind = EntryKind::Page;
    Seal(&entry, page.slot);
    if (!_file.Write(page.offset, data, page.bytes) ||
        !_file.Write(page.slot, &entry, sizeof(entry))) {
        return false;
    }
    const std::uint64_t end = page.bytes > 0 ? page.offset + page.bytes : 0;
    std::uint64_t known = _written.load(std::memory_order_relaxed);
    while (known < end && !_written.compare_exchange_weak(known, end, std::memory_order_relaxed)) {
    }
    return true;
}

bool PageSegment::Read(const StoredPage& page, std::uint8_t* data) const {
    return _file.Read(page.offset, data, page.bytes) &&
           PayloadChecksum(data, page.bytes) == page.checksum;
}

bool PageSegment::Verify(const StoredPage& page) const {
    // Not through the mapping: a file that was cut would be a signal there, and is an error here.
    std::vector<std::uint8_t> part(std::min<std::uint64_t>(page.bytes, kBlockBytes));
    Hasher hasher;
    for (std::uint64_t done = 0; done < page.bytes; done += part.size()) {
        const std::size_t bytes = std::min<std::uint64_t>(part.size(), page.bytes - done);
        if (!_file.Read(page.offset + done, part.data(), bytes)) {
            return false;
        }
        hasher.Append(part.data(), bytes);
    }
    return hasher.Words()[0] == page.checksum;
}

void PageSegment::Reject(const PageKey& key, const StoredPage& page) const {
    IndexEntry entry{};
    entry.key = key;
    entry.offset = page.offset;
    entry.bytes = page.bytes;
    entry.kind = EntryKind::RejectedPage;
    Seal(&entry, page.slot);
    // Never longer than it is: see IsCut.
    if (_file.IsWritable() && page.slot + sizeof(entry) <= _file.Size()) {
        _file.Write(page.slot, &entry, sizeof(entry));
    }
}

const std::uint8_t* PageSegment::Map() {
    if (_mapping == nullptr && (!_isWriter || (Trim() && _file.Resize(_capacity)))) {
        _mapping = _file.Map(MappedBytes());
    }
    return _mapping;
}

} // namespace hds
