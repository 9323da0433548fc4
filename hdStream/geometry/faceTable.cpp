// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/faceTable.h"

#include "hdStream/geometry/polygon.h"

#include <glm/common.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace hds {
namespace {

/// What one block of faces gives.
struct BlockResult {
    std::uint64_t numTriangles = 0;
    FaceProblems problems;
    Bounds bounds;
};

/// A face's vertices.
struct Face {
    std::size_t index;
    std::uint64_t firstCorner;
    std::uint32_t count;
};

/// Splits the faces of one block; scratch memory is kept from face to face.
class BlockSplitter {
public:
    BlockSplitter(const GeometryDescription& mesh, TriangleMesh& result,
                  std::uint64_t firstTriangle)
        : _mesh(mesh), _result(result), _firstTriangle(firstTriangle) {}

    void Add(const Face& face) {
        const FaceUse use = CheckFace(_mesh, face.firstCorner, face.count);
        _block.problems.Count(use);
        if (use == FaceUse::Usable) {
            Load(face);
            _local.resize(face.count - 2);
            const std::uint32_t count = _splitter.Split(_points.data(), face.count, _local.data());
            Store(face, count);
            _block.problems.zeroArea += count == 0 ? 1 : 0;
        }
    }

    const BlockResult& Result() const { return _block; }

private:
    void Load(const Face& face) {
        _points.resize(face.count);
        const std::int32_t* indices = _mesh.faceVertexIndices.data() + face.firstCorner;
        for (std::uint32_t i = 0; i < face.count; ++i) {
            const float* p = _mesh.points.data() + std::size_t(indices[i]) * 3;
            _points[i] = glm::dvec3(p[0], p[1], p[2]);
        }
    }

    void Store(const Face& face, std::uint32_t count) {
        const std::int32_t* indices = _mesh.faceVertexIndices.data() + face.firstCorner;
        const auto firstCorner = static_cast<std::uint32_t>(face.firstCorner);
        for (std::uint32_t i = 0; i < count; ++i) {
            const glm::uvec3 local = _local[i];
            const std::uint64_t t = _firstTriangle + _block.numTriangles++;
            _result.triangles[t] = glm::uvec3(indices[local.x], indices[local.y], indices[local.z]);
            _result.corners[t] = local + firstCorner;
            _result.faces[t] = static_cast<std::uint32_t>(face.index);
        }
        for (std::uint32_t i = 0; count > 0 && i < face.count; ++i) {
            const glm::vec3 p(_points[i]);
            _block.bounds.min = glm::min(_block.bounds.min, p);
            _block.bounds.max = glm::max(_block.bounds.max, p);
        }
    }

    const GeometryDescription& _mesh;
    TriangleMesh& _result;
    std::uint64_t _firstTriangle;
    BlockResult _block;
    PolygonSplitter _splitter;
    std::vector<glm::dvec3> _points;
    std::vector<glm::uvec3> _local;
};

/// Calls visit(face) for the faces of a block, holes included; `corner` is its first face-vertex.
template <typename Visit>
void ForEachFace(const GeometryDescription& mesh, std::size_t block, std::uint64_t corner,
                 Visit visit) {
    const std::size_t begin = block * FaceTable::kFacesPerBlock;
    const std::size_t end =
        std::min(begin + FaceTable::kFacesPerBlock, mesh.faceVertexCounts.size());
    for (std::size_t f = begin; f < end; ++f) {
        const auto count = static_cast<std::uint32_t>(std::max(mesh.faceVertexCounts[f], 0));
        visit(Face{f, corner, count});
        corner += count;
    }
}

/// Turns entries [1..] that hold sizes into running sums.
void Accumulate(std::vector<std::uint64_t>& begins) {
    for (std::size_t i = 1; i < begins.size(); ++i) {
        begins[i] += begins[i - 1];
    }
}

/// Closes the gaps that dropped triangles left at the ends of blocks.
void Compact(const FaceTable& table, const std::vector<BlockResult>& blocks, TriangleMesh& result) {
    std::uint64_t numTriangles = 0;
    for (std::size_t block = 0; block < blocks.size(); ++block) {
        const std::uint64_t begin = table.triangleBegin[block];
        const std::uint64_t end = begin + blocks[block].numTriangles;
        if (begin != numTriangles) {
            const auto move = [&](auto& values) {
                std::copy(values.begin() + begin, values.begin() + end,
                          values.begin() + numTriangles);
            };
            move(result.triangles);
            move(result.corners);
            move(result.faces);
        }
        numTriangles += blocks[block].numTriangles;
    }
    if (numTriangles == result.triangles.size()) {
        return;
    }
    const auto shrink = [&](auto& values) {
        values.resize(numTriangles);
        values.shrink_to_fit();
    };
    shrink(result.triangles);
    shrink(result.corners);
    shrink(result.faces);
}

} // namespace

bool IsUsablePoint(const float* point) {
    // Comparisons with NaN are false.
    return std::fabs(point[0]) <= kMaxCoordinate && std::fabs(point[1]) <= kMaxCoordinate &&
           std::fabs(point[2]) <= kMaxCoordinate;
}

FaceUse CheckFace(const GeometryDescription& mesh, std::uint64_t firstCorner, std::uint32_t count) {
    if (count < 3) {
        return FaceUse::TooFewVertices;
    }
    if (firstCorner + count > mesh.faceVertexIndices.size()) {
        return FaceUse::EndsEarly;
    }
    const std::size_t numPoints = mesh.points.size() / 3;
    const std::int32_t* indices = mesh.faceVertexIndices.data() + firstCorner;
    bool isFinite = true;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (indices[i] < 0 || static_cast<std::size_t>(indices[i]) >= numPoints) {
            return FaceUse::IndexOutOfRange;
        }
        isFinite = isFinite && IsUsablePoint(mesh.points.data() + std::size_t(indices[i]) * 3);
    }
    return isFinite ? FaceUse::Usable : FaceUse::PointNotFinite;
}

void FaceProblems::Count(FaceUse use) {
    tooFewVertices += use == FaceUse::TooFewVertices ? 1 : 0;
    endsEarly += use == FaceUse::EndsEarly ? 1 : 0;
    indexOutOfRange += use == FaceUse::IndexOutOfRange ? 1 : 0;
    pointNotFinite += use == FaceUse::PointNotFinite ? 1 : 0;
}

void FaceProblems::Warn(const std::string& primPath, Warnings& warnings) const {
    const auto warn = [&](std::uint64_t count, const std::string& reason) {
        if (count > 0) {
            warnings.Add(primPath, std::to_string(count) + (count == 1 ? " face" : " faces") +
                                       " dropped: " + reason);
        }
    };
    warn(tooFewVertices, "fewer than 3 vertices");
    warn(endsEarly, "faceVertexIndices end before them");
    warn(indexOutOfRange, "point index out of range");
    warn(pointNotFinite, "point not finite or beyond 1e18");
    warn(zeroArea, "zero area");
}

void FaceProblems::Add(const FaceProblems& other) {
    tooFewVertices += other.tooFewVertices;
    endsEarly += other.endsEarly;
    indexOutOfRange += other.indexOutOfRange;
    pointNotFinite += other.pointNotFinite;
    zeroArea += other.zeroArea;
}

FaceTable BuildFaceTable(const GeometryDescription& mesh) {
    FaceTable table;
    table.numFaces = mesh.faceVertexCounts.size();
    const std::size_t numBlocks =
        (table.numFaces + FaceTable::kFacesPerBlock - 1) / FaceTable::kFacesPerBlock;
    table.cornerBegin.assign(numBlocks + 1, 0);
    table.triangleBegin.assign(numBlocks + 1, 0);
    tbb::parallel_for(std::size_t(0), numBlocks, [&](std::size_t block) {
        std::uint64_t numCorners = 0;
        ForEachFace(mesh, block, 0, [&](const Face& face) { numCorners += face.count; });
        table.cornerBegin[block + 1] = numCorners;
    });
    Accumulate(table.cornerBegin);
    table.numCorners = table.cornerBegin.back();
    const std::size_t numIndices = mesh.faceVertexIndices.size();
    tbb::parallel_for(std::size_t(0), numBlocks, [&](std::size_t block) {
        std::uint64_t numTriangles = 0;
        ForEachFace(mesh, block, table.cornerBegin[block], [&](const Face& face) {
            const bool isComplete = face.firstCorner + face.count <= numIndices;
            numTriangles += isComplete && face.count >= 3 ? face.count - 2 : 0;
        });
        table.triangleBegin[block + 1] = numTriangles;
    });
    Accumulate(table.triangleBegin);
    return table;
}

FaceProblems SplitFaces(const GeometryDescription& mesh, const FaceTable& table,
                        const std::vector<std::uint8_t>& isHole, TriangleMesh& result) {
    result.triangles.resize(table.triangleBegin.back());
    result.corners.resize(table.triangleBegin.back());
    result.faces.resize(table.triangleBegin.back());
    std::vector<BlockResult> blocks(table.NumBlocks());
    tbb::parallel_for(std::size_t(0), blocks.size(), [&](std::size_t block) {
        BlockSplitter splitter(mesh, result, table.triangleBegin[block]);
        ForEachFace(mesh, block, table.cornerBegin[block], [&](const Face& face) {
            if (isHole.empty() || isHole[face.index] == 0) {
                splitter.Add(face);
            }
        });
        blocks[block] = splitter.Result();
    });
    Compact(table, blocks, result);
    FaceProblems problems;
    for (const BlockResult& block : blocks) {
        problems.Add(block.problems);
        result.bounds.min = glm::min(result.bounds.min, block.bounds.min);
        result.bounds.max = glm::max(result.bounds.max, block.bounds.max);
    }
    return problems;
}

} // namespace hds
