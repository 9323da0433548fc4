// SPDX-License-Identifier: Apache-2.0
// The scenes of the Hydra host: plain values that a test edits and copies. SyntheticScene shows
// one to a render index.
// Explained in docs/testing.md.
#pragma once

#include <pxr/base/gf/matrix4d.h>
#include <pxr/base/vt/value.h>
#include <pxr/imaging/hd/basisCurvesTopology.h>
#include <pxr/imaging/hd/enums.h>
#include <pxr/imaging/hd/material.h>
#include <pxr/imaging/hd/meshTopology.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>
#include <pxr/imaging/pxOsd/subdivTags.h>
#include <pxr/usd/sdf/path.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace hydraHost {

PXR_NAMESPACE_USING_DIRECTIVE

/// A primvar, "points" included.
struct PrimvarData {
    TfToken name;
    HdInterpolation interpolation = HdInterpolationConstant;
    TfToken role;
    VtValue value;
    VtIntArray indices; ///< empty: not indexed
};

/// Visible geometry of any type; only the topology of its type counts.
struct GprimData {
    TfToken type = HdPrimTypeTokens->mesh;
    HdMeshTopology mesh;
    HdBasisCurvesTopology curves;
    PxOsdSubdivTags subdivTags;
    std::vector<PrimvarData> primvars;
    std::vector<HdExtComputationPrimvarDescriptor> computedPrimvars;
    GfMatrix4d transform{1.0}; ///< world from object; below an instancer: prototype from object
    std::map<float, GfMatrix4d> transformSamples; ///< by time, in frames; empty: at rest
    bool isVisible = true;
    bool isDoubleSided = true;
    HdCullStyle cullStyle = HdCullStyleDontCare;
    int refineLevel = 0;
    SdfPath material;
    TfToken renderTag = HdRenderTagTokens->geometry;
    SdfPath instancer;
    SdfPath scenePath; ///< what Hydra asks for where an instancer places it; empty: not known
    HdVolumeFieldDescriptorVector volumeFields; ///< of the type volume

    /// The primvar of that name; null when there is none.
    PrimvarData* FindPrimvar(const TfToken& name);
    /// Adds or replaces.
    void SetPrimvar(const char* name, HdInterpolation interpolation, const VtValue& value,
                    const TfToken& role = HdPrimvarRoleTokens->none);
};

struct InstancerData {
    GfMatrix4d transform{1.0};
    SdfPath parent; ///< empty: world
    std::vector<PrimvarData> primvars;
    std::map<SdfPath, VtIntArray> indicesByPrototype;
    bool isVisible = true;
};

struct LightData {
    TfToken type = HdPrimTypeTokens->distantLight;
    GfMatrix4d transform{1.0};
    std::map<TfToken, VtValue> params;
    bool isVisible = true;
    VtValue resource; ///< of a lightFilter: its network
};

struct CameraData {
    GfMatrix4d transform{1.0};
    std::map<TfToken, VtValue> params;
};

/// A computation with scene inputs and one output; `run` makes the output of the inputs.
struct ComputationData {
    std::map<TfToken, VtValue> inputs;
    TfToken output;
    HdTupleType outputType{HdTypeFloatVec3, 1};
    size_t numElements = 0;
    std::function<VtValue(const std::map<TfToken, VtValue>&)> run;
};

/// An OpenVDBAsset.
struct FieldData {
    std::map<TfToken, VtValue> params;
};

/// A whole scene. Copies are cheap: arrays are shared.
struct SceneData {
    std::map<SdfPath, GprimData> gprims;
    std::map<SdfPath, InstancerData> instancers;
    std::map<SdfPath, HdMaterialNetworkMap> materials;
    std::map<SdfPath, LightData> lights;
    std::map<SdfPath, CameraData> cameras;
    std::map<SdfPath, ComputationData> computations;
    std::map<SdfPath, FieldData> fields;
};

// --- Builders -----------------------------------------------------------------------------------

/// A mesh of polygons; scheme "none" or a subdivision scheme.
GprimData MakeMesh(const std::vector<GfVec3f>& points, const std::vector<int>& counts,
                   const std::vector<int>& indices, const std::string& scheme = "none");

/// The rectangle [-x, x] x [-y, y] at z = 0 that faces +z, numX x numY quads.
GprimData MakeGrid(float x, float y, int numX = 1, int numY = 1);

/// The cube [-half, half]^3 of six quads; faces in the order -x +x -y +y -z +z.
GprimData MakeCube(float half);

/// A UsdPreviewSurface of that diffuse and emissive colour.
HdMaterialNetworkMap MakeMaterial(const GfVec3f& diffuse, const GfVec3f& emissive = GfVec3f(0),
                                  float opacity = 1.0F);

/// A dome of that radiance in all directions: closed forms follow.
LightData MakeDome(const GfVec3f& radiance);

/// A camera at `eye` that looks along -z; focal length of `apertures` horizontal apertures.
CameraData MakeCamera(const GfVec3d& eye, double apertures = 1.0);
/// An orthographic camera that shows [-halfWidth, halfWidth] horizontally.
CameraData MakeOrthographicCamera(const GfVec3d& eye, double halfWidth);

GfMatrix4d Translation(double x, double y, double z);

} // namespace hydraHost
