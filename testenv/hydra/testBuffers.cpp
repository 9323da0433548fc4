// SPDX-License-Identifier: Apache-2.0
// Render buffers: allocation, mapping, replacement.
#include "hydraTest.h"

#include <pxr/base/tf/errorMark.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <thread>

namespace hydraHost {

namespace {

/// Buffers without a scene delegate, as applications allocate them directly.
class Buffers : public HydraTest {
protected:
    void SetUp() override {
        HydraTest::SetUp();
        if (!IsSkipped()) {
            _host = std::make_unique<Host>(EmptyScene(), Quick());
            _buffer = static_cast<HdRenderBuffer*>(
                _host->Delegate().CreateBprim(HdPrimTypeTokens->renderBuffer, SdfPath("/own")));
            ASSERT_NE(_buffer, nullptr);
        }
    }
    void TearDown() override {
        if (_buffer) {
            _buffer->Finalize(_host->Delegate().GetRenderParam());
            _host->Delegate().DestroyBprim(_buffer);
        }
    }
    std::unique_ptr<Host> _host;
    HdRenderBuffer* _buffer = nullptr;
};

TEST_F(Buffers, AllocateAllFormatsAskedFor) {
    for (const HdFormat format : {HdFormatUNorm8Vec4, HdFormatFloat16Vec4, HdFormatFloat32Vec4,
                                  HdFormatFloat32, HdFormatFloat32Vec3, HdFormatInt32}) {
        EXPECT_TRUE(_buffer->Allocate(GfVec3i(5, 3, 1), format, false));
        EXPECT_EQ(_buffer->GetFormat(), format);
        EXPECT_EQ(_buffer->GetWidth(), 5U);
        EXPECT_EQ(_buffer->GetHeight(), 3U);
        EXPECT_EQ(_buffer->GetDepth(), 1U);
        EXPECT_FALSE(_buffer->IsMapped());
        ASSERT_NE(_buffer->Map(), nullptr);
        EXPECT_TRUE(_buffer->IsMapped());
        _buffer->Unmap();
        EXPECT_FALSE(_buffer->IsMapped());
    }
}

TEST_F(Buffers, AllocateReplacesWhenOnlyTheShapeChanges) {
    ASSERT_TRUE(_buffer->Allocate(GfVec3i(12, 4, 1), HdFormatFloat32Vec4, false));
    ASSERT_TRUE(_buffer->Allocate(GfVec3i(4, 12, 1), HdFormatFloat32Vec4, false));
    EXPECT_EQ(_buffer->GetWidth(), 4U);
    EXPECT_EQ(_buffer->GetHeight(), 12U);
    // Equal bytes, another format.
    ASSERT_TRUE(_buffer->Allocate(GfVec3i(4, 12, 1), HdFormatFloat32, false));
    ASSERT_TRUE(_buffer->Allocate(GfVec3i(4, 12, 1), HdFormatInt32, false));
    EXPECT_EQ(_buffer->GetFormat(), HdFormatInt32);
}

TEST_F(Buffers, WrongRequestsFail) {
    TfErrorMark mark;
    EXPECT_FALSE(_buffer->Allocate(GfVec3i(-1, 4, 1), HdFormatFloat32Vec4, false));
    EXPECT_FALSE(_buffer->Allocate(GfVec3i(4, 4, 1), HdFormatInvalid, false));
    mark.Clear();
}

TEST_F(Buffers, MapIsCountedAndThreadSafe) {
    ASSERT_TRUE(_buffer->Allocate(GfVec3i(64, 64, 1), HdFormatFloat32Vec4, false));
    void* outer = _buffer->Map();
    ASSERT_NE(outer, nullptr);
    std::vector<std::thread> threads;
    std::atomic<int> numWrong{0};
    for (int thread = 0; thread < 4; ++thread) {
        threads.emplace_back([this, outer, &numWrong] {
            for (int i = 0; i < 1000; ++i) {
                numWrong += _buffer->Map() != outer;
                numWrong += !_buffer->IsMapped();
                _buffer->Unmap();
            }
        });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
    EXPECT_EQ(numWrong, 0);
    EXPECT_TRUE(_buffer->IsMapped()) << "the outer map is still held";
    _buffer->Unmap();
    EXPECT_FALSE(_buffer->IsMapped());
}

using BoundBuffers = HydraTest;

constexpr int kWidth = 64;
constexpr int kHeight = 48;
const std::size_t kBytes = std::size_t(kWidth) * kHeight * HdDataSizeOfFormat(HdFormatFloat32Vec4);

/// Asks without frames. \return false when it did not come true in the time of any render here.
bool Becomes(const std::function<bool()>& condition) {
    constexpr int kTries = 30000;
    for (int i = 0; i < kTries; ++i) {
        if (condition()) {
            return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
}

TEST_F(BoundBuffers, MappedPixelsStayWhileTheRenderGoesOn) {
    Host host(ThreeMeshes(), Quick({HdAovTokens->color}, 1000000));
    HdRenderBuffer* buffer = nullptr;
    ASSERT_TRUE(host.FrameUntil([&] { return host.Statistic("numCompletedSamples") >= 1.0; }));
    buffer = host.Buffer(HdAovTokens->color);
    buffer->Resolve();
    const auto* pixels = static_cast<const std::uint8_t*>(buffer->Map());
    ASSERT_NE(pixels, nullptr);
    const size_t numBytes = size_t(64) * 48 * HdDataSizeOfFormat(buffer->GetFormat());
    const std::vector<std::uint8_t> first(pixels, pixels + numBytes);
    const double samples = host.Statistic("numCompletedSamples");
    ASSERT_TRUE(
        host.FrameUntil([&] { return host.Statistic("numCompletedSamples") >= samples + 2.0; }));
    EXPECT_TRUE(std::equal(first.begin(), first.end(), pixels));
    buffer->Unmap();
}

TEST_F(BoundBuffers, ResolveShowsWhatHasComeSinceTheFrame) {
    const HostOptions options = Quick({HdAovTokens->color}, 8);
    Host host(ThreeMeshes(), options);
    host.Frame();
    HdRenderBuffer* buffer = host.Buffer(HdAovTokens->color);
    const Image rendered = RenderFresh(host, options);
    EXPECT_TRUE(Becomes([&] { return host.Read() == rendered; }));
    EXPECT_FALSE(buffer->IsConverged()) << "no frame has said so";
    EXPECT_TRUE(host.RenderUntilConverged());
    EXPECT_EQ(host.Read(), rendered);
}

TEST_F(BoundBuffers, ResolveLeavesPixelsThatSomebodyReads) {
    Host host(ThreeMeshes(), Quick());
    host.Frame();
    HdRenderBuffer* buffer = host.Buffer(HdAovTokens->color);
    const auto* pixels = static_cast<const std::uint8_t*>(buffer->Map());
    ASSERT_NE(pixels, nullptr);
    const std::vector<std::uint8_t> before(pixels, pixels + kBytes);
    ASSERT_TRUE(Becomes([&] { return host.Statistic("percentDone") == 100.0; }));
    buffer->Resolve();
    EXPECT_TRUE(std::equal(before.begin(), before.end(), pixels));
    buffer->Unmap();
    EXPECT_NE(host.Read().bytes, before) << "the render is done, and nobody reads";
}

TEST_F(BoundBuffers, OtherThreadsMayResolveWhileFramesRun) {
    HostOptions options = Quick({HdAovTokens->color, HdAovTokens->depth}, 32);
    options.settings[HdRenderSettingsTokens->enableInteractive] = VtValue(true);
    Host host(ThreeMeshes(), options);
    host.Frame();
    std::atomic<bool> isOver{false};
    std::vector<std::thread> readers;
    for (const TfToken& aov : {HdAovTokens->color, HdAovTokens->depth, HdAovTokens->color}) {
        readers.emplace_back([&isOver, buffer = host.Buffer(aov)] {
            while (!isOver) {
                buffer->Resolve();
                const Image image = ReadBuffer(buffer);
                EXPECT_EQ(image.width, kWidth);
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
        });
    }
    EXPECT_TRUE(host.RenderUntilConverged());
    isOver = true;
    for (std::thread& reader : readers) {
        reader.join();
    }
    EXPECT_EQ(host.Render(), RenderFresh(host, options));
}

TEST_F(BoundBuffers, ResolveKeepsOutputsTogether) {
    HostOptions options = Quick({HdAovTokens->color, TfToken("alpha")}, 1000000);
    options.aovs[0].clearValue = VtValue(GfVec4f(0.0F));
    options.settings[HdRenderSettingsTokens->domeLightCameraVisibility] = VtValue(false);
    Host host(ThreeMeshes(), options);
    ASSERT_TRUE(host.FrameUntil([&] { return host.Statistic("numCompletedSamples") >= 1.0; }));
    std::set<std::vector<std::uint8_t>> alphas;
    int numApart = 0;
    EXPECT_TRUE(Becomes([&] {
        const Image color = host.Read();
        // Long enough for another image, now and then.
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        const Image alpha = host.Read(TfToken("alpha"));
        for (int x = 0; x < color.width; ++x) {
            for (int y = 0; y < color.height; ++y) {
                numApart += color.Float(x, y, 3) != alpha.Float(x, y) ? 1 : 0;
            }
        }
        alphas.insert(alpha.bytes);
        return alphas.size() > 20;
    }));
    EXPECT_EQ(numApart, 0);
}

/// Another task of the host's application, with a camera and a buffer of its own.
class OtherView {
public:
    OtherView(Host& host, const SdfPath& camera, const SdfPath& buffer)
        : _host(host), _buffer(buffer) {
        const HdRprimCollection collection(HdTokens->geometry,
                                           HdReprSelector(HdReprTokens->refined));
        auto task = std::make_shared<RenderTask>(
            host.Delegate().CreateRenderPass(&host.Index(), collection),
            host.Delegate().CreateRenderPassState());
        task->SetCamera(camera);
        task->SetRenderTags({HdRenderTagTokens->geometry});
        task->State().SetFraming(CameraUtilFraming(GfRect2i(GfVec2i(0, 0), kWidth, kHeight)));
        HdRenderPassAovBinding binding;
        binding.aovName = HdAovTokens->color;
        binding.renderBufferId = buffer;
        binding.clearValue = VtValue(GfVec4f(0.0F));
        task->SetAovBindings({binding});
        host.Scene().SetBuffer(buffer, HdRenderBufferDescriptor(GfVec3i(kWidth, kHeight, 1),
                                                                HdFormatFloat32Vec4, false));
        _tasks = {task};
    }

    void Frame() { _engine.Execute(&_host.Index(), &_tasks); }
    Image Read() {
        auto* buffer = static_cast<HdRenderBuffer*>(
            _host.Index().GetBprim(HdPrimTypeTokens->renderBuffer, _buffer));
        buffer->Resolve();
        return ReadBuffer(buffer);
    }

private:
    Host& _host;
    SdfPath _buffer;
    HdTaskSharedPtrVector _tasks;
    HdEngine _engine;
};

TEST_F(BoundBuffers, ResolveShowsNothingOfAnotherPass) {
    SceneData scene = ThreeMeshes();
    const SdfPath other("/other");
    scene.cameras[other] = MakeCamera(GfVec3d(0.4, 0.2, 3.0));
    const HostOptions options = Quick();
    Host host(scene, options);
    const Image shown = host.Render();
    OtherView view(host, other, SdfPath("/otherBuffer"));
    view.Frame();
    scene.cameras[SdfPath("/camera")] = scene.cameras[other];
    const Image expected = Host(scene, options).Render();
    EXPECT_TRUE(Becomes([&] { return view.Read() == expected; }));
    EXPECT_NE(shown, expected);
    EXPECT_EQ(host.Read(), shown);
}

TEST_F(BoundBuffers, AovsMayBeReplacedWhileRendering) {
    const HostOptions options = Quick({HdAovTokens->color}, 8);
    Host host(ThreeMeshes(), options);
    for (int round = 0; round < 10; ++round) {
        host.SetAovs({HdAovTokens->depth, HdAovTokens->normal});
        host.Frame();
        host.SetAovs({HdAovTokens->color});
        host.SetSize(64 - round, 48 + round);
        host.Frame();
    }
    host.SetSize(64, 48);
    EXPECT_EQ(host.Render(), RenderFresh(host, options));
}

TEST_F(BoundBuffers, BitsDoNotDependOnTheOtherAovs) {
    Host alone(ThreeMeshes(), Quick());
    Host together(ThreeMeshes(), Quick({HdAovTokens->normal, HdAovTokens->depth, HdAovTokens->color,
                                        HdAovTokens->primId}));
    EXPECT_EQ(together.Render(), alone.Render());
}

} // namespace

} // namespace hydraHost
