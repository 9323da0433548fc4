// SPDX-License-Identifier: Apache-2.0
// Edits of the host's scene delegate.
#include "hostDelegate.h"

#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/extComputation.h>
#include <pxr/imaging/hd/field.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/material.h>
#include <pxr/imaging/hd/renderBuffer.h>
#include <pxr/imaging/hd/renderIndex.h>

namespace hydraHost {

namespace {

/// Stores a value; true when the key is new.
template <class T>
bool Store(std::map<SdfPath, T>* map, const SdfPath& path, const T& value) {
    return map->insert_or_assign(path, value).second;
}

} // namespace

SyntheticScene::SyntheticScene(HdRenderIndex* index, const SdfPath& id)
    : HdSceneDelegate(index, id) {}

void SyntheticScene::SetGprim(const SdfPath& path, const GprimData& gprim, HdDirtyBits bits) {
    if (Store(&_data.gprims, path, gprim)) {
        GetRenderIndex().InsertRprim(gprim.type, this, path);
    } else {
        GetRenderIndex().GetChangeTracker().MarkRprimDirty(
            path, bits ? bits : HdDirtyBits(HdChangeTracker::AllDirty));
    }
}

void SyntheticScene::SetInstancer(const SdfPath& path, const InstancerData& instancer,
                                  HdDirtyBits bits) {
    if (Store(&_data.instancers, path, instancer)) {
        GetRenderIndex().InsertInstancer(this, path);
    } else {
        GetRenderIndex().GetChangeTracker().MarkInstancerDirty(
            path, bits ? bits : HdDirtyBits(HdChangeTracker::AllDirty));
    }
}

void SyntheticScene::SetMaterial(const SdfPath& path, const HdMaterialNetworkMap& material) {
    if (Store(&_data.materials, path, material)) {
        GetRenderIndex().InsertSprim(HdPrimTypeTokens->material, this, path);
    } else {
        GetRenderIndex().GetChangeTracker().MarkSprimDirty(path, HdMaterial::AllDirty);
    }
}

void SyntheticScene::SetLight(const SdfPath& path, const LightData& light, HdDirtyBits bits) {
    if (Store(&_data.lights, path, light)) {
        GetRenderIndex().InsertSprim(light.type, this, path);
    } else {
        GetRenderIndex().GetChangeTracker().MarkSprimDirty(
            path, bits ? bits : HdDirtyBits(HdLight::AllDirty));
    }
}

void SyntheticScene::SetCamera(const SdfPath& path, const CameraData& camera, HdDirtyBits bits) {
    if (Store(&_data.cameras, path, camera)) {
        GetRenderIndex().InsertSprim(HdPrimTypeTokens->camera, this, path);
    } else {
        GetRenderIndex().GetChangeTracker().MarkSprimDirty(
            path, bits ? bits : HdDirtyBits(HdCamera::AllDirty));
    }
}

void SyntheticScene::SetComputation(const SdfPath& path, const ComputationData& computation,
                                    HdDirtyBits bits) {
    if (Store(&_data.computations, path, computation)) {
        GetRenderIndex().InsertSprim(HdPrimTypeTokens->extComputation, this, path);
    } else {
        GetRenderIndex().GetChangeTracker().MarkSprimDirty(
            path, bits ? bits : HdDirtyBits(HdExtComputation::AllDirty));
    }
}

void SyntheticScene::SetField(const SdfPath& path, const FieldData& field) {
    if (Store(&_data.fields, path, field)) {
        GetRenderIndex().InsertBprim(TfToken("openvdbAsset"), this, path);
    } else {
        GetRenderIndex().GetChangeTracker().MarkBprimDirty(path, HdField::DirtyParams);
    }
}

void SyntheticScene::Insert(const SceneData& scene) {
    GetRenderIndex().SceneIndexEmulationNoticeBatchBegin();
    for (const auto& [path, field] : scene.fields) {
        SetField(path, field);
    }
    for (const auto& [path, material] : scene.materials) {
        SetMaterial(path, material);
    }
    for (const auto& [path, computation] : scene.computations) {
        SetComputation(path, computation);
    }
    for (const auto& [path, light] : scene.lights) {
        SetLight(path, light);
    }
    for (const auto& [path, camera] : scene.cameras) {
        SetCamera(path, camera);
    }
    for (const auto& [path, instancer] : scene.instancers) {
        SetInstancer(path, instancer);
    }
    for (const auto& [path, gprim] : scene.gprims) {
        SetGprim(path, gprim);
    }
    GetRenderIndex().SceneIndexEmulationNoticeBatchEnd();
}

void SyntheticScene::Remove(const SdfPath& path) {
    HdRenderIndex& index = GetRenderIndex();
    if (_data.gprims.count(path)) {
        index.RemoveRprim(path);
        _data.gprims.erase(path);
    } else if (_data.instancers.count(path)) {
        index.RemoveInstancer(path);
        _data.instancers.erase(path);
    } else if (_data.materials.count(path)) {
        index.RemoveSprim(HdPrimTypeTokens->material, path);
        _data.materials.erase(path);
    } else if (_data.cameras.count(path)) {
        index.RemoveSprim(HdPrimTypeTokens->camera, path);
        _data.cameras.erase(path);
    } else if (_data.computations.count(path)) {
        index.RemoveSprim(HdPrimTypeTokens->extComputation, path);
        _data.computations.erase(path);
    } else if (_data.fields.count(path)) {
        index.RemoveBprim(TfToken("openvdbAsset"), path);
        _data.fields.erase(path);
    } else {
        const auto light = _data.lights.find(path);
        if (TF_VERIFY(light != _data.lights.end(), "%s is not in the scene", path.GetText())) {
            index.RemoveSprim(light->second.type, path);
            _data.lights.erase(light);
        }
    }
}

void SyntheticScene::SetBuffer(const SdfPath& path, const HdRenderBufferDescriptor& description) {
    if (Store(&_buffers, path, description)) {
        GetRenderIndex().InsertBprim(HdPrimTypeTokens->renderBuffer, this, path);
    } else {
        GetRenderIndex().GetChangeTracker().MarkBprimDirty(path, HdRenderBuffer::DirtyDescription);
    }
}

void SyntheticScene::RemoveBuffer(const SdfPath& path) {
    GetRenderIndex().RemoveBprim(HdPrimTypeTokens->renderBuffer, path);
    _buffers.erase(path);
}

} // namespace hydraHost
