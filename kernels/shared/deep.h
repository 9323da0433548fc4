/* SPDX-License-Identifier: Apache-2.0
 * What a camera ray ends on that is no surface, for a deep picture: in place of the material entry
 * in the field `matte` of the path state, whose prim is HDS_NONE. Explained in docs/film.md. */
#ifndef HDS_SHARED_DEEP_H
#define HDS_SHARED_DEEP_H

#define HDS_DEEP_LIGHT 1u
#define HDS_DEEP_VOLUME 2u

#endif
