// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/primEdits.h"

#include "hdStream/base/error.h"

#include <algorithm>

namespace hds {

namespace {

/// Whether all members are equal for which `isLeftOut(field)` is false.
template <typename T, typename Predicate>
bool AreEqualBut(const T& a, const T& b, const Predicate& isLeftOut) {
    bool areEqual = true;
    ForEachField<T>([&](const auto& field) {
        areEqual = areEqual && (isLeftOut(field) || a.*field.member == b.*field.member);
    });
    return areEqual;
}

bool DifferInPlaceAlone(const Placement& a, const Placement& b) {
    return AreEqualBut(a, b, [](const auto& field) {
        return field.Is(&Placement::worldFromObject) || field.Is(&Placement::samples) ||
               field.Is(&Placement::visible);
    });
}

bool DifferInValuesAlone(const Primvar& a, const Primvar& b) {
    const bool varies =
        a.interpolation != Interpolation::Constant && a.interpolation != Interpolation::Instance;
    return a.values.size() == b.values.size() && AreEqualBut(a, b, [varies](const auto& field) {
               return varies && field.Is(&Primvar::values);
           });
}

bool DifferInShapeAlone(const GeometryDescription& a, const GeometryDescription& b) {
    return a.points.size() == b.points.size() &&
           std::equal(a.primvars.begin(), a.primvars.end(), b.primvars.begin(), b.primvars.end(),
                      DifferInValuesAlone) &&
           AreEqualBut(a, b, [](const auto& field) {
               return field.Is(&GeometryDescription::points) ||
                      field.Is(&GeometryDescription::primvars);
           });
}

} // namespace

bool LeavesPrims(const GeometryPrim& before, const GeometryPrim& after) {
    return DifferInPlaceAlone(before.placement, after.placement) &&
           AreEqualBut(before, after,
                       [](const auto& field) { return field.Is(&GeometryPrim::placement); });
}

bool LeavesAllButShape(const GeometryPrim& before, const GeometryPrim& after) try {
    return DifferInPlaceAlone(before.placement, after.placement) && before.geometry &&
           after.geometry &&
           AreEqualBut(before, after,
                       [](const auto& field) {
                           return field.Is(&GeometryPrim::placement) ||
                                  field.Is(&GeometryPrim::geometry);
                       }) &&
           DifferInShapeAlone(*before.geometry, *after.geometry);
} catch (const Error&) { // of an array that has changed where it is read again
    return false;
}

bool LeavesPrims(const InstancerPrim& before, const InstancerPrim& after) {
    return DifferInPlaceAlone(before.placement, after.placement) &&
           before.instanceTransforms.Size() == after.instanceTransforms.Size() &&
           AreEqualBut(before, after, [](const auto& field) {
               return field.Is(&InstancerPrim::placement) ||
                      field.Is(&InstancerPrim::instanceTransforms) ||
                      field.Is(&InstancerPrim::samples);
           });
}

bool LeavesPrims(const LightPrim& before, const LightPrim& after) {
    const LightDescription& was = before.light;
    const LightDescription& is = after.light;
    return DifferInPlaceAlone(before.placement, after.placement) &&
           before.placement.visible == after.placement.visible && was.type == is.type &&
           was.textureFile == is.textureFile && was.shadow == is.shadow &&
           was.colorSpace == is.colorSpace && AreEqualBut(before, after, [](const auto& field) {
               return field.Is(&LightPrim::placement) || field.Is(&LightPrim::light) ||
                      field.Is(&LightPrim::samples);
           });
}

} // namespace hds
