// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/curveSource.h"

#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/curveRuns.h"
#include "hdStream/geometry/curveSegments.h"
#include "hdStream/geometry/curveStates.h"
#include "hdStream/geometry/solidContent.h"
#include "kernels/shared/geometry.h"

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

namespace hds {
namespace {

/// Segments of a group: neighbours in it share vertices, and its box should stay small.
constexpr std::uint32_t kGroupSegments = 16;
/// A piece turns by at most so much (radians): a round one has one minimum of t, a flat one looks
/// smooth.
constexpr double kRoundTurn = 0.35;
constexpr double kRibbonTurn = 0.1;

class CurveSource final : public ChunkSource {
public:
    CurveSource(std::shared_ptr<const GeometryDescription> curves, const std::string& primPath,
                Warnings& warnings)
        : _log(primPath, warnings), _runs(std::move(curves), _log), _basis(_runs.Basis()) {
        _origin = _runs.Origin();
        _values = SolidAttributes(_runs.Curves(), _runs.Size(), _log);
        for (const GeometryAttribute& attribute : _values) {
            _attributes.push_back({attribute.name, attribute.numComponents});
        }
        if (_runs.Size().numPoints >= 0xffffffffU || _runs.Size().numJoints >= 0xffffffffU) {
            _log.Warn("curves dropped: more than 2^32 - 2 points");
            return;
        }
        CutCurves();
        MeasureSegments();
        double mostVertices = 5.0; // of a group, for each of its pieces
        for (std::uint32_t group = 0; group < _numGroups; ++group) {
            if (const double numPieces = GroupTriangles(group); numPieces > 0.0) { // as Gather
                const std::uint64_t vertices = GroupVertices(_groups[group]);
                _numVertices += vertices;
                mostVertices = std::max(mostVertices, static_cast<double>(vertices) / numPieces);
            }
        }
        const std::size_t vertexBytes =
            ((_runs.HasNormals() ? 4 : 0) + 4 * _runs.NumPoses()) * sizeof(float);
        _boundBytes = SolidBytes(_values, mostVertices, vertexBytes, _runs.NumPoses(), false);
        _meanBytes =
            SolidBytes(_values,
                       std::min(mostVertices,
                                static_cast<double>(_numVertices) /
                                    static_cast<double>(std::max<std::uint64_t>(1, _numTriangles))),
                       vertexBytes, _runs.NumPoses(), true);
    }

    std::uint32_t GroupTriangles(std::uint32_t group) const override {
        return _groups[group + 1].firstPrimId - _groups[group].firstPrimId;
    }
    Bounds GroupBounds(std::uint32_t group) const override { return _groupBounds[group]; }
    std::uint64_t TableBytes() const override {
        return sizeof(*this) - sizeof(_runs) + _runs.TableBytes() +
               VectorBytes(_groups, _groupBounds, _states);
    }

    ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const override {
        std::call_once(_isRead, [this] { ReadValues(); });
        ChunkGeometry chunk;
        chunk.primitives = _basis.Primitives();
        chunk.keys.resize(_runs.NumPoses() - 1);
        chunk.attributes = _values;
        for (std::size_t i = 0; i < count; ++i) {
            if (GroupTriangles(groups[i]) > 0) {
                GatherGroup(groups[i], &chunk);
            }
        }
        return chunk;
    }

private:
    struct Group {
        std::uint32_t curve;
        std::uint32_t firstSegment; ///< in the curve
        std::uint32_t numSegments;
        std::uint32_t firstPrimId; ///< of the curve's pieces
        std::uint64_t firstState;  ///< of its segments, in _states
    };
    using Points = CurveRuns::Points;

    void CutCurves() {
        std::uint64_t firstState = 0;
        for (std::uint32_t curve = 0; curve < _runs.NumCurves(); ++curve) {
            const std::uint32_t numSegments = _runs.NumSegments(curve);
            for (std::uint32_t first = 0; first < numSegments; first += kGroupSegments) {
                const std::uint32_t count = std::min(kGroupSegments, numSegments - first);
                _groups.push_back({curve, first, count, 0, firstState});
                firstState += count;
            }
        }
        _numGroups = static_cast<std::uint32_t>(_groups.size());
        _states.resize(firstState);
        _groupBounds.resize(_numGroups);
    }

    /// How many pieces each segment has, and the boxes of groups.
    void MeasureSegments() {
        tbb::parallel_for(std::uint32_t{0}, _numGroups, [this](std::uint32_t index) {
            const Group& group = _groups[index];
            for (std::uint32_t i = 0; i < group.numSegments; ++i) {
                _states[group.firstState + i] = StateOf(group.curve, group.firstSegment + i);
                if (_states[group.firstState + i] != kDropped) {
                    for (const Points& shape :
                         _runs.ShapesOf(group.curve, group.firstSegment + i)) {
                        Extend(shape, &_groupBounds[index]);
                    }
                }
            }
        });
        for (const Group& group : _groups) {
            if (group.firstSegment == 0) {
                SettleStates(&_states[group.firstState], _runs.NumSegments(group.curve),
                             _basis.IsPeriodic());
            }
        }
        std::uint64_t numDropped = 0;
        for (Group& group : _groups) {
            group.firstPrimId = static_cast<std::uint32_t>(_numTriangles);
            for (std::uint32_t i = 0; i < group.numSegments; ++i) {
                const SegmentState state = _states[group.firstState + i];
                numDropped += state == kDropped ? 1 : 0;
                _numTriangles += IsDrawn(state) ? 1U << (state & kLevelBits) : 0U;
                _hasStanding = _hasStanding || (IsDrawn(state) && (state & kStands) != 0);
            }
        }
        _groups.push_back({0, 0, 0, static_cast<std::uint32_t>(_numTriangles), 0});
        if (numDropped > 0) {
            _log.Warn(std::to_string(numDropped) +
                      " segments dropped: points missing or not finite, or no width");
        }
        if (_numTriangles >= 0xffffffffU) {
            _log.Warn("curves dropped: more than 2^32 - 2 pieces");
            _numTriangles = 0;
            _numGroups = 0;
            _groupBounds.clear();
        }
        for (const Bounds& bounds : _groupBounds) {
            for (int axis = 0; axis < 3; ++axis) {
                _bounds.min[axis] = std::min(_bounds.min[axis], bounds.min[axis]);
                _bounds.max[axis] = std::max(_bounds.max[axis], bounds.max[axis]);
            }
        }
    }

    SegmentState StateOf(std::uint32_t curve, std::uint32_t segment) const {
        bool hasWidth = false;
        // The outer vertices of a straight segment are its neighbours'.
        const bool isLinear = (_basis.Primitives() & HDS_PRIMITIVE_BASIS) == HDS_PRIMITIVE_LINEAR;
        for (std::uint32_t k = isLinear ? 1 : 0; k < (isLinear ? 3U : 4U); ++k) {
            const RunVertex vertex = _runs.VertexOf(curve, _basis.FirstVertex(segment) + k);
            if (!HasPoint(_runs.Curves(), _runs.PointAt(curve, vertex.point))) {
                return kDropped;
            }
        }
        double turn = 0.0;
        bool isStill = !_runs.HasNormals();
        for (const Points& shape : _runs.ShapesOf(curve, segment)) {
            for (const glm::dvec4& point : shape) {
                hasWidth = hasWidth || point.w != 0.0;
                isStill = isStill && point == shape[0];
            }
            turn = std::max(turn,
                            TurnOfBezier(shape) / (_runs.HasNormals() ? kRibbonTurn : kRoundTurn));
        }
        if (!hasWidth || isStill) {
            return hasWidth ? kStill : kDropped;
        }
        if (_runs.HasNormals()) {
            const glm::dvec3 n0(_runs.JointNormal(curve, segment, 0));
            const glm::dvec3 n1(_runs.JointNormal(curve, segment, 1));
            turn += std::acos(std::clamp(glm::dot(n0, n1), -1.0, 1.0)) / kRibbonTurn;
        }
        std::uint8_t level = 0;
        while (level < HDS_MAX_PIECE_LEVEL && turn > static_cast<double>(1U << level)) {
            ++level;
        }
        return StandsBehind(curve, segment) ? level | kStands : level;
    }

    /// Whether the next segment begins at rest in some pose: the curve's derivative is 0 there.
    bool StandsBehind(std::uint32_t curve, std::uint32_t segment) const {
        const std::uint32_t basis = _basis.Primitives() & HDS_PRIMITIVE_BASIS;
        const bool isLast = !_basis.IsPeriodic() && segment + 1 == _runs.NumSegments(curve);
        if (_runs.HasNormals() || basis == HDS_PRIMITIVE_LINEAR || isLast) {
            return false;
        }
        const bool isBezier = basis == HDS_PRIMITIVE_BEZIER;
        const std::uint32_t first = _basis.FirstVertex(segment);
        for (std::size_t pose = 0; pose < _runs.NumPoses(); ++pose) {
            const glm::vec3 before(_runs.VertexAt(curve, first + (isBezier ? 3U : 1U), pose));
            const glm::vec3 behind(_runs.VertexAt(curve, first + (isBezier ? 4U : 3U), pose));
            if (before == behind) { // whatever the radii
                return true;
            }
        }
        return false;
    }

    static void Extend(const Points& shape, Bounds* bounds) {
        for (const glm::dvec4& point : shape) {
            ExtendBySolid(glm::dvec3(point), point.w, bounds);
        }
    }

    bool IsLast(const Group& group) const {
        return !_basis.IsPeriodic() &&
               group.firstSegment + group.numSegments == _runs.NumSegments(group.curve);
    }
    CurveStates StatesOf(const Group& group) const {
        return {_states.data() + group.firstState - group.firstSegment,
                _runs.NumSegments(group.curve), _basis.IsPeriodic()};
    }

    /// The vertices of its segments and of their neighbours, in their order.
    std::uint32_t RowVertices(const Group& group) const {
        const std::uint32_t count = _basis.NumVertices(group.numSegments, IsLast(group));
        const SegmentState state = _states[group.firstState + group.numSegments - 1];
        const bool stands = IsDrawn(state) && (state & kStands) != 0;
        const std::uint32_t last = _basis.FirstVertex(group.numSegments - 1) + _basis.TailVertex();
        return stands && !IsLast(group) ? std::max(count, last + 1) : count;
    }

    /// The vertices in the run of a segment that has some of its own, since those that tell how
    /// the curve goes on do not follow its four: others stand still in between. Else none.
    std::vector<std::uint32_t> OwnVertices(const Group& group, std::uint32_t segment) const {
        const CurveStates states = StatesOf(group);
        const SegmentState state = states.states[segment];
        const auto next = IsDrawn(state) && (state & kStands) != 0 ? states.Next(segment, 1)
                                                                   : std::optional<std::uint32_t>();
        if (!next || *next == (segment + 1) % states.count) {
            return {};
        }
        return _basis.VerticesWithTail(_basis.FirstVertex(segment), _basis.FirstVertex(*next));
    }

    std::uint64_t GroupVertices(const Group& group) const {
        std::uint64_t count = RowVertices(group);
        for (std::uint32_t i = 0; i < group.numSegments && _hasStanding; ++i) {
            count += OwnVertices(group, group.firstSegment + i).size();
        }
        return count;
    }

    void AddVertex(const Group& group, std::uint32_t run, ChunkGeometry* chunk) const {
        const glm::vec4 vertex = _runs.VertexAt(group.curve, run, 0);
        chunk->positions.emplace_back(vertex);
        chunk->radii.push_back(vertex.w);
        for (std::size_t pose = 1; pose < _runs.NumPoses(); ++pose) {
            const glm::vec4 later = _runs.VertexAt(group.curve, run, pose);
            chunk->keys[pose - 1].positions.emplace_back(later);
            chunk->keys[pose - 1].radii.push_back(later.w);
        }
        const RunVertex from = _runs.VertexOf(group.curve, run);
        const std::size_t point = _runs.PointAt(group.curve, from.point);
        chunk->points.push_back(
            _basis.HasPhantoms()
                ? static_cast<std::uint32_t>(_runs.RunBegin(group.curve) + run)
                : static_cast<std::uint32_t>(std::min(point, _runs.Size().numPoints - 1)));
        chunk->joints.push_back(_runs.JointAt(group.curve, run));
    }

    void GatherGroup(std::uint32_t index, ChunkGeometry* chunk) const {
        const Group& group = _groups[index];
        const auto firstVertex = static_cast<std::uint32_t>(chunk->positions.size());
        const std::uint32_t firstRun = _basis.FirstVertex(group.firstSegment);
        for (std::uint32_t i = 0; i < RowVertices(group); ++i) {
            AddVertex(group, firstRun + i, chunk);
        }
        if (_runs.HasNormals()) {
            chunk->jointNormals.resize(chunk->positions.size());
        }
        std::uint32_t primId = group.firstPrimId;
        for (std::uint32_t i = 0; i < group.numSegments; ++i) {
            const SegmentState state = _states[group.firstState + i];
            if (!IsDrawn(state)) {
                continue;
            }
            const std::uint32_t segment = group.firstSegment + i;
            std::uint32_t first = firstVertex + _basis.FirstVertex(segment) - firstRun;
            for (int joint = 0; joint < 2 && _runs.HasNormals(); ++joint) {
                chunk->jointNormals[first + static_cast<std::uint32_t>(_basis.Joints()[joint])] =
                    _runs.JointNormal(group.curve, segment, joint);
            }
            const CurveStates states = StatesOf(group);
            Ends ends;
            ends.isStart = !states.Next(segment, -1);
            ends.isEnd = !states.Next(segment, 1);
            ends.stands = (state & kStands) != 0 && !ends.isEnd;
            if (ends.stands) {
                const std::vector<std::uint32_t> own = OwnVertices(group, segment);
                first = own.empty() ? first : static_cast<std::uint32_t>(chunk->positions.size());
                for (const std::uint32_t run : own) {
                    AddVertex(group, run, chunk);
                }
            }
            const std::uint32_t level = state & kLevelBits;
            AddPieces(first, level, ends, _runs.ShapesOf(group.curve, segment), chunk);
            for (std::uint32_t piece = 0; piece < 1U << level; ++piece) {
                chunk->primIds.push_back(primId++);
                chunk->faces.push_back(_runs.FaceOf(group.curve));
            }
        }
    }

    struct Ends {
        bool isStart, isEnd; ///< of a curve
        bool stands;         ///< kStands, and the curve goes on
    };

    static void AddPieces(std::uint32_t first, std::uint32_t level, const Ends& ends,
                          const std::vector<Points>& shapes, ChunkGeometry* chunk) {
        constexpr int kAbove = HDS_PIECE_SHIFT; // corner 1 begins there
        const std::uint32_t count = 1U << level;
        for (std::uint32_t piece = 0; piece < count; ++piece) {
            std::uint64_t bits = std::uint64_t{level} << (HDS_PIECE_LEVEL_SHIFT - kAbove) | piece;
            bits |= ends.isStart ? HDS_PIECE_START >> kAbove : 0;
            bits |= ends.isEnd ? HDS_PIECE_END >> kAbove : 0;
            bits |= ends.stands ? HDS_PIECE_STANDS >> kAbove : 0;
            chunk->triangles.emplace_back(first, static_cast<std::uint32_t>(bits), 0U);
            for (std::size_t i = 0; i < shapes.size(); ++i) {
                Bounds bounds;
                Extend(count == 1 ? shapes[i]
                                  : PartOfBezier(shapes[i], static_cast<double>(piece) / count,
                                                 static_cast<double>(piece + 1) / count),
                       &bounds);
                (i == 0 ? chunk->primitiveBounds : chunk->keys[i - 1].primitiveBounds)
                    .push_back(bounds);
            }
        }
    }

    /// Looks at all values; gives pinned curves the values of their phantoms.
    void ReadValues() const {
        for (GeometryAttribute& attribute : _values) {
            WarnNotFinite(attribute, _log.PrimPath(), _log.Sink());
            if (attribute.interpolation == Interpolation::Vertex && _basis.HasPhantoms()) {
                _runs.AddPhantoms(&attribute);
            }
        }
    }

    mutable PrimLog _log;
    const CurveRuns _runs;
    const CurveBasis& _basis;   ///< of _runs
    std::vector<Group> _groups; ///< and one more for the end
    std::vector<Bounds> _groupBounds;
    std::vector<SegmentState> _states; ///< [numSegments]; final once constructed
    bool _hasStanding = false;         ///< some are kStands
    mutable std::vector<GeometryAttribute>
        _values; ///< user primvars; final once ReadValues has run
    mutable std::once_flag _isRead;
};

} // namespace

std::shared_ptr<const ChunkSource>
MakeCurveSource(std::shared_ptr<const GeometryDescription> curves, const std::string& primPath,
                Warnings& warnings) {
    return std::make_shared<const CurveSource>(std::move(curves), primPath, warnings);
}

} // namespace hds
