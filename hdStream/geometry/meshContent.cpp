// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/meshContent.h"

#include "hdStream/geometry/normals.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace hds {

bool IsPolygonal(const std::string& scheme) {
    return scheme != "catmullClark" && scheme != "loop";
}

void CheckHeader(const GeometryDescription& mesh, const FaceTable& table, PrimLog& log) {
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

bool IsCountable(const GeometryDescription& mesh, const FaceTable& table, PrimLog& log) {
    // HDS_NONE and HDS_NOT_RESIDENT take the last value; corners are counted in 32 bits too.
    if (mesh.faceVertexIndices.size() < 0xffffffffU && table.numFaces < 0xffffffffU) {
        return true;
    }
    log.Warn("mesh dropped: more than 2^32 - 2 faceVertexIndices or faces");
    return false;
}

std::vector<std::uint8_t> MarkHoles(const GeometryDescription& mesh, PrimLog& log) {
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

std::vector<std::uint32_t> AssignSubsets(const GeometryDescription& mesh, PrimLog& log) {
    if (mesh.subsets.empty()) {
        return {};
    }
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
    const bool isAllZero =
        std::all_of(entries.begin(), entries.end(), [](std::uint32_t entry) { return entry == 0; });
    return isAllZero ? std::vector<std::uint32_t>() : entries;
}

std::vector<GeometryAttribute> CollectAttributes(const GeometryDescription& mesh,
                                                 const TopologySize& size, PrimLog& log) {
    std::vector<GeometryAttribute> attributes;
    for (const Primvar& primvar : mesh.primvars) {
        if (primvar.name == "normals" || primvar.interpolation == Interpolation::Instance) {
            continue;
        }
        auto attribute = ValidatePrimvar(primvar, size, log.PrimPath(), log.Sink());
        if (attribute) {
            attributes.push_back(std::move(*attribute));
        }
    }
    std::stable_sort(attributes.begin(), attributes.end(),
                     [](const auto& a, const auto& b) { return a.name < b.name; });
    const auto last = std::unique(attributes.begin(), attributes.end(),
                                  [](const auto& a, const auto& b) { return a.name == b.name; });
    if (last != attributes.end()) {
        log.Warn(std::to_string(attributes.end() - last) + " primvars ignored: repeated name");
        attributes.erase(last, attributes.end());
    }
    return attributes;
}

std::optional<GeometryAttribute> AuthoredNormals(const GeometryDescription& mesh,
                                                 const TopologySize& size, PrimLog& log) {
    const auto found =
        std::find_if(mesh.primvars.begin(), mesh.primvars.end(), [](const Primvar& primvar) {
            return primvar.name == "normals" && primvar.interpolation != Interpolation::Instance;
        });
    // A bilinear surface has its own, in every form that it is drawn in.
    if (found == mesh.primvars.end() || mesh.subdivisionScheme == "bilinear") {
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
    if (normals->interpolation == Interpolation::Constant &&
        !IsUsableNormal(ValueOf(*normals, 0))) {
        log.Warn("primvar \"normals\" ignored: zero or not finite");
        return std::nullopt;
    }
    return normals;
}

void RepairAuthoredNormals(const TriangleMesh& mesh, const TopologySize& size,
                           GeometryAttribute& normals, PrimLog& log) {
    const std::size_t numReplaced = RepairNormals(mesh, size, normals);
    if (numReplaced > 0) {
        log.Warn(std::to_string(numReplaced) +
                 " normals replaced by face normals: zero or not finite");
    }
}

} // namespace hds
