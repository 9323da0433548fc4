// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/triangleMeshSource.h"

#include "hdStream/base/error.h"
#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/pointNumbering.h"

#include <glm/common.hpp>

#include <algorithm>
#include <utility>

namespace hds {

TriangleMeshSource::TriangleMeshSource(std::shared_ptr<const TriangleMesh> mesh)
    : _mesh(std::move(mesh)) {
    _origin = _mesh->origin;
    _bounds = _mesh->bounds;
    _numTriangles = _mesh->triangles.size();
    _numVertices = _mesh->positions.size();
    _numGroups = static_cast<std::uint32_t>(_numTriangles);
    _isLeftHanded = _mesh->leftHanded;
    for (const GeometryAttribute& attribute : _mesh->attributes) {
        _attributes.push_back({attribute.name, attribute.numComponents});
    }
    std::optional<Interpolation> normals;
    if (!_mesh->normals.values.empty()) {
        normals = _mesh->normals.interpolation;
    }
    const bool hasMaterials = !_mesh->materialEntries.empty();
    _boundBytes = BoundTriangleBytes(_mesh->attributes, normals, hasMaterials, 1);
    _meanBytes =
        MeanTriangleBytes(_mesh->attributes, normals, hasMaterials, 1,
                          VerticesPerTriangle(_mesh->positions.size(), _mesh->triangles.size()));
}

Bounds TriangleMeshSource::GroupBounds(std::uint32_t group) const {
    const glm::uvec3& triangle = _mesh->triangles[group];
    Bounds bounds;
    for (int k = 0; k < 3; ++k) {
        bounds.min = glm::min(bounds.min, _mesh->positions[triangle[k]]);
        bounds.max = glm::max(bounds.max, _mesh->positions[triangle[k]]);
    }
    return bounds;
}

ChunkGeometry TriangleMeshSource::Gather(const std::uint32_t* groups, std::size_t count) const {
    ChunkGeometry chunk;
    chunk.primIds.assign(groups, groups + count);
    chunk.triangles.resize(count);
    chunk.attributes = _mesh->attributes;
    chunk.normals = _mesh->normals;
    PointNumbering numbering(std::min(count * 3, _mesh->positions.size()));
    for (std::size_t i = 0; i < count; ++i) {
        HDS_VERIFY(groups[i] < _mesh->triangles.size(),
                   "triangle " + std::to_string(groups[i]) + " of " +
                       std::to_string(_mesh->triangles.size()));
        for (int k = 0; k < 3; ++k) {
            chunk.triangles[i][k] = numbering.Number(_mesh->triangles[groups[i]][k], chunk.points);
        }
        chunk.faces.push_back(_mesh->faces[groups[i]]);
        chunk.corners.push_back(_mesh->corners[groups[i]]);
        if (!_mesh->materialEntries.empty()) {
            chunk.materialEntries.push_back(_mesh->materialEntries[groups[i]]);
        }
    }
    for (const std::uint32_t point : chunk.points) {
        chunk.positions.push_back(_mesh->positions[point]);
    }
    return chunk;
}

} // namespace hds
