/* SPDX-License-Identifier: Apache-2.0
 * The kernels that run once a sample or a pixel, whatever the scene holds, as one program: a
 * program costs its compiler a fifth of a second before it has read a line of it. Explained in
 * docs/wavefront.md. */
#include "film/film.cl"
#include "integrator/generate.cl"
#include "integrator/resolve.cl"
