// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/subdivPoints.h"

#include "hdStream/geometry/primvars.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

namespace Far = OpenSubdiv::Far;

/// Half the distance of the points whose difference is a tangent of the displaced surface.
constexpr double kStep = 1.0 / 256.0;

} // namespace

FaceLocation SubdivPoints::EdgeIn(int face, int edge, double t) const {
    const Far::TopologyLevel& level = _model.Level();
    const int local = FindIn(level.GetFaceEdges(face), edge);
    const Far::ConstIndexArray corners = level.GetFaceVertices(face);
    const bool isForward = corners[local] == level.GetEdgeVertices(edge)[0];
    return {face, EdgePoint(_model.Shape(face), std::uint32_t(corners.size()), std::uint32_t(local),
                            isForward ? t : 1.0 - t)};
}

FaceLocation SubdivPoints::VertexIn(int face, int vertex) const {
    const Far::ConstIndexArray corners = _model.Level().GetFaceVertices(face);
    return {face, EdgePoint(_model.Shape(face), std::uint32_t(corners.size()),
                            std::uint32_t(FindIn(corners, vertex)), 0.0)};
}

FaceLocation SubdivPoints::OnEdge(int edge, double t) const {
    return EdgeIn(_model.EdgeOwner(edge), edge, t);
}

FaceLocation SubdivPoints::AtVertex(int vertex) const {
    return VertexIn(_model.VertexOwner(vertex), vertex);
}

/// The first four components of a primvar on the limit surface.
std::array<double, 4> SubdivPoints::PrimvarAt(std::size_t index, const FaceLocation& location) {
    const SubdivPrimvar& primvar = _model.Primvars()[index];
    const GeometryAttribute& attribute = primvar.attribute;
    FaceSurface& surface = _surfaces.At(location.face);
    const int own = std::max(int(attribute.numComponents), 4);
    _row.assign(
        std::size_t(std::max({_model.VertexRows().rowSize, _model.VaryingRows().rowSize, own})),
        0.0);
    switch (attribute.interpolation) {
    case Interpolation::Vertex:
        surface.VertexValues(location.at, _row.data());
        break;
    case Interpolation::Varying:
        surface.VaryingValues(location.at, _row.data());
        break;
    case Interpolation::FaceVarying:
        surface.ChannelValues(primvar.channel, location.at, _row.data());
        break;
    default: {
        const bool isUniform = attribute.interpolation == Interpolation::Uniform;
        const std::uint32_t face = _model.Cage().faces[location.face];
        const float* value = ValueOf(attribute, isUniform ? face : 0);
        std::transform(value, value + attribute.numComponents, _row.begin() + primvar.offset,
                       [](float v) { return std::isfinite(v) ? double(v) : 0.0; });
        break;
    }
    }
    std::array<double, 4> value{};
    std::copy_n(_row.begin() + primvar.offset, std::min(attribute.numComponents, 4U),
                value.begin());
    return value;
}

double SubdivPoints::Amount(const FaceLocation& location) {
    const std::uint32_t face = _model.Cage().faces[location.face];
    const std::uint32_t entry = _entries.empty() ? 0 : _entries[face];
    if (entry >= _displacement.amounts.size()) {
        return 0.0;
    }
    const BoundAmount& bound = _displacement.amounts[entry];
    if (bound.amount == nullptr) {
        return bound.constant;
    }
    _point.primvars.clear();
    for (std::size_t i = 0; i < bound.attributes.size(); ++i) {
        _point.primvars.push_back(bound.attributes[i] == BoundAmount::kMissing
                                      ? bound.amount->Primvars()[i].missing
                                      : PrimvarAt(bound.attributes[i], location));
    }
    if (bound.amount->ReadsPosition()) {
        _point.position = _surfaces.At(location.face).Frame(location.at).point;
    }
    // Interpolation may leave the range by rounding; boxes rely on it.
    return glm::clamp(bound.amount->At(_point), _displacement.range.low, _displacement.range.high);
}

/// Displaced along the face's own normal.
glm::dvec3 SubdivPoints::OwnPosition(const FaceLocation& location) {
    const FaceSurface& surface = _surfaces.At(location.face);
    const SurfaceFrame frame = surface.Frame(location.at);
    return frame.point + Amount(location) * surface.Normal(location.at, frame);
}

/// Of the displaced surface, by differences on the face: the amount may be any function, and
/// second derivatives of the surface do not exist at extraordinary vertices.
glm::dvec3 SubdivPoints::DisplacedNormal(const FaceLocation& location) {
    const FaceShape shape = _model.Shape(location.face);
    FacePoint centre = location.at;
    glm::dvec2 low = glm::max(centre.uv - kStep, 0.0);
    glm::dvec2 high = glm::min(centre.uv + kStep, 1.0);
    if (shape == FaceShape::Triangle) {
        centre.uv = glm::mix(centre.uv, FaceCentre(shape).uv, 4.0 * kStep);
        low = centre.uv - kStep;
        high = centre.uv + kStep;
    }
    const auto at = [&](double u, double v) {
        return OwnPosition({location.face, {centre.subFace, {u, v}}});
    };
    SurfaceFrame frame;
    frame.tangentU = at(high.x, centre.uv.y) - at(low.x, centre.uv.y);
    frame.tangentV = at(centre.uv.x, high.y) - at(centre.uv.x, low.y);
    const double cross = glm::length(glm::cross(frame.tangentU, frame.tangentV));
    const FaceSurface& surface = _surfaces.At(location.face);
    return cross > 0.0 ? surface.Normal(location.at, frame)
                       : surface.Normal(location.at, surface.Frame(location.at));
}

glm::dvec3 SubdivPoints::Normal(const FaceLocation& location) {
    if (_displacement.IsActive() && !_displacement.IsConstant()) {
        return DisplacedNormal(location);
    }
    const FaceSurface& surface = _surfaces.At(location.face);
    return surface.Normal(location.at, surface.Frame(location.at));
}

/// \param locations the same point on each drawn face that has it, the owner first.
SurfacePoint SubdivPoints::Shared(const std::vector<FaceLocation>& locations, bool isSharp) {
    const FaceLocation& owner = locations.front();
    const FaceSurface& surface = _surfaces.At(owner.face);
    const SurfaceFrame frame = surface.Frame(owner.at);
    glm::dvec3 direction = surface.Normal(owner.at, frame);
    SurfacePoint point{frame.point, direction};
    if (!_displacement.IsActive()) {
        return point;
    }
    double amount = 0.0;
    glm::dvec3 sum(0.0);
    for (const FaceLocation& location : locations) {
        amount += Amount(location);
        if (isSharp) {
            const FaceSurface& other = _surfaces.At(location.face);
            sum += other.Normal(location.at, other.Frame(location.at));
        }
    }
    const double length = glm::length(sum);
    direction = length > 1e-6 ? sum / length : direction;
    point.position += direction * (amount / double(locations.size()));
    point.normal = Normal(owner);
    return point;
}

SurfacePoint SubdivPoints::Inside(const FaceLocation& location) {
    _locations.assign(1, location);
    return Shared(_locations, false);
}

SurfacePoint SubdivPoints::Edge(int edge, double t) {
    _locations.assign(1, OnEdge(edge, t));
    if (_displacement.IsActive()) {
        const Far::ConstIndexArray faces = _model.Level().GetEdgeFaces(edge);
        for (int i = 0; i < faces.size(); ++i) {
            if (_model.IsDrawn(faces[i]) && faces[i] != _locations.front().face) {
                _locations.push_back(EdgeIn(faces[i], edge, t));
            }
        }
    }
    return Shared(_locations, _model.IsSharpEdge(edge));
}

SurfacePoint SubdivPoints::Vertex(int vertex) {
    _locations.assign(1, AtVertex(vertex));
    if (_displacement.IsActive()) {
        const Far::ConstIndexArray faces = _model.Level().GetVertexFaces(vertex);
        for (int i = 0; i < faces.size(); ++i) {
            if (_model.IsDrawn(faces[i]) && faces[i] != _locations.front().face) {
                _locations.push_back(VertexIn(faces[i], vertex));
            }
        }
    }
    return Shared(_locations, _model.IsSharpVertex(vertex));
}

glm::dvec3 SubdivPoints::EdgeSideNormal(const FaceLocation& location) {
    return Normal(location);
}

glm::dvec3 SubdivPoints::VertexSideNormal(int vertex, int face) {
    // Flood over the faces around the vertex, never across a sharp edge. The sum is in the order
    // of the level's list, so that every face of a side gets the same bits.
    const Far::TopologyLevel& level = _model.Level();
    const Far::ConstIndexArray faces = level.GetVertexFaces(vertex);
    std::vector<char> isOnSide(std::size_t(faces.size()), 0);
    std::vector<int> pending = {FindIn(faces, face)};
    isOnSide[std::size_t(pending[0])] = 1;
    while (!pending.empty()) {
        const int at = pending.back();
        pending.pop_back();
        const Far::ConstIndexArray edges = level.GetFaceEdges(faces[at]);
        for (int e = 0; e < edges.size(); ++e) {
            if (_model.IsSharpEdge(edges[e]) ||
                FindIn(level.GetEdgeVertices(edges[e]), vertex) < 0) {
                continue;
            }
            const Far::ConstIndexArray neighbours = level.GetEdgeFaces(edges[e]);
            for (int n = 0; n < neighbours.size(); ++n) {
                const int other = FindIn(faces, neighbours[n]);
                if (other >= 0 && isOnSide[std::size_t(other)] == 0) {
                    isOnSide[std::size_t(other)] = 1;
                    pending.push_back(other);
                }
            }
        }
    }
    glm::dvec3 sum(0.0);
    for (int i = 0; i < faces.size(); ++i) {
        if (isOnSide[std::size_t(i)] != 0 && _model.IsDrawn(faces[i])) {
            sum += Normal(VertexIn(faces[i], vertex));
        }
    }
    const double length = glm::length(sum);
    return length > 1e-9 ? sum / length : Normal(VertexIn(face, vertex));
}

} // namespace hds
