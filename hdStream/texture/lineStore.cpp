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
           (_store && _store->Bytes(KeyOf(index)));
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

void LineStore::ForgetSaved() const {
    for (std::uint32_t index = 0; _store && index < _groups.size(); ++index) {
        _store->Forget(KeyOf(index));
    }
}

/// The page of a group, which is opened when it is asked for first; null: it is not there.
const OpenedPage* LineStore::PageOf(std::uint32_t group) const {
    std::atomic<const OpenedPage*>& kept = _groups[group].page;
    const OpenedPage* page = kept.load(std::memory_order_acquire);
    if (page != nullptr || !_store) {
        return page;
    }
    std::unique_ptr<const OpenedPage> opened = _store->Open(KeyOf(group));
    if (opened && kept.compare_exchange_strong(page, opened.get(), std::memory_order_acq_rel)) {
        return opened.release();
    }
    return page; // of another thread, or null
}

/// Copies lines of one group.
bool LineStore::ReadOfGroup(std::uint32_t line, std::uint32_t count, TextureLine* out) const {
    const std::uint32_t index = line / kGroupLines;
    const std::uint32_t first = line % kGroupLines;
    const TextureLine* group = _groups[index].data.load(std::memory_order_acquire);
    if (group != nullptr) {
        std::copy_n(group + first, count, out);
        return true;
    }
    // Not through a mapping: a file that is cut while it is mapped would be a signal.
    const std::uint64_t offset = std::uint64_t{first} * HDS_LINE_BYTES;
    const std::size_t bytes = std::size_t{count} * HDS_LINE_BYTES;
    const OpenedPage* page = PageOf(index);
    return page != nullptr && (page->Read(offset, bytes, out->data()) ||
                               _store->LoadPart(KeyOf(index), offset, bytes, out->data()));
}

bool LineStore::Read(std::uint32_t line, TextureLine* out) const {
    return ReadOfGroup(line, 1, out);
}

bool LineStore::ReadRun(std::uint32_t first, std::uint32_t count, TextureLine* out) const {
    const std::uint32_t end = first + count;
    for (std::uint32_t line = first; line < end;) {
        const std::uint32_t inGroup = std::min(end - line, kGroupLines - line % kGroupLines);
        if (!ReadOfGroup(line, inGroup, out)) {
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
