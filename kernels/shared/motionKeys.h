/* SPDX-License-Identifier: Apache-2.0
 * How the device inverts what lies between the keys of an instance. Explained in
 * docs/motionBlur.md, section "Transforms". */
#ifndef HDS_SHARED_MOTION_KEYS_H
#define HDS_SHARED_MOTION_KEYS_H

/* In the word HDS_MOTION_SEGMENTS of objectFromParent, above the number. */
#define HDS_MOTION_SLIDES 0x80000000u /* keys differ by translations alone */
#define HDS_MOTION_PLAIN 0x40000000u  /* transform_inversePlain is good for all between the keys */
#define HDS_MOTION_FORMS 0xc0000000u
/* Of what slides objectFromParent holds from here on the inverse of the linear part, 3 rows of 3,
 * so that the device inverts nothing. */
#define HDS_MOTION_INVERSE 3

/* Plain are maps whose columns have lengths from 1 / this to this, with a product of at most
 * HDS_MOTION_MOST_SHEAR determinants. */
#define HDS_MOTION_MOST_SIZE 1073741824.0 /* 2^30 */
#define HDS_MOTION_MOST_SHEAR 2.0

#endif
