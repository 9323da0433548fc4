// SPDX-License-Identifier: Apache-2.0
// The one task of the Hydra host: a render pass over all geometry into AOV buffers, on the CPU.
#pragma once

#include <pxr/imaging/hd/renderPass.h>
#include <pxr/imaging/hd/renderPassState.h>
#include <pxr/imaging/hd/task.h>

namespace hydraHost {

PXR_NAMESPACE_USING_DIRECTIVE

/// Not in the index: the engine gets it directly, and the host sets its state between frames.
class RenderTask final : public HdTask {
public:
    RenderTask(const HdRenderPassSharedPtr& pass, const HdRenderPassStateSharedPtr& state);

    void SetCamera(const SdfPath& camera) { _camera = camera; }
    void SetRenderTags(const TfTokenVector& tags) { _renderTags = tags; }
    /// Buffers are looked up by renderBufferId in each frame.
    void SetAovBindings(const HdRenderPassAovBindingVector& bindings) { _bindings = bindings; }
    HdRenderPassState& State() { return *_state; }
    HdRenderPass& Pass() { return *_pass; }
    bool IsConverged() const { return _pass->IsConverged(); }

    void Sync(HdSceneDelegate* delegate, HdTaskContext* context, HdDirtyBits* dirtyBits) override;
    void Prepare(HdTaskContext* context, HdRenderIndex* index) override;
    void Execute(HdTaskContext* context) override;
    const TfTokenVector& GetRenderTags() const override { return _renderTags; }

private:
    HdRenderPassSharedPtr _pass;
    HdRenderPassStateSharedPtr _state;
    SdfPath _camera;
    TfTokenVector _renderTags;
    HdRenderPassAovBindingVector _bindings;
};

} // namespace hydraHost
