// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/light.h"

#include "hdStream/hydra/arrays.h"
#include "hdStream/hydra/instancer.h"
#include "hdStream/hydra/lightParameters.h"
#include "hdStream/hydra/motion.h"
#include "hdStream/hydra/renderParam.h"
#include "hdStream/hydra/scenePaths.h"

#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>

#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

HdStreamLight::HdStreamLight(const SdfPath& id, const TfToken& typeId, hds::LightType type)
    : HdLight(id), _typeId(typeId), _type(type) {}

HdDirtyBits HdStreamLight::GetInitialDirtyBitsMask() const {
    return AllDirty;
}

void HdStreamLight::Sync(HdSceneDelegate* delegate, HdRenderParam* renderParam,
                         HdDirtyBits* dirtyBits) {
    auto* param = static_cast<HdStreamRenderParam*>(renderParam);
    const HdDirtyBits bits = *dirtyBits;
    _UpdateInstancer(delegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(delegate->GetRenderIndex(), GetInstancerId());
    SyncPlacement(delegate, param, bits);
    const bool areParametersDirty =
        (bits & (DirtyParams | DirtyResource | DirtyShadowParams | DirtyCollection)) != 0;
    if (areParametersDirty) {
        SyncParameters(delegate, param);
    }
    if (areParametersDirty || (bits & DirtyTransform)) { // the latter also when the shutter changes
        SyncSamples(delegate, param);
    }
    const bool isPlaced = HdStreamInstancer::IsPlaced(_prim.placement);
    if (isPlaced) {
        param->Push([path = _scenePath, prim = _prim](hds::Session& session) mutable {
            session.SetLight(path, std::move(prim));
        });
    } else if (_isInScene) {
        param->Push([path = _scenePath](hds::Session& session) { session.Remove(path); });
    }
    _isInScene = isPlaced;
    *dirtyBits = Clean;
}

void HdStreamLight::SyncPlacement(HdSceneDelegate* delegate, HdStreamRenderParam* param,
                                  HdDirtyBits bits) {
    const SdfPath& id = GetId();
    hds::Placement& placement = _prim.placement;
    _isPathProvisional = _isPathProvisional && !_isInScene;
    HdStreamInstancer::UpdatePathOf(delegate->GetRenderIndex(), GetInstancerId(), param,
                                    &placement);
    if (bits & DirtyInstancer) { // Lights have no bit of their own for instance indices.
        HdStreamInstancer::ReadInstances(delegate, GetInstancerId(), id, &placement);
    }
    if (bits & (DirtyTransform | DirtyParams)) {
        // The dome offset turns a dome's pole to its pole axis (UsdLuxDomeLight_1).
        const GfMatrix4d offset = HdStreamGetLightParameter(delegate, id, HdLightTokens->domeOffset)
                                      .GetWithDefault(GfMatrix4d(1.0));
        placement.worldFromObject = HdStreamToGlm(offset * delegate->GetTransform(id));
        placement.samples = HdStreamSampleTransform(delegate, id, param->Shutter());
        for (hds::TransformSample& sample : placement.samples) {
            sample.matrix = sample.matrix * HdStreamToGlm(offset);
        }
    }
    if (bits & DirtyParams) {
        placement.visible = delegate->GetVisible(id);
    }
    HdStreamReservePath(delegate, id, GetInstancerId(), placement, param, &_scenePath,
                        &_isPathProvisional);
}

void HdStreamLight::SyncParameters(HdSceneDelegate* delegate, HdStreamRenderParam* param) {
    _authored = HdStreamReadLight(delegate, GetId(), _typeId, _type);
    _prim.light = _authored;
    if (_typeId != HdPrimTypeTokens->simpleLight) { // which no exporter wrote
        HdStreamFixLight(param->Exporter(), &_prim.light);
        HdStreamFixTemperature(param->Exporter(), delegate, GetId(), &_prim.light);
    }
    _prim.links = HdStreamReadLinks(delegate, GetId());
    if (_typeId == HdPrimTypeTokens->simpleLight) {
        return; // The application's own: nobody can act on a warning about it.
    }
    std::vector<std::string> problems;
    // Their edits are edits of the light (HdStreamEditSceneIndex).
    _prim.filters = HdStreamReadFilters(delegate, GetId(), &problems);
    for (const std::string& problem : problems) {
        param->Warn(SdfPath(_scenePath), problem);
    }
    for (const std::string& feature : HdStreamUnsupportedLightFeatures(delegate, GetId())) {
        param->Warn(SdfPath(_scenePath), feature + " is not supported yet");
    }
}

void HdStreamLight::SyncSamples(HdSceneDelegate* delegate, HdStreamRenderParam* param) {
    if (_typeId == HdPrimTypeTokens->simpleLight) {
        return; // whose delegate, the application's, has an error for each name that it does not
                // know
    }
    _prim.samples = HdStreamSampleLight(delegate, GetId(), _authored, param->Shutter());
    for (hds::LightSample& sample : _prim.samples) {
        hds::LightDescription light = _authored;
        light.intensity = sample.intensity;
        HdStreamFixLight(param->Exporter(), &light);
        sample.intensity = light.intensity;
    }
}

void HdStreamLight::Finalize(HdRenderParam* renderParam) {
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

HdStreamUnsupportedLight::HdStreamUnsupportedLight(const SdfPath& id, const TfToken& typeId)
    : HdSprim(id), _typeId(typeId) {}

HdDirtyBits HdStreamUnsupportedLight::GetInitialDirtyBitsMask() const {
    return HdLight::DirtyParams;
}

void HdStreamUnsupportedLight::Sync(HdSceneDelegate*, HdRenderParam* renderParam,
                                    HdDirtyBits* dirtyBits) {
    // The lights that name a filter warn of it.
    if ((*dirtyBits & HdLight::DirtyParams) && _typeId != HdPrimTypeTokens->lightFilter) {
        static_cast<HdStreamRenderParam*>(renderParam)
            ->Warn(GetId(), _typeId.GetString() + " is not supported yet; left out");
    }
    *dirtyBits = HdLight::Clean;
}

PXR_NAMESPACE_CLOSE_SCOPE
