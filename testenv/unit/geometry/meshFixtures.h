// SPDX-License-Identifier: Apache-2.0
// Meshes and a reference reader for the tests of geometry. The reader follows the text of UsdGeom's
// primvar interpolation and shares no code with the core.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace hds::test {

inline std::vector<float> Flatten(const std::vector<glm::vec3>& points) {
    std::vector<float> values;
    for (const glm::vec3& p : points) {
        values.insert(values.end(), {p.x, p.y, p.z});
    }
    return values;
}

inline GeometryDescription MakeMesh(const std::vector<glm::vec3>& points,
                                    std::vector<std::int32_t> counts,
                                    std::vector<std::int32_t> indices) {
    GeometryDescription mesh;
    mesh.points = Flatten(points);
    mesh.faceVertexCounts = std::move(counts);
    mesh.faceVertexIndices = std::move(indices);
    return mesh;
}

/// One face over all points.
inline GeometryDescription MakePolygon(const std::vector<glm::vec3>& points) {
    std::vector<std::int32_t> indices;
    for (std::size_t i = 0; i < points.size(); ++i) {
        indices.push_back(static_cast<std::int32_t>(i));
    }
    return MakeMesh(points, {static_cast<std::int32_t>(points.size())}, indices);
}

/// n x n quads over the unit square in z = 0, facing +z, with a height function.
template <typename Height>
GeometryDescription MakeGrid(int n, Height height) {
    std::vector<glm::vec3> points;
    std::vector<std::int32_t> indices;
    for (int y = 0; y <= n; ++y) {
        for (int x = 0; x <= n; ++x) {
            const float s = float(x) / float(n);
            const float t = float(y) / float(n);
            points.emplace_back(s, t, height(s, t));
        }
    }
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const int i = y * (n + 1) + x;
            indices.insert(indices.end(), {i, i + 1, i + n + 2, i + n + 1});
        }
    }
    return MakeMesh(points, std::vector<std::int32_t>(std::size_t(n) * n, 4), indices);
}

inline GeometryDescription MakeFlatGrid(int n) {
    return MakeGrid(n, [](float, float) { return 0.0F; });
}

/// The lines of all warnings of one Triangulate call.
struct Triangulated {
    std::shared_ptr<const TriangleMesh> mesh;
    std::vector<std::string> warnings;
};

inline Triangulated RunTriangulate(const GeometryDescription& mesh) {
    Warnings warnings;
    auto result = Triangulate(mesh, "/World/mesh", warnings);
    return {std::move(result), warnings.Lines()};
}

/// Area vector of a triangle in double, in authored space relative to the origin.
inline glm::dvec3 AreaVector(const TriangleMesh& mesh, std::size_t triangle) {
    const glm::uvec3 t = mesh.triangles[triangle];
    const glm::dvec3 p0(mesh.positions[t.x]);
    return 0.5 *
           glm::cross(glm::dvec3(mesh.positions[t.y]) - p0, glm::dvec3(mesh.positions[t.z]) - p0);
}

inline double TotalArea(const TriangleMesh& mesh) {
    double sum = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        sum += glm::length(AreaVector(mesh, t));
    }
    return sum;
}

/// Component `c` of a primvar at one face-vertex of a face, as UsdGeomPrimvar documents it:
/// constant has one value, uniform one per face, varying and vertex one per point, faceVarying one
/// per face-vertex; indices, when authored, lead to the values.
inline double AuthoredValue(const GeometryDescription& mesh, const Primvar& primvar,
                            std::size_t face, std::size_t corner, std::uint32_t c) {
    std::size_t element = 0;
    switch (primvar.interpolation) {
    case Interpolation::Uniform:
        element = face;
        break;
    case Interpolation::Varying:
    case Interpolation::Vertex:
        element = static_cast<std::size_t>(mesh.faceVertexIndices[corner]);
        break;
    case Interpolation::FaceVarying:
        element = corner;
        break;
    case Interpolation::Constant:
    case Interpolation::Instance:
        break;
    }
    if (!primvar.indices.empty()) {
        element = static_cast<std::size_t>(primvar.indices[element]);
    }
    return primvar.values[element * primvar.numComponents + c];
}

/// The face-vertex of an authored face that lies at a position. Faces of the fixtures have no two
/// vertices at one place. Returns the number of face-vertices when there is none.
inline std::size_t FindCorner(const GeometryDescription& mesh, std::size_t face,
                              glm::vec3 position) {
    std::size_t corner = 0;
    for (std::size_t f = 0; f < face; ++f) {
        corner += static_cast<std::size_t>(mesh.faceVertexCounts[f]);
    }
    for (std::int32_t i = 0; i < mesh.faceVertexCounts[face]; ++i, ++corner) {
        const float* p = mesh.points.data() + std::size_t(mesh.faceVertexIndices[corner]) * 3;
        if (p[0] == position.x && p[1] == position.y && p[2] == position.z) {
            return corner;
        }
    }
    return mesh.faceVertexIndices.size();
}

/// A primvar of random values of the right length; indexed ones share a few values.
inline Primvar MakePrimvar(const GeometryDescription& mesh, const std::string& name,
                           Interpolation interpolation, std::uint32_t numComponents, bool isIndexed,
                           std::mt19937& random) {
    std::size_t count = 1;
    switch (interpolation) {
    case Interpolation::Uniform:
        count = mesh.faceVertexCounts.size();
        break;
    case Interpolation::Varying:
    case Interpolation::Vertex:
        count = mesh.points.size() / 3;
        break;
    case Interpolation::FaceVarying:
        count = mesh.faceVertexIndices.size();
        break;
    case Interpolation::Constant:
    case Interpolation::Instance:
        break;
    }
    const std::size_t numValues = isIndexed ? count / 2 + 3 : count;
    std::uniform_real_distribution<float> value(-2.0F, 5.0F);
    std::vector<float> values(numValues * numComponents);
    for (float& v : values) {
        v = value(random);
    }
    Primvar primvar;
    primvar.name = name;
    primvar.interpolation = interpolation;
    primvar.numComponents = numComponents;
    primvar.values = std::move(values);
    if (isIndexed) {
        std::vector<std::int32_t> indices(count);
        for (std::int32_t& index : indices) {
            index = static_cast<std::int32_t>(random() % numValues);
        }
        primvar.indices = std::move(indices);
    }
    return primvar;
}

/// Quads, a triangle and a concave pentagon in one mesh.
inline GeometryDescription MakeMixedMesh() {
    return MakeMesh({{0, 0, 0},
                     {1, 0, 0.1F},
                     {2, 0, 0},
                     {0, 1, 0.2F},
                     {1, 1, 0},
                     {2, 1, 0.1F},
                     {0, 2, 0},
                     {1, 1.5F, 0},
                     {2, 2, 0}},
                    {4, 4, 3, 5, 3}, {0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 3, 7, 5, 8, 6, 4, 5, 7});
}

/// Every interpolation, with and without indices, of 1 to 4 components: primvars "p00", "p01", ...
inline void AddAllPrimvars(GeometryDescription& mesh, std::mt19937& random) {
    const Interpolation kinds[] = {Interpolation::Constant, Interpolation::Uniform,
                                   Interpolation::Varying, Interpolation::Vertex,
                                   Interpolation::FaceVarying};
    int number = 0;
    for (const Interpolation kind : kinds) {
        for (std::uint32_t numComponents = 1; numComponents <= 4; ++numComponents) {
            for (const bool isIndexed : {false, true}) {
                const std::string name =
                    std::string("p") + char('0' + number / 10) + char('0' + number % 10);
                // A constant has one value, so its index list has one entry.
                mesh.primvars.push_back(
                    MakePrimvar(mesh, name, kind, numComponents, isIndexed, random));
                ++number;
            }
        }
    }
}

} // namespace hds::test
