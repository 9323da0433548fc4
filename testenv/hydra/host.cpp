// SPDX-License-Identifier: Apache-2.0
// The Hydra host.
#include "host.h"

#include <pxr/base/plug/registry.h>
#include <pxr/base/tf/getenv.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/renderBuffer.h>
#include <pxr/imaging/hd/rendererPlugin.h>
#include <pxr/imaging/hd/rendererPluginRegistry.h>
#include <pxr/imaging/hd/rprimCollection.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace hydraHost {

namespace {

/// A render of these tests takes seconds; only one that hangs takes longer, sanitizers included.
constexpr std::chrono::seconds kHangLimit(300);

SdfPath BufferPath(const TfToken& aov) {
    return SdfPath("/hostBuffers").AppendChild(TfToken(TfMakeValidIdentifier(aov.GetString())));
}

void RegisterTestPlugin() {
#ifdef HDSTREAM_TEST_PLUGIN_PATH
    static const bool isRegistered = [] {
        PlugRegistry::GetInstance().RegisterPlugins(
            TfGetenv("HDSTREAM_TEST_PLUGIN", HDSTREAM_TEST_PLUGIN_PATH));
        return true;
    }();
    (void)isRegistered;
#endif
}

} // namespace

TfToken RendererId() {
    return TfToken(TfGetenv("HDSTREAM_TEST_RENDERER", "HdStreamRendererPlugin"));
}

bool HasRenderer(const TfToken& renderer) {
    RegisterTestPlugin();
    HdRendererPluginRegistry& registry = HdRendererPluginRegistry::GetInstance();
    if (!registry.IsRegisteredPlugin(renderer)) {
        return false;
    }
    return bool(registry.CreateRenderDelegate(renderer));
}

Host::Host(const SceneData& scene, const HostOptions& options)
    : _width(options.width), _height(options.height) {
    RegisterTestPlugin();
    _renderer = HdRendererPluginRegistry::GetInstance().CreateRenderDelegate(options.renderer,
                                                                             options.settings);
    TF_AXIOM(_renderer);
    _index.reset(HdRenderIndex::New(_renderer.Get(), {}));
    _scene = std::make_unique<SyntheticScene>(_index.get(), SdfPath::AbsoluteRootPath());
    _scene->Insert(scene);
    HdRprimCollection collection(HdTokens->geometry, HdReprSelector(HdReprTokens->refined));
    const std::size_t numTasks = options.hasTaskPerAov ? options.aovs.size() : 1;
    for (std::size_t i = 0; i < numTasks; ++i) {
        auto task =
            std::make_shared<RenderTask>(_renderer->CreateRenderPass(_index.get(), collection),
                                         _renderer->CreateRenderPassState());
        task->SetCamera(SdfPath("/camera"));
        task->SetRenderTags({HdRenderTagTokens->geometry, HdRenderTagTokens->render});
        _tasks.push_back(std::move(task));
    }
    SetAovs(options.aovs);
    SetSize(_width, _height);
}

Host::~Host() {
    // As applications do: tasks, then the scene's prims, the index, and the renderer last.
    _tasks.clear();
    _index->Clear();
    _scene.reset();
    _index.reset();
}

void Host::SetAovs(const std::vector<AovRequest>& aovs) {
    for (const AovRequest& aov : _aovs) {
        _scene->RemoveBuffer(BufferPath(aov.name));
    }
    _aovs = aovs;
    std::vector<HdRenderPassAovBindingVector> bindings(_tasks.size());
    for (std::size_t i = 0; i < _aovs.size(); ++i) {
        const AovRequest& aov = _aovs[i];
        HdRenderPassAovBinding& binding = bindings[i % _tasks.size()].emplace_back();
        binding.aovName = aov.name;
        binding.aovSettings = aov.settings;
        binding.renderBufferId = BufferPath(aov.name);
        binding.clearValue =
            aov.clearValue.value_or(_renderer->GetDefaultAovDescriptor(aov.name).clearValue);
    }
    for (std::size_t i = 0; i < _tasks.size(); ++i) {
        _tasks[i]->SetAovBindings(bindings[i]);
    }
    _SetBuffers();
}

void Host::_SetBuffers() {
    for (const AovRequest& aov : _aovs) {
        const HdAovDescriptor descriptor = _renderer->GetDefaultAovDescriptor(aov.name);
        _scene->SetBuffer(BufferPath(aov.name),
                          HdRenderBufferDescriptor(GfVec3i(_width, _height, 1),
                                                   aov.format.value_or(descriptor.format),
                                                   descriptor.multiSampled));
    }
}

void Host::SetSize(int width, int height) {
    _width = width;
    _height = height;
    _SetBuffers();
    SetFraming(CameraUtilFraming(GfRect2i(GfVec2i(0, 0), width, height)));
}

void Host::SetFraming(const CameraUtilFraming& framing) {
    for (const auto& task : _tasks) {
        task->State().SetFraming(framing);
    }
}

void Host::SetCollection(const HdRprimCollection& collection) {
    for (const auto& task : _tasks) {
        task->Pass().SetRprimCollection(collection);
    }
}

void Host::SetSetting(const char* name, const VtValue& value) {
    _renderer->SetRenderSetting(TfToken(name), value);
}

bool Host::Frame() {
    HdTaskSharedPtrVector tasks(_tasks.begin(), _tasks.end());
    _engine.Execute(_index.get(), &tasks);
    return _IsConverged();
}

bool Host::_IsConverged() const {
    return std::all_of(_tasks.begin(), _tasks.end(),
                       [](const auto& task) { return task->IsConverged(); });
}

bool Host::FrameUntil(const std::function<bool()>& condition) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < kHangLimit) {
        Frame();
        if (condition()) {
            return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
}

bool Host::RenderUntilConverged() {
    return FrameUntil([this] { return _IsConverged(); });
}

HdRenderBuffer* Host::Buffer(const TfToken& aov) {
    return dynamic_cast<HdRenderBuffer*>(
        _index->GetBprim(HdPrimTypeTokens->renderBuffer, BufferPath(aov)));
}

Image Host::Read(const TfToken& aov) {
    HdRenderBuffer* buffer = Buffer(aov);
    buffer->Resolve();
    return ReadBuffer(buffer);
}

Image Host::Render(const TfToken& aov) {
    return RenderUntilConverged() ? Read(aov) : Image();
}

double Host::Statistic(const std::string& path) {
    const VtDictionary stats = _renderer->GetRenderStats();
    const VtValue* value = stats.GetValueAtPath(path, ".");
    if (!value) {
        return -1.0;
    }
    const VtValue number = VtValue::Cast<double>(*value);
    return number.IsHolding<double>() ? number.UncheckedGet<double>() : -1.0;
}

} // namespace hydraHost
