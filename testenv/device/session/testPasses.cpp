// SPDX-License-Identifier: Apache-2.0
// However samples are cut into passes and waves: the bits are the same, progress comes in order
// after each wave, and a render can be cancelled inside a wave. The sizes of passes follow the
// setting passSeconds; none of the values here lets the time that something takes decide.
#include "hdStream/integrator/sampleSchedule.h"
#include "hdStream/session/renderThread.h"

#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <thread>

namespace hds::test {
namespace {

constexpr double kNoTime = 1e-9; ///< every pass takes longer
constexpr double kAllTime = 1e9; ///< none does

class PassesTest : public DeviceFixture {
protected:
    static Settings Make(bool interactive, double passSeconds, std::uint32_t samples = 64) {
        Settings settings = MakeSettings();
        settings.interactive = interactive;
        settings.passSeconds = passSeconds;
        settings.samples = samples;
        settings.aovs.push_back("sampleCount");
        return settings;
    }
    static const ImageLayer& Layer(const std::vector<ImageLayer>& layers, const std::string& name) {
        return *std::find_if(layers.begin(), layers.end(),
                             [&](const ImageLayer& layer) { return layer.name == name; });
    }
};

TEST_F(PassesTest, BitsDoNotDependOnThem) {
    for (const double noise : {0.0, 0.1}) {
        std::vector<ImageLayer> expected;
        for (const bool interactive : {false, true}) {
            for (const double seconds : {kNoTime, 0.002, kAllTime}) {
                for (const std::uint32_t waveSize : {0U, 777U}) {
                    Session session;
                    FillSession(&session);
                    Settings settings = Make(interactive, seconds, 100);
                    settings.noise = noise;
                    settings.waveSize = waveSize;
                    EXPECT_EQ(session.Render(settings), RenderResult::Complete);
                    const std::vector<ImageLayer> layers = session.Layers();
                    expected = expected.empty() ? layers : expected;
                    EXPECT_TRUE(SameLayers(layers, expected))
                        << interactive << " " << seconds << " " << waveSize << " " << noise;
                }
            }
        }
    }
}

/// What a schedule without a device expects to be told, by a clock of which a sample takes a
/// second.
std::vector<double> ExpectedFractions(const Settings& settings) {
    RenderOptions options;
    options.imageWidth = settings.imageWidth;
    options.imageHeight = settings.imageHeight;
    options.samples = settings.samples;
    options.interactive = settings.interactive;
    options.passSeconds = settings.passSeconds;
    SampleSchedule schedule;
    schedule.Begin(options, {});
    schedule.SetLimits({settings.waveSize, settings.waveSize});
    std::vector<double> fractions;
    while (const auto pass = schedule.Next()) {
        for (std::uint32_t first = pass->begin; first < pass->end;) {
            const std::uint32_t count = schedule.WavePixels(*pass, first);
            schedule.EndWave(count * pass->numSamples, 1.0 * count * pass->numSamples);
            first += count;
            fractions.push_back(schedule.Equivalent(*pass, first) / settings.samples);
        }
        schedule.Complete();
        if (pass->isOfFirstPicture) { // its end is told, too
            fractions.push_back(fractions.back());
        }
    }
    return fractions;
}

TEST_F(PassesTest, ProgressComesAfterEachWaveAndAtTheEndOfEachFirstPicture) {
    for (const bool interactive : {false, true}) {
        for (const double seconds : {kNoTime, kAllTime}) {
            Session session;
            FillSession(&session);
            Settings settings = Make(interactive, seconds);
            settings.waveSize = 5000;
            std::vector<double> fractions;
            std::vector<std::uint32_t> samples;
            std::vector<std::uint64_t> rays;
            session.Render(settings, [&](const Progress& progress) {
                if (session.HasImage()) {
                    fractions.push_back(progress.fraction);
                    samples.push_back(progress.samplesDone);
                    rays.push_back(nlohmann::json::parse(session.Statistics())["rays"]["camera"]);
                }
                return true;
            });
            EXPECT_EQ(fractions, ExpectedFractions(settings)) << interactive << " " << seconds;
            EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
            EXPECT_TRUE(std::is_sorted(samples.begin(), samples.end()));
            EXPECT_TRUE(std::is_sorted(rays.begin(), rays.end()));
            EXPECT_EQ(fractions.back(), 1.0);
            EXPECT_EQ(rays.back(), std::uint64_t{64} * settings.imageWidth * settings.imageHeight);
            EXPECT_GE(fractions.size(), rays.back() / settings.waveSize);
        }
    }
}

TEST_F(PassesTest, ACancelledWaveIsNotInTheFilm) {
    const auto stream = [](Settings settings) {
        settings.residency = "stream";
        settings.geometryMemory = "24K";
        settings.chunkBytes = 4096;
        return settings;
    };
    for (const bool streams : {false, true}) {
        Session session;
        FillSession(&session);
        const auto make = [&](std::uint32_t samples) {
            Settings settings = Make(false, kNoTime, samples);
            settings.waveSize = 5000;
            return streams ? stream(settings) : settings;
        };
        std::uint32_t numStopped = 0;
        for (int numAsked = 1; numAsked < 60; numAsked += 7) {
            int asked = 0;
            double told = 0.0;
            RenderWatch watch;
            watch.isCancelled = [&] { return ++asked == numAsked; };
            const auto onProgress = [&](const Progress& progress) {
                told = progress.fraction;
                return true;
            };
            const RenderResult result = session.Render(make(64), onProgress, {}, watch);
            ASSERT_EQ(result, RenderResult::Stopped) << numAsked;
            EXPECT_EQ(asked, numAsked) << "it is not asked again";
            ++numStopped;
            double samples = 0.0;
            const std::vector<ImageLayer> layers = session.Layers();
            for (const std::int32_t count : Layer(layers, "sampleCount").ids) {
                samples += count;
            }
            EXPECT_DOUBLE_EQ(samples, told * 64 * 48 * 32) << numAsked;
        }
        EXPECT_GT(numStopped, 3U);
        session.Render(make(20));
        Session fresh;
        FillSession(&fresh);
        fresh.Render(make(20));
        EXPECT_TRUE(SameLayers(session.Layers(), fresh.Layers()));
    }
}

TEST_F(PassesTest, FirstHitsComeWithTheFirstPicture) {
    Session session;
    FillSession(&session);
    std::vector<ImageLayer> seen;
    RenderWatch watch;
    watch.takesPictures = true;
    const auto onProgress = [&](const Progress& progress) {
        if (progress.previewStride == 1 && seen.empty()) {
            seen = session.Layers(false);
        }
        return true;
    };
    Settings settings = Make(true, kNoTime, 4);
    session.Render(settings, onProgress, {}, watch);
    EXPECT_TRUE(SameLayers({Layer(seen, "depth")}, {Layer(session.Layers(), "depth")}));
}

/// Looking at all pixels for it takes the time of the render that waits.
TEST_F(PassesTest, NobodyWaitsForTheErrorOfAPictureThatAnEditHasEnded) {
    Session session;
    FillSession(&session);
    const auto hasError = [&](bool takesPictures, bool isCut) {
        RenderWatch watch;
        watch.takesPictures = takesPictures;
        const auto onProgress = [&](const Progress& progress) {
            return !isCut || progress.samplesDone < 8;
        };
        session.Render(Make(true, kNoTime, isCut ? 4096 : 8), onProgress, {}, watch);
        const auto statistics = nlohmann::json::parse(session.Statistics());
        const auto& error = statistics["accuracy"]["meanRelativeError"];
        EXPECT_TRUE(error.is_null() || error.get<double>() > 0.0);
        return error.is_number();
    };
    EXPECT_FALSE(hasError(true, true));
    EXPECT_TRUE(hasError(false, true)) << "of a picture that is kept";
    EXPECT_TRUE(hasError(true, false)) << "of one that is done";
}

TEST_F(PassesTest, StatusesOfARenderThreadComeInOrderAndEndWithTheImage) {
    RenderThread thread;
    EXPECT_EQ(thread.Status(), nullptr);
    thread.Post({[](Session& session) { FillSession(&session); }});
    thread.SetSettings(Make(true, kNoTime, 2000));
    double fraction = 0.0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    while (!thread.IsConverged() && std::chrono::steady_clock::now() < end) {
        if (const auto status = thread.Status()) {
            EXPECT_GE(status->progress.fraction, fraction);
            fraction = status->progress.fraction;
            EXPECT_LE(status->version, thread.Version());
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(thread.IsConverged());
    EXPECT_EQ(thread.Status(), thread.Newest()) << "the last status is that of the last image";
    EXPECT_EQ(thread.Status()->progress.fraction, 1.0);
    const auto statistics = nlohmann::json::parse(thread.Status()->statistics);
    EXPECT_EQ(statistics["image"]["samples"], 2000);
}

} // namespace
} // namespace hds::test
