// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/polygonSource.h"

#include "hdStream/base/error.h"
#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/meshContent.h"
#include "hdStream/geometry/normals.h"
#include "hdStream/geometry/pointNumbering.h"
#include "hdStream/geometry/polygon.h"
#include "hdStream/geometry/triangleMesh.h"

#include <glm/common.hpp>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

namespace hds {
namespace {

/// Most triangles of a group: faces with more are cut into parts, so that chunks stay small.
constexpr std::uint32_t kMaxGroupTriangles = 256;

struct Face {
    std::uint32_t firstCorner = 0;
    std::uint32_t count = 0;
};

/// The first triangle of a part of a face.
struct FacePart {
    std::uint32_t face = 0;
    std::uint32_t firstTriangle = 0;
};

/// Extends a box by a face in one of its poses.
void ExtendByFace(const GeometryDescription& mesh, const SharedSpan<float>& points,
                  const Face& face, Bounds* bounds) {
    const std::int32_t* indices = mesh.faceVertexIndices.data() + face.firstCorner;
    for (std::uint32_t i = 0; i < face.count; ++i) {
        const float* p = points.data() + std::size_t(indices[i]) * 3;
        bounds->min = glm::min(bounds->min, glm::vec3(p[0], p[1], p[2]));
        bounds->max = glm::max(bounds->max, glm::vec3(p[0], p[1], p[2]));
    }
}

/// Reads faces and cuts them; scratch memory is kept from face to face. One object per thread.
class FaceCutter {
public:
    explicit FaceCutter(const GeometryDescription& mesh) : _mesh(mesh) {}

    void Load(const Face& face) {
        _count = face.count;
        _firstCorner = face.firstCorner;
        _points.resize(face.count);
        const std::int32_t* indices = _mesh.faceVertexIndices.data() + face.firstCorner;
        for (std::uint32_t i = 0; i < face.count; ++i) {
            const float* p = _mesh.points.data() + std::size_t(indices[i]) * 3;
            _points[i] = glm::dvec3(p[0], p[1], p[2]);
        }
    }

    /// Triangles of the loaded face, as numbers of its vertices.
    const glm::uvec3* Cut(std::uint32_t* numTriangles) {
        _triangles.resize(_count - 2);
        *numTriangles = _splitter.Split(_points.data(), _count, _triangles.data());
        return _triangles.data();
    }

    /// The number of triangles that Cut makes.
    std::uint32_t Count() {
        // Whichever diagonal a quad is cut along: nothing is lost.
        const glm::dvec3* p = _points.data();
        if (_count == 4 && !IsDegenerate(p[0], p[1], p[2]) && !IsDegenerate(p[0], p[2], p[3]) &&
            !IsDegenerate(p[0], p[1], p[3]) && !IsDegenerate(p[1], p[2], p[3])) {
            return 2;
        }
        std::uint32_t count = 0;
        Cut(&count);
        return count;
    }

    void Extend(Bounds* bounds) const {
        for (const glm::dvec3& point : _points) {
            bounds->min = glm::min(bounds->min, glm::vec3(point));
            bounds->max = glm::max(bounds->max, glm::vec3(point));
        }
        for (const ShutterKey& key : _mesh.keys) {
            ExtendByFace(_mesh, key.points, {_firstCorner, _count}, bounds);
        }
    }

private:
    const GeometryDescription& _mesh;
    std::uint32_t _firstCorner = 0;
    std::uint32_t _count = 0;
    PolygonSplitter _splitter;
    std::vector<glm::dvec3> _points;
    std::vector<glm::uvec3> _triangles;
};

/// What a block of faces comes to.
struct BlockMeasure {
    FaceProblems problems;
    Bounds bounds; ///< authored
    std::uint64_t numTriangles = 0;
    std::vector<std::uint32_t> leftOut; ///< faces that are not drawn
    std::vector<FacePart> parts;
};

class PolygonSource final : public ChunkSource {
public:
    PolygonSource(std::shared_ptr<const GeometryDescription> mesh, const std::string& primPath,
                  const Displacement& displacement, Warnings& warnings, bool keepsRest)
        : _mesh(std::move(mesh)), _displacement(displacement), _log(primPath, warnings),
          _keys(_mesh->keys.size()), _keepsRest(keepsRest) {
        const FaceTable table = BuildFaceTable(*_mesh);
        CheckHeader(*_mesh, table, _log);
        _isLeftHanded = _mesh->leftHanded;
        if (!IsCountable(*_mesh, table, _log)) {
            return;
        }
        _numVertices = _mesh->points.size() / 3;
        _size = {_mesh->points.size() / 3, table.numFaces, std::size_t(table.numCorners)};
        FindCorners(table);
        MeasureFaces(table, MarkHoles(*_mesh, _log));
        if (_numTriangles > 0) {
            ReadAttributes();
        }
    }

    std::uint32_t GroupTriangles(std::uint32_t group) const override {
        const FacePart part = PartOf(group);
        return IsLeftOut(part.face)
                   ? 0
                   : std::min(kMaxGroupTriangles, FaceAt(part.face).count - 2 - part.firstTriangle);
    }

    Bounds GroupBounds(std::uint32_t group) const override {
        const std::uint32_t index = PartOf(group).face;
        Bounds bounds;
        if (IsLeftOut(index)) {
            return bounds;
        }
        ExtendByFace(*_mesh, _mesh->points, FaceAt(index), &bounds);
        for (const ShutterKey& key : _mesh->keys) {
            ExtendByFace(*_mesh, key.points, FaceAt(index), &bounds);
        }
        const glm::vec3 origin(_origin); // exact, and so are the differences
        bounds.min -= origin + _reach;
        bounds.max -= origin - _reach;
        return bounds;
    }

    ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const override {
        std::call_once(_isRead, [this] {
            // Whoever waits here may hold a task of this very mesh: steal none.
            tbb::this_task_arena::isolate([this] { ReadValues(); });
        });
        ChunkGeometry chunk;
        std::size_t maxTriangles = 0;
        for (std::size_t i = 0; i < count; ++i) {
            maxTriangles += GroupTriangles(groups[i]);
        }
        chunk.attributes = _values;
        chunk.attributes.insert(chunk.attributes.end(), _rest.begin(), _rest.end());
        chunk.normals = _normals;
        chunk.triangles.reserve(maxTriangles);
        chunk.primIds.reserve(maxTriangles);
        chunk.faces.reserve(maxTriangles);
        chunk.corners.reserve(maxTriangles);
        PointNumbering numbering(std::min(maxTriangles * 3, _size.numPoints));
        FaceCutter cutter(*_mesh);
        for (std::size_t i = 0; i < count; ++i) {
            GatherGroup(groups[i], cutter, numbering, chunk);
        }
        GatherPositions(chunk.points, _mesh->points, _moved, &chunk.positions);
        chunk.keys.resize(_mesh->keys.size());
        for (std::size_t i = 0; i < chunk.keys.size(); ++i) {
            GatherPositions(chunk.points, _mesh->keys[i].points, _keys[i].moved,
                            &chunk.keys[i].positions);
            chunk.keys[i].normals = _keys[i].normals;
        }
        return chunk;
    }

    std::uint64_t TableBytes() const override {
        const bool isSmooth = !IsPolygonal(_mesh->subdivisionScheme);
        const std::uint64_t perPoint =
            (isSmooth ? sizeof(glm::vec3) : 0) + (_displacement.empty() ? 0 : sizeof(glm::vec3));
        return sizeof(*this) + VectorBytes(_cornerBegin, _parts, _entries) + _isLeftOut.size() / 8 +
               NumPoses() * _size.numPoints * perPoint;
    }

private:
    /// What ReadValues makes of a key.
    struct Key {
        std::vector<glm::vec3> moved; ///< [numPoints] displaced; empty: as authored
        SharedSpan<float> normals;    ///< of the elements of _normals; empty: as they are
    };

    std::size_t NumPoses() const { return 1 + _mesh->keys.size(); }

    /// \param moved all positions, if they are not where `authored` has them.
    void GatherPositions(const std::vector<std::uint32_t>& points,
                         const SharedSpan<float>& authored, const std::vector<glm::vec3>& moved,
                         std::vector<glm::vec3>* positions) const {
        positions->reserve(points.size());
        const glm::vec3 origin(_origin);
        for (const std::uint32_t point : points) {
            const float* p = authored.data() + std::size_t(point) * 3;
            positions->push_back(moved.empty() ? glm::vec3(p[0], p[1], p[2]) - origin
                                               : moved[point]);
        }
    }

    bool IsLeftOut(std::uint32_t face) const { return !_isLeftOut.empty() && _isLeftOut[face]; }

    Face FaceAt(std::uint32_t face) const {
        if (_cornerBegin.empty()) {
            return {face * _faceSize, _faceSize};
        }
        return {_cornerBegin[face], _cornerBegin[face + 1] - _cornerBegin[face]};
    }

    FacePart PartOf(std::uint32_t group) const {
        HDS_VERIFY(group < _numGroups, std::to_string(group) + " of " + std::to_string(_numGroups));
        const auto numFaces = static_cast<std::uint32_t>(_size.numFaces);
        return group < numFaces ? FacePart{group, 0} : _parts[group - numFaces];
    }

    /// Where the face-vertices of each face begin; nothing is kept when all faces are alike.
    void FindCorners(const FaceTable& table) {
        const auto& counts = _mesh->faceVertexCounts;
        _faceSize = counts.empty() ? 0U : static_cast<std::uint32_t>(std::max(counts[0], 0));
        const bool isUniform = std::all_of(counts.begin(), counts.end(),
                                           [&](std::int32_t n) { return n == counts[0]; });
        if (isUniform) {
            return;
        }
        _cornerBegin.resize(table.numFaces + 1);
        tbb::parallel_for(std::size_t{0}, table.NumBlocks(), [&](std::size_t block) {
            auto corner = static_cast<std::uint32_t>(table.cornerBegin[block]);
            const std::size_t begin = block * FaceTable::kFacesPerBlock;
            const std::size_t end = std::min(begin + FaceTable::kFacesPerBlock, table.numFaces);
            for (std::size_t face = begin; face < end; ++face) {
                _cornerBegin[face] = corner;
                corner += static_cast<std::uint32_t>(std::max(counts[face], 0));
            }
        });
        _cornerBegin.back() = static_cast<std::uint32_t>(table.numCorners);
    }

    void MeasureFace(std::uint32_t index, FaceCutter& cutter, BlockMeasure& block) const {
        const Face face = FaceAt(index);
        const FaceUse use = CheckFace(*_mesh, face.firstCorner, face.count);
        block.problems.Count(use);
        std::uint32_t numTriangles = 0;
        if (use == FaceUse::Usable) {
            cutter.Load(face);
            numTriangles = cutter.Count();
            block.problems.zeroArea += numTriangles == 0 ? 1 : 0;
        }
        if (numTriangles == 0) {
            block.leftOut.push_back(index);
            return;
        }
        cutter.Extend(&block.bounds);
        block.numTriangles += numTriangles;
        for (std::uint32_t first = kMaxGroupTriangles; first < face.count - 2;
             first += kMaxGroupTriangles) {
            block.parts.push_back({index, first});
        }
    }

    /// What is drawn, and where it is.
    void MeasureFaces(const FaceTable& table, const std::vector<std::uint8_t>& isHole) {
        std::vector<BlockMeasure> blocks(table.NumBlocks());
        tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
            FaceCutter cutter(*_mesh);
            const std::size_t begin = block * FaceTable::kFacesPerBlock;
            const std::size_t end = std::min(begin + FaceTable::kFacesPerBlock, table.numFaces);
            for (std::size_t face = begin; face < end; ++face) {
                if (!isHole.empty() && isHole[face] != 0) {
                    blocks[block].leftOut.push_back(static_cast<std::uint32_t>(face));
                } else {
                    MeasureFace(static_cast<std::uint32_t>(face), cutter, blocks[block]);
                }
            }
        });
        FaceProblems problems;
        for (const BlockMeasure& block : blocks) {
            problems.Add(block.problems);
            _numTriangles += block.numTriangles;
            _bounds.min = glm::min(_bounds.min, block.bounds.min);
            _bounds.max = glm::max(_bounds.max, block.bounds.max);
            _parts.insert(_parts.end(), block.parts.begin(), block.parts.end());
            if (!block.leftOut.empty()) {
                _isLeftOut.resize(table.numFaces);
            }
            for (const std::uint32_t face : block.leftOut) {
                _isLeftOut[face] = true;
            }
        }
        problems.Warn(_log.PrimPath(), _log.Sink());
        if (_numTriangles > 0) {
            const glm::vec3 origin = ChooseOrigin(_bounds);
            _origin = glm::dvec3(origin);
            _bounds.min -= origin;
            _bounds.max -= origin;
            _numGroups = static_cast<std::uint32_t>(table.numFaces + _parts.size());
        }
    }

    void ReadAttributes() {
        _entries = AssignSubsets(*_mesh, _log);
        _values = CollectAttributes(*_mesh, _size, _log);
        for (const GeometryAttribute& attribute : _values) {
            _attributes.push_back({attribute.name, attribute.numComponents});
        }
        std::optional<Interpolation> normals;
        if (!IsPolygonal(_mesh->subdivisionScheme)) {
            normals = Interpolation::Vertex;
        } else if (auto authored = AuthoredNormals(*_mesh, _size, _log)) {
            normals = authored->interpolation;
            _normals = std::move(*authored);
        }
        if (!_displacement.empty()) {
            SetReach();
        }
        std::vector<GeometryAttribute> attributes = _values;
        if (_keepsRest && _keys.empty() && _range.low != _range.high) {
            DescribeRest(normals.has_value());
            attributes.insert(attributes.end(), _rest.begin(), _rest.end());
        }
        _boundBytes = BoundTriangleBytes(attributes, normals, !_entries.empty(), NumPoses());
        _meanBytes = MeanTriangleBytes(attributes, normals, !_entries.empty(), NumPoses(),
                                       VerticesPerTriangle(_size.numPoints, _numTriangles));
    }

    /// The attributes of which ReadValues makes the values.
    void DescribeRest(bool hasNormals) {
        for (const char* name : {kMovedBy, kRestNormals}) {
            if (name == kMovedBy || hasNormals) {
                GeometryAttribute& attribute = _rest.emplace_back();
                attribute.name = name;
                attribute.interpolation = Interpolation::Vertex;
                attribute.numComponents = 3;
                _attributes.push_back({attribute.name, attribute.numComponents});
            }
        }
    }

    /// How far displacement moves points at most, with the rounding of what is moved.
    void SetReach() {
        const std::size_t numEntries = 1 + _mesh->subsets.size();
        const std::vector<BoundAmount> amounts = BindAmounts(_displacement, _values);
        _range = RangeOf(amounts, _values, *_mesh, _displacement.size() < numEntries);
        if (LacksCoordinates(amounts)) {
            _log.Warn(kNoCoordinates);
        }
        const glm::vec3 far = glm::max(glm::abs(_bounds.min), glm::abs(_bounds.max));
        const double most = std::max(std::abs(_range.low), std::abs(_range.high));
        constexpr double kRounding = 1.0 / (1U << 20U);
        _reach = static_cast<float>(
            most + kRounding * (most + static_cast<double>(std::max({far.x, far.y, far.z}))));
        _bounds.min -= _reach;
        _bounds.max += _reach;
    }

    /// Moves the points of a pose along the smooth normals of the mesh as it was, and by vectors.
    /// \param rest values of _rest; may be null \return smooth normals of the moved mesh, where
    /// those are the mesh's.
    std::optional<GeometryAttribute> Displace(const SharedSpan<float>& points,
                                              std::vector<glm::vec3>* moved,
                                              std::vector<GeometryAttribute>* rest) const {
        TriangleMesh whole = Whole(points);
        const GeometryAttribute smooth = ComputeSmoothNormals(whole);
        const std::vector<float> amounts =
            PointAmounts(*_mesh, points, _range, _entries, _values, _displacement);
        const std::vector<glm::dvec3> vectors =
            PointVectors(*_mesh, points, smooth, _range, _entries, _values, _displacement);
        std::vector<float> movedBy;
        for (std::size_t i = 0; i < whole.positions.size(); ++i) {
            const float* n = ValueOf(smooth, i);
            const glm::dvec3 before(whole.positions[i]);
            glm::dvec3 position =
                before + static_cast<double>(amounts[i]) * glm::dvec3(n[0], n[1], n[2]);
            position += vectors.empty() ? glm::dvec3(0.0) : vectors[i];
            const glm::vec3 way(position - before);
            movedBy.insert(movedBy.end(), &way.x, &way.x + 3);
            whole.positions[i] = glm::vec3(position);
        }
        if (rest != nullptr && !rest->empty()) {
            (*rest)[0].values = std::move(movedBy);
            if (rest->size() > 1) {
                (*rest)[1].values = smooth.values;
                (*rest)[1].indices = smooth.indices;
            }
        }
        std::optional<GeometryAttribute> normals;
        if (!_normals.values.empty() || !IsPolygonal(_mesh->subdivisionScheme)) {
            normals = ComputeSmoothNormals(whole);
        }
        *moved = std::move(whole.positions);
        return normals;
    }

    /// The whole mesh with the points of a pose, relative to the source's origin.
    TriangleMesh Whole(const SharedSpan<float>& points) const {
        GeometryDescription posed = *_mesh;
        posed.points = points;
        Warnings unheard;
        TriangleMesh whole = *Triangulate(posed, _log.PrimPath(), unheard);
        const glm::vec3 change(whole.origin - _origin);
        if (change != glm::vec3(0.0F)) { // never of a mesh at rest
            for (glm::vec3& position : whole.positions) {
                position += change;
            }
        }
        return whole;
    }

    /// What moves with the points: of a displaced mesh its positions, and normals that follow from
    /// them. \param isRepaired authored normals have become others, which stay.
    void ReadKeys(bool isRepaired) const {
        for (std::size_t i = 0; i < _keys.size(); ++i) {
            const ShutterKey& key = _mesh->keys[i];
            if (!_displacement.empty()) {
                const auto normals = Displace(key.points, &_keys[i].moved, nullptr);
                _keys[i].normals = normals ? normals->values : SharedSpan<float>();
            } else if (!IsPolygonal(_mesh->subdivisionScheme)) {
                _keys[i].normals = Whole(key.points).normals.values;
            } else if (!isRepaired && key.normals.size() == _normals.values.size()) {
                _keys[i].normals = key.normals;
            }
        }
    }

    /// All that must read every value of the mesh; before the first chunk.
    void ReadValues() const {
        for (const GeometryAttribute& attribute : _values) {
            WarnNotFinite(attribute, _log.PrimPath(), _log.Sink());
        }
        const bool isSmooth = !IsPolygonal(_mesh->subdivisionScheme);
        const bool isAuthored =
            !_normals.values.empty() && _normals.interpolation != Interpolation::Constant;
        if (isAuthored) {
            WarnNotFinite(_normals, _log.PrimPath(), _log.Sink());
        }
        const bool mustRepair = isAuthored && HasUnusableNormals(_normals);
        ReadKeys(mustRepair);
        if (!isSmooth && !mustRepair && _displacement.empty()) {
            return;
        }
        if (!_displacement.empty()) {
            if (auto normals = Displace(_mesh->points, &_moved, &_rest)) {
                _normals = std::move(*normals);
            }
            return;
        }
        TriangleMesh whole = Whole(_mesh->points);
        if (isSmooth) {
            _normals = std::move(whole.normals);
        } else {
            RepairAuthoredNormals(whole, _size, _normals, _log);
        }
    }

    void GatherGroup(std::uint32_t group, FaceCutter& cutter, PointNumbering& numbering,
                     ChunkGeometry& chunk) const {
        const FacePart part = PartOf(group);
        if (IsLeftOut(part.face)) {
            return;
        }
        const Face face = FaceAt(part.face);
        cutter.Load(face);
        std::uint32_t numTriangles = 0;
        const glm::uvec3* triangles = cutter.Cut(&numTriangles);
        const std::uint32_t end = std::min(numTriangles, part.firstTriangle + kMaxGroupTriangles);
        const std::int32_t* indices = _mesh->faceVertexIndices.data() + face.firstCorner;
        for (std::uint32_t i = part.firstTriangle; i < end; ++i) {
            glm::uvec3 local;
            for (int k = 0; k < 3; ++k) {
                const auto point = static_cast<std::uint32_t>(indices[triangles[i][k]]);
                local[k] = numbering.Number(point, chunk.points);
            }
            chunk.triangles.push_back(local);
            chunk.primIds.push_back(face.firstCorner +
                                    i); // a face has fewer triangles than corners
            chunk.faces.push_back(part.face);
            chunk.corners.push_back(triangles[i] + face.firstCorner);
            if (!_entries.empty()) {
                chunk.materialEntries.push_back(_entries[part.face]);
            }
        }
    }

    std::shared_ptr<const GeometryDescription> _mesh;
    Displacement _displacement;
    AmountRange _range;  ///< of displacement
    float _reach = 0.0F; ///< of displacement
    mutable PrimLog _log;
    TopologySize _size;
    std::uint32_t _faceSize = 0;             ///< when all faces are alike
    std::vector<std::uint32_t> _cornerBegin; ///< [numFaces + 1], else
    std::vector<bool> _isLeftOut;            ///< [numFaces]; empty: none
    std::vector<FacePart> _parts;            ///< groups beyond the faces
    std::vector<std::uint32_t> _entries;     ///< [numFaces] material entries; empty: all 0
    std::vector<GeometryAttribute> _values;  ///< user primvars
    mutable std::once_flag _isRead;
    mutable GeometryAttribute _normals;    ///< final once ReadValues has run
    mutable std::vector<glm::vec3> _moved; ///< [numPoints] displaced; empty: as authored
    mutable std::vector<Key> _keys;        ///< of _mesh->keys
    bool _keepsRest;
    mutable std::vector<GeometryAttribute> _rest; ///< kMovedBy, kRestNormals; values as _normals'
};

} // namespace

std::shared_ptr<const ChunkSource>
MakePolygonSource(std::shared_ptr<const GeometryDescription> mesh, const std::string& primPath,
                  const Displacement& displacement, Warnings& warnings, bool keepsRest) {
    return std::make_shared<const PolygonSource>(std::move(mesh), primPath, displacement, warnings,
                                                 keepsRest);
}

} // namespace hds
