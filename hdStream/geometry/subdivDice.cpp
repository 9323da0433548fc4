// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/subdivDice.h"

#include "hdStream/geometry/dicing.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <iterator>
#include <optional>
#include <unordered_map>

namespace hds {
namespace {

namespace Far = OpenSubdiv::Far;

constexpr std::uint32_t kNone = 0xffffffffU;
/// primIds are 32 bits; the last value means none.
constexpr std::uint64_t kMaxTriangles = 0xffffffffU;

void Append(const glm::dvec3& value, std::vector<float>& values) {
    values.insert(values.end(), {float(value.x), float(value.y), float(value.z)});
}

/// Builds a chunk, group by group.
class ChunkBuilder {
public:
    explicit ChunkBuilder(const SubdivDice& dice)
        : _dice(dice), _model(*dice.model), _points(_model, dice.displacement, dice.entries) {
        for (const SubdivPrimvar& primvar : _model.Primvars()) {
            _hasCornerValues =
                _hasCornerValues || primvar.attribute.interpolation == Interpolation::FaceVarying;
        }
        _values.resize(_model.Primvars().size());
        for (const auto& model : dice.keyModels) {
            _keys.push_back(
                {std::make_unique<SubdivPoints>(*model, dice.displacement, dice.entries), {}, {}});
        }
        _chunk.keys.resize(_keys.size());
    }

    void AddGroup(std::uint32_t group) {
        const int face = _dice.FaceOf(group);
        StartFace(face);
        const DicePattern& pattern = *_pattern;
        _triangles.clear();
        pattern.AddTile(group - _dice.faceGroups[std::size_t(face)], _triangles);
        const std::uint32_t authored = _model.Cage().faces[std::size_t(face)];
        for (std::size_t i = 0; i < _triangles.size(); ++i) {
            glm::uvec3 triangle;
            glm::uvec3 corners;
            for (int k = 0; k < 3; ++k) {
                triangle[k] = Vertex(pattern, _triangles[i][k]);
                corners[k] = _cornerOf[_triangles[i][k]];
            }
            if (!HasArea(triangle)) {
                continue;
            }
            _chunk.triangles.push_back(triangle);
            _chunk.corners.push_back(corners);
            _chunk.primIds.push_back(_dice.groupTriangles[group] + std::uint32_t(i));
            _chunk.faces.push_back(authored);
            if (!_dice.entries.empty()) {
                _chunk.materialEntries.push_back(_dice.entries[authored]);
            }
        }
    }

    ChunkGeometry Finish() {
        _chunk.points.resize(_chunk.positions.size());
        for (std::size_t i = 0; i < _chunk.points.size(); ++i) {
            _chunk.points[i] = static_cast<std::uint32_t>(i);
        }
        FinishNormals();
        std::vector<GeometryAttribute> rest = TakeRest();
        for (std::size_t i = 0; i < _values.size(); ++i) {
            GeometryAttribute attribute = _model.Primvars()[i].attribute;
            const Interpolation interpolation = attribute.interpolation;
            if (interpolation == Interpolation::Vertex || interpolation == Interpolation::Varying ||
                interpolation == Interpolation::FaceVarying) {
                attribute.values = std::move(_values[i]);
                attribute.indices = {};
            }
            if (interpolation == Interpolation::Varying) {
                attribute.interpolation = Interpolation::Vertex;
            }
            _chunk.attributes.push_back(std::move(attribute));
        }
        std::move(rest.begin(), rest.end(), std::back_inserter(_chunk.attributes));
        return std::move(_chunk);
    }

private:
    /// A pose after the opening of the shutter.
    struct Key {
        std::unique_ptr<SubdivPoints> points;
        std::vector<float> normals;     ///< as _normals
        std::vector<float> sideNormals; ///< as _sideNormals
    };

    void StartFace(int face) {
        if (face == _face) {
            return;
        }
        _face = face;
        _dice.FaceLevels(face, _levels);
        _pattern.emplace(_model.Shape(face), std::uint32_t(_levels.size()), _levels.data());
        _vertexOf.assign(_pattern->NumVertices(), kNone);
        _cornerOf.assign(_pattern->NumVertices(), kNone);
    }

    /// Chunk vertex of a vertex of the face's pattern.
    std::uint32_t Vertex(const DicePattern& pattern, std::uint32_t index) {
        std::uint32_t& vertex = _vertexOf[index];
        if (vertex != kNone) {
            return vertex;
        }
        const PatternVertex location = pattern.Locate(index);
        switch (location.kind) {
        case PatternVertex::Kind::Corner:
            vertex = CornerVertex(location.index);
            break;
        case PatternVertex::Kind::Edge:
            vertex = EdgeVertex(location);
            break;
        case PatternVertex::Kind::Inside:
            vertex = AddVertex(
                [&](SubdivPoints& points) {
                    return points.Inside({_face, location.at});
                },
                {_face, location.at});
            break;
        }
        _cornerOf[index] = AddCorner(location, vertex);
        return vertex;
    }

    std::uint32_t CornerVertex(std::uint32_t corner) {
        const int point = _model.Level().GetFaceVertices(_face)[int(corner)];
        const auto [found, isNew] = _shared.emplace(std::uint64_t(point), 0U);
        if (isNew) {
            found->second = AddVertex([&](SubdivPoints& points) { return points.Vertex(point); },
                                      _points.AtVertex(point));
        }
        return found->second;
    }

    std::uint32_t EdgeVertex(const PatternVertex& location) {
        const Far::TopologyLevel& level = _model.Level();
        const int edge = level.GetFaceEdges(_face)[int(location.index)];
        const std::uint32_t rate = 1U << _levels[location.index];
        const bool isForward =
            level.GetFaceVertices(_face)[int(location.index)] == level.GetEdgeVertices(edge)[0];
        const std::uint32_t step = isForward ? location.step : rate - location.step;
        const std::uint64_t key =
            (std::uint64_t(edge) << DicePattern::kMaxLevel | step) | std::uint64_t(1) << 63U;
        const auto [found, isNew] = _shared.emplace(key, 0U);
        if (isNew) {
            const double t = double(step) / double(rate);
            found->second = AddVertex([&](SubdivPoints& points) { return points.Edge(edge, t); },
                                      _points.OnEdge(edge, t));
        }
        return found->second;
    }

    /// \param evaluate the point, from either model.
    template <typename Evaluate>
    std::uint32_t AddVertex(const Evaluate& evaluate, const FaceLocation& owner) {
        const auto vertex = static_cast<std::uint32_t>(_chunk.positions.size());
        const auto add = [&](SubdivPoints& points, std::vector<glm::vec3>& positions,
                             std::vector<float>& normals) {
            const SurfacePoint point = evaluate(points);
            positions.emplace_back(point.position - _dice.origin);
            if (!_model.IsFlat()) {
                Append(point.normal, normals);
            }
            return point;
        };
        const SurfacePoint opening = add(_points, _chunk.positions, _normals);
        if (_dice.keepsRest) {
            Append(opening.movedBy, _movedBy);
            Append(opening.restNormal, _restNormals);
        }
        for (std::size_t i = 0; i < _keys.size(); ++i) {
            add(*_keys[i].points, _chunk.keys[i].positions, _keys[i].normals);
        }
        const int vertexSize = _model.VertexRows().rowSize;
        const int varyingSize = _model.VaryingRows().rowSize;
        FaceSurface& surface = _points.Surface(owner.face);
        if (vertexSize > 0) {
            _vertexRow.resize(std::size_t(vertexSize));
            surface.VertexValues(owner.at, _vertexRow.data());
        }
        if (varyingSize > 0) {
            _varyingRow.resize(std::size_t(varyingSize));
            surface.VaryingValues(owner.at, _varyingRow.data());
        }
        for (std::size_t i = 0; i < _values.size(); ++i) {
            const SubdivPrimvar& primvar = _model.Primvars()[i];
            if (primvar.attribute.interpolation == Interpolation::Vertex) {
                AppendRow(_vertexRow, primvar, _values[i]);
            } else if (primvar.attribute.interpolation == Interpolation::Varying) {
                AppendRow(_varyingRow, primvar, _values[i]);
            }
        }
        return vertex;
    }

    static void AppendRow(const std::vector<double>& row, const SubdivPrimvar& primvar,
                          std::vector<float>& values) {
        for (std::uint32_t c = 0; c < primvar.attribute.numComponents; ++c) {
            values.push_back(float(row[std::size_t(primvar.offset) + c]));
        }
    }

    /// What the face has at a vertex of its own: faceVarying values, the normal of its side.
    std::uint32_t AddCorner(const PatternVertex& location, std::uint32_t vertex) {
        const auto corner = static_cast<std::uint32_t>(_cornerNormals.size());
        _cornerNormals.push_back(static_cast<std::int32_t>(vertex));
        if (const auto side = SideNormal(_points, location)) {
            _cornerNormals.back() = -1 - static_cast<std::int32_t>(_sideNormals.size() / 3);
            Append(*side, _sideNormals);
            if (_dice.keepsRest) {
                Append(_points.RestNormal({_face, location.at}), _sideRestNormals);
            }
            for (Key& key : _keys) {
                Append(*SideNormal(*key.points, location), key.sideNormals);
            }
        }
        if (_hasCornerValues) {
            for (std::size_t i = 0; i < _values.size(); ++i) {
                const SubdivPrimvar& primvar = _model.Primvars()[i];
                if (primvar.channel >= 0) {
                    _vertexRow.resize(std::max<std::size_t>(4, _vertexRow.size()));
                    _points.Surface(_face).ChannelValues(primvar.channel, location.at,
                                                         _vertexRow.data());
                    AppendRow(_vertexRow, primvar, _values[i]);
                }
            }
        }
        return corner;
    }

    /// Nothing where all faces share the vertex's normal, which depends on the topology alone.
    std::optional<glm::dvec3> SideNormal(SubdivPoints& points, const PatternVertex& location) {
        const Far::TopologyLevel& level = _model.Level();
        const auto index = static_cast<int>(location.index);
        if (_model.IsFlat() || location.kind == PatternVertex::Kind::Inside) {
            return std::nullopt;
        }
        if (location.kind == PatternVertex::Kind::Edge) {
            if (!_model.IsSharpEdge(level.GetFaceEdges(_face)[index])) {
                return std::nullopt;
            }
            return points.EdgeSideNormal({_face, location.at});
        }
        const int point = level.GetFaceVertices(_face)[index];
        if (!_model.IsSharpVertex(point)) {
            return std::nullopt;
        }
        return points.VertexSideNormal(point, _face);
    }

    /// As Triangulate: no area once rounded to float, in any pose.
    bool HasArea(const glm::uvec3& triangle) const {
        return HasArea(_chunk.positions, triangle) ||
               std::any_of(_chunk.keys.begin(), _chunk.keys.end(),
                           [&](const ChunkKey& key) { return HasArea(key.positions, triangle); });
    }

    static bool HasArea(const std::vector<glm::vec3>& positions, const glm::uvec3& triangle) {
        const glm::dvec3 p0(positions[triangle.x]);
        const glm::vec3 cross(glm::cross(glm::dvec3(positions[triangle.y]) - p0,
                                         glm::dvec3(positions[triangle.z]) - p0));
        return cross != glm::vec3(0.0F);
    }

    void FinishNormals() {
        if (_model.IsFlat()) {
            return;
        }
        GeometryAttribute& normals = _chunk.normals;
        normals.name = "normals";
        normals.numComponents = 3;
        normals.interpolation = Interpolation::Vertex;
        if (!_sideNormals.empty()) {
            const auto numVertices = static_cast<std::int32_t>(_chunk.positions.size());
            for (std::int32_t& index : _cornerNormals) {
                index = index >= 0 ? index : numVertices - 1 - index;
            }
            _normals.insert(_normals.end(), _sideNormals.begin(), _sideNormals.end());
            for (Key& key : _keys) {
                key.normals.insert(key.normals.end(), key.sideNormals.begin(),
                                   key.sideNormals.end());
            }
            normals.interpolation = Interpolation::FaceVarying;
            normals.indices = std::move(_cornerNormals);
        }
        normals.values = std::move(_normals);
        for (std::size_t i = 0; i < _keys.size(); ++i) {
            _chunk.keys[i].normals = std::move(_keys[i].normals);
        }
    }

    /// What shading needs to know of the undisplaced surface; \pre the normals are finished.
    std::vector<GeometryAttribute> TakeRest() {
        std::vector<GeometryAttribute> rest;
        if (!_dice.keepsRest) {
            return rest;
        }
        GeometryAttribute movedBy;
        movedBy.name = kMovedBy;
        movedBy.numComponents = 3;
        movedBy.interpolation = Interpolation::Vertex;
        movedBy.values = std::move(_movedBy);
        rest.push_back(std::move(movedBy));
        if (!_model.IsFlat()) {
            GeometryAttribute normals = _chunk.normals; // per corner where those are
            normals.name = kRestNormals;
            _restNormals.insert(_restNormals.end(), _sideRestNormals.begin(),
                                _sideRestNormals.end());
            normals.values = std::move(_restNormals);
            rest.push_back(std::move(normals));
        }
        return rest;
    }

    const SubdivDice& _dice;
    const SubdivModel& _model;
    SubdivPoints _points;
    std::vector<Key> _keys;
    ChunkGeometry _chunk;
    bool _hasCornerValues = false;

    int _face = -1;
    std::vector<std::uint8_t> _levels;
    std::optional<DicePattern> _pattern;
    std::vector<std::uint32_t> _vertexOf; ///< [pattern vertices] chunk vertex
    std::vector<std::uint32_t> _cornerOf; ///< [pattern vertices] chunk corner
    std::vector<glm::uvec3> _triangles;
    std::unordered_map<std::uint64_t, std::uint32_t> _shared; ///< of cage vertices and edges

    std::vector<float> _normals;              ///< [vertices][3]
    std::vector<std::int32_t> _cornerNormals; ///< [corners] vertex, or -1 - side normal
    std::vector<float> _sideNormals;
    std::vector<float> _movedBy; ///< as _normals, with the next two: of the opening
    std::vector<float> _restNormals;
    std::vector<float> _sideRestNormals;     ///< as _sideNormals
    std::vector<std::vector<float>> _values; ///< by primvar
    std::vector<double> _vertexRow;
    std::vector<double> _varyingRow;
};

} // namespace

void SubdivDice::FaceLevels(int face, std::vector<std::uint8_t>& levels) const {
    const Far::ConstIndexArray edges = model->Level().GetFaceEdges(face);
    levels.resize(std::size_t(edges.size()));
    for (int i = 0; i < edges.size(); ++i) {
        levels[std::size_t(i)] = edgeLevels[std::size_t(edges[i])];
    }
}

SubdivDice::Counts SubdivDice::NumberGroups() {
    const auto numFaces = static_cast<int>(model->NumFaces());
    std::vector<std::uint8_t> levels;
    for (std::uint8_t bound = kMaxDicingLevel;; --bound) {
        Counts counts;
        counts.vertices = static_cast<std::uint64_t>(model->Level().GetNumVertices());
        for (std::uint8_t& level : edgeLevels) {
            level = std::min(level, bound);
            counts.vertices += (1U << level) - 1U;
        }
        faceGroups.assign(1, 0);
        groupTriangles.assign(1, 0);
        for (int face = 0; face < numFaces && counts.triangles < kMaxTriangles; ++face) {
            if (model->IsDrawn(face)) {
                FaceLevels(face, levels);
                const DicePattern pattern(model->Shape(face), std::uint32_t(levels.size()),
                                          levels.data());
                counts.vertices += pattern.NumInside();
                for (std::uint32_t tile = 0; tile < pattern.NumTiles(); ++tile) {
                    counts.triangles += pattern.TileTriangles(tile);
                    groupTriangles.push_back(static_cast<std::uint32_t>(counts.triangles));
                }
            }
            faceGroups.push_back(static_cast<std::uint32_t>(groupTriangles.size() - 1));
        }
        if (counts.triangles < kMaxTriangles || bound == 0) {
            return counts;
        }
    }
}

int SubdivDice::FaceOf(std::uint32_t group) const {
    const auto next = std::upper_bound(faceGroups.begin(), faceGroups.end(), group);
    return static_cast<int>(next - faceGroups.begin()) - 1;
}

ChunkGeometry DiceGroups(const SubdivDice& dice, const std::uint32_t* groups, std::size_t count) {
    ChunkBuilder builder(dice);
    std::for_each(groups, groups + count, [&](std::uint32_t group) { builder.AddGroup(group); });
    return builder.Finish();
}

} // namespace hds
