/* SPDX-License-Identifier: Apache-2.0
 * Adds the samples of a finished wave to the film, one work-item a pixel, in the order of samples:
 * the sums do not depend on how samples were spread over waves. From: path radiance; while rays
 * keep lists, where slots are used again, the sums of paths. To: film, of which nothing is read
 * where a pixel has its first sample: it may hold a render before. Explained in docs/film.md. */
#include "film/filmPixel.clh"
#include "integrator/lightPaths.clh"
#include "integrator/pathState.clh"

#if HDS_WAIT_LISTS
/* Global size: count. Keeps what paths that have ended have gathered, by their numbers in the wave.
 * \param queue of their slots. \param numPaths of the wave: behind their sums lie the surfaces that
 * camera rays have met, and behind these the sums of each light path expression. */
kernel void resolve_keepSums(global uchar* state, uint numSlots, global const uint* restrict queue,
                             uint first, uint count, global float4* restrict sums, uint numPaths) {
    const uint item = (uint)get_global_id(0);
    if (item >= count) {
        return;
    }
    HdsPaths paths = {state, numSlots};
    const uint i = queue[first + item];
    const uint number = path_number(paths, i);
    sums[number] = path_load_radiance(paths, i);
#if HDS_FEATURE_MATTES
    sums[(size_t)numPaths + number] = as_float4(path_load_matte(paths, i));
#endif
#if HDS_LIGHT_PATH_STATE
    for (uint k = 0u; k < HDS_LIGHT_PATHS; ++k) {
        sums[(size_t)numPaths * (1u + HDS_FEATURE_MATTES + k) + number] =
            *path_lightSum(paths, i, k);
    }
#endif
}
#endif

/* What path `number` of the wave has gathered. \param state of paths; with lists their sums. */
float4 resolve_sum(global uchar* state, uint numSlots, uint number) {
#if HDS_WAIT_LISTS
    return ((global const float4*)state)[number];
#else
    HdsPaths paths = {state, numSlots};
    return path_load_radiance(paths, number);
#endif
}

/* Samples that the film has of a pixel of the wave. */
uint resolve_samplesBefore(HdsWave wave, global const HdsFilmPixel* pixel) {
    return wave.firstSample > 0u ? pixel->numSamples : 0u;
}

#if HDS_LIGHT_PATH_STATE || HDS_FEATURE_CATCHERS || HDS_FEATURE_OCCLUSION
/* A sum beside colour as it is before a wave. */
HdsLightPathPixel resolve_sumBefore(HdsWave wave, global const HdsLightPathPixel* slot) {
    const HdsLightPathPixel black = {(float4)(0.0f), (float4)(0.0f)};
    return wave.firstSample > 0u ? *slot : black;
}
#endif

/* Whether a sample counts; else it is black. */
bool resolve_isFinite(float4 value) {
    return isfinite(value.x) && isfinite(value.y) && isfinite(value.z);
}

/* Whether a sample shows a catcher, and so is no part of the picture. */
bool resolve_isCaught(float4 value) {
    return HDS_FEATURE_CATCHERS && value.w == HDS_CAUGHT_ALPHA;
}

#if HDS_LIGHT_PATH_STATE
/* What path `number` of the wave has gathered for light path expression k. */
float4 resolve_lightSum(global uchar* state, uint numSlots, uint numPaths, uint number, uint k) {
#if HDS_WAIT_LISTS
    return ((global const float4*)state)[(size_t)numPaths * (1u + HDS_FEATURE_MATTES + k) + number];
#else
    HdsPaths paths = {state, numSlots};
    return *path_lightSum(paths, number, k);
#endif
}

/* Adds the samples of light path expressions, by the rules of resolve_addSamples, which comes after
 * it: the film tells how many samples there are. Global size: wave.numPixels * number of
 * expressions. \param sums [expressions][numPixels] */
kernel void resolve_addLightPaths(HdsWave wave, global uchar* state, uint numSlots, uint numPaths,
                                  global const uint* pixels, global const HdsFilmPixel* film,
                                  global HdsLightPathPixel* sums, uint numPixels, uint count) {
    const uint item = (uint)get_global_id(0);
    if (item >= wave.numPixels * count) {
        return;
    }
    const uint i = item % wave.numPixels;
    const uint k = item / wave.numPixels;
    const uint at = pixels[wave.firstPixel + i];
    global HdsLightPathPixel* slot = &sums[(size_t)k * numPixels + at];
    HdsLightPathPixel pixel = resolve_sumBefore(wave, slot);
    uint numSamples = resolve_samplesBefore(wave, &film[at]);
    for (uint s = 0u; s < wave.numSamples; ++s) {
        const uint number = i * wave.numSamples + s;
        const float4 value = resolve_sum(state, numSlots, number);
        if (resolve_isFinite(value) && !resolve_isCaught(value)) {
            const float4 light = resolve_lightSum(state, numSlots, numPaths, number, k);
            filmPixel_addLightSample(&pixel, fmin(light.xyz, HDS_MAX_SAMPLE));
        }
        ++numSamples;
        filmPixel_closeLightPath(&pixel, numSamples);
    }
    *slot = pixel;
}
#endif

#if HDS_FEATURE_CATCHERS || HDS_FEATURE_OCCLUSION
/* Keeps what the paths of a trace beside that of the picture have gathered. Global size: count. */
kernel void resolve_keepSamples(global uchar* state, uint numSlots, uint count,
                                global float4* kept) {
    const uint number = (uint)get_global_id(0);
    if (number < count) {
        kept[number] = resolve_sum(state, numSlots, number);
    }
}
#endif

#if HDS_FEATURE_OCCLUSION
/* Adds samples of ambient occlusion to sums[firstSum...], by the rules of resolve_addSamples, which
 * comes after it. Global size: wave.numPixels. \param kept of the wave (resolve_keepSamples). */
kernel void resolve_addOcclusion(HdsWave wave, global const float4* kept, global const uint* pixels,
                                 global const HdsFilmPixel* film, global HdsLightPathPixel* sums,
                                 uint firstSum) {
    const uint i = (uint)get_global_id(0);
    if (i >= wave.numPixels) {
        return;
    }
    const uint at = pixels[wave.firstPixel + i];
    HdsLightPathPixel pixel = resolve_sumBefore(wave, &sums[(size_t)firstSum + at]);
    uint numSamples = resolve_samplesBefore(wave, &film[at]);
    for (uint s = 0u; s < wave.numSamples; ++s) {
        pixel.blockSum.x += kept[i * wave.numSamples + s].x;
        ++numSamples;
        filmPixel_closeSum(&pixel, numSamples);
    }
    sums[(size_t)firstSum + at] = pixel;
}
#endif

#if HDS_FEATURE_CATCHERS
/* Adds the samples that show catchers, by the rules of resolve_addSamples, which comes after it: to
 * sums[firstSum...] what they have gathered, and as the fourth how many they are; to the next
 * numPixels what the same samples gather without all that is no catcher, and as the fourth the
 * squares of what blocks differ by in luminance (filmPixel_caughtVariance). Global size:
 * wave.numPixels. \param alone of the wave (resolve_keepSamples). */
kernel void resolve_addCatchers(HdsWave wave, global uchar* state, uint numSlots,
                                global const float4* alone, global const uint* pixels,
                                global const HdsFilmPixel* film, global HdsLightPathPixel* sums,
                                uint firstSum, uint numPixels) {
    const uint i = (uint)get_global_id(0);
    if (i >= wave.numPixels) {
        return;
    }
    const uint at = pixels[wave.firstPixel + i];
    global HdsLightPathPixel* slots[2] = {&sums[(size_t)firstSum + at],
                                          &sums[(size_t)firstSum + numPixels + at]};
    HdsLightPathPixel lit = resolve_sumBefore(wave, slots[0]);
    HdsLightPathPixel unshadowed = resolve_sumBefore(wave, slots[1]);
    uint numSamples = resolve_samplesBefore(wave, &film[at]);
    for (uint s = 0u; s < wave.numSamples; ++s) {
        const uint number = i * wave.numSamples + s;
        const float4 value = resolve_sum(state, numSlots, number);
        const float4 without = alone[number];
        if (resolve_isCaught(value) && resolve_isFinite(value) && resolve_isFinite(without)) {
            lit.blockSum += (float4)(fmin(value.xyz, HDS_MAX_SAMPLE), 1.0f);
            unshadowed.blockSum += (float4)(fmin(without.xyz, HDS_MAX_SAMPLE), 0.0f);
        }
        ++numSamples;
        if (numSamples % HDS_SAMPLE_BLOCK == 0u) {
            const float difference = vec_luminance(lit.blockSum.xyz - unshadowed.blockSum.xyz);
            unshadowed.sum.w = fma(difference, difference, unshadowed.sum.w);
        }
        filmPixel_closeSum(&lit, numSamples);
        filmPixel_closeSum(&unshadowed, numSamples);
    }
    *slots[0] = lit;
    *slots[1] = unshadowed;
}
#endif

/* Global size: wave.numPixels. */
kernel void resolve_addSamples(HdsWave wave, global uchar* state, uint numSlots,
                               global const uint* pixels, global HdsFilmPixel* film,
                               volatile global uint* counters) {
    uint i = (uint)get_global_id(0);
    if (i >= wave.numPixels) {
        return;
    }
    global HdsFilmPixel* slot = &film[pixels[wave.firstPixel + i]];
    HdsFilmPixel pixel = {(float4)(0.0f), (float4)(0.0f), 0.0f, 0.0f, 0.0f, 0u};
    if (wave.firstSample > 0u) {
        pixel = *slot;
    }
    for (uint s = 0u; s < wave.numSamples; ++s) {
        float4 value = resolve_sum(state, numSlots, i * wave.numSamples + s);
        if (!resolve_isFinite(value)) {
            atomic_inc(&counters[HDS_COUNTER_NAN]);
            value = (float4)(0.0f, 0.0f, 0.0f, isfinite(value.w) ? value.w : 0.0f);
        }
        value = resolve_isCaught(value) ? (float4)(0.0f) : value;
        value = fmin(value, HDS_MAX_SAMPLE);
        filmPixel_addSample(&pixel, value);
    }
    *slot = pixel;
}
