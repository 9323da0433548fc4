// SPDX-License-Identifier: Apache-2.0
// Brute-force first hits in double precision.
#include "hostOracle.h"

#include <pxr/base/gf/quath.h>
#include <pxr/base/gf/rotation.h>
#include <pxr/imaging/hd/camera.h>

#include <algorithm>
#include <cmath>

namespace hydraHost {

namespace {

/// The matrix of one instance from its primvars, row vectors: transform, scale, rotate, translate.
GfMatrix4d InstanceMatrix(const InstancerData& instancer, int index) {
    GfMatrix4d result(1.0);
    for (const PrimvarData& primvar : instancer.primvars) {
        if (primvar.name == HdInstancerTokens->instanceTransforms) {
            result = result * primvar.value.Get<VtMatrix4dArray>()[size_t(index)];
        }
    }
    for (const PrimvarData& primvar : instancer.primvars) {
        if (primvar.name == HdInstancerTokens->instanceScales) {
            result = result * GfMatrix4d(1.0).SetScale(
                                  GfVec3d(primvar.value.Get<VtVec3fArray>()[size_t(index)]));
        }
    }
    for (const PrimvarData& primvar : instancer.primvars) {
        if (primvar.name == HdInstancerTokens->instanceRotations) {
            const GfQuath rotation = primvar.value.Get<VtQuathArray>()[size_t(index)];
            result = result * GfMatrix4d(1.0).SetRotate(GfQuatd(rotation));
        }
    }
    for (const PrimvarData& primvar : instancer.primvars) {
        if (primvar.name == HdInstancerTokens->instanceTranslations) {
            result = result * GfMatrix4d(1.0).SetTranslate(
                                  GfVec3d(primvar.value.Get<VtVec3fArray>()[size_t(index)]));
        }
    }
    return result * instancer.transform;
}

/// Surfaces nearer to each other than this, and pixel centres nearer to an edge, are not compared.
/// Scene units: the host's scenes are a few units large and a pixel is some hundredths.
constexpr double kSurfaceDistance = 1e-4;

bool IsNearEdge(const GfVec3d (&points)[3], const GfVec3d& position) {
    for (int i = 0; i < 3; ++i) {
        const GfVec3d& a = points[i];
        const GfVec3d edge = points[(i + 1) % 3] - a;
        const double along = GfDot(position - a, edge) / edge.GetLengthSq();
        const GfVec3d nearest = a + edge * std::min(std::max(along, 0.0), 1.0);
        if ((position - nearest).GetLength() < kSurfaceDistance) {
            return true;
        }
    }
    return false;
}

/// Precondition: the position is in the triangle's plane.
bool IsInside(const GfVec3d (&points)[3], const GfVec3d& position) {
    const GfVec3d winding = GfCross(points[1] - points[0], points[2] - points[0]);
    for (int i = 0; i < 3; ++i) {
        const GfVec3d& a = points[i];
        if (GfDot(GfCross(points[(i + 1) % 3] - a, position - a), winding) < 0.0) {
            return false;
        }
    }
    return true;
}

} // namespace

std::vector<GfMatrix4d> FlattenInstances(const SceneData& scene, const SdfPath& instancer,
                                         const SdfPath& prototype) {
    if (instancer.IsEmpty()) {
        return {GfMatrix4d(1.0)};
    }
    const InstancerData& data = scene.instancers.at(instancer);
    std::vector<GfMatrix4d> flat;
    for (const GfMatrix4d& parent : FlattenInstances(scene, data.parent, instancer)) {
        for (const int index : data.indicesByPrototype.at(prototype)) {
            flat.push_back(InstanceMatrix(data, index) * parent);
        }
    }
    return flat;
}

Oracle::Oracle(Host& host) {
    const HdRenderPassState& state = host.Task().State();
    _viewFromWorld = state.GetWorldToViewMatrix();
    _clipFromWorld = _viewFromWorld * state.GetProjectionMatrix();
    const GfVec4f viewport = state.GetViewport();
    _dataWindow = state.GetFraming().IsValid()
                      ? state.GetFraming().dataWindow
                      : GfRect2i(GfVec2i(int(viewport[0]), int(viewport[1])), int(viewport[2]),
                                 int(viewport[3]));
    _height = int(state.GetAovBindings().front().renderBuffer->GetHeight());
    const SceneData& scene = host.Scene().Data();
    for (const auto& [path, gprim] : scene.gprims) {
        if (!gprim.isVisible || gprim.type != HdPrimTypeTokens->mesh) {
            continue;
        }
        int instance = gprim.instancer.IsEmpty() ? -1 : 0;
        for (const GfMatrix4d& world : FlattenInstances(scene, gprim.instancer, path)) {
            _AddMesh(path, gprim, gprim.transform * world, instance++);
        }
    }
}

void Oracle::_AddMesh(const SdfPath& path, const GprimData& gprim,
                      const GfMatrix4d& worldFromObject, int instance) {
    const auto& points = const_cast<GprimData&>(gprim)
                             .FindPrimvar(HdTokens->points)
                             ->value.UncheckedGet<VtVec3fArray>();
    const VtIntArray counts = gprim.mesh.GetFaceVertexCounts();
    const VtIntArray indices = gprim.mesh.GetFaceVertexIndices();
    const VtIntArray holes = gprim.mesh.GetHoleIndices();
    // A mirrored transform turns the outside in, and so does left-handed orientation; the normal
    // is that of the transformed surface's outside.
    const bool isFlipped = (worldFromObject.GetDeterminant() < 0.0) !=
                           (gprim.mesh.GetOrientation() == HdTokens->leftHanded);
    size_t first = 0;
    for (size_t face = 0; face < counts.size(); ++face) {
        const size_t count = size_t(counts[face]);
        if (std::find(holes.begin(), holes.end(), int(face)) == holes.end()) {
            for (size_t corner = 1; corner + 1 < count; ++corner) {
                Triangle triangle{{}, {}, path, instance, int(face)};
                const size_t corners[3] = {first, first + corner, first + corner + 1};
                for (int i = 0; i < 3; ++i) {
                    triangle.points[i] = worldFromObject.TransformAffine(
                        GfVec3d(points[size_t(indices[corners[i]])]));
                }
                triangle.normal = GfCross(triangle.points[1] - triangle.points[0],
                                          triangle.points[2] - triangle.points[0])
                                      .GetNormalized();
                if (isFlipped) {
                    triangle.normal = -triangle.normal;
                }
                _triangles.push_back(triangle);
            }
        }
        first += count;
    }
}

OracleHit Oracle::Trace(int x, int y) const {
    const double ndcX = 2.0 * (x + 0.5 - _dataWindow.GetMinX()) / _dataWindow.GetWidth() - 1.0;
    const double ndcY =
        1.0 - 2.0 * (_height - y - 0.5 - _dataWindow.GetMinY()) / _dataWindow.GetHeight();
    const GfMatrix4d worldFromClip = _clipFromWorld.GetInverse();
    const GfVec3d origin = worldFromClip.Transform(GfVec3d(ndcX, ndcY, -1.0));
    const GfVec3d end = worldFromClip.Transform(GfVec3d(ndcX, ndcY, 1.0));
    const GfVec3d direction = (end - origin).GetNormalized();
    OracleHit hit;
    double nearest = (end - origin).GetLength();
    double nearestEdge = nearest;
    for (const Triangle& triangle : _triangles) {
        const double slope = GfDot(triangle.normal, direction);
        const double t = GfDot(triangle.points[0] - origin, triangle.normal) / slope;
        if (!(t >= 0.0 && t <= nearest + kSurfaceDistance)) {
            continue;
        }
        const GfVec3d position = origin + direction * t;
        if (IsNearEdge(triangle.points, position)) {
            nearestEdge = std::min(nearestEdge, t);
        }
        if (t < nearest && IsInside(triangle.points, position)) {
            hit.isAmbiguous = hit.isHit && nearest - t < kSurfaceDistance;
            nearest = t;
            hit.isHit = true;
            hit.prim = triangle.prim;
            hit.instance = triangle.instance;
            hit.face = triangle.face;
            hit.position = position;
            hit.normal = triangle.normal;
        }
    }
    hit.isAmbiguous = hit.isAmbiguous || nearestEdge < nearest + kSurfaceDistance;
    if (hit.isHit) {
        hit.depth = _clipFromWorld.Transform(hit.position)[2] * 0.5 + 0.5;
        hit.cameraDepth = -_viewFromWorld.Transform(hit.position)[2];
    } else {
        hit.isAmbiguous = nearestEdge < nearest;
    }
    return hit;
}

} // namespace hydraHost
