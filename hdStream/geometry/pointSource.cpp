// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/pointSource.h"

#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/solidContent.h"
#include "kernels/shared/geometry.h"

#include <algorithm>
#include <mutex>

namespace hds {
namespace {

constexpr float kDefaultWidth = 1.0F; // as Hydra has it

class PointSource final : public ChunkSource {
public:
    PointSource(std::shared_ptr<const GeometryDescription> points, const std::string& primPath,
                Warnings& warnings)
        : _points(std::move(points)), _log(primPath, warnings) {
        const std::size_t count = _points->points.size() / 3;
        if (count >= 0xffffffffU) {
            _log.Warn("points dropped: more than 2^32 - 2");
            return;
        }
        TopologySize size;
        size.numPoints = size.numFaces = size.numCorners = count;
        _widths.values = std::vector<float>{kDefaultWidth};
        if (auto widths = AuthoredWidths(*_points, size, _log)) {
            _widths = std::move(*widths);
            WarnBadWidths(_widths, _log);
        }
        _widthsOfPoses = WidthsOfPoses(*_points, _widths);
        _values = SolidAttributes(*_points, size, _log);
        for (const GeometryAttribute& attribute : _values) {
            _attributes.push_back({attribute.name, attribute.numComponents});
        }
        _origin = glm::dvec3(ChooseOrigin(BoundPoints(*_points)));
        _numGroups = static_cast<std::uint32_t>(count);
        std::size_t numBad = 0;
        for (std::uint32_t i = 0; i < _numGroups; ++i) {
            if (GroupTriangles(i) == 0) {
                numBad += FindPoint(*_points, i) ? 0 : 1;
                continue;
            }
            ++_numTriangles;
            const Bounds bounds = GroupBounds(i);
            for (int axis = 0; axis < 3; ++axis) {
                _bounds.min[axis] = std::min(_bounds.min[axis], bounds.min[axis]);
                _bounds.max[axis] = std::max(_bounds.max[axis], bounds.max[axis]);
            }
        }
        if (numBad > 0) {
            _log.Warn(std::to_string(numBad) + " points dropped: not finite or beyond 1e18");
        }
        if (_numTriangles + numBad < count) {
            _log.Warn(std::to_string(count - numBad - _numTriangles) + " points dropped: no width");
        }
        _numVertices = _numTriangles;
        const std::size_t vertexBytes = NumPoses() * 4 * sizeof(float);
        _boundBytes = SolidBytes(_values, 1.0, vertexBytes, NumPoses(), false);
        _meanBytes = SolidBytes(_values, 1.0, vertexBytes, NumPoses(), true);
    }

    std::uint32_t GroupTriangles(std::uint32_t group) const override {
        const bool hasWidth = std::any_of(
            _widthsOfPoses.begin(), _widthsOfPoses.end(),
            [&](const GeometryAttribute& widths) { return RadiusOf(widths, group) > 0.0F; });
        return hasWidth && HasPoint(*_points, group) ? 1 : 0;
    }
    Bounds GroupBounds(std::uint32_t group) const override {
        Bounds bounds;
        if (GroupTriangles(group) > 0) {
            for (std::size_t pose = 0; pose < NumPoses(); ++pose) {
                Extend(group, pose, &bounds);
            }
        }
        return bounds;
    }
    ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const override {
        std::call_once(_isRead, [this] {
            for (const GeometryAttribute& attribute : _values) {
                WarnNotFinite(attribute, _log.PrimPath(), _log.Sink());
            }
        });
        ChunkGeometry chunk;
        chunk.primitives = HDS_PRIMITIVE_POINTS;
        chunk.attributes = _values;
        chunk.keys.resize(NumPoses() - 1);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t group = groups[i];
            if (GroupTriangles(group) == 0) {
                continue;
            }
            chunk.triangles.emplace_back(static_cast<std::uint32_t>(chunk.points.size()), 0U, 0U);
            chunk.points.push_back(group);
            Add(group, 0, &chunk.positions, &chunk.radii, &chunk.primitiveBounds);
            chunk.primIds.push_back(group);
            chunk.faces.push_back(group);
            for (std::size_t pose = 1; pose < NumPoses(); ++pose) {
                ChunkKey& key = chunk.keys[pose - 1];
                Add(group, pose, &key.positions, &key.radii, &key.primitiveBounds);
            }
        }
        return chunk;
    }

private:
    std::size_t NumPoses() const { return 1 + _points->keys.size(); }

    void Extend(std::uint32_t group, std::size_t pose, Bounds* bounds) const {
        ExtendBySolid(glm::dvec3(*FindPointAt(*_points, pose, group)) - _origin,
                      RadiusOf(_widthsOfPoses[pose], group), bounds);
    }
    void Add(std::uint32_t group, std::size_t pose, std::vector<glm::vec3>* positions,
             std::vector<float>* radii, std::vector<Bounds>* bounds) const {
        positions->push_back(*FindPointAt(*_points, pose, group) - glm::vec3(_origin));
        radii->push_back(RadiusOf(_widthsOfPoses[pose], group));
        bounds->emplace_back();
        Extend(group, pose, &bounds->back());
    }

    std::shared_ptr<const GeometryDescription> _points;
    mutable PrimLog _log;
    GeometryAttribute _widths;
    std::vector<GeometryAttribute> _widthsOfPoses;
    std::vector<GeometryAttribute> _values; ///< user primvars
    mutable std::once_flag _isRead;
};

} // namespace

std::shared_ptr<const ChunkSource>
MakePointSource(std::shared_ptr<const GeometryDescription> points, const std::string& primPath,
                Warnings& warnings) {
    return std::make_shared<const PointSource>(std::move(points), primPath, warnings);
}

} // namespace hds
