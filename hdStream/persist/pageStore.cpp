// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/pageStore.h"

#include "hdStream/persist/cacheDirectory.h"
#include "hdStream/persist/pageFolder.h"
#include "hdStream/persist/pageSegment.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <mutex>
#include <shared_mutex>
#include <system_error>
#include <unordered_map>
#include <utility>

namespace hds {

namespace {

/// New segments are no smaller than this.
constexpr std::uint64_t kMinSegmentBytes = 256U << 10U;
/// New segments are at most this part of the whole, so that the oldest can leave one by one.
constexpr std::uint64_t kSegmentsPerStore = 8;
/// Part of what is left that pages which nobody asks for may take: each of those that somebody asks
/// for, but that finds no room, is made again and again.
constexpr std::uint64_t kSpareDivisor = 2;
/// Times a name is tried for a new segment; another process may take its file away each time.
constexpr int kCreateAttempts = 8;

std::string ErrnoText() {
    return std::system_category().message(errno);
}

/// A page in the index.
struct KnownPage {
    StoredPage stored;
    std::uint32_t segment = 0;
    bool isVerified = false;
    bool isUsed = false;  ///< PageStore::UsedPages
    bool isAhead = false; ///< by SaveAhead, and nobody has asked for it since
};

/// A page to read or write without a lock; its segment stays open meanwhile.
struct FoundPage {
    StoredPage stored;
    std::uint32_t number = 0;
    bool isVerified = false;
    std::shared_ptr<PageSegment> segment;
};

} // namespace

struct OpenedPage::Impl {
    FoundPage page;
};

OpenedPage::OpenedPage(std::unique_ptr<const Impl> impl) : _impl(std::move(impl)) {}

OpenedPage::~OpenedPage() = default;

bool OpenedPage::Read(std::uint64_t offset, std::size_t bytes, void* data) const {
    const FoundPage& page = _impl->page;
    return offset <= page.stored.bytes && bytes <= page.stored.bytes - offset &&
           page.segment->ReadPart(page.stored, offset, bytes, data);
}

/// Locks: writeMutex before mutex. writeMutex serialises who takes room in the segment that is
/// appended to; mutex guards the index and the list of segments.
struct PageStore::Impl {
    Impl(PageStoreOptions asked, Warnings* sink)
        : options(std::move(asked)), warnings(sink), process(::getpid()) {}

    void OpenSegments();
    void AddSegment(std::shared_ptr<PageSegment> segment, const std::vector<IndexedPage>& indexed);
    std::optional<FoundPage> Find(const PageKey& key);
    std::optional<FoundPage> FindVerified(const PageKey& key);
    void Reject(const PageKey& key, const FoundPage& page);
    bool Save(const PageKey& key, const void* data, std::size_t bytes, bool isAhead);
    void CountAsked(KnownPage* page);
    std::optional<FoundPage> Reserve(std::uint64_t bytes);
    bool ReadyWriter();
    bool StartSegment(std::uint64_t pageBytes);
    std::shared_ptr<PageSegment> CreateSegment(std::uint64_t capacity);
    void DropRemovedSegments();
    void StopWriting(const std::string& reason);

    PageStoreOptions options;
    Warnings* warnings;
    int process; ///< a forked child reads, but does not append to its parent's segment
    std::atomic<bool> isWriting{false};

    mutable std::shared_mutex mutex;
    std::unordered_map<PageKey, KnownPage> pages;
    std::vector<std::shared_ptr<PageSegment>> segments; ///< by number; null: gone
    std::uint64_t aheadBytes = 0;                       ///< of pages that are isAhead

    std::mutex writeMutex;
    std::shared_ptr<PageSegment> writer;
    std::uint32_t writerNumber = 0;
    bool isFull = false; ///< no room for another segment

    std::atomic<std::uint64_t> pagesLoaded{0};
    std::atomic<std::uint64_t> bytesLoaded{0};
    std::atomic<std::uint64_t> pagesSaved{0};
    std::atomic<std::uint64_t> bytesSaved{0};
    std::atomic<std::uint64_t> pagesRejected{0};
    std::atomic<std::uint64_t> pagesNotKept{0};
    std::atomic<std::uint64_t> numUsed{0};
};

void PageStore::Impl::OpenSegments() {
    std::uint64_t mayGrowBy = 0;
    if (!options.isReadOnly) {
        const std::uint64_t taken = TrimSegments(options.directory, options.maxBytes);
        mayGrowBy = options.maxBytes - std::min(options.maxBytes, taken);
    }
    std::vector<IndexedPage> indexed;
    for (const std::string& path : ListSegments(options.directory)) {
        indexed.clear();
        std::shared_ptr<PageSegment> segment = PageSegment::Open(
            path, mayGrowBy, &indexed,
            options.isReadOnly ? PageSegment::Unreadable::Stays : PageSegment::Unreadable::Goes);
        if (segment == nullptr) {
            continue;
        }
        if (segment->IsWriter()) {
            mayGrowBy = 0; // one is enough
            writer = segment;
            writerNumber = static_cast<std::uint32_t>(segments.size());
        }
        AddSegment(std::move(segment), indexed);
    }
}

void PageStore::Impl::AddSegment(std::shared_ptr<PageSegment> segment,
                                 const std::vector<IndexedPage>& indexed) {
    const std::unique_lock<std::shared_mutex> lock(mutex);
    const auto number = static_cast<std::uint32_t>(segments.size());
    pagesRejected += segment->DamagedEntries();
    segments.push_back(std::move(segment));
    pages.reserve(pages.size() + indexed.size());
    for (const IndexedPage& page : indexed) {
        pages[page.key] = {page.page, number};
    }
}

/// A page, which is used from now on.
std::optional<FoundPage> PageStore::Impl::Find(const PageKey& key) {
    std::optional<FoundPage> result;
    {
        const std::shared_lock<std::shared_mutex> lock(mutex);
        const auto found = pages.find(key);
        if (found == pages.end()) {
            return std::nullopt;
        }
        const KnownPage& page = found->second;
        result = FoundPage{page.stored, page.segment, page.isVerified, segments[page.segment]};
        if (page.isUsed && !page.isAhead) {
            return result;
        }
    }
    if (!options.isReadOnly) {
        result->segment->MarkUsed(); // nobody deletes it from now on
    }
    const std::unique_lock<std::shared_mutex> lock(mutex);
    if (const auto found = pages.find(key); found != pages.end()) {
        CountAsked(&found->second);
    }
    return result;
}

/// Somebody asks for a page. \pre mutex is held.
void PageStore::Impl::CountAsked(KnownPage* page) {
    aheadBytes -= page->isAhead ? page->stored.bytes : 0;
    page->isAhead = false;
    numUsed += page->isUsed ? 0 : 1;
    page->isUsed = true;
}

/// A page that is verified now, and marked as used.
std::optional<FoundPage> PageStore::Impl::FindVerified(const PageKey& key) {
    const auto page = Find(key);
    if (!page) {
        return std::nullopt;
    }
    page->segment->MarkUsed();
    if (!page->isVerified) {
        if (!page->segment->Verify(page->stored)) {
            Reject(key, *page);
            return std::nullopt;
        }
        const std::unique_lock<std::shared_mutex> lock(mutex);
        if (const auto found = pages.find(key); found != pages.end()) {
            found->second.isVerified = true;
        }
    }
    return page;
}

void PageStore::Impl::Reject(const PageKey& key, const FoundPage& page) {
    {
        const std::unique_lock<std::shared_mutex> lock(mutex);
        const auto found = pages.find(key);
        if (found == pages.end() || found->second.segment != page.number ||
            found->second.stored.offset != page.stored.offset) {
            return; // by another thread already
        }
        pages.erase(found);
    }
    ++pagesRejected;
    page.segment->Reject(key, page.stored);
}

void PageStore::Impl::StopWriting(const std::string& reason) {
    if (isWriting.exchange(false) && warnings != nullptr) {
        warnings->Add(options.directory, "no more pages are kept in the cache: " + reason);
    }
}

bool PageStore::Impl::ReadyWriter() {
    if (writer != nullptr && writer->IsUnlinked()) {
        std::error_code error;
        if (!std::filesystem::is_directory(options.directory, error)) {
            StopWriting("the folder was removed");
            return false;
        }
        writer.reset(); // the cache was cleared
        isFull = false;
    } else if (writer != nullptr && writer->IsCut()) {
        writer.reset(); // pages that are left in it are read still
    }
    return true;
}

void PageStore::Impl::DropRemovedSegments() {
    const std::unique_lock<std::shared_mutex> lock(mutex);
    std::vector<bool> isDropped(segments.size(), false);
    bool isAnyDropped = false;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        std::shared_ptr<PageSegment>& segment = segments[i];
        if (segment != nullptr && !segment->IsUsed() && segment->IsUnlinked()) {
            isDropped[i] = isAnyDropped = true;
            segment.reset(); // closing it gives the disk's room back
        }
    }
    for (auto it = pages.begin(); isAnyDropped && it != pages.end();) {
        it = isDropped[it->second.segment] ? pages.erase(it) : std::next(it);
    }
}

std::shared_ptr<PageSegment> PageStore::Impl::CreateSegment(std::uint64_t capacity) {
    std::error_code error;
    std::filesystem::create_directories(options.directory, error);
    if (error) {
        StopWriting(error.message());
        return nullptr;
    }
    for (int i = 0; i < kCreateAttempts; ++i) {
        if (auto segment = PageSegment::Create(NewSegmentPath(options.directory), capacity)) {
            return segment;
        }
        if (errno != EEXIST) {
            break;
        }
    }
    StopWriting(ErrnoText());
    return nullptr;
}

bool PageStore::Impl::StartSegment(std::uint64_t pageBytes) {
    const std::uint64_t usual = AlignPage(std::max(
        kMinSegmentBytes, std::min(options.segmentBytes, options.maxBytes / kSegmentsPerStore)));
    const std::uint64_t capacity = AlignPage(std::max(usual, PageSegment::CapacityFor(pageBytes)));
    const std::uint64_t room = options.maxBytes - std::min(options.maxBytes, capacity);
    const bool hasRoom =
        TrimSegments(options.directory, room) <= room && options.maxBytes >= capacity;
    DropRemovedSegments();
    if (!hasRoom) {
        isFull = capacity == usual; // a page that is larger may be the only one without room
        return false;
    }
    writer = CreateSegment(capacity);
    if (writer == nullptr) {
        return false;
    }
    writer->MarkUsed();
    writerNumber = static_cast<std::uint32_t>(segments.size());
    AddSegment(writer, {});
    return true;
}

std::optional<FoundPage> PageStore::Impl::Reserve(std::uint64_t bytes) {
    const std::lock_guard<std::mutex> lock(writeMutex);
    if (!isWriting || !ReadyWriter()) {
        return std::nullopt;
    }
    for (int attempt = 0; attempt < 2; ++attempt) {
        bool hasFailed = false;
        if (writer != nullptr) {
            if (const auto stored = writer->Reserve(bytes, &hasFailed)) {
                return FoundPage{*stored, writerNumber, true, writer};
            }
        }
        if (hasFailed) {
            StopWriting(ErrnoText());
            return std::nullopt;
        }
        if (attempt > 0 || isFull || !StartSegment(bytes)) {
            return std::nullopt;
        }
    }
    return std::nullopt;
}

PageStore::PageStore(PageStoreOptions options, Warnings* warnings) {
    options.directory = ResolveCacheDirectory(options.directory);
    options.enabled = options.enabled && !options.directory.empty();
    _impl = std::make_unique<Impl>(std::move(options), warnings);
    if (_impl->options.enabled) {
        _impl->isWriting = !_impl->options.isReadOnly;
        _impl->OpenSegments();
    }
}

PageStore::~PageStore() = default;

bool PageStore::Contains(const PageKey& key) const {
    const std::shared_lock<std::shared_mutex> lock(_impl->mutex);
    return _impl->pages.count(key) > 0;
}

std::optional<std::uint64_t> PageStore::Bytes(const PageKey& key) const {
    const auto page = _impl->Find(key);
    return page ? std::optional<std::uint64_t>(page->stored.bytes) : std::nullopt;
}

void PageStore::Forget(const PageKey& key) {
    if (const auto page = _impl->Find(key)) {
        _impl->Reject(key, *page);
    }
}

bool PageStore::Load(const PageKey& key, std::vector<std::uint8_t>* bytes) {
    const auto page = _impl->Find(key);
    if (!page) {
        return false;
    }
    page->segment->MarkUsed();
    bytes->resize(page->stored.bytes);
    if (!page->segment->Read(page->stored, bytes->data())) {
        _impl->Reject(key, *page);
        return false;
    }
    ++_impl->pagesLoaded;
    _impl->bytesLoaded += page->stored.bytes;
    return true;
}

bool PageStore::Save(const PageKey& key, const void* data, std::size_t bytes) {
    return _impl->Find(key) || _impl->Save(key, data, bytes, false);
}

bool PageStore::SaveAhead(const PageKey& key, const void* data, std::size_t bytes) {
    return Contains(key) || _impl->Save(key, data, bytes, true);
}

/// Of a page that is not there.
bool PageStore::Impl::Save(const PageKey& key, const void* data, std::size_t bytes, bool isAhead) {
    if (!isWriting || process != ::getpid()) {
        ++pagesNotKept;
        return false;
    }
    const std::uint64_t checksum = PayloadChecksum(data, bytes);
    auto page = Reserve(bytes);
    if (!page) {
        ++pagesNotKept;
        return false;
    }
    page->stored.checksum = checksum;
    page->segment->MarkUsed();
    if (!page->segment->Write(key, page->stored, data)) {
        StopWriting(ErrnoText());
        ++pagesNotKept;
        return false;
    }
    ++pagesSaved;
    bytesSaved += bytes;
    const std::unique_lock<std::shared_mutex> lock(mutex);
    if (segments[page->number] != nullptr) { // else Clear() came in between
        const KnownPage known{page->stored, page->number, true, true, isAhead};
        const bool isNew = pages.emplace(key, known).second;
        aheadBytes += isNew && isAhead ? bytes : 0;
        ++numUsed;
    }
    return true;
}

bool PageStore::LoadPart(const PageKey& key, std::uint64_t offset, std::size_t bytes, void* data) {
    const auto page = _impl->FindVerified(key);
    if (!page || offset > page->stored.bytes || bytes > page->stored.bytes - offset) {
        return false;
    }
    if (!page->segment->ReadPart(page->stored, offset, bytes, data)) {
        _impl->Reject(key, *page); // the file was cut meanwhile
        return false;
    }
    return true;
}

std::unique_ptr<const OpenedPage> PageStore::Open(const PageKey& key) {
    auto page = _impl->FindVerified(key);
    if (!page) {
        return nullptr;
    }
    auto impl = std::make_unique<const OpenedPage::Impl>(OpenedPage::Impl{*std::move(page)});
    return std::unique_ptr<const OpenedPage>(new OpenedPage(std::move(impl)));
}

std::optional<PageLocation> PageStore::Locate(const PageKey& key) {
    const auto page = _impl->FindVerified(key);
    return page ? std::make_optional(
                      PageLocation{page->number, page->stored.offset, page->stored.bytes})
                : std::nullopt;
}

const std::uint8_t* PageStore::SegmentData(std::uint32_t segment) {
    const std::lock_guard<std::mutex> writeLock(_impl->writeMutex);
    const std::unique_lock<std::shared_mutex> lock(_impl->mutex);
    if (segment >= _impl->segments.size() || _impl->segments[segment] == nullptr) {
        return nullptr;
    }
    _impl->segments[segment]->MarkUsed();
    return _impl->segments[segment]->Map();
}

std::uint64_t PageStore::SegmentBytes(std::uint32_t segment) const {
    const std::shared_lock<std::shared_mutex> lock(_impl->mutex);
    const bool isThere = segment < _impl->segments.size() && _impl->segments[segment] != nullptr;
    return isThere ? _impl->segments[segment]->MappedBytes() : 0;
}

PageStoreStatistics PageStore::Statistics() const {
    PageStoreStatistics statistics;
    statistics.pagesLoaded = _impl->pagesLoaded;
    statistics.bytesLoaded = _impl->bytesLoaded;
    statistics.pagesSaved = _impl->pagesSaved;
    statistics.bytesSaved = _impl->bytesSaved;
    statistics.pagesRejected = _impl->pagesRejected;
    statistics.pagesNotKept = _impl->pagesNotKept;
    return statistics;
}

std::vector<PageKey> PageStore::UsedPages() const {
    const std::shared_lock<std::shared_mutex> lock(_impl->mutex);
    std::vector<PageKey> keys;
    for (const auto& [key, page] : _impl->pages) {
        if (page.isUsed) {
            keys.push_back(key);
        }
    }
    return keys;
}

std::uint64_t PageStore::NumUsed() const {
    return _impl->numUsed;
}

PageAmount PageStore::Amount() const {
    const std::shared_lock<std::shared_mutex> lock(_impl->mutex);
    PageAmount amount{_impl->pages.size(), 0};
    for (const auto& entry : _impl->pages) {
        amount.bytes += entry.second.stored.bytes;
    }
    return amount;
}

std::uint64_t PageStore::Size() const {
    return hds::SegmentBytes(_impl->options.directory);
}

std::uint64_t PageStore::Clear() {
    const std::lock_guard<std::mutex> writeLock(_impl->writeMutex);
    const std::unique_lock<std::shared_mutex> lock(_impl->mutex);
    _impl->pages.clear();
    _impl->aheadBytes = 0;
    _impl->writer.reset();
    _impl->isFull = false;
    for (std::shared_ptr<PageSegment>& segment : _impl->segments) {
        if (segment != nullptr && !segment->IsMapped()) {
            segment.reset();
        }
    }
    return RemoveSegments(_impl->options.directory);
}

const std::string& PageStore::Directory() const {
    return _impl->options.directory;
}

bool PageStore::IsWriting() const {
    return _impl->isWriting;
}

bool PageStore::HasSpareRoom() const {
    const std::shared_lock<std::shared_mutex> lock(_impl->mutex);
    std::uint64_t taken = 0;
    for (const std::shared_ptr<PageSegment>& segment : _impl->segments) {
        taken += segment != nullptr && segment->IsUsed() ? segment->FilledBytes() : 0;
    }
    const std::uint64_t ahead = _impl->aheadBytes;
    const std::uint64_t ofOthers = taken - std::min(taken, ahead);
    const std::uint64_t left =
        _impl->options.maxBytes - std::min(_impl->options.maxBytes, ofOthers);
    return _impl->isWriting && ahead < left / kSpareDivisor;
}

} // namespace hds
