/* SPDX-License-Identifier: Apache-2.0
 * Brings lines into the texture cache: the host uploads them together, the device spreads them.
 * Launched in this order, so that a line is found only after it has landed. Explained in
 * docs/texturing.md. */
#include "shared/textureCache.h"

/* Vectors of 16 bytes a line. */
#define FILL_VECTORS (HDS_LINE_BYTES / 16u)

/* Global size: numCopies * FILL_VECTORS. From: staging memory. To: one of the pool's buffers.
 * \param firstSlot of the buffer. */
kernel void fill_copyLines(global const uint4* restrict staging,
                           global const HdsLineCopy* restrict copies, uint firstCopy,
                           uint numCopies, uint firstSlot, global uint4* restrict pool) {
    const uint item = (uint)get_global_id(0);
    const uint i = item / FILL_VECTORS;
    const uint vector = item % FILL_VECTORS;
    if (i < numCopies) {
        const HdsLineCopy copy = copies[firstCopy + i];
        pool[(size_t)(copy.slot - firstSlot) * FILL_VECTORS + vector] =
            staging[(size_t)copy.staged * FILL_VECTORS + vector];
    }
}

/* Global size: numUpdates. Words differ. */
kernel void fill_updateTable(global const HdsTableUpdate* restrict updates, uint numUpdates,
                             global uint* restrict table) {
    const uint i = (uint)get_global_id(0);
    if (i < numUpdates) {
        table[updates[i].word] = updates[i].value;
    }
}
