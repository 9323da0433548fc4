/* SPDX-License-Identifier: Apache-2.0
 * The residency table, one u32 a page, and the uses, another: what kernels tell of a page. With
 * HDS_FEATURE_PAGE_HASH both are hash tables, whose size does not grow with the pages that there
 * are. Explained in docs/streaming.md. */
#ifndef HDS_SHARED_RESIDENCY_H
#define HDS_SHARED_RESIDENCY_H
#include "shared/compat.h"

/* A word of the table: the page's address in units of 16 bytes, whose bits 28..26 select one of 8
 * buffers of 1 GiB; or HDS_NOT_RESIDENT. */
#define HDS_POOL_UNIT_BYTES 16u
#define HDS_POOL_BUFFER_SHIFT 26
#define HDS_POOL_MAX_BUFFERS 8
#define HDS_NOT_RESIDENT 0x7fffffffu

/* Most pending chunks that a ray which waits remembers. */
#define HDS_WAIT_LIST 4
/* Of them, those of a closest-hit ray, which walks no further until it has entered them. */
#define HDS_WAIT_NEAREST 2

/* The uses: a header, then a word a page. Of a page that is resident, the epoch of its last use. Of
 * one that is missing, how many have asked for it, and beside that HDS_ASKED_WHOLE. */
/* The present epoch: written by the host, counts ray batches and rounds of requests. */
#define HDS_USE_EPOCH 0
/* With instance chunks: the way of a ray that waits, all pages that it needs at once, so that they
 * can be placed together. The first who finds HDS_USE_WAY 0 sets it, and writes
 * HDS_WAY_PAGES pages behind it, HDS_NONE for none. */
#define HDS_USE_WAY 4
#define HDS_WAY_PAGES 3
/* With hash tables: number of buckets of the table of requests less 1, and how many requests found
 * their bucket full since the host has read them. */
#define HDS_USE_ASKED_MASK 8
#define HDS_USE_DROPPED 9
#define HDS_USE_HEADER \
    16 /* 64 bytes: every use reads the epoch, so it has a cache line to itself */
/* Hash tables are buckets of HDS_BUCKET_PAGES pages and as many words of theirs, a cache line. The
 * residency table: behind a header, whose first word is its number of buckets less 1, entries of
 * pages (HDS_NONE: none, and none behind it) with addresses. A page that finds its bucket full is
 * in one of the next. The uses: behind the header a word an entry of the residency table, then the
 * table of requests, with pages + 1 (0: none) and counts of askers; one that finds its bucket full
 * is dropped. */
#define HDS_BUCKET_PAGES 8u
#define HDS_BUCKET_WORDS (2u * HDS_BUCKET_PAGES)
#define HDS_HASH_HEADER 16u
/* The bucket of a page. */
#define HDS_HASH_BUCKET(page, mask) ((page)*0x9e3779b1u >> 8u & (mask))

/* Counts of askers end about here. */
#define HDS_ASKED_MAX 0x10000u
/* The page is asked for with the whole of its group. */
#define HDS_ASKED_WHOLE 0x80000000u

#endif
