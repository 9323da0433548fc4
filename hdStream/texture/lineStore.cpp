// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/lineStore.h"

#include "hdStream/base/error.h"

#include <algorithm>

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

bool LineStore::Has(std::uint32_t line) const {
    const std::uint32_t index = line / kGroupLines;
    return _groups[index].data.load(std::memory_order_acquire) != nullptr ||
           (_store && _store->Contains(KeyOf(index)));
}

void LineStore::BeginFilling(std::uint32_t first) {
    for (std::uint32_t index = 0; index < _groups.size(); ++index) {
        _groups[index].isFilling = index >= first / kGroupLines && !Has(index * kGroupLines);
        _groups[index].numComplete = 0;
    }
}

void LineStore::BeginFilling(const std::vector<std::uint32_t>& lines) {
    for (Group& group : _groups) {
        group.isFilling = false;
        group.numComplete = 0;
    }
    for (const std::uint32_t line : lines) {
        _groups[line / kGroupLines].isFilling = !Has(line);
    }
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
        if (_store && Keep(index)) {
            std::vector<TextureLine>().swap(group.lines);
        } else {
            group.data.store(group.lines.data(), std::memory_order_release);
        }
    }
}

/// Saves a group. One that is there already may turn out to be damaged, and is saved anew then.
bool LineStore::Keep(std::uint32_t index) const {
    const std::vector<TextureLine>& lines = _groups[index].lines;
    for (int attempt = 0; attempt < 2; ++attempt) {
        if (!_store->Save(KeyOf(index), lines.data(), lines.size() * HDS_LINE_BYTES)) {
            return false;
        }
        if (_store->Locate(KeyOf(index))) {
            return true;
        }
    }
    return false;
}

bool LineStore::Read(std::uint32_t line, TextureLine* out) const {
    const std::uint32_t index = line / kGroupLines;
    const TextureLine* group = _groups[index].data.load(std::memory_order_acquire);
    if (group != nullptr) {
        *out = group[line % kGroupLines];
        return true;
    }
    // Not through a mapping: a file that is cut while it is mapped would be a signal.
    return _store &&
           _store->LoadPart(KeyOf(index), std::uint64_t{line % kGroupLines} * HDS_LINE_BYTES,
                            sizeof(*out), out->data());
}

bool LineStore::ReadRun(std::uint32_t first, std::uint32_t count, TextureLine* out) const {
    const std::uint32_t end = first + count;
    for (std::uint32_t line = first; line < end;) {
        const std::uint32_t index = line / kGroupLines;
        const std::uint32_t inGroup = std::min(end - line, kGroupLines - line % kGroupLines);
        const TextureLine* group = _groups[index].data.load(std::memory_order_acquire);
        if (group != nullptr) {
            std::copy_n(group + line % kGroupLines, inGroup, out);
        } else if (!_store || !_store->LoadPart(
                                  KeyOf(index), std::uint64_t{line % kGroupLines} * HDS_LINE_BYTES,
                                  std::size_t{inGroup} * HDS_LINE_BYTES, out->data())) {
            return false;
        }
        out += inGroup;
        line += inGroup;
    }
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
