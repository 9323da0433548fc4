// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/imaging/hd/rendererPlugin.h>
#include <pxr/imaging/hd/version.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// The name under which users pick the renderer; plugInfo.json has it too.
inline constexpr char kHdStreamDisplayName[] = "Stream";

/// The entry point of the plug-in. Hosts construct it often and only to ask questions, so it never
/// touches a device and never logs.
class HdStreamRendererPlugin final : public HdRendererPlugin {
public:
    HdStreamRendererPlugin() = default;

    HdRenderDelegate* CreateRenderDelegate() override;
    HdRenderDelegate* CreateRenderDelegate(const HdRenderSettingsMap& settings) override;
    void DeleteRenderDelegate(HdRenderDelegate* delegate) override;

    /// Always true: the renderer runs on GPUs and CPUs, and reports a missing OpenCL device when it
    /// is asked for an image.
#if HD_API_VERSION >= 103
    bool IsSupported(const HdRendererCreateArgsSchema& arguments,
                     std::string* reasonWhyNot = nullptr) const override;
#elif HD_API_VERSION >= 83
    bool IsSupported(const HdRendererCreateArgs& arguments,
                     std::string* reasonWhyNot = nullptr) const override;
#else
    bool IsSupported(bool gpuEnabled = true) const override;
#endif
};

PXR_NAMESPACE_CLOSE_SCOPE
