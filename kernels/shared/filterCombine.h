/* SPDX-License-Identifier: Apache-2.0
 * How a light filter joins the others of its light: a part of HdsLightFilter.type, beside its kind.
 * Shared by hdStream/shading/lightFilter.cpp and kernels/light/filter.clh. Explained in
 * docs/lights.md, "Filters". */
#ifndef HDS_SHARED_FILTER_COMBINE_H
#define HDS_SHARED_FILTER_COMBINE_H

#define HDS_COMBINE_SHIFT 8u
#define HDS_COMBINE_MULTIPLY 0u
#define HDS_COMBINE_MAX 1u
#define HDS_COMBINE_MIN 2u
#define HDS_COMBINE_SCREEN 3u

#endif
