// SPDX-License-Identifier: Apache-2.0
// The arithmetic is that of UsdGeomPointInstancer::ComputeInstanceTransformsAtTime, so that both
// front ends give the same bits.
#include "hdStream/hydra/instanceTransforms.h"

#include "hdStream/hydra/arrays.h"

#include <pxr/base/gf/matrix4d.h>
#include <pxr/base/gf/quatd.h>
#include <pxr/base/gf/quatf.h>
#include <pxr/base/gf/quath.h>
#include <pxr/base/gf/vec3d.h>
#include <pxr/base/gf/vec3f.h>
#include <pxr/base/gf/vec3h.h>
#include <pxr/base/gf/vec4f.h>
#include <pxr/base/vt/types.h>

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Translations or scales of any precision, in double.
VtVec3dArray VectorsFrom(const VtValue& value) {
    VtVec3dArray result;
    const auto convert = [&result](const auto& array) {
        result.reserve(array.size());
        for (const auto& item : array) {
            result.push_back(GfVec3d(item));
        }
    };
    if (value.IsHolding<VtVec3fArray>()) {
        convert(value.UncheckedGet<VtVec3fArray>());
    } else if (value.IsHolding<VtVec3dArray>()) {
        result = value.UncheckedGet<VtVec3dArray>();
    } else if (value.IsHolding<VtVec3hArray>()) {
        convert(value.UncheckedGet<VtVec3hArray>());
    }
    return result;
}

/// Rotations: quaternions of any precision, or vectors (real, i, j, k).
VtArray<GfQuatd> RotationsFrom(const VtValue& value) {
    VtArray<GfQuatd> result;
    const auto convert = [&result](const auto& array) {
        result.reserve(array.size());
        for (const auto& item : array) {
            result.push_back(GfQuatd(item));
        }
    };
    if (value.IsHolding<VtQuathArray>()) {
        convert(value.UncheckedGet<VtQuathArray>());
    } else if (value.IsHolding<VtQuatfArray>()) {
        convert(value.UncheckedGet<VtQuatfArray>());
    } else if (value.IsHolding<VtQuatdArray>()) {
        result = value.UncheckedGet<VtQuatdArray>();
    } else if (value.IsHolding<VtVec4fArray>()) {
        for (const GfVec4f& item : value.UncheckedGet<VtVec4fArray>()) {
            result.push_back(GfQuatd(item[0], item[1], item[2], item[3]));
        }
    }
    return result;
}

} // namespace

hds::SharedSpan<double> HdStreamInstanceTransforms(const VtValue& translations,
                                                   const VtValue& rotations, const VtValue& scales,
                                                   const VtValue& transforms,
                                                   const VtArray<GfRotation>& turns) {
    const VtVec3dArray translationArray = VectorsFrom(translations);
    const VtArray<GfQuatd> rotationArray = RotationsFrom(rotations);
    const VtVec3dArray scaleArray = VectorsFrom(scales);
    const VtMatrix4dArray matrices = transforms.GetWithDefault(VtMatrix4dArray());
    const std::size_t numParts =
        std::max({translationArray.size(), rotationArray.size(), scaleArray.size()});
    if (numParts == 0) {
        return HdStreamShareArray<double>(matrices);
    }
    VtMatrix4dArray result(std::max(numParts, matrices.size()), GfMatrix4d(1.0));
    GfMatrix4d* items = result.data();
    for (std::size_t i = 0; i < result.size(); ++i) {
        GfMatrix4d& matrix = items[i];
        if (i < scaleArray.size()) {
            matrix.SetScale(scaleArray[i]);
        }
        if (i < rotationArray.size()) {
            matrix *= GfMatrix4d(1.0).SetRotate(rotationArray[i]);
        }
        if (i < turns.size()) {
            matrix *= GfMatrix4d(1.0).SetRotate(turns[i]);
        }
        if (i < translationArray.size()) {
            matrix.SetTranslateOnly(translationArray[i]);
        }
        if (i < matrices.size()) {
            matrix = matrices[i] * matrix;
        }
    }
    return HdStreamShareArray<double>(result);
}

PXR_NAMESPACE_CLOSE_SCOPE
