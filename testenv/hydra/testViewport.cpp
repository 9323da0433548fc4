// SPDX-License-Identifier: Apache-2.0
// A viewport's calls, as Blender's engine, usdview and Houdini make them, in any order: buffers
// that change their size in place, cameras moved, outputs bound late, pause, stop, restart,
// settings changed, engines that are thrown away while they render. The last picture is a fresh
// delegate's.
#include "hydraTest.h"

#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/changeTracker.h>

#include <chrono>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace hydraHost {

namespace {

using Viewport = HydraTest;

const SdfPath kCamera("/camera");
constexpr int kSamples = 8;

void Rest() {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

void DragCamera(Host& host, double x) {
    CameraData camera = host.Scene().Data().cameras.at(kCamera);
    camera.transform = Translation(x, 0.1 * x, 5.0 - 0.2 * x);
    host.Scene().SetCamera(kCamera, camera, HdCamera::DirtyTransform);
}

/// A viewport and what it has chosen so far, from which a fresh one can be made.
class View {
public:
    View() : _options(Quick({HdAovTokens->color}, kSamples)) {
        _options.settings[TfToken("enableInteractive")] = VtValue(true);
        _Open(ThreeMeshes());
    }

    Host& Engine() { return *_host; }

    void Resize(int width, int height) {
        _options.width = width;
        _options.height = height;
        _host->SetSize(width, height);
    }

    void Bind(const std::vector<AovRequest>& aovs) {
        _options.aovs = aovs;
        _host->SetAovs(aovs);
    }

    void SetSetting(const char* name, const VtValue& value) {
        _options.settings[TfToken(name)] = value;
        _host->SetSetting(name, value);
    }

    /// Another shading mode and back: the engine goes, at work or not, and a new one comes.
    void Reopen() {
        const SceneData scene = _host->Scene().Data();
        _host.reset();
        _Open(scene);
    }

    /// What is on the screen once nothing changes any more, and what a fresh delegate shows.
    void ExpectFresh(const std::string& what) {
        _host->Delegate().Resume();
        _host->Delegate().Restart();
        const Image shown = _host->Render();
        ASSERT_EQ(shown.width, _options.width) << what;
        EXPECT_EQ(shown, RenderFresh(*_host, _options)) << what;
    }

private:
    void _Open(const SceneData& scene) { _host = std::make_unique<Host>(scene, _options); }

    HostOptions _options;
    std::unique_ptr<Host> _host;
};

/// One step of a user, or of the host on his behalf, chosen by a number. \return its name.
std::string Step(View& view, std::mt19937& random) {
    const auto below = [&random](unsigned int count) { return int(random() % count); };
    Host& host = view.Engine();
    switch (below(11)) {
    case 0:
        view.Resize(24 + below(80), 16 + below(60));
        return "resize";
    case 1:
        DragCamera(host, 0.1 * below(10));
        return "camera";
    case 2:
        view.Bind(below(2) != 0 ? std::vector<AovRequest>{HdAovTokens->color, HdAovTokens->depth}
                                : std::vector<AovRequest>{HdAovTokens->color});
        return "outputs";
    case 3:
        view.SetSetting("samples", VtValue(kSamples - below(3)));
        return "samples";
    case 4:
        view.SetSetting("maxDepth", VtValue(1 + below(3)));
        return "maxDepth";
    case 5:
        host.Delegate().Pause();
        return "pause";
    case 6:
        host.Delegate().Resume();
        return "resume";
    case 7:
        host.Delegate().Stop(below(2) != 0);
        return "stop";
    case 8:
        host.Delegate().Restart();
        return "restart";
    case 9: {
        GprimData cube = host.Scene().Data().gprims.at(SdfPath("/cube"));
        cube.transform = cube.transform * Translation(0.02 * below(5), 0.0, 0.01);
        cube.isVisible = below(4) != 0;
        host.Scene().SetGprim(SdfPath("/cube"), cube,
                              HdChangeTracker::DirtyTransform | HdChangeTracker::DirtyVisibility);
        return "move";
    }
    default:
        view.Reopen();
        return "reopen";
    }
}

TEST_F(Viewport, AnyOrderOfCallsEndsInTheBitsOfAFreshDelegate) {
    for (unsigned int seed = 1; seed <= 8; ++seed) {
        std::mt19937 random(seed);
        View view;
        std::string steps = "seed " + std::to_string(seed) + ":";
        for (int i = 0; i < 25; ++i) {
            steps += " " + Step(view, random);
            for (unsigned int frames = random() % 3; frames > 0; --frames) {
                view.Engine().Frame();
                Rest();
            }
        }
        view.ExpectFresh(steps);
    }
}

TEST_F(Viewport, ADepthThatIsBoundLateIsWholeAndLeavesTheColour) {
    View view;
    const Image alone = view.Engine().Render();
    // As Blender does when it draws overlays.
    view.Bind({HdAovTokens->color, HdAovTokens->depth});
    EXPECT_EQ(view.Engine().Render(), alone);
    Host both(ThreeMeshes(), Quick({HdAovTokens->color, HdAovTokens->depth}, kSamples));
    EXPECT_EQ(view.Engine().Read(HdAovTokens->depth), both.Render(HdAovTokens->depth));
}

} // namespace

} // namespace hydraHost
