/* SPDX-License-Identifier: Apache-2.0
 * Bounds of what a Gaussian splat covers: those of Kerbl et al. 2023, "3D Gaussian Splatting for
 * Real-Time Radiance Field Rendering", appendix C. Explained in docs/splats.md. */
#ifndef HDS_SHARED_SPLAT_H
#define HDS_SHARED_SPLAT_H

#define HDS_SPLAT_LEAST_ALPHA (1.0f / 255.0f) /* a splat ends where it covers less */
#define HDS_SPLAT_MOST_ALPHA 0.99f
#define HDS_SPLAT_MAX_DEGREE 3u /* of spherical harmonics */

#endif
