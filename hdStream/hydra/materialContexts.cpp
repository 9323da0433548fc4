// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/materialContexts.h"

#include <pxr/imaging/hd/tokens.h>
#include <pxr/usd/sdr/registry.h>

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr const char* kMaterialXSurface = "ND_standard_surface_surfaceshader";
constexpr const char* kArnoldSurface = "arnold:standard_surface";

thread_local std::size_t numSkippedHere = 0;

TfTokenVector AllContexts() {
    // UsdImaging drops a network whose surface shader is not registered, and does not try the next
    // context then: MaterialX and Arnold are asked for where OpenUSD knows their nodes. Karma's
    // context is MaterialX as Houdini writes it; Storm's may be the only one with a preview.
    const auto isKnown = [](const char* identifier) {
        return SdrRegistry::GetInstance().GetShaderNodeByIdentifier(TfToken(identifier)) != nullptr;
    };
    TfTokenVector contexts;
    if (isKnown(kMaterialXSurface)) {
        contexts.emplace_back("mtlx");
        contexts.emplace_back("kma");
    }
    contexts.push_back(HdRenderContextTokens->universal);
    contexts.emplace_back("glslfx");
    if (isKnown(kArnoldSurface)) {
        contexts.emplace_back("arnold");
    }
    return contexts;
}

} // namespace

TfTokenVector HdStreamMaterialContexts() {
    static const TfTokenVector all = AllContexts();
    const std::size_t skipped = std::min(numSkippedHere, all.size());
    return {all.begin() + static_cast<std::ptrdiff_t>(skipped), all.end()};
}

HdStreamLaterMaterialContexts::HdStreamLaterMaterialContexts(std::size_t numSkipped) {
    numSkippedHere = numSkipped;
}

HdStreamLaterMaterialContexts::~HdStreamLaterMaterialContexts() {
    numSkippedHere = 0;
}

PXR_NAMESPACE_CLOSE_SCOPE
