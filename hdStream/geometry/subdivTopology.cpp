// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/subdivTopology.h"

#include "hdStream/geometry/faceTable.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <iterator>
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

/// A rule of OpenSubdiv and UsdGeomMesh's token of it.
template <typename Rule>
using RuleToken = std::pair<const char*, Rule>;

constexpr RuleToken<Sdc::Options::VtxBoundaryInterpolation> kBoundaries[] = {
    {"edgeAndCorner", Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER},
    {"edgeOnly", Sdc::Options::VTX_BOUNDARY_EDGE_ONLY},
    {"none", Sdc::Options::VTX_BOUNDARY_NONE}};
constexpr RuleToken<Sdc::Options::FVarLinearInterpolation> kLinear[] = {
    {"cornersPlus1", Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1},
    {"none", Sdc::Options::FVAR_LINEAR_NONE},
    {"cornersOnly", Sdc::Options::FVAR_LINEAR_CORNERS_ONLY},
    {"cornersPlus2", Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2},
    {"boundaries", Sdc::Options::FVAR_LINEAR_BOUNDARIES},
    {"all", Sdc::Options::FVAR_LINEAR_ALL}};
constexpr RuleToken<Sdc::Options::TriangleSubdivision> kTriangles[] = {
    {"catmullClark", Sdc::Options::TRI_SUB_CATMARK}, {"smooth", Sdc::Options::TRI_SUB_SMOOTH}};

/// Reads UsdGeomMesh's tokens; unknown ones warn and read as the schema's fallback.
class RuleReader {
public:
    RuleReader(const std::string& primPath, Warnings& warnings)
        : _primPath(primPath), _warnings(warnings) {}

    /// \param rules the schema's fallback first
    template <typename Rule, std::size_t kCount>
    Rule Read(const char* name, const std::string& token,
              const RuleToken<Rule> (&rules)[kCount]) const {
        const auto* found = std::find_if(std::begin(rules), std::end(rules),
                                         [&](const auto& rule) { return token == rule.first; });
        if (found == std::end(rules)) {
            _warnings.Add(_primPath, "unknown " + std::string(name) + " \"" + token + "\", " +
                                         rules[0].first + " is used");
            found = rules;
        }
        return found->second;
    }

private:
    const std::string& _primPath;
    Warnings& _warnings;
};

Sdc::Options MakeOptions(const SubdivTags& tags, const RuleReader& reader) {
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(
        reader.Read("interpolateBoundary", tags.interpolateBoundary, kBoundaries));
    options.SetFVarLinearInterpolation(reader.Read("faceVaryingLinearInterpolation",
                                                   tags.faceVaryingLinearInterpolation, kLinear));
    options.SetTriangleSubdivision(
        reader.Read("triangleSubdivisionRule", tags.triangleSubdivisionRule, kTriangles));
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
    cage.options = MakeOptions(*mesh.subdivTags, RuleReader(primPath, warnings));
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
    Factory::Options options(SchemeOf(mesh.subdivisionScheme), cage.options);
    options.validateFullTopology = true;
    return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(descriptor, options));
}

} // namespace hds
