// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/normals.h"

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace hds {
namespace {

using Range = tbb::blocked_range<std::size_t>;
constexpr std::size_t kGrain = 8192;

/// The triangles around each point: those of point i are items[begin[i] .. begin[i + 1]),
/// ascending.
struct PointTriangles {
    std::vector<std::uint32_t> begin;
    std::vector<std::uint32_t> items;
};

PointTriangles FindPointTriangles(const TriangleMesh& mesh) {
    const std::size_t numPoints = mesh.positions.size();
    // Counts and then cursors. The order inside a list depends on threads until it is sorted.
    const auto cursor = std::make_unique<std::atomic<std::uint32_t>[]>(numPoints);
    tbb::parallel_for(Range(0, numPoints, kGrain), [&](const Range& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            cursor[i].store(0, std::memory_order_relaxed);
        }
    });
    const auto forEachCorner = [&](auto visit) {
        tbb::parallel_for(Range(0, mesh.triangles.size(), kGrain), [&](const Range& range) {
            for (std::size_t t = range.begin(); t < range.end(); ++t) {
                for (int k = 0; k < 3; ++k) {
                    visit(mesh.triangles[t][k], static_cast<std::uint32_t>(t));
                }
            }
        });
    };
    forEachCorner([&](std::uint32_t point, std::uint32_t) {
        cursor[point].fetch_add(1, std::memory_order_relaxed);
    });
    PointTriangles result;
    result.begin.resize(numPoints + 1);
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < numPoints; ++i) {
        result.begin[i] = sum;
        sum += cursor[i].exchange(sum, std::memory_order_relaxed);
    }
    result.begin[numPoints] = sum;
    result.items.resize(sum);
    forEachCorner([&](std::uint32_t point, std::uint32_t triangle) {
        result.items[cursor[point].fetch_add(1, std::memory_order_relaxed)] = triangle;
    });
    tbb::parallel_for(Range(0, numPoints, kGrain), [&](const Range& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            std::sort(result.items.begin() + result.begin[i],
                      result.items.begin() + result.begin[i + 1]);
        }
    });
    return result;
}

/// Max's weighted normal of a triangle at the corner that is `point`; towards cross(p1-p0, p2-p0).
glm::dvec3 CornerNormal(const TriangleMesh& mesh, const glm::uvec3& triangle, std::uint32_t point) {
    const int k = triangle.x == point ? 0 : (triangle.y == point ? 1 : 2);
    const glm::dvec3 origin(mesh.positions[point]);
    const glm::dvec3 next = glm::dvec3(mesh.positions[triangle[(k + 1) % 3]]) - origin;
    const glm::dvec3 prev = glm::dvec3(mesh.positions[triangle[(k + 2) % 3]]) - origin;
    return glm::cross(next, prev) / (glm::dot(next, next) * glm::dot(prev, prev));
}

/// Sum over a point's triangles, as a unit vector towards the authored front.
glm::dvec3 SmoothNormal(const TriangleMesh& mesh, const std::uint32_t* triangles, std::size_t count,
                        std::uint32_t point) {
    glm::dvec3 sum(0.0);
    double sumLengths = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 normal = CornerNormal(mesh, mesh.triangles[triangles[i]], point);
        sum += normal;
        sumLengths += glm::length(normal);
    }
    const double length = glm::length(sum);
    // Below rounding of the sum the triangles cancel, as on both sides of a folded sheet.
    if (!(length > 1e-12 * sumLengths)) {
        return FaceNormal(mesh, triangles[0]);
    }
    return sum / (mesh.leftHanded ? -length : length);
}

/// Calls visit(element, triangle) for the elements of an interpolation that a triangle uses.
template <typename Visit>
void ForEachElement(const TriangleMesh& mesh, Interpolation interpolation, std::size_t triangle,
                    Visit visit) {
    if (interpolation == Interpolation::Uniform) {
        visit(std::size_t(mesh.faces[triangle]));
        return;
    }
    const bool isCorner = interpolation == Interpolation::FaceVarying;
    const glm::uvec3 elements = isCorner ? mesh.corners[triangle] : mesh.triangles[triangle];
    for (int k = 0; k < 3; ++k) {
        visit(std::size_t(elements[k]));
    }
}

bool HasUnusableNormal(const TriangleMesh& mesh, const GeometryAttribute& normals) {
    return tbb::parallel_reduce(
        Range(0, mesh.triangles.size(), kGrain), false,
        [&](const Range& range, bool found) {
            for (std::size_t t = range.begin(); !found && t < range.end(); ++t) {
                ForEachElement(mesh, normals.interpolation, t, [&](std::size_t element) {
                    found = found || !IsUsableNormal(ValueOf(normals, element));
                });
            }
            return found;
        },
        std::logical_or<>());
}

} // namespace

bool IsUsableNormal(const float* normal) {
    return std::isfinite(normal[0]) && std::isfinite(normal[1]) && std::isfinite(normal[2]) &&
           (normal[0] != 0.0F || normal[1] != 0.0F || normal[2] != 0.0F);
}

bool HasUnusableNormals(const GeometryAttribute& normals) {
    return tbb::parallel_reduce(
        Range(0, normals.values.size() / 3, kGrain), false,
        [&](const Range& range, bool found) {
            for (std::size_t i = range.begin(); i < range.end() && !found; ++i) {
                found = !IsUsableNormal(normals.values.data() + 3 * i);
            }
            return found;
        },
        std::logical_or<>());
}

glm::dvec3 FaceNormal(const TriangleMesh& mesh, std::size_t triangle) {
    const glm::uvec3 t = mesh.triangles[triangle];
    const glm::dvec3 p0(mesh.positions[t.x]);
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(mesh.positions[t.y]) - p0, glm::dvec3(mesh.positions[t.z]) - p0);
    const double length = glm::length(normal);
    return normal / (mesh.leftHanded ? -length : length);
}

GeometryAttribute ComputeSmoothNormals(const TriangleMesh& mesh) {
    const PointTriangles around = FindPointTriangles(mesh);
    std::vector<float> values(mesh.positions.size() * 3);
    tbb::parallel_for(Range(0, mesh.positions.size(), kGrain), [&](const Range& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const std::size_t count = around.begin[i + 1] - around.begin[i];
            if (count > 0) {
                const glm::vec3 normal(SmoothNormal(mesh, around.items.data() + around.begin[i],
                                                    count, static_cast<std::uint32_t>(i)));
                std::copy(&normal.x, &normal.x + 3, values.begin() + i * 3);
            }
        }
    });
    GeometryAttribute normals;
    normals.name = "normals";
    normals.interpolation = Interpolation::Vertex;
    normals.numComponents = 3;
    normals.values = std::move(values);
    return normals;
}

std::size_t RepairNormals(const TriangleMesh& mesh, const TopologySize& size,
                          GeometryAttribute& normals) {
    if (!HasUnusableNormal(mesh, normals)) {
        return 0;
    }
    const std::size_t numElements = NumElements(normals.interpolation, size);
    std::vector<float> values(numElements * 3);
    for (std::size_t element = 0; element < numElements; ++element) {
        const float* value = ValueOf(normals, element);
        std::copy(value, value + 3, values.begin() + element * 3);
    }
    std::size_t numReplaced = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        ForEachElement(mesh, normals.interpolation, t, [&](std::size_t element) {
            float* value = values.data() + element * 3;
            if (!IsUsableNormal(value)) {
                const glm::vec3 normal(FaceNormal(mesh, t));
                std::copy(&normal.x, &normal.x + 3, value);
                ++numReplaced;
            }
        });
    }
    normals.values = std::move(values);
    normals.indices = {};
    return numReplaced;
}

} // namespace hds
