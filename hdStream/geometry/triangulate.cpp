// SPDX-License-Identifier: Apache-2.0
// Triangulate: the steps from an authored mesh to a TriangleMesh, and the warnings of each.
#include "hdStream/geometry/meshContent.h"
#include "hdStream/geometry/normals.h"
#include "hdStream/geometry/triangleMesh.h"

#include <glm/common.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace hds {
namespace {

using Range = tbb::blocked_range<std::size_t>;
constexpr std::size_t kGrain = 16384;

void FillPositions(const GeometryDescription& mesh, TriangleMesh& result) {
    if (result.triangles.empty()) {
        result.bounds = Bounds();
        return;
    }
    const glm::vec3 origin = ChooseOrigin(result.bounds);
    result.origin = glm::dvec3(origin);
    result.bounds.min -= origin;
    result.bounds.max -= origin;
    result.positions.resize(mesh.points.size() / 3);
    tbb::parallel_for(Range(0, result.positions.size(), kGrain), [&](const Range& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const float* p = mesh.points.data() + i * 3;
            if (IsUsablePoint(p)) {
                result.positions[i] = glm::vec3(p[0], p[1], p[2]) - origin;
            }
        }
    });
}

void FillMaterialEntries(const GeometryDescription& mesh, TriangleMesh& result, PrimLog& log) {
    const std::vector<std::uint32_t> entries = AssignSubsets(mesh, log);
    if (entries.empty()) {
        return;
    }
    result.materialEntries.resize(result.triangles.size());
    tbb::parallel_for(Range(0, result.triangles.size(), kGrain), [&](const Range& range) {
        for (std::size_t t = range.begin(); t < range.end(); ++t) {
            result.materialEntries[t] = entries[result.faces[t]];
        }
    });
    if (std::all_of(result.materialEntries.begin(), result.materialEntries.end(),
                    [](std::uint32_t entry) { return entry == 0; })) {
        result.materialEntries = {};
    }
}

void FillNormals(const GeometryDescription& mesh, const TopologySize& size, TriangleMesh& result,
                 PrimLog& log) {
    if (!IsPolygonal(mesh.subdivisionScheme)) {
        result.normals = ComputeSmoothNormals(result);
    } else if (auto normals = AuthoredNormals(mesh, size, log)) {
        result.normals = std::move(*normals);
        WarnNotFinite(result.normals, log.PrimPath(), log.Sink());
        if (result.normals.interpolation != Interpolation::Constant) {
            RepairAuthoredNormals(result, size, result.normals, log);
        }
    }
}

/// Everything but material entries. Authored faces are the description's own.
void Interpret(const GeometryDescription& mesh, TriangleMesh& result, PrimLog& log) {
    const FaceTable table = BuildFaceTable(mesh);
    CheckHeader(mesh, table, log);
    if (!IsCountable(mesh, table, log)) {
        return;
    }
    SplitFaces(mesh, table, MarkHoles(mesh, log), result).Warn(log.PrimPath(), log.Sink());
    FillPositions(mesh, result);
    if (!result.triangles.empty()) {
        const TopologySize size{mesh.points.size() / 3, table.numFaces,
                                static_cast<std::size_t>(table.numCorners)};
        result.attributes = CollectAttributes(mesh, size, log);
        for (const GeometryAttribute& attribute : result.attributes) {
            WarnNotFinite(attribute, log.PrimPath(), log.Sink());
        }
        FillNormals(mesh, size, result, log);
    }
}

} // namespace

std::shared_ptr<const TriangleMesh> Triangulate(const GeometryDescription& mesh,
                                                const std::string& primPath, Warnings& warnings) {
    const auto result = std::make_shared<TriangleMesh>();
    result->leftHanded = mesh.leftHanded;
    PrimLog log(primPath, warnings);
    Interpret(mesh, *result, log);
    if (!result->triangles.empty()) {
        FillMaterialEntries(mesh, *result, log);
    }
    return result;
}

} // namespace hds
