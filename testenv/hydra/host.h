// SPDX-License-Identifier: Apache-2.0
// A small Hydra application on the CPU: a renderer plug-in, a render index, a synthetic scene, and
// one render task with AOV buffers. It knows the renderer by its plug-in id only.
// Explained in docs/testing.md.
#pragma once

#include "hostDelegate.h"
#include "hostImage.h"
#include "hostTask.h"

#include <pxr/imaging/cameraUtil/framing.h>
#include <pxr/imaging/hd/engine.h>
#include <pxr/imaging/hd/pluginRenderDelegateUniqueHandle.h>
#include <pxr/imaging/hd/renderDelegate.h>
#include <pxr/imaging/hd/renderIndex.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hydraHost {

/// The renderer under test: HDSTREAM_TEST_RENDERER, else "HdStreamRendererPlugin".
TfToken RendererId();

/// True when the plug-in is found and its code loads.
bool HasRenderer(const TfToken& renderer);

/// An AOV to render; what is not set comes from the renderer's default descriptor.
struct AovRequest {
    AovRequest(const TfToken& aovName) : name(aovName) {}
    TfToken name;
    std::optional<HdFormat> format;
    std::optional<VtValue> clearValue;
    HdAovSettingsMap settings; ///< of the binding
};

struct HostOptions {
    TfToken renderer = RendererId();
    HdRenderSettingsMap settings;
    int width = 64;
    int height = 48;
    std::vector<AovRequest> aovs{HdAovTokens->color};
    bool hasTaskPerAov = false; ///< a task and a render pass for each, else one for all
};

/// Externally synchronised. Several may live in one process, each on its own thread.
class Host {
public:
    /// The camera that is rendered is "/camera".
    explicit Host(const SceneData& scene, const HostOptions& options = {});
    /// Also while the renderer is at work.
    ~Host();
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    HdRenderDelegate& Delegate() { return *_renderer.Get(); }
    HdRenderIndex& Index() { return *_index; }
    SyntheticScene& Scene() { return *_scene; }
    RenderTask& Task() { return *_tasks.front(); }

    /// Replaces the AOVs: old buffers are destroyed, new ones created.
    void SetAovs(const std::vector<AovRequest>& aovs);
    /// Size of the buffers; the framing becomes the whole buffer.
    void SetSize(int width, int height);
    void SetFraming(const CameraUtilFraming& framing);
    /// What all render passes draw.
    void SetCollection(const HdRprimCollection& collection);
    void SetSetting(const char* name, const VtValue& value);

    /// One frame of the application: sync, commit, execute.
    /// \return whether all render passes say that they have converged.
    bool Frame();
    /// Frames until convergence. \return false when it took longer than any render here may.
    bool RenderUntilConverged();
    /// Frames until `condition` holds; false when it did not in time.
    bool FrameUntil(const std::function<bool()>& condition);

    HdRenderBuffer* Buffer(const TfToken& aov);
    /// Resolves and reads.
    Image Read(const TfToken& aov = HdAovTokens->color);
    /// RenderUntilConverged and Read; an empty image when it did not converge.
    Image Render(const TfToken& aov = HdAovTokens->color);

    /// A number of the render statistics by its path, "geometry.chunksBuilt".
    /// \return -1 when there is none.
    double Statistic(const std::string& path);

private:
    void _SetBuffers();
    bool _IsConverged() const;

    HdPluginRenderDelegateUniqueHandle _renderer;
    std::unique_ptr<HdRenderIndex> _index;
    std::unique_ptr<SyntheticScene> _scene;
    std::vector<std::shared_ptr<RenderTask>> _tasks; ///< at least one
    HdEngine _engine;
    std::vector<AovRequest> _aovs;
    int _width;
    int _height;
};

} // namespace hydraHost
