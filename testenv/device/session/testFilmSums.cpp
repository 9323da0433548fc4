// SPDX-License-Identifier: Apache-2.0
// Samples may be split at borders of blocks, between sessions, and a render may stop anywhere and
// go on elsewhere: the bits are those of one render.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"

#include <cstring>

namespace hds::test {
namespace {

constexpr std::uint32_t kSamples = 40; // two blocks and the beginning of a third

/// A prim that shows nothing but the shadows of others.
void MakeCatcher(GeometryPrim* prim) {
    auto geometry = std::make_shared<GeometryDescription>(*prim->geometry);
    geometry->primvars.push_back(
        {"hdstream:shadowCatcher", Interpolation::Constant, 1, std::vector<float>{1.0F}, {}});
    prim->geometry = std::move(geometry);
}

class FilmSumsTest : public DeviceFixture {
protected:
    static Settings SettingsOf(std::uint32_t samples) {
        Settings settings = MakeSettings();
        settings.aovs = {"color", "variance", "sampleCount", "depth"};
        settings.samples = samples;
        return settings;
    }

    static std::vector<ImageLayer> Whole() {
        Session session;
        FillSession(&session);
        EXPECT_EQ(session.Render(SettingsOf(kSamples)), RenderResult::Complete);
        return session.Layers();
    }

    /// The samples [first, end), in a session of its own.
    static FilmSums Range(std::uint32_t first, std::uint32_t end) {
        Session session;
        FillSession(&session);
        const Settings settings = SettingsOf(end);
        FilmSums black{settings.imageWidth, settings.imageHeight, first, first, {}};
        EXPECT_EQ(session.Render(settings, {}, {black}), RenderResult::Complete);
        return session.Film();
    }

    static std::vector<ImageLayer> GoOn(const std::vector<FilmSums>& start) {
        Session session;
        FillSession(&session);
        EXPECT_EQ(session.Render(SettingsOf(kSamples), {}, start), RenderResult::Complete);
        return session.Layers();
    }

    /// What a render fails with that begins with these sums.
    static std::string ErrorOf(const std::vector<FilmSums>& start, Settings settings) {
        Session session;
        FillSession(&session);
        try {
            session.Render(settings, {}, start);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::Usage);
            return error.what();
        }
        return "";
    }
};

TEST_F(FilmSumsTest, BlocksOfDifferentSessionsAddUpToTheBitsOfOne) {
    const std::vector<FilmSums> blocks{Range(0, 16), Range(16, 32), Range(32, 40)};
    EXPECT_TRUE(SameLayers(GoOn(blocks), Whole()));
    // What is not there yet is rendered.
    EXPECT_TRUE(SameLayers(GoOn({blocks[0], blocks[1]}), Whole()));
}

TEST_F(FilmSumsTest, ARangeHasOnlyItsOwnSamples) {
    const FilmSums range = Range(16, 32);
    EXPECT_EQ(range.firstSample, 16U);
    EXPECT_EQ(range.endSample, 32U);
    const FilmSums both = Range(0, 32);
    EXPECT_NE(std::memcmp(range.pixels.data(), both.pixels.data(),
                          range.pixels.size() * sizeof(range.pixels[0])),
              0);
}

TEST_F(FilmSumsTest, ARenderGoesOnFromAnyNumberOfSamples) {
    for (const std::uint32_t done : {1U, 16U, 23U, 40U}) {
        EXPECT_TRUE(SameLayers(GoOn({Range(0, done)}), Whole())) << done;
    }
}

TEST_F(FilmSumsTest, ARenderThatWasStoppedInsideAPassGoesOn) {
    int numInside = 0;
    for (const int numReports : {1, 2, 5, 9}) {
        Session session;
        FillSession(&session);
        Settings settings = SettingsOf(kSamples);
        settings.waveSize = 4096; // several waves a pass
        int left = numReports;
        EXPECT_EQ(session.Render(settings,
                                 [&](const Progress& progress) {
                                     return progress.fraction == 0.0 || left-- > 0;
                                 }),
                  RenderResult::Stopped);
        const FilmSums sums = session.Film();
        numInside += sums.MostSamples() > sums.endSample ? 1 : 0;
        EXPECT_TRUE(SameLayers(GoOn({sums}), Whole())) << numReports;
    }
    EXPECT_GT(numInside, 1);
}

/// Of a film that holds the render before.
TEST_F(FilmSumsTest, PixelsThatAStoppedRenderHasNotReachedAreBlack) {
    struct Case {
        bool interactive;
        bool hasOthers; ///< sums beside light paths: of shadow catchers and ambient occlusion
    };
    for (const auto [interactive, hasOthers] :
         {Case{false, false}, Case{true, false}, Case{false, true}, Case{true, true}}) {
        Session session;
        FillSession(&session);
        Settings settings = SettingsOf(3);
        settings.aovs.insert(settings.aovs.end(), {"diffuse", "direct"});
        settings.interactive = interactive;
        if (hasOthers) {
            settings.aovs.emplace_back("ambientOcclusion");
            GeometryPrim ground = session.Scene().geometry.at("/ground");
            MakeCatcher(&ground);
            session.SetGeometry("/ground", ground);
        }
        EXPECT_EQ(session.Render(settings), RenderResult::Complete);
        settings.samples = 1;
        settings.waveSize = 300; // of 1536 pixels
        int left = 2;
        EXPECT_EQ(session.Render(settings,
                                 [&](const Progress& progress) {
                                     return progress.fraction == 0.0 || left-- > 0;
                                 }),
                  RenderResult::Stopped);
        const FilmSums some = session.Film();
        EXPECT_EQ(session.Render(settings), RenderResult::Complete);
        const FilmSums all = session.Film();
        std::size_t numReached = 0;
        for (std::size_t i = 0; i < all.pixels.size(); ++i) {
            const bool isReached = some.pixels[i].numSamples > 0;
            numReached += isReached ? 1 : 0;
            const shared::HdsFilmPixel pixel = isReached ? all.pixels[i] : shared::HdsFilmPixel{};
            EXPECT_EQ(std::memcmp(&some.pixels[i], &pixel, sizeof(pixel)), 0) << i;
            for (std::size_t at = i; at < all.lightPathPixels.size(); at += all.pixels.size()) {
                const shared::HdsLightPathPixel sum =
                    isReached ? all.lightPathPixels[at] : shared::HdsLightPathPixel{};
                EXPECT_EQ(std::memcmp(&some.lightPathPixels[at], &sum, sizeof(sum)), 0) << at;
            }
        }
        EXPECT_GT(numReached, 0U);
        EXPECT_LT(numReached, all.pixels.size());
        EXPECT_EQ(all.lightPathPixels.size(), (hasOthers ? 5 : 2) * all.pixels.size());
    }
}

TEST_F(FilmSumsTest, SumsThatDoNotFitAreErrors) {
    const FilmSums first = Range(0, 16);
    const FilmSums third = Range(32, 40);
    EXPECT_NE(ErrorOf({first, third}, SettingsOf(kSamples)).find("follow each other"),
              std::string::npos);
    EXPECT_NE(ErrorOf({first}, SettingsOf(8)).find("8 samples"), std::string::npos);
    Settings wide = SettingsOf(kSamples);
    wide.imageWidth += 1;
    EXPECT_NE(ErrorOf({first}, wide).find("pixels"), std::string::npos);
    Settings adaptive = SettingsOf(kSamples);
    adaptive.noise = 0.1;
    EXPECT_NE(ErrorOf({first}, adaptive).find("--noise"), std::string::npos);
    FilmSums odd = first;
    odd.firstSample = 3;
    EXPECT_NE(ErrorOf({odd}, SettingsOf(kSamples)).find("multiples"), std::string::npos);
    FilmSums cut = first;
    cut.pixels.pop_back();
    EXPECT_NE(ErrorOf({cut}, SettingsOf(kSamples)).find("missing"), std::string::npos);
}

} // namespace
} // namespace hds::test
