// SPDX-License-Identifier: Apache-2.0
// The state of the render: convergence, pause and stop, errors, a pass that never blocks.
#include "hydraTest.h"

#include <pxr/base/tf/errorMark.h>
#include <pxr/imaging/hd/changeTracker.h>

#include <algorithm>

namespace hydraHost {

namespace {

using Control = HydraTest;

const SdfPath kCube("/cube");

/// More samples than any machine renders during a test: such a render never converges by itself.
constexpr int kEndless = 1000000;

bool IsClear(const Image& image) {
    return std::all_of(image.bytes.begin(), image.bytes.end(), [](auto byte) { return byte == 0; });
}

HostOptions ClearedQuick(int samples) {
    AovRequest color{HdAovTokens->color};
    color.clearValue = VtValue(GfVec4f(0.0F));
    return Quick({color}, samples);
}

void MoveCube(Host& host, double x) {
    GprimData cube = host.Scene().Data().gprims.at(kCube);
    cube.transform = Translation(x, 0.5, 0.0);
    host.Scene().SetGprim(kCube, cube, HdChangeTracker::DirtyTransform);
}

TEST_F(Control, ConvergedMeansThatNothingChangesAnyMore) {
    Host host(ThreeMeshes(), Quick({HdAovTokens->color, HdAovTokens->depth}, 8));
    ASSERT_TRUE(host.RenderUntilConverged());
    // As HdxAovInputTask does: it asks before it resolves.
    HdRenderBuffer* buffer = host.Buffer(HdAovTokens->color);
    EXPECT_TRUE(buffer->IsConverged());
    const Image first = host.Read();
    for (int frame = 0; frame < 5; ++frame) {
        EXPECT_TRUE(host.Frame());
        EXPECT_EQ(host.Read(), first);
    }
    EXPECT_EQ(host.Statistic("image.samples"), 8.0);
}

TEST_F(Control, BufferThatIsConvergedBeforeItsResolveHasTheLastSamples) {
    const HostOptions options = Quick({HdAovTokens->color}, 8);
    Host host(ThreeMeshes(), options);
    HdRenderBuffer* buffer = nullptr;
    ASSERT_TRUE(host.FrameUntil([&] {
        buffer = host.Buffer(HdAovTokens->color);
        return buffer->IsConverged();
    }));
    buffer->Resolve();
    const Image atOnce = ReadBuffer(buffer);
    ASSERT_TRUE(host.RenderUntilConverged());
    EXPECT_EQ(atOnce, host.Read());
}

TEST_F(Control, FramesReturnWhileTheRenderRuns) {
    HostOptions options = ClearedQuick(kEndless);
    options.width = 320;
    options.height = 240;
    Host host(ThreeMeshes(), options);
    for (int frame = 0; frame < 20; ++frame) {
        EXPECT_FALSE(host.Frame());
    }
    // Pixels come before the end.
    EXPECT_TRUE(host.FrameUntil([&] { return !IsClear(host.Read()); }));
    EXPECT_FALSE(host.Task().IsConverged());
    EXPECT_FALSE(host.Buffer(HdAovTokens->color)->IsConverged());
}

TEST_F(Control, SettingsEndAnEndlessRender) {
    const HostOptions few = ClearedQuick(4);
    Host host(ThreeMeshes(), ClearedQuick(kEndless));
    ASSERT_TRUE(host.FrameUntil([&] { return !IsClear(host.Read()); }));
    host.SetSetting("samples", VtValue(4));
    EXPECT_EQ(host.Render(), RenderFresh(host, few));
}

TEST_F(Control, HostsThatTakeStepsGetControlBackAndThenAllSamples) {
    HostOptions options = ClearedQuick(kEndless);
    options.settings[TfToken("hostStepSeconds")] = VtValue(0.01);
    Host host(ThreeMeshes(), options);
    // The pass says that it has converged, and the buffer, which it has not, does not.
    for (int step = 0; step < 3; ++step) {
        EXPECT_TRUE(host.Frame());
        host.Delegate().GetRenderStats(); // waits
        EXPECT_FALSE(host.Buffer(HdAovTokens->color)->IsConverged());
    }
    host.SetSetting("samples", VtValue(4));
    ASSERT_TRUE(host.FrameUntil([&] { //
        host.Delegate().GetRenderStats();
        return host.Buffer(HdAovTokens->color)->IsConverged();
    }));
    EXPECT_EQ(host.Read(), RenderFresh(host, ClearedQuick(4)));
}

TEST_F(Control, TimeLimitConverges) {
    HostOptions options = ClearedQuick(kEndless);
    options.settings[TfToken("timeLimit")] = VtValue(0.2);
    Host host(ThreeMeshes(), options);
    EXPECT_TRUE(host.RenderUntilConverged());
    EXPECT_FALSE(IsClear(host.Read()));
}

TEST_F(Control, WrongDeviceConverges) {
    HostOptions options = ClearedQuick(2);
    options.settings[TfToken("device")] = VtValue(std::string("no such device"));
    TfErrorMark mark;
    Host host(ThreeMeshes(), options);
    EXPECT_TRUE(host.RenderUntilConverged());
    mark.Clear();
    // The error is no state of its own: a right setting renders.
    host.SetSetting("device", VtValue(std::string()));
    EXPECT_EQ(host.Render(), RenderFresh(host, ClearedQuick(2)));
}

TEST_F(Control, WithoutACameraItConverges) {
    SceneData scene = ThreeMeshes();
    scene.cameras.clear();
    TfErrorMark mark;
    Host host(scene, Quick());
    EXPECT_TRUE(host.RenderUntilConverged());
    mark.Clear();
}

TEST_F(Control, WithoutAovsItConverges) {
    Host host(ThreeMeshes(), Quick({}));
    EXPECT_TRUE(host.RenderUntilConverged());
}

TEST_F(Control, EmptySceneConverges) {
    SceneData scene = EmptyScene();
    Host host(scene, Quick({HdAovTokens->color, HdAovTokens->primId}));
    ASSERT_TRUE(host.RenderUntilConverged());
    EXPECT_EQ(host.Read(HdAovTokens->primId).Int(5, 5), -1);
}

TEST_F(Control, StopIsLatchedAcrossEdits) {
    Host host(ThreeMeshes(), ClearedQuick(4));
    const Image before = host.Render();
    EXPECT_FALSE(host.Delegate().IsStopped());
    EXPECT_TRUE(host.Delegate().Stop(true));
    EXPECT_TRUE(host.Delegate().IsStopped());
    MoveCube(host, 0.2);
    for (int frame = 0; frame < 5; ++frame) {
        EXPECT_TRUE(host.Frame()) << "an application that waits must not wait for a stopped render";
        EXPECT_TRUE(host.Delegate().IsStopped());
        EXPECT_EQ(host.Read(), before);
    }
    EXPECT_TRUE(host.Delegate().Restart());
    EXPECT_FALSE(host.Delegate().IsStopped());
    const Image after = host.Render();
    EXPECT_NE(after, before);
    EXPECT_EQ(after, RenderFresh(host, ClearedQuick(4)));
}

TEST_F(Control, StopEndsAnEndlessRender) {
    Host host(ThreeMeshes(), ClearedQuick(kEndless));
    ASSERT_TRUE(host.FrameUntil([&] { return !IsClear(host.Read()); }));
    EXPECT_TRUE(host.Delegate().Stop(true));
    host.Frame();
    const Image stopped = host.Read();
    for (int frame = 0; frame < 5; ++frame) {
        host.Frame();
        EXPECT_EQ(host.Read(), stopped) << "after a blocking stop nothing is written";
    }
}

TEST_F(Control, PauseIsLatchedAcrossEdits) {
    Host host(ThreeMeshes(), ClearedQuick(4));
    const Image before = host.Render();
    EXPECT_FALSE(host.Delegate().IsPaused());
    EXPECT_TRUE(host.Delegate().Pause());
    EXPECT_TRUE(host.Delegate().IsPaused());
    MoveCube(host, 0.2);
    for (int frame = 0; frame < 5; ++frame) {
        EXPECT_FALSE(host.Frame());
        EXPECT_TRUE(host.Delegate().IsPaused());
    }
    EXPECT_TRUE(host.Delegate().Resume());
    EXPECT_FALSE(host.Delegate().IsPaused());
    const Image after = host.Render();
    EXPECT_NE(after, before);
    EXPECT_EQ(after, RenderFresh(host, ClearedQuick(4)));
}

TEST_F(Control, ResumedRenderHasTheBitsOfAnUninterruptedOne) {
    const HostOptions options = ClearedQuick(64);
    Host host(ThreeMeshes(), options);
    host.Frame();
    for (int pause = 0; pause < 4; ++pause) {
        host.Delegate().Pause();
        host.Frame();
        host.Delegate().Resume();
        host.Frame();
    }
    EXPECT_EQ(host.Render(), RenderFresh(host, options));
}

TEST_F(Control, PassesOfOneFrameMayDifferInTheirOutputs) {
    HostOptions options = Quick({HdAovTokens->color, HdAovTokens->primId, HdAovTokens->depth}, 4);
    Host one(ThreeMeshes(), options);
    options.hasTaskPerAov = true;
    Host several(ThreeMeshes(), options);
    for (const AovRequest& aov : options.aovs) {
        EXPECT_EQ(several.Render(aov.name), one.Render(aov.name)) << aov.name;
    }
}

TEST_F(Control, WhatTheSceneDoesNotHaveDoesNotRestart) {
    Host host(ThreeMeshes(), Quick());
    ASSERT_TRUE(host.RenderUntilConverged());
    for (const HdDirtyBits bits : {HdChangeTracker::DirtyRepr, HdChangeTracker::DirtyDisplayStyle,
                                   HdChangeTracker::DirtyExtent, HdChangeTracker::DirtyPoints}) {
        host.Index().GetChangeTracker().MarkAllRprimsDirty(bits);
        EXPECT_TRUE(host.Frame());
    }
    MoveCube(host, -0.5);
    EXPECT_FALSE(host.Frame());
}

TEST_F(Control, SameFrameAgainDoesNotRestart) {
    Host host(ThreeMeshes(), ClearedQuick(kEndless));
    ASSERT_TRUE(host.FrameUntil([&] { return host.Statistic("numCompletedSamples") >= 3.0; }));
    // Restarts would keep the count from growing: each frame here would throw the samples away.
    const double samples = host.Statistic("numCompletedSamples");
    host.SetFraming(host.Task().State().GetFraming());
    EXPECT_TRUE(
        host.FrameUntil([&] { return host.Statistic("numCompletedSamples") >= samples + 3.0; }));
}

} // namespace

} // namespace hydraHost
