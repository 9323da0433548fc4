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
        const std::size_t vertexBytes = (Moves() ? 8 : 4) * sizeof(float);
        _boundBytes = SolidBytes(_values, 1.0, vertexBytes, Moves(), false);
        _meanBytes = SolidBytes(_values, 1.0, vertexBytes, Moves(), true);
    }

    std::uint32_t GroupTriangles(std::uint32_t group) const override {
        return FindPoint(*_points, group) && (!Moves() || FindClosePoint(*_points, group)) &&
                       RadiusOf(_widths, group) > 0.0F
                   ? 1
                   : 0;
    }
    Bounds GroupBounds(std::uint32_t group) const override {
        Bounds bounds;
        if (GroupTriangles(group) > 0) {
            ExtendBySolid(glm::dvec3(*FindPoint(*_points, group)) - _origin,
                          RadiusOf(_widths, group), &bounds);
            if (Moves()) {
                ExtendBySolid(glm::dvec3(*FindClosePoint(*_points, group)) - _origin,
                              RadiusOf(_widths, group), &bounds);
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
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t group = groups[i];
            if (GroupTriangles(group) == 0) {
                continue;
            }
            chunk.triangles.emplace_back(static_cast<std::uint32_t>(chunk.points.size()), 0U, 0U);
            chunk.points.push_back(group);
            chunk.positions.push_back(*FindPoint(*_points, group) - glm::vec3(_origin));
            if (Moves()) {
                chunk.closePositions.push_back(*FindClosePoint(*_points, group) -
                                               glm::vec3(_origin));
            }
            chunk.radii.push_back(RadiusOf(_widths, group));
            chunk.primIds.push_back(group);
            chunk.faces.push_back(group);
            chunk.primitiveBounds.push_back(BoundAt(*FindPoint(*_points, group), group));
            if (Moves()) {
                chunk.closePrimitiveBounds.push_back(
                    BoundAt(*FindClosePoint(*_points, group), group));
            }
        }
        return chunk;
    }

private:
    Bounds BoundAt(const glm::vec3& point, std::uint32_t group) const {
        Bounds bounds;
        ExtendBySolid(glm::dvec3(point) - _origin, RadiusOf(_widths, group), &bounds);
        return bounds;
    }
    bool Moves() const { return !_points->closePoints.empty(); }

    std::shared_ptr<const GeometryDescription> _points;
    mutable PrimLog _log;
    GeometryAttribute _widths;
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
