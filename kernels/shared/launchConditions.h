/* SPDX-License-Identifier: Apache-2.0
 * How rays are launched, where several features decide it. Evaluated as the conditions of
 * shared/pathConditions.h are. */
#ifndef HDS_SHARED_LAUNCH_CONDITIONS_H
#define HDS_SHARED_LAUNCH_CONDITIONS_H

/* A shadow ray passes all that lets it through in one launch: nothing on its way can be missing.
 * Two launches a surface, and the waits between them, are for what streams. */
#define HDS_PASSES_SHADOWS_AT_ONCE \
    (HDS_FEATURE_CUTOUT && !HDS_FEATURE_STREAMING && !HDS_FEATURE_TEXTURE_STREAMING)
/* There no candidate waits, and this counts the rays that go on behind a surface. */
#define HDS_COUNTER_PASSED HDS_COUNTER_WAITING_CANDIDATES

#endif
