// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/aovs.h"

#include "hdStream/session/session.h"

#include <pxr/base/gf/vec3f.h>
#include <pxr/base/gf/vec4f.h>

PXR_NAMESPACE_OPEN_SCOPE

HdAovDescriptor HdStreamAovDescriptor(const TfToken& name) {
    const HdParsedAovToken parsed(name);
    if (parsed.isPrimvar) {
        return {HdFormatFloat32Vec3, false, VtValue(GfVec3f(0.0F))};
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
        return {HdFormatFloat32Vec3, false, VtValue(GfVec3f(info->clearValue))};
    case 4:
        return {HdFormatFloat32Vec4, false, VtValue(GfVec4f(info->clearValue))};
    default:
        return {};
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
