// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/subdivTopology.h"

#include "hdStream/geometry/faceTable.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hds {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

void AddFaces(const GeometryDescription& mesh, SubdivCage& cage, const std::string& primPath,
              Warnings& warnings) {
    FaceProblems problems;
    std::vector<int> cageFaces(mesh.faceVertexCounts.size(), -1);
    std::uint64_t corner = 0;
    for (std::size_t f = 0; f < mesh.faceVertexCounts.size(); ++f) {
        const auto count = static_cast<std::uint32_t>(std::max(mesh.faceVertexCounts[f], 0));
        const FaceUse use = CheckFace(mesh, corner, count);
        problems.Count(use);
        if (use == FaceUse::Usable) {
            cageFaces[f] = static_cast<int>(cage.faces.size());
            cage.faces.push_back(static_cast<std::uint32_t>(f));
            cage.counts.push_back(static_cast<int>(count));
            for (std::uint32_t i = 0; i < count; ++i) {
                cage.indices.push_back(mesh.faceVertexIndices[corner + i]);
                cage.corners.push_back(static_cast<std::uint32_t>(corner + i));
            }
        }
        corner += count;
    }
    problems.Warn(primPath, warnings);
    for (const std::int32_t hole : mesh.holeIndices) {
        if (hole >= 0 && static_cast<std::size_t>(hole) < cageFaces.size() &&
            cageFaces[hole] >= 0) {
            cage.holes.push_back(cageFaces[hole]);
        }
    }
}

bool IsPoint(const GeometryDescription& mesh, std::int32_t index) {
    return index >= 0 && static_cast<std::size_t>(index) < mesh.points.size() / 3;
}

/// Creases are chains of points; sharpness is per chain or per edge.
bool AddCreases(const GeometryDescription& mesh, SubdivCage& cage) {
    const SubdivTags& tags = *mesh.subdivTags;
    std::size_t numIndices = 0;
    std::size_t numEdges = 0;
    for (const std::int32_t length : tags.creaseLengths) {
        if (length < 2) {
            return false;
        }
        numIndices += static_cast<std::size_t>(length);
        numEdges += static_cast<std::size_t>(length) - 1;
    }
    const bool isPerEdge = tags.creaseSharpnesses.size() == numEdges;
    const bool isPerChain = tags.creaseSharpnesses.size() == tags.creaseLengths.size();
    const bool isInRange = std::all_of(tags.creaseIndices.begin(), tags.creaseIndices.end(),
                                       [&](std::int32_t index) { return IsPoint(mesh, index); });
    if (numIndices != tags.creaseIndices.size() || !(isPerEdge || isPerChain) || !isInRange) {
        return false;
    }
    const std::int32_t* point = tags.creaseIndices.data();
    for (std::size_t chain = 0; chain < tags.creaseLengths.size(); ++chain) {
        for (std::int32_t i = 0; i + 1 < tags.creaseLengths[chain]; ++i) {
            const std::size_t edge = cage.creaseWeights.size();
            cage.creasePairs.push_back(point[i]);
            cage.creasePairs.push_back(point[i + 1]);
            // NaN reads as 0: not a crease.
            cage.creaseWeights.push_back(
                std::fmax(0.0F, tags.creaseSharpnesses[isPerChain ? chain : edge]));
        }
        point += tags.creaseLengths[chain];
    }
    return true;
}

bool AddCorners(const GeometryDescription& mesh, SubdivCage& cage) {
    const SubdivTags& tags = *mesh.subdivTags;
    if (tags.cornerIndices.size() != tags.cornerSharpnesses.size()) {
        return false;
    }
    for (std::size_t i = 0; i < tags.cornerIndices.size(); ++i) {
        if (!IsPoint(mesh, tags.cornerIndices[i])) {
            return false;
        }
    }
    for (std::size_t i = 0; i < tags.cornerIndices.size(); ++i) {
        cage.cornerPoints.push_back(tags.cornerIndices[i]);
        cage.cornerWeights.push_back(std::fmax(0.0F, tags.cornerSharpnesses[i]));
    }
    return true;
}

/// UsdGeomMesh's tokens; unknown ones read as the schema's fallback.
Sdc::Options MakeOptions(const SubdivTags& tags) {
    Sdc::Options options;
    const std::string& boundary = tags.interpolateBoundary;
    options.SetVtxBoundaryInterpolation(boundary == "none" ? Sdc::Options::VTX_BOUNDARY_NONE
                                        : boundary == "edgeOnly"
                                            ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                            : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    static constexpr std::pair<const char*, Sdc::Options::FVarLinearInterpolation> kLinear[] = {
        {"none", Sdc::Options::FVAR_LINEAR_NONE},
        {"cornersOnly", Sdc::Options::FVAR_LINEAR_CORNERS_ONLY},
        {"cornersPlus1", Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1},
        {"cornersPlus2", Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2},
        {"boundaries", Sdc::Options::FVAR_LINEAR_BOUNDARIES},
        {"all", Sdc::Options::FVAR_LINEAR_ALL},
    };
    options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1);
    for (const auto& [token, value] : kLinear) {
        if (tags.faceVaryingLinearInterpolation == token) {
            options.SetFVarLinearInterpolation(value);
        }
    }
    options.SetTriangleSubdivision(tags.triangleSubdivisionRule == "smooth"
                                       ? Sdc::Options::TRI_SUB_SMOOTH
                                       : Sdc::Options::TRI_SUB_CATMARK);
    return options;
}

Sdc::SchemeType SchemeOf(const std::string& scheme) {
    return scheme == "loop"       ? Sdc::SCHEME_LOOP
           : scheme == "bilinear" ? Sdc::SCHEME_BILINEAR
                                  : Sdc::SCHEME_CATMARK;
}

} // namespace

SubdivCage BuildSubdivCage(const GeometryDescription& mesh, const std::string& primPath,
                           Warnings& warnings) {
    SubdivCage cage;
    AddFaces(mesh, cage, primPath, warnings);
    if (!AddCreases(mesh, cage)) {
        warnings.Add(primPath, "creases ignored: lengths, indices and sharpnesses disagree");
    }
    if (!AddCorners(mesh, cage)) {
        warnings.Add(primPath, "corners ignored: indices and sharpnesses disagree");
    }
    return cage;
}

std::unique_ptr<Far::TopologyRefiner> CreateRefiner(const GeometryDescription& mesh,
                                                    const SubdivCage& cage,
                                                    const std::vector<SubdivChannel>& channels) {
    // OpenSubdiv prints to stderr by default; the caller says in one line what happened.
    static const bool isSilent = [] {
        Far::SetErrorCallback([](Far::ErrorType, const char*) {});
        Far::SetWarningCallback([](const char*) {});
        return true;
    }();
    static_cast<void>(isSilent);
    std::vector<Far::TopologyDescriptor::FVarChannel> farChannels(channels.size());
    for (std::size_t i = 0; i < channels.size(); ++i) {
        farChannels[i].numValues = channels[i].numValues;
        farChannels[i].valueIndices = channels[i].valueIndices.data();
    }
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = static_cast<int>(mesh.points.size() / 3);
    descriptor.numFaces = static_cast<int>(cage.counts.size());
    descriptor.numVertsPerFace = cage.counts.data();
    descriptor.vertIndicesPerFace = cage.indices.data();
    descriptor.numCreases = static_cast<int>(cage.creaseWeights.size());
    descriptor.creaseVertexIndexPairs = cage.creasePairs.data();
    descriptor.creaseWeights = cage.creaseWeights.data();
    descriptor.numCorners = static_cast<int>(cage.cornerWeights.size());
    descriptor.cornerVertexIndices = cage.cornerPoints.data();
    descriptor.cornerWeights = cage.cornerWeights.data();
    descriptor.numHoles = static_cast<int>(cage.holes.size());
    descriptor.holeIndices = cage.holes.data();
    descriptor.isLeftHanded = false; // the winding stays as authored
    descriptor.numFVarChannels = static_cast<int>(farChannels.size());
    descriptor.fvarChannels = farChannels.data();
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Factory::Options options(SchemeOf(mesh.subdivisionScheme), MakeOptions(*mesh.subdivTags));
    options.validateFullTopology = true;
    return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(descriptor, options));
}

} // namespace hds
