/* SPDX-License-Identifier: Apache-2.0
 * A grid of voxels: floats in bricks of 8^3, which are lines of the texture cache, and above them
 * the cells and tiles that say which bricks there are, what the others hold, and how large voxels
 * can be. Voxel (i, j, k) is at the point (i, j, k). Explained in docs/volumes.md. */
#ifndef HDS_SHARED_GRID_H
#define HDS_SHARED_GRID_H
#include "shared/compat.h"

/* Voxels along an edge of a brick, and of a cell. Bricks are where leaf nodes of OpenVDB are. */
#define HDS_BRICK_VOXELS 8
#define HDS_BRICK_VOXELS_LOG2 3
/* Lines of a brick (HDS_LINE_BYTES): x is fastest, then y, then z; line z >> 1 has voxel z. */
#define HDS_BRICK_LINES 4u
/* Voxels along an edge of a block, whose bounds are known where its brick is not. */
#define HDS_BLOCK_VOXELS 2
#define HDS_BLOCK_VOXELS_LOG2 1
#define HDS_BRICK_BLOCKS 4 /* along an edge of a brick */
/* The greatest bound that half a byte can say. */
#define HDS_BLOCK_CODES 15
/* Cells along an edge of a tile. */
#define HDS_TILE_CELLS 8
#define HDS_TILE_VOXELS 64
#define HDS_TILE_VOXELS_LOG2 6

HDS_SHARED_BEGIN
typedef struct {
    u32 brick;      /* number in the grid; HDS_NONE: every voxel has `value` */
    float value;    /* else the mean of those that are in the box of the grid */
    float greatest; /* of the voxels that interpolation inside of the cell reads: its own and the
                       next ones along each axis */
    float least;    /* of the same voxels, or any number from 0 up to that */
} HdsGridCell;
HDS_ASSERT_SIZE(HdsGridCell, 16);

/* Bounds of the voxels of a brick, by blocks of HDS_BLOCK_VOXELS^3: nothing is outside of them.
 * Half a byte n stands for least + step * n. */
typedef struct {
    float least;
    float step;
    u8 blocks[HDS_BRICK_BLOCKS * HDS_BRICK_BLOCKS *
              HDS_BRICK_BLOCKS]; /* x fastest, then y: the least of the block in the lower half, the
                                    greatest in the upper */
} HdsBrickBounds;
HDS_ASSERT_SIZE(HdsBrickBounds, 72);

typedef struct {
    u32 firstCell; /* of its HDS_TILE_CELLS^3, x fastest, among those of the grid; HDS_NONE: every
                      voxel has `value` */
    float value;
    float greatest; /* as of a cell */
    float least;    /* where the tile has no cells; else nothing */
} HdsGridTile;
HDS_ASSERT_SIZE(HdsGridTile, 16);

typedef struct {
    int origin[3];  /* the first voxel of tile 0, a multiple of HDS_TILE_VOXELS */
    u32 tiles[3];   /* along each axis, x fastest */
    u32 firstTile;  /* among those of the scene */
    u32 firstCell;  /* among those of the scene */
    u32 texture;    /* whose lines the bricks are */
    float greatest; /* of all voxels */
    u32 firstBrick; /* of its bounds among those of the scene, if they are read */
    u32 reserved;
} HdsGrid;
HDS_ASSERT_SIZE(HdsGrid, 48);
HDS_SHARED_END
#endif
