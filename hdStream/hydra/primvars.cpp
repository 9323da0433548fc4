// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/primvars.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/floatValues.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/extComputationUtils.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <array>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr std::array<std::pair<HdInterpolation, hds::Interpolation>, 5> kInterpolations{{
    {HdInterpolationConstant, hds::Interpolation::Constant},
    {HdInterpolationUniform, hds::Interpolation::Uniform},
    {HdInterpolationVarying, hds::Interpolation::Varying},
    {HdInterpolationVertex, hds::Interpolation::Vertex},
    {HdInterpolationFaceVarying, hds::Interpolation::FaceVarying},
}};

/// One pass over a prim's primvars.
class Reader {
public:
    Reader(HdSceneDelegate* delegate, const SdfPath& id, const TfToken& pointsName,
           HdDirtyBits dirtyBits, hds::SharedSpan<float>* points,
           std::vector<hds::Primvar>* primvars)
        : _delegate(delegate), _id(id), _pointsName(pointsName), _dirtyBits(dirtyBits),
          _points(points), _old(std::move(*primvars)), _new(primvars) {
        _new->clear();
    }

    void Read() {
        bool hasPoints = false;
        for (const auto& [hydra, core] : kInterpolations) {
            hasPoints |= ReadComputed(hydra, core);
            for (const HdPrimvarDescriptor& descriptor :
                 _delegate->GetPrimvarDescriptors(_id, hydra)) {
                if (descriptor.name == _pointsName) {
                    hasPoints |= ReadPoints();
                } else {
                    ReadAuthored(descriptor.name, core);
                }
            }
        }
        if (!hasPoints) {
            *_points = {};
        }
    }

private:
    bool IsDirty(const TfToken& name) const {
        return HdChangeTracker::IsPrimvarDirty(_dirtyBits, _id, name);
    }

    /// Returns true when points are computed.
    bool ReadComputed(HdInterpolation hydra, hds::Interpolation core) {
        const HdExtComputationPrimvarDescriptorVector descriptors =
            _delegate->GetExtComputationPrimvarDescriptors(_id, hydra);
        HdExtComputationPrimvarDescriptorVector dirty;
        for (const HdExtComputationPrimvarDescriptor& descriptor : descriptors) {
            _computed.push_back(descriptor.name);
            // Scene indices say only that some computed primvar is dirty, of points too.
            if (IsDirty(descriptor.name) || (_dirtyBits & HdChangeTracker::DirtyPrimvar)) {
                dirty.push_back(descriptor);
            } else if (descriptor.name != _pointsName) {
                Keep(descriptor.name);
            }
        }
        if (!dirty.empty()) {
            for (const auto& [name, value] :
                 HdExtComputationUtils::GetComputedPrimvarValues(dirty, _delegate)) {
                if (name == _pointsName) {
                    SetPoints(value);
                } else {
                    Add(name, core, value, {});
                }
            }
        }
        return IsComputed(_pointsName);
    }

    bool IsComputed(const TfToken& name) const {
        return std::find(_computed.begin(), _computed.end(), name) != _computed.end();
    }

    bool ReadPoints() {
        if (!IsComputed(_pointsName) && IsDirty(_pointsName)) {
            SetPoints(_delegate->Get(_id, _pointsName));
        }
        return true;
    }

    void SetPoints(const VtValue& value) {
        const std::optional<HdStreamFloatRows> rows = HdStreamGetFloatRows(value);
        *_points = rows && rows->numComponents == 3 ? rows->values : hds::SharedSpan<float>();
    }

    void ReadAuthored(const TfToken& name, hds::Interpolation core) {
        if (IsComputed(name) || HdStreamIsSkippedPrimvar(name)) {
            return;
        }
        if (!IsDirty(name)) {
            Keep(name);
            return;
        }
        VtIntArray indices;
        const VtValue value = _delegate->GetIndexedPrimvar(_id, name, &indices);
        Add(name, core, value, indices);
    }

    void Keep(const TfToken& name) {
        const auto found = std::find_if(_old.begin(), _old.end(), [&](const hds::Primvar& primvar) {
            return primvar.name == name.GetString();
        });
        if (found != _old.end()) {
            _new->push_back(*found);
        }
    }

    void Add(const TfToken& name, hds::Interpolation core, const VtValue& value,
             const VtIntArray& indices) {
        const bool isText = name == hds::kKarmaVisibility && value.IsHolding<std::string>();
        std::optional<HdStreamFloatRows> rows = HdStreamGetFloatRows(
            isText ? VtValue(hds::KarmaVisibilityNumber(value.UncheckedGet<std::string>()))
                   : value);
        if (rows) {
            _new->push_back({name.GetString(), core, rows->numComponents, std::move(rows->values),
                             HdStreamShareArray<std::int32_t>(indices)});
        }
    }

    HdSceneDelegate* _delegate;
    const SdfPath& _id;
    const TfToken& _pointsName;
    HdDirtyBits _dirtyBits;
    hds::SharedSpan<float>* _points;
    std::vector<hds::Primvar> _old;
    std::vector<hds::Primvar>* _new;
    TfTokenVector _computed;
};

} // namespace

bool HdStreamIsSkippedPrimvar(const TfToken& name) {
    static const char* const names[] = {"velocities", "angularVelocities", "accelerations",
                                        "nonlinearSampleCount", "blurScale"};
    return TfStringStartsWith(name.GetString(), "skel:") ||
           std::find(std::begin(names), std::end(names), name.GetString()) != std::end(names);
}

void HdStreamSyncPrimvars(HdSceneDelegate* delegate, const SdfPath& id, const TfToken& pointsName,
                          HdDirtyBits dirtyBits, hds::SharedSpan<float>* points,
                          std::vector<hds::Primvar>* primvars) {
    Reader(delegate, id, pointsName, dirtyBits, points, primvars).Read();
}

bool HdStreamEqual(const std::vector<hds::Primvar>& a, const std::vector<hds::Primvar>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const hds::Primvar& left, const hds::Primvar& right) {
                          return left.name == right.name &&
                                 left.interpolation == right.interpolation &&
                                 left.numComponents == right.numComponents &&
                                 left.colorSpace == right.colorSpace &&
                                 HdStreamEqual(left.values, right.values) &&
                                 HdStreamEqual(left.indices, right.indices);
                      });
}

PXR_NAMESPACE_CLOSE_SCOPE
