// SPDX-License-Identifier: Apache-2.0
#include "hdStream/volume/preparedGrid.h"

#include "hdStream/persist/pageBytes.h"
#include "hdStream/volume/brickBounds.h"
#include "hdStream/volume/gridTiles.h"

#include <glm/gtc/type_ptr.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

namespace hds {

namespace {

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

/// The cell from voxel `first` on, with the number of its brick in the source.
shared::HdsGridCell MakeCell(const VoxelGrid& source, glm::ivec3 first) {
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
            cell.brick = brick;
        }
    }
    return cell;
}

/// Numbers bricks in the order of the cells. \return their numbers in the source.
std::vector<std::uint32_t> NumberBricks(std::vector<shared::HdsGridCell>* cells) {
    std::vector<std::uint32_t> bricks;
    for (shared::HdsGridCell& cell : *cells) {
        if (cell.brick != HDS_NONE) {
            bricks.push_back(std::exchange(cell.brick, static_cast<std::uint32_t>(bricks.size())));
        }
    }
    return bricks;
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
    GridTiles made = MakeGridTiles(grid.first - 1, grid.first + grid.size,
                                   [&](glm::ivec3 voxel) { return MakeCell(grid, voxel); });
    description.record = made.record;
    description.tiles = std::move(made.tiles);
    description.cells = std::move(made.cells);
    const std::vector<std::uint32_t> bricks = NumberBricks(&description.cells);
    description.numBricks = static_cast<std::uint32_t>(bricks.size());
    description.bounds.resize(bricks.size());
    tbb::parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
        description.bounds[i] = BoundBrick(grid.bricks[bricks[i]]);
    });
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
    AddElements(&page, description.bounds);
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
    GetElements(&page, bytes.size(), &description.bounds);
    const bool isWhole =
        page.IsGood() && page.IsAtEnd() && description.bounds.size() == description.numBricks;
    return isWhole ? std::optional(std::move(description)) : std::nullopt;
}

} // namespace hds
