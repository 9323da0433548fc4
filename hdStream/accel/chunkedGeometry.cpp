// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/chunkedGeometry.h"

#include "hdStream/accel/bvh.h"
#include "hdStream/base/error.h"
#include "hdStream/base/hash.h"
#include "hdStream/geometry/attributePage.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

namespace hds {

namespace {

/// Changes whenever the same geometry gives other pages or another plan: part of the keys in the
/// store.
constexpr std::uint64_t kPageFormat = 7;
/// The part of geometry that is its summary; pages count from 0.
constexpr std::uint64_t kSummaryPart = ~std::uint64_t{0};
/// Making a source and its plan takes about this part of making all its pages (docs/accel.md).
constexpr std::uint32_t kFirstAheadDivisor = 8;
/// Bytes of a page that do not grow with its triangles: header and root; slot word and padding.
constexpr std::uint64_t kFixedBytes = 128;

std::uint64_t RoundUp(std::uint64_t bytes) {
    return (bytes + HDS_POOL_UNIT_BYTES - 1) / HDS_POOL_UNIT_BYTES * HDS_POOL_UNIT_BYTES;
}

class Writer {
public:
    template <typename T>
    void Add(const T& value) {
        static_assert(std::is_standard_layout_v<T> && std::is_trivially_destructible_v<T>);
        Append(&value, sizeof(T));
    }
    template <typename T>
    void AddArray(const std::vector<T>& values) {
        Add(std::uint64_t{values.size()});
        Append(values.data(), values.size() * sizeof(T));
    }
    void AddText(const std::string& text) {
        Add(std::uint64_t{text.size()});
        Append(text.data(), text.size());
    }
    std::vector<std::uint8_t> bytes;

private:
    void Append(const void* data, std::size_t count) {
        const auto* first = static_cast<const std::uint8_t*>(data);
        bytes.insert(bytes.end(), first, first + count);
    }
};

/// Reads what Writer wrote; past the end everything is empty and `isGood` false.
class Reader {
public:
    explicit Reader(const std::vector<std::uint8_t>& bytes) : _bytes(bytes) {}

    template <typename T>
    void Get(T* value) {
        static_assert(!std::is_same_v<T, bool>, "not every byte is one");
        Copy(value, sizeof(T));
    }
    template <typename T>
    void GetArray(std::vector<T>* values) {
        values->resize(GetCount(sizeof(T)));
        Copy(values->data(), values->size() * sizeof(T));
    }
    void GetText(std::string* text) {
        text->resize(GetCount(1));
        Copy(text->data(), text->size());
    }
    /// Of elements that take at least so many bytes each.
    std::size_t GetCount(std::size_t bytesEach) {
        std::uint64_t count = 0;
        Get(&count);
        isGood = isGood && count <= (_bytes.size() - _next) / bytesEach;
        return isGood ? static_cast<std::size_t>(count) : 0;
    }
    bool IsAtEnd() const { return isGood && _next == _bytes.size(); }

    bool isGood = true;

private:
    void Copy(void* data, std::size_t count) {
        isGood = isGood && count <= _bytes.size() - _next;
        if (isGood && count > 0) {
            std::memcpy(data, _bytes.data() + _next, count);
            _next += count;
        }
    }

    const std::vector<std::uint8_t>& _bytes;
    std::size_t _next = 0;
};

} // namespace

std::vector<std::uint8_t> SerializeSummary(const GeometrySummary& summary) {
    Writer writer;
    writer.Add(summary.origin);
    writer.Add(std::uint8_t{summary.isLeftHanded});
    writer.Add(summary.numTriangles);
    writer.Add(summary.boundBytes);
    writer.Add(std::uint64_t{summary.attributes.size()});
    for (const AttributeFormat& attribute : summary.attributes) {
        writer.AddText(attribute.name);
        writer.Add(attribute.numComponents);
    }
    writer.AddArray(summary.chunkBounds);
    writer.AddArray(summary.numInChunk);
    return std::move(writer.bytes);
}

std::optional<GeometrySummary> ParseSummary(const std::vector<std::uint8_t>& bytes) {
    Reader reader(bytes);
    GeometrySummary summary;
    reader.Get(&summary.origin);
    std::uint8_t isLeftHanded = 0;
    reader.Get(&isLeftHanded);
    summary.isLeftHanded = isLeftHanded == 1;
    reader.Get(&summary.numTriangles);
    reader.Get(&summary.boundBytes);
    summary.attributes.resize(reader.GetCount(sizeof(std::uint64_t)));
    for (AttributeFormat& attribute : summary.attributes) {
        reader.GetText(&attribute.name);
        reader.Get(&attribute.numComponents);
    }
    reader.GetArray(&summary.chunkBounds);
    reader.GetArray(&summary.numInChunk);
    if (!reader.IsAtEnd() || isLeftHanded > 1 || summary.numInChunk.size() != summary.NumChunks()) {
        return std::nullopt;
    }
    return summary;
}

ChunkedGeometry::ChunkedGeometry(SourceMaker makeSource, std::uint64_t chunkBytes,
                                 std::shared_ptr<PageStore> store, const PageKey& key,
                                 std::shared_ptr<SourceKeeper> keeper, std::uint64_t arrayBytes)
    : _makeSource(std::move(makeSource)), _chunkBytes(chunkBytes), _store(std::move(store)),
      _key(key), _keeper(std::move(keeper)), _arrayBytes(arrayBytes) {
    if (!LoadSummary()) {
        MakeSummary(*Hold());
    }
}

ChunkedGeometry::~ChunkedGeometry() {
    if (_keeper) {
        _keeper->Forget(this);
    }
}

bool ChunkedGeometry::LoadSummary() {
    std::vector<std::uint8_t> bytes;
    if (!_store || !_store->Load(PartKey(kSummaryPart), &bytes)) {
        return false;
    }
    std::optional<GeometrySummary> summary = ParseSummary(bytes);
    if (!summary) {
        return false;
    }
    _summary = std::move(*summary);
    return true;
}

void ChunkedGeometry::SaveSummary() const {
    const PageKey key = PartKey(kSummaryPart);
    if (_store && !_store->Contains(key)) {
        const std::vector<std::uint8_t> bytes = SerializeSummary(_summary);
        _store->Save(key, bytes.data(), bytes.size());
    }
}

void ChunkedGeometry::MakeSummary(const Cut& cut) {
    _summary.origin = cut.source->Origin();
    _summary.isLeftHanded = cut.source->IsLeftHanded();
    _summary.numTriangles = cut.source->NumTriangles();
    _summary.attributes = cut.source->Attributes();
    _summary.boundBytes = cut.source->BoundBytes();
    _summary.chunkBounds = cut.plan.bounds;
    _summary.numInChunk = cut.plan.counts;
}

std::shared_ptr<const ChunkedGeometry::Cut> ChunkedGeometry::MakeCut() const {
    auto cut = std::make_shared<Cut>();
    // A thread that took another task meanwhile might come here again and wait for itself.
    tbb::this_task_arena::isolate([&] {
        cut->source = _makeSource();
        if (cut->source->NumTriangles() == 0) {
            return;
        }
        const std::uint64_t maxTriangles =
            std::clamp<std::uint64_t>(_chunkBytes / cut->source->MeanBytes().Both(), 1,
                                      std::numeric_limits<std::uint32_t>::max());
        cut->plan = PlanChunks(*cut->source, static_cast<std::uint32_t>(maxTriangles));
    });
    // A chunk of another plan would be drawn in the place of this one.
    if (_summary.NumChunks() > 0 && _summary.numInChunk != cut->plan.counts) {
        throw Error("geometry is not what it was when it was planned: the stage has been written "
                    "into, or the cache has the summary of other geometry (hdstream cache "
                    "--clear)");
    }
    return cut;
}

std::uint64_t ChunkedGeometry::BytesOf(const Cut& cut) const {
    return _arrayBytes + cut.source->TableBytes() +
           cut.plan.groups.size() * sizeof(cut.plan.groups[0]) +
           cut.plan.NumChunks() * (sizeof(Bounds) + 2 * sizeof(std::uint32_t));
}

std::shared_ptr<const ChunkedGeometry::Cut> ChunkedGeometry::Hold() const {
    bool isMade = false;
    return Hold(&isMade);
}

std::shared_ptr<const ChunkedGeometry::Cut> ChunkedGeometry::Hold(bool* isMade) const {
    const std::lock_guard<std::mutex> lock(_mutex);
    std::shared_ptr<const Cut> cut = _cut.lock();
    *isMade = !cut;
    if (!cut) {
        cut = MakeCut();
        _cut = cut;
    }
    if (!_keeper || _numMaking > 0) {
        _kept = cut;
    }
    if (_keeper) {
        _keeper->Use(this, cut, BytesOf(*cut));
    }
    return cut;
}

void ChunkedGeometry::BeginMaking() const {
    const std::lock_guard<std::mutex> lock(_mutex);
    ++_numMaking;
}

void ChunkedGeometry::EndMaking() const {
    std::shared_ptr<const Cut> dropped; // destroyed without the lock
    const std::lock_guard<std::mutex> lock(_mutex);
    if (--_numMaking == 0 && _keeper) {
        dropped.swap(_kept);
    }
}

std::array<std::uint64_t, 2> ChunkedGeometry::BoundBytes(std::uint32_t chunk) const {
    const std::uint64_t count = _summary.numInChunk[chunk];
    const TriangleBytes& bytes = _summary.boundBytes;
    // Each block of attributes is padded.
    const std::uint64_t padding = kFixedBytes * (1 + _summary.attributes.size());
    return {RoundUp(count * bytes.geometry + kFixedBytes),
            RoundUp(count * bytes.attributes + padding)};
}

ChunkBytes ChunkedGeometry::Make(std::uint32_t chunk) const {
    bool isMade = false;
    const std::shared_ptr<const Cut> cut = Hold(&isMade);
    ChunkBytes pages = MakePages(*cut, chunk);
    if (isMade && _keeper) {
        CountMade(chunk);
    }
    return pages;
}

/// \param chunk for which the source was made.
void ChunkedGeometry::CountMade(std::uint32_t chunk) const {
    _keeper->CountMade();
    const std::lock_guard<std::mutex> lock(_mutex);
    ++_numMade;
    _isMadeAgain = _numMade > 1;
    _firstAhead = _numAhead == 0 ? chunk : _firstAhead;
}

// The first time none, since the source may stay. Then an eighth, which takes about as long as the
// source did, and each time twice as many, until all are there.
void ChunkedGeometry::MakeAhead(const std::function<bool()>& isCancelled) const {
    const auto numChunks = static_cast<std::uint32_t>(_summary.NumChunks());
    std::shared_ptr<const Cut> cut;
    std::uint32_t begin = 0;
    std::uint32_t count = 0;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        if (!std::exchange(_isMadeAgain, false) || !_kept || !_store || !_store->HasSpareRoom()) {
            return;
        }
        cut = _kept;
        begin = _firstAhead + _numAhead;
        count = _numMade < 5 ? std::max(1U, (numChunks / kFirstAheadDivisor) << (_numMade - 2))
                             : numChunks;
        count = std::min(count, numChunks - _numAhead);
        _numAhead += count;
    }
    std::atomic<bool> isKept{true};  // else the store is full
    std::atomic<bool> isOver{false}; // for this time
    // One by one, so that the thread that may ask has its turn as long as there are any.
    tbb::parallel_for(
        begin, begin + count,
        [&](std::uint32_t i) {
            if (isOver || !isKept) {
                return;
            }
            if (isCancelled() || !_store->HasSpareRoom()) {
                isOver = true;
            } else if (!KeepAhead(*cut, i % numChunks)) {
                isKept = false;
            }
        },
        tbb::simple_partitioner());
    const std::lock_guard<std::mutex> lock(_mutex);
    if (!isKept) {
        _numAhead = numChunks; // others would not be kept either
    } else if (isOver) {
        _numAhead = std::min(_numAhead, begin - _firstAhead); // the rest another time
    }
}

/// Makes a chunk that nobody has asked for, unless the store has it.
/// \return false when the store did not keep it.
bool ChunkedGeometry::KeepAhead(const Cut& cut, std::uint32_t chunk) const {
    if (IsStored(chunk)) {
        return true;
    }
    const ChunkBytes pages = MakePages(cut, chunk);
    for (std::uint32_t page = 0; page < pages.size(); ++page) {
        if (!_store->SaveAhead(*Key(chunk, page), pages[page].data(), pages[page].size())) {
            return false;
        }
    }
    _keeper->CountAhead();
    return true;
}

bool ChunkedGeometry::IsStored(std::uint32_t chunk) const {
    return _store->Contains(*Key(chunk, HDS_PAGE_GEOMETRY)) &&
           _store->Contains(*Key(chunk, HDS_PAGE_ATTRIBUTES));
}

ChunkBytes ChunkedGeometry::MakePages(const Cut& cut, std::uint32_t chunk) const {
    const ChunkPlan& plan = cut.plan;
    ChunkGeometry gathered = cut.source->Gather(plan.groups.data() + plan.begin[chunk],
                                                plan.begin[chunk + 1] - plan.begin[chunk]);
    ChunkBytes pages;
    pages[HDS_PAGE_GEOMETRY] = BuildGeometryPage(gathered).bytes;
    pages[HDS_PAGE_ATTRIBUTES] = BuildAttributePage(gathered);
    return pages;
}

PageKey ChunkedGeometry::PartKey(std::uint64_t index) const {
    Hasher hasher;
    hasher.Append(kPageFormat);
    hasher.Append(_key.words[0]);
    hasher.Append(_key.words[1]);
    hasher.Append(index);
    return MakePageKey(hasher);
}

} // namespace hds
