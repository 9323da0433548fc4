// SPDX-License-Identifier: Apache-2.0
// Builders of the host's scenes.
#include "hostScene.h"

#include <pxr/base/gf/range1f.h>
#include <pxr/imaging/cameraUtil/conformWindow.h>
#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/light.h>

namespace hydraHost {

PrimvarData* GprimData::FindPrimvar(const TfToken& name) {
    for (PrimvarData& primvar : primvars) {
        if (primvar.name == name) {
            return &primvar;
        }
    }
    return nullptr;
}

void GprimData::SetPrimvar(const char* name, HdInterpolation interpolation, const VtValue& value,
                           const TfToken& role) {
    const TfToken token(name);
    PrimvarData* primvar = FindPrimvar(token);
    if (!primvar) {
        primvar = &primvars.emplace_back();
    }
    *primvar = {token, interpolation, role, value, {}};
}

GprimData MakeMesh(const std::vector<GfVec3f>& points, const std::vector<int>& counts,
                   const std::vector<int>& indices, const std::string& scheme) {
    GprimData gprim;
    gprim.mesh = HdMeshTopology(TfToken(scheme), HdTokens->rightHanded,
                                VtIntArray(counts.begin(), counts.end()),
                                VtIntArray(indices.begin(), indices.end()));
    gprim.SetPrimvar("points", HdInterpolationVertex,
                     VtValue(VtVec3fArray(points.begin(), points.end())),
                     HdPrimvarRoleTokens->point);
    return gprim;
}

GprimData MakeGrid(float x, float y, int numX, int numY) {
    std::vector<GfVec3f> points;
    std::vector<int> counts;
    std::vector<int> indices;
    for (int j = 0; j <= numY; ++j) {
        for (int i = 0; i <= numX; ++i) {
            points.emplace_back(x * (2.0F * float(i) / float(numX) - 1.0F),
                                y * (2.0F * float(j) / float(numY) - 1.0F), 0.0F);
        }
    }
    for (int j = 0; j < numY; ++j) {
        for (int i = 0; i < numX; ++i) {
            const int first = j * (numX + 1) + i;
            counts.push_back(4);
            indices.insert(indices.end(), {first, first + 1, first + numX + 2, first + numX + 1});
        }
    }
    return MakeMesh(points, counts, indices);
}

GprimData MakeCube(float half) {
    std::vector<GfVec3f> points;
    for (int corner = 0; corner < 8; ++corner) {
        points.emplace_back((corner & 1) ? half : -half, (corner & 2) ? half : -half,
                            (corner & 4) ? half : -half);
    }
    return MakeMesh(points, {4, 4, 4, 4, 4, 4},
                    {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6});
}

HdMaterialNetworkMap MakeMaterial(const GfVec3f& diffuse, const GfVec3f& emissive, float opacity) {
    HdMaterialNode node;
    node.path = SdfPath("/Surface");
    node.identifier = TfToken("UsdPreviewSurface");
    node.parameters[TfToken("diffuseColor")] = VtValue(diffuse);
    node.parameters[TfToken("emissiveColor")] = VtValue(emissive);
    node.parameters[TfToken("opacity")] = VtValue(opacity);
    node.parameters[TfToken("roughness")] = VtValue(1.0F);
    node.parameters[TfToken("useSpecularWorkflow")] = VtValue(1);
    HdMaterialNetworkMap network;
    network.map[HdMaterialTerminalTokens->surface].nodes.push_back(node);
    network.terminals.push_back(node.path);
    return network;
}

LightData MakeDome(const GfVec3f& radiance) {
    LightData light;
    light.type = HdPrimTypeTokens->domeLight;
    light.params[HdLightTokens->color] = VtValue(radiance);
    light.params[HdLightTokens->intensity] = VtValue(1.0F);
    light.params[HdLightTokens->exposure] = VtValue(0.0F);
    return light;
}

CameraData MakeCamera(const GfVec3d& eye, double apertures) {
    CameraData camera;
    camera.transform.SetTranslate(eye);
    camera.params = {
        {HdCameraTokens->projection, VtValue(HdCamera::Perspective)},
        {HdCameraTokens->horizontalAperture, VtValue(2.0F)},
        {HdCameraTokens->verticalAperture, VtValue(1.5F)},
        {HdCameraTokens->horizontalApertureOffset, VtValue(0.0F)},
        {HdCameraTokens->verticalApertureOffset, VtValue(0.0F)},
        {HdCameraTokens->focalLength, VtValue(float(2.0 * apertures))},
        {HdCameraTokens->clippingRange, VtValue(GfRange1f(0.5F, 100.0F))},
        {HdCameraTokens->windowPolicy, VtValue(CameraUtilFit)},
    };
    return camera;
}

CameraData MakeOrthographicCamera(const GfVec3d& eye, double halfWidth) {
    CameraData camera = MakeCamera(eye);
    camera.params[HdCameraTokens->projection] = VtValue(HdCamera::Orthographic);
    camera.params[HdCameraTokens->horizontalAperture] = VtValue(float(2.0 * halfWidth));
    camera.params[HdCameraTokens->verticalAperture] = VtValue(float(1.5 * halfWidth));
    return camera;
}

GfMatrix4d Translation(double x, double y, double z) {
    return GfMatrix4d(1.0).SetTranslate(GfVec3d(x, y, z));
}

} // namespace hydraHost
