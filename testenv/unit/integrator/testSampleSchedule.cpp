// SPDX-License-Identifier: Apache-2.0
// The passes of a render, without a device or a clock: which samples of which pixels come next,
// where passes and waves end by the seconds they are told to have taken, what a film that was
// loaded lacks, which pixels are dropped, and when time is up.
#include "hdStream/integrator/sampleSchedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace hds::test {
namespace {

constexpr std::uint32_t kBlock = HDS_SAMPLE_BLOCK;

RenderOptions Options(std::uint32_t samples, bool interactive = false) {
    RenderOptions options;
    options.imageWidth = 40;
    options.imageHeight = 9;
    options.samples = samples;
    options.interactive = interactive;
    return options;
}

SampleSchedule Begun(const RenderOptions& options, const std::vector<FilmSums>& start = {}) {
    SampleSchedule schedule;
    schedule.Begin(options, start);
    return schedule;
}

/// Sums of which every third pixel has `more` samples beyond `done`.
FilmSums Sums(std::uint32_t done, std::uint32_t more = 0) {
    FilmSums sums;
    sums.width = 40;
    sums.height = 9;
    sums.endSample = done;
    sums.pixels.resize(std::size_t{sums.width} * sums.height);
    for (std::size_t i = 0; i < sums.pixels.size(); ++i) {
        sums.pixels[i].numSamples = done + (i % 3 == 0 ? more : 0);
    }
    return sums;
}

/// Seconds that one sample of all 360 pixels takes, by how many they have.
using Clock = std::function<double(std::uint32_t sample)>;

Clock Always(double secondsPerSample) {
    return [=](std::uint32_t) { return secondsPerSample; };
}

/// A pass takes longer than it should, however short it is.
const Clock kSlow = Always(1000.0);

/// Renders the pass that is next, in waves as the schedule wants them. \return their paths.
std::vector<std::uint32_t> RenderPass(SampleSchedule* schedule, const Clock& clock) {
    const SamplePass pass = *schedule->Next();
    const double secondsPerPath = clock(pass.firstSample) / 360;
    std::vector<std::uint32_t> waves;
    for (std::uint32_t first = pass.begin; first < pass.end;) {
        const std::uint32_t count = schedule->WavePixels(pass, first);
        waves.push_back(count * pass.numSamples);
        schedule->EndWave(waves.back(), waves.back() * secondsPerPath);
        first += count;
        EXPECT_LE(first, pass.end);
    }
    schedule->Complete();
    return waves;
}

/// Where passes end, from now on to the end of the render.
std::vector<std::uint32_t> Borders(SampleSchedule schedule, const Clock& clock = kSlow) {
    std::vector<std::uint32_t> borders;
    while (const auto pass = schedule.Next()) {
        EXPECT_EQ(pass->firstSample, schedule.Done());
        RenderPass(&schedule, clock);
        borders.push_back(schedule.Done());
    }
    return borders;
}

/// Every number in [first, last].
std::vector<std::uint32_t> All(std::uint32_t first, std::uint32_t last) {
    std::vector<std::uint32_t> all(last - first + 1);
    std::iota(all.begin(), all.end(), first);
    return all;
}

TEST(SampleSchedule, PassesAreTheFirstSampleAndBlocks) {
    EXPECT_EQ(Borders(Begun(Options(1))), (std::vector<std::uint32_t>{1}));
    EXPECT_EQ(Borders(Begun(Options(7))), (std::vector<std::uint32_t>{1, 7}));
    EXPECT_EQ(Borders(Begun(Options(50))), (std::vector<std::uint32_t>{1, 16, 32, 48, 50}));
}

TEST(SampleSchedule, PassesWhereNobodyLooksAreAsManyBlocksAsASecondHolds) {
    EXPECT_EQ(Borders(Begun(Options(300)), Always(0.01)),
              (std::vector<std::uint32_t>{1, 16, 32, 64, 128, 224, 300}))
        << "100 samples, once passes have doubled as often as they may";
    EXPECT_EQ(Borders(Begun(Options(100)), Always(1.0 / 33)),
              (std::vector<std::uint32_t>{1, 16, 32, 64, 96, 100}));
    RenderOptions options = Options(100);
    options.passSeconds = 1.5;
    EXPECT_EQ(Borders(Begun(options), Always(1.0 / 33)),
              (std::vector<std::uint32_t>{1, 16, 32, 64, 100}));
}

TEST(SampleSchedule, PassesWhereSomeoneLooksTakeATenthOfASecond) {
    const std::vector<FilmSums> start{Sums(1)}; // without previews
    EXPECT_EQ(Borders(Begun(Options(40, true), start), Always(0.019)),
              (std::vector<std::uint32_t>{2, 4, 8, 13, 18, 23, 28, 32, 36, 40}))
        << "1, 2, 4, 5 samples; the rest in equal parts";
    EXPECT_EQ(Borders(Begun(Options(9, true), start), Always(0.11)), All(2, 9));
    EXPECT_EQ(Borders(Begun(Options(64, true), start), Always(1e-9)),
              (std::vector<std::uint32_t>{2, 4, 8, 16, 32, 64}));
}

TEST(SampleSchedule, PassesShrinkAtOnceAndGrowAgain) {
    const auto clock = [](std::uint32_t sample) { return sample == 16 ? 1.0 : 1e-9; };
    EXPECT_EQ(Borders(Begun(Options(64, true), {Sums(1)}), clock),
              (std::vector<std::uint32_t>{2, 4, 8, 16, 32, 33, 35, 39, 46, 55, 64}));
}

TEST(SampleSchedule, WhileGeometryStreamsPassesDoubleToBlocks) {
    for (const Clock& clock : {kSlow, Always(1e-9)}) {
        SampleSchedule schedule = Begun(Options(40, true), {Sums(1)});
        schedule.SetLimits({1U << 20U, 1, true});
        EXPECT_EQ(Borders(schedule, clock), (std::vector<std::uint32_t>{2, 4, 8, 16, 32, 40}));
    }
}

TEST(SampleSchedule, SamplesOfAPixelFitAWave) {
    SampleSchedule schedule = Begun(Options(300));
    schedule.SetLimits({50, 50});
    EXPECT_EQ(Borders(schedule, Always(1e-9)),
              (std::vector<std::uint32_t>{1, 16, 32, 64, 112, 160, 208, 256, 300}));
    schedule = Begun(Options(300, true), {Sums(1)});
    schedule.SetLimits({5, 5});
    for (const std::uint32_t border : Borders(schedule, Always(1e-9))) {
        EXPECT_LE(border, schedule.Done() + HDS_SAMPLE_BLOCK);
        while (schedule.Done() < border) {
            RenderPass(&schedule, Always(1e-9));
        }
    }
    schedule = Begun(Options(300), {Sums(16, 100)});
    schedule.SetLimits({40, 40});
    EXPECT_EQ(Borders(schedule), (std::vector<std::uint32_t>{56, 96, 116, 128, 144, 160, 176, 192,
                                                             208, 224, 240, 256, 272, 288, 300}))
        << "also those of late pixels";
}

TEST(SampleSchedule, TheFirstWaveIsATrialAndTheNextAreCutByTime) {
    using Waves = std::vector<std::uint32_t>;
    const auto waves = [](bool interactive, double seconds, WaveLimits limits) {
        SampleSchedule schedule = Begun(Options(40, interactive), {Sums(16)});
        schedule.SetLimits(limits);
        return RenderPass(&schedule, Always(seconds));
    };
    EXPECT_EQ(waves(false, 1e-9, {3200, 320}), (Waves{320, 3200, 2240})) << "16 samples of a pixel";
    EXPECT_EQ(waves(false, 0.5, {3200, 160}), (Waves{160, 352, 352, 352, 352, 352, 352, 352, 352,
                                                     352, 352, 352, 352, 352, 352, 352, 320}))
        << "half a second holds 360 paths";
    EXPECT_EQ(waves(false, 1000.0, {3200, 1600}), (Waves{1600, 1600, 1600, 960}));
    EXPECT_EQ(waves(true, 0.47, {3200, 36}), (Waves{36, 76, 76, 76, 76, 20}))
        << "a tenth of a second; one sample of a pixel";
    EXPECT_EQ(waves(false, 1000.0, {3200, 3200, true}), (Waves{2880, 2880}));
    EXPECT_EQ(waves(false, 1e-9, {5, 5}), Waves(360, 16)) << "at least a pixel";
}

TEST(SampleSchedule, EverySecondPassBeginsWhereTheOneBeforeHasEnded) {
    SampleSchedule schedule = Begun(Options(64));
    schedule.SetLimits({100, 100}); // pixels are cut into several waves
    std::vector<bool> areBackward;
    std::uint32_t last = 0; // first pixel of the wave before
    while (const auto pass = schedule.Next()) {
        std::vector<std::uint32_t> timesRendered(360, 0);
        for (std::uint32_t rendered = pass->begin; rendered < pass->end;) {
            const std::uint32_t count = schedule.WavePixels(*pass, rendered);
            const std::uint32_t first = pass->FirstOfWave(rendered, count);
            ASSERT_LE(first + count, 360U);
            if (rendered > 0) {
                EXPECT_EQ(first < last, pass->isBackward) << "neighbours follow each other";
            } else if (!areBackward.empty()) {
                EXPECT_EQ(first, pass->isBackward ? 360 - count : 0U);
            }
            last = first;
            std::for_each(timesRendered.begin() + first, timesRendered.begin() + first + count,
                          [](std::uint32_t& times) { ++times; });
            schedule.EndWave(count * pass->numSamples, 1000.0);
            rendered += count;
        }
        EXPECT_EQ(timesRendered, std::vector<std::uint32_t>(360, 1));
        areBackward.push_back(pass->isBackward);
        schedule.Complete();
    }
    EXPECT_EQ(areBackward, (std::vector<bool>{false, true, false, true, false}));
}

TEST(SampleSchedule, AllPixelsOfAPassAreActive) {
    SampleSchedule schedule = Begun(Options(50));
    while (const auto pass = schedule.Next()) {
        EXPECT_EQ(pass->list, PixelList::Active);
        EXPECT_EQ(pass->begin, 0U);
        EXPECT_EQ(pass->end, 360U);
        EXPECT_EQ(pass->isOfFirstPicture, schedule.Done() == 0);
        schedule.Complete();
    }
    EXPECT_EQ(schedule.Pixels(PixelList::Active), MakePixelOrder(40, 9));
}

TEST(SampleSchedule, PreviewsGoFromCoarseToFine) {
    SampleSchedule schedule = Begun(Options(40, true));
    EXPECT_EQ(schedule.PreviewStride(), 0U);
    const std::vector<std::uint32_t>& pixels = schedule.Pixels(PixelList::Preview);
    std::uint32_t begin = 0;
    for (const std::uint32_t stride : {8U, 4U, 2U, 1U}) {
        const auto pass = schedule.Next();
        ASSERT_TRUE(pass);
        EXPECT_EQ(pass->list, PixelList::Preview);
        EXPECT_TRUE(pass->isOfFirstPicture);
        EXPECT_EQ(pass->begin, begin);
        EXPECT_EQ(pass->end, ((39 / stride) + 1) * ((8 / stride) + 1)) << stride;
        EXPECT_EQ(pass->numSamples, 1U);
        EXPECT_EQ(schedule.Done(), 0U);
        for (std::uint32_t i = pass->begin; i < pass->end; ++i) {
            EXPECT_EQ(pixels[i] % 40 % stride, 0U);
            EXPECT_EQ(pixels[i] / 40 % stride, 0U);
        }
        begin = pass->end;
        schedule.Complete();
        EXPECT_EQ(schedule.PreviewStride(), stride);
    }
    EXPECT_EQ(schedule.Done(), 1U);
    EXPECT_EQ(Borders(schedule), All(2, 40));
    EXPECT_EQ(Borders(Begun(Options(1, true))), (std::vector<std::uint32_t>{0, 0, 0, 1}));
}

TEST(SampleSchedule, AFilmThatWasLoadedGoesOnAtItsEnd) {
    for (const bool interactive : {false, true}) {
        const SampleSchedule schedule = Begun(Options(40, interactive), {Sums(16), Sums(20)});
        EXPECT_EQ(schedule.PreviewStride(), 1U) << "it is a picture";
        EXPECT_EQ(schedule.Done(), 20U);
        EXPECT_FALSE(schedule.Next()->isOfFirstPicture);
        EXPECT_EQ(Borders(schedule),
                  interactive ? All(21, 40) : (std::vector<std::uint32_t>{32, 40}));
    }
    FilmSums middle = Sums(32);
    middle.firstSample = 16;
    EXPECT_EQ(Begun(Options(40), {middle}).FilmBegin(), 16U);
    EXPECT_EQ(Borders(Begun(Options(40), {Sums(3)})), (std::vector<std::uint32_t>{16, 32, 40}));
    EXPECT_FALSE(Begun(Options(16), {Sums(16)}).Next()) << "nothing is missing";
    EXPECT_EQ(Borders(Begun(Options(2), {FilmSums{}})), (std::vector<std::uint32_t>{1, 2}))
        << "a black film is a new one";
}

TEST(SampleSchedule, LatePixelsComeFirstAndAlone) {
    SampleSchedule schedule = Begun(Options(40), {Sums(16, 12)});
    const auto pass = schedule.Next();
    ASSERT_TRUE(pass);
    EXPECT_EQ(pass->list, PixelList::Late);
    EXPECT_EQ(pass->firstSample, 16U);
    EXPECT_EQ(pass->numSamples, 12U);
    EXPECT_EQ(pass->end, 240U) << "two of three";
    EXPECT_FALSE(pass->isOfFirstPicture);
    for (const std::uint32_t pixel : schedule.Pixels(PixelList::Late)) {
        EXPECT_NE(pixel % 3, 0U);
    }
    schedule.Complete();
    EXPECT_EQ(schedule.Done(), 28U);
    EXPECT_EQ(schedule.Next()->end, 360U);
    EXPECT_EQ(Borders(schedule), (std::vector<std::uint32_t>{32, 40}));
}

/// Of sums that were taken when the last wave of a pass was done, and the pass was not.
TEST(SampleSchedule, NoSampleIsRenderedTwiceWherePixelsHaveMoreThanTheSumsSay) {
    FilmSums sums = Sums(32);
    for (shared::HdsFilmPixel& pixel : sums.pixels) {
        pixel.numSamples = 64;
    }
    const std::optional<SamplePass> pass = Begun(Options(200), {sums}).Next();
    ASSERT_TRUE(pass);
    EXPECT_EQ(pass->list, PixelList::Active);
    EXPECT_EQ(pass->firstSample, 64U);
    sums.endSample = 0;
    EXPECT_EQ(Begun(Options(200, true), {sums}).Next()->firstSample, 64U);
}

TEST(SampleSchedule, PixelsOfAFirstPassThatWasStoppedComeLate) {
    SampleSchedule schedule = Begun(Options(16, true), {Sums(0, 1)});
    EXPECT_EQ(schedule.Next()->list, PixelList::Late);
    EXPECT_EQ(schedule.Next()->end, 240U);
    schedule.Complete();
    EXPECT_EQ(schedule.Done(), 1U);
    EXPECT_EQ(Borders(schedule), All(2, 16));
}

/// Borders at which pixels may be dropped.
std::vector<std::uint32_t> Drops(SampleSchedule schedule, const Clock& clock) {
    std::vector<std::uint32_t> drops;
    while (schedule.Next()) {
        RenderPass(&schedule, clock);
        if (schedule.MayDrop()) {
            drops.push_back(schedule.Done());
        }
    }
    return drops;
}

TEST(SampleSchedule, PixelsAreDroppedAtBlocksFromTheSecondOnWhateverTimePassesTake) {
    RenderOptions options = Options(70);
    EXPECT_TRUE(Drops(Begun(options), kSlow).empty()) << "no error is set";
    options.noise = 0.1;
    for (const double seconds : {1000.0, 0.05, 0.003, 1e-9}) {
        for (const bool interactive : {false, true}) {
            options.interactive = interactive;
            EXPECT_EQ(Drops(Begun(options), Always(seconds)),
                      (std::vector<std::uint32_t>{2 * kBlock, 3 * kBlock, 4 * kBlock}))
                << seconds;
            EXPECT_EQ(Drops(Begun(options, {Sums(16, 16)}), Always(seconds)),
                      (std::vector<std::uint32_t>{3 * kBlock, 4 * kBlock}))
                << "not after the pass that was stopped";
        }
    }
}

TEST(SampleSchedule, DroppedPixelsGetNoMoreSamples) {
    RenderOptions options = Options(70);
    options.noise = 0.1;
    SampleSchedule schedule = Begun(options, {Sums(32)});
    std::vector<float> errors(360, 0.2F);
    EXPECT_FALSE(schedule.Drop(errors));
    errors[3] = 0.1F; // as much as is asked for
    errors[5] = std::numeric_limits<float>::quiet_NaN();
    errors[7] = 0.0F;
    EXPECT_TRUE(schedule.Drop(errors));
    std::vector<std::uint32_t> rest = MakePixelOrder(40, 9);
    rest.erase(rest.begin() + 7);
    rest.erase(rest.begin() + 3);
    EXPECT_EQ(schedule.Pixels(PixelList::Active), rest);
    EXPECT_EQ(schedule.Next()->end, 358U);
    EXPECT_EQ(schedule.AllPixels().size(), 360U);
    EXPECT_TRUE(schedule.Drop(std::vector<float>(358, 0.0F)));
    EXPECT_FALSE(schedule.Next()) << "all have met it";
    schedule.Begin(options, {});
    EXPECT_EQ(schedule.Next()->end, 360U) << "a new render has all pixels";
}

TEST(SampleSchedule, AnotherSizeHasOtherPixels) {
    SampleSchedule schedule = Begun(Options(4, true));
    RenderOptions options = Options(4, true);
    options.imageWidth = 9;
    options.imageHeight = 40;
    schedule.Begin(options, {});
    EXPECT_EQ(schedule.AllPixels(), MakePixelOrder(9, 40));
    EXPECT_EQ(schedule.Pixels(PixelList::Active), MakePixelOrder(9, 40));
    EXPECT_EQ(schedule.Pixels(PixelList::Preview),
              MakePreviewOrder(MakePixelOrder(9, 40), 9, 40).pixels);
}

TEST(SampleSchedule, ListsOfTheSameNumberAreTheSame) {
    std::map<std::uint64_t, std::vector<std::uint32_t>> lists;
    SampleSchedule schedule;
    const auto look = [&] {
        for (const PixelList list : {PixelList::Preview, PixelList::Late, PixelList::Active}) {
            const auto& pixels = schedule.Pixels(list);
            EXPECT_EQ(lists.try_emplace(schedule.NumberOf(list), pixels).first->second, pixels);
        }
        EXPECT_EQ(lists.try_emplace(schedule.NumberOfAll(), schedule.AllPixels()).first->second,
                  schedule.AllPixels());
    };
    RenderOptions options = Options(70, true);
    options.noise = 0.1;
    schedule.Begin(options, {});
    look();
    const std::uint64_t preview = schedule.NumberOf(PixelList::Preview);
    EXPECT_EQ(schedule.NumberOf(PixelList::Active), schedule.NumberOfAll()) << "one list";
    schedule.Begin(options, {Sums(32, 48)});
    look();
    std::vector<float> errors(360, 0.2F);
    for (const std::size_t met : {std::size_t{3}, std::size_t{5}}) {
        errors[met] = 0.0F;
        EXPECT_TRUE(schedule.Drop(errors));
        look();
        errors.assign(359, 0.2F);
    }
    schedule.Begin(options, {});
    look();
    EXPECT_EQ(schedule.NumberOf(PixelList::Preview), preview) << "of the same image";
    std::swap(options.imageWidth, options.imageHeight);
    schedule.Begin(options, {});
    look();
    EXPECT_NE(schedule.NumberOf(PixelList::Preview), preview);
}

TEST(SampleSchedule, ProgressIsOfTheSamplesThatTheFilmLacked) {
    SampleSchedule schedule = Begun(Options(36), {Sums(16)});
    const auto pass = schedule.Next();
    EXPECT_EQ(schedule.Equivalent(*pass, 90), 16 + 0.25 * 16);
    const Progress progress = schedule.MakeProgress(schedule.Equivalent(*pass, 90), 3.0);
    EXPECT_EQ(progress.samplesDone, 16U);
    EXPECT_EQ(progress.samplesTotal, 36U);
    EXPECT_DOUBLE_EQ(progress.fraction, 4.0 / 20.0);
    EXPECT_EQ(progress.secondsElapsed, 3.0);
    EXPECT_DOUBLE_EQ(progress.secondsLeft, 12.0);
    EXPECT_EQ(progress.previewStride, 1U);
    EXPECT_EQ(schedule.MakeProgress(16, 3.0).secondsLeft, 0.0) << "not known";
}

TEST(SampleSchedule, TimeEndsARenderAndItsEstimates) {
    RenderOptions options = Options(36);
    EXPECT_FALSE(Begun(options).IsTimeUp(1e9)) << "no limit";
    options.timeLimit = 10.0;
    SampleSchedule schedule = Begun(options, {Sums(16)});
    EXPECT_FALSE(schedule.IsTimeUp(9.9));
    EXPECT_TRUE(schedule.IsTimeUp(10.0));
    EXPECT_EQ(schedule.MakeProgress(17, 4.0).secondsLeft, 6.0);
    EXPECT_EQ(schedule.SecondsLeft(0.1, 16, 4.0), 2.0);
    EXPECT_EQ(schedule.SecondsLeft(0.1, 26, 4.0), 1.0) << "half-way";
    EXPECT_EQ(schedule.SecondsLeft(1.0, 16, 4.0), 6.0);
    options.timeLimit = 0.0;
    schedule.Begin(options, {Sums(16)});
    EXPECT_EQ(schedule.SecondsLeft(1.0, 16, 4.0), 20.0);
}

} // namespace
} // namespace hds::test
