/* SPDX-License-Identifier: Apache-2.0
 * The texture cache as kernels and the host see it: slots for lines, the table that finds them, and
 * the buffer that kernels ask for lines through. Explained in docs/texturing.md. */
#ifndef HDS_SHARED_TEXTURE_CACHE_H
#define HDS_SHARED_TEXTURE_CACHE_H
#include "shared/texture.h"

/* A slot is a place for a line; bits 23..21 select one of 8 buffers of 1 GiB. */
#define HDS_SLOT_BUFFER_SHIFT 21
#define HDS_SLOT_MAX_BUFFERS 8

/* The table: word (line >> HDS_LINE_PAGE_SHIFT) says at which word a page begins that has the slots
 * of so many lines, or HDS_NONE for each. One page without any line stands for all of which none
 * has been loaded. When all lines are there, slots are lines and there is no table. */
#define HDS_LINE_PAGE_SHIFT 8
#define HDS_LINE_PAGE_WORDS (1u << HDS_LINE_PAGE_SHIFT)

/* HdsTexture.flags: nobody has opened it yet; the record is that of a texture of one texel. */
#define HDS_TEXTURE_CLOSED 0x80000000u

/* A request is the number of a line, or with this bit that of a texture which is to be opened. */
#define HDS_REQUEST_TEXTURE 0x80000000u

/* The request buffer, u32 each: what the host says; what kernels count; the list of requests; and
 * the same requests as a set (open addressing), so that each is listed once. */
/* Stamp of the lines that are used now; 0: there are no stamps, for no line will ever leave. */
#define HDS_TEXELS_EPOCH 0
/* Not 0: a coarser mip will do where a line is missing. */
#define HDS_TEXELS_ACCEPT_COARSER_MIPS 1
#define HDS_TEXELS_CAPACITY 2  /* requests that the list holds */
#define HDS_TEXELS_SET_BEGIN 3 /* word at which the set begins */
#define HDS_TEXELS_SET_MASK 4  /* words of the set, a power of two, less 1 */
/* From here on kernels write: every look-up reads what is above, so that has a cache line to
 * itself. */
#define HDS_TEXELS_NUM_REQUESTS 16  /* may exceed the capacity */
#define HDS_TEXELS_NUM_DROPPED 17   /* requests that found no place */
#define HDS_TEXELS_NUM_FALLBACKS 18 /* texels of a coarser mip that were accepted */
#define HDS_TEXELS_LOOKUPS 32       /* [HDS_TEXELS_COUNTERS], by work-items: texels read */
#define HDS_TEXELS_MISSES \
    64 /* [HDS_TEXELS_COUNTERS], by work-items: texels whose line was missing */
#define HDS_TEXELS_COUNTERS 32u
#define HDS_TEXELS_HEADER 96 /* here the list begins */
/* Words of the set that a request tries. */
#define HDS_TEXELS_PROBES 8u

HDS_SHARED_BEGIN
/* A line on its way from staging memory to its slot. */
typedef struct {
    u32 staged; /* its place in staging memory, in lines */
    u32 slot;
} HdsLineCopy;
HDS_ASSERT_SIZE(HdsLineCopy, 8);

/* A word of the table that changes. */
typedef struct {
    u32 word;
    u32 value;
} HdsTableUpdate;
HDS_ASSERT_SIZE(HdsTableUpdate, 8);
HDS_SHARED_END
#endif
