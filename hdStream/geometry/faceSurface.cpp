// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/faceSurface.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>

namespace hds {
namespace {

using PointDescriptor = OpenSubdiv::Bfr::Surface<double>::PointDescriptor;

/// Tangents whose cross product is below this part of their squares, or that are as good as
/// parallel, have no normal.
constexpr double kMinArea = 1e-9;
constexpr double kMinSine = 1e-3;

/// Newell's normal of a cage face: what is left when all of a surface is degenerate.
glm::dvec3 CageNormal(const SubdivModel& model, int face) {
    const auto corners = model.Level().GetFaceVertices(face);
    const float* points = model.Mesh().points.data();
    const auto at = [&](int i) {
        const float* p = points + 3 * std::size_t(corners[i % corners.size()]);
        return glm::dvec3(p[0], p[1], p[2]);
    };
    glm::dvec3 sum(0.0);
    for (int i = 1; i + 1 < corners.size(); ++i) {
        sum += glm::cross(at(i) - at(0), at(i + 1) - at(0));
    }
    return sum;
}

} // namespace

FacePoint FaceCentre(FaceShape shape) {
    return {0, shape == FaceShape::Quad       ? glm::dvec2(0.5)
               : shape == FaceShape::Triangle ? glm::dvec2(1.0 / 3.0)
                                              : glm::dvec2(1.0)};
}

FaceSurface::FaceSurface(const SubdivModel& model, int face)
    : _model(model), _face(face), _shape(model.Shape(face)) {
    model.Surfaces(face).InitVertexSurface(face, &_surface);
}

const double* FaceSurface::Points() const {
    if (_points.empty()) {
        _points.resize(3 * std::size_t(_surface.GetNumPatchPoints()));
        _surface.GatherControlPoints(_model.Mesh().points.data(), PointDescriptor(3),
                                     _points.data(), PointDescriptor(3));
        _surface.ComputePatchPoints(_points.data(), PointDescriptor(3));
    }
    return _points.data();
}

std::array<double, 2> FaceSurface::Coordinates(const FacePoint& at) const {
    std::array<double, 2> uv{at.uv.x, at.uv.y};
    if (_shape == FaceShape::SubQuads) {
        const double subFace[2] = {at.uv.x, at.uv.y};
        _surface.GetParameterization().ConvertNormalizedSubFaceToCoord(at.subFace, subFace,
                                                                       uv.data());
    }
    return uv;
}

glm::dvec3 FaceSurface::Point(const FacePoint& at) const {
    glm::dvec3 point;
    _surface.Evaluate(Coordinates(at).data(), Points(), PointDescriptor(3), &point.x);
    return point;
}

SurfaceFrame FaceSurface::Frame(const FacePoint& at) const {
    SurfaceFrame frame;
    _surface.Evaluate(Coordinates(at).data(), Points(), PointDescriptor(3), &frame.point.x,
                      &frame.tangentU.x, &frame.tangentV.x);
    return frame;
}

SurfaceFrame2 FaceSurface::Frame2(const FacePoint& at) const {
    SurfaceFrame2 frame;
    _surface.Evaluate(Coordinates(at).data(), Points(), PointDescriptor(3), &frame.point.x,
                      &frame.tangentU.x, &frame.tangentV.x, &frame.uu.x, &frame.uv.x, &frame.vv.x);
    return frame;
}

glm::dvec3 FaceSurface::Normal(const FacePoint& at, const SurfaceFrame& frame) const {
    const double side = _model.Mesh().leftHanded ? -1.0 : 1.0;
    const auto normalOf = [&](const SurfaceFrame& f, glm::dvec3& normal) {
        normal = glm::cross(f.tangentU, f.tangentV);
        const double length = glm::length(normal);
        const double u = glm::length(f.tangentU);
        const double v = glm::length(f.tangentV);
        normal *= length > 0.0 ? side / length : 0.0;
        return length > std::max(kMinArea * (u * u + v * v), kMinSine * u * v);
    };
    glm::dvec3 normal;
    if (normalOf(frame, normal)) {
        return normal;
    }
    // At a collapsed edge, as the tip of a cone, normals exist just beside.
    FacePoint inside = at;
    inside.uv = glm::mix(at.uv, FaceCentre(_shape).uv, 1.0 / 64.0);
    if (normalOf(Frame(inside), normal)) {
        return normal;
    }
    const glm::dvec3 cage = CageNormal(_model, _face);
    const double length = glm::length(cage);
    return length > 0.0 ? cage * (side / length) : glm::dvec3(0.0, 0.0, 1.0);
}

void FaceSurface::ControlPoints(std::vector<int>& points) const {
    points.resize(std::size_t(_surface.GetNumControlPoints()));
    _surface.GetControlPointIndices(points.data());
}

void FaceSurface::Prepare(const ValueRows& rows, Prepared& prepared) const {
    const PointDescriptor row(rows.rowSize);
    prepared.rowSize = rows.rowSize;
    prepared.points.resize(std::size_t(rows.rowSize) *
                           std::size_t(prepared.surface.GetNumPatchPoints()));
    prepared.surface.GatherControlPoints(rows.values.data(), row, prepared.points.data(), row);
    prepared.surface.ComputePatchPoints(prepared.points.data(), row);
}

void FaceSurface::Evaluate(const Prepared& prepared, const FacePoint& at, double* values) const {
    prepared.surface.Evaluate(Coordinates(at).data(), prepared.points.data(),
                              PointDescriptor(prepared.rowSize), values);
}

void FaceSurface::VertexValues(const FacePoint& at, double* values) {
    if (!_vertex) {
        _vertex = std::make_unique<Prepared>();
        _vertex->surface = _surface;
        Prepare(_model.VertexRows(), *_vertex);
    }
    Evaluate(*_vertex, at, values);
}

void FaceSurface::VaryingValues(const FacePoint& at, double* values) {
    if (!_varying) {
        _varying = std::make_unique<Prepared>();
        _model.Surfaces(_face).InitVaryingSurface(_face, &_varying->surface);
        Prepare(_model.VaryingRows(), *_varying);
    }
    Evaluate(*_varying, at, values);
}

void FaceSurface::ChannelValues(int channel, const FacePoint& at, double* values) {
    _channels.resize(std::max(_channels.size(), std::size_t(channel) + 1));
    std::unique_ptr<Prepared>& prepared = _channels[channel];
    if (!prepared) {
        prepared = std::make_unique<Prepared>();
        _model.Surfaces(_face).InitFaceVaryingSurface(_face, &prepared->surface, channel);
        Prepare(_model.ChannelRows(channel), *prepared);
    }
    Evaluate(*prepared, at, values);
}

FaceSurface& FaceSurfaces::At(int face) {
    std::unique_ptr<FaceSurface>& surface = _faces[face];
    if (!surface) {
        surface = std::make_unique<FaceSurface>(_model, face);
    }
    return *surface;
}

} // namespace hds
