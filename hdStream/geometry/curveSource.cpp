// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/curveSource.h"

#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/curveCounts.h"
#include "hdStream/geometry/curveSegments.h"
#include "hdStream/geometry/curveStates.h"
#include "hdStream/geometry/normals.h"
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

constexpr float kDefaultWidth = 1.0F; // as Hydra has it
/// Lines of draw modes, whose widths mean pixels: a part of the diagonal of all points.
constexpr double kLineWidth = 1.0 / 256.0;
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
        : _curves(std::move(curves)), _log(primPath, warnings) {
        SetCounts();
        if (!ReadPrimvars()) {
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
        const std::size_t vertexBytes = ((_hasNormals ? 4 : 0) + 4 * NumPoses()) * sizeof(float);
        _boundBytes = SolidBytes(_values, mostVertices, vertexBytes, NumPoses(), false);
        _meanBytes =
            SolidBytes(_values,
                       std::min(mostVertices,
                                static_cast<double>(_numVertices) /
                                    static_cast<double>(std::max<std::uint64_t>(1, _numTriangles))),
                       vertexBytes, NumPoses(), true);
    }

    std::uint32_t GroupTriangles(std::uint32_t group) const override {
        return _groups[group + 1].firstPrimId - _groups[group].firstPrimId;
    }
    Bounds GroupBounds(std::uint32_t group) const override { return _groupBounds[group]; }
    std::uint64_t TableBytes() const override {
        return sizeof(*this) +
               VectorBytes(_begins, _counts, _faces, _firstJoints, _groups, _groupBounds, _states);
    }

    ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const override {
        std::call_once(_isRead, [this] { ReadValues(); });
        ChunkGeometry chunk;
        chunk.primitives = _basis->Primitives();
        chunk.keys.resize(NumPoses() - 1);
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
    using Points = std::array<glm::dvec4, 4>;

    /// Vertices of each curve, and where they begin; curves that ask for too much have none.
    void SetCounts() {
        if (_curves->points.size() % 3 != 0) {
            _log.Warn(std::to_string(_curves->points.size() % 3) +
                      " floats after the last point ignored");
        }
        _size.numPoints = _curves->points.size() / 3;
        CurveCounts counts = ReadCurveCounts(*_curves, _size.numPoints, _log);
        _begins = std::move(counts.begins);
        _counts = std::move(counts.counts);
        _faces = std::move(counts.faces);
        _size.numFaces = _curves->faceVertexCounts.size();
    }

    /// The authored curve, which uniform values belong to.
    std::uint32_t FaceOf(std::uint32_t curve) const {
        return _faces.empty() ? curve : _faces[curve];
    }

    /// Index of a point, or one beyond all.
    std::size_t PointAt(std::uint32_t curve, std::uint32_t place) const {
        const std::uint64_t element = _begins[curve] + place;
        if (_curves->faceVertexIndices.empty()) {
            return element;
        }
        const std::int32_t index = _curves->faceVertexIndices[element];
        return index < 0 ? _size.numPoints : static_cast<std::size_t>(index);
    }

    /// Finds the basis, which widths and normals take part in. \return false: nothing can be drawn.
    bool ReadPrimvars() {
        // Joints must be counted before anything varying is looked at.
        CurveBasis plain(*_curves->curves, false, false, _log);
        std::size_t numShort = 0;
        std::size_t numUnused = 0;
        for (const std::uint32_t count : _counts) {
            std::uint32_t unused = 0;
            const std::uint32_t segments = plain.NumSegments(count, &unused);
            _firstJoints.push_back(static_cast<std::uint32_t>(_size.numJoints));
            _size.numJoints += segments > 0 ? plain.NumJoints(segments) : 0;
            numShort += segments == 0 && count > 0 ? 1 : 0;
            numUnused += segments > 0 ? unused : 0;
        }
        _size.hasJoints = true;
        _size.numCorners = _size.numJoints;
        if (numShort > 0) {
            _log.Warn(std::to_string(numShort) + " curves dropped: too few vertices for " +
                      (_curves->curves->type == "linear" ? "linear" : _curves->curves->basis) +
                      " curves");
        }
        if (numUnused > 0) {
            _log.Warn(std::to_string(numUnused) + " vertices after the last segment ignored");
        }
        const Bounds bounds = BoundPoints(*_curves);
        _origin = glm::dvec3(ChooseOrigin(bounds));
        float width = kDefaultWidth;
        if (plain.IsSegmented() && bounds.min.x <= bounds.max.x) {
            width = static_cast<float>(
                kLineWidth * glm::length(glm::dvec3(bounds.max) - glm::dvec3(bounds.min)));
        }
        _widths.values = std::vector<float>{width};
        if (auto widths =
                plain.IsSegmented() ? std::nullopt : AuthoredWidths(*_curves, _size, _log)) {
            _widths = std::move(*widths);
            WarnBadWidths(_widths, _log);
        }
        _widthsOfPoses = WidthsOfPoses(*_curves, _widths);
        if (auto normals = AuthoredNormals(*_curves, _size, _log)) {
            _normals = std::move(*normals);
            _hasNormals = true;
        }
        Warnings unheard; // of the form: heard above
        PrimLog quiet(_log.PrimPath(), unheard);
        _basis.emplace(*_curves->curves, _hasNormals,
                       _widths.interpolation == Interpolation::Varying, quiet);
        _values = SolidAttributes(*_curves, _size, _log);
        for (const GeometryAttribute& attribute : _values) {
            _attributes.push_back({attribute.name, attribute.numComponents});
        }
        if (_size.numPoints >= 0xffffffffU || _size.numJoints >= 0xffffffffU) {
            _log.Warn("curves dropped: more than 2^32 - 2 points");
            return false;
        }
        return true;
    }

    void CutCurves() {
        std::uint64_t firstState = 0;
        for (std::uint32_t curve = 0; curve < _counts.size(); ++curve) {
            const std::uint32_t numSegments = SegmentsOf(curve);
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

    std::uint32_t SegmentsOf(std::uint32_t curve) const {
        std::uint32_t unused = 0;
        return _basis->NumSegments(_counts[curve], &unused);
    }

    /// How many pieces each segment has, and the boxes of groups.
    void MeasureSegments() {
        tbb::parallel_for(std::uint32_t{0}, _numGroups, [this](std::uint32_t index) {
            const Group& group = _groups[index];
            for (std::uint32_t i = 0; i < group.numSegments; ++i) {
                _states[group.firstState + i] = StateOf(group.curve, group.firstSegment + i);
                if (_states[group.firstState + i] != kDropped) {
                    for (const Points& shape : ShapesOf(group.curve, group.firstSegment + i)) {
                        Extend(shape, &_groupBounds[index]);
                    }
                }
            }
        });
        for (const Group& group : _groups) {
            if (group.firstSegment == 0) {
                SettleStates(&_states[group.firstState], SegmentsOf(group.curve),
                             _basis->IsPeriodic());
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
        const bool isLinear = (_basis->Primitives() & HDS_PRIMITIVE_BASIS) == HDS_PRIMITIVE_LINEAR;
        for (std::uint32_t k = isLinear ? 1 : 0; k < (isLinear ? 3U : 4U); ++k) {
            const RunVertex vertex =
                _basis->VertexOf(_basis->FirstVertex(segment) + k, _counts[curve]);
            if (!HasPoint(*_curves, PointAt(curve, vertex.point))) {
                return kDropped;
            }
        }
        double turn = 0.0;
        bool isStill = !_hasNormals;
        for (const Points& shape : ShapesOf(curve, segment)) {
            for (const glm::dvec4& point : shape) {
                hasWidth = hasWidth || point.w != 0.0;
                isStill = isStill && point == shape[0];
            }
            turn = std::max(turn, TurnOfBezier(shape) / (_hasNormals ? kRibbonTurn : kRoundTurn));
        }
        if (!hasWidth || isStill) {
            return hasWidth ? kStill : kDropped;
        }
        if (_hasNormals) {
            const glm::dvec3 n0(JointNormal(curve, segment, 0));
            const glm::dvec3 n1(JointNormal(curve, segment, 1));
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
        const std::uint32_t basis = _basis->Primitives() & HDS_PRIMITIVE_BASIS;
        const bool isLast = !_basis->IsPeriodic() && segment + 1 == SegmentsOf(curve);
        if (_hasNormals || basis == HDS_PRIMITIVE_LINEAR || isLast) {
            return false;
        }
        const bool isBezier = basis == HDS_PRIMITIVE_BEZIER;
        const std::uint32_t first = _basis->FirstVertex(segment);
        for (std::size_t pose = 0; pose < NumPoses(); ++pose) {
            const glm::vec3 before(VertexAt(curve, first + (isBezier ? 3U : 1U), pose));
            const glm::vec3 behind(VertexAt(curve, first + (isBezier ? 4U : 3U), pose));
            if (before == behind) { // whatever the radii
                return true;
            }
        }
        return false;
    }

    std::size_t NumPoses() const { return 1 + _curves->keys.size(); }

    /// A vertex of a run relative to the origin, with its radius, as its page holds it. \param
    /// pose 0: when the shutter opens; else of a key.
    glm::vec4 VertexAt(std::uint32_t curve, std::uint32_t run, std::size_t pose) const {
        const RunVertex vertex = _basis->VertexOf(run, _counts[curve]);
        const auto at = [&](std::uint32_t place) {
            const auto point = FindPointAt(*_curves, pose, PointAt(curve, place));
            return glm::vec4(point ? *point - glm::vec3(_origin) : glm::vec3(0.0F),
                             VertexRadius(_widthsOfPoses[pose], curve, run, place));
        };
        return vertex.isPhantom ? 2.0F * at(vertex.point) - at(vertex.next) : at(vertex.point);
    }

    float VertexRadius(const GeometryAttribute& widths, std::uint32_t curve, std::uint32_t run,
                       std::uint32_t place) const {
        switch (widths.interpolation) {
        case Interpolation::Uniform:
            return RadiusOf(widths, curve);
        case Interpolation::Vertex:
            return PointAt(curve, place) < _size.numPoints ? RadiusOf(widths, PointAt(curve, place))
                                                           : 0.0F;
        case Interpolation::Varying:
            break;
        default:
            return RadiusOf(widths, 0);
        }
        const std::uint32_t segments = SegmentsOf(curve);
        const float radius = RadiusOf(widths, _firstJoints[curve] + _basis->JointOf(run, segments));
        const bool isBezier = (_basis->Primitives() & HDS_PRIMITIVE_BASIS) == HDS_PRIMITIVE_BEZIER;
        if (!isBezier || run % 3 == 0) {
            return radius;
        }
        const float next =
            RadiusOf(widths, _firstJoints[curve] + _basis->JointOf((run / 3 + 1) * 3, segments));
        return radius + (next - radius) * (static_cast<float>(run % 3) / 3.0F);
    }

    Points ShapeOf(std::uint32_t curve, std::uint32_t segment, std::size_t pose) const {
        Points vertices;
        for (std::uint32_t k = 0; k < 4; ++k) {
            vertices[k] = glm::dvec4(VertexAt(curve, _basis->FirstVertex(segment) + k, pose));
        }
        return _basis->Bezier(vertices);
    }

    /// When the shutter opens and, of curves that move, at each of the keys.
    std::vector<Points> ShapesOf(std::uint32_t curve, std::uint32_t segment) const {
        std::vector<Points> shapes;
        for (std::size_t pose = 0; pose < NumPoses(); ++pose) {
            shapes.push_back(ShapeOf(curve, segment, pose));
        }
        return shapes;
    }

    static void Extend(const Points& shape, Bounds* bounds) {
        for (const glm::dvec4& point : shape) {
            ExtendBySolid(glm::dvec3(point), point.w, bounds);
        }
    }

    /// Group length; some direction where nothing usable is authored.
    glm::vec3 JointNormal(std::uint32_t curve, std::uint32_t segment, int joint) const {
        glm::dvec3 sum(0.0);
        const auto add = [&](std::size_t element, double weight) {
            const float* normal = ValueOf(_normals, element);
            if (weight != 0.0 && IsUsableNormal(normal)) {
                const glm::dvec3 authored(normal[0], normal[1], normal[2]);
                sum += weight / glm::length(authored) * authored;
            }
        };
        const std::uint32_t first = _basis->FirstVertex(segment);
        switch (_normals.interpolation) {
        case Interpolation::Uniform:
            add(FaceOf(curve), 1.0);
            break;
        case Interpolation::Vertex: {
            const std::array<double, 4> weights = _basis->JointWeights(joint);
            for (std::uint32_t k = 0; k < 4; ++k) {
                const RunVertex vertex = _basis->VertexOf(first + k, _counts[curve]);
                const std::size_t point = PointAt(curve, vertex.point);
                if (point < _size.numPoints) {
                    add(point, weights[k]);
                }
            }
            break;
        }
        case Interpolation::Varying:
        case Interpolation::FaceVarying:
            add(_firstJoints[curve] +
                    _basis->JointOf(first + static_cast<std::uint32_t>(_basis->Joints()[joint]),
                                    SegmentsOf(curve)),
                1.0);
            break;
        default:
            add(0, 1.0);
            break;
        }
        const double length = glm::length(sum);
        return length > 1e-6 ? glm::vec3(sum / length) : glm::vec3(0.0F, 0.0F, 1.0F);
    }

    bool IsLast(const Group& group) const {
        return !_basis->IsPeriodic() &&
               group.firstSegment + group.numSegments == SegmentsOf(group.curve);
    }
    CurveStates StatesOf(const Group& group) const {
        return {_states.data() + group.firstState - group.firstSegment, SegmentsOf(group.curve),
                _basis->IsPeriodic()};
    }

    /// The vertices of its segments and of their neighbours, in their order.
    std::uint32_t RowVertices(const Group& group) const {
        const std::uint32_t count = _basis->NumVertices(group.numSegments, IsLast(group));
        const SegmentState state = _states[group.firstState + group.numSegments - 1];
        const bool stands = IsDrawn(state) && (state & kStands) != 0;
        const std::uint32_t last =
            _basis->FirstVertex(group.numSegments - 1) + _basis->TailVertex();
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
        return _basis->VerticesWithTail(_basis->FirstVertex(segment), _basis->FirstVertex(*next));
    }

    std::uint64_t GroupVertices(const Group& group) const {
        std::uint64_t count = RowVertices(group);
        for (std::uint32_t i = 0; i < group.numSegments && _hasStanding; ++i) {
            count += OwnVertices(group, group.firstSegment + i).size();
        }
        return count;
    }

    void AddVertex(const Group& group, std::uint32_t run, ChunkGeometry* chunk) const {
        const glm::vec4 vertex = VertexAt(group.curve, run, 0);
        chunk->positions.emplace_back(vertex);
        chunk->radii.push_back(vertex.w);
        for (std::size_t pose = 1; pose < NumPoses(); ++pose) {
            const glm::vec4 later = VertexAt(group.curve, run, pose);
            chunk->keys[pose - 1].positions.emplace_back(later);
            chunk->keys[pose - 1].radii.push_back(later.w);
        }
        const RunVertex from = _basis->VertexOf(run, _counts[group.curve]);
        const std::size_t point = PointAt(group.curve, from.point);
        chunk->points.push_back(
            _basis->HasPhantoms()
                ? static_cast<std::uint32_t>(RunBegin(group.curve) + run)
                : static_cast<std::uint32_t>(std::min(point, _size.numPoints - 1)));
        chunk->joints.push_back(_firstJoints[group.curve] +
                                _basis->JointOf(run, SegmentsOf(group.curve)));
    }

    void GatherGroup(std::uint32_t index, ChunkGeometry* chunk) const {
        const Group& group = _groups[index];
        const auto firstVertex = static_cast<std::uint32_t>(chunk->positions.size());
        const std::uint32_t firstRun = _basis->FirstVertex(group.firstSegment);
        for (std::uint32_t i = 0; i < RowVertices(group); ++i) {
            AddVertex(group, firstRun + i, chunk);
        }
        if (_hasNormals) {
            chunk->jointNormals.resize(chunk->positions.size());
        }
        std::uint32_t primId = group.firstPrimId;
        for (std::uint32_t i = 0; i < group.numSegments; ++i) {
            const SegmentState state = _states[group.firstState + i];
            if (!IsDrawn(state)) {
                continue;
            }
            const std::uint32_t segment = group.firstSegment + i;
            std::uint32_t first = firstVertex + _basis->FirstVertex(segment) - firstRun;
            for (int joint = 0; joint < 2 && _hasNormals; ++joint) {
                chunk->jointNormals[first + static_cast<std::uint32_t>(_basis->Joints()[joint])] =
                    JointNormal(group.curve, segment, joint);
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
            AddPieces(first, level, ends, ShapesOf(group.curve, segment), chunk);
            for (std::uint32_t piece = 0; piece < 1U << level; ++piece) {
                chunk->primIds.push_back(primId++);
                chunk->faces.push_back(FaceOf(group.curve));
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

    /// Where the vertices of a pinned curve begin among those of all: each has two phantoms.
    std::uint64_t RunBegin(std::uint32_t curve) const {
        return _begins[curve] + 2 * std::uint64_t{curve};
    }

    /// Looks at all values; gives pinned curves the values of their phantoms.
    void ReadValues() const {
        for (GeometryAttribute& attribute : _values) {
            WarnNotFinite(attribute, _log.PrimPath(), _log.Sink());
            if (attribute.interpolation == Interpolation::Vertex && _basis->HasPhantoms()) {
                AddPhantoms(&attribute);
            }
        }
    }

    void AddPhantoms(GeometryAttribute* attribute) const {
        const std::uint32_t width = attribute->numComponents;
        std::vector<float> values;
        for (std::uint32_t curve = 0; curve < _counts.size(); ++curve) {
            const std::uint32_t numVertices = _counts[curve];
            values.resize(RunBegin(curve) * width);
            for (std::uint32_t run = 0; run < numVertices + 2 && numVertices > 1; ++run) {
                const RunVertex vertex = _basis->VertexOf(run, numVertices);
                const auto at = [&](std::uint32_t place) {
                    return ValueOf(*attribute,
                                   std::min(PointAt(curve, place), _size.numPoints - 1));
                };
                for (std::uint32_t c = 0; c < width; ++c) {
                    const float value = at(vertex.point)[c];
                    values.push_back(vertex.isPhantom ? 2.0F * value - at(vertex.next)[c] : value);
                }
            }
        }
        attribute->values = std::move(values);
        attribute->indices = {};
    }

    std::shared_ptr<const GeometryDescription> _curves;
    mutable PrimLog _log;
    TopologySize _size;
    std::vector<std::uint64_t> _begins;      ///< [numCurves] first vertex
    std::vector<std::uint32_t> _counts;      ///< [numCurves] vertices
    std::vector<std::uint32_t> _faces;       ///< [numCurves] authored curve; empty: the same
    std::vector<std::uint32_t> _firstJoints; ///< [numCurves]
    std::optional<CurveBasis> _basis;
    GeometryAttribute _widths;
    std::vector<GeometryAttribute> _widthsOfPoses;
    GeometryAttribute _normals;
    bool _hasNormals = false;
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
