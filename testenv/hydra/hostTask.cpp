// SPDX-License-Identifier: Apache-2.0
// The host's render task.
#include "hostTask.h"

#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/renderBuffer.h>
#include <pxr/imaging/hd/renderDelegate.h>
#include <pxr/imaging/hd/renderIndex.h>

namespace hydraHost {

RenderTask::RenderTask(const HdRenderPassSharedPtr& pass, const HdRenderPassStateSharedPtr& state)
    : HdTask(SdfPath::EmptyPath()), _pass(pass), _state(state) {}

void RenderTask::Sync(HdSceneDelegate*, HdTaskContext*, HdDirtyBits* dirtyBits) {
    _pass->Sync();
    *dirtyBits = HdChangeTracker::Clean;
}

void RenderTask::Prepare(HdTaskContext*, HdRenderIndex* index) {
    for (HdRenderPassAovBinding& binding : _bindings) {
        binding.renderBuffer = dynamic_cast<HdRenderBuffer*>(
            index->GetBprim(HdPrimTypeTokens->renderBuffer, binding.renderBufferId));
    }
    _state->SetAovBindings(_bindings);
    _state->SetCamera(
        dynamic_cast<const HdCamera*>(index->GetSprim(HdPrimTypeTokens->camera, _camera)));
    _state->Prepare(index->GetResourceRegistry());
}

void RenderTask::Execute(HdTaskContext*) {
    _pass->Execute(_state, _renderTags);
}

} // namespace hydraHost
