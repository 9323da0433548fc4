// SPDX-License-Identifier: Apache-2.0
// A grid ready to be streamed: what of it is resident, and the lines of its bricks. Explained in
// docs/volumes.md, section "Grids".
#pragma once

#include "hdStream/texture/preparedTexture.h"
#include "hdStream/volume/voxelGrid.h"

#include <memory>
#include <optional>
#include <vector>

namespace hds {

/// All of a prepared grid but its bricks.
struct GridDescription {
    shared::HdsGrid record{}; ///< firstTile, firstCell and texture are the scene's to set
    glm::ivec3 first{0};      ///< as of VoxelGrid
    glm::ivec3 size{0};
    glm::dmat4 objectFromIndex{1.0};
    std::vector<shared::HdsGridTile> tiles;
    std::vector<shared::HdsGridCell> cells;
    std::vector<shared::HdsBrickBounds> bounds; ///< of each brick
    std::uint32_t numBricks = 0;
    std::uint32_t numComponents = 1; ///< of the file's grid, which have a description each
    std::uint64_t id = 0;            ///< of its content
};

/// Immutable. Reading lines is thread-safe.
struct PreparedGrid {
    GridDescription description;
    std::shared_ptr<const PreparedTexture> lines; ///< HDS_BRICK_LINES a brick, at least one
};

/// A grid's description, and its bricks.
struct BuiltGrid {
    GridDescription description;
    std::shared_ptr<LineStore> lines;
};

/// Bricks that `store` (may be null) does not take stay in memory. On all cores. \param key of the
/// grid.
BuiltGrid BuildGrid(const VoxelGrid& grid, const std::shared_ptr<PageStore>& store,
                    const PageKey& key);

/// What a texture of a grid's lines is: nothing but their number counts.
TextureDescription LinesOf(const GridDescription& description);

/// Keeps a description; its lines are in the store already.
void SaveGridDescription(PageStore* store, const PageKey& key, const GridDescription& description);
/// \return empty when it is not there.
std::optional<GridDescription> LoadGridDescription(PageStore* store, const PageKey& key);

} // namespace hds
