// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/texturePool.h"

#include "hdStream/base/error.h"
#include "hdStream/base/timer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <utility>

namespace hds {

namespace {

constexpr std::uint64_t kWord = sizeof(std::uint32_t);
/// Most lines uploaded at a time: 1 MiB.
constexpr std::uint32_t kStagedLines = 2048;
/// Most words of the table changed at a time.
constexpr std::uint32_t kMaxUpdates = 4 * kStagedLines;
/// The table's buffer has room for so many more pages before it must grow.
constexpr std::uint64_t kSparePages = 64;
/// Most lines of one repeated block that are kept for all who have the same.
constexpr std::uint32_t kMaxShared = 64;
/// A repeated block: no line has larger ones (16 texels of four floats at 1:2).
constexpr std::size_t kBlockBytes = 128;
/// Stands for all lines that share a slot.
constexpr std::uint32_t kSharedLine = HDS_REQUEST_TEXTURE;
/// Numbers of lines of textures that have gone are given up as long as they are fewer than these.
constexpr std::uint32_t kGoneLines = 1U << 20U;

bool IsRepeated(const std::uint8_t* line) {
    return std::memcmp(line, line + kBlockBytes, HDS_LINE_BYTES - kBlockBytes) == 0;
}

std::uint32_t PowerOfTwo(std::uint32_t least) {
    std::uint32_t power = 1;
    while (power < least) {
        power *= 2;
    }
    return power;
}

} // namespace

TexturePool::TexturePool(std::shared_ptr<Device> device, Store* store,
                         std::uint32_t requestCapacity)
    : _device(std::move(device)), _store(store), _requestCapacity(requestCapacity) {
    Program::Announce(*_device, {KernelSource(*_device)}, store);
}

ProgramSource TexturePool::KernelSource(const Device& device) {
    return MakeProgramSource(device.Properties(), "texture/cacheFill.cl", {});
}

/// Kernels are built when the first one is launched: they may be compiled elsewhere until then.
void TexturePool::ReadyKernels() {
    if (!_program) {
        _program = std::make_unique<Program>(_device, KernelSource(*_device), _store);
        _copyLines = _program->GetKernel("fill_copyLines");
        _updateTable = _program->GetKernel("fill_updateTable");
        _program->SaveBinary(_store); // it is small
    }
}

/// Slots of one part of a pool. \param maxLines that it can ever have to hold. \param[out]
/// keepsStamps set where these do not all find room.
SlotPlan TexturePool::PlanPart(const Part& part, std::uint64_t maxSlots, bool* keepsStamps) {
    const std::uint64_t limit = std::min(part.budgetBytes / HDS_LINE_BYTES, maxSlots);
    const std::uint64_t fewest = FewestSlots(part.linesPerItem);
    if (limit < fewest) {
        throw Error(part.option + ": " + std::to_string(part.budgetBytes) +
                    " bytes cannot hold the " + std::to_string(part.linesPerItem) + " " +
                    part.lines + "; that takes " + std::to_string(fewest * HDS_LINE_BYTES) +
                    " bytes");
    }
    const std::uint32_t numPinned = PowerOfTwo(part.numTextures + kMaxShared);
    const std::uint64_t enough = part.maxLines == LineProvider::kUnknown
                                     ? limit + 1
                                     : EnoughSlots(part.maxLines, part.linesPerItem, numPinned);
    *keepsStamps = *keepsStamps || enough > limit;
    return MakeSlotPlan(static_cast<std::uint32_t>(std::min(limit, enough)), part.linesPerItem,
                        numPinned);
}

TexturePool::PoolPlan TexturePool::Plan(std::uint64_t budgetBytes, std::uint32_t linesPerItem,
                                        const GridBudget& grids) const {
    const std::uint32_t numTextures = _provider->NumTextures();
    const std::uint32_t numGrids = numTextures - _provider->FirstGrid();
    const bool areApart = grids.bytes > 0 && numGrids > 0;
    Part rest{"--textureMemory",
              "texture lines that one surface point can need",
              budgetBytes,
              numTextures,
              linesPerItem + grids.linesPerItem,
              _provider->MaxLines()};
    PoolPlan plan;
    if (areApart) {
        rest.numTextures -= numGrids;
        rest.linesPerItem = linesPerItem;
        rest.maxLines -= rest.maxLines == LineProvider::kUnknown ? 0 : _provider->GridLines();
    }
    if (rest.numTextures > 0) {
        plan.lines = PlanPart(rest, LineBuffers::MaxSlots(*_device), &plan.keepsStamps);
    }
    if (areApart) {
        const std::uint64_t left = LineBuffers::MaxSlots(*_device) - plan.lines.NumSlots();
        plan.grids = PlanPart({"--volumeMemory", "lines of volumes that one collision can need",
                               grids.bytes, numGrids, grids.linesPerItem, _provider->GridLines()},
                              left, &plan.keepsStamps);
    }
    return plan;
}

void TexturePool::Update(LineProvider* provider, std::uint64_t budgetBytes,
                         std::uint32_t linesPerItem, GridBudget grids) {
    _provider = provider;
    const PoolPlan plan = Plan(budgetBytes, linesPerItem, grids);
    _linesPerItem = linesPerItem + grids.linesPerItem;
    const std::vector<LineRange> gone = _textures.Update(*provider);
    if (_textures.NumLines() > 2 * std::uint64_t{_textures.NumLiveLines()} + kGoneLines) {
        _textures = {}; // numbers begin anew
        _textures.Update(*provider);
        _table = {};
        MakePool(plan);
    } else if (!_slots || !(_plan == plan)) {
        MakePool(plan);
    } else {
        RemoveLines(gone);
    }
    _provider->Open(_textures.Open(), false, {});
    HDS_VERIFY(Bytes() <= budgetBytes + grids.bytes, "texture pool larger than its budget");
    // Requests and items of a render that was stopped mean something else now.
    MakeRequests();
    ReserveItems(0);
    _records = Buffer(); // frees first
    _records = UploadVector(_device, "textures", _textures.Records());
    PublishTable();
    ++_generation;
}

/// Makes an empty pool.
void TexturePool::MakePool(const PoolPlan& plan) {
    ForEachPart([&](const LineSlots& part) {
        _statistics.evictions += part.NumUsed();
        _statistics.grids.evictions += &part == _gridSlots.get() ? part.NumUsed() : 0;
    });
    _stampView.reset(); // a round that failed has left it
    _slots = nullptr;   // until all is there: memory may run out
    _gridSlots = nullptr;
    _sharedSlots.clear();
    _table.Clear();
    _table.Reserve(std::max(1U, _textures.NumLines()));
    const std::uint32_t numSlots = plan.lines.NumSlots() + plan.grids.NumSlots();
    if (!_buffers || _buffers->NumSlots() != numSlots) {
        _buffers = nullptr; // frees first
        _buffers = std::make_unique<LineBuffers>(_device, numSlots);
    }
    const std::uint32_t numStaged = std::min(numSlots, kStagedLines);
    _stagedBytes.resize(std::size_t{numStaged} * HDS_LINE_BYTES);
    for (Buffer* buffer : {&_stamps, &_staging, &_copies, &_updates}) {
        *buffer = Buffer(); // frees first
    }
    _plan = plan;
    const std::uint64_t stampBytes = plan.keepsStamps ? numSlots * kWord : 0;
    _stamps = Buffer(_device, "texture use stamps", stampBytes);
    _stamps.Fill(0, stampBytes);
    _staging = Buffer(_device, "texture lines on their way", _stagedBytes.size());
    _copies = Buffer(_device, "texture line copies", numStaged * sizeof(shared::HdsLineCopy));
    _updates =
        Buffer(_device, "texture table updates", kMaxUpdates * sizeof(shared::HdsTableUpdate));
    _slots = std::make_unique<LineSlots>(plan.lines);
    if (plan.grids.NumSlots() > 0) {
        _gridSlots = std::make_unique<LineSlots>(plan.grids, plan.lines.NumSlots());
    }
}

/// Calls `action` for each part of the pool.
void TexturePool::ForEachPart(const std::function<void(const LineSlots&)>& action) const {
    for (const LineSlots* part : {_slots.get(), _gridSlots.get()}) {
        if (part != nullptr) {
            action(*part);
        }
    }
}

std::uint32_t TexturePool::NumSlots() const {
    return _plan.lines.NumSlots() + _plan.grids.NumSlots();
}

/// Takes lines of textures that have gone out of their slots.
void TexturePool::RemoveLines(const std::vector<LineRange>& ranges) {
    if (ranges.empty()) {
        return;
    }
    for (std::uint32_t slot = 0; slot < NumSlots(); ++slot) {
        LineSlots* part = slot < _plan.lines.NumSlots() ? _slots.get() : _gridSlots.get();
        const std::uint32_t line = part->Line(slot);
        const auto range = std::upper_bound(ranges.begin(), ranges.end(), line,
                                            [](std::uint32_t value, const LineRange& candidate) {
                                                return value < candidate.first;
                                            });
        if (line < kSharedLine && range != ranges.begin() && line < (range - 1)->second) {
            part->Free(slot);
            _table.Set(line, HDS_NONE);
        }
    }
}

void TexturePool::MakeRequests() {
    const std::uint32_t capacity = std::min(_requestCapacity, PowerOfTwo(NumSlots()));
    const std::uint32_t setSize = 2 * PowerOfTwo(capacity);
    const std::uint32_t setBegin = HDS_TEXELS_HEADER + capacity;
    _requests = Buffer(); // frees first
    _requests = Buffer(_device, "texture requests", (setBegin + setSize) * kWord);
    std::array<std::uint32_t, HDS_TEXELS_HEADER> header{};
    header[HDS_TEXELS_EPOCH] = Epoch();
    header[HDS_TEXELS_ACCEPT_COARSER_MIPS] = _acceptsCoarserMips ? 1 : 0;
    header[HDS_TEXELS_CAPACITY] = capacity;
    header[HDS_TEXELS_SET_BEGIN] = setBegin;
    header[HDS_TEXELS_SET_MASK] = setSize - 1;
    _requests.Write(header.data(), sizeof(header));
    _requests.Fill(HDS_NONE, setSize * kWord, setBegin * kWord);
    _setBegin = setBegin;
    _maxSetSize = setSize;
    _setSize = setSize;
}

void TexturePool::BeginStatistics() {
    _statistics = {};
    _table.ForgetPast();
    for (LineSlots* part : {_slots.get(), _gridSlots.get()}) {
        if (part != nullptr) {
            part->BeginMost();
        }
    }
}

void TexturePool::ReserveItems(std::uint32_t numItems) {
    const std::uint64_t bytes = (1 + std::uint64_t{numItems}) * kWord;
    if (_waiting.Bytes() < bytes) {
        _waiting = Buffer(); // frees first
        _waiting = Buffer(_device, "items that wait for texels", bytes);
        ++_generation;
    }
    _waiting.Fill(0, kWord);
    ExpectAnyItems();   // a render that failed has left it
    _stampView.reset(); // and this
}

/// How much of the set kernels use. \pre it does not shrink, or nothing is asked for. What is asked
/// for when it grows may be listed once more.
void TexturePool::SetSetSize(std::uint32_t numWords) {
    if (numWords != _setSize) {
        _setSize = numWords;
        const std::uint32_t mask = numWords - 1;
        _requests.Write(&mask, kWord, HDS_TEXELS_SET_MASK * kWord);
    }
}

std::vector<std::uint32_t> TexturePool::TakeWaiting() {
    std::uint32_t count = 0;
    _waiting.Read(&count, kWord);
    std::vector<std::uint32_t> items(count);
    if (count > 0) {
        _waiting.Read(items.data(), items.size() * kWord, kWord);
        _waiting.Fill(0, kWord);
        std::sort(items.begin(), items.end());
    }
    return items;
}

void TexturePool::SetAcceptsCoarserMips(bool accepts) {
    if (accepts != _acceptsCoarserMips) {
        _acceptsCoarserMips = accepts;
        const std::uint32_t word = accepts ? 1 : 0;
        _requests.Write(&word, kWord, HDS_TEXELS_ACCEPT_COARSER_MIPS * kWord);
    }
}

/// Adds the counters to the statistics and clears them. \return the number of requests.
std::uint32_t TexturePool::TakeCounts() {
    std::array<std::uint32_t, HDS_TEXELS_HEADER> header{};
    _requests.Read(header.data(), sizeof(header));
    _statistics.droppedRequests += header[HDS_TEXELS_NUM_DROPPED];
    _statistics.fallbackTexels += header[HDS_TEXELS_NUM_FALLBACKS];
    for (std::uint32_t i = 0; i < HDS_TEXELS_COUNTERS; ++i) {
        _statistics.lookups += header[HDS_TEXELS_LOOKUPS + i];
        _statistics.misses += header[HDS_TEXELS_MISSES + i];
    }
    _requests.Fill(0, (HDS_TEXELS_HEADER - HDS_TEXELS_NUM_DROPPED) * kWord,
                   HDS_TEXELS_NUM_DROPPED * kWord);
    return std::min(header[HDS_TEXELS_NUM_REQUESTS], header[HDS_TEXELS_CAPACITY]);
}

void TexturePool::CollectCounts() {
    TakeCounts();
}

/// What kernels have asked for, in order; clears the requests and begins an epoch.
std::vector<std::uint32_t> TexturePool::TakeRequests() {
    std::vector<std::uint32_t> requests(TakeCounts());
    _requests.Read(requests.data(), requests.size() * kWord, HDS_TEXELS_HEADER * kWord);
    if (!requests.empty()) {
        _requests.Fill(HDS_NONE, _setSize * kWord, _setBegin * kWord);
        _requests.Fill(0, kWord, HDS_TEXELS_NUM_REQUESTS * kWord);
    }
    std::sort(requests.begin(), requests.end());
    requests.erase(std::unique(requests.begin(), requests.end()), requests.end());
    return requests;
}

TexturePool::Outcome TexturePool::ProcessRequests(std::uint32_t numItems,
                                                  const LineProvider::IsCancelled& isCancelled) {
    const Timer timer;
    const double before = _statistics.openSeconds + _statistics.readSeconds;
    Outcome outcome;
    const std::vector<std::uint32_t> requests = TakeRequests();
    // Half empty, as the largest one.
    const std::uint64_t words = 2 * std::uint64_t{numItems} * _linesPerItem;
    SetSetSize(words < _maxSetSize ? PowerOfTwo(static_cast<std::uint32_t>(words)) : _maxSetSize);
    const auto firstTexture =
        std::lower_bound(requests.begin(), requests.end(), HDS_REQUEST_TEXTURE);
    std::vector<std::uint32_t> textures;
    std::transform(firstTexture, requests.end(), std::back_inserter(textures),
                   [](std::uint32_t request) { return request & ~HDS_REQUEST_TEXTURE; });
    std::vector<Load> loads;
    outcome.isCancelled = !OpenAll(textures, &loads, isCancelled);
    if (!outcome.isCancelled) {
        outcome.numLoaded = static_cast<std::uint32_t>(textures.size());
        std::transform(requests.begin(), firstTexture, std::back_inserter(loads),
                       [](std::uint32_t line) {
                           return Load{line, false};
                       });
        LoadAll(loads, &outcome, isCancelled);
    }
    _stampView.reset();
    _epoch = std::max(1U, _epoch + 1);
    const std::uint32_t epoch = Epoch();
    _requests.Write(&epoch, kWord, HDS_TEXELS_EPOCH * kWord);
    ++_statistics.requestRounds;
    _statistics.requestSeconds +=
        timer.Seconds() - (_statistics.openSeconds + _statistics.readSeconds - before);
    return outcome;
}

/// Opens textures. \param[out] loads gets the line with the coarsest mips of each. \return false
/// when it was cancelled: none counts as opened.
bool TexturePool::OpenAll(const std::vector<std::uint32_t>& textures, std::vector<Load>* loads,
                          const LineProvider::IsCancelled& isCancelled) {
    if (textures.empty()) {
        return true;
    }
    const Timer timer;
    const bool areOpen = _provider->Open(textures, false, isCancelled);
    _statistics.openSeconds += timer.Seconds();
    if (!areOpen) {
        return false;
    }
    for (const std::uint32_t texture : textures) {
        _textures.Add(*_provider, texture);
        const shared::HdsTexture& record = _textures.Records()[texture];
        loads->push_back({record.firstLine + record.numLines - 1, true});
        _records.Write(&record, sizeof(record), texture * sizeof(record));
    }
    _table.Reserve(_textures.NumLines());
    _statistics.openedTextures += textures.size();
    return true;
}

/// Coarsest mips come first, and are loaded whatever is asked: each texture that is open has its
/// own.
void TexturePool::LoadAll(const std::vector<Load>& loads, Outcome* outcome,
                          const LineProvider::IsCancelled& isCancelled) {
    const std::size_t batch = _stagedBytes.size() / HDS_LINE_BYTES;
    const auto firstOther =
        std::find_if(loads.begin(), loads.end(), [](const Load& load) { return !load.isPinned; });
    const auto numPinned = static_cast<std::size_t>(firstOther - loads.begin());
    std::size_t end = 0;
    for (std::size_t begin = 0; begin < loads.size() && !outcome->isCancelled; begin = end) {
        const bool arePinned = begin < numPinned;
        if (begin > 0 && !arePinned && isCancelled && isCancelled()) {
            outcome->isCancelled = true;
            break;
        }
        end = std::min(arePinned ? numPinned : loads.size(), begin + batch);
        LoadBatch({loads.begin() + static_cast<std::ptrdiff_t>(begin),
                   loads.begin() + static_cast<std::ptrdiff_t>(end)},
                  outcome, arePinned ? LineProvider::IsCancelled() : isCancelled);
    }
    PublishTable(); // also when textures were opened and none of their lines found room
}

void TexturePool::LoadBatch(const std::vector<Load>& loads, Outcome* outcome,
                            const LineProvider::IsCancelled& isCancelled) {
    std::vector<LineId> lines;
    for (const Load& load : loads) {
        lines.push_back(_textures.Find(load.line));
    }
    const Timer timer;
    outcome->isCancelled = !_provider->Read(lines, _stagedBytes.data(), isCancelled);
    _statistics.readSeconds += timer.Seconds();
    if (outcome->isCancelled) {
        return;
    }
    std::vector<shared::HdsLineCopy> copies;
    for (std::size_t i = 0; i < loads.size(); ++i) {
        std::uint8_t* bytes = _stagedBytes.data() + i * HDS_LINE_BYTES;
        bool needsCopy = true;
        const bool isOfGrid = IsOfGrid(lines[i]);
        const std::uint32_t slot = PlaceLine(loads[i], isOfGrid, bytes, &needsCopy);
        if (slot == HDS_NONE) {
            ++outcome->numDenied;
            continue;
        }
        ++outcome->numLoaded;
        if (needsCopy) {
            std::memmove(_stagedBytes.data() + copies.size() * HDS_LINE_BYTES, bytes,
                         HDS_LINE_BYTES);
            copies.push_back({static_cast<std::uint32_t>(copies.size()), slot});
        }
        LineTraffic loaded;
        loaded.uploadedBytes = needsCopy ? HDS_LINE_BYTES : 0;
        if (!_table.Set(loads[i].line, slot)) {
            loaded.linesLoaded = 1;
            loaded.uniqueBytesLoaded = loaded.uploadedBytes;
        }
        _statistics.Count(loaded, isOfGrid);
    }
    CopyStaged(std::move(copies));
    PublishTable(); // only now: words are read by whatever is launched next
}

/// \param[out] needsCopy false: the slot has these bytes. \return the slot, or HDS_NONE.
std::uint32_t TexturePool::PlaceLine(const Load& load, bool isOfGrid, const std::uint8_t* bytes,
                                     bool* needsCopy) {
    LineSlots* part = isOfGrid && _gridSlots ? _gridSlots.get() : _slots.get();
    if (IsRepeated(bytes)) {
        const std::string block(reinterpret_cast<const char*>(bytes), kBlockBytes);
        const auto known = _sharedSlots.find(block);
        if (known != _sharedSlots.end()) {
            *needsCopy = false;
            return known->second;
        }
        if (_sharedSlots.size() < kMaxShared) {
            const std::uint32_t slot = part->PlacePinned(kSharedLine);
            if (slot != HDS_NONE) {
                _sharedSlots.emplace(block, slot);
                return slot;
            }
        }
    }
    if (load.isPinned) {
        const std::uint32_t slot = part->PlacePinned(load.line);
        if (slot != HDS_NONE) {
            return slot;
        }
    }
    const LineSlots::Placement placement =
        part->Place(load.line, _epoch, [this] { return ReadStamps(); });
    _statistics.setConflicts += placement.isConflict ? 1 : 0;
    if (placement.slot != HDS_NONE && placement.evicted != HDS_NONE) {
        _table.Set(placement.evicted, HDS_NONE);
        LineTraffic gone;
        gone.evictions = 1;
        _statistics.Count(gone, IsOfGrid(_textures.Find(placement.evicted)));
    }
    return placement.slot;
}

/// In place where the device's memory is the host's: most rounds load few lines, and a large pool
/// has millions of stamps.
const std::uint32_t* TexturePool::ReadStamps() {
    HDS_VERIFY(_plan.keepsStamps, "a line has to leave a texture pool that has room for all");
    if (!_stampView) {
        _stampView.emplace(_stamps);
    }
    return reinterpret_cast<const std::uint32_t*>(_stampView->Data());
}

/// Sends staged lines [0, copies.size()) to their slots.
void TexturePool::CopyStaged(std::vector<shared::HdsLineCopy> copies) {
    if (copies.empty()) {
        return;
    }
    const std::uint64_t bytes = copies.size() * HDS_LINE_BYTES;
    ReadyKernels();
    _staging.Write(_stagedBytes.data(), bytes);
    std::sort(copies.begin(), copies.end(),
              [](const auto& a, const auto& b) { return a.slot < b.slot; });
    _copies.Write(copies.data(), copies.size() * sizeof(copies[0]));
    std::uint32_t first = 0;
    while (first < copies.size()) {
        const std::uint32_t buffer = copies[first].slot >> HDS_SLOT_BUFFER_SHIFT;
        const auto end = std::find_if(copies.begin() + first, copies.end(), [&](const auto& copy) {
            return copy.slot >> HDS_SLOT_BUFFER_SHIFT != buffer;
        });
        const auto count = static_cast<std::uint32_t>(end - copies.begin()) - first;
        _copyLines.Launch(std::size_t{count} * (HDS_LINE_BYTES / 16), _staging, _copies, first,
                          count, buffer << HDS_SLOT_BUFFER_SHIFT, _buffers->At(buffer));
        first += count;
    }
}

void TexturePool::PublishTable() {
    bool isMoved = false;
    const std::vector<shared::HdsTableUpdate> updates = _table.TakeUpdates(&isMoved);
    const std::vector<std::uint32_t>& words = _table.Words();
    const std::uint64_t bytes = words.size() * kWord;
    if (!_lineTable.IsValid() || _lineTable.Bytes() < bytes) {
        _lineTable = Buffer(); // frees first
        const std::uint64_t numWords =
            words.size() + words.size() / 2 + kSparePages * HDS_LINE_PAGE_WORDS;
        _lineTable = Buffer(_device, "texture line table", numWords * kWord);
        isMoved = true;
        ++_generation;
    }
    if (isMoved) {
        _lineTable.Write(words.data(), bytes);
        _lineTable.Fill(HDS_NONE, _lineTable.Bytes() - bytes, bytes);
        return;
    }
    if (!updates.empty()) {
        ReadyKernels();
    }
    for (std::size_t begin = 0; begin < updates.size(); begin += kMaxUpdates) {
        const auto count =
            static_cast<std::uint32_t>(std::min<std::size_t>(kMaxUpdates, updates.size() - begin));
        _updates.Write(&updates[begin], count * sizeof(updates[0]));
        _updateTable.Launch(count, _updates, count, _lineTable);
    }
}

TextureBinding TexturePool::Binding() const {
    TextureBinding binding;
    binding.textures = &_records;
    binding.lineTable = &_lineTable;
    _buffers->FillBinding(&binding);
    binding.requests = &_requests;
    binding.stamps = &_stamps;
    binding.waiting = &_waiting;
    return binding;
}

std::uint64_t TexturePool::TableBytes() const {
    std::uint64_t bytes = _buffers ? _buffers->UnusedBytes() : 0;
    for (const Buffer* buffer : {&_records, &_lineTable, &_requests, &_stamps, &_waiting, &_staging,
                                 &_copies, &_updates}) {
        bytes += buffer->Bytes();
    }
    return bytes;
}

std::uint64_t TexturePool::PeakUsedBytes() const {
    std::uint64_t most = 0;
    ForEachPart([&](const LineSlots& part) { most += part.MostUsed(); });
    return most * HDS_LINE_BYTES;
}

std::uint64_t TexturePool::GridPeakUsedBytes() const {
    return _gridSlots ? std::uint64_t{_gridSlots->MostUsed()} * HDS_LINE_BYTES : 0;
}

std::uint64_t TexturePool::PinnedBytes() const {
    std::uint64_t pinned = 0;
    ForEachPart([&](const LineSlots& part) { pinned += part.NumPinned(); });
    return pinned * HDS_LINE_BYTES;
}

} // namespace hds
