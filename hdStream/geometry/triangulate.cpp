// SPDX-License-Identifier: Apache-2.0
// Triangulate: the steps from an authored mesh to a TriangleMesh, and the warnings of each.
#include "hdStream/geometry/faceTable.h"
#include "hdStream/geometry/normals.h"
#include "hdStream/geometry/primvars.h"
#include "hdStream/geometry/subdivide.h"
#include "hdStream/geometry/triangleMesh.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace hds {
namespace {

using Range = tbb::blocked_range<std::size_t>;
constexpr std::size_t kGrain = 16384;

/// The warnings of one prim.
class PrimLog {
public:
    PrimLog(const std::string& primPath, Warnings& warnings)
        : _primPath(primPath), _warnings(warnings) {}
    void Warn(const std::string& text) { _warnings.Add(_primPath, text); }
    const std::string& PrimPath() const { return _primPath; }
    Warnings& Sink() { return _warnings; }

private:
    const std::string& _primPath;
    Warnings& _warnings;
};

/// True for schemes whose cage is the surface: faceted unless normals are authored.
bool IsPolygonal(const std::string& scheme) {
    return scheme != "catmullClark" && scheme != "loop";
}

bool IsSubdivided(const std::string& scheme) {
    return scheme == "catmullClark" || scheme == "loop" || scheme == "bilinear";
}

void CheckHeader(const MeshDescription& mesh, const FaceTable& table, PrimLog& log) {
    const std::string& scheme = mesh.subdivisionScheme;
    if (IsPolygonal(scheme) && scheme != "none" && scheme != "bilinear") {
        log.Warn("unknown subdivisionScheme \"" + scheme + "\", drawn as none");
    }
    if (mesh.points.size() % 3 != 0) {
        log.Warn(std::to_string(mesh.points.size() % 3) + " floats after the last point ignored");
    }
    if (table.numCorners != mesh.faceVertexIndices.size()) {
        log.Warn("faceVertexCounts ask for " + std::to_string(table.numCorners) +
                 " faceVertexIndices, there are " + std::to_string(mesh.faceVertexIndices.size()));
    }
}

std::vector<std::uint8_t> MarkHoles(const MeshDescription& mesh, PrimLog& log) {
    std::vector<std::uint8_t> isHole;
    if (mesh.holeIndices.empty()) {
        return isHole;
    }
    const std::size_t numFaces = mesh.faceVertexCounts.size();
    isHole.resize(numFaces);
    std::size_t numBad = 0;
    for (const std::int32_t face : mesh.holeIndices) {
        if (face < 0 || static_cast<std::size_t>(face) >= numFaces) {
            ++numBad;
        } else {
            isHole[face] = 1;
        }
    }
    if (numBad > 0) {
        log.Warn(std::to_string(numBad) + " holeIndices ignored: out of range");
    }
    return isHole;
}

/// Where positions are relative to. An axis moves only when the whole mesh lies within a factor 2
/// of the new origin on it, so that float subtraction is exact (Sterbenz 1974, theorem 4.3.1).
glm::vec3 ChooseOrigin(const Bounds& bounds) {
    const glm::dvec3 low(bounds.min);
    const glm::dvec3 high(bounds.max);
    const glm::dvec3 centre = 0.5 * (low + high);
    const double halfDiagonal = 0.5 * glm::length(high - low);
    glm::vec3 origin(0.0F);
    if (glm::length(centre) > 4.0 * halfDiagonal) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto rounded = static_cast<float>(centre[axis]);
            const float smaller =
                std::min(std::fabs(bounds.min[axis]), std::fabs(bounds.max[axis]));
            const float larger = std::max(std::fabs(bounds.min[axis]), std::fabs(bounds.max[axis]));
            const float size = std::fabs(rounded);
            const bool isExact = bounds.min[axis] * bounds.max[axis] > 0.0F && //
                                 smaller >= 0.5F * size && larger <= 2.0F * size;
            origin[axis] = isExact ? rounded : 0.0F;
        }
    }
    return origin;
}

void FillPositions(const MeshDescription& mesh, TriangleMesh& result) {
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

/// Material entry per face: 1 + the first subset that names it, else 0.
std::vector<std::uint32_t> AssignSubsets(const MeshDescription& mesh, PrimLog& log) {
    std::vector<std::uint32_t> entries(mesh.faceVertexCounts.size());
    for (std::size_t s = 0; s < mesh.subsets.size(); ++s) {
        const MeshSubset& subset = mesh.subsets[s];
        std::size_t numBad = 0;
        std::size_t numTaken = 0;
        const auto entry = static_cast<std::uint32_t>(s + 1);
        for (const std::int32_t face : subset.faces) {
            if (face < 0 || static_cast<std::size_t>(face) >= entries.size()) {
                ++numBad;
            } else if (entries[face] == 0) {
                entries[face] = entry;
            } else if (entries[face] != entry) {
                ++numTaken;
            }
        }
        if (numBad > 0) {
            log.Warn("subset " + subset.name + ": " + std::to_string(numBad) +
                     " faces ignored: out of range");
        }
        if (numTaken > 0) {
            log.Warn("subset " + subset.name + ": " + std::to_string(numTaken) +
                     " faces ignored: taken by an earlier subset");
        }
    }
    return entries;
}

void FillMaterialEntries(const MeshDescription& mesh, TriangleMesh& result, PrimLog& log) {
    if (mesh.subsets.empty()) {
        return;
    }
    const std::vector<std::uint32_t> entries = AssignSubsets(mesh, log);
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

void FillAttributes(const MeshDescription& mesh, const TopologySize& size, TriangleMesh& result,
                    PrimLog& log) {
    for (const Primvar& primvar : mesh.primvars) {
        if (primvar.name == "normals" || primvar.interpolation == Interpolation::Instance) {
            continue;
        }
        auto attribute = ValidatePrimvar(primvar, size, log.PrimPath(), log.Sink());
        if (attribute) {
            result.attributes.push_back(std::move(*attribute));
        }
    }
    auto& attributes = result.attributes;
    std::stable_sort(attributes.begin(), attributes.end(),
                     [](const auto& a, const auto& b) { return a.name < b.name; });
    const auto last = std::unique(attributes.begin(), attributes.end(),
                                  [](const auto& a, const auto& b) { return a.name == b.name; });
    if (last != attributes.end()) {
        log.Warn(std::to_string(attributes.end() - last) + " primvars ignored: repeated name");
        attributes.erase(last, attributes.end());
    }
}

/// The authored normals, if they can be used.
std::optional<MeshAttribute> AuthoredNormals(const MeshDescription& mesh, const TopologySize& size,
                                             const TriangleMesh& result, PrimLog& log) {
    const auto found =
        std::find_if(mesh.primvars.begin(), mesh.primvars.end(), [](const Primvar& primvar) {
            return primvar.name == "normals" && primvar.interpolation != Interpolation::Instance;
        });
    if (found == mesh.primvars.end()) {
        return std::nullopt;
    }
    if (found->numComponents != 3) {
        log.Warn("primvar \"normals\" ignored: " + std::to_string(found->numComponents) +
                 " components, 3 are needed");
        return std::nullopt;
    }
    auto normals = ValidatePrimvar(*found, size, log.PrimPath(), log.Sink());
    if (!normals) {
        return std::nullopt;
    }
    if (normals->interpolation == Interpolation::Constant) {
        if (IsUsableNormal(ValueOf(*normals, 0))) {
            return normals;
        }
        log.Warn("primvar \"normals\" ignored: zero or not finite");
        return std::nullopt;
    }
    const std::size_t numReplaced = RepairNormals(result, size, *normals);
    if (numReplaced > 0) {
        log.Warn(std::to_string(numReplaced) +
                 " normals replaced by face normals: zero or not finite");
    }
    return normals;
}

void FillNormals(const MeshDescription& mesh, const TopologySize& size, TriangleMesh& result,
                 PrimLog& log) {
    if (!IsPolygonal(mesh.subdivisionScheme)) {
        result.normals = ComputeSmoothNormals(result);
    } else if (auto normals = AuthoredNormals(mesh, size, result, log)) {
        result.normals = std::move(*normals);
    }
}

/// Everything but material entries. Authored faces are the description's own.
void Interpret(const MeshDescription& mesh, TriangleMesh& result, PrimLog& log) {
    const FaceTable table = BuildFaceTable(mesh);
    CheckHeader(mesh, table, log);
    // HDS_NONE and HDS_NOT_RESIDENT take the last value; corners are counted in 32 bits too.
    if (mesh.faceVertexIndices.size() >= 0xffffffffU || table.numFaces >= 0xffffffffU) {
        log.Warn("mesh dropped: more than 2^32 - 2 faceVertexIndices or faces");
        return;
    }
    SplitFaces(mesh, table, MarkHoles(mesh, log), result).Warn(log.PrimPath(), log.Sink());
    FillPositions(mesh, result);
    if (!result.triangles.empty()) {
        const TopologySize size{mesh.points.size() / 3, table.numFaces,
                                static_cast<std::size_t>(table.numCorners)};
        FillAttributes(mesh, size, result, log);
        FillNormals(mesh, size, result, log);
    }
}

/// Makes a uniform attribute that has one index a refined face one with an index an authored face:
/// all faces that a cage face was refined into have the same value.
void AddressByAuthoredFace(const RefinedMesh& refined, std::size_t numAuthoredFaces,
                           MeshAttribute& attribute) {
    std::vector<std::int32_t> indices(numAuthoredFaces, 0); // holes keep 0 and are never asked for
    for (std::size_t face = 0; face < refined.authoredFaces.size(); ++face) {
        indices[refined.authoredFaces[face]] =
            attribute.indices.empty() ? static_cast<std::int32_t>(face) : attribute.indices[face];
    }
    attribute.indices = std::move(indices);
}

/// The same for a refined cage; false when it cannot be refined.
bool InterpretRefined(const MeshDescription& mesh, int refineLevel, TriangleMesh& result,
                      PrimLog& log) {
    const auto refined = RefineMesh(mesh, refineLevel, log.PrimPath(), log.Sink());
    if (!refined) {
        return false;
    }
    CheckHeader(mesh, BuildFaceTable(mesh), log);
    MarkHoles(mesh, log);
    // The authored content has had its warnings; faces and normals that the surface makes
    // degenerate, as at a cone's tip, are nobody's mistake.
    Warnings unheard;
    PrimLog silent(log.PrimPath(), unheard);
    Interpret(refined->mesh, result, silent);
    for (std::uint32_t& face : result.faces) {
        face = refined->authoredFaces[face];
    }
    for (MeshAttribute& attribute : result.attributes) {
        if (attribute.interpolation == Interpolation::Uniform) {
            AddressByAuthoredFace(*refined, mesh.faceVertexCounts.size(), attribute);
        }
    }
    return true;
}

} // namespace

std::shared_ptr<const TriangleMesh> Triangulate(const MeshDescription& mesh,
                                                const std::string& primPath, Warnings& warnings,
                                                int refineLevel) {
    const auto result = std::make_shared<TriangleMesh>();
    result->leftHanded = mesh.leftHanded;
    PrimLog log(primPath, warnings);
    const bool isRefined = refineLevel > 0 && IsSubdivided(mesh.subdivisionScheme) &&
                           InterpretRefined(mesh, refineLevel, *result, log);
    if (!isRefined) {
        Interpret(mesh, *result, log);
    }
    if (!result->triangles.empty()) {
        FillMaterialEntries(mesh, *result, log);
    }
    return result;
}

} // namespace hds
