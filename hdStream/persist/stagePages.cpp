// SPDX-License-Identifier: Apache-2.0
#include "hdStream/persist/stagePages.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <unordered_set>

namespace hds {

namespace {

constexpr const char* kKind = "stage";

/// An entry's payload: bytes of the name, the name, and the keys of pages, which may repeat.
struct Note {
    std::string stage;
    std::vector<PageKey> pages;
};

Note ReadNote(const std::vector<std::uint8_t>& payload) {
    Note note;
    std::uint64_t nameBytes = 0;
    if (payload.size() < sizeof(nameBytes)) {
        return note;
    }
    std::memcpy(&nameBytes, payload.data(), sizeof(nameBytes));
    const std::uint64_t left = payload.size() - sizeof(nameBytes);
    if (nameBytes > left) {
        return note;
    }
    const std::uint8_t* const name = payload.data() + sizeof(nameBytes);
    note.stage.assign(name, name + nameBytes);
    note.pages.resize((left - nameBytes) / sizeof(PageKey));
    if (!note.pages.empty()) {
        std::memcpy(note.pages.data(), name + nameBytes, note.pages.size() * sizeof(PageKey));
    }
    return note;
}

std::vector<std::uint8_t> PayloadOf(const Note& note) {
    const std::uint64_t nameBytes = note.stage.size();
    const std::size_t pageBytes = note.pages.size() * sizeof(PageKey);
    std::vector<std::uint8_t> payload(sizeof(nameBytes) + nameBytes + pageBytes);
    std::memcpy(payload.data(), &nameBytes, sizeof(nameBytes));
    std::memcpy(payload.data() + sizeof(nameBytes), note.stage.data(), nameBytes);
    if (pageBytes > 0) {
        std::memcpy(payload.data() + sizeof(nameBytes) + nameBytes, note.pages.data(), pageBytes);
    }
    return payload;
}

std::string KeyOf(const std::string& stage) {
    Hasher hasher;
    hasher.Append(stage.data(), stage.size());
    return hasher.Hex();
}

} // namespace

void NoteStagePages(const std::string& stage, const PageStore& used, Store* store) {
    const std::vector<PageKey> pages = used.UsedPages();
    Note note{stage, pages};
    const std::string key = KeyOf(stage);
    if (const auto payload = store->Load(kKind, key)) {
        const Note before = ReadNote(*payload);
        std::unordered_set<PageKey> all(pages.begin(), pages.end());
        std::size_t numKept = 0;
        for (const PageKey& page : before.pages) {
            const bool isNoted = all.find(page) != all.end();
            if (!isNoted && used.Contains(page)) {
                all.insert(page);
                note.pages.push_back(page);
            }
            numKept += isNoted || all.find(page) != all.end() ? 1 : 0;
        }
        if (numKept == before.pages.size() && note.pages.size() == numKept) {
            return; // nothing is new, and nothing has left
        }
    }
    const std::vector<std::uint8_t> payload = PayloadOf(note);
    store->Save(kKind, key, payload.data(), payload.size());
}

std::vector<StagePages> ListStagePages(Store* store, const PageStore& pages, PageAmount* rest) {
    std::vector<StagePages> stages;
    std::unordered_set<PageKey> ofStages;
    PageAmount ofAll;
    for (const std::string& key : store->Keys(kKind)) {
        const auto payload = store->Load(kKind, key);
        const Note note = payload ? ReadNote(*payload) : Note();
        StagePages stage{note.stage, {}};
        for (const PageKey& page : note.pages) {
            const auto bytes = pages.Bytes(page);
            if (!bytes) {
                continue; // has left
            }
            ++stage.amount.pages;
            stage.amount.bytes += *bytes;
            if (ofStages.insert(page).second) {
                ++ofAll.pages;
                ofAll.bytes += *bytes;
            }
        }
        if (stage.amount.pages > 0) {
            stages.push_back(std::move(stage));
        }
    }
    std::sort(stages.begin(), stages.end(),
              [](const StagePages& a, const StagePages& b) { return a.stage < b.stage; });
    const PageAmount all = pages.Amount();
    *rest = {all.pages - ofAll.pages, all.bytes - ofAll.bytes};
    return stages;
}

} // namespace hds
