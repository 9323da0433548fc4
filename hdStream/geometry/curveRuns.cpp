// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/curveRuns.h"

#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/curveCounts.h"
#include "hdStream/geometry/normals.h"
#include "hdStream/geometry/solidContent.h"
#include "kernels/shared/geometry.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <string>
#include <utility>

namespace hds {
namespace {

constexpr float kDefaultWidth = 1.0F; // as Hydra has it
/// Lines of draw modes, whose widths mean pixels: a part of the diagonal of all points.
constexpr double kLineWidth = 1.0 / 256.0;

} // namespace

CurveRuns::CurveRuns(std::shared_ptr<const GeometryDescription> curves, PrimLog& log)
    : _curves(std::move(curves)) {
    if (_curves->points.size() % 3 != 0) {
        log.Warn(std::to_string(_curves->points.size() % 3) +
                 " floats after the last point ignored");
    }
    _size.numPoints = _curves->points.size() / 3;
    CurveCounts counts = ReadCurveCounts(*_curves, _size.numPoints, log);
    _begins = std::move(counts.begins);
    _counts = std::move(counts.counts);
    _faces = std::move(counts.faces);
    _size.numFaces = _curves->faceVertexCounts.size();

    const CurveBasis plain(*_curves->curves, false, false, log);
    ReadJoints(plain, log);
    ReadWidths(plain, log);
    if (auto normals = AuthoredNormals(*_curves, _size, log)) {
        _normals = std::move(*normals);
        _hasNormals = true;
    }
    Warnings unheard; // of the form: heard above
    PrimLog quiet(log.PrimPath(), unheard);
    _basis.emplace(*_curves->curves, _hasNormals, _widths.interpolation == Interpolation::Varying,
                   quiet);
}

/// Counts joints, which must be known before anything varying is looked at.
void CurveRuns::ReadJoints(const CurveBasis& basis, PrimLog& log) {
    std::size_t numShort = 0;
    std::size_t numUnused = 0;
    for (const std::uint32_t count : _counts) {
        std::uint32_t unused = 0;
        const std::uint32_t segments = basis.NumSegments(count, &unused);
        _firstJoints.push_back(static_cast<std::uint32_t>(_size.numJoints));
        _size.numJoints += segments > 0 ? basis.NumJoints(segments) : 0;
        numShort += segments == 0 && count > 0 ? 1 : 0;
        numUnused += segments > 0 ? unused : 0;
    }
    _size.hasJoints = true;
    _size.numCorners = _size.numJoints;
    if (numShort > 0) {
        log.Warn(std::to_string(numShort) + " curves dropped: too few vertices for " +
                 (_curves->curves->type == "linear" ? "linear" : _curves->curves->basis) +
                 " curves");
    }
    if (numUnused > 0) {
        log.Warn(std::to_string(numUnused) + " vertices after the last segment ignored");
    }
}

void CurveRuns::ReadWidths(const CurveBasis& basis, PrimLog& log) {
    const Bounds bounds = BoundPoints(*_curves);
    _origin = glm::dvec3(ChooseOrigin(bounds));
    float width = kDefaultWidth;
    if (basis.IsSegmented() && bounds.min.x <= bounds.max.x) {
        width = static_cast<float>(kLineWidth *
                                   glm::length(glm::dvec3(bounds.max) - glm::dvec3(bounds.min)));
    }
    _widths.values = std::vector<float>{width};
    if (auto widths = basis.IsSegmented() ? std::nullopt : AuthoredWidths(*_curves, _size, log)) {
        _widths = std::move(*widths);
        WarnBadWidths(_widths, log);
    }
    _widthsOfPoses = WidthsOfPoses(*_curves, _widths);
}

std::uint32_t CurveRuns::NumSegments(std::uint32_t curve) const {
    std::uint32_t unused = 0;
    return _basis->NumSegments(_counts[curve], &unused);
}

std::size_t CurveRuns::PointAt(std::uint32_t curve, std::uint32_t place) const {
    const std::uint64_t element = _begins[curve] + place;
    if (_curves->faceVertexIndices.empty()) {
        return element;
    }
    const std::int32_t index = _curves->faceVertexIndices[element];
    return index < 0 ? _size.numPoints : static_cast<std::size_t>(index);
}

glm::vec4 CurveRuns::VertexAt(std::uint32_t curve, std::uint32_t run, std::size_t pose) const {
    const RunVertex vertex = VertexOf(curve, run);
    const auto at = [&](std::uint32_t place) {
        const auto point = FindPointAt(*_curves, pose, PointAt(curve, place));
        return glm::vec4(point ? *point - glm::vec3(_origin) : glm::vec3(0.0F),
                         VertexRadius(_widthsOfPoses[pose], curve, run, place));
    };
    return vertex.isPhantom ? 2.0F * at(vertex.point) - at(vertex.next) : at(vertex.point);
}

float CurveRuns::VertexRadius(const GeometryAttribute& widths, std::uint32_t curve,
                              std::uint32_t run, std::uint32_t place) const {
    switch (widths.interpolation) {
    case Interpolation::Uniform:
        return RadiusOf(widths, curve);
    case Interpolation::Vertex:
        return PointAt(curve, place) < _size.numPoints ? RadiusOf(widths, PointAt(curve, place))
                                                       : 0.0F;
    case Interpolation::Varying:
        break;
    default:
        return RadiusOf(widths, 0);
    }
    const float radius = RadiusOf(widths, JointAt(curve, run));
    const bool isBezier = (_basis->Primitives() & HDS_PRIMITIVE_BASIS) == HDS_PRIMITIVE_BEZIER;
    if (!isBezier || run % 3 == 0) {
        return radius;
    }
    const float next = RadiusOf(widths, JointAt(curve, (run / 3 + 1) * 3));
    return radius + (next - radius) * (static_cast<float>(run % 3) / 3.0F);
}

std::vector<CurveRuns::Points> CurveRuns::ShapesOf(std::uint32_t curve,
                                                   std::uint32_t segment) const {
    std::vector<Points> shapes;
    for (std::size_t pose = 0; pose < NumPoses(); ++pose) {
        Points vertices;
        for (std::uint32_t k = 0; k < 4; ++k) {
            vertices[k] = glm::dvec4(VertexAt(curve, _basis->FirstVertex(segment) + k, pose));
        }
        shapes.push_back(_basis->Bezier(vertices));
    }
    return shapes;
}

glm::vec3 CurveRuns::JointNormal(std::uint32_t curve, std::uint32_t segment, int joint) const {
    glm::dvec3 sum(0.0);
    const auto add = [&](std::size_t element, double weight) {
        const float* normal = ValueOf(_normals, element);
        if (weight != 0.0 && IsUsableNormal(normal)) {
            const glm::dvec3 authored(normal[0], normal[1], normal[2]);
            sum += weight / glm::length(authored) * authored;
        }
    };
    const std::uint32_t first = _basis->FirstVertex(segment);
    switch (_normals.interpolation) {
    case Interpolation::Uniform:
        add(FaceOf(curve), 1.0);
        break;
    case Interpolation::Vertex: {
        const std::array<double, 4> weights = _basis->JointWeights(joint);
        for (std::uint32_t k = 0; k < 4; ++k) {
            const RunVertex vertex = VertexOf(curve, first + k);
            const std::size_t point = PointAt(curve, vertex.point);
            if (point < _size.numPoints) {
                add(point, weights[k]);
            }
        }
        break;
    }
    case Interpolation::Varying:
    case Interpolation::FaceVarying:
        add(JointAt(curve, first + static_cast<std::uint32_t>(_basis->Joints()[joint])), 1.0);
        break;
    default:
        add(0, 1.0);
        break;
    }
    const double length = glm::length(sum);
    return length > 1e-6 ? glm::vec3(sum / length) : glm::vec3(0.0F, 0.0F, 1.0F);
}

void CurveRuns::AddPhantoms(GeometryAttribute* attribute) const {
    const std::uint32_t width = attribute->numComponents;
    std::vector<float> values;
    for (std::uint32_t curve = 0; curve < _counts.size(); ++curve) {
        const std::uint32_t numVertices = _counts[curve];
        values.resize(RunBegin(curve) * width);
        for (std::uint32_t run = 0; run < numVertices + 2 && numVertices > 1; ++run) {
            const RunVertex vertex = _basis->VertexOf(run, numVertices);
            const auto at = [&](std::uint32_t place) {
                return ValueOf(*attribute, std::min(PointAt(curve, place), _size.numPoints - 1));
            };
            for (std::uint32_t c = 0; c < width; ++c) {
                const float value = at(vertex.point)[c];
                values.push_back(vertex.isPhantom ? 2.0F * value - at(vertex.next)[c] : value);
            }
        }
    }
    attribute->values = std::move(values);
    attribute->indices = {};
}

std::uint64_t CurveRuns::TableBytes() const {
    return sizeof(*this) + VectorBytes(_begins, _counts, _faces, _firstJoints);
}

} // namespace hds
