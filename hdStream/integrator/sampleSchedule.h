// SPDX-License-Identifier: Apache-2.0
// Which samples of which pixels a render traces, in which order, in which portions, and when it is
// over. It knows no device and no clock: seconds are told. Explained in docs/wavefront.md.
#pragma once

#include "hdStream/film/filmSums.h"
#include "hdStream/integrator/pixelOrder.h"
#include "hdStream/integrator/renderOptions.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

namespace hds {

/// The lists that passes take their pixels from.
enum class PixelList {
    Preview, ///< all pixels, from coarse to fine
    Late,    ///< those that a stopped pass of the loaded film left out
    Active,  ///< all pixels but those that have met the error
};

/// Samples [firstSample, firstSample + numSamples) of the pixels [begin, end) of a list.
struct SamplePass {
    PixelList list = PixelList::Active;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint32_t firstSample = 0;
    std::uint32_t numSamples = 0;
    bool isOfFirstPicture = false; ///< who looks on is told when it ends
    bool isBackward = false;       ///< waves take the last pixels of the list first

    /// Where in the list a wave of `count` pixels begins, when `rendered` pixels of the list are
    /// before those of the pass or rendered by it.
    std::uint32_t FirstOfWave(std::uint32_t rendered, std::uint32_t count) const {
        return isBackward ? begin + (end - rendered) - count : rendered;
    }
};

/// What a wave can be at present; a render may change it between two waves.
struct WaveLimits {
    std::uint32_t most = 1U << 20U; ///< paths in flight
    std::uint32_t least = 1;        ///< fewer paths are not worth a wave
    /// Every pass over the picture loads geometry anew: passes are blocks of samples, whatever they
    /// take, and waves are not cut.
    bool isStreaming = false;
};

/// The passes of a render, and how far it is. A pass that was stopped half-way is not completed.
/// Seconds that waves took decide the sizes of waves and passes, and nothing else: neither bits nor
/// the samples after which pixels are dropped.
class SampleSchedule {
public:
    /// Begins a render of a film that has the sums `start` (CheckFilmSums).
    void Begin(const RenderOptions& options, const std::vector<FilmSums>& start);
    /// Holds from the next wave, and the next pass, on.
    void SetLimits(const WaveLimits& limits) { _limits = limits; }

    /// What is to be rendered next; none: all pixels have all their samples.
    std::optional<SamplePass> Next() const;
    /// How many pixels of the pass the next wave takes: as many as a wave of that many seconds can
    /// have, by the rate of the last one. \param rendered as of SamplePass::FirstOfWave.
    std::uint32_t WavePixels(const SamplePass& pass, std::uint32_t rendered) const;
    /// A wave of so many paths has been rendered.
    void EndWave(std::uint32_t numPaths, double seconds);
    /// What Next says has been rendered.
    void Complete();
    const std::vector<std::uint32_t>& Pixels(PixelList list) const;
    /// All pixels of the image, in the order in which they enter waves.
    const std::vector<std::uint32_t>& AllPixels() const { return _order; }
    /// Lists of the same number are the same, in all renders.
    std::uint64_t NumberOf(PixelList list) const;
    std::uint64_t NumberOfAll() const { return _orderNumber; }

    /// Whether the pass completed last ends where pixels that have met the error are dropped.
    bool MayDrop() const;
    /// \param errors relative ones of the active pixels, in their order. Those that have met the
    /// error get no more samples. \return whether there are any.
    bool Drop(const std::vector<float>& errors);

    /// The film begins with this sample.
    std::uint32_t FilmBegin() const { return _filmBegin; }
    /// Every active pixel has the samples below.
    std::uint32_t Done() const { return _done; }
    /// As Progress::previewStride.
    std::uint32_t PreviewStride() const { return _previewStride; }

    /// Samples a pixel that as much work would have rendered, once `numPixels` pixels of the pass
    /// and of its list before it are rendered.
    double Equivalent(const SamplePass& pass, std::uint32_t numPixels) const;
    /// \param seconds since rendering began.
    Progress MakeProgress(double samplesEquivalent, double seconds) const;
    bool IsTimeUp(double seconds) const { return _timeLimit > 0.0 && seconds >= _timeLimit; }
    /// An estimate. \param samplesEquivalent that are rendered. \param seconds since rendering
    /// began.
    double SecondsLeft(double secondsPerSample, double samplesEquivalent, double seconds) const;

private:
    void MakeOrders(std::uint32_t width, std::uint32_t height);
    void LoadStart(const std::vector<FilmSums>& start);
    std::uint32_t PassEnd() const;
    std::uint32_t SamplesInTime() const;
    /// Of a pixel: all that a pass makes of them are in one wave.
    std::uint32_t MostInPass() const {
        return std::max<std::uint32_t>(_limits.most, HDS_SAMPLE_BLOCK);
    }
    std::uint32_t NumPreviews() const {
        return static_cast<std::uint32_t>(_preview.strides.size());
    }
    std::uint32_t Count(PixelList list) const {
        return static_cast<std::uint32_t>(Pixels(list).size());
    }

    std::uint32_t _samples = 0;
    bool _isInteractive = false;
    double _passSeconds = 0.0;
    double _noise = 0.0;
    double _timeLimit = 0.0;
    std::uint32_t _width = 0; ///< of the image that _order and _preview are of
    std::uint32_t _height = 0;
    std::vector<std::uint32_t> _order;
    PreviewOrder _preview;
    std::vector<std::uint32_t> _late;
    std::vector<std::uint32_t> _active; ///< once pixels have been dropped
    std::uint64_t _numLists = 0;        ///< that were made
    std::uint64_t _orderNumber = 0;     ///< NumberOf each
    std::uint64_t _previewNumber = 0;
    std::uint64_t _lateNumber = 0;
    std::uint64_t _activeNumber = 0; ///< _orderNumber: none has been dropped
    std::uint32_t _filmBegin = 0;
    std::uint32_t _firstMissing = 0; ///< first sample that some pixel of the loaded film lacks
    std::uint32_t _lateDone = 0;     ///< samples of the late pixels
    std::uint32_t _lateEnd = 0;      ///< samples of the other pixels
    std::uint32_t _previewsLeft = 0; ///< strides of the first picture that are to come
    bool _hasLate = false;           ///< the late pixels are to come
    bool _isInStep = false;          ///< the last pass was one of active pixels after the first
    bool _isBackward = false;        ///< the next pass of active pixels begins with the last ones
    std::uint32_t _done = 0;
    std::uint32_t _previewStride = 0;
    WaveLimits _limits;
    double _waveSecondsPerPath = 0.0; ///< of the last wave; 0: none has ended
    double _passSecondsPerPath = 0.0; ///< of the last pass; 0: none has ended
    double _secondsInPass = 0.0;      ///< of the waves of the present pass
    std::uint64_t _pathsInPass = 0;
    std::uint32_t _lastSamples = 0; ///< of a pixel in the last pass
};

} // namespace hds
