// SPDX-License-Identifier: Apache-2.0
// What the host's scene delegate answers to Hydra.
#include "hostDelegate.h"

#include <pxr/base/gf/range3d.h>
#include <pxr/imaging/hd/extComputationContext.h>

namespace hydraHost {

namespace {

/// The value of a path; null when there is none.
template <class T>
const T* Find(const std::map<SdfPath, T>& map, const SdfPath& path) {
    const auto found = map.find(path);
    return found == map.end() ? nullptr : &found->second;
}

VtValue FindParam(const std::map<TfToken, VtValue>& params, const TfToken& name) {
    const auto found = params.find(name);
    return found == params.end() ? VtValue() : found->second;
}

} // namespace

const std::vector<PrimvarData>* SyntheticScene::_FindPrimvars(const SdfPath& id) const {
    if (const GprimData* gprim = Find(_data.gprims, id)) {
        return &gprim->primvars;
    }
    const InstancerData* instancer = Find(_data.instancers, id);
    return instancer ? &instancer->primvars : nullptr;
}

const PrimvarData* SyntheticScene::_FindPrimvar(const SdfPath& id, const TfToken& name) const {
    if (const std::vector<PrimvarData>* primvars = _FindPrimvars(id)) {
        for (const PrimvarData& primvar : *primvars) {
            if (primvar.name == name) {
                return &primvar;
            }
        }
    }
    return nullptr;
}

HdMeshTopology SyntheticScene::GetMeshTopology(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return gprim ? gprim->mesh : HdMeshTopology();
}

HdBasisCurvesTopology SyntheticScene::GetBasisCurvesTopology(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return gprim ? gprim->curves : HdBasisCurvesTopology();
}

PxOsdSubdivTags SyntheticScene::GetSubdivTags(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return gprim ? gprim->subdivTags : PxOsdSubdivTags();
}

GfRange3d SyntheticScene::GetExtent(const SdfPath& id) {
    GfRange3d extent;
    const PrimvarData* points = _FindPrimvar(id, HdTokens->points);
    if (points && points->value.IsHolding<VtVec3fArray>()) {
        for (const GfVec3f& point : points->value.UncheckedGet<VtVec3fArray>()) {
            extent.UnionWith(GfVec3d(point));
        }
    }
    return extent;
}

GfMatrix4d SyntheticScene::GetTransform(const SdfPath& id) {
    if (const GprimData* gprim = Find(_data.gprims, id)) {
        return gprim->transform;
    }
    if (const LightData* light = Find(_data.lights, id)) {
        return light->transform;
    }
    const CameraData* camera = Find(_data.cameras, id);
    return camera ? camera->transform : GfMatrix4d(1.0);
}

size_t SyntheticScene::SampleTransform(const SdfPath& id, size_t maxSampleCount, float* sampleTimes,
                                       GfMatrix4d* sampleValues) {
    const GprimData* gprim = Find(_data.gprims, id);
    if (!gprim || gprim->transformSamples.empty()) {
        return HdSceneDelegate::SampleTransform(id, maxSampleCount, sampleTimes, sampleValues);
    }
    size_t count = 0;
    for (const auto& [time, matrix] : gprim->transformSamples) {
        if (count < maxSampleCount) {
            sampleTimes[count] = time;
            sampleValues[count] = matrix;
        }
        ++count;
    }
    return count;
}

size_t SyntheticScene::SampleTransform(const SdfPath& id, float, float, size_t maxSampleCount,
                                       float* sampleTimes, GfMatrix4d* sampleValues) {
    return SampleTransform(id, maxSampleCount, sampleTimes, sampleValues);
}

bool SyntheticScene::GetVisible(const SdfPath& id) {
    if (const GprimData* gprim = Find(_data.gprims, id)) {
        return gprim->isVisible;
    }
    if (const InstancerData* instancer = Find(_data.instancers, id)) {
        return instancer->isVisible;
    }
    const LightData* light = Find(_data.lights, id);
    return !light || light->isVisible;
}

bool SyntheticScene::GetDoubleSided(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return gprim && gprim->isDoubleSided;
}

HdCullStyle SyntheticScene::GetCullStyle(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return gprim ? gprim->cullStyle : HdCullStyleDontCare;
}

HdDisplayStyle SyntheticScene::GetDisplayStyle(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return HdDisplayStyle(gprim ? gprim->refineLevel : 0);
}

VtValue SyntheticScene::Get(const SdfPath& id, const TfToken& key) {
    if (const FieldData* field = Find(_data.fields, id)) {
        return FindParam(field->params, key);
    }
    const PrimvarData* primvar = _FindPrimvar(id, key);
    return primvar ? primvar->value : VtValue();
}

VtValue SyntheticScene::GetIndexedPrimvar(const SdfPath& id, const TfToken& key,
                                          VtIntArray* indices) {
    const PrimvarData* primvar = _FindPrimvar(id, key);
    if (!primvar) {
        return VtValue();
    }
    if (indices) {
        *indices = primvar->indices;
    }
    return primvar->value;
}

TfToken SyntheticScene::GetRenderTag(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return gprim ? gprim->renderTag : HdRenderTagTokens->geometry;
}

VtIntArray SyntheticScene::GetInstanceIndices(const SdfPath& instancer, const SdfPath& prototype) {
    const InstancerData* data = Find(_data.instancers, instancer);
    return data ? VtIntArray(Find(data->indicesByPrototype, prototype)
                                 ? *Find(data->indicesByPrototype, prototype)
                                 : VtIntArray())
                : VtIntArray();
}

GfMatrix4d SyntheticScene::GetInstancerTransform(const SdfPath& instancer) {
    const InstancerData* data = Find(_data.instancers, instancer);
    return data ? data->transform : GfMatrix4d(1.0);
}

SdfPath SyntheticScene::GetInstancerId(const SdfPath& id) {
    if (const GprimData* gprim = Find(_data.gprims, id)) {
        return gprim->instancer;
    }
    const InstancerData* instancer = Find(_data.instancers, id);
    return instancer ? instancer->parent : SdfPath();
}

SdfPathVector SyntheticScene::GetInstancerPrototypes(const SdfPath& instancer) {
    SdfPathVector prototypes;
    if (const InstancerData* data = Find(_data.instancers, instancer)) {
        for (const auto& prototype : data->indicesByPrototype) {
            prototypes.push_back(prototype.first);
        }
    }
    return prototypes;
}

SdfPath SyntheticScene::GetScenePrimPath(const SdfPath& id, int instanceIndex,
                                         HdInstancerContext* instancerContext) {
    const GprimData* gprim = Find(_data.gprims, id);
    if (!gprim || gprim->scenePath.IsEmpty()) {
        return HdSceneDelegate::GetScenePrimPath(id, instanceIndex, instancerContext);
    }
    if (instancerContext) {
        instancerContext->emplace_back(gprim->instancer, instanceIndex);
    }
    return gprim->scenePath;
}

SdfPath SyntheticScene::GetMaterialId(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return gprim ? gprim->material : SdfPath();
}

VtValue SyntheticScene::GetMaterialResource(const SdfPath& id) {
    if (const LightData* light = Find(_data.lights, id)) {
        return light->resource;
    }
    const HdMaterialNetworkMap* material = Find(_data.materials, id);
    return material ? VtValue(*material) : VtValue();
}

HdVolumeFieldDescriptorVector SyntheticScene::GetVolumeFieldDescriptors(const SdfPath& id) {
    const GprimData* gprim = Find(_data.gprims, id);
    return gprim ? gprim->volumeFields : HdVolumeFieldDescriptorVector();
}

HdRenderBufferDescriptor SyntheticScene::GetRenderBufferDescriptor(const SdfPath& id) {
    const HdRenderBufferDescriptor* buffer = Find(_buffers, id);
    return buffer ? *buffer : HdRenderBufferDescriptor();
}

VtValue SyntheticScene::GetLightParamValue(const SdfPath& id, const TfToken& name) {
    const LightData* light = Find(_data.lights, id);
    return light ? FindParam(light->params, name) : VtValue();
}

VtValue SyntheticScene::GetCameraParamValue(const SdfPath& id, const TfToken& name) {
    const CameraData* camera = Find(_data.cameras, id);
    return camera ? FindParam(camera->params, name) : VtValue();
}

HdPrimvarDescriptorVector SyntheticScene::GetPrimvarDescriptors(const SdfPath& id,
                                                                HdInterpolation interpolation) {
    HdPrimvarDescriptorVector descriptors;
    if (const std::vector<PrimvarData>* primvars = _FindPrimvars(id)) {
        for (const PrimvarData& primvar : *primvars) {
            if (primvar.interpolation == interpolation) {
                descriptors.emplace_back(primvar.name, interpolation, primvar.role,
                                         !primvar.indices.empty());
            }
        }
    }
    return descriptors;
}

TfTokenVector SyntheticScene::GetExtComputationSceneInputNames(const SdfPath& id) {
    TfTokenVector names;
    if (const ComputationData* computation = Find(_data.computations, id)) {
        for (const auto& input : computation->inputs) {
            names.push_back(input.first);
        }
    }
    return names;
}

HdExtComputationInputDescriptorVector
SyntheticScene::GetExtComputationInputDescriptors(const SdfPath&) {
    return {};
}

HdExtComputationOutputDescriptorVector
SyntheticScene::GetExtComputationOutputDescriptors(const SdfPath& id) {
    const ComputationData* computation = Find(_data.computations, id);
    if (!computation) {
        return {};
    }
    return {HdExtComputationOutputDescriptor(computation->output, computation->outputType)};
}

HdExtComputationPrimvarDescriptorVector
SyntheticScene::GetExtComputationPrimvarDescriptors(const SdfPath& id,
                                                    HdInterpolation interpolation) {
    HdExtComputationPrimvarDescriptorVector descriptors;
    if (const GprimData* gprim = Find(_data.gprims, id)) {
        for (const HdExtComputationPrimvarDescriptor& primvar : gprim->computedPrimvars) {
            if (primvar.interpolation == interpolation) {
                descriptors.push_back(primvar);
            }
        }
    }
    return descriptors;
}

VtValue SyntheticScene::GetExtComputationInput(const SdfPath& id, const TfToken& input) {
    const ComputationData* computation = Find(_data.computations, id);
    if (!computation) {
        return VtValue();
    }
    if (input == HdTokens->elementCount) {
        return VtValue(computation->numElements);
    }
    if (input == HdTokens->dispatchCount) {
        return VtValue(size_t(0));
    }
    return FindParam(computation->inputs, input);
}

void SyntheticScene::InvokeExtComputation(const SdfPath& id, HdExtComputationContext* context) {
    const ComputationData* computation = Find(_data.computations, id);
    if (!computation) {
        context->RaiseComputationError();
        return;
    }
    std::map<TfToken, VtValue> inputs;
    for (const auto& input : computation->inputs) {
        inputs[input.first] = context->GetInputValue(input.first);
    }
    context->SetOutputValue(computation->output, computation->run(inputs));
}

} // namespace hydraHost
