// SPDX-License-Identifier: Apache-2.0
// The film's sums in host memory: what a farm ships, and what a later render goes on from.
// Explained in docs/film.md.
#pragma once

#include "hdStream/film/cryptomatte.h"
#include "kernels/shared/frame.h"
#include "kernels/shared/lightPaths.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Sums of the samples [firstSample, endSample) of every pixel. In the midst of a render, and after
/// one that was stopped, pixels of its last pass may have more, all of them if its last wave is
/// done: those that do have equally many. 48 B a pixel.
struct FilmSums {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t firstSample = 0; ///< where the film began, a multiple of HDS_SAMPLE_BLOCK
    std::uint32_t endSample = 0;   ///< every pixel has the samples below
    std::vector<shared::HdsFilmPixel> pixels; ///< [height][width]; empty: no sample yet, black
    bool hasMattes = false;                   ///< what samples met was counted, for a Cryptomatte
    std::vector<MatteCount> mattes;
    std::vector<std::string> lightPaths; ///< expressions that were asked for, each once
    /// [lightPaths][height][width], without samples none. 32 B each.
    std::vector<shared::HdsLightPathPixel> lightPathPixels;

    /// Samples of the pixels that have most.
    std::uint32_t MostSamples() const;
};

/// Checks what a render begins with: ranges that follow each other, the first of any length, each
/// other one a block of HDS_SAMPLE_BLOCK samples or the beginning of one, since only block sums
/// add up to the bits of one render.
/// \param samples that the render ends with
/// \param needsMattes the render has a Cryptomatte
/// \param lightPaths that the render has, in this order
/// \throws Error (Usage) that says what is wrong
void CheckFilmSums(const std::vector<FilmSums>& start, std::uint32_t width, std::uint32_t height,
                   std::uint32_t samples, bool needsMattes,
                   const std::vector<std::string>& lightPaths);

} // namespace hds
