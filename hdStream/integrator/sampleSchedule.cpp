// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/sampleSchedule.h"

#include "kernels/shared/frame.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace hds {

namespace {

/// Fewest samples before the error estimate of a pixel is believed.
constexpr std::uint32_t kMinAdaptiveSamples = 2 * HDS_SAMPLE_BLOCK;
constexpr auto kNumPreviews = static_cast<std::uint32_t>(std::size(kPreviewStrides));

} // namespace

void SampleSchedule::Begin(const RenderOptions& options, const std::vector<FilmSums>& start) {
    _samples = options.samples;
    _showsPreviews = options.showsPreviews;
    _noise = options.noise;
    _timeLimit = options.timeLimit;
    MakeOrders(options.imageWidth, options.imageHeight);
    _active = _order;
    _isInStep = false;
    LoadStart(start);
    const bool isNew = _firstMissing == 0 && !_hasLate;
    _previewsLeft = isNew && _showsPreviews ? kNumPreviews : 0;
    _previewStride = isNew ? 0 : 1; // a film that was loaded is a picture
    _done = _firstMissing;
}

void SampleSchedule::MakeOrders(std::uint32_t width, std::uint32_t height) {
    if (_order.empty() || width != _width || height != _height) {
        _width = width;
        _height = height;
        _order = MakePixelOrder(width, height);
        _preview = MakePreviewOrder(_order, width);
    }
}

void SampleSchedule::LoadStart(const std::vector<FilmSums>& start) {
    _filmBegin = start.empty() ? 0 : start.front().firstSample;
    _firstMissing = start.empty() ? 0 : start.back().endSample;
    _lateEnd = start.empty() ? 0 : start.back().MostSamples();
    _late.clear();
    if (_lateEnd > _firstMissing) {
        const std::vector<shared::HdsFilmPixel>& sums = start.back().pixels;
        std::copy_if(_order.begin(), _order.end(), std::back_inserter(_late),
                     [&](std::uint32_t i) { return sums[i].numSamples == _firstMissing; });
    }
    _hasLate = !_late.empty();
}

const std::vector<std::uint32_t>& SampleSchedule::Pixels(PixelList list) const {
    return list == PixelList::Preview ? _preview.pixels : list == PixelList::Late ? _late : _active;
}

std::optional<SamplePass> SampleSchedule::Next() const {
    if (_previewsLeft > 0) {
        const std::uint32_t i = kNumPreviews - _previewsLeft;
        return SamplePass{
            PixelList::Preview, i == 0 ? 0 : _preview.ends[i - 1], _preview.ends[i], 0, 1, true};
    }
    if (_hasLate) { // the pass that was stopped is ended
        return SamplePass{PixelList::Late,          0,    Count(PixelList::Late), _firstMissing,
                          _lateEnd - _firstMissing, false};
    }
    const std::uint32_t count = Count(PixelList::Active);
    if (_done == 0) {
        return SamplePass{PixelList::Active, 0, count, 0, 1, true};
    }
    if (_done >= _samples || count == 0) {
        return std::nullopt;
    }
    return SamplePass{PixelList::Active, 0, count, _done, PassEnd() - _done, false};
}

/// Where the pass after _done samples ends: block by block; for those who look at pictures doubling
/// inside the first block, so that pictures follow each other soon.
std::uint32_t SampleSchedule::PassEnd() const {
    const bool isDoubling = _showsPreviews && _done < HDS_SAMPLE_BLOCK;
    const std::uint32_t border =
        isDoubling ? 2 * _done : (_done / HDS_SAMPLE_BLOCK + 1) * HDS_SAMPLE_BLOCK;
    return std::min(_samples, border);
}

void SampleSchedule::Complete() {
    const std::optional<SamplePass> pass = Next();
    if (!pass) {
        return;
    }
    _isInStep = pass->list == PixelList::Active && !pass->isOfFirstPicture;
    _previewStride = 1;
    if (pass->list == PixelList::Preview) {
        _previewStride = kPreviewStrides[kNumPreviews - _previewsLeft--];
        _done = pass->end == Count(PixelList::Preview) ? 1 : 0;
        return;
    }
    _hasLate = false;
    _done = pass->firstSample + pass->numSamples;
}

bool SampleSchedule::MayDrop() const {
    return _noise > 0.0 && _isInStep && _done >= kMinAdaptiveSamples &&
           _done % HDS_SAMPLE_BLOCK == 0;
}

bool SampleSchedule::Drop(const std::vector<float>& errors) {
    const auto noise = static_cast<float>(_noise);
    std::vector<std::uint32_t> rest;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        if (!(errors[i] <= noise)) { // one that is not a number is not met
            rest.push_back(_active[i]);
        }
    }
    const bool isAny = rest.size() < _active.size();
    _active = std::move(rest);
    return isAny;
}

double SampleSchedule::Equivalent(const SamplePass& pass, std::uint32_t numPixels) const {
    const double part = static_cast<double>(numPixels) / static_cast<double>(Count(pass.list));
    return pass.firstSample + part * pass.numSamples;
}

Progress SampleSchedule::MakeProgress(double samplesEquivalent, double seconds) const {
    Progress progress;
    progress.samplesDone = _done;
    progress.samplesTotal = _samples;
    progress.fraction =
        std::min(1.0, (samplesEquivalent - _firstMissing) / (_samples - _firstMissing));
    progress.secondsElapsed = seconds;
    progress.previewStride = _previewStride;
    progress.secondsLeft =
        progress.fraction > 0.0 ? seconds * (1.0 - progress.fraction) / progress.fraction : 0.0;
    if (_timeLimit > 0.0) {
        progress.secondsLeft = std::min(progress.secondsLeft, _timeLimit - seconds);
    }
    return progress;
}

double SampleSchedule::SecondsLeft(double secondsPerSample, double samplesEquivalent,
                                   double seconds) const {
    const double left = secondsPerSample * (_samples - samplesEquivalent);
    return _timeLimit > 0.0 ? std::min(left, _timeLimit - seconds) : left;
}

} // namespace hds
