// SPDX-License-Identifier: Apache-2.0
// Cages for the tests of subdivision, sources gathered whole, and the limit surface as OpenSubdiv's
// uniform refinement and limit masks give it: another code path than the one that dices.
#pragma once

#include "hdStream/geometry/subdivSource.h"
#include "testenv/unit/geometry/meshFixtures.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <numeric>

namespace hds::test {

/// A source with everything it says.
struct Diced {
    std::shared_ptr<const SubdivChunkSource> source; ///< null: refused
    ChunkGeometry chunk;                             ///< of all units
    std::vector<std::string> warnings;
};

inline Diced DiceAll(const GeometryDescription& mesh, const DicingOptions& options,
                     const Displacement& displacement = {}) {
    Warnings warnings;
    Diced result;
    result.source = MakeSubdivSource(std::make_shared<GeometryDescription>(mesh), "/World/mesh",
                                     options, displacement, warnings);
    if (result.source) {
        std::vector<std::uint32_t> units(result.source->NumPrimitiveGroups());
        std::iota(units.begin(), units.end(), 0U);
        result.chunk = result.source->Gather(units.data(), units.size());
    }
    result.warnings = warnings.Lines();
    return result;
}

inline Diced DiceUniform(const GeometryDescription& mesh, std::uint32_t level,
                         const Displacement& displacement = {}) {
    DicingOptions options;
    options.level = level;
    return DiceAll(mesh, options, displacement);
}

/// Adaptive rates for a camera that looks along -z at an object there.
inline DicingOptions MakeOptions(const glm::dvec3& objectFromCamera) {
    DicingOptions options;
    options.isAdaptive = true;
    options.level = kAdaptiveLevel;
    options.view.imageSize = {640.0, 480.0};
    options.view.windowMin = {-0.5, -0.375};
    options.view.windowMax = {0.5, 0.375};
    options.view.cameraFromObject[3] = glm::dvec4(objectFromCamera, 1.0);
    return options;
}

/// A cube of quads, side 2.
inline GeometryDescription MakeCube() {
    GeometryDescription mesh = MakeMesh({{-1, -1, -1},
                                         {1, -1, -1},
                                         {1, 1, -1},
                                         {-1, 1, -1},
                                         {-1, -1, 1},
                                         {1, -1, 1},
                                         {1, 1, 1},
                                         {-1, 1, 1}},
                                        {4, 4, 4, 4, 4, 4}, {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4,
                                                             1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7});
    mesh.subdivisionScheme = "catmullClark";
    return mesh;
}

/// A closed cage about the origin with faces of `numSides` types: a box grid whose faces are split
/// or joined at random. \param onlyTriangles for loop.
inline GeometryDescription MakeRandomCage(std::mt19937& random, bool onlyTriangles) {
    const int n = 2 + int(random() % 2);
    std::vector<glm::vec3> points;
    std::vector<int> pointAt(std::size_t((n + 1) * (n + 1) * (n + 1)), -1);
    std::vector<std::int32_t> counts;
    std::vector<std::int32_t> indices;
    const auto point = [&](int x, int y, int z) {
        int& index = pointAt[std::size_t((z * (n + 1) + y) * (n + 1) + x)];
        if (index < 0) {
            const auto jitter = [&] { return float(random() % 1000) / 4000.0F; };
            index = int(points.size());
            points.emplace_back(x - 0.5F * n + jitter(), y - 0.5F * n + jitter(),
                                z - 0.5F * n + jitter());
        }
        return index;
    };
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        const int level = side % 2 * n;
        for (int b = 0; b < n; ++b) {
            for (int a = 0; a < n; ++a) {
                const auto at = [&](int da, int db) {
                    int p[3];
                    p[axis] = level;
                    p[(axis + 1) % 3] = a + da;
                    p[(axis + 2) % 3] = b + db;
                    return point(p[0], p[1], p[2]);
                };
                std::vector<std::int32_t> quad = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
                if (side % 2 == 0) {
                    std::swap(quad[1], quad[3]);
                }
                if (onlyTriangles || random() % 4 == 0) {
                    counts.insert(counts.end(), {3, 3});
                    indices.insert(indices.end(),
                                   {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]});
                } else {
                    counts.push_back(4);
                    indices.insert(indices.end(), quad.begin(), quad.end());
                }
            }
        }
    }
    GeometryDescription mesh = MakeMesh(points, counts, indices);
    mesh.subdivisionScheme = onlyTriangles ? "loop" : "catmullClark";
    return mesh;
}

/// Tags of all kinds on random edges and points.
inline void AddRandomTags(GeometryDescription& mesh, std::mt19937& random) {
    const auto pick = [&](std::initializer_list<const char*> tokens) {
        return std::string(tokens.begin()[random() % tokens.size()]);
    };
    SubdivTags& tags = mesh.subdivTags.Edit();
    tags.interpolateBoundary = pick({"none", "edgeOnly", "edgeAndCorner"});
    tags.faceVaryingLinearInterpolation =
        pick({"none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"});
    tags.triangleSubdivisionRule = pick({"catmullClark", "smooth"});
    std::vector<std::int32_t> pairs;
    std::vector<float> weights;
    std::size_t corner = 0;
    for (const std::int32_t count : mesh.faceVertexCounts) {
        for (std::int32_t i = 0; i < count; ++i) {
            if (random() % 6 == 0) {
                pairs.push_back(mesh.faceVertexIndices[corner + std::size_t(i)]);
                pairs.push_back(mesh.faceVertexIndices[corner + std::size_t((i + 1) % count)]);
                weights.push_back(random() % 2 == 0 ? 10.0F : 0.5F + float(random() % 4));
            }
        }
        corner += std::size_t(count);
    }
    tags.creaseLengths = std::vector<std::int32_t>(weights.size(), 2);
    tags.creaseIndices = pairs;
    tags.creaseSharpnesses = weights;
    tags.cornerIndices = std::vector<std::int32_t>{0, 5};
    tags.cornerSharpnesses = std::vector<float>{10.0F, 1.5F};
}

/// Limit points of the vertices of a level of uniform refinement, and of values over the corners.
struct LimitLevel {
    std::vector<glm::dvec3> points;
    std::vector<glm::dvec3> normals;          ///< unit; zero where tangents vanish
    std::vector<bool> isSharp;                ///< faces have normals of their own
    std::vector<bool> isDart;                 ///< where a crease ends: the masks ignore it
    std::vector<std::vector<int>> faces;      ///< points of the drawn faces
    std::vector<std::vector<glm::dvec2>> uvs; ///< per drawn face
    std::vector<int> cageFaces;
};

/// Semi-sharp edges are not smooth before their sharpness is used up: masks are those of
/// kDeepLevel. \param uv values and indices of a faceVarying channel; may be empty.
inline LimitLevel RefineToLimit(const GeometryDescription& mesh, int level,
                                const std::vector<glm::dvec2>& uv = {},
                                const std::vector<int>& uvIndices = {}) {
    namespace Far = OpenSubdiv::Far;
    namespace Sdc = OpenSubdiv::Sdc;
    struct Vec3 {
        glm::dvec3 v{0.0};
        void Clear() { v = glm::dvec3(0.0); }
        void AddWithWeight(const Vec3& other, double weight) { v += weight * other.v; }
    };
    const SubdivTags& tags = *mesh.subdivTags;
    Sdc::Options options;
    const auto& boundary = tags.interpolateBoundary;
    options.SetVtxBoundaryInterpolation(boundary == "none" ? Sdc::Options::VTX_BOUNDARY_NONE
                                        : boundary == "edgeOnly"
                                            ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                            : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    const auto& linear = tags.faceVaryingLinearInterpolation;
    options.SetFVarLinearInterpolation(
        linear == "none"           ? Sdc::Options::FVAR_LINEAR_NONE
        : linear == "cornersOnly"  ? Sdc::Options::FVAR_LINEAR_CORNERS_ONLY
        : linear == "cornersPlus1" ? Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1
        : linear == "cornersPlus2" ? Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2
        : linear == "boundaries"   ? Sdc::Options::FVAR_LINEAR_BOUNDARIES
                                   : Sdc::Options::FVAR_LINEAR_ALL);
    options.SetTriangleSubdivision(tags.triangleSubdivisionRule == "smooth"
                                       ? Sdc::Options::TRI_SUB_SMOOTH
                                       : Sdc::Options::TRI_SUB_CATMARK);
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = int(mesh.points.size() / 3);
    descriptor.numFaces = int(mesh.faceVertexCounts.size());
    descriptor.numVertsPerFace = mesh.faceVertexCounts.data();
    descriptor.vertIndicesPerFace = mesh.faceVertexIndices.data();
    descriptor.numCreases = int(tags.creaseSharpnesses.size());
    descriptor.creaseVertexIndexPairs = tags.creaseIndices.data();
    descriptor.creaseWeights = tags.creaseSharpnesses.data();
    descriptor.numCorners = int(tags.cornerSharpnesses.size());
    descriptor.cornerVertexIndices = tags.cornerIndices.data();
    descriptor.cornerWeights = tags.cornerSharpnesses.data();
    descriptor.numHoles = int(mesh.holeIndices.size());
    descriptor.holeIndices = mesh.holeIndices.data();
    Far::TopologyDescriptor::FVarChannel channel;
    channel.numValues = int(uv.size());
    channel.valueIndices = uvIndices.data();
    descriptor.numFVarChannels = uv.empty() ? 0 : 1;
    descriptor.fvarChannels = &channel;
    const Sdc::SchemeType scheme = mesh.subdivisionScheme == "loop"       ? Sdc::SCHEME_LOOP
                                   : mesh.subdivisionScheme == "bilinear" ? Sdc::SCHEME_BILINEAR
                                                                          : Sdc::SCHEME_CATMARK;
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    const std::unique_ptr<Far::TopologyRefiner> refiner(
        Factory::Create(descriptor, Factory::Options(scheme, options)));
    constexpr int kDeepLevel = 5;
    Far::TopologyRefiner::UniformOptions uniform(kDeepLevel);
    uniform.fullTopologyInLastLevel = true;
    refiner->RefineUniform(uniform);
    const Far::PrimvarRefinerReal<double> primvars(*refiner);
    std::vector<Vec3> values(mesh.points.size() / 3);
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i].v = {mesh.points[3 * i], mesh.points[3 * i + 1], mesh.points[3 * i + 2]};
    }
    std::vector<Vec3> uvs(uv.size());
    for (std::size_t i = 0; i < uvs.size(); ++i) {
        uvs[i].v = glm::dvec3(uv[i], 0.0);
    }
    for (int l = 1; l <= kDeepLevel; ++l) {
        std::vector<Vec3> finer(std::size_t(refiner->GetLevel(l).GetNumVertices()));
        primvars.Interpolate(l, values, finer);
        values = finer;
        if (!uv.empty()) {
            std::vector<Vec3> finerUvs(std::size_t(refiner->GetLevel(l).GetNumFVarValues(0)));
            primvars.InterpolateFaceVarying(l, uvs, finerUvs, 0);
            uvs = finerUvs;
        }
    }
    std::vector<Vec3> points(values.size());
    std::vector<Vec3> tangent1(values.size());
    std::vector<Vec3> tangent2(values.size());
    primvars.Limit(values, points, tangent1, tangent2);
    if (!uv.empty()) {
        std::vector<Vec3> limit(uvs.size());
        primvars.LimitFaceVarying(uvs, limit, 0);
        uvs = limit;
    }
    const Far::TopologyLevel& last = refiner->GetLevel(level);
    const Far::TopologyLevel& deepest = refiner->GetLevel(kDeepLevel);
    LimitLevel result;
    for (int vertex = 0; vertex < last.GetNumVertices(); ++vertex) {
        int deep = vertex;
        for (int l = level; l < kDeepLevel; ++l) {
            deep = refiner->GetLevel(l).GetVertexChildVertex(deep);
        }
        result.points.push_back(points[std::size_t(deep)].v);
        const glm::dvec3 normal =
            glm::cross(tangent1[std::size_t(deep)].v, tangent2[std::size_t(deep)].v);
        const double length = glm::length(normal);
        result.normals.push_back(length > 0.0 ? normal / length : glm::dvec3(0.0));
        const Far::ConstIndexArray edges = deepest.GetVertexEdges(deep);
        // Of a rounded corner of a sheet, the tangents of a face are parallel in the limit.
        bool isSharp =
            deepest.GetVertexSharpness(deep) > 0.0F || deepest.GetVertexFaces(deep).size() == 1;
        for (int e = 0; e < edges.size(); ++e) {
            isSharp = isSharp || (deepest.GetEdgeSharpness(edges[e]) > 0.0F &&
                                  !deepest.IsEdgeBoundary(edges[e]));
        }
        result.isSharp.push_back(isSharp);
        result.isDart.push_back(deepest.GetVertexRule(deep) == Sdc::Crease::RULE_DART);
    }
    for (int f = 0; f < last.GetNumFaces(); ++f) {
        if (last.IsFaceHole(f)) {
            continue;
        }
        const Far::ConstIndexArray corners = last.GetFaceVertices(f);
        result.faces.emplace_back(corners.begin(), corners.end());
        auto& faceUvs = result.uvs.emplace_back();
        for (int k = 0; !uv.empty() && k < corners.size(); ++k) {
            // The descendants of a face at a corner keep the corner.
            int face = f;
            int vertex = corners[k];
            int corner = k;
            for (int l = level; l < kDeepLevel; ++l) {
                vertex = refiner->GetLevel(l).GetVertexChildVertex(vertex);
                face = refiner->GetLevel(l).GetFaceChildFaces(face)[corner];
                const Far::ConstIndexArray deep = refiner->GetLevel(l + 1).GetFaceVertices(face);
                corner = int(std::find(deep.begin(), deep.end(), vertex) - deep.begin());
            }
            const int value = deepest.GetFaceFVarValues(face, 0)[corner];
            faceUvs.emplace_back(uvs[std::size_t(value)].v);
        }
        int face = f;
        for (int l = level; l > 0; --l) {
            face = refiner->GetLevel(l).GetFaceParentFace(face);
        }
        result.cageFaces.push_back(face);
    }
    return result;
}

} // namespace hds::test
