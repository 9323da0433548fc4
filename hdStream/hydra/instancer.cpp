// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/instancer.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/categories.h"
#include "hdStream/hydra/floatValues.h"
#include "hdStream/hydra/instanceTransforms.h"
#include "hdStream/hydra/motion.h"
#include "hdStream/hydra/primvars.h"
#include "hdStream/hydra/renderParam.h"
#include "hdStream/hydra/scenePaths.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Instances that their angular velocities turn nowhere finite do not turn. \param[out] isFinite
/// false: there is such.
void StopWhereNotFinite(HdStreamTurn* turn, bool* isFinite) {
    for (GfVec3f& velocity : turn->degreesPerSecond) {
        if (!std::isfinite(velocity.GetLength())) { // of which the angle is made
            velocity = GfVec3f(0.0F);
            *isFinite = false;
        }
    }
}

/// Adds a primvar that is neither motion nor something without floats.
void ReadPrimvar(HdSceneDelegate* delegate, const SdfPath& id, const TfToken& name,
                 std::vector<hds::Primvar>* primvars) {
    if (HdStreamIsSkippedPrimvar(name) || name == HdTokens->points) {
        return;
    }
    if (std::optional<HdStreamFloatRows> rows = HdStreamGetFloatRows(delegate->Get(id, name))) {
        primvars->push_back({name.GetString(),
                             hds::Interpolation::Instance,
                             rows->numComponents,
                             std::move(rows->values),
                             {}});
    }
}

hds::SharedSpan<double> TransformsOf(std::map<TfToken, VtValue>& values,
                                     const VtArray<GfRotation>& turns = {}) {
    return HdStreamInstanceTransforms(values[HdInstancerTokens->instanceTranslations],
                                      values[HdInstancerTokens->instanceRotations],
                                      values[HdInstancerTokens->instanceScales],
                                      values[HdInstancerTokens->instanceTransforms], turns);
}

} // namespace

HdStreamInstancer::HdStreamInstancer(HdSceneDelegate* delegate, const SdfPath& id)
    : HdInstancer(delegate, id) {}

const std::string& HdStreamInstancer::ScenePath(HdStreamRenderParam* param) {
    std::call_once(_hasScenePath, [&] {
        HdSceneDelegate* delegate = GetDelegate();
        const SdfPath parentId = delegate->GetInstancerId(GetId());
        hds::Placement parent;
        UpdatePathOf(delegate->GetRenderIndex(), parentId, param, &parent);
        _scenePath = param->ReservePath(
            HdStreamInstancerScenePath(delegate, GetId(), parentId, parent.instancerPath), GetId());
    });
    return _scenePath;
}

bool HdStreamInstancer::UpdatePathOf(HdRenderIndex& index, const SdfPath& instancerId,
                                     HdStreamRenderParam* param, hds::Placement* placement) {
    auto* instancer = instancerId.IsEmpty()
                          ? nullptr
                          : static_cast<HdStreamInstancer*>(index.GetInstancer(instancerId));
    std::string path = instancer ? instancer->ScenePath(param) : std::string();
    if (path == placement->instancerPath) {
        return false;
    }
    placement->instancerPath = std::move(path);
    return true;
}

void HdStreamInstancer::ReadInstances(HdSceneDelegate* delegate, const SdfPath& instancerId,
                                      const SdfPath& prototypeId, hds::Placement* placement) {
    placement->instances = instancerId.IsEmpty()
                               ? hds::SharedSpan<std::int32_t>()
                               : HdStreamShareArray<std::int32_t>(
                                     delegate->GetInstanceIndices(instancerId, prototypeId));
}

HdDirtyBits HdStreamInstancer::GetInitialDirtyBitsMask() const {
    return HdInstancer::GetInitialDirtyBitsMask() | HdChangeTracker::DirtyVisibility |
           HdChangeTracker::DirtyCategories;
}

void HdStreamInstancer::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                             HdDirtyBits* dirtyBits) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    const HdDirtyBits bits = *dirtyBits;
    _UpdateInstancer(delegate, dirtyBits);
    ScenePath(param);
    hds::Placement& placement = _prim.placement;
    const bool isMoved = UpdatePathOf(delegate->GetRenderIndex(), GetParentId(), param, &placement);
    if (isMoved || (bits & HdChangeTracker::DirtyInstanceIndex)) {
        ReadInstances(delegate, GetParentId(), GetId(), &placement);
    }
    if (bits & HdChangeTracker::DirtyTransform) {
        placement.worldFromObject = HdStreamToGlm(delegate->GetInstancerTransform(GetId()));
        placement.samples = HdStreamSampleInstancerTransform(delegate, GetId(), param->Shutter());
    }
    // Legacy delegates fold an instancer's visibility into what it places, and GetVisible would be
    // that of the first native instance only. Scene indices say nothing of it to instancers;
    // HdStreamEditSceneIndex lets their instances change with it.
    if ((bits & (HdChangeTracker::DirtyVisibility | HdChangeTracker::DirtyInstanceIndex)) &&
        !HdStreamFindLegacyDelegate(delegate, GetId())) {
        placement.visible = delegate->GetVisible(GetId());
    }
    if (HdChangeTracker::IsAnyPrimvarDirty(bits, GetId())) {
        SyncPrimvars(delegate, bits);
        if (!SyncMotion(delegate, param->Shutter())) {
            param->Push([path = _scenePath](hds::Session& session) {
                session.Warn(path,
                             "velocities are not finite: instances that have these stand still");
            });
        }
    }
    if (bits & (HdChangeTracker::DirtyCategories | HdChangeTracker::DirtyInstanceIndex)) {
        _prim.instanceCategories.clear();
        for (const VtArray<TfToken>& tokens : delegate->GetInstanceCategories(GetId())) {
            _prim.instanceCategories.push_back(HdStreamCategories(tokens));
        }
    }
    ShareLevel(param);
    const bool isPlacing = _prim.instanceTransforms.Size() > 0 && IsPlaced(placement);
    if (isPlacing) {
        param->Push([path = _scenePath, prim = _prim](hds::Session& session) mutable {
            session.SetInstancer(path, std::move(prim));
        });
    } else if (_isInScene) {
        param->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
    }
    _isInScene = isPlacing;
    *dirtyBits = HdChangeTracker::Clean;
}

void HdStreamInstancer::SyncPrimvars(HdSceneDelegate* delegate, HdDirtyBits bits) {
    const SdfPath& id = GetId();
    const TfTokenVector& transforms = GetBuiltinPrimvarNames();
    std::map<TfToken, VtValue> values;
    std::vector<hds::Primvar> primvars;
    for (const HdPrimvarDescriptor& descriptor :
         delegate->GetPrimvarDescriptors(id, HdInterpolationInstance)) {
        const TfToken& name = descriptor.name;
        const bool isDirty = HdChangeTracker::IsPrimvarDirty(bits, id, name);
        if (std::find(transforms.begin(), transforms.end(), name) == transforms.end()) {
            if (isDirty) {
                ReadPrimvar(delegate, id, name, &primvars);
            } else {
                std::copy_if(_primvars.begin(), _primvars.end(), std::back_inserter(primvars),
                             [&name](const hds::Primvar& primvar) { return primvar.name == name; });
            }
        } else if (isDirty) {
            values[name] = delegate->Get(id, name);
        } else if (const auto found = _values.find(name); found != _values.end()) {
            values.insert(*found);
        }
    }
    _primvars = std::move(primvars);
    _values = std::move(values);
    _prim.instanceTransforms = TransformsOf(_values);
}

bool HdStreamInstancer::SyncMotion(HdSceneDelegate* delegate, const hds::Shutter& shutter) {
    _prim.samples.clear();
    std::map<TfToken, HdStreamMovingValue> moving;
    HdStreamTurn turn;
    std::set<double> times;
    bool isFinite = true;
    for (const auto& [name, value] : _values) {
        HdStreamMovingValue values;
        if (!value.IsEmpty()) {
            values = HdStreamSamplePrimvar(delegate, GetId(), name, shutter);
        }
        if (!values.Moves() && name == HdInstancerTokens->instanceTranslations) {
            values = HdStreamMoveByVelocities(delegate, GetId(), value, shutter, &isFinite);
        }
        if (!values.Moves() && name == HdInstancerTokens->instanceRotations) {
            turn = HdStreamTurnByVelocities(delegate, GetId(), value.GetArraySize(), shutter);
            StopWhereNotFinite(&turn, &isFinite);
            times.insert(turn.times.begin(), turn.times.end());
        }
        if (values.Moves()) {
            times.insert(values.times.begin(), values.times.end());
            moving[name] = std::move(values);
        }
    }
    for (const double time : times) {
        std::map<TfToken, VtValue> values = _values;
        for (const auto& [name, value] : moving) {
            values[name] = value.At(time);
        }
        _prim.samples.push_back({time, TransformsOf(values, turn.At(time))});
    }
    return isFinite;
}

void HdStreamInstancer::ShareLevel(HdStreamRenderParam* param) {
    const std::size_t numInstances = _prim.instanceTransforms.Size();
    auto level = std::make_shared<HdStreamInstanceLevel>();
    level->placements = _prim.placement.instances;
    for (const hds::Primvar& primvar : _primvars) {
        const std::size_t numValues = primvar.values.size() / primvar.numComponents;
        if (numValues == numInstances) {
            level->primvars.push_back(primvar);
        } else if (numInstances > 0) {
            param->Push([path = _scenePath, text = "primvar " + primvar.name + " has " +
                                                   std::to_string(numValues) + " values for " +
                                                   std::to_string(numInstances) +
                                                   " instances; ignored"](hds::Session& session) {
                session.Warn(path, text);
            });
        }
    }
    _prim.primvars = HdStreamInstancerPrimvars(level->primvars);
    const std::lock_guard<std::mutex> lock(_levelMutex);
    _level = std::move(level);
}

HdStreamInstanceLevels HdStreamInstancer::Levels(HdRenderIndex& index, const SdfPath& instancerId) {
    HdStreamInstanceLevels levels;
    for (SdfPath id = instancerId; !id.IsEmpty();) {
        const auto* instancer = static_cast<const HdStreamInstancer*>(index.GetInstancer(id));
        if (!instancer) {
            break;
        }
        const std::lock_guard<std::mutex> lock(instancer->_levelMutex);
        if (!instancer->_level) {
            break;
        }
        levels.push_back(instancer->_level);
        id = instancer->GetParentId();
    }
    return levels;
}

void HdStreamInstancer::Finalize(HdRenderParam* renderParam) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    if (_isInScene) {
        param->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
        _isInScene = false;
    }
    if (!_scenePath.empty()) {
        param->ReleasePath(_scenePath);
        _scenePath.clear();
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
