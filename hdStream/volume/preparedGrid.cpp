// SPDX-License-Identifier: Apache-2.0
#include "hdStream/volume/preparedGrid.h"

#include "hdStream/persist/pageBytes.h"

#include <glm/gtc/type_ptr.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

namespace hds {

namespace {

constexpr std::size_t kTileCells = std::size_t{HDS_TILE_CELLS} * HDS_TILE_CELLS * HDS_TILE_CELLS;

/// A tile while it is made.
struct TileBuild {
    shared::HdsGridTile tile{HDS_NONE, 0.0F, 0.0F, 0.0F};
    std::vector<shared::HdsGridCell> cells; ///< empty: the tile is constant
    std::vector<std::uint32_t> bricks;      ///< of the source, in the order of the cells
};

/// Whether a cell, from voxel `first` on, has one value, also where it is outside of the grid's
/// box.
bool IsConstant(const VoxelGrid& source, glm::ivec3 first) {
    const glm::ivec3 end = source.first + source.size;
    for (int i = 0; i < 3; ++i) {
        if (first[i] + HDS_BRICK_VOXELS <= source.first[i] || first[i] >= end[i]) {
            return true; // 0
        }
    }
    return source.cells[source.CellOf(glm::clamp(first, source.first, end - 1))].brick == HDS_NONE;
}

/// Of the voxels that interpolation inside of a cell reads.
struct VoxelBounds {
    float least = std::numeric_limits<float>::max();
    float greatest = 0.0F;

    void Add(float value) {
        least = std::min(least, value);
        greatest = std::max(greatest, value);
    }
};

VoxelBounds BoundsIn(const VoxelGrid& source, glm::ivec3 first) {
    bool isConstant = true;
    VoxelBounds bounds;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 there =
            first + HDS_BRICK_VOXELS * glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        isConstant = isConstant && IsConstant(source, there);
        bounds.Add(source.ValueAt(there));
    }
    if (isConstant) {
        return bounds;
    }
    for (int z = 0; z <= HDS_BRICK_VOXELS; ++z) {
        for (int y = 0; y <= HDS_BRICK_VOXELS; ++y) {
            for (int x = 0; x <= HDS_BRICK_VOXELS; ++x) {
                bounds.Add(source.ValueAt(first + glm::ivec3(x, y, z)));
            }
        }
    }
    return bounds;
}

/// Of the voxels of a cell that are in the grid's box: those beyond are 0.
float MeanOf(const VoxelGrid& source, glm::ivec3 first, const VoxelBrick& values) {
    const glm::ivec3 inside = glm::min(first + HDS_BRICK_VOXELS, source.first + source.size) -
                              glm::max(first, source.first);
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    return static_cast<float>(sum / (double(inside.x) * inside.y * inside.z));
}

shared::HdsGridCell MakeCell(const VoxelGrid& source, glm::ivec3 first, TileBuild* tile) {
    const VoxelBounds bounds = BoundsIn(source, first);
    shared::HdsGridCell cell{HDS_NONE, source.ValueAt(first), bounds.greatest, bounds.least};
    if (!IsConstant(source, first)) {
        const std::uint32_t brick = source
                                        .cells[source.CellOf(glm::clamp(
                                            first, source.first, source.first + source.size - 1))]
                                        .brick;
        const VoxelBrick& values = source.bricks[brick];
        if (std::all_of(values.begin(), values.end(),
                        [&](float value) { return value == values[0]; })) {
            cell.value = values[0];
        } else {
            cell.value = MeanOf(source, first, values);
            cell.brick = static_cast<std::uint32_t>(tile->bricks.size());
            tile->bricks.push_back(brick);
        }
    }
    return cell;
}

TileBuild MakeTile(const VoxelGrid& source, glm::ivec3 first) {
    TileBuild build;
    build.cells.reserve(kTileCells);
    bool isConstant = true;
    for (int z = 0; z < HDS_TILE_CELLS; ++z) {
        for (int y = 0; y < HDS_TILE_CELLS; ++y) {
            for (int x = 0; x < HDS_TILE_CELLS; ++x) {
                const shared::HdsGridCell cell =
                    MakeCell(source, first + HDS_BRICK_VOXELS * glm::ivec3(x, y, z), &build);
                build.tile.greatest = std::max(build.tile.greatest, cell.greatest);
                const shared::HdsGridCell& head = build.cells.empty() ? cell : build.cells[0];
                isConstant = isConstant && cell.brick == HDS_NONE && cell.value == head.value &&
                             cell.greatest == head.greatest && cell.least == head.least;
                build.cells.push_back(cell);
            }
        }
    }
    build.tile.value = build.cells[0].value;
    if (isConstant) {
        build.tile.least = build.cells[0].least;
        build.cells.clear();
    }
    return build;
}

template <typename Element>
void AddElements(PageWriter* page, const std::vector<Element>& elements) {
    page->Add(std::uint64_t{elements.size()});
    page->Add(elements.data(), elements.size() * sizeof(Element));
}

template <typename Element>
void GetElements(PageReader* page, std::uint64_t limit, std::vector<Element>* elements) {
    const std::uint64_t size = page->Number();
    elements->resize(size <= limit / sizeof(Element) ? size : 0);
    page->Get(elements->data(), elements->size() * sizeof(Element));
}

PageKey DescriptionKey(const PageKey& key) {
    Hasher hasher;
    hasher.Append("gridDescription");
    hasher.Append(key.words[0]);
    hasher.Append(key.words[1]);
    return MakePageKey(hasher);
}

} // namespace

BuiltGrid BuildGrid(const VoxelGrid& grid, const std::shared_ptr<PageStore>& store,
                    const PageKey& key) {
    BuiltGrid built;
    GridDescription& description = built.description;
    description.first = grid.first;
    description.size = grid.size;
    description.objectFromIndex = grid.objectFromIndex;
    // A voxel more on each side: interpolation fades to 0 there.
    const glm::ivec3 origin = ((grid.first - 1) >> HDS_TILE_VOXELS_LOG2) * HDS_TILE_VOXELS;
    const glm::ivec3 numTiles =
        ((grid.first + grid.size - origin) >> HDS_TILE_VOXELS_LOG2) + glm::ivec3(1);
    for (int i = 0; i < 3; ++i) {
        description.record.origin[i] = origin[i];
        description.record.tiles[i] = static_cast<std::uint32_t>(numTiles[i]);
    }
    std::vector<TileBuild> tiles(std::size_t(numTiles.x) * numTiles.y * numTiles.z);
    tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t i) {
        const auto n = static_cast<int>(i);
        const glm::ivec3 at(n % numTiles.x, n / numTiles.x % numTiles.y,
                            n / numTiles.x / numTiles.y);
        tiles[i] = MakeTile(grid, origin + HDS_TILE_VOXELS * at);
    });
    std::vector<std::uint32_t> bricks;
    for (TileBuild& tile : tiles) {
        if (!tile.cells.empty()) {
            tile.tile.firstCell = static_cast<std::uint32_t>(description.cells.size());
        }
        for (shared::HdsGridCell& cell : tile.cells) {
            cell.brick += cell.brick != HDS_NONE ? static_cast<std::uint32_t>(bricks.size()) : 0U;
        }
        description.cells.insert(description.cells.end(), tile.cells.begin(), tile.cells.end());
        bricks.insert(bricks.end(), tile.bricks.begin(), tile.bricks.end());
        description.tiles.push_back(tile.tile);
        description.record.greatest = std::max(description.record.greatest, tile.tile.greatest);
    }
    description.numBricks = static_cast<std::uint32_t>(bricks.size());
    description.id = key.words[0];
    built.lines = std::make_shared<LineStore>(store, key, LinesOf(description).record.numLines);
    static_assert(sizeof(VoxelBrick) == HDS_BRICK_LINES * sizeof(TextureLine));
    for (std::uint32_t i = 0; i < description.numBricks; ++i) {
        const auto* values = reinterpret_cast<const std::uint8_t*>(grid.bricks[bricks[i]].data());
        for (std::uint32_t part = 0; part < HDS_BRICK_LINES; ++part) {
            std::memcpy(built.lines->Open(i * HDS_BRICK_LINES + part)->data(),
                        values + std::size_t{part} * HDS_LINE_BYTES, HDS_LINE_BYTES);
        }
        built.lines->Complete(i * HDS_BRICK_LINES, HDS_BRICK_LINES);
    }
    if (description.numBricks == 0) {
        built.lines->Open(0);
        built.lines->Complete(0, 1);
    }
    return built;
}

TextureDescription LinesOf(const GridDescription& description) {
    TextureDescription lines;
    lines.record.width = 1;
    lines.record.height = 1;
    lines.record.numMips = 1;
    lines.record.numLines = std::max(1U, description.numBricks * HDS_BRICK_LINES);
    return lines;
}

void SaveGridDescription(PageStore* store, const PageKey& key, const GridDescription& description) {
    PageWriter page;
    page.Add(&description.record, sizeof(description.record));
    page.Add(&description.first, sizeof(description.first));
    page.Add(&description.size, sizeof(description.size));
    page.Add(glm::value_ptr(description.objectFromIndex), sizeof(description.objectFromIndex));
    page.Add(std::uint64_t{description.numBricks});
    page.Add(std::uint64_t{description.numComponents});
    page.Add(description.id);
    AddElements(&page, description.tiles);
    AddElements(&page, description.cells);
    store->Save(DescriptionKey(key), page.Bytes().data(), page.Bytes().size());
}

std::optional<GridDescription> LoadGridDescription(PageStore* store, const PageKey& key) {
    std::vector<std::uint8_t> bytes;
    if (!store->Load(DescriptionKey(key), &bytes)) {
        return std::nullopt;
    }
    PageReader page(bytes);
    GridDescription description;
    page.Get(&description.record, sizeof(description.record));
    page.Get(&description.first, sizeof(description.first));
    page.Get(&description.size, sizeof(description.size));
    page.Get(glm::value_ptr(description.objectFromIndex), sizeof(description.objectFromIndex));
    description.numBricks = static_cast<std::uint32_t>(page.Number());
    description.numComponents = static_cast<std::uint32_t>(page.Number());
    description.id = page.Number();
    GetElements(&page, bytes.size(), &description.tiles);
    GetElements(&page, bytes.size(), &description.cells);
    const bool isWhole = page.IsGood() && page.IsAtEnd();
    return isWhole ? std::optional(std::move(description)) : std::nullopt;
}

} // namespace hds
