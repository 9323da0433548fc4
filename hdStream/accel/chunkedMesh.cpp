// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/chunkedMesh.h"

#include "hdStream/base/error.h"
#include "hdStream/base/hash.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

namespace hds {

namespace {

/// Changes whenever the same mesh gives other pages or another plan: part of the keys in the store.
constexpr std::uint64_t kPageFormat = 5;
/// The part of a mesh that is its outline; pages count from 0.
constexpr std::uint64_t kOutlinePart = ~std::uint64_t{0};

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

std::vector<std::uint8_t> SerializeOutline(const MeshOutline& outline) {
    Writer writer;
    writer.Add(outline.origin);
    writer.Add(outline.isLeftHanded);
    writer.Add(outline.numTriangles);
    writer.Add(outline.boundBytes);
    writer.Add(std::uint64_t{outline.attributes.size()});
    for (const AttributeFormat& attribute : outline.attributes) {
        writer.AddText(attribute.name);
        writer.Add(attribute.numComponents);
    }
    writer.AddArray(outline.chunkBounds);
    writer.AddArray(outline.numInChunk);
    return std::move(writer.bytes);
}

std::optional<MeshOutline> ParseOutline(const std::vector<std::uint8_t>& bytes) {
    Reader reader(bytes);
    MeshOutline outline;
    reader.Get(&outline.origin);
    reader.Get(&outline.isLeftHanded);
    reader.Get(&outline.numTriangles);
    reader.Get(&outline.boundBytes);
    outline.attributes.resize(reader.GetCount(sizeof(std::uint64_t)));
    for (AttributeFormat& attribute : outline.attributes) {
        reader.GetText(&attribute.name);
        reader.Get(&attribute.numComponents);
    }
    reader.GetArray(&outline.chunkBounds);
    reader.GetArray(&outline.numInChunk);
    if (!reader.IsAtEnd() || outline.numInChunk.size() != outline.NumChunks()) {
        return std::nullopt;
    }
    return outline;
}

ChunkedMesh::ChunkedMesh(SourceMaker makeSource, std::uint64_t chunkBytes,
                         std::shared_ptr<PageStore> store, const PageKey& key)
    : _makeSource(std::move(makeSource)), _chunkBytes(chunkBytes), _store(std::move(store)),
      _key(key) {
    if (!LoadOutline()) {
        MakeSourceOnce();
        MakeOutline();
    }
}

bool ChunkedMesh::LoadOutline() {
    std::vector<std::uint8_t> bytes;
    if (!_store || !_store->Load(PartKey(kOutlinePart), &bytes)) {
        return false;
    }
    std::optional<MeshOutline> outline = ParseOutline(bytes);
    if (!outline) {
        return false;
    }
    _outline = std::move(*outline);
    return true;
}

void ChunkedMesh::SaveOutline() const {
    const PageKey key = PartKey(kOutlinePart);
    if (_store && !_store->Contains(key)) {
        const std::vector<std::uint8_t> bytes = SerializeOutline(_outline);
        _store->Save(key, bytes.data(), bytes.size());
    }
}

void ChunkedMesh::MakeOutline() {
    _outline.origin = _source->Origin();
    _outline.isLeftHanded = _source->IsLeftHanded();
    _outline.numTriangles = _source->NumTriangles();
    _outline.attributes = _source->Attributes();
    _outline.boundBytes = _source->BoundBytes();
    _outline.chunkBounds = _plan.bounds;
    _outline.numInChunk = _plan.counts;
}

void ChunkedMesh::MakeSourceOnce() const {
    std::call_once(_isMade, [this] {
        // A thread that took another task meanwhile might come here again and wait for itself.
        tbb::this_task_arena::isolate([this] {
            _source = _makeSource();
            if (_source->NumTriangles() == 0) {
                return;
            }
            const std::uint64_t maxTriangles =
                std::clamp<std::uint64_t>(_chunkBytes / _source->MeanBytes().Both(), 1,
                                          std::numeric_limits<std::uint32_t>::max());
            _plan = PlanChunks(*_source, static_cast<std::uint32_t>(maxTriangles));
        });
        // A chunk of another plan would be drawn in the place of this one.
        HDS_VERIFY(_outline.NumChunks() == 0 || _outline.numInChunk == _plan.counts,
                   "the cache has the outline of another mesh: hdstream cache --clear");
    });
}

const ChunkSource& ChunkedMesh::Source() const {
    MakeSourceOnce();
    return *_source;
}

const ChunkPlan& ChunkedMesh::Plan() const {
    MakeSourceOnce();
    return _plan;
}

PageKey ChunkedMesh::PartKey(std::uint64_t index) const {
    Hasher hasher;
    hasher.Append(kPageFormat);
    hasher.Append(_key.words[0]);
    hasher.Append(_key.words[1]);
    hasher.Append(index);
    return MakePageKey(hasher);
}

} // namespace hds
