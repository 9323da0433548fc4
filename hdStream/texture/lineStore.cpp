// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/lineStore.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <cstring>

namespace hds {

LineStore::LineStore(std::shared_ptr<PageStore> store, const PageKey& key, std::uint32_t numLines)
    : _store(std::move(store)), _key(key), _numLines(numLines),
      _groups((numLines + kGroupLines - 1) / kGroupLines) {}

std::uint32_t LineStore::GroupSize(std::uint32_t group) const {
    return std::min(kGroupLines, _numLines - group * kGroupLines);
}

PageKey LineStore::KeyOf(std::uint32_t group) const {
    Hasher hasher;
    hasher.Append("lines");
    hasher.Append(_key.words[0]);
    hasher.Append(_key.words[1]);
    hasher.Append(std::uint64_t{group});
    return MakePageKey(hasher);
}

TextureLine* LineStore::Open(std::uint32_t line) {
    Group& group = _groups[line / kGroupLines];
    if (group.lines.empty()) {
        group.lines.resize(GroupSize(line / kGroupLines), TextureLine{});
    }
    return &group.lines[line % kGroupLines];
}

void LineStore::Complete(std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t line = first; line < first + count; ++line) {
        const std::uint32_t index = line / kGroupLines;
        Group& group = _groups[index];
        if (++group.numComplete < GroupSize(index)) {
            continue;
        }
        HDS_VERIFY(!group.lines.empty(), "a group is complete that nobody has opened");
        if (_store &&
            _store->Save(KeyOf(index), group.lines.data(), group.lines.size() * HDS_LINE_BYTES) &&
            Find(index) != nullptr) {
            std::vector<TextureLine>().swap(group.lines);
        } else {
            group.data.store(group.lines.data(), std::memory_order_release);
        }
    }
}

const TextureLine* LineStore::Find(std::uint32_t index) const {
    const Group& group = _groups[index];
    const TextureLine* data = group.data.load(std::memory_order_acquire);
    if (data != nullptr || !_store) {
        return data;
    }
    const auto location = _store->Locate(KeyOf(index));
    if (!location || location->bytes != std::uint64_t{GroupSize(index)} * HDS_LINE_BYTES) {
        return nullptr;
    }
    const std::uint8_t* segment = _store->SegmentData(location->segment);
    if (segment == nullptr) {
        return nullptr;
    }
    data = reinterpret_cast<const TextureLine*>(segment + location->offset);
    group.data.store(data, std::memory_order_release);
    return data;
}

bool LineStore::Read(std::uint32_t line, TextureLine* out) const {
    const TextureLine* group = Find(line / kGroupLines);
    if (group != nullptr) {
        std::memcpy(out, group + line % kGroupLines, sizeof(*out));
        return true;
    }
    std::vector<std::uint8_t> bytes; // a segment that cannot be mapped
    const std::uint32_t index = line / kGroupLines;
    if (!_store || !_store->Load(KeyOf(index), &bytes) ||
        bytes.size() != std::size_t{GroupSize(index)} * HDS_LINE_BYTES) {
        return false;
    }
    std::memcpy(out, &bytes[std::size_t{line % kGroupLines} * HDS_LINE_BYTES], sizeof(*out));
    return true;
}

std::uint64_t LineStore::HostBytes() const {
    std::uint64_t bytes = 0;
    for (const Group& group : _groups) {
        bytes += group.lines.size() * HDS_LINE_BYTES;
    }
    return bytes;
}

} // namespace hds
