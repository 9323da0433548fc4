// SPDX-License-Identifier: Apache-2.0
// The persistent store of pages: many small binary objects by 128-bit key in few files, which
// several processes may share. Invariant: a page is either complete and verified, or absent.
// A folder that cannot be written or a full disk is one warning and no more saving; it never fails
// a render. Explained in docs/cache-format.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/persist/pageKey.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Options of a page store.
struct PageStoreOptions {
    std::string directory;                    ///< as ResolveCacheDirectory takes it
    bool enabled = true;                      ///< false: nothing is found, nothing is kept
    bool isReadOnly = false;                  ///< nothing is kept, and nothing leaves
    std::uint64_t maxBytes = 32ULL << 30U;    ///< of all segments; see PageStore about leaving
    std::uint64_t segmentBytes = 1ULL << 30U; ///< of a new segment, at most an eighth of maxBytes
};

/// Where a page lies in memory: at SegmentData(segment) + offset.
struct PageLocation {
    std::uint32_t segment = 0; ///< number within this store, never used again
    std::uint64_t offset = 0;  ///< bytes, a multiple of 64
    std::uint64_t bytes = 0;
};

/// A page that was found and verified, for who reads many parts of it: nothing is looked up again.
/// Its file stays open as long as this is there, also when the cache is cleared.
class OpenedPage {
public:
    ~OpenedPage();
    OpenedPage(const OpenedPage&) = delete;
    OpenedPage& operator=(const OpenedPage&) = delete;

    /// Copies bytes [offset, offset + bytes); thread-safe. \return false: not inside the page, or
    /// the file was cut meanwhile.
    bool Read(std::uint64_t offset, std::size_t bytes, void* data) const;

private:
    friend class PageStore;
    struct Impl;
    explicit OpenedPage(std::unique_ptr<const Impl> impl);
    std::unique_ptr<const Impl> _impl;
};

/// What a store has done since it was opened.
struct PageStoreStatistics {
    std::uint64_t pagesLoaded = 0;
    std::uint64_t bytesLoaded = 0;
    std::uint64_t pagesSaved = 0;
    std::uint64_t bytesSaved = 0;
    std::uint64_t pagesRejected = 0; ///< damaged: absent from then on
    std::uint64_t pagesNotKept = 0;  ///< not saved, for lack of room or after a failure
};

/// Some pages.
struct PageAmount {
    std::uint64_t pages = 0;
    std::uint64_t bytes = 0;
};

/// Pages by key. All methods are thread-safe, none throws for what it finds in the folder.
///
/// Opening reads the index of all segments; pages that other processes save later are not noticed.
/// Above maxBytes whole segments leave, least recently used first, but none of which a live process
/// (this one too) has used a page: when those fill the cache, saving stops, since a render that
/// goes through more pages than fit in turn would otherwise never find any of them.
class PageStore {
public:
    PageStore(PageStoreOptions options, Warnings* warnings);
    /// Ends all mappings.
    ~PageStore();
    PageStore(const PageStore&) = delete;
    PageStore& operator=(const PageStore&) = delete;

    bool Contains(const PageKey& key) const;
    /// Length of a page.
    std::optional<std::uint64_t> Bytes(const PageKey& key) const;

    /// Reads a page and verifies its checksum. \return false if it is absent, or was found to be
    /// damaged: it is forgotten then, `bytes` holds nothing of use, and the caller makes it again.
    bool Load(const PageKey& key, std::vector<std::uint8_t>* bytes);

    /// Copies bytes [offset, offset + bytes) of a page. The page is verified as a whole the first
    /// time. \return as Load; a part that is not inside the page is absent.
    bool LoadPart(const PageKey& key, std::uint64_t offset, std::size_t bytes, void* data);

    /// A page to read parts of. It is verified as a whole the first time. \return null: as Load.
    std::unique_ptr<const OpenedPage> Open(const PageKey& key);

    /// Keeps a page; one that is there is left as it is. After a failure (one warning) nothing is
    /// saved any more, what was saved stays readable.
    /// \return whether the page is in the store now.
    bool Save(const PageKey& key, const void* data, std::size_t bytes);
    /// The same for a page that nobody has asked for yet (HasSpareRoom).
    bool SaveAhead(const PageKey& key, const void* data, std::size_t bytes);

    /// A page that should not have been saved: it is absent from now on, and in stores that are
    /// opened later.
    void Forget(const PageKey& key);

    /// For zero-copy reading through SegmentData. The page is verified the first time; a damaged
    /// one is forgotten as by Load.
    std::optional<PageLocation> Locate(const PageKey& key);

    /// A read-only mapping of SegmentBytes(segment) bytes, aligned to memory pages, until the store
    /// goes. Pages saved later into the same segment appear in it. Only located pages may be read.
    /// \return null when it cannot be mapped: Load works still.
    const std::uint8_t* SegmentData(std::uint32_t segment);
    std::uint64_t SegmentBytes(std::uint32_t segment) const;

    PageStoreStatistics Statistics() const;

    /// The pages that this store has loaded, saved or told the length of, of those that are there.
    std::vector<PageKey> UsedPages() const;
    /// How many pages were used; grows whenever UsedPages does.
    std::uint64_t NumUsed() const;
    /// How many pages there are, and their bytes.
    PageAmount Amount() const;

    /// Bytes of all segments in the folder.
    std::uint64_t Size() const;

    /// Forgets all pages and deletes all segments, also those of other processes, which notice and
    /// start anew. Mappings stay. \return the bytes of disk they took.
    std::uint64_t Clear();

    const std::string& Directory() const;
    /// Whether pages are still saved.
    bool IsWriting() const;
    /// Whether there is room for SaveAhead: pages of it that nobody has asked for since take at
    /// most half of what all others leave of maxBytes. The others are all segments that cannot
    /// leave as long as this store is open.
    bool HasSpareRoom() const;

private:
    struct Impl;
    std::unique_ptr<Impl> _impl;
};

} // namespace hds
