/* SPDX-License-Identifier: Apache-2.0
 * Adds the samples of a finished wave to the film, one work-item a pixel, in the order of samples:
 * the sums do not depend on how samples were spread over waves. From: path radiance. To: film.
 * Explained in docs/film.md. */
#include "film/filmPixel.clh"
#include "integrator/pathState.clh"

/* Global size: wave.numPixels. */
kernel void resolve_addSamples(HdsWave wave, global uchar* state, uint numSlots,
                               global const uint* pixels, global HdsFilmPixel* film,
                               volatile global uint* counters) {
    uint i = (uint)get_global_id(0);
    if (i >= wave.numPixels) {
        return;
    }
    HdsPaths paths = {state, numSlots};
    global HdsFilmPixel* slot = &film[pixels[wave.firstPixel + i]];
    HdsFilmPixel pixel = *slot;
    for (uint s = 0u; s < wave.numSamples; ++s) {
        float4 value = path_load_radiance(paths, i * wave.numSamples + s);
        if (!(isfinite(value.x) && isfinite(value.y) && isfinite(value.z))) {
            atomic_inc(&counters[HDS_COUNTER_NAN]);
            value = (float4)(0.0f, 0.0f, 0.0f, isfinite(value.w) ? value.w : 0.0f);
        }
        value = fmin(value, HDS_MAX_SAMPLE);
        filmPixel_addSample(&pixel, value);
    }
    *slot = pixel;
}
