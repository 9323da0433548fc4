// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/subdivide.h"

#include "hdStream/geometry/normals.h"
#include "hdStream/geometry/primvars.h"
#include "hdStream/geometry/subdivTopology.h"

#include <glm/geometric.hpp>
#include <opensubdiv/far/primvarRefiner.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hds {
namespace {

namespace Far = OpenSubdiv::Far;
using Primvars = Far::PrimvarRefinerReal<double>;

/// Tuples of a number of doubles that is known at run time, with what PrimvarRefiner asks of them.
class Tuples {
public:
    struct Reference {
        double* values;
        std::size_t size;
        void Clear() { std::fill(values, values + size, 0.0); }
        void AddWithWeight(const Reference& other, double weight) {
            for (std::size_t i = 0; i < size; ++i) {
                values[i] += weight * other.values[i];
            }
        }
    };

    Tuples(std::size_t count, std::size_t tupleSize)
        : _tupleSize(tupleSize), _values(count * tupleSize) {}
    // OpenSubdiv reads through a const source; the reference itself is what it adds from.
    Reference operator[](int index) const {
        return {const_cast<double*>(_values.data()) + std::size_t(index) * _tupleSize, _tupleSize};
    }
    double* Data() { return _values.data(); }
    glm::dvec3 Vec3(std::size_t i) const {
        return {_values[3 * i], _values[3 * i + 1], _values[3 * i + 2]};
    }
    std::vector<float> ToFloats() const { return {_values.begin(), _values.end()}; }

private:
    std::size_t _tupleSize;
    std::vector<double> _values;
};

/// The values of an attribute, one tuple per element (points or face-vertices).
Tuples Load(const MeshAttribute& attribute, std::size_t numElements) {
    Tuples tuples(numElements, attribute.numComponents);
    double* to = tuples.Data();
    for (std::size_t i = 0; i < numElements; ++i) {
        const float* value = ValueOf(attribute, i);
        // Values that are not finite would spread to their neighbours.
        to = std::transform(value, value + attribute.numComponents, to,
                            [](float v) { return std::isfinite(v) ? double(v) : 0.0; });
    }
    return tuples;
}

/// Refines one cage of a mesh; holds the refiner and the limit points.
class Refinement {
public:
    Refinement(const MeshDescription& cage, const Far::TopologyRefiner& refiner)
        : _cage(cage), _refiner(refiner), _primvars(refiner),
          _last(refiner.GetLevel(refiner.GetMaxLevel())),
          _isBilinear(cage.subdivisionScheme == "bilinear") {}

    /// Values of a vertex attribute on the limit surface.
    Tuples RefineVertex(const MeshAttribute& attribute) const {
        Tuples values = Load(attribute, _cage.points.size() / 3);
        for (int level = 1; level <= _refiner.GetMaxLevel(); ++level) {
            Tuples finer(_refiner.GetLevel(level).GetNumVertices(), attribute.numComponents);
            _primvars.Interpolate(level, values, finer);
            values = std::move(finer);
        }
        Tuples limit(_last.GetNumVertices(), attribute.numComponents);
        _primvars.Limit(values, limit);
        return limit;
    }

    Tuples RefineVarying(const MeshAttribute& attribute) const {
        Tuples values = Load(attribute, _cage.points.size() / 3);
        for (int level = 1; level <= _refiner.GetMaxLevel(); ++level) {
            Tuples finer(_refiner.GetLevel(level).GetNumVertices(), attribute.numComponents);
            _primvars.InterpolateVarying(level, values, finer);
            values = std::move(finer);
        }
        return values;
    }

    /// Values of a face-varying channel on the limit; corners name them by GetFaceFVarValues.
    Tuples RefineFaceVarying(const MeshAttribute& attribute, int channel) const {
        Tuples values = Load({attribute.name,
                              attribute.interpolation,
                              attribute.numComponents,
                              attribute.values,
                              {}},
                             attribute.values.size() / attribute.numComponents);
        for (int level = 1; level <= _refiner.GetMaxLevel(); ++level) {
            Tuples finer(_refiner.GetLevel(level).GetNumFVarValues(channel),
                         attribute.numComponents);
            _primvars.InterpolateFaceVarying(level, values, finer, channel);
            values = std::move(finer);
        }
        Tuples limit(_last.GetNumFVarValues(channel), attribute.numComponents);
        _primvars.LimitFaceVarying(values, limit, channel);
        return limit;
    }

    /// Limit points, and limit normals from the limit tangents (zero where they are parallel).
    void RefinePoints(Tuples& points, Tuples& normals) const {
        MeshAttribute cage;
        cage.numComponents = 3;
        cage.values = _cage.points;
        Tuples values = Load(cage, _cage.points.size() / 3);
        for (int level = 1; level <= _refiner.GetMaxLevel(); ++level) {
            Tuples finer(_refiner.GetLevel(level).GetNumVertices(), 3);
            _primvars.Interpolate(level, values, finer);
            values = std::move(finer);
        }
        const auto count = static_cast<std::size_t>(_last.GetNumVertices());
        Tuples tangent1(count, 3);
        Tuples tangent2(count, 3);
        _primvars.Limit(values, points, tangent1, tangent2);
        const double side = _cage.leftHanded ? -1.0 : 1.0;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::dvec3 normal = glm::cross(tangent1.Vec3(i), tangent2.Vec3(i));
            const double length = glm::length(normal);
            const glm::dvec3 unit = length > 0.0 ? normal * (side / length) : glm::dvec3(0.0);
            std::copy(&unit.x, &unit.x + 3, normals.Data() + 3 * i);
        }
    }

    const Far::TopologyLevel& Last() const { return _last; }
    bool IsBilinear() const { return _isBilinear; }

    /// The authored cage face of a face of the last level.
    int CageFace(int face) const {
        for (int level = _refiner.GetMaxLevel(); level > 0; --level) {
            face = _refiner.GetLevel(level).GetFaceParentFace(face);
        }
        return face;
    }

private:
    const MeshDescription& _cage;
    const Far::TopologyRefiner& _refiner;
    Primvars _primvars;
    const Far::TopologyLevel& _last;
    bool _isBilinear;
};

/// Index of `value` in a short list of OpenSubdiv.
int Find(const Far::ConstIndexArray& list, int value) {
    for (int i = 0; i < list.size(); ++i) {
        if (list[i] == value) {
            return i;
        }
    }
    return -1;
}

/// Normals at vertices that lie on creases inside the surface: each side of a crease has its own,
/// the sum over the corners of that side (Max 1999 weights) on the limit points.
class CreaseNormals {
public:
    CreaseNormals(const Far::TopologyLevel& level, const Tuples& points, bool isLeftHanded)
        : _level(level), _points(points), _side(isLeftHanded ? -1.0 : 1.0) {}

    bool IsCreased(int vertex) const {
        const Far::ConstIndexArray edges = _level.GetVertexEdges(vertex);
        for (int i = 0; i < edges.size(); ++i) {
            if (IsSharp(edges[i]) && !_level.IsEdgeBoundary(edges[i])) {
                return true;
            }
        }
        return false;
    }

    /// The normal at a vertex, of the side that `face` is on.
    glm::dvec3 At(int vertex, int face) const {
        // Flood over the faces around the vertex, never across a sharp edge. Their order is that of
        // the level's list, so that every face of a side gives the same bits.
        const Far::ConstIndexArray faces = _level.GetVertexFaces(vertex);
        std::vector<char> isOnSide(faces.size(), 0);
        std::vector<int> pending = {Find(faces, face)};
        isOnSide[pending[0]] = 1;
        while (!pending.empty()) {
            const int at = pending.back();
            pending.pop_back();
            const Far::ConstIndexArray edges = _level.GetFaceEdges(faces[at]);
            for (int e = 0; e < edges.size(); ++e) {
                const Far::ConstIndexArray ends = _level.GetEdgeVertices(edges[e]);
                if (IsSharp(edges[e]) || Find(ends, vertex) < 0) {
                    continue;
                }
                const Far::ConstIndexArray neighbours = _level.GetEdgeFaces(edges[e]);
                for (int n = 0; n < neighbours.size(); ++n) {
                    const int other = Find(faces, neighbours[n]);
                    if (other >= 0 && isOnSide[other] == 0) {
                        isOnSide[other] = 1;
                        pending.push_back(other);
                    }
                }
            }
        }
        glm::dvec3 sum(0.0);
        for (int i = 0; i < faces.size(); ++i) {
            sum += isOnSide[i] != 0 ? CornerNormal(vertex, faces[i]) : glm::dvec3(0.0);
        }
        const double length = glm::length(sum);
        return length > 0.0 ? sum * (_side / length) : glm::dvec3(0.0);
    }

private:
    bool IsSharp(int edge) const {
        return _level.GetEdgeSharpness(edge) > 0.0F || _level.IsEdgeNonManifold(edge);
    }

    glm::dvec3 CornerNormal(int vertex, int face) const {
        const Far::ConstIndexArray corners = _level.GetFaceVertices(face);
        const int k = Find(corners, vertex);
        const int size = corners.size();
        const glm::dvec3 origin = _points.Vec3(vertex);
        const glm::dvec3 next = _points.Vec3(corners[(k + 1) % size]) - origin;
        const glm::dvec3 prev = _points.Vec3(corners[(k + size - 1) % size]) - origin;
        const double weight = glm::dot(next, next) * glm::dot(prev, prev);
        return weight > 0.0 ? glm::cross(next, prev) / weight : glm::dvec3(0.0);
    }

    const Far::TopologyLevel& _level;
    const Tuples& _points;
    double _side;
};

/// Builds the refined description face by face.
class RefinedBuilder {
public:
    RefinedBuilder(const MeshDescription& mesh, const SubdivCage& cage,
                   const Refinement& refinement)
        : _mesh(mesh), _cage(cage), _refinement(refinement) {}

    /// Faces in order of their authored faces; holes are left out.
    void AddFaces() {
        const Far::TopologyLevel& level = _refinement.Last();
        std::vector<std::pair<std::uint32_t, int>> order;
        for (int f = 0; f < level.GetNumFaces(); ++f) {
            if (!level.IsFaceHole(f)) {
                order.emplace_back(_cage.faces[_refinement.CageFace(f)], f);
            }
        }
        std::sort(order.begin(), order.end());
        std::vector<std::int32_t> counts;
        std::vector<std::int32_t> indices;
        for (const auto& [authored, f] : order) {
            const Far::ConstIndexArray corners = level.GetFaceVertices(f);
            counts.push_back(corners.size());
            indices.insert(indices.end(), corners.begin(), corners.end());
            _levelFaces.push_back(f);
            result.authoredFaces.push_back(authored);
        }
        result.mesh.faceVertexCounts = std::move(counts);
        result.mesh.faceVertexIndices = std::move(indices);
        result.mesh.leftHanded = _mesh.leftHanded;
    }

    void AddPointsAndNormals() {
        const auto count = static_cast<std::size_t>(_refinement.Last().GetNumVertices());
        Tuples points(count, 3);
        Tuples normals(count, 3);
        _refinement.RefinePoints(points, normals);
        result.mesh.points = points.ToFloats();
        if (!_refinement.IsBilinear()) {
            AddNormals(points, normals);
        }
    }

    void AddPrimvar(const MeshAttribute& attribute, Interpolation authored, int channel) {
        Primvar refined;
        refined.name = attribute.name;
        refined.interpolation = authored;
        refined.numComponents = attribute.numComponents;
        switch (authored) {
        case Interpolation::Vertex:
            refined.values = _refinement.RefineVertex(attribute).ToFloats();
            break;
        case Interpolation::Varying:
            refined.values = _refinement.RefineVarying(attribute).ToFloats();
            break;
        case Interpolation::FaceVarying:
            refined.values = _refinement.RefineFaceVarying(attribute, channel).ToFloats();
            refined.indices = CornerValues(channel);
            break;
        case Interpolation::Uniform:
            refined.values = attribute.values;
            refined.indices = FaceValues(attribute);
            break;
        case Interpolation::Constant:
        case Interpolation::Instance:
            refined.values = attribute.values;
            refined.indices = attribute.indices;
            break;
        }
        result.mesh.primvars.push_back(std::move(refined));
    }

    RefinedMesh result;

private:
    std::vector<std::int32_t> CornerValues(int channel) const {
        std::vector<std::int32_t> indices;
        for (const int f : _levelFaces) {
            const Far::ConstIndexArray values = _refinement.Last().GetFaceFVarValues(f, channel);
            indices.insert(indices.end(), values.begin(), values.end());
        }
        return indices;
    }

    std::vector<std::int32_t> FaceValues(const MeshAttribute& attribute) const {
        std::vector<std::int32_t> indices;
        for (const std::uint32_t face : result.authoredFaces) {
            indices.push_back(static_cast<std::int32_t>(ValueIndex(attribute, face)));
        }
        return indices;
    }

    /// Limit normals, and at creases one value per corner.
    void AddNormals(const Tuples& points, const Tuples& normals) {
        const Far::TopologyLevel& level = _refinement.Last();
        const CreaseNormals creases(level, points, _mesh.leftHanded);
        std::vector<float> values = normals.ToFloats();
        std::vector<std::int32_t> indices;
        for (const int f : _levelFaces) {
            const Far::ConstIndexArray corners = level.GetFaceVertices(f);
            for (int k = 0; k < corners.size(); ++k) {
                if (!creases.IsCreased(corners[k])) {
                    indices.push_back(corners[k]);
                    continue;
                }
                const glm::vec3 normal(creases.At(corners[k], f));
                indices.push_back(static_cast<std::int32_t>(values.size() / 3));
                values.insert(values.end(), {normal.x, normal.y, normal.z});
            }
        }
        Primvar primvar;
        primvar.name = "normals";
        primvar.numComponents = 3;
        // Without creases every corner names its vertex.
        const bool isSmooth = values.size() == std::size_t(level.GetNumVertices()) * 3;
        primvar.interpolation = isSmooth ? Interpolation::Vertex : Interpolation::FaceVarying;
        primvar.values = std::move(values);
        if (!isSmooth) {
            primvar.indices = std::move(indices);
        }
        result.mesh.primvars.push_back(std::move(primvar));
    }

    const MeshDescription& _mesh;
    const SubdivCage& _cage;
    const Refinement& _refinement;
    std::vector<int> _levelFaces; ///< [refined faces] face of the last level
};

/// A checked primvar with its channel (faceVarying only).
struct CheckedPrimvar {
    MeshAttribute attribute;
    Interpolation interpolation;
    int channel = -1;
};

std::vector<CheckedPrimvar> CheckPrimvars(const MeshDescription& mesh, const SubdivCage& cage,
                                          std::vector<SubdivChannel>& channels,
                                          const std::string& primPath, Warnings& warnings) {
    TopologySize size{mesh.points.size() / 3, mesh.faceVertexCounts.size(), 0};
    for (const std::int32_t count : mesh.faceVertexCounts) {
        size.numCorners += static_cast<std::size_t>(std::max(count, 0));
    }
    std::vector<CheckedPrimvar> checked;
    for (const Primvar& primvar : mesh.primvars) {
        // Authored normals of a subdivision surface are ignored (UsdGeomMesh).
        if (primvar.name == "normals" || primvar.interpolation == Interpolation::Instance) {
            continue;
        }
        auto attribute = ValidatePrimvar(primvar, size, primPath, warnings);
        if (!attribute) {
            continue;
        }
        WarnNotFinite(*attribute, primPath, warnings);
        CheckedPrimvar entry{std::move(*attribute), primvar.interpolation, -1};
        if (primvar.interpolation == Interpolation::FaceVarying) {
            entry.channel = static_cast<int>(channels.size());
            SubdivChannel channel;
            channel.numValues =
                static_cast<int>(entry.attribute.values.size() / entry.attribute.numComponents);
            for (const std::uint32_t corner : cage.corners) {
                channel.valueIndices.push_back(
                    static_cast<int>(ValueIndex(entry.attribute, corner)));
            }
            channels.push_back(std::move(channel));
        }
        checked.push_back(std::move(entry));
    }
    return checked;
}

/// Why the mesh cannot be subdivided, or nothing.
std::string FindObstacle(const MeshDescription& mesh, const SubdivCage& cage, int level) {
    const double numFaces =
        4.0 * double(cage.indices.size()) * double(std::size_t(1) << (2 * level));
    if (numFaces > std::numeric_limits<std::int32_t>::max()) {
        return "too many faces at level " + std::to_string(level);
    }
    const bool hasOthers =
        std::any_of(cage.counts.begin(), cage.counts.end(), [](int count) { return count != 3; });
    if (mesh.subdivisionScheme == "loop" && hasOthers) {
        return "loop needs triangles only";
    }
    return {};
}

} // namespace

std::optional<RefinedMesh> RefineMesh(const MeshDescription& mesh, int level,
                                      const std::string& primPath, Warnings& warnings) {
    level = std::clamp(level, 1, kMaxRefineLevel);
    const SubdivCage cage = BuildSubdivCage(mesh, primPath, warnings);
    if (cage.faces.empty()) {
        return std::nullopt;
    }
    std::string obstacle = FindObstacle(mesh, cage, level);
    std::vector<SubdivChannel> channels;
    const auto primvars = CheckPrimvars(mesh, cage, channels, primPath, warnings);
    const auto refiner = obstacle.empty() ? CreateRefiner(mesh, cage, channels) : nullptr;
    if (!refiner) {
        obstacle = obstacle.empty() ? "OpenSubdiv refuses its topology" : obstacle;
        warnings.Add(primPath, "not subdivided: " + obstacle);
        return std::nullopt;
    }
    Far::TopologyRefiner::UniformOptions options(level);
    options.fullTopologyInLastLevel = true; // limits and creases look at a vertex's neighbours
    refiner->RefineUniform(options);
    const Refinement refinement(mesh, *refiner);
    RefinedBuilder builder(mesh, cage, refinement);
    builder.AddFaces();
    builder.AddPointsAndNormals();
    for (const CheckedPrimvar& primvar : primvars) {
        builder.AddPrimvar(primvar.attribute, primvar.interpolation, primvar.channel);
    }
    return std::move(builder.result);
}

} // namespace hds
