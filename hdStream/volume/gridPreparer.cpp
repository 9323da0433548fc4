// SPDX-License-Identifier: Apache-2.0
#include "hdStream/volume/gridPreparer.h"

#include "hdStream/base/hash.h"
#include "hdStream/persist/fileIdentity.h"

#include <iterator>
#include <optional>
#include <utility>

namespace hds {

namespace {

/// Changes with what is kept of a grid.
constexpr std::uint64_t kCodeVersion = 3;
/// Times that a file which is written to while it is read is read again.
constexpr int kMaxTries = 3;

/// Everything a grid of a file depends on. \return empty when the file cannot be read.
std::optional<PageKey> FileKey(const VdbRequest& request, std::uint64_t bytes) {
    Hasher hasher;
    hasher.Append("grid");
    hasher.Append(kCodeVersion);
    hasher.Append(request.gridName);
    hasher.Append(static_cast<std::uint64_t>(request.gridIndex));
    if (request.isNegated) {
        hasher.Append("negated");
    }
    if (!AppendFileIdentity(&hasher, request.file, request.offset, bytes)) {
        return std::nullopt;
    }
    return MakePageKey(hasher);
}

PageKey ComponentKey(const PageKey& key, std::size_t component) {
    Hasher hasher;
    hasher.Append("gridComponent");
    hasher.Append(key.words[0]);
    hasher.Append(key.words[1]);
    hasher.Append(std::uint64_t{component});
    return MakePageKey(hasher);
}

PageKey MemoryKey(const VoxelGrid& grid) {
    Hasher hasher;
    hasher.Append("gridInMemory");
    for (int i = 0; i < 3; ++i) {
        hasher.Append(static_cast<std::uint64_t>(static_cast<std::uint32_t>(grid.first[i])));
        hasher.Append(static_cast<std::uint64_t>(grid.size[i]));
    }
    for (const VoxelCell& cell : grid.cells) {
        hasher.Append(&cell, sizeof(cell));
    }
    for (const VoxelBrick& brick : grid.bricks) {
        hasher.Append(brick.data(), sizeof(brick));
    }
    return MakePageKey(hasher);
}

std::shared_ptr<const PreparedGrid> MakePrepared(GridDescription description,
                                                 std::shared_ptr<const LineStore> lines,
                                                 PreparedTexture::Make restore) {
    TextureDescription texture = LinesOf(description);
    auto prepared = std::make_shared<PreparedGrid>();
    prepared->description = std::move(description);
    prepared->lines =
        std::make_shared<PreparedTexture>(std::move(texture), std::move(lines), std::move(restore));
    return prepared;
}

/// All components; nothing when the file cannot be read.
std::vector<BuiltGrid> BuildFile(const VdbRequest& request, const std::shared_ptr<PageStore>& store,
                                 const PageKey& key, std::string* error) {
    std::vector<BuiltGrid> built;
    const std::vector<VoxelGrid> grids = ReadVdb(request, error);
    for (std::size_t i = 0; i < grids.size(); ++i) {
        built.push_back(BuildGrid(grids[i], store, ComponentKey(key, i)));
        built.back().description.numComponents = static_cast<std::uint32_t>(grids.size());
    }
    return built;
}

} // namespace

PreparedGrids GridPreparer::Prepare(const VdbRequest& request, std::uint64_t bytes,
                                    std::string* error) {
    std::optional<PageKey> key = FileKey(request, bytes);
    if (key) {
        const auto found = _entries.find(*key);
        if (found != _entries.end()) {
            found->second.isUsed = true;
            return found->second.grids;
        }
    }
    PreparedGrids grids = key && _store ? Load(request, bytes, *key) : PreparedGrids();
    for (int i = 0; i < kMaxTries && grids.empty(); ++i) {
        // What is read of a file that changes meanwhile must not be kept under its old key.
        key = FileKey(request, bytes);
        std::vector<BuiltGrid> built = BuildFile(
            request, key && i + 1 < kMaxTries ? _store : nullptr, key.value_or(PageKey()), error);
        if (built.empty()) {
            return {};
        }
        const bool isStable = key && FileKey(request, bytes) == key;
        for (const BuiltGrid& grid : built) {
            if (!isStable) {
                grid.lines->ForgetSaved();
            }
        }
        for (std::size_t k = 0; k < built.size() && (isStable || i + 1 == kMaxTries); ++k) {
            // Only beside bricks that are all in the store: else the next process would find none.
            if (isStable && _store && built[k].lines->HostBytes() == 0) {
                SaveGridDescription(_store.get(), ComponentKey(*key, k), built[k].description);
            }
            grids.push_back(MakePrepared(std::move(built[k].description), std::move(built[k].lines),
                                         isStable ? Restorer(request, bytes, *key, k) : nullptr));
        }
    }
    if (key) {
        _entries[*key] = {grids, nullptr, true};
    }
    return grids;
}

PreparedGrids GridPreparer::Prepare(const std::shared_ptr<const VoxelGrid>& grid) {
    for (auto& [key, entry] : _entries) {
        if (entry.source == grid) {
            entry.isUsed = true;
            return entry.grids;
        }
    }
    const PageKey key = MemoryKey(*grid);
    BuiltGrid built = BuildGrid(*grid, nullptr, key);
    PreparedGrids grids{
        MakePrepared(std::move(built.description), std::move(built.lines), nullptr)};
    _entries[key] = {grids, grid, true};
    return grids;
}

/// From the store; nothing when not all components are there.
PreparedGrids GridPreparer::Load(const VdbRequest& request, std::uint64_t bytes,
                                 const PageKey& key) const {
    PreparedGrids grids;
    std::size_t numComponents = 1;
    for (std::size_t i = 0; i < numComponents; ++i) {
        const PageKey own = ComponentKey(key, i);
        std::optional<GridDescription> description = LoadGridDescription(_store.get(), own);
        if (!description) {
            return {};
        }
        numComponents = description->numComponents;
        auto lines =
            std::make_shared<LineStore>(_store, own, LinesOf(*description).record.numLines);
        grids.push_back(MakePrepared(std::move(*description), std::move(lines),
                                     Restorer(request, bytes, key, i)));
    }
    return grids;
}

/// What makes the bricks of a component again when some are found damaged.
PreparedTexture::Make GridPreparer::Restorer(const VdbRequest& request, std::uint64_t bytes,
                                             const PageKey& key, std::size_t component) const {
    return [request, bytes, key, component, store = _store, warnings = _warnings](
               const std::vector<std::uint32_t>&) -> std::shared_ptr<const LineStore> {
        if (FileKey(request, bytes) == key) {
            std::string error;
            const std::vector<BuiltGrid> built = BuildFile(request, store, key, &error);
            if (component < built.size() && FileKey(request, bytes) == key) {
                return built[component].lines;
            }
        }
        if (warnings != nullptr) {
            warnings->Add(request.file, "the prepared grid '" + request.gridName +
                                            "' is damaged, and the file is not the same any more");
        }
        return nullptr;
    };
}

void GridPreparer::ForgetUnused() {
    for (auto entry = _entries.begin(); entry != _entries.end();) {
        const bool isUsed = std::exchange(entry->second.isUsed, false);
        entry = isUsed ? std::next(entry) : _entries.erase(entry);
    }
}

} // namespace hds
