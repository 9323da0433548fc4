/* SPDX-License-Identifier: Apache-2.0
 * The residency table, one u32 a page, and the buffer that kernels ask for pages through.
 * Explained in docs/streaming.md. */
#ifndef HDS_SHARED_RESIDENCY_H
#define HDS_SHARED_RESIDENCY_H
#include "shared/compat.h"

/* A word of the table: the page's address in units of 16 bytes, whose bits 28..26 select one of 8
 * buffers of 1 GiB; or HDS_NOT_RESIDENT. */
#define HDS_POOL_UNIT_BYTES 16u
#define HDS_POOL_BUFFER_SHIFT 26
#define HDS_POOL_MAX_BUFFERS 8
#define HDS_NOT_RESIDENT 0x7fffffffu
/* Set beside either, when rays walk again instead of keeping lists (HDS_REQUEST_FIRST): every ray
 * of the present cast has visited the page. */
#define HDS_PAGE_DONE 0x80000000u

/* Most visits to missing chunks that a ray which waits remembers. */
#define HDS_WAIT_LIST 4
/* Of them, those of a closest-hit ray, which walks no further until it has made them. */
#define HDS_WAIT_NEAREST 2

/* The request buffer: a header, then page numbers, each at most once. */
#define HDS_REQUEST_NUM_PAGES 0
#define HDS_REQUEST_EPOCH 1 /* written by the host; counts casts */
#define HDS_REQUEST_HEADER 4
/* Counts of askers end about here. */
#define HDS_REQUEST_MAX_COUNT 0x10000u

#endif
