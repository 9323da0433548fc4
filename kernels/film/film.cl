/* SPDX-License-Identifier: Apache-2.0
 * Reads the film: means for display, and which pixels have met their error.
 * Explained in docs/film.md. */
#include "film/filmPixel.clh"

/* Writes the sampled AOVs of those pixels whose coordinates are multiples of `stride`, one after
 * another; offsets are values inside a pixel of `floats` or `ints`, HDS_NONE: not asked for. Global
 * size: number of these pixels, which are numAcross in a row. */
kernel void film_develop(global const HdsFilmPixel* film, uint numPixels, uint width,
                         uint numAcross, uint stride, global float* floats, uint floatStride,
                         global int* ints, uint intStride, uint colorOffset, uint alphaOffset,
                         uint varianceOffset, uint countOffset, uint noisyOffset) {
    uint i = (uint)get_global_id(0);
    if (i >= numPixels) {
        return;
    }
    HdsFilmPixel pixel = film[i / numAcross * stride * width + i % numAcross * stride];
    global float* target = floats + (size_t)i * floatStride;
    float4 mean = filmPixel_mean(&pixel);
    if (colorOffset != HDS_NONE) {
        vstore4(mean, 0, target + colorOffset);
    }
    if (noisyOffset != HDS_NONE) {
        vstore4(mean, 0, target + noisyOffset);
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

#if HDS_FEATURE_OCCLUSION
/* Writes the mean of ambient occlusion as film_develop does colour. */
kernel void film_developOcclusion(global const HdsFilmPixel* film,
                                  global const HdsLightPathPixel* sums, uint firstSum,
                                  uint numPixels, uint width, uint numAcross, uint stride,
                                  global float* floats, uint floatStride, uint offset) {
    const uint i = (uint)get_global_id(0);
    if (i >= numPixels) {
        return;
    }
    const uint at = i / numAcross * stride * width + i % numAcross * stride;
    const HdsLightPathPixel pixel = sums[(size_t)firstSum + at];
    const uint count = film[at].numSamples;
    floats[(size_t)i * floatStride + offset] =
        count > 0u ? (pixel.sum.x + pixel.blockSum.x) / (float)count : 0.0f;
}
#endif

#if HDS_FEATURE_CATCHERS
/* Adds what catchers show to what film_develop has written: alpha for the light that others take
 * from them, colour for the light that others add. \param firstSum as resolve_addCatchers has it.
 */
kernel void film_developCatchers(global const HdsFilmPixel* film,
                                 global const HdsLightPathPixel* sums, uint firstSum,
                                 uint numFilmPixels, uint numPixels, uint width, uint numAcross,
                                 uint stride, global float* floats, uint floatStride,
                                 uint colorOffset, uint alphaOffset, uint noisyOffset) {
    const uint i = (uint)get_global_id(0);
    if (i >= numPixels) {
        return;
    }
    const uint at = i / numAcross * stride * width + i % numAcross * stride;
    const HdsLightPathPixel pixels[2] = {sums[(size_t)firstSum + at],
                                         sums[(size_t)firstSum + numFilmPixels + at]};
    const float4 lit = pixels[0].sum + pixels[0].blockSum;
    if (!(lit.w > 0.0f)) {
        return;
    }
    const float4 added =
        filmPixel_caught(lit, (pixels[1].sum + pixels[1].blockSum).xyz, film[at].numSamples);
    global float* target = floats + (size_t)i * floatStride;
    if (colorOffset != HDS_NONE) {
        vstore4(vload4(0, target + colorOffset) + added, 0, target + colorOffset);
    }
    if (noisyOffset != HDS_NONE) {
        vstore4(vload4(0, target + noisyOffset) + added, 0, target + noisyOffset);
    }
    if (alphaOffset != HDS_NONE) {
        target[alphaOffset] += added.w;
    }
}
#endif

/* Writes a light path expression as film_develop does colour, or the variance of its mean.
 * \param firstSum of the expression in `sums`. */
kernel void film_developLightPath(global const HdsFilmPixel* film,
                                  global const HdsLightPathPixel* sums, uint firstSum,
                                  uint numPixels, uint width, uint numAcross, uint stride,
                                  global float* floats, uint floatStride, uint offset,
                                  uint isVariance) {
    const uint i = (uint)get_global_id(0);
    if (i >= numPixels) {
        return;
    }
    const uint at = i / numAcross * stride * width + i % numAcross * stride;
    const HdsLightPathPixel pixel = sums[(size_t)firstSum + at];
    const uint count = film[at].numSamples;
    if (isVariance != 0u) {
        floats[(size_t)i * floatStride + offset] = filmPixel_lightPathVariance(&pixel, count);
        return;
    }
    const float3 mean =
        count > 0u ? (pixel.sum + pixel.blockSum).xyz / (float)count : (float3)(0.0f);
    vstore3(mean, 0, floats + (size_t)i * floatStride + offset);
}

/* Pixels on each side of one that film_relativeError looks at, and what a pixel counts by itself.
 */
#define HDS_ERROR_RADIUS 2
#define HDS_ERROR_OWN_SHARE 0.25f

/* filmPixel_relativeVariance of each pixel. Global size: numPixels. */
kernel void film_relativeVariance(global const HdsFilmPixel* film, uint numPixels,
                                  global float* variances) {
    uint i = (uint)get_global_id(0);
    if (i < numPixels) {
        const HdsFilmPixel pixel = film[i];
        variances[i] = filmPixel_relativeVariance(&pixel);
    }
}

#if HDS_FEATURE_CATCHERS
/* Adds filmPixel_caughtVariance to those of film_relativeVariance. Global size: numPixels. */
kernel void film_addCaughtVariance(global const HdsFilmPixel* film,
                                   global const HdsLightPathPixel* sums, uint firstSum,
                                   uint numPixels, global float* variances) {
    const uint i = (uint)get_global_id(0);
    if (i < numPixels) {
        const HdsLightPathPixel lit = sums[(size_t)firstSum + i];
        const HdsLightPathPixel unshadowed = sums[(size_t)firstSum + numPixels + i];
        variances[i] += filmPixel_caughtVariance(&lit, &unshadowed, film[i].numSamples);
    }
}
#endif

/* Their mean over the window around a pixel. */
float film_windowVariance(global const float* variances, int2 size, int2 at) {
    const int2 from = max(at - HDS_ERROR_RADIUS, 0);
    const int2 to = min(at + HDS_ERROR_RADIUS, size - 1);
    float sum = 0.0f;
    for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) {
            sum += variances[y * size.x + x];
        }
    }
    return sum / (float)((to.x - from.x + 1) * (to.y - from.y + 1));
}

/* Relative error of each listed pixel, the root of what it adds to relMSE (docs/film.md):
 * standard error of the mean over sqrt(mean^2 + 0.01), of luminance. A few blocks of one pixel say
 * little about its variance, and nothing of a bright path that it has not met: it is the mean of a
 * window of pixels, or a quarter of the pixel's own where that is more (a line thinner than the
 * window). `variances` are of film_relativeVariance. Global size: numPixels. */
kernel void film_relativeError(global const HdsFilmPixel* film, global const float* variances,
                               int width, int height, global const uint* pixels, uint numPixels,
                               global float* errors) {
    uint i = (uint)get_global_id(0);
    if (i >= numPixels) {
        return;
    }
    const uint index = pixels[i];
    const int2 at = (int2)((int)(index % (uint)width), (int)(index / (uint)width));
    const float variance = fmax(HDS_ERROR_OWN_SHARE * variances[index],
                                film_windowVariance(variances, (int2)(width, height), at));
    errors[i] = sqrt(variance / fmax((float)film[index].numSamples, 1.0f));
}

/* Adds the sums of the block that follows to each pixel: `film` is at its first sample. Global
 * size: numPixels. */
kernel void film_addBlock(global HdsFilmPixel* film, global const HdsFilmPixel* block,
                          uint numPixels) {
    uint i = (uint)get_global_id(0);
    if (i >= numPixels) {
        return;
    }
    HdsFilmPixel pixel = film[i];
    const HdsFilmPixel added = block[i];
    filmPixel_addBlock(&pixel, &added);
    film[i] = pixel;
}

/* film_addBlock for the sums beside colour, the first numLightPaths of which are those of light
 * path expressions. Global size: numPixels * count. \param block [numPixels] film of the block.
 * \param sums, blockSums [count][numPixels] */
kernel void film_addLightPathBlock(global const HdsFilmPixel* block, uint numPixels, uint count,
                                   uint numLightPaths, global HdsLightPathPixel* sums,
                                   global const HdsLightPathPixel* blockSums) {
    const uint i = (uint)get_global_id(0);
    if (i >= numPixels * count) {
        return;
    }
    HdsLightPathPixel pixel = sums[i];
    const HdsLightPathPixel added = blockSums[i];
    pixel.blockSum = added.sum + added.blockSum;
    const uint numSamples = block[i % numPixels].numSamples;
    if (i / numPixels < numLightPaths) {
        filmPixel_closeLightPath(&pixel, numSamples);
    } else {
        filmPixel_closeSum(&pixel, numSamples);
    }
    sums[i] = pixel;
}
