// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/carriedNormals.h"

#include "hdStream/geometry/awayArrays.h"
#include "hdStream/geometry/normals.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace hds {

namespace {

/// A corner of a face: the index of its point, and those of its neighbours along the face's edge.
struct Corner {
    std::size_t point, next, previous;
    std::size_t origin; ///< the face's first point
    std::size_t face;
};

glm::dvec3 At(const SharedSpan<float>& rows, std::size_t row) {
    return {rows[3 * row], rows[3 * row + 1], rows[3 * row + 2]};
}

glm::dvec3 Unit(const glm::dvec3& vector) {
    const double length = glm::length(vector);
    return length > 0.0 && std::isfinite(length) ? vector / length : glm::dvec3(0.0);
}

/// All corners in order of faceVertexIndices; empty when a face has points that are not there.
std::vector<Corner> CornersOf(const GeometryDescription& mesh, std::size_t numPoints) {
    std::vector<Corner> corners;
    corners.reserve(mesh.faceVertexIndices.size());
    for (std::size_t face = 0; face < mesh.faceVertexCounts.size(); ++face) {
        const std::size_t first = corners.size();
        if (mesh.faceVertexCounts[face] < 0) {
            return {};
        }
        const auto count = static_cast<std::size_t>(mesh.faceVertexCounts[face]);
        if (count > mesh.faceVertexIndices.size() - first) {
            return {};
        }
        const std::int32_t* indices = mesh.faceVertexIndices.data() + first;
        for (std::size_t i = 0; i < count; ++i) {
            if (indices[i] < 0 || static_cast<std::size_t>(indices[i]) >= numPoints) {
                return {};
            }
            corners.push_back({static_cast<std::size_t>(indices[i]),
                               static_cast<std::size_t>(indices[(i + 1) % count]),
                               static_cast<std::size_t>(indices[(i + count - 1) % count]),
                               static_cast<std::size_t>(indices[0]), face});
        }
    }
    return corners;
}

/// The geometric normals of one pose.
struct Pose {
    const SharedSpan<float>& points;
    std::vector<glm::dvec3> ofFaces, ofPoints;

    Pose(const SharedSpan<float>& positions, const std::vector<Corner>& corners,
         std::size_t numFaces)
        : points(positions), ofFaces(numFaces, glm::dvec3(0.0)),
          ofPoints(positions.size() / 3, glm::dvec3(0.0)) {
        for (const Corner& corner : corners) { // twice the area of a polygon, plane or not
            const glm::dvec3 origin = At(points, corner.origin);
            ofFaces[corner.face] +=
                glm::cross(At(points, corner.point) - origin, At(points, corner.next) - origin);
        }
        for (glm::dvec3& normal : ofFaces) {
            normal = Unit(normal);
        }
        for (const Corner& corner : corners) {
            const glm::dvec3 a = Side(corner, corner.next);
            const glm::dvec3 b = Side(corner, corner.previous);
            const double lengths = glm::dot(a, a) * glm::dot(b, b);
            if (lengths > 0.0 && std::isfinite(lengths)) {
                const glm::dvec3 normal = glm::cross(a, b) / lengths;
                const bool isReflex = glm::dot(normal, ofFaces[corner.face]) < 0.0;
                ofPoints[corner.point] += isReflex ? -normal : normal;
            }
        }
        for (glm::dvec3& normal : ofPoints) {
            normal = Unit(normal);
        }
    }

    glm::dvec3 Side(const Corner& corner, std::size_t end) const {
        return At(points, end) - At(points, corner.point);
    }
};

/// A normal and the sides of a corner in the plane of it.
struct Frame {
    glm::dvec3 normal, a, b;
    double area;

    Frame(const Pose& pose, const Corner& corner, bool isOfFace)
        : normal(isOfFace ? pose.ofFaces[corner.face] : pose.ofPoints[corner.point]) {
        a = InPlane(pose.Side(corner, corner.next));
        b = InPlane(pose.Side(corner, corner.previous));
        area = glm::dot(normal, glm::cross(a, b));
    }

    glm::dvec3 InPlane(const glm::dvec3& side) const {
        return side - normal * glm::dot(normal, side);
    }
};

glm::dvec3 Carried(const glm::dvec3& normal, const Corner& corner, const Pose& rest,
                   const Pose& posed) {
    const bool isOfFace = std::abs(glm::dot(normal, rest.ofFaces[corner.face])) >
                          std::abs(glm::dot(normal, rest.ofPoints[corner.point]));
    const Frame before(rest, corner, isOfFace);
    const Frame after(posed, corner, isOfFace);
    const double ratio = std::abs(after.area / before.area);
    if (!(ratio > 0.0) || !std::isfinite(ratio)) {
        return Unit(normal + after.normal - before.normal); // the corner's sides are parallel
    }
    const glm::dvec3 alongA = glm::cross(after.b, after.normal) / after.area;
    const glm::dvec3 alongB = glm::cross(after.normal, after.a) / after.area;
    return Unit(glm::dot(normal, before.a) * alongA + glm::dot(normal, before.b) * alongB +
                glm::dot(normal, before.normal) / std::sqrt(ratio) * after.normal);
}

/// Which value a corner has.
std::size_t ElementOf(Interpolation interpolation, const std::vector<Corner>& corners,
                      std::size_t i) {
    switch (interpolation) {
    case Interpolation::Constant:
        return 0;
    case Interpolation::Uniform:
        return corners[i].face;
    case Interpolation::Vertex:
    case Interpolation::Varying:
        return corners[i].point;
    default:
        return i;
    }
}

/// The row of values of an element; none when there is none.
std::optional<std::size_t> RowOf(const Primvar& normals, std::size_t element) {
    if (!normals.indices.empty()) {
        if (element >= normals.indices.size() || normals.indices[element] < 0) {
            return std::nullopt;
        }
        element = static_cast<std::size_t>(normals.indices[element]);
    }
    return 3 * element + 2 < normals.values.size() ? std::optional<std::size_t>(element)
                                                   : std::nullopt;
}

void Put(const glm::dvec3& normal, float* row) {
    for (int i = 0; i < 3; ++i) {
        row[i] = static_cast<float>(normal[i]);
    }
}

} // namespace

std::optional<Primvar> CarryNormals(const Primvar& authored, const GeometryDescription& geometry,
                                    const SharedSpan<float>& atRest,
                                    const SharedSpan<float>& posed) {
    const Primvar normals = Held(authored);
    const auto held = Held(std::make_shared<const GeometryDescription>(geometry));
    const GeometryDescription& mesh = *held;
    const std::size_t numPoints = atRest.size() / 3;
    const std::vector<Corner> corners = CornersOf(mesh, numPoints);
    if (normals.numComponents != 3 || posed.size() != atRest.size() || corners.empty()) {
        return std::nullopt;
    }
    const bool isOfPoints = normals.interpolation == Interpolation::Vertex ||
                            normals.interpolation == Interpolation::Varying;
    const Pose rest(atRest, corners, mesh.faceVertexCounts.size());
    const Pose now(posed, corners, mesh.faceVertexCounts.size());
    std::vector<glm::dvec3> sums(isOfPoints ? numPoints : corners.size(), glm::dvec3(0.0));
    std::vector<float> values(3 * sums.size(), 0.0f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const auto row = RowOf(normals, ElementOf(normals.interpolation, corners, i));
        if (!row) {
            return std::nullopt;
        }
        const std::size_t element = isOfPoints ? corners[i].point : i;
        Put(At(normals.values, *row), &values[3 * element]);
        if (IsUsableNormal(&normals.values[3 * *row])) {
            sums[element] += Carried(Unit(At(normals.values, *row)), corners[i], rest, now);
        }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
        if (const glm::dvec3 normal = Unit(sums[i]); normal != glm::dvec3(0.0)) {
            Put(normal, &values[3 * i]);
        }
    }
    return Primvar{normals.name,
                   isOfPoints ? Interpolation::Vertex : Interpolation::FaceVarying,
                   3,
                   std::move(values),
                   {}};
}

} // namespace hds
