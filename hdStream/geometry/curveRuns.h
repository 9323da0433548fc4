// SPDX-License-Identifier: Apache-2.0
// Authored curves as runs of vertices with radii, normals and joints, in all poses. Internal to
// geometry. Explained in docs/curves.md.
#pragma once

#include "hdStream/geometry/curveSegments.h"
#include "hdStream/geometry/geometryDescription.h"
#include "hdStream/geometry/primvars.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace hds {

/// Threads: const methods may run beside each other.
class CurveRuns {
public:
    /// The Bezier points of a segment, with radii.
    using Points = std::array<glm::dvec4, 4>;

    /// Reads counts, the basis, and which widths and normals take part in. Bad content warns, and
    /// curves that ask for too much have no vertices. \pre curves->primitives is Curves.
    CurveRuns(std::shared_ptr<const GeometryDescription> curves, PrimLog& log);

    const GeometryDescription& Curves() const { return *_curves; }
    const CurveBasis& Basis() const { return *_basis; }
    const TopologySize& Size() const { return _size; }
    /// What vertices are relative to, in object space.
    const glm::dvec3& Origin() const { return _origin; }
    bool HasNormals() const { return _hasNormals; }
    /// When the shutter opens, and the keys of curves that move.
    std::size_t NumPoses() const { return 1 + _curves->keys.size(); }
    std::uint32_t NumCurves() const { return static_cast<std::uint32_t>(_counts.size()); }
    std::uint32_t NumSegments(std::uint32_t curve) const;
    /// The authored curve, which uniform values belong to.
    std::uint32_t FaceOf(std::uint32_t curve) const {
        return _faces.empty() ? curve : _faces[curve];
    }

    RunVertex VertexOf(std::uint32_t curve, std::uint32_t run) const {
        return _basis->VertexOf(run, _counts[curve]);
    }
    /// Index of a point, or one beyond all.
    std::size_t PointAt(std::uint32_t curve, std::uint32_t place) const;
    /// Index of the varying value that a vertex of the run has.
    std::uint32_t JointAt(std::uint32_t curve, std::uint32_t run) const {
        return _firstJoints[curve] + _basis->JointOf(run, NumSegments(curve));
    }
    /// Where the vertices of a pinned curve begin among those of all: each has two phantoms.
    std::uint64_t RunBegin(std::uint32_t curve) const {
        return _begins[curve] + 2 * std::uint64_t{curve};
    }

    /// A vertex of a run relative to the origin, with its radius, as its page holds it. \param
    /// pose 0: when the shutter opens; else of a key.
    glm::vec4 VertexAt(std::uint32_t curve, std::uint32_t run, std::size_t pose) const;
    /// [NumPoses()]
    std::vector<Points> ShapesOf(std::uint32_t curve, std::uint32_t segment) const;
    /// Unit length; some direction where nothing usable is authored.
    glm::vec3 JointNormal(std::uint32_t curve, std::uint32_t segment, int joint) const;

    /// Gives values of points those of the vertices of all pinned curves. \pre Basis().HasPhantoms.
    void AddPhantoms(GeometryAttribute* attribute) const;

    /// About the host memory of its own tables.
    std::uint64_t TableBytes() const;

private:
    void ReadJoints(const CurveBasis& basis, PrimLog& log);
    void ReadWidths(const CurveBasis& basis, PrimLog& log);
    float VertexRadius(const GeometryAttribute& widths, std::uint32_t curve, std::uint32_t run,
                       std::uint32_t place) const;

    std::shared_ptr<const GeometryDescription> _curves;
    TopologySize _size;
    glm::dvec3 _origin{0.0};
    std::vector<std::uint64_t> _begins;      ///< [numCurves] first vertex
    std::vector<std::uint32_t> _counts;      ///< [numCurves] vertices
    std::vector<std::uint32_t> _faces;       ///< [numCurves] authored curve; empty: the same
    std::vector<std::uint32_t> _firstJoints; ///< [numCurves]
    std::optional<CurveBasis> _basis;
    GeometryAttribute _widths;
    std::vector<GeometryAttribute> _widthsOfPoses;
    GeometryAttribute _normals;
    bool _hasNormals = false;
};

} // namespace hds
