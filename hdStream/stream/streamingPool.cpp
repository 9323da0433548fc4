// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/streamingPool.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <unordered_map>
#include <utility>

namespace hds {

namespace {

double SecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::uint64_t RoundDown(std::uint64_t bytes) {
    return bytes / HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES;
}

/// A page makes others leave only when at least this part as many ask for it as for the page that
/// most ask for: the others come later, when more wait for them (docs/streaming.md).
constexpr std::uint32_t kLeastWantedShare = 16;

/// As many pages of the same or a greater age are listed together.
constexpr std::uint32_t kVictimBatch = 512;

/// A pool that has become too small gets so much more than all pages take, for edits to come.
constexpr std::uint64_t kSpareDivisor = 8;
/// Part of a pool that pinned pages may take.
constexpr std::uint64_t kPinDivisor = 4;
/// An edit that wants so many times the room for pinned pages empties the pool.
constexpr std::uint64_t kPinGrowth = 2;

constexpr std::uint64_t kUseHeaderBytes = HDS_USE_HEADER * sizeof(std::uint32_t);

std::uint32_t FirstOfGroup(std::uint32_t page) {
    return page / StreamingPool::kGroupPages * StreamingPool::kGroupPages;
}

} // namespace

StreamingPool::StreamingPool(std::shared_ptr<Device> device, std::string label, Eviction eviction,
                             std::uint64_t bufferLimit)
    : _device(std::move(device)), _label(std::move(label)), _eviction(eviction),
      _bufferLimit(RoundDown(
          std::min({bufferLimit, kMaxPoolBufferBytes, _device->Properties().maxAllocationBytes}))) {
    for (Buffer& buffer : _buffers) {
        buffer = Buffer(_device, _label + " pool", 0, BufferAccess::ReadOnly);
    }
}

void StreamingPool::Update(PageProvider* theProvider, std::uint64_t budgetBytes) {
    _provider = theProvider;
    const PageProvider& provider = *_provider;
    std::unordered_map<std::uint64_t, PageState> known;
    for (std::size_t page = 0; page < _ids.size(); ++page) {
        known.emplace(_ids[page], _pages[page]);
    }
    _ids.assign(provider.NumPages(), 0);
    _pages.assign(provider.NumPages(), {});
    std::uint64_t totalBytes = 0;
    for (std::uint32_t page = 0; page < provider.NumPages(); ++page) {
        _ids[page] = provider.PageId(page);
        totalBytes += provider.PageBytes(page);
        const auto found = known.find(_ids[page]);
        if (found != known.end()) {
            _pages[page] = found->second;
            known.erase(found);
        }
    }
    for (const auto& [id, state] : known) {
        if (state.range.bytes > 0) {
            _ranges.Free(state.range);
        }
    }
    const std::uint64_t largest = CheckFits(budgetBytes);
    for (std::uint32_t page = 0; page < provider.NumPages(); ++page) {
        _pages[page].bytes = provider.PageBytes(page);
    }
    const std::uint64_t limit = std::min(RoundDown(budgetBytes), kMaxPoolBuffers * _bufferLimit);
    const bool isKept = std::min(limit, totalBytes) <= _bytes && budgetBytes >= _bytes;
    const std::uint64_t spare = _bytes > 0 ? totalBytes / kSpareDivisor : 0;
    const std::uint64_t bytes = isKept ? _bytes : std::min(limit, RoundDown(totalBytes + spare));
    const std::uint64_t pinLimit = PinLimit(bytes, largest);
    const std::uint64_t pinned = ChoosePinned(pinLimit);
    const std::uint64_t apart = _ranges.ApartBytes();
    if (isKept && apart <= pinLimit && pinned / kPinGrowth <= apart) {
        ChoosePinned(apart);
        RemoveUnpinned();
    } else {
        AllocateBuffers(bytes, pinned);
    }
    MakeTables();
}

/// Removes pages that were pinned before an edit from the places of pinned ones.
void StreamingPool::RemoveUnpinned() {
    for (std::uint32_t page = 0; page < _pages.size(); ++page) {
        const PageState& state = _pages[page];
        if (IsResident(page) && !state.isPinned && _ranges.IsPinned(state.range.Address())) {
            _ranges.Free(state.range);
            _pages[page].range = {};
            ++_statistics.evictions;
        }
    }
}

/// Most bytes of pinned pages in a pool of `bytes`.
std::uint64_t StreamingPool::PinLimit(std::uint64_t bytes, std::uint64_t largestGroup) const {
    if (_eviction == Eviction::Flush) {
        return 0;
    }
    return std::min(bytes / kPinDivisor, std::min(bytes, _bufferLimit) - largestGroup);
}

/// Chooses the first groups that should stay, of at most `limit` bytes in all. \return their bytes.
std::uint64_t StreamingPool::ChoosePinned(std::uint64_t limit) {
    std::uint64_t sum = 0;
    for (std::uint32_t first = 0; first < _pages.size(); first += kGroupPages) {
        const bool isPinned = _provider->ShouldStay(first) && sum + GroupBytes(first) <= limit;
        sum += isPinned ? GroupBytes(first) : 0;
        for (std::uint32_t page = first; page < first + kGroupPages; ++page) {
            _pages[page].isPinned = isPinned;
        }
    }
    return sum;
}

std::uint64_t StreamingPool::GroupBytes(std::uint32_t first) const {
    std::uint64_t bytes = 0;
    for (std::uint32_t page = first; page < first + kGroupPages; ++page) {
        bytes += _provider->PageBytes(page);
    }
    return bytes;
}

/// The largest group must fit the largest buffer, so that each service can load one. \return its
/// bytes.
std::uint64_t StreamingPool::CheckFits(std::uint64_t budgetBytes) {
    const std::uint64_t limit = std::min(budgetBytes, _bufferLimit);
    std::uint64_t largest = 0;
    for (std::uint32_t first = 0; first < _provider->NumPages(); first += kGroupPages) {
        if (GroupBytes(first) > limit && !_provider->IsExact(first)) {
            _provider->Prepare({first}); // one by one: few are so large
        }
        largest = std::max(largest, GroupBytes(first));
    }
    if (largest > limit) {
        throw Error("--" + _label + "Memory: " + std::to_string(limit) +
                    " bytes cannot hold the largest chunk, which takes " + std::to_string(largest) +
                    " (--chunkSize makes chunks smaller)");
    }
    return largest;
}

/// Makes buffers of `bytes` in all, of which `pinnedBytes` are set apart; what was resident leaves.
void StreamingPool::AllocateBuffers(std::uint64_t bytes, std::uint64_t pinnedBytes) {
    for (Buffer& buffer : _buffers) {
        buffer = Buffer(); // frees first
    }
    _ranges = {};
    _bytes = 0;
    for (PageState& page : _pages) {
        _statistics.evictions += page.range.bytes > 0 ? 1 : 0;
        page.range = {};
    }
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        const std::uint64_t size = std::min(_bufferLimit, bytes - _bytes);
        _buffers[i] =
            Buffer(_device, _label + " pool " + std::to_string(i), size, BufferAccess::ReadOnly);
        if (size > 0) {
            _ranges.AddBuffer(size);
            _bytes += size;
        }
    }
    _ranges.SetApart(pinnedBytes);
}

void StreamingPool::MakeTables() {
    const std::uint64_t bytes = _pages.size() * sizeof(std::uint32_t);
    _table = Buffer(_device, _label + " residency table", bytes, BufferAccess::ReadOnly);
    _useTable = Buffer(_device, _label + " uses", kUseHeaderBytes + bytes);
    _useTable.Write(&_epoch, sizeof(_epoch), HDS_USE_EPOCH * sizeof(std::uint32_t));
    _uses.assign(_pages.size(), 0);
    PublishUses();
    _words.resize(_pages.size());
    for (std::uint32_t page = 0; page < _pages.size(); ++page) {
        UpdateWord(page);
    }
    PublishTable();
}

std::uint64_t StreamingPool::TableBytes() const {
    return _table.Bytes() + _useTable.Bytes();
}

void StreamingPool::BeginEpoch() {
    ++_epoch;
    _useTable.Write(&_epoch, sizeof(_epoch), HDS_USE_EPOCH * sizeof(std::uint32_t));
}

void StreamingPool::BeginCast() {
    BeginEpoch();
    bool isChanged = false;
    for (std::uint32_t page = 0; page < _pages.size(); ++page) {
        if (_pages[page].isDone) {
            isChanged = true;
            _pages[page].isDone = false;
            UpdateWord(page);
        }
    }
    if (isChanged) {
        PublishTable();
    }
}

void StreamingPool::ServiceCast() {
    const auto start = Clock::now();
    const StreamingStatistics before = _statistics;
    for (std::uint32_t page = 0; page < _pages.size(); ++page) {
        if (IsResident(page) && !_pages[page].isDone) {
            _pages[page].isDone = true;
            UpdateWord(page);
        }
    }
    ++_service;
    _hasVictims = false;
    PlaceInBatches(TakeRequests(false), false);
    EndService(start, before);
}

void StreamingPool::Service() {
    const auto start = Clock::now();
    const StreamingStatistics before = _statistics;
    ++_service;
    _hasVictims = false;
    PlaceInBatches(TakeRequests(true), true);
    EndService(start, before);
    BeginEpoch();
}

/// Loads the last batch; tells seconds apart.
void StreamingPool::EndService(Clock::time_point start, const StreamingStatistics& before) {
    HDS_VERIFY(_placedBytes > 0, _label + ": nothing was loaded");
    if (_queued.empty()) {
        PublishTable(); // pages may have left for one that found no place
    }
    LoadQueued();
    PublishUses();
    _statistics.serviceSeconds += SecondsSince(start) -
                                  (_statistics.prepareSeconds - before.prepareSeconds) -
                                  (_statistics.transferSeconds - before.transferSeconds);
}

/// Places requests, the first ones first, until there is no more room; those that can fit are
/// prepared together. \param withGroups pages that hardly any ask for make none leave.
void StreamingPool::PlaceInBatches(const std::vector<Request>& requests, bool withGroups) {
    _placedBytes = 0;
    std::size_t next = 0;
    bool isOver = false;
    while (next < requests.size() && !isOver) {
        LoadQueued(); // what is prepared next may take the place of what is prepared now
        const std::uint64_t room = _bytes - _placedBytes;
        std::vector<std::uint32_t> batch;
        std::uint64_t bytes = 0;
        const std::size_t first = next;
        for (; next < requests.size() && (batch.empty() || bytes < room); ++next) {
            const Request& request = requests[next];
            const std::uint32_t begin = request.isGroup ? FirstOfGroup(request.page) : request.page;
            for (std::uint32_t i = 0; i < (request.isGroup ? kGroupPages : 1); ++i) {
                batch.push_back(begin + i);
                bytes += _pages[begin + i].bytes;
            }
        }
        Prepare(batch);
        for (std::size_t i = first; i < next && !isOver; ++i) {
            // Hardly wanted pages do not make others leave.
            isOver = (withGroups && _eviction == Eviction::Clock && _hasVictims &&
                      requests[i].count < requests[0].count / kLeastWantedShare) ||
                     !PlaceRequest(requests[i]);
        }
    }
}

/// Makes the bytes of pages ready.
void StreamingPool::Prepare(const std::vector<std::uint32_t>& pages) {
    const auto start = Clock::now();
    _provider->Prepare(pages);
    _statistics.prepareSeconds += SecondsSince(start);
    for (const std::uint32_t page : pages) {
        _pages[page].bytes = _provider->PageBytes(page); // exact now
    }
}

/// \return false when there is no room left.
bool StreamingPool::PlaceRequest(const Request& request) {
    const std::uint32_t first = FirstOfGroup(request.page);
    if (request.isGroup) {
        if (PlaceGroup(first, request.count)) {
            return true;
        }
        if (_placedBytes == 0) {
            // What was kept of the group lies in the way of the rest: begin with an empty pool.
            for (std::uint32_t page = 0; page < _pages.size(); ++page) {
                if (MayLeave(_words[page])) {
                    Remove(page);
                }
            }
            PlaceGroup(first, request.count);
        }
        return false;
    }
    if (IsResident(request.page)) {
        Protect(request.page); // came with its group
        return true;
    }
    if (!Place(request.page)) {
        return false;
    }
    _pages[request.page].wanted = request.count;
    return true;
}

/// Places what is missing of the group that begins with page `first`. \return false, with nothing
/// placed, when there is no room for all of it.
bool StreamingPool::PlaceGroup(std::uint32_t first, std::uint32_t wanted) {
    std::array<bool, kGroupPages> isNeeded{};
    for (std::uint32_t i = 0; i < kGroupPages; ++i) {
        // Before anything leaves for the others.
        isNeeded[i] = !IsResident(first + i) && _pages[first + i].bytes > 0;
        if (IsResident(first + i)) {
            Protect(first + i);
        }
    }
    const std::size_t numQueued = _queued.size();
    for (std::uint32_t i = 0; i < kGroupPages; ++i) {
        if (!isNeeded[i]) {
            continue;
        }
        if (!Place(first + i)) {
            _statistics.groupUploads -= _queued.size() - numQueued;
            while (_queued.size() > numQueued) {
                _placedBytes -= _pages[_queued.back()].range.bytes;
                _ranges.Free(_pages[_queued.back()].range);
                _pages[_queued.back()].range = {};
                _queued.pop_back();
            }
            return false;
        }
        _pages[first + i].wanted = wanted;
        ++_statistics.groupUploads;
    }
    return true;
}

void StreamingPool::ReadUses() {
    _useTable.Read(_uses.data(), _uses.size() * sizeof(std::uint32_t), kUseHeaderBytes);
}

/// What kernels have asked for, most wanted first; clears the requests.
/// \param withGroups pages of which the whole group is wanted stand for it.
std::vector<StreamingPool::Request> StreamingPool::TakeRequests(bool withGroups) {
    ReadUses();
    std::vector<Request> requests;
    for (std::uint32_t page = 0; page < _uses.size(); ++page) {
        const std::uint32_t asked = _uses[page];
        if (asked != 0 && !IsResident(page)) {
            requests.push_back(
                {page, asked & ~HDS_ASKED_WHOLE, withGroups && (asked & HDS_ASKED_WHOLE) != 0});
            _uses[page] = 0;
        }
    }
    std::sort(requests.begin(), requests.end(), [](const Request& a, const Request& b) {
        return a.count != b.count ? a.count > b.count : a.page < b.page;
    });
    return requests;
}

/// Finds room for a page, evicting others, and queues it. \return false when all that could leave
/// has left.
bool StreamingPool::Place(std::uint32_t page) {
    PageState& state = _pages[page];
    while (!_ranges.Allocate(state.bytes, state.isPinned, &state.range)) {
        if (!Evict()) {
            state.range = {};
            return false;
        }
    }
    Protect(page);
    _placedBytes += state.range.bytes;
    _queued.push_back(page);
    return true;
}

/// Counts by age what may leave in this service. An age is the number of epochs since the last use.
void StreamingPool::CountVictims() {
    _hasVictims = true;
    _victims.clear();
    _numByAge = {};
    _listedAge = kNumAges;
    for (std::uint32_t page = 0; page < _words.size(); ++page) {
        if (MayLeave(_words[page])) {
            ++_numByAge[std::min(_epoch - _uses[page], kNumAges - 1)];
        }
    }
}

/// Puts the next younger pages into the heap, as few of many leave: a heap of all would take longer
/// than what is left of the service.
void StreamingPool::ListVictims() {
    const std::uint32_t end = _listedAge;
    std::uint32_t count = 0;
    while (_listedAge > 0 && count < kVictimBatch) {
        count += _numByAge[--_listedAge];
    }
    for (std::uint32_t page = 0; count > 0 && page < _words.size(); ++page) {
        if (!MayLeave(_words[page])) {
            continue;
        }
        const std::uint32_t age = std::min(_epoch - _uses[page], kNumAges - 1);
        if (age >= _listedAge && age < end && !IsProtected(page)) {
            _victims.push_back({_uses[page], _pages[page].wanted, page});
        }
    }
    std::make_heap(_victims.begin(), _victims.end(), std::greater<>());
}

/// Makes one page leave, or all (flush). \return false when none may.
bool StreamingPool::Evict() {
    if (!_hasVictims) {
        CountVictims();
    }
    bool isAny = false;
    while (!isAny || _eviction == Eviction::Flush) {
        if (_victims.empty()) {
            if (_listedAge == 0) {
                break;
            }
            ListVictims();
            continue;
        }
        std::pop_heap(_victims.begin(), _victims.end(), std::greater<>());
        const std::uint32_t page = _victims.back().page;
        _victims.pop_back();
        if (!IsProtected(page)) {
            isAny = Remove(page) || isAny;
        }
    }
    return isAny;
}

/// \return false when the page is not resident.
bool StreamingPool::Remove(std::uint32_t page) {
    if (!IsResident(page)) {
        return false;
    }
    if (WasUsed(page)) {
        CountGroup(page); // its stamp goes
    }
    _ranges.Free(_pages[page].range);
    _pages[page].range = {};
    _uses[page] = 0;
    UpdateWord(page);
    ++_statistics.evictions;
    return true;
}

/// \param isAskedFor by kernels.
void StreamingPool::LoadQueued(bool isAskedFor) {
    if (_queued.empty()) {
        return;
    }
    const auto start = Clock::now();
    std::array<std::vector<BufferCopy>, kMaxPoolBuffers> copies;
    for (const std::uint32_t page : _queued) {
        const PoolRange& range = _pages[page].range;
        copies[range.buffer].push_back({_provider->Page(page), range.bytes, range.offset});
        UpdateWord(page);
        _statistics.uploadedBytes += range.bytes;
        ++_statistics.uploads;
        _statistics.uniqueBytes += _pages[page].wasLoaded ? 0 : range.bytes;
        _pages[page].wasLoaded = true;
        if (isAskedFor) {
            CountGroup(page);
        }
    }
    for (std::uint32_t buffer = 0; buffer < NumBuffers(); ++buffer) {
        _buffers[buffer].WriteMany(copies[buffer]);
    }
    _queued.clear();
    _peakUsedBytes = std::max(_peakUsedBytes, _ranges.UsedBytes(_bytes));
    PublishTable(); // only now: words are read by whatever is launched next
    _statistics.transferSeconds += SecondsSince(start);
}

void StreamingPool::UpdateWord(std::uint32_t page) {
    const PageState& state = _pages[page];
    _words[page] = (state.range.bytes > 0 ? state.range.Address() : HDS_NOT_RESIDENT) |
                   (state.isDone ? HDS_PAGE_DONE : 0U);
}

void StreamingPool::PublishTable() {
    _table.Write(_words.data(), _words.size() * sizeof(std::uint32_t));
}

void StreamingPool::PublishUses() {
    _useTable.Write(_uses.data(), _uses.size() * sizeof(std::uint32_t), kUseHeaderBytes);
}

} // namespace hds
