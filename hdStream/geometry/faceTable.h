// SPDX-License-Identifier: Apache-2.0
// Cuts a mesh's faces into triangles: blocks of faces in parallel, results in order of faces.
// Internal to geometry. Explained in docs/geometry.md.
#pragma once

#include "hdStream/geometry/triangleMesh.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// Largest coordinate that is used: its square, and a product of two squares' sums, fit a float.
constexpr float kMaxCoordinate = 1e18F;

/// True for a point whose coordinates are finite and not beyond kMaxCoordinate.
bool IsUsablePoint(const float* point);

/// Whether a face can be used; the first reason that applies.
enum class FaceUse { Usable, TooFewVertices, EndsEarly, IndexOutOfRange, PointNotFinite };

/// Checks the face whose indices start at `firstCorner`.
FaceUse CheckFace(const GeometryDescription& mesh, std::uint64_t firstCorner, std::uint32_t count);

/// Faces that were left out, by reason.
struct FaceProblems {
    std::uint64_t tooFewVertices = 0;  ///< faceVertexCounts below 3
    std::uint64_t endsEarly = 0;       ///< faceVertexIndices has no entries left for it
    std::uint64_t indexOutOfRange = 0; ///< a point index is negative or >= numPoints
    std::uint64_t pointNotFinite = 0;  ///< a point is not usable
    std::uint64_t zeroArea = 0;        ///< no triangle of it has an area
    void Count(FaceUse use);
    void Add(const FaceProblems& other);
    /// One line per reason that occurred: "3 faces dropped: point index out of range".
    void Warn(const std::string& primPath, Warnings& warnings) const;
};

/// Where blocks of kFacesPerBlock faces start.
struct FaceTable {
    static constexpr std::size_t kFacesPerBlock = 4096;
    std::size_t numFaces = 0;
    std::uint64_t numCorners = 0;             ///< sum of faceVertexCounts (negative ones are 0)
    std::vector<std::uint64_t> cornerBegin;   ///< [numBlocks + 1]
    std::vector<std::uint64_t> triangleBegin; ///< [numBlocks + 1] upper bound
    std::size_t NumBlocks() const { return cornerBegin.size() - 1; }
};

/// Counts corners and triangles. Cost: O(faces), parallel.
FaceTable BuildFaceTable(const GeometryDescription& mesh);

/// Fills triangles, faces, corners and (authored, not recentred) bounds of `result`.
/// \param isHole one byte a face, or empty.
/// Precondition: table.triangleBegin.back() and table.numCorners fit 32 bits.
FaceProblems SplitFaces(const GeometryDescription& mesh, const FaceTable& table,
                        const std::vector<std::uint8_t>& isHole, TriangleMesh& result);

} // namespace hds
