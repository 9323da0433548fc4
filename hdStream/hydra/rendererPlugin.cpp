// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/rendererPlugin.h"

#include "hdStream/hydra/renderDelegate.h"

#include <pxr/base/tf/registryManager.h>
#include <pxr/imaging/hd/rendererPluginRegistry.h>

PXR_NAMESPACE_OPEN_SCOPE

TF_REGISTRY_FUNCTION(TfType) {
    HdRendererPluginRegistry::Define<HdStreamRendererPlugin>();
}

HdRenderDelegate* HdStreamRendererPlugin::CreateRenderDelegate() {
    return new HdStreamRenderDelegate({});
}

HdRenderDelegate*
HdStreamRendererPlugin::CreateRenderDelegate(const HdRenderSettingsMap& settings) {
    return new HdStreamRenderDelegate(settings);
}

void HdStreamRendererPlugin::DeleteRenderDelegate(HdRenderDelegate* delegate) {
    delete delegate;
}

#if HD_API_VERSION >= 103
bool HdStreamRendererPlugin::IsSupported(const HdRendererCreateArgsSchema&, std::string*) const {
    return true;
}
#elif HD_API_VERSION >= 83
bool HdStreamRendererPlugin::IsSupported(const HdRendererCreateArgs&, std::string*) const {
    return true;
}
#else
bool HdStreamRendererPlugin::IsSupported(bool) const {
    return true;
}
#endif

PXR_NAMESPACE_CLOSE_SCOPE
