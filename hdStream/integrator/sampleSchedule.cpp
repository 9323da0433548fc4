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
/// Seconds of a pass: pictures follow each other fast enough to be looked at, or seldom enough to
/// cost nothing.
constexpr double kInteractivePassSeconds = 0.1;
constexpr double kBatchPassSeconds = 1.0;
/// Seconds of a wave at most, however long passes are: who looks on hears of it after each.
constexpr double kMaxWaveSeconds = 0.5;
/// Passes grow by this factor at most: the first ones take longer than those to come, for drivers
/// compile what they launch first and pages are loaded.
constexpr std::uint32_t kMaxGrowth = 2;

} // namespace

double PassSeconds(bool interactive, double passSeconds) {
    return passSeconds > 0.0 ? passSeconds
           : interactive     ? kInteractivePassSeconds
                             : kBatchPassSeconds;
}

void SampleSchedule::Begin(const RenderOptions& options, const std::vector<FilmSums>& start) {
    _samples = options.samples;
    _isInteractive = options.interactive;
    _passSeconds = PassSeconds(options.interactive, options.passSeconds);
    _noise = options.noise;
    _timeLimit = options.timeLimit;
    MakeOrders(options.imageWidth, options.imageHeight);
    _activeNumber = _orderNumber;
    _isInStep = false;
    _isBackward = false;
    LoadStart(start);
    const bool isNew = _firstMissing == 0 && !_hasLate;
    _previewsLeft = isNew && _isInteractive ? NumPreviews() : 0;
    _previewStride = isNew ? 0 : 1; // a film that was loaded is a picture
    _done = _firstMissing;
    _waveSecondsPerPath = 0.0;
    _passSecondsPerPath = 0.0;
    _secondsInPass = 0.0;
    _pathsInPass = 0;
    _lastSamples = 1;
}

void SampleSchedule::MakeOrders(std::uint32_t width, std::uint32_t height) {
    if (_order.empty() || width != _width || height != _height) {
        _width = width;
        _height = height;
        _order = MakePixelOrder(width, height);
        _preview = MakePreviewOrder(_order, width, height);
        _orderNumber = ++_numLists;
        _previewNumber = ++_numLists;
    }
}

void SampleSchedule::LoadStart(const std::vector<FilmSums>& start) {
    _filmBegin = start.empty() ? 0 : start.front().firstSample;
    _firstMissing = start.empty() ? 0 : start.back().endSample;
    _lateEnd = start.empty() ? 0 : start.back().MostSamples();
    _late.clear();
    _lateNumber = ++_numLists;
    if (_lateEnd > _firstMissing) {
        const std::vector<shared::HdsFilmPixel>& sums = start.back().pixels;
        std::copy_if(_order.begin(), _order.end(), std::back_inserter(_late),
                     [&](std::uint32_t i) { return sums[i].numSamples == _firstMissing; });
    }
    _hasLate = !_late.empty();
    if (!_hasLate) { // also of sums that were taken behind the last wave of a pass
        _firstMissing = _lateEnd;
    }
    _lateDone = _firstMissing;
}

const std::vector<std::uint32_t>& SampleSchedule::Pixels(PixelList list) const {
    switch (list) {
    case PixelList::Preview:
        return _preview.pixels;
    case PixelList::Late:
        return _late;
    case PixelList::Active:
        break;
    }
    return _activeNumber == _orderNumber ? _order : _active;
}

std::uint64_t SampleSchedule::NumberOf(PixelList list) const {
    switch (list) {
    case PixelList::Preview:
        return _previewNumber;
    case PixelList::Late:
        return _lateNumber;
    case PixelList::Active:
        break;
    }
    return _activeNumber;
}

std::optional<SamplePass> SampleSchedule::Next() const {
    if (_previewsLeft > 0) {
        const std::uint32_t i = NumPreviews() - _previewsLeft;
        return SamplePass{
            PixelList::Preview, i == 0 ? 0 : _preview.ends[i - 1], _preview.ends[i], 0, 1, true};
    }
    if (_hasLate) { // the pass that was stopped is ended
        return SamplePass{PixelList::Late,
                          0,
                          Count(PixelList::Late),
                          _lateDone,
                          std::min(_lateEnd - _lateDone, MostInPass()),
                          false};
    }
    const std::uint32_t count = Count(PixelList::Active);
    if (_done == 0) {
        return SamplePass{PixelList::Active, 0, count, 0, 1, true};
    }
    if (_done >= _samples || count == 0) {
        return std::nullopt;
    }
    return SamplePass{PixelList::Active, 0, count, _done, PassEnd() - _done, false, _isBackward};
}

/// Where the pass after _done samples ends. Passes are as long as they should take; but while
/// pixels may be dropped none goes beyond a border of blocks, and where nobody looks on, or every
/// pass loads geometry anew, all end at such borders: samples of a pixel that are traced together
/// share what they touch.
std::uint32_t SampleSchedule::PassEnd() const {
    const std::uint32_t border = (_done / HDS_SAMPLE_BLOCK + 1) * HDS_SAMPLE_BLOCK;
    const std::uint32_t end = _noise > 0.0 ? std::min(_samples, border) : _samples;
    if (!_isInteractive) {
        const std::uint32_t inTime = _done + std::min(SamplesInTime(), MostInPass());
        return std::min(end, std::max(border, inTime - inTime % HDS_SAMPLE_BLOCK));
    }
    if (_limits.isStreaming) {
        return std::min({end, border, kMaxGrowth * _done});
    }
    // Parts of equal length, so that no short one is left.
    const std::uint32_t left = end - _done;
    const std::uint32_t samples = std::min({SamplesInTime(), MostInPass(), left});
    const std::uint32_t numParts = (left + samples - 1) / samples;
    return _done + (left + numParts - 1) / numParts;
}

/// Of each active pixel that a pass of _passSeconds can have, by the rate of the last one; at least
/// one.
std::uint32_t SampleSchedule::SamplesInTime() const {
    const double secondsPerSample = _passSecondsPerPath * Count(PixelList::Active);
    const std::uint32_t most = kMaxGrowth * _lastSamples;
    if (secondsPerSample <= 0.0) {
        return 1; // nothing is known
    }
    if (_passSeconds >= most * secondsPerSample) {
        return most;
    }
    return std::max(1U, static_cast<std::uint32_t>(_passSeconds / secondsPerSample));
}

std::uint32_t SampleSchedule::WavePixels(const SamplePass& pass, std::uint32_t rendered) const {
    double paths = _waveSecondsPerPath > 0.0 ? _limits.most : _limits.least; // the first is a trial
    if (_waveSecondsPerPath > 0.0 && !_limits.isStreaming) {
        paths = std::min(_passSeconds, kMaxWaveSeconds) / _waveSecondsPerPath;
    }
    paths = std::clamp<double>(paths, std::min(_limits.least, _limits.most), _limits.most);
    const std::uint32_t pixels = std::max(1U, static_cast<std::uint32_t>(paths) / pass.numSamples);
    const std::uint32_t left = pass.end - rendered;
    if (!_limits.isStreaming) {
        return std::min(pixels, left);
    }
    // Equal parts: a small one that is left waits for pages as often as a large one.
    const std::uint32_t numWaves = (left + pixels - 1) / pixels;
    return (left + numWaves - 1) / numWaves;
}

void SampleSchedule::EndWave(std::uint32_t numPaths, double seconds) {
    _waveSecondsPerPath = seconds / numPaths;
    _secondsInPass += seconds;
    _pathsInPass += numPaths;
}

void SampleSchedule::Complete() {
    const std::optional<SamplePass> pass = Next();
    if (!pass) {
        return;
    }
    if (_pathsInPass > 0) {
        _passSecondsPerPath = _secondsInPass / static_cast<double>(_pathsInPass);
    }
    _secondsInPass = 0.0;
    _pathsInPass = 0;
    _lastSamples = pass->numSamples;
    _isInStep = pass->list == PixelList::Active && !pass->isOfFirstPicture;
    _isBackward = pass->list == PixelList::Active && !pass->isBackward;
    _previewStride = 1;
    if (pass->list == PixelList::Preview) {
        _previewStride = _preview.strides[NumPreviews() - _previewsLeft--];
        _done = pass->end == Count(PixelList::Preview) ? 1 : 0;
        return;
    }
    const std::uint32_t end = pass->firstSample + pass->numSamples;
    if (pass->list == PixelList::Late) {
        _lateDone = end;
        _hasLate = end < _lateEnd;
    }
    _done = end;
}

bool SampleSchedule::MayDrop() const {
    return _noise > 0.0 && _isInStep && _done >= kMinAdaptiveSamples &&
           _done % HDS_SAMPLE_BLOCK == 0;
}

bool SampleSchedule::Drop(const std::vector<float>& errors) {
    const auto noise = static_cast<float>(_noise);
    const std::vector<std::uint32_t>& active = Pixels(PixelList::Active);
    std::vector<std::uint32_t> rest;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        if (!(errors[i] <= noise)) { // one that is not a number is not met
            rest.push_back(active[i]);
        }
    }
    const bool isAny = rest.size() < active.size();
    if (isAny) {
        _active = std::move(rest);
        _activeNumber = ++_numLists;
    }
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
