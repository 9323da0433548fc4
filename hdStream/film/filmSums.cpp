// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/filmSums.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <string>

namespace hds {

namespace {

[[noreturn]] void Fail(const FilmSums& sums, const std::string& reason) {
    throw Error("sums of the samples " + std::to_string(sums.firstSample) + " to " +
                    std::to_string(sums.endSample) + ": " + reason,
                ErrorKind::Usage);
}

void CheckPixels(const FilmSums& sums) {
    const std::uint32_t most = sums.MostSamples();
    const auto hasOtherCount = [&](const shared::HdsFilmPixel& pixel) {
        return pixel.numSamples != sums.endSample && pixel.numSamples != most;
    };
    if (std::any_of(sums.pixels.begin(), sums.pixels.end(), hasOtherCount)) {
        Fail(sums, "pixels of an adaptive render (--noise) cannot be continued");
    }
}

} // namespace

std::uint32_t FilmSums::MostSamples() const {
    std::uint32_t most = endSample;
    for (const shared::HdsFilmPixel& pixel : pixels) {
        most = std::max(most, pixel.numSamples);
    }
    return most;
}

void CheckFilmSums(const std::vector<FilmSums>& start, std::uint32_t width, std::uint32_t height,
                   std::uint32_t samples, bool needsMattes,
                   const std::vector<std::string>& lightPaths) {
    for (std::size_t i = 0; i < start.size(); ++i) {
        const FilmSums& sums = start[i];
        if (sums.width != width || sums.height != height) {
            Fail(sums, "they are of " + std::to_string(sums.width) + "x" +
                           std::to_string(sums.height) + " pixels, the image has " +
                           std::to_string(width) + "x" + std::to_string(height));
        }
        const bool isBlack = sums.pixels.empty();
        if (isBlack ? sums.endSample != sums.firstSample
                    : sums.pixels.size() != std::size_t{width} * height) {
            Fail(sums, "pixels are missing");
        }
        if (sums.firstSample % HDS_SAMPLE_BLOCK != 0 || sums.endSample < sums.firstSample) {
            Fail(sums, "ranges begin at multiples of " + std::to_string(HDS_SAMPLE_BLOCK));
        }
        if (i > 0 && (sums.firstSample != start[i - 1].endSample ||
                      sums.endSample - sums.firstSample > HDS_SAMPLE_BLOCK)) {
            Fail(sums, "blocks follow each other, without gaps");
        }
        if (needsMattes && !isBlack && !sums.hasMattes) {
            Fail(sums, "they were made without a Cryptomatte, which is asked for now");
        }
        if (!isBlack && !lightPaths.empty() && sums.lightPaths != lightPaths) {
            Fail(sums, "they were made with other light path expressions than are asked for now");
        }
        if (!isBlack &&
            sums.lightPathPixels.size() != sums.lightPaths.size() * sums.pixels.size()) {
            Fail(sums, "pixels of light path expressions are missing");
        }
        for (const MatteCount& matte : sums.mattes) {
            if (matte.pixel >= std::uint64_t{width} * height) {
                Fail(sums, "counts of a Cryptomatte lie outside of the image");
            }
        }
        CheckPixels(sums);
        const std::uint32_t most = sums.MostSamples();
        if (start.size() > 1 && most != sums.endSample) {
            Fail(sums, "a pass was stopped in it");
        }
        if (most > samples) {
            Fail(sums, "the image is to have " + std::to_string(samples) + " samples");
        }
    }
}

} // namespace hds
