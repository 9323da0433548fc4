// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/subdivPoints.h"

#include "hdStream/geometry/primvars.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace hds {
namespace {

namespace Far = OpenSubdiv::Far;

/// Half the distance of the points whose difference is a tangent of the displaced surface.
constexpr double kStep = 1.0 / 256.0;

/// Points of a face whose differences stand for derivatives along two ways, U and V.
struct DifferencePoints {
    FacePoint lowU;
    FacePoint highU;
    FacePoint lowV;
    FacePoint highV;
};

/// The part of a way from a point that is in the face, kStep to both sides at most.
struct Reach {
    glm::dvec2 low;
    glm::dvec2 high;
    double length = 0.0; ///< in ways
};

Reach ReachOf(FaceShape shape, const glm::dvec2& from, const glm::dvec2& way) {
    double low = -kStep;
    double high = kStep;
    const auto end = [&](double inside, double slope) { // where inside + t * slope is 0
        if (slope > 0.0) {
            low = std::max(low, -inside / slope);
        } else if (slope < 0.0) {
            high = std::min(high, inside / -slope);
        }
    };
    end(from.x, way.x);
    end(from.y, way.y);
    if (shape == FaceShape::Triangle) {
        end(1.0 - from.x - from.y, -way.x - way.y);
    } else {
        end(1.0 - from.x, -way.x);
        end(1.0 - from.y, -way.y);
    }
    return {from + low * way, from + high * way, high - low};
}

/// Of a triangle two of the three ways along its sides are taken, for at a corner one of them
/// leaves it to both sides. Any two, in the order of `ways`, turn to the same side as u and v.
DifferencePoints PointsAround(FaceShape shape, const FacePoint& centre) {
    const std::array<glm::dvec2, 3> ways{glm::dvec2(1, 0), glm::dvec2(0, 1), glm::dvec2(-1, 1)};
    std::array<Reach, 3> reaches;
    std::transform(ways.begin(), ways.end(), reaches.begin(),
                   [&](const glm::dvec2& way) { return ReachOf(shape, centre.uv, way); });
    std::size_t first = 0;
    std::size_t second = 1;
    const auto prefer = [&](std::size_t a, std::size_t b) {
        if (std::min(reaches[a].length, reaches[b].length) >
            std::min(reaches[first].length, reaches[second].length)) {
            first = a;
            second = b;
        }
    };
    if (shape == FaceShape::Triangle) {
        prefer(0, 2);
        prefer(1, 2);
    }
    const auto at = [&](const glm::dvec2& uv) { return FacePoint{centre.subFace, uv}; };
    return {at(reaches[first].low), at(reaches[first].high), at(reaches[second].low),
            at(reaches[second].high)};
}

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

void SubdivPoints::FindPoint(const BoundAmount& bound, const FaceLocation& location) {
    _point.primvars.clear();
    for (std::size_t i = 0; i < bound.attributes.size(); ++i) {
        _point.primvars.push_back(bound.attributes[i] == BoundAmount::kMissing
                                      ? bound.amount->Primvars()[i].missing
                                      : PrimvarAt(bound.attributes[i], location));
    }
    if (bound.amount->ReadsPosition()) {
        _point.position = _surfaces.At(location.face).Frame(location.at).point;
    }
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
    if (bound.amount->Space() != DisplacementSpace::Normal) {
        return 0.0;
    }
    FindPoint(bound, location);
    // Interpolation may leave the range by rounding; boxes rely on it.
    return glm::clamp(bound.amount->At(_point), _displacement.range.low, _displacement.range.high);
}

/// Differences of the surface and of coordinates on the face.
CoordinateFrame SubdivPoints::FrameAt(const FaceLocation& location, std::size_t coordinates) {
    const DifferencePoints at = PointsAround(_model.Shape(location.face), location.at);
    const FaceSurface& surface = _surfaces.At(location.face);
    CoordinateFrame frame;
    const auto difference = [&](const FacePoint& high, const FacePoint& low, glm::dvec3* point,
                                glm::dvec2* st) {
        const std::array<double, 4> above = PrimvarAt(coordinates, {location.face, high});
        const std::array<double, 4> below = PrimvarAt(coordinates, {location.face, low});
        *point = surface.Frame(high).point - surface.Frame(low).point;
        *st = {above[0] - below[0], above[1] - below[1]};
    };
    difference(at.highU, at.lowU, &frame.pointU, &frame.coordinatesU);
    difference(at.highV, at.lowV, &frame.pointV, &frame.coordinatesV);
    return frame;
}

/// In object space; 0 where nothing displaces by vectors.
glm::dvec3 SubdivPoints::Vector(const FaceLocation& location) {
    const std::uint32_t face = _model.Cage().faces[location.face];
    const std::uint32_t entry = _entries.empty() ? 0 : _entries[face];
    if (!_displacement.hasVectors || entry >= _displacement.amounts.size()) {
        return glm::dvec3(0.0);
    }
    const BoundAmount& bound = _displacement.amounts[entry];
    if (bound.amount == nullptr || bound.amount->Space() == DisplacementSpace::Normal) {
        return glm::dvec3(0.0);
    }
    FindPoint(bound, location);
    const glm::dvec3 vector = LimitedVector(*bound.amount, _point, _displacement.range);
    if (bound.amount->Space() == DisplacementSpace::Object) {
        return vector;
    }
    const std::size_t coordinates = bound.attributes[bound.amount->Coordinates()];
    CoordinateFrame frame;
    if (coordinates != BoundAmount::kMissing) {
        frame = FrameAt(location, coordinates);
    }
    const FaceSurface& surface = _surfaces.At(location.face);
    frame.normal = surface.Normal(location.at, surface.Frame(location.at));
    return FromTangentSpace(frame, vector);
}

glm::dvec3 SubdivPoints::OwnPosition(const FaceLocation& location) {
    const FaceSurface& surface = _surfaces.At(location.face);
    const SurfaceFrame frame = surface.Frame(location.at);
    const glm::dvec3 position = frame.point + Amount(location) * surface.Normal(location.at, frame);
    return _displacement.hasVectors ? position + Vector(location) : position;
}

/// Of the displaced surface, by differences on the face: the amount may be any function, and
/// second derivatives of the surface do not exist at extraordinary vertices.
glm::dvec3 SubdivPoints::DisplacedNormal(const FaceLocation& location) {
    const DifferencePoints at = PointsAround(_model.Shape(location.face), location.at);
    SurfaceFrame frame;
    frame.tangentU = OwnPosition({location.face, at.highU}) - OwnPosition({location.face, at.lowU});
    frame.tangentV = OwnPosition({location.face, at.highV}) - OwnPosition({location.face, at.lowV});
    const double cross = glm::length(glm::cross(frame.tangentU, frame.tangentV));
    const FaceSurface& surface = _surfaces.At(location.face);
    return cross > 0.0 ? surface.Normal(location.at, frame)
                       : surface.Normal(location.at, surface.Frame(location.at));
}

glm::dvec3 SubdivPoints::Normal(const FaceLocation& location) {
    if (_displacement.IsActive() && !_displacement.IsConstant()) {
        return DisplacedNormal(location);
    }
    return RestNormal(location);
}

/// \param locations the same point on each drawn face that has it, the owner first.
SurfacePoint SubdivPoints::Shared(const std::vector<FaceLocation>& locations, bool isSharp) {
    const FaceLocation& owner = locations.front();
    const FaceSurface& surface = _surfaces.At(owner.face);
    const SurfaceFrame frame = surface.Frame(owner.at);
    glm::dvec3 direction = surface.Normal(owner.at, frame);
    SurfacePoint point{frame.point, direction, glm::dvec3(0.0), direction};
    if (!_displacement.IsActive()) {
        return point;
    }
    double amount = 0.0;
    glm::dvec3 vector(0.0);
    glm::dvec3 sum(0.0);
    for (const FaceLocation& location : locations) {
        amount += Amount(location);
        if (_displacement.hasVectors) {
            vector += Vector(location);
        }
        if (isSharp) {
            const FaceSurface& other = _surfaces.At(location.face);
            sum += other.Normal(location.at, other.Frame(location.at));
        }
    }
    const double length = glm::length(sum);
    direction = length > 1e-6 ? sum / length : direction;
    point.position += direction * (amount / double(locations.size()));
    if (_displacement.hasVectors) {
        point.position += vector / double(locations.size());
    }
    point.movedBy = point.position - frame.point;
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

glm::dvec3 SubdivPoints::RestNormal(const FaceLocation& location) {
    const FaceSurface& surface = _surfaces.At(location.face);
    return surface.Normal(location.at, surface.Frame(location.at));
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
