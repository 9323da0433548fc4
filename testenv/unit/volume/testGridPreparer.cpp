// SPDX-License-Identifier: Apache-2.0
// Grids cut into cells, tiles and bricks, and kept in the persistent store.
#include "hdStream/volume/gridPreparer.h"

#include "hdStream/volume/brickBounds.h"

#include "testenv/support/temporaryFolder.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

namespace hds::test {
namespace {

constexpr int kVoxels = HDS_BRICK_VOXELS;

/// A value of a voxel that differs from its neighbours', with holes; rough, so that what is least
/// in a cell and its neighbours may lie anywhere.
float Made(glm::ivec3 voxel) {
    const double wave = std::sin(0.3 * voxel.x) + std::cos(0.2 * voxel.y - 0.1 * voxel.z);
    const double rough = std::sin(12.9898 * voxel.x + 78.233 * voxel.y + 37.719 * voxel.z);
    return wave > 0.0 ? static_cast<float>(wave * (1.5 + rough)) : 0.0F;
}

VoxelGrid MakeWaves(glm::ivec3 first, glm::ivec3 size) {
    std::vector<float> values;
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                values.push_back(Made(first + glm::ivec3(x, y, z)));
            }
        }
    }
    return MakeVoxelGrid(values.data(), first, size, glm::dmat4(1.0));
}

/// What kernels/volume/voxels.clh finds, in plain words.
struct Found {
    float value = 0.0F;
    float greatest = 0.0F;
    float least = 0.0F;
    bool hasBrick = false;
    float mean = 0.0F;  ///< of a cell with a brick
    float lower = 0.0F; ///< that the bounds of the voxel's block say, and beside that the next
    float upper = 0.0F; ///< numbers within, which are no bounds
    float aboveLower = 0.0F;
    float belowUpper = 0.0F;
};

/// What half a byte of bounds stands for.
float Bound(const shared::HdsBrickBounds& bounds, int code) {
    return bounds.least + bounds.step * static_cast<float>(code);
}

/// The bounds of the block of a voxel of a brick, in plain words.
void FindBounds(const shared::HdsBrickBounds& bounds, glm::ivec3 inside, Found* found) {
    const glm::ivec3 block = inside / HDS_BLOCK_VOXELS;
    const int codes =
        bounds.blocks[(block.z * HDS_BRICK_BLOCKS + block.y) * HDS_BRICK_BLOCKS + block.x];
    found->lower = Bound(bounds, codes & 15);
    found->upper = Bound(bounds, codes >> 4);
    found->aboveLower = Bound(bounds, (codes & 15) + 1);
    found->belowUpper = Bound(bounds, (codes >> 4) - 1);
}

Found Find(const PreparedGrid& grid, glm::ivec3 voxel) {
    const GridDescription& description = grid.description;
    const auto* origin = description.record.origin;
    const glm::ivec3 at = voxel - glm::ivec3(origin[0], origin[1], origin[2]);
    const glm::ivec3 tileAt = at / HDS_TILE_VOXELS;
    const auto* tiles = description.record.tiles;
    const shared::HdsGridTile& tile =
        description.tiles[(tileAt.z * tiles[1] + tileAt.y) * tiles[0] + tileAt.x];
    if (tile.firstCell == HDS_NONE) {
        return {tile.value, tile.greatest, tile.least};
    }
    const glm::ivec3 cellAt = at % HDS_TILE_VOXELS / kVoxels;
    const shared::HdsGridCell& cell =
        description.cells[tile.firstCell + (cellAt.z * HDS_TILE_CELLS + cellAt.y) * HDS_TILE_CELLS +
                          cellAt.x];
    if (cell.brick == HDS_NONE) {
        return {cell.value, cell.greatest, cell.least};
    }
    const glm::ivec3 inside = at % kVoxels;
    const int place = (inside.z * kVoxels + inside.y) * kVoxels + inside.x;
    TextureLine line;
    EXPECT_TRUE(grid.lines->ReadLine(cell.brick * HDS_BRICK_LINES + place / 128, &line));
    float value = 0.0F;
    std::memcpy(&value, &line[place % 128], sizeof(value));
    Found found{value, cell.greatest, cell.least, true, cell.value};
    FindBounds(description.bounds[cell.brick], inside, &found);
    return found;
}

/// Every voxel has its value, and every cell bounds of those that it interpolates, as tight as can
/// be.
void ExpectWaves(const PreparedGrid& grid) {
    const GridDescription& description = grid.description;
    const glm::ivec3 end = description.first + description.size;
    const auto valueAt = [&](glm::ivec3 voxel) {
        const bool isInside = glm::all(glm::greaterThanEqual(voxel, description.first)) &&
                              glm::all(glm::lessThan(voxel, end));
        return isInside ? Made(voxel) : 0.0F;
    };
    // By the first voxel of a cell: the least and the greatest that it interpolates.
    const auto boundsAt = [&](glm::ivec3 cell) {
        std::pair<float, float> bounds(valueAt(cell), valueAt(cell));
        for (int i = 0; i < (kVoxels + 1) * (kVoxels + 1) * (kVoxels + 1); ++i) {
            const float value =
                valueAt(cell + glm::ivec3(i % (kVoxels + 1), i / (kVoxels + 1) % (kVoxels + 1),
                                          i / (kVoxels + 1) / (kVoxels + 1)));
            bounds = {std::min(bounds.first, value), std::max(bounds.second, value)};
        }
        return bounds;
    };
    // Bricks' cells have the mean of what is in the box.
    const auto meanOf = [&](glm::ivec3 cell) {
        double sum = 0.0;
        int count = 0;
        for (int i = 0; i < kVoxels * kVoxels * kVoxels; ++i) {
            const glm::ivec3 voxel =
                cell + glm::ivec3(i % kVoxels, i / kVoxels % kVoxels, i / kVoxels / kVoxels);
            sum += valueAt(voxel);
            count += glm::all(glm::greaterThanEqual(voxel, description.first)) &&
                     glm::all(glm::lessThan(voxel, end));
        }
        return sum / count;
    };
    // Of the block of a voxel, as much as is in the cell: voxels beyond the box are 0.
    const auto blockAt = [&](glm::ivec3 voxel) {
        const glm::ivec3 block = voxel & ~(HDS_BLOCK_VOXELS - 1);
        std::pair<float, float> bounds(valueAt(block), valueAt(block));
        for (int i = 1; i < 8; ++i) {
            const float value = valueAt(block + glm::ivec3(i & 1, i >> 1 & 1, i >> 2));
            bounds = {std::min(bounds.first, value), std::max(bounds.second, value)};
        }
        return bounds;
    };
    int numTight = 0;
    for (int z = description.first.z - 1; z <= end.z; ++z) {
        for (int y = description.first.y - 1; y <= end.y; ++y) {
            for (int x = description.first.x - 1; x <= end.x; ++x) {
                const Found found = Find(grid, {x, y, z});
                ASSERT_EQ(found.value, valueAt({x, y, z})) << x << " " << y << " " << z;
                if (found.hasBrick) {
                    const auto [least, greatest] = blockAt({x, y, z});
                    ASSERT_LE(found.lower, least);
                    ASSERT_GT(found.aboveLower, least);
                    ASSERT_GE(found.upper, greatest);
                    ASSERT_LT(found.belowUpper, greatest);
                    numTight += found.upper - found.lower < 0.5F * (found.greatest - found.least);
                }
                for (int corner = 0; corner < 8; ++corner) {
                    const glm::ivec3 next(x + (corner & 1), y + (corner >> 1 & 1),
                                          z + (corner >> 2 & 1));
                    ASSERT_LE(valueAt(next), found.greatest);
                    ASSERT_GE(valueAt(next), found.least);
                    ASSERT_LE(found.greatest, description.record.greatest);
                }
                if ((x & (kVoxels - 1)) == 0 && (y & (kVoxels - 1)) == 0 &&
                    (z & (kVoxels - 1)) == 0) {
                    ASSERT_EQ(std::pair(found.least, found.greatest), boundsAt({x, y, z}));
                    if (found.hasBrick) {
                        ASSERT_NEAR(found.mean, meanOf({x, y, z}), 1e-5);
                    }
                }
            }
        }
    }
    EXPECT_GT(numTight, 0);
}

TEST(GridPreparer, BoundsBricksOfAnyNumbers) {
    for (const float scale : {1e-38F, 1e-30F, 1e-3F, 1.0F, 3e38F}) {
        for (const float offset : {0.0F, 1e-38F, 0.25F, 1e6F}) {
            VoxelBrick brick;
            for (int i = 0; i < static_cast<int>(brick.size()); ++i) {
                brick[i] = std::min(offset + scale * std::abs(Made({i, 3 * i, 7 * i})) / 4.0F,
                                    std::numeric_limits<float>::max());
            }
            const shared::HdsBrickBounds bounds = BoundBrick(brick);
            for (int i = 0; i < static_cast<int>(brick.size()); ++i) {
                Found found;
                FindBounds(bounds, {i % kVoxels, i / kVoxels % kVoxels, i / kVoxels / kVoxels},
                           &found);
                ASSERT_LE(found.lower, brick[i]) << scale << " " << offset << " " << i;
                ASSERT_GE(found.upper, brick[i]) << scale << " " << offset << " " << i;
            }
        }
    }
}

TEST(GridPreparer, CutsGridsInMemory) {
    GridPreparer preparer(nullptr);
    for (const glm::ivec3& first : {glm::ivec3(0), glm::ivec3(-13, 5, 62)}) {
        const auto grids =
            preparer.Prepare(std::make_shared<const VoxelGrid>(MakeWaves(first, {70, 40, 9})));
        ASSERT_EQ(grids.size(), 1U);
        ExpectWaves(*grids[0]);
    }
}

TEST(GridPreparer, HasNoBrickWhereAllIsAlike) {
    GridPreparer preparer(nullptr);
    const std::vector<float> ones(64 * 64 * 64, 1.0F);
    const auto grids = preparer.Prepare(std::make_shared<const VoxelGrid>(
        MakeVoxelGrid(ones.data(), {0, 0, 0}, {64, 64, 64}, glm::dmat4(1.0))));
    EXPECT_EQ(grids[0]->description.numBricks, 0U);
    EXPECT_EQ(Find(*grids[0], {20, 63, 0}).value, 1.0F);
}

class GridFiles : public ::testing::Test {
protected:
    void SetUp() override {
        openvdb::initialize();
        const auto grid = openvdb::FloatGrid::create();
        grid->setName("density");
        for (int z = 0; z < 30; ++z) {
            for (int y = 0; y < 20; ++y) {
                for (int x = 0; x < 50; ++x) {
                    grid->tree().setValue({x, y, z}, Made({x, y, z}));
                }
            }
        }
        const auto colour = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0F));
        colour->setName("Cd");
        colour->tree().setValue({1, 2, 3}, {1.0F, 2.0F, 3.0F});
        openvdb::io::File(Request().file).write({grid, colour});
    }

    VdbRequest Request(const std::string& grid = "density") const {
        return {_folder.Path() + "/grids.vdb", 0, grid, 0};
    }
    std::shared_ptr<PageStore> Open() const {
        return std::make_shared<PageStore>(PageStoreOptions{_folder.Path() + "/cache"}, nullptr);
    }

    TemporaryFolder _folder;
};

TEST_F(GridFiles, AreKept) {
    std::string error;
    std::uint64_t id = 0;
    for (const std::uint64_t expectedSaves : {2U, 0U}) { // a group of lines, and the description
        const auto store = Open();
        GridPreparer preparer(store);
        const auto grids = preparer.Prepare(Request(), 0, &error);
        ASSERT_EQ(grids.size(), 1U) << error;
        ExpectWaves(*grids[0]);
        EXPECT_EQ(store->Statistics().pagesSaved > 0, expectedSaves > 0);
        EXPECT_EQ(grids[0]->lines->HostBytes(), 0U);
        EXPECT_TRUE(id == 0 || id == grids[0]->description.id);
        id = grids[0]->description.id;
        EXPECT_EQ(preparer.Prepare(Request(), 0, &error), grids);
    }
}

TEST_F(GridFiles, HaveAllComponentsFromTheStore) {
    std::string error;
    for (int i = 0; i < 2; ++i) {
        GridPreparer preparer(Open());
        const auto grids = preparer.Prepare(Request("Cd"), 0, &error);
        ASSERT_EQ(grids.size(), 3U) << error;
        for (int component = 0; component < 3; ++component) {
            EXPECT_EQ(Find(*grids[component], {1, 2, 3}).value, 1.0F + component);
        }
    }
}

TEST_F(GridFiles, AreReadAgainWhenThePagesAreDamaged) {
    std::string error;
    const auto store = Open();
    GridPreparer preparer(store);
    const auto grids = preparer.Prepare(Request(), 0, &error);
    store->Clear();
    ExpectWaves(*grids[0]);
}

TEST_F(GridFiles, AreOtherGridsWhenTheFileChanges) {
    std::string error;
    GridPreparer preparer(Open());
    const auto before = preparer.Prepare(Request(), 0, &error);
    const auto other = openvdb::FloatGrid::create();
    other->setName("density");
    other->tree().setValue({1, 1, 1}, 9.0F);
    openvdb::io::File(Request().file).write({other});
    const auto after = preparer.Prepare(Request(), 0, &error);
    ASSERT_EQ(after.size(), 1U) << error;
    EXPECT_EQ(Find(*after[0], {1, 1, 1}).value, 9.0F);
    EXPECT_NE(before[0]->description.id, after[0]->description.id);
}

TEST_F(GridFiles, AreForgottenWhenNobodyAsksForThem) {
    std::string error;
    GridPreparer preparer(nullptr);
    const std::weak_ptr<const PreparedGrid> grid = preparer.Prepare(Request(), 0, &error)[0];
    preparer.ForgetUnused();
    EXPECT_FALSE(grid.expired());
    preparer.ForgetUnused();
    EXPECT_TRUE(grid.expired());
}

} // namespace
} // namespace hds::test
