// SPDX-License-Identifier: Apache-2.0
// General kernels render until those of the scene's own are there; the picture has the same bits.
#include "hdStream/device/kernelCompilers.h"
#include "hdStream/integrator/generalKernels.h"
#include "hdStream/integrator/kernelSets.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"
#include "testenv/support/temporaryFolder.h"

#include <nlohmann/json.hpp>

#include <chrono>

namespace hds::test {
namespace {

class GeneralKernelsTest : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        if (device && !device->Properties().hasSlowBinaries) {
            GTEST_SKIP() << "the driver compiles fast";
        }
    }
};

/// Which kernels a render begins with, by what the store has.
TEST_F(GeneralKernelsTest, AreChosenWhereOwnOnesAreNotThere) {
    Warnings warnings;
    const TemporaryFolder folder;
    Store store({folder.Path()}, &warnings);
    KernelFeatures own;
    own.simd8 = true;
    own.groups = true;
    const KernelFeatures general = GeneralFeatures(own).front();
    const auto choose = [&](KernelChoice choice, bool mayWait) {
        return KernelSets(device, &store).Choose(own, choice, mayWait);
    };
    EXPECT_EQ(choose(KernelChoice::Auto, true), own) << "nothing is there";
    StageKernels(device, &store, general).SaveBinaries(&store);
    EXPECT_EQ(choose(KernelChoice::Auto, true), general);
    EXPECT_EQ(choose(KernelChoice::Own, true), own);
    KernelSets(device, &store).AddGeneralSeconds(own, 10.0);
    EXPECT_EQ(choose(KernelChoice::Auto, true), general);
    KernelSets(device, &store).AddGeneralSeconds(own, 1000.0);
    EXPECT_EQ(choose(KernelChoice::Auto, true), own) << "renders have paid for them";
    EXPECT_EQ(choose(KernelChoice::Auto, false), general) << "somebody looks on";
    KernelFeatures other = own;
    other.lightTree = true;
    EXPECT_EQ(KernelSets(device, &store).Choose(other, KernelChoice::Auto, true), general)
        << "they have paid for one set";
    StageKernels(device, &store, own).SaveBinaries(&store);
    EXPECT_EQ(choose(KernelChoice::Auto, false), own);
    EXPECT_EQ(choose(KernelChoice::General, true), general);
    EXPECT_TRUE(warnings.Lines().empty());
}

/// A long render changes its kernels on the way.
TEST_F(GeneralKernelsTest, LeaveWhenOwnOnesCome) {
    if (KernelCompilers::DefaultExecutable().empty()) {
        GTEST_SKIP() << "no program that compiles";
    }
    const TemporaryFolder folder;
    Settings settings = MakeSettings();
    settings.cacheDirectory = folder.Path();
    settings.noCache = false;
    settings.samples = 1U << 22U; // hours
    settings.passSeconds = 1e-3;  // of a wave each: who stops has all pixels equally often
    settings.waveSize = 1U << 17U;
    const auto kernelsOf = [](const Session& session) {
        return nlohmann::json::parse(session.Statistics())["wave"]["kernels"].get<std::string>();
    };
    {
        Settings first = settings; // so that general kernels are there
        first.kernels = "general";
        Session session;
        FillSession(&session);
        ASSERT_EQ(session.Render(first, [](const Progress& p) { return p.samplesDone == 0; }),
                  RenderResult::Stopped);
        ASSERT_EQ(kernelsOf(session), "general");
    }
    Session session;
    FillSession(&session);
    std::string begin;
    std::string end;
    const auto start = std::chrono::steady_clock::now();
    const auto onProgress = [&](const Progress& progress) {
        if (progress.fraction == 0.0) {
            return true; // it is not rendering yet
        }
        end = kernelsOf(session);
        begin = begin.empty() ? end : begin;
        const bool isLate = std::chrono::steady_clock::now() - start > std::chrono::minutes(3);
        return (end == "general" || progress.samplesDone == 0) && !isLate;
    };
    ASSERT_EQ(session.Render(settings, onProgress), RenderResult::Stopped);
    EXPECT_EQ(begin, "general");
    ASSERT_EQ(end, "own");
    Settings own = settings;
    own.kernels = "own";
    own.samples =
        nlohmann::json::parse(session.Statistics())["image"]["samples"].get<std::uint32_t>();
    Session again;
    FillSession(&again);
    ASSERT_EQ(again.Render(own), RenderResult::Complete);
    EXPECT_TRUE(SameLayers(session.Layers(), again.Layers()));
}

} // namespace
} // namespace hds::test
