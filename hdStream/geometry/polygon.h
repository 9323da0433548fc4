// SPDX-License-Identifier: Apache-2.0
// Splits one face into triangles: triangles and quads by direct rules, larger faces as a fan where
// that is valid and else by ear clipping in the plane of the face.
// The result depends on the face's points only. Explained in docs/geometry.md.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hds {

/// True when the triangle has no area: its normal is zero once rounded to float.
/// Points come from floats, so that the differences and nearly all products are exact in double.
inline bool IsDegenerate(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 u = b - a;
    const glm::dvec3 v = c - a;
    const auto isZero = [](double component) { return static_cast<float>(component) == 0.0F; };
    // Of nearly all triangles the first component is enough to tell.
    return isZero(u.y * v.z - v.y * u.z) && isZero(u.z * v.x - v.z * u.x) &&
           isZero(u.x * v.y - v.x * u.y);
}

/// Splits faces; keeps scratch memory between calls. One object per thread.
class PolygonSplitter {
public:
    /// Splits the face `points[0..count)` and writes at most count - 2 triangles of local vertex
    /// numbers, wound as the face is, to `out`. Triangles without area are left out.
    /// Precondition: count >= 3, points finite with magnitudes below 1e18.
    /// Cost: O(count) for convex faces, typically O(count) and at worst O(count^2) for concave
    /// ones. \return number of triangles written.
    std::uint32_t Split(const glm::dvec3* points, std::uint32_t count, glm::uvec3* out);

private:
    /// What an ear must fulfil; the looser rules serve faces that intersect themselves or collapse.
    enum class EarRule { Clean, Convex, Any };

    std::uint32_t SplitQuad(glm::uvec3* out) const;
    std::uint32_t SplitLarge(glm::uvec3* out);
    std::uint32_t EmitFan(glm::uvec3* out) const;
    std::uint32_t ClipEars(glm::uvec3* out);
    bool Emit(std::uint32_t a, std::uint32_t b, std::uint32_t c, glm::uvec3* out) const;
    void Project(const glm::dvec3& normal);
    void BuildGrid();
    bool IsEar(std::uint32_t vertex, EarRule rule) const;
    bool IsBlocked(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
    bool IsBlocker(std::uint32_t vertex, std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
    double Turn(std::uint32_t vertex) const;

    const glm::dvec3* _points = nullptr;
    std::uint32_t _count = 0;
    std::vector<glm::dvec2> _flat;    ///< points in the plane, counter-clockwise
    std::vector<std::uint32_t> _next; ///< ring of the vertices that are left
    std::vector<std::uint32_t> _prev; ///< `vertex` itself once it is clipped
    /// Uniform grid over the vertices that are not strictly convex at the start. Clipping only
    /// makes interior angles smaller, so that no other vertex can enter an ear later.
    std::vector<std::uint32_t> _cellBegin;
    std::vector<std::uint32_t> _cellVertices;
    glm::dvec2 _gridMin{0.0};
    glm::dvec2 _cellsPerUnit{0.0};
    int _gridSize = 0; ///< cells per side
};

} // namespace hds
