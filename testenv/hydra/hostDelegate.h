// SPDX-License-Identifier: Apache-2.0
// The scene delegate of the Hydra host: shows a SceneData to a render index and marks edits.
// Explained in docs/testing.md.
#pragma once

#include "hostScene.h"

#include <pxr/imaging/hd/aov.h>
#include <pxr/imaging/hd/sceneDelegate.h>

#include <vector>

namespace hydraHost {

/// Externally synchronised, but for the getters: Hydra calls those from many threads while it
/// syncs, and they only read.
class SyntheticScene final : public HdSceneDelegate {
public:
    SyntheticScene(HdRenderIndex* index, const SdfPath& id);

    const SceneData& Data() const { return _data; }

    // Each inserts the prim, or replaces its data and marks `bits` dirty (0: all of its bits).
    void SetGprim(const SdfPath& path, const GprimData& gprim, HdDirtyBits bits = 0);
    void SetInstancer(const SdfPath& path, const InstancerData& instancer, HdDirtyBits bits = 0);
    void SetMaterial(const SdfPath& path, const HdMaterialNetworkMap& material);
    void SetLight(const SdfPath& path, const LightData& light, HdDirtyBits bits = 0);
    void SetCamera(const SdfPath& path, const CameraData& camera, HdDirtyBits bits = 0);
    void SetComputation(const SdfPath& path, const ComputationData& computation,
                        HdDirtyBits bits = 0);
    void SetField(const SdfPath& path, const FieldData& field);
    /// Inserts all prims of a scene; fields, materials, computations, lights and cameras first.
    void Insert(const SceneData& scene);
    /// Removes a prim of any kind. Precondition: the scene has it.
    void Remove(const SdfPath& path);

    /// A render buffer of the index with that description.
    void SetBuffer(const SdfPath& path, const HdRenderBufferDescriptor& description);
    void RemoveBuffer(const SdfPath& path);

    // --- HdSceneDelegate ---
    HdMeshTopology GetMeshTopology(const SdfPath& id) override;
    HdBasisCurvesTopology GetBasisCurvesTopology(const SdfPath& id) override;
    PxOsdSubdivTags GetSubdivTags(const SdfPath& id) override;
    GfRange3d GetExtent(const SdfPath& id) override;
    GfMatrix4d GetTransform(const SdfPath& id) override;
    size_t SampleTransform(const SdfPath& id, size_t maxSampleCount, float* sampleTimes,
                           GfMatrix4d* sampleValues) override;
    size_t SampleTransform(const SdfPath& id, float startTime, float endTime, size_t maxSampleCount,
                           float* sampleTimes, GfMatrix4d* sampleValues) override;
    bool GetVisible(const SdfPath& id) override;
    bool GetDoubleSided(const SdfPath& id) override;
    HdCullStyle GetCullStyle(const SdfPath& id) override;
    HdDisplayStyle GetDisplayStyle(const SdfPath& id) override;
    VtValue Get(const SdfPath& id, const TfToken& key) override;
    VtValue GetIndexedPrimvar(const SdfPath& id, const TfToken& key, VtIntArray* indices) override;
    TfToken GetRenderTag(const SdfPath& id) override;
    VtIntArray GetInstanceIndices(const SdfPath& instancer, const SdfPath& prototype) override;
    GfMatrix4d GetInstancerTransform(const SdfPath& instancer) override;
    SdfPath GetInstancerId(const SdfPath& id) override;
    SdfPathVector GetInstancerPrototypes(const SdfPath& instancer) override;
    SdfPath GetScenePrimPath(const SdfPath& id, int instanceIndex,
                             HdInstancerContext* instancerContext) override;
    SdfPath GetMaterialId(const SdfPath& id) override;
    VtValue GetMaterialResource(const SdfPath& id) override;
    HdRenderBufferDescriptor GetRenderBufferDescriptor(const SdfPath& id) override;
    HdVolumeFieldDescriptorVector GetVolumeFieldDescriptors(const SdfPath& id) override;
    VtValue GetLightParamValue(const SdfPath& id, const TfToken& name) override;
    VtValue GetCameraParamValue(const SdfPath& id, const TfToken& name) override;
    HdPrimvarDescriptorVector GetPrimvarDescriptors(const SdfPath& id,
                                                    HdInterpolation interpolation) override;
    TfTokenVector GetExtComputationSceneInputNames(const SdfPath& id) override;
    HdExtComputationInputDescriptorVector
    GetExtComputationInputDescriptors(const SdfPath& id) override;
    HdExtComputationOutputDescriptorVector
    GetExtComputationOutputDescriptors(const SdfPath& id) override;
    HdExtComputationPrimvarDescriptorVector
    GetExtComputationPrimvarDescriptors(const SdfPath& id, HdInterpolation interpolation) override;
    VtValue GetExtComputationInput(const SdfPath& id, const TfToken& input) override;
    void InvokeExtComputation(const SdfPath& id, HdExtComputationContext* context) override;

private:
    const std::vector<PrimvarData>* _FindPrimvars(const SdfPath& id) const;
    const PrimvarData* _FindPrimvar(const SdfPath& id, const TfToken& name) const;

    SceneData _data;
    std::map<SdfPath, HdRenderBufferDescriptor> _buffers;
};

} // namespace hydraHost
