/* SPDX-License-Identifier: Apache-2.0
 * Reads the film: means for display, and which pixels have met their error.
 * Explained in docs/film.md. */
#include "film/filmPixel.clh"

/* Writes the sampled AOVs of each pixel; offsets are values inside a pixel of `floats` or `ints`,
 * HDS_NONE: not asked for. Global size: number of pixels. */
kernel void film_develop(global const HdsFilmPixel* film, uint numPixels, global float* floats,
                         uint floatStride, global int* ints, uint intStride, uint colorOffset,
                         uint alphaOffset, uint varianceOffset, uint countOffset) {
    uint i = (uint)get_global_id(0);
    if (i >= numPixels) {
        return;
    }
    HdsFilmPixel pixel = film[i];
    global float* target = floats + (size_t)i * floatStride;
    float4 mean = filmPixel_mean(&pixel);
    if (colorOffset != HDS_NONE) {
        vstore4(mean, 0, target + colorOffset);
    }
    if (alphaOffset != HDS_NONE) {
        target[alphaOffset] = mean.w;
    }
    if (varianceOffset != HDS_NONE) {
        target[varianceOffset] = filmPixel_variance(&pixel);
    }
    if (countOffset != HDS_NONE) {
        ints[(size_t)i * intStride + countOffset] = (int)pixel.numSamples;
    }
}

/* Relative error of each listed pixel, the root of what it adds to relMSE (DESIGN.md section 10):
 * standard error of the mean over sqrt(mean^2 + 0.01), of luminance. Global size: numPixels. */
kernel void film_relativeError(global const HdsFilmPixel* film, global const uint* pixels,
                               uint numPixels, global float* errors) {
    uint i = (uint)get_global_id(0);
    if (i >= numPixels) {
        return;
    }
    HdsFilmPixel pixel = film[pixels[i]];
    float mean = vec_luminance(filmPixel_mean(&pixel).xyz);
    errors[i] = sqrt(filmPixel_variance(&pixel) / fma(mean, mean, 0.01f));
}
