// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/aovs.h"

#include "hdStream/session/session.h"

#include <pxr/base/gf/vec3f.h>
#include <pxr/base/gf/vec4f.h>

#include <optional>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// In OpenUSD 24.11 outputs of three floats are shown with a fourth of 1: its HdxAovInputTask reads
/// buffers of Float32Vec3 after it has freed its copy. Hosts may bind such buffers all the same.
HdAovDescriptor ThreeFloats(float clearValue) {
#if PXR_VERSION < 2502
    return {HdFormatFloat32Vec4, false, VtValue(GfVec4f(clearValue, clearValue, clearValue, 1.0F))};
#else
    return {HdFormatFloat32Vec3, false, VtValue(GfVec3f(clearValue))};
#endif
}

} // namespace

std::string HdStreamAovName(const TfToken& name) {
    static const std::string kPrefix = "primvars_";
    const std::string& text = name.GetString();
    return text.compare(0, kPrefix.size(), kPrefix) == 0 ? "primvars:" + text.substr(kPrefix.size())
                                                         : text;
}

HdAovDescriptor HdStreamAovDescriptor(const TfToken& name) {
    const std::string layer = HdStreamAovName(name);
    const HdParsedAovToken parsed{TfToken(layer)};
    if (parsed.isPrimvar) {
        return ThreeFloats(0.0F);
    }
    const hds::AovInfo* info = hds::FindAov(layer);
    const std::optional<hds::MatteAov> matte = hds::ParseMatteAov(layer);
    if (!info || (matte && !matte->layer)) { // a Cryptomatte is several buffers: ask for its layers
        return {};
    }
    if (info->isInteger) {
        return {HdFormatInt32, false, VtValue(static_cast<int>(info->clearId))};
    }
    switch (info->NumChannels()) {
    case 1:
        return {HdFormatFloat32, false, VtValue(info->clearValue)};
    case 3:
        return ThreeFloats(info->clearValue);
    case 4:
        return {HdFormatFloat32Vec4, false, VtValue(GfVec4f(info->clearValue))};
    default:
        return {};
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
