// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/streamingPool.h"

#include "hdStream/base/error.h"
#include "hdStream/base/timer.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace hds {

namespace {

std::uint64_t RoundDown(std::uint64_t bytes) {
    return bytes / HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES;
}

/// A page makes others leave only when at least this part as many ask for it as for the page that
/// most ask for: the others come later, when more wait for them (docs/streaming.md).
constexpr std::uint32_t kLeastWantedShare = 16;

/// A pool that has become too small gets so much more than all pages take, for edits to come.
constexpr std::uint64_t kSpareDivisor = 8;
/// Part of a pool that pinned pages may take.
constexpr std::uint64_t kPinDivisor = 4;
/// An edit that wants so many times the room for pinned pages empties the pool.
constexpr std::uint64_t kPinGrowth = 2;
/// Most bytes of pages that are prepared together: who cancels a render waits for them.
constexpr std::uint64_t kBatchBytes = 32U << 20U;
/// Of so many pages for each entry two words a page take more of the device than hash tables.
constexpr std::uint64_t kLeastPagesPerEntry = 2;

constexpr std::uint64_t kUseHeaderBytes = HDS_USE_HEADER * sizeof(std::uint32_t);

} // namespace

StreamingPool::StreamingPool(std::shared_ptr<Device> device, std::string label,
                             std::unique_ptr<EvictionOrder> order, std::uint64_t bufferLimit)
    : PagePool(std::move(device), std::move(label)),
      _bufferLimit(RoundDown(
          std::min({bufferLimit, kMaxPoolBufferBytes, _device->Properties().maxAllocationBytes}))),
      _order(order ? std::move(order) : std::make_unique<LastUseOrder>()) {}

bool StreamingPool::Update(PageProvider* provider, std::uint64_t budgetBytes) {
    _provider = provider;
    Renumber();
    std::uint64_t totalBytes = 0;
    for (std::uint32_t page = 0; page < _table.NumPages(); ++page) {
        totalBytes += _provider->PageBytes(page);
    }
    const std::uint64_t largest = CheckFits(budgetBytes);
    _pageBytes.resize(_table.NumPages());
    for (std::uint32_t page = 0; page < _table.NumPages(); ++page) {
        _pageBytes[page] = _provider->PageBytes(page);
    }
    const std::uint64_t limit = std::min(RoundDown(budgetBytes), kMaxPoolBuffers * _bufferLimit);
    const bool isKept = std::min(limit, totalBytes) <= _bytes && budgetBytes >= _bytes;
    const std::uint64_t spare = _bytes > 0 ? totalBytes / kSpareDivisor : 0;
    const std::uint64_t bytes = isKept ? _bytes : std::min(limit, RoundDown(totalBytes + spare));
    ChooseHash(bytes, totalBytes);
    const std::uint64_t pinLimit = PinLimit(bytes, largest);
    const std::uint64_t pinned = ChoosePinned(pinLimit);
    const std::uint64_t apart = _table.PinLimit();
    if (isKept && HasEntries() && apart <= pinLimit && pinned / kPinGrowth <= apart) {
        ChoosePinned(apart);
        _counters.CountEvictions(_table.RemoveUnpinned());
    } else {
        AllocateBuffers(bytes, pinned);
    }
    _counters.SetHeld(_table.PlacedBytes());
    MakeTables();
    return true;
}

/// The pages are those of the provider.
void StreamingPool::Renumber() {
    std::vector<std::uint64_t> ids(_provider->NumPages());
    for (std::uint32_t page = 0; page < ids.size(); ++page) {
        ids[page] = _provider->PageId(page);
    }
    const std::vector<std::uint32_t> previous = _table.Renumber(ids);
    _order->Renumber(previous);
    _counters.Renumber(previous);
}

/// Most bytes of pinned pages in a pool of `bytes`.
std::uint64_t StreamingPool::PinLimit(std::uint64_t bytes, std::uint64_t largestGroup) const {
    if (!_order->IsSelective()) {
        return 0;
    }
    return std::min(bytes / kPinDivisor, std::min(bytes, _bufferLimit) - largestGroup);
}

/// Chooses the first groups that should stay, of at most `limit` bytes in all. \return their bytes.
std::uint64_t StreamingPool::ChoosePinned(std::uint64_t limit) {
    std::uint64_t sum = 0;
    std::uint64_t mostPages = _hash ? _hash->MostPages() / kPinDivisor : _table.NumPages();
    for (std::uint32_t first = 0; first < _table.NumPages(); first += kGroupPages) {
        const bool isPinned = _provider->ShouldStay(first) && sum + GroupBytes(first) <= limit &&
                              mostPages >= kGroupPages;
        sum += isPinned ? GroupBytes(first) : 0;
        mostPages -= isPinned ? kGroupPages : 0;
        for (std::uint32_t page = first; page < first + kGroupPages; ++page) {
            _table.SetPinned(page, isPinned);
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

/// The largest group must fit the largest buffer, beside the largest one that it may be reached
/// through, so that each round of requests can load both. \return their bytes.
std::uint64_t StreamingPool::CheckFits(std::uint64_t budgetBytes) {
    const std::uint64_t limit = std::min(budgetBytes, _bufferLimit);
    const std::uint32_t numOuter = _provider->NumOuterPages();
    std::uint64_t inner = PrepareLarge(numOuter, _provider->NumPages(), limit);
    const std::uint64_t outer = PrepareLarge(0, numOuter, limit - std::min(limit, inner));
    inner = PrepareLarge(numOuter, _provider->NumPages(), limit - std::min(limit, outer));
    if (inner + outer > limit) {
        throw Error("--" + _label + "Memory: " + std::to_string(limit) +
                    " bytes cannot hold the largest chunk, which takes " +
                    std::to_string(inner + outer) + " (--chunkSize makes chunks smaller)");
    }
    return inner + outer;
}

/// Prepares those groups of pages [begin, end) that are larger than `limit`, as far as is known.
/// \return the bytes of the largest one.
std::uint64_t StreamingPool::PrepareLarge(std::uint32_t begin, std::uint32_t end,
                                          std::uint64_t limit) {
    std::uint64_t largest = 0;
    for (std::uint32_t first = begin; first < end; first += kGroupPages) {
        if (GroupBytes(first) > limit && !_provider->IsExact(first)) {
            _provider->Prepare({first}); // one by one: few are so large
        }
        largest = std::max(largest, GroupBytes(first));
    }
    return largest;
}

/// Makes buffers of `bytes` in all, of which `pinnedBytes` are set apart; what was resident leaves.
void StreamingPool::AllocateBuffers(std::uint64_t bytes, std::uint64_t pinnedBytes) {
    for (Buffer& buffer : _buffers) {
        buffer = Buffer(); // frees first
    }
    _bytes = 0;
    for (std::uint32_t page = 0; page < _table.NumPages(); ++page) {
        _counters.CountEvictions(_table.HasPlace(page) ? 1 : 0);
    }
    std::vector<std::uint64_t> sizes;
    for (std::uint32_t i = 0; i < kMaxPoolBuffers; ++i) {
        const std::uint64_t size = std::min(_bufferLimit, bytes - _bytes);
        _buffers[i] =
            Buffer(_device, _label + " pool " + std::to_string(i), size, BufferAccess::ReadOnly);
        if (size > 0) {
            sizes.push_back(size);
            _bytes += size;
        }
    }
    _table.SetBuffers(sizes, pinnedBytes);
}

/// Whether kernels look pages up in a hash table, in a pool of so many bytes. Unless a setting says
/// otherwise it has entries for as many pages of the mean size as fit, and there is none where all
/// do.
void StreamingPool::ChooseHash(std::uint64_t bytes, std::uint64_t totalBytes) {
    const double part = double(bytes) / double(std::max<std::uint64_t>(totalBytes, 1));
    const auto fitting = static_cast<std::uint64_t>(part * _table.NumPages() * 8.0 / 7.0);
    const std::uint32_t entries =
        _hashEntries > 0 ? PageHash::RoundUp(_hashEntries)
                         : std::max(PageHash::EntriesOf(bytes), PageHash::RoundUp(fitting));
    const std::uint64_t least =
        _hashEntries > 0 ? entries : kLeastPagesPerEntry * std::uint64_t{entries};
    const bool isWanted = MayHash() && _provider->NumOuterPages() > 0 &&
                          _table.NumPages() > least && (_hashEntries > 0 || totalBytes > bytes);
    _hash = isWanted ? std::make_unique<PageHash>(entries) : nullptr;
}

void StreamingPool::MakeTables() {
    const std::uint64_t numWords = _hash ? _hash->Addresses().size() : _table.NumPages();
    const std::uint64_t numUses = _hash ? _hash->NumUseWords() : _table.NumPages();
    _addresses = Buffer(_device, _label + " residency table", numWords * sizeof(std::uint32_t),
                        BufferAccess::ReadOnly);
    _useTable =
        Buffer(_device, _label + " uses", kUseHeaderBytes + numUses * sizeof(std::uint32_t));
    const std::uint32_t epoch = _uses.Epoch();
    _useTable.Write(&epoch, sizeof(epoch), HDS_USE_EPOCH * sizeof(epoch));
    if (_hash) {
        const std::array<std::uint32_t, 2> asked = {_hash->AskedMask(), 0};
        _useTable.Write(asked.data(), sizeof(asked), HDS_USE_ASKED_MASK * sizeof(asked[0]));
    }
    WithdrawWay();
    _uses.Reset(_table.NumPages());
    PublishTable();
    PublishUses(); // by the places that the table gives
}

void StreamingPool::BeginEpoch() {
    _uses.BeginEpoch();
    const std::uint32_t epoch = _uses.Epoch();
    _useTable.Write(&epoch, sizeof(epoch), HDS_USE_EPOCH * sizeof(epoch));
}

void StreamingPool::ProcessRequests(const IsCancelled& isCancelled) {
    ProcessRound(true, isCancelled);
    BeginEpoch();
}

void StreamingPool::ProcessRound(bool withGroups, const IsCancelled& isCancelled) {
    const Timer timer;
    const StreamingStatistics before = Statistics();
    _order->BeginRound();
    _hasEvicted = false;
    ReadUses();
    _placedBytes = 0;
    if (_provider->NumOuterPages() > 0) {
        PlaceWay(TakeWay(), isCancelled);
    }
    PlaceInBatches(_uses.TakeRequests(_table, withGroups), withGroups, isCancelled);
    HDS_VERIFY(_placedBytes > 0, _label + ": nothing was loaded");
    if (_queued.empty()) {
        PublishTable(); // pages may have left for one that found no place
    }
    LoadQueued(); // the last batch
    PublishUses();
    const StreamingStatistics& after = _counters.Statistics();
    _counters.AddRequestSeconds(timer.Seconds() - (after.prepareSeconds - before.prepareSeconds) -
                                (after.transferSeconds - before.transferSeconds));
}

/// Places requests, the first ones first, until there is no more room; those that can fit are
/// prepared together. \param withGroups pages that hardly any ask for make none leave.
void StreamingPool::PlaceInBatches(const std::vector<PageRequest>& requests, bool withGroups,
                                   const IsCancelled& isCancelled) {
    std::size_t next = 0;
    bool isOver = false;
    while (next < requests.size() && !isOver) {
        LoadQueued(); // what is prepared next may take the place of what is prepared now
        if (_placedBytes > 0 && isCancelled && isCancelled()) {
            return;
        }
        const std::uint64_t room = std::min(_bytes - _placedBytes, kBatchBytes);
        std::vector<std::uint32_t> batch;
        std::uint64_t bytes = 0;
        const std::size_t first = next;
        for (; next < requests.size() && (batch.empty() || bytes < room); ++next) {
            const PageRequest& request = requests[next];
            const std::uint32_t begin = request.isGroup ? FirstOfGroup(request.page) : request.page;
            for (std::uint32_t i = 0; i < (request.isGroup ? kGroupPages : 1); ++i) {
                batch.push_back(begin + i);
                bytes += _pageBytes[begin + i];
            }
        }
        Prepare(batch, isCancelled);
        for (std::size_t i = first; i < next && !isOver; ++i) {
            const bool isHardlyWanted = requests[i].count < requests[0].count / kLeastWantedShare;
            isOver = (withGroups && _order->IsSelective() && _hasEvicted && isHardlyWanted) ||
                     !PlaceRequest(requests[i]);
        }
    }
}

/// No ray has offered its way.
void StreamingPool::WithdrawWay() {
    const std::uint32_t none = 0;
    _useTable.Write(&none, sizeof(none), HDS_USE_WAY * sizeof(none));
}

/// The pages that one of those who wait needs at once.
std::vector<std::uint32_t> StreamingPool::TakeWay() {
    std::array<std::uint32_t, 1 + HDS_WAY_PAGES> words{};
    _useTable.Read(words.data(), sizeof(words), HDS_USE_WAY * sizeof(words[0]));
    std::vector<std::uint32_t> pages;
    for (std::size_t i = 1; words[0] != 0 && i < words.size(); ++i) {
        if (words[i] != HDS_NONE && _pageBytes[words[i]] > 0) {
            pages.push_back(words[i]);
        }
    }
    WithdrawWay();
    return pages;
}

/// Places pages that are needed at once, so that whoever offered them goes on after this round.
/// Without it those that need them could take each other's pages for ever.
void StreamingPool::PlaceWay(const std::vector<std::uint32_t>& pages,
                             const IsCancelled& isCancelled) {
    std::vector<std::uint32_t> missing;
    for (const std::uint32_t page : pages) {
        if (_table.HasPlace(page)) {
            _order->Protect(page);
        } else {
            missing.push_back(page);
        }
    }
    Prepare(missing, isCancelled);
    bool isPlaced = true;
    for (const std::uint32_t page : missing) {
        isPlaced = isPlaced && Place(page);
    }
    if (!isPlaced) { // what is kept of them lies in the way of the rest
        for (const std::uint32_t page : _queued) {
            _placedBytes -= _table.Place(page).bytes;
            _table.Remove(page);
        }
        _queued.clear();
        RemoveAll();
        missing.clear();
        std::copy_if(pages.begin(), pages.end(), std::back_inserter(missing),
                     [this](std::uint32_t page) { return !_table.HasPlace(page); });
        Prepare(missing, isCancelled);
        for (const std::uint32_t page : missing) {
            isPlaced = Place(page);
            HDS_VERIFY(isPlaced, _label + ": no room for what a ray needs at once");
        }
    }
    for (const std::uint32_t page : missing) {
        _uses.Clear(page); // who asked for it has it
    }
    LoadQueued();
    _hasEvicted = false;
}

/// All that may leave does.
void StreamingPool::RemoveAll() {
    for (std::uint32_t page = 0; page < _table.NumPages(); ++page) {
        if (_table.MayLeave(page)) {
            Remove(page);
        }
    }
}

/// Makes the bytes of pages ready.
void StreamingPool::Prepare(const std::vector<std::uint32_t>& pages,
                            const IsCancelled& isCancelled) {
    const Timer timer;
    _provider->Prepare(pages, isCancelled);
    _counters.AddPrepareSeconds(timer.Seconds());
    for (const std::uint32_t page : pages) {
        _pageBytes[page] = _provider->PageBytes(page); // exact now
    }
}

/// \return false when there is no room left.
bool StreamingPool::PlaceRequest(const PageRequest& request) {
    const std::uint32_t first = FirstOfGroup(request.page);
    if (request.isGroup) {
        if (PlaceGroup(first, request.count)) {
            return true;
        }
        if (_placedBytes == 0) {
            // What was kept of the group lies in the way of the rest: begin with an empty pool.
            RemoveAll();
            PlaceGroup(first, request.count);
        }
        return false;
    }
    if (_table.HasPlace(request.page)) {
        _order->Protect(request.page); // came with its group
        return true;
    }
    if (!Place(request.page)) {
        return false;
    }
    _order->SetWanted(request.page, request.count);
    return true;
}

/// Places what is missing of the group that begins with page `first`. \return false, with nothing
/// placed, when there is no room for all of it.
bool StreamingPool::PlaceGroup(std::uint32_t first, std::uint32_t wanted) {
    std::array<bool, kGroupPages> isNeeded{};
    for (std::uint32_t i = 0; i < kGroupPages; ++i) {
        // Before anything leaves for the others.
        isNeeded[i] = !_table.HasPlace(first + i) && _pageBytes[first + i] > 0;
        if (_table.HasPlace(first + i)) {
            _order->Protect(first + i);
        }
    }
    const std::size_t numQueued = _queued.size();
    for (std::uint32_t i = 0; i < kGroupPages; ++i) {
        if (!isNeeded[i]) {
            continue;
        }
        if (!Place(first + i)) {
            for (; _queued.size() > numQueued; _queued.pop_back()) {
                _placedBytes -= _table.Place(_queued.back()).bytes;
                _table.Remove(_queued.back());
            }
            return false;
        }
        _order->SetWanted(first + i, wanted);
    }
    _counters.CountGroupLoads(_queued.size() - numQueued);
    return true;
}

/// Finds room for a page, evicting others, and queues it. \return false when all that could leave
/// has left.
bool StreamingPool::Place(std::uint32_t page) {
    while (!HasEntry() || !_table.FindPlace(page, _pageBytes[page])) {
        if (!Evict()) {
            return false;
        }
    }
    _order->Protect(page);
    _placedBytes += _table.Place(page).bytes;
    _queued.push_back(page);
    return true;
}

/// Makes pages leave. \return false when none may.
bool StreamingPool::Evict() {
    _hasEvicted = true;
    const bool isAny = _order->Next(_table, _uses, &_leaving);
    for (const std::uint32_t page : _leaving) {
        Remove(page);
    }
    return isAny;
}

/// \pre the page has a place.
void StreamingPool::Remove(std::uint32_t page) {
    if (_uses.WasUsed(page)) {
        _counters.CountUse(page); // its stamp goes
    }
    _table.Remove(page);
    _uses.Clear(page);
    _counters.CountEvictions(1);
}

/// \param isAskedFor by kernels.
void StreamingPool::LoadQueued(bool isAskedFor) {
    if (_queued.empty()) {
        return;
    }
    const Timer timer;
    std::array<std::vector<BufferCopy>, kMaxPoolBuffers> copies;
    for (const std::uint32_t page : _queued) {
        const PoolRange& range = _table.Place(page);
        copies[range.buffer].push_back({_provider->Page(page), range.bytes, range.offset});
        _table.Publish(page);
        _counters.CountLoad(page, range.bytes, isAskedFor);
    }
    _counters.SetHeld(_table.PlacedBytes());
    for (std::uint32_t buffer = 0; buffer < NumBuffers(); ++buffer) {
        _buffers[buffer].WriteMany(copies[buffer]);
    }
    _queued.clear();
    PublishTable(); // only now: words are read by whatever is launched next
    _counters.AddTransferSeconds(timer.Seconds());
}

void StreamingPool::PublishTable() {
    if (_hash) {
        _hash->Enter(_table.Words());
    }
    WriteWords(_hash ? _hash->Addresses() : _table.Words());
}

void StreamingPool::WriteWords(const std::vector<std::uint32_t>& words) {
    _addresses.Write(words.data(), words.size() * sizeof(std::uint32_t));
}

void StreamingPool::ReadUses() {
    if (!_hash) {
        std::vector<std::uint32_t>& words = _uses.Words();
        _useTable.Read(words.data(), words.size() * sizeof(std::uint32_t), kUseHeaderBytes);
        return;
    }
    std::vector<std::uint32_t> words(_hash->NumUseWords());
    _useTable.Read(words.data(), words.size() * sizeof(std::uint32_t), kUseHeaderBytes);
    _hash->Read(words, &_uses.Words());
    std::uint32_t dropped = 0;
    _useTable.Read(&dropped, sizeof(dropped), HDS_USE_DROPPED * sizeof(dropped));
    if (dropped > 0) {
        _counters.CountDropped(dropped);
        dropped = 0;
        _useTable.Write(&dropped, sizeof(dropped), HDS_USE_DROPPED * sizeof(dropped));
    }
}

void StreamingPool::PublishUses() {
    const std::vector<std::uint32_t>& uses = _uses.Words();
    const std::vector<std::uint32_t> hashed =
        _hash ? _hash->Write(uses) : std::vector<std::uint32_t>();
    const std::vector<std::uint32_t>& words = _hash ? hashed : uses;
    _useTable.Write(words.data(), words.size() * sizeof(std::uint32_t), kUseHeaderBytes);
}

} // namespace hds
