// SPDX-License-Identifier: Apache-2.0
#include "hdStream/accel/chunkPages.h"

#include "hdStream/base/hash.h"

#include <atomic>
#include <utility>

namespace hds {

namespace {

std::uint64_t NextIds() {
    static std::atomic<std::uint64_t> next{1};
    return next.fetch_add(ChunkPages::kNumPages, std::memory_order_relaxed);
}

PageKey KeyOfBytes(const std::vector<std::uint8_t>& bytes) {
    Hasher hasher;
    hasher.Append(bytes.data(), bytes.size());
    return MakePageKey(hasher);
}

} // namespace

ChunkPages::ChunkPages(std::shared_ptr<const PageMaker> maker, std::uint32_t chunk)
    : _maker(std::move(maker)), _chunk(chunk), _firstId(NextIds()),
      _bytes(_maker->BoundBytes(chunk)) {}

void ChunkPages::FindSizes() {
    if (!_maker->Store() || _isExact) {
        return;
    }
    std::array<std::uint64_t, kNumPages> sizes{};
    for (std::uint32_t page = 0; page < kNumPages; ++page) {
        const auto key = _maker->Key(_chunk, page);
        const auto bytes = key ? _maker->Store()->Bytes(*key) : std::nullopt;
        if (!bytes) {
            return;
        }
        sizes[page] = *bytes;
    }
    _bytes = sizes;
    _isExact = true;
}

ChunkPages::Made ChunkPages::Prepare(const std::array<bool, kNumPages>& isWanted) {
    if (Load(isWanted)) {
        return Made::Loaded;
    }
    _data.Edit() = _maker->Make(_chunk);
    Made made = Made::MadeAlways;
    for (std::uint32_t page = 0; page < kNumPages; ++page) {
        _bytes[page] = Data(page).size();
        const auto key = _maker->Key(_chunk, page);
        made = key ? Made::Built : made;
        if (_maker->Store() && key) {
            _maker->Store()->Save(*key, Data(page).data(), Data(page).size());
        }
    }
    _isExact = true;
    return made;
}

bool ChunkPages::Locate(std::uint32_t page, MappedPage* mapped) {
    PageStore* store = _maker->Store();
    if (!store) {
        return false;
    }
    auto key = _maker->Key(_chunk, page);
    if (!key && HasData(page)) {
        key = KeyOfBytes(Data(page));
        store->Save(*key, Data(page).data(), Data(page).size());
    }
    const auto location = key ? store->Locate(*key) : std::nullopt;
    if (!location) {
        return false;
    }
    mapped->file = store->SegmentData(location->segment);
    mapped->fileBytes = store->SegmentBytes(location->segment);
    mapped->offset = location->offset;
    _bytes[page] = location->bytes;
    return mapped->file != nullptr;
}

void ChunkPages::Drop(std::uint32_t page) {
    if (!_data.IsApart()) {
        return;
    }
    std::vector<std::uint8_t>().swap(_data.Edit()[page]);
    if (DataBytes() == 0) {
        _data = Apart<ChunkBytes>();
    }
}

/// \return whether all that is wanted is there now.
bool ChunkPages::Load(const std::array<bool, kNumPages>& isWanted) {
    FindSizes();
    for (std::uint32_t page = 0; page < kNumPages; ++page) {
        if (!isWanted[page] || HasData(page)) {
            continue;
        }
        const auto key = _maker->Key(_chunk, page);
        if (!_maker->Store() || !key || !_maker->Store()->Load(*key, &_data.Edit()[page])) {
            return false;
        }
        _bytes[page] = Data(page).size();
    }
    return true;
}

} // namespace hds
