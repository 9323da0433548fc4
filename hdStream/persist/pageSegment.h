// SPDX-License-Identifier: Apache-2.0
// One file of the page store: an append-only file of pages with its index in blocks of its own, so
// that opening reads the index alone (docs/cache-format.md). One process at a time appends to it,
// any number read it.
//
// Locks (File::TryLock): byte 0 is held exclusively by the one that appends, byte 1 is shared by
// all that have used a page of it. Who wants to remove the file needs both, exclusively.
#pragma once

#include "hdStream/persist/file.h"
#include "hdStream/persist/pageFormat.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Removes a segment's file unless a process holds it. `file` is `path`, open, not locked.
bool RemoveSegmentFile(const std::string& path, const File& file);

/// Where a page lies in its segment.
struct StoredPage {
    std::uint64_t offset = 0; ///< of the payload, a multiple of kPageAlignment
    std::uint64_t bytes = 0;
    std::uint64_t checksum = 0;
    std::uint64_t slot = 0; ///< offset of the page's index entry
};

/// A page as the index names it.
struct IndexedPage {
    PageKey key;
    StoredPage page;
};

/// Thread rule: Open, Create, Reserve, Map and destruction are the owner's to serialise; the rest
/// is thread-safe.
class PageSegment {
public:
    /// What becomes of a file that is damaged in its header or of another version: it is removed
    /// unless a process holds it, or left alone.
    enum class Unreadable { Goes, Stays };

    /// Opens a segment and appends its pages to `pages`, in the order they were saved.
    /// \param mayGrowBy claims it for appending if no process does, it is sound, and has room, but
    /// for no more than this many bytes; 0: only for reading.
    /// \return null if there is no such segment.
    static std::shared_ptr<PageSegment> Open(const std::string& path, std::uint64_t mayGrowBy,
                                             std::vector<IndexedPage>* pages,
                                             Unreadable unreadable);

    /// Makes a segment for appending. \return null with errno; EEXIST: take another name.
    static std::shared_ptr<PageSegment> Create(const std::string& path, std::uint64_t capacity);

    ~PageSegment();
    PageSegment(const PageSegment&) = delete;
    PageSegment& operator=(const PageSegment&) = delete;

    /// Bytes that a new segment must have for one page.
    static std::uint64_t CapacityFor(std::uint64_t pageBytes) {
        return kBlockBytes + AlignPage(pageBytes);
    }

    bool IsWriter() const { return _isWriter; }
    /// Bytes of the file that are taken.
    std::uint64_t End() const { return _end; }
    /// Index entries that were found to be wrong when it was opened.
    std::uint64_t DamagedEntries() const { return _damagedEntries; }
    bool IsUnlinked() const { return _file.IsUnlinked(); }
    /// Whether the file has become shorter than what is in it. It must not be appended to: the hole
    /// in between would read as pages of zeros.
    bool IsCut() const { return _file.Size() < _written.load(std::memory_order_relaxed); }

    /// From now on no process removes the file for lack of room; it counts as used just now.
    void MarkUsed();
    bool IsUsed() const { return _isUsed.load(std::memory_order_relaxed); }
    /// Bytes up to the end of the last page that is known to be in it.
    std::uint64_t FilledBytes() const {
        return std::max(_readableBytes, _written.load(std::memory_order_relaxed));
    }

    /// Takes room for a page; Write() fills it. Needs IsWriter().
    /// \param hasFailed set when the file could not be written (errno).
    /// \return empty when the segment is full or writing failed.
    std::optional<StoredPage> Reserve(std::uint64_t bytes, bool* hasFailed);

    /// Writes the payload, then the index entry: whoever sees the entry finds the payload.
    /// `page` is from Reserve, its checksum filled in. \return false with errno.
    bool Write(const PageKey& key, const StoredPage& page, const void* data) const;

    /// \return false if it cannot be read or is not what was saved.
    bool Read(const StoredPage& page, std::uint8_t* data) const;

    /// Bytes [offset, offset + bytes) of a page that was verified. \return false: cannot be read.
    bool ReadPart(const StoredPage& page, std::uint64_t offset, std::size_t bytes,
                  void* data) const {
        return _file.Read(page.offset + offset, data, bytes);
    }

    /// As Read, without keeping it.
    bool Verify(const StoredPage& page) const;

    /// Marks the page as wrong in the file, if it can be written: no later process finds it.
    void Reject(const PageKey& key, const StoredPage& page) const;

    /// A read-only mapping of MappedBytes(), for the life of this object; null if there is none to
    /// be had. For the writer that is the capacity, so that later pages appear in it.
    const std::uint8_t* Map();
    bool IsMapped() const { return _mapping != nullptr; }
    /// Stays the same from opening on for a writer, and for a reader.
    std::uint64_t MappedBytes() const { return _isWriter ? _capacity : _readableBytes; }

private:
    PageSegment(File file, std::uint64_t capacity);

    bool IsFitForAppending(std::uint64_t mayGrowBy) const;
    void ReadIndex(std::vector<IndexedPage>* pages);
    std::uint64_t ReadBlock(std::uint64_t block, std::vector<IndexedPage>* pages);
    void ReadEntry(const IndexEntry& entry, std::uint64_t slot, std::uint64_t fileBytes,
                   std::vector<IndexedPage>* pages);
    bool StartBlock();
    bool Trim();

    File _file;
    std::uint64_t _capacity;
    std::uint64_t _end = kBlockBytes; ///< where the next payload or block goes
    std::uint64_t _block = 0;         ///< offset of the block that takes entries
    std::uint64_t _nextSlot = 1;      ///< in it
    std::uint64_t _readableBytes = 0; ///< that others had written when it was opened
    std::uint64_t _damagedEntries = 0;
    int _process; ///< the one that opened it: a forked child leaves the file alone
    bool _isWriter = false;
    bool _isTrimmed = false; ///< what a dead writer left behind _end is gone
    std::atomic<bool> _isUsed{false};
    mutable std::atomic<std::uint64_t> _written{0}; ///< end of the last page there, for a writer
    const std::uint8_t* _mapping = nullptr;
};

} // namespace hds
