/* SPDX-License-Identifier: Apache-2.0
 * Instances whose keys differ by translations alone: the inverse of their linear part, which all
 * keys have, is in their record, so that the device inverts nothing. Explained in
 * docs/motionBlur.md, section "Transforms". */
#ifndef HDS_SHARED_MOTION_KEYS_H
#define HDS_SHARED_MOTION_KEYS_H

/* In the word HDS_MOTION_SEGMENTS of objectFromParent, above the number. */
#define HDS_MOTION_SLIDES 0x80000000u
/* Then objectFromParent holds from here on 3 rows of 3. */
#define HDS_MOTION_INVERSE 3

#endif
