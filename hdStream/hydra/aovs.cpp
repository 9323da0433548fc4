// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/aovs.h"

#include "hdStream/session/session.h"

#include <pxr/base/gf/vec4f.h>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Outputs of three floats are shown with a fourth of 1: HdxAovInputTask of OpenUSD 24.11 reads
/// buffers of Float32Vec3 after it has freed its copy. Hosts may bind such buffers all the same.
HdAovDescriptor ThreeFloats(float clearValue) {
    return {HdFormatFloat32Vec4, false, VtValue(GfVec4f(clearValue, clearValue, clearValue, 1.0F))};
}

} // namespace

HdAovDescriptor HdStreamAovDescriptor(const TfToken& name) {
    const HdParsedAovToken parsed(name);
    if (parsed.isPrimvar) {
        return ThreeFloats(0.0F);
    }
    const hds::AovInfo* info = hds::FindAov(name.GetString());
    if (!info) {
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
