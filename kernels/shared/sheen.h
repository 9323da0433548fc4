/* SPDX-License-Identifier: Apache-2.0
 * Sheens of closures that a hit chooses from. Some may be fuzz and others not, and some may lie on
 * all but the coat and others on the diffuse part alone, where a material has one set of flags: the
 * roughness of those that are no fuzz is taken from one of these then, and so says which they are.
 * Explained in docs/materials.md. */
#ifndef HDS_SHARED_SHEEN_H
#define HDS_SHARED_SHEEN_H

#define HDS_SHEEN_MARK -8.0f       /* on the diffuse part */
#define HDS_SHEEN_OVER_MARK -16.0f /* on all but the coat */

#endif
