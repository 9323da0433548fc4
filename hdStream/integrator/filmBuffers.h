// SPDX-License-Identifier: Apache-2.0
// The film in device memory and its AOVs on the way to host memory.
// Explained in docs/film.md.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/film/aov.h"
#include "hdStream/film/deepImage.h"
#include "hdStream/film/filmSums.h"
#include "hdStream/integrator/stageKernels.h"
#include "kernels/shared/frame.h"

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace hds {

/// Sums of samples, and the AOVs developed from them or found by first hits. Externally
/// synchronised.
class FilmBuffers {
public:
    explicit FilmBuffers(std::shared_ptr<Device> device) : _device(std::move(device)) {}

    /// A film of that size with buffers for the AOVs. Keeps memory of the same size, and what it
    /// holds: waves take pixels that have no sample for black.
    void Reset(const AovLayout& layout, const std::optional<DeepLimits>& deep, std::uint32_t width,
               std::uint32_t height);

    /// Puts sums (CheckFilmSums), if there are any, into the film. Blocks.
    void Load(StageKernels* kernels, const std::vector<FilmSums>& start);

    /// Makes those pixels black that have no sample yet: of a list of all pixels those from `first`
    /// on. Blocks.
    void ClearRest(const std::vector<std::uint32_t>& pixels, std::size_t first);

    /// The sums as they are. Blocks. \param samples [first, end) that every pixel has.
    FilmSums Read(std::uint32_t firstSample, std::uint32_t endSample) const;

    /// Standard errors over brightness around a pixel (docs/film.md). Blocks. \param pixels
    /// [>= count] on the device. \return [count].
    std::vector<float> RelativeErrors(StageKernels* kernels, const Buffer& pixels,
                                      std::uint32_t count) const;
    /// Their mean; those that are not finite count as 0. 0 without pixels.
    double MeanRelativeError(StageKernels* kernels, const Buffer& pixels,
                             std::uint32_t count) const;

    const Buffer& Film() const { return _film; }
    const Buffer& Floats() const { return _floats; }
    const Buffer& Ints() const { return _ints; }
    std::uint64_t Bytes() const {
        return _film.Bytes() + _floats.Bytes() + _ints.Bytes() + _lightPaths.Bytes();
    }

    /// Sums of light path expressions, and how many there are.
    const Buffer& LightPaths() const { return _lightPaths; }
    std::uint32_t NumLightPaths() const {
        return static_cast<std::uint32_t>(_layout.lightPaths.size());
    }
    /// Of these, and behind them of catchers and of ambient occlusion.
    std::uint32_t NumSums() const { return static_cast<std::uint32_t>(_layout.SumNames().size()); }
    /// The number of the sum of ambient occlusion, which is the last.
    std::uint32_t OcclusionSum() const { return NumSums() - 1; }
    std::uint32_t NumPixels() const { return _width * _height; }

    bool HasMattes() const { return _layout.hasMattes; }
    /// Counts what the samples of a wave have met. \param pixels of the wave, numSamples slots
    /// each. \param surfaces as the field `matte` of the path state, by slot.
    void AddMattes(const CommittedScene& scene, const std::uint32_t* pixels,
                   std::uint32_t numSamples,
                   const std::vector<std::array<std::uint32_t, 4>>& surfaces);

    bool HasDeep() const { return _deep.has_value(); }
    /// Adds the samples of a wave to the deep picture; parameters as of AddMattes.
    /// \param radiances what paths have gathered, by slot.
    void AddDeep(const std::uint32_t* pixels, std::uint32_t numSamples,
                 const std::vector<std::array<std::uint32_t, 4>>& surfaces,
                 const std::vector<std::array<float, 4>>& radiances);
    /// Where HasDeep.
    const DeepSums& Deep() const { return *_deep; }

    /// Where the kernel `aov` writes. \param centre of the scene, world space. \param shutterFrames
    /// length of the shutter's interval, 0: closed.
    shared::HdsAovOffsets FirstHitOffsets(const glm::dvec3& centre, double shutterFrames) const;

    /// Some AOV is found by first hits / they have all been found since Reset.
    bool NeedsFirstHits() const;
    bool HasFirstHits() const { return _hasFirstHits; }
    void SetHasFirstHits() { _hasFirstHits = true; }

    /// All AOVs of the layout. Blocks. Those of first hits are at their clear values until they
    /// have been found. \param previewStride as Progress::previewStride; 0 gives clear values.
    /// \param nameOf what Cryptomattes show.
    std::vector<ImageLayer> Develop(StageKernels* kernels, std::uint32_t previewStride,
                                    const MatteNamer& nameOf);

private:
    void AddLightPathBlock(StageKernels* kernels, const FilmSums& sums, const Buffer& block);
    void DevelopMattes(const MatteNamer& nameOf, std::vector<ImageLayer>* layers) const;

    std::shared_ptr<Device> _device;
    AovLayout _layout;
    std::uint32_t _width = 0;
    std::uint32_t _height = 0;
    Buffer _film;
    Buffer _floats;
    Buffer _ints;
    Buffer _lightPaths; ///< HdsLightPathPixel [NumSums()][pixels]
    bool _hasFirstHits = false;
    MatteSums _mattes;
    std::optional<DeepSums> _deep;
};

/// The name by which a Cryptomatte knows a surface.
std::string MatteName(const CommittedScene& scene, MatteKind kind, const MatteSurface& surface);

/// True when some AOV of the layout is found by a ray through each pixel's centre.
bool NeedsFirstHits(const AovLayout& layout);

} // namespace hds
