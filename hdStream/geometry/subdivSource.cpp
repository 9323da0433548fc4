// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/subdivSource.h"

#include "hdStream/base/error.h"
#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/faceMeter.h"
#include "hdStream/geometry/meshContent.h"
#include "hdStream/geometry/subdivDice.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

namespace hds {
namespace {

namespace Far = OpenSubdiv::Far;
using Range = tbb::blocked_range<int>;
constexpr int kGrain = 64;

/// A box relative to the origin, rounded outwards. The owner of a shared point may have it a
/// rounding error away from where another face has it.
Bounds RoundOut(const ExactBox& box, const glm::dvec3& origin) {
    Bounds bounds;
    if (box.min.x > box.max.x) {
        return bounds;
    }
    const auto infinity = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double slack = 1e-12 * std::max(std::fabs(box.min[axis]), std::fabs(box.max[axis]));
        bounds.min[axis] = std::nextafter(float(box.min[axis] - origin[axis] - slack), -infinity);
        bounds.max[axis] = std::nextafter(float(box.max[axis] - origin[axis] + slack), infinity);
    }
    return bounds;
}

void RaiseTo(std::uint8_t level, std::atomic<std::uint8_t>* highest) {
    std::uint8_t seen = highest->load();
    while (seen < level && !highest->compare_exchange_weak(seen, level)) {
    }
}

class SubdivSource final : public SubdivChunkSource {
public:
    SubdivSource(std::unique_ptr<const SubdivModel> model, const std::string& primPath,
                 const DicingOptions& options, const Displacement& displacement, Warnings& warnings,
                 bool keepsRest) {
        _dice.model = std::move(model);
        MakeKeyModels(primPath);
        PrimLog log(primPath, warnings);
        _dice.entries = AssignSubsets(Model().Mesh(), log);
        _isLeftHanded = Model().Mesh().leftHanded;
        BindDisplacement(displacement, log);
        _dice.keepsRest = keepsRest && _dice.displacement.IsActive() &&
                          !_dice.displacement.IsConstant() && _dice.keyModels.empty();
        std::vector<ExactBox> faceBoxes(Model().NumFaces());
        MeasureFaces(options, faceBoxes);
        ChooseOrigin(faceBoxes);
        const SubdivDice::Counts counts = _dice.NumberGroups();
        _numTriangles = counts.triangles;
        _numVertices = counts.vertices;
        _numGroups = static_cast<std::uint32_t>(_dice.groupTriangles.size() - 1);
        MeasureGroups(faceBoxes);
        DescribePages();
    }

    std::uint32_t GroupTriangles(std::uint32_t group) const override {
        return _dice.groupTriangles[group + 1] - _dice.groupTriangles[group];
    }

    Bounds GroupBounds(std::uint32_t group) const override { return _groupBounds[group]; }

    const std::vector<std::uint8_t>& EdgeLevels() const override { return _dice.edgeLevels; }

    std::uint64_t TableBytes() const override {
        constexpr std::uint64_t kTopologyBytes = 200; ///< about, a face, of OpenSubdiv
        return sizeof(*this) + NumPoses() * Model().NumFaces() * kTopologyBytes +
               VectorBytes(_groupBounds, _dice.entries, _dice.edgeLevels, _dice.faceGroups,
                           _dice.groupTriangles);
    }

    ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const override {
        for (std::size_t i = 0; i < count; ++i) {
            HDS_VERIFY(groups[i] < _numGroups,
                       "group " + std::to_string(groups[i]) + " of " + std::to_string(_numGroups));
        }
        return DiceGroups(_dice, groups, count);
    }

private:
    const SubdivModel& Model() const { return *_dice.model; }
    std::size_t NumPoses() const { return 1 + _dice.keyModels.size(); }

    void MakeKeyModels(const std::string& primPath) {
        _dice.keyWarnings = std::make_unique<Warnings>();
        for (const ShutterKey& key : Model().Mesh().keys) {
            auto posed = std::make_shared<GeometryDescription>(Model().Mesh());
            posed->points = key.points;
            auto model = SubdivModel::Make(std::move(posed), primPath, *_dice.keyWarnings);
            if (!model || model->Cage().faces != Model().Cage().faces) {
                _dice.keyModels.clear();
                return;
            }
            _dice.keyModels.push_back(std::move(model));
        }
    }

    /// The box of what `boxOf` says of a face, in all poses.
    template <typename BoxOf>
    ExactBox BoxOfPoses(int face, const BoxOf& boxOf) const {
        ExactBox box = boxOf(FaceMeter(Model(), face));
        for (const auto& model : _dice.keyModels) {
            const ExactBox posed = boxOf(FaceMeter(*model, face));
            box.min = glm::min(box.min, posed.min);
            box.max = glm::max(box.max, posed.max);
        }
        return box;
    }

    void BindDisplacement(const Displacement& displacement, PrimLog& log) {
        std::vector<GeometryAttribute> attributes;
        for (const SubdivPrimvar& primvar : Model().Primvars()) {
            attributes.push_back(primvar.attribute);
        }
        std::uint32_t last = 0;
        for (const std::uint32_t entry : _dice.entries) {
            last = std::max(last, entry);
        }
        _dice.displacement.owner = displacement;
        _dice.displacement.amounts = BindAmounts(displacement, attributes);
        _dice.displacement.hasVectors = HasVectors(_dice.displacement.amounts);
        if (LacksCoordinates(_dice.displacement.amounts)) {
            log.Warn(kNoCoordinates);
        }
        _dice.displacement.range = RangeOf(_dice.displacement.amounts, attributes, Model().Mesh(),
                                           last >= displacement.size());
    }

    void DescribePages() {
        std::vector<GeometryAttribute> attributes;
        for (const SubdivPrimvar& primvar : Model().Primvars()) {
            attributes.push_back(primvar.attribute);
            _attributes.push_back({primvar.attribute.name, primvar.attribute.numComponents});
        }
        std::vector<GeometryAttribute> rest;
        if (_dice.keepsRest) {
            rest.emplace_back();
            rest.back().name = kMovedBy;
            rest.back().interpolation = Interpolation::Vertex;
            if (!Model().IsFlat()) {
                rest.emplace_back();
                rest.back().name = kRestNormals;
                rest.back().interpolation = Interpolation::FaceVarying; // at most
            }
        }
        for (GeometryAttribute& attribute : rest) {
            attribute.numComponents = 3;
            attributes.push_back(attribute);
            _attributes.push_back({attribute.name, attribute.numComponents});
        }
        const auto normalsAs = [&](Interpolation interpolation) {
            return Model().IsFlat() ? std::nullopt : std::optional<Interpolation>(interpolation);
        };
        // Chunks with a crease have normals per corner.
        _boundBytes = BoundTriangleBytes(attributes, normalsAs(Interpolation::FaceVarying),
                                         !_dice.entries.empty(), NumPoses());
        _meanBytes =
            MeanTriangleBytes(attributes, normalsAs(Interpolation::Vertex), !_dice.entries.empty(),
                              NumPoses(), VerticesPerTriangle(_numVertices, _numTriangles));
    }

    /// The levels that a face asks for in one pose.
    void RequestLevels(const SubdivModel& model, int face, const DicingOptions& options,
                       std::uint8_t* levels) const {
        const SubdivDisplacement& displacement = _dice.displacement;
        SubdivPoints points(model, displacement, _dice.entries);
        SurfaceMove move{displacement.range, {}};
        if (!displacement.IsConstant()) {
            move.positionAt = [&](const FacePoint& at) { return points.OwnPosition({face, at}); };
        }
        FaceMeter(model, face).RequestLevels(options, move, levels);
    }

    /// Boxes of the faces' limit surfaces, and the levels of all edges.
    void MeasureFaces(const DicingOptions& options, std::vector<ExactBox>& boxes) {
        const Far::TopologyLevel& level = Model().Level();
        const auto uniform = static_cast<std::uint8_t>(
            options.isAdaptive ? 0 : std::min(options.level, kMaxDicingLevel));
        std::vector<std::atomic<std::uint8_t>> levels(std::size_t(level.GetNumEdges()));
        tbb::parallel_for(Range(0, level.GetNumFaces(), kGrain), [&](const Range& range) {
            std::vector<std::uint8_t> requests;
            for (int face = range.begin(); face < range.end(); ++face) {
                if (!Model().IsDrawn(face)) {
                    continue;
                }
                boxes[std::size_t(face)] =
                    BoxOfPoses(face, [](const FaceMeter& pose) { return pose.Box(); });
                if (!options.isAdaptive) {
                    continue;
                }
                const Far::ConstIndexArray edges = level.GetFaceEdges(face);
                requests.resize(std::size_t(edges.size()));
                const auto request = [&](const SubdivModel& model) {
                    RequestLevels(model, face, options, requests.data());
                    for (int i = 0; i < edges.size(); ++i) {
                        RaiseTo(requests[std::size_t(i)], &levels[std::size_t(edges[i])]);
                    }
                };
                request(Model());
                for (const auto& model : _dice.keyModels) {
                    request(*model);
                }
            }
        });
        _dice.edgeLevels.assign(levels.begin(), levels.end());
        if (!options.isAdaptive) {
            std::fill(_dice.edgeLevels.begin(), _dice.edgeLevels.end(), uniform);
        }
    }

    void ChooseOrigin(const std::vector<ExactBox>& boxes) {
        ExactBox all;
        for (const ExactBox& box : boxes) {
            all.min = glm::min(all.min, box.min);
            all.max = glm::max(all.max, box.max);
        }
        if (all.min.x <= all.max.x) {
            _dice.origin = glm::dvec3(hds::ChooseOrigin(RoundOut(all, glm::dvec3(0.0))));
        }
        _origin = _dice.origin;
    }

    void MeasureGroups(const std::vector<ExactBox>& faceBoxes) {
        _groupBounds.resize(_numGroups);
        const double reach = std::max(std::fabs(_dice.displacement.range.low),
                                      std::fabs(_dice.displacement.range.high));
        const auto bounds = [&](ExactBox box) {
            box.min -= reach;
            box.max += reach;
            return RoundOut(box, _origin);
        };
        tbb::parallel_for(Range(0, int(Model().NumFaces()), kGrain), [&](const Range& range) {
            std::vector<std::uint8_t> levels;
            for (int face = range.begin(); face < range.end(); ++face) {
                const std::uint32_t begin = _dice.faceGroups[std::size_t(face)];
                const std::uint32_t end = _dice.faceGroups[std::size_t(face) + 1];
                if (end - begin == 1 || Model().Shape(face) != FaceShape::Quad) {
                    std::fill(_groupBounds.begin() + begin, _groupBounds.begin() + end,
                              bounds(faceBoxes[std::size_t(face)]));
                    continue;
                }
                if (begin == end) {
                    continue;
                }
                _dice.FaceLevels(face, levels);
                const DicePattern pattern(Model().Shape(face), std::uint32_t(levels.size()),
                                          levels.data());
                for (std::uint32_t group = begin; group < end; ++group) {
                    _groupBounds[group] = bounds(BoxOfPoses(face, [&](const FaceMeter& pose) {
                        return pose.BoxOver(pattern.TileBox(group - begin));
                    }));
                }
            }
        });
        for (const Bounds& group : _groupBounds) {
            _bounds.min = glm::min(_bounds.min, group.min);
            _bounds.max = glm::max(_bounds.max, group.max);
        }
    }

    SubdivDice _dice;
    std::vector<Bounds> _groupBounds;
};

} // namespace

bool IsSubdivisionScheme(const std::string& scheme) {
    return scheme == "catmullClark" || scheme == "loop" || scheme == "bilinear";
}

std::shared_ptr<const SubdivChunkSource>
MakeSubdivSource(std::shared_ptr<const GeometryDescription> mesh, const std::string& primPath,
                 const DicingOptions& options, const Displacement& displacement, Warnings& warnings,
                 bool keepsRest) {
    auto model = SubdivModel::Make(std::move(mesh), primPath, warnings);
    if (!model) {
        return nullptr;
    }
    return std::make_shared<SubdivSource>(std::move(model), primPath, options, displacement,
                                          warnings, keepsRest);
}

} // namespace hds
