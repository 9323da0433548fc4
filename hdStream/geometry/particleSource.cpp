// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/particleSource.h"

#include <algorithm>
#include <utility>

namespace hds {

ParticleSource::ParticleSource(std::shared_ptr<const GeometryDescription> particles,
                               std::uint32_t kind, const char* name, const std::string& primPath,
                               Warnings& warnings)
    : _particles(std::move(particles)), _log(primPath, warnings), _kind(kind), _name(name) {}

bool ParticleSource::CanNumber() {
    if (Count() < 0xffffffffU) {
        return true;
    }
    _log.Warn(_name + " dropped: more than 2^32 - 2");
    return false;
}

void ParticleSource::Measure(std::size_t numFloats, std::size_t numFloatsLater,
                             const char* unseen) {
    _origin = glm::dvec3(ChooseOrigin(BoundPoints(*_particles)));
    _numGroups = static_cast<std::uint32_t>(Count());
    std::size_t numBad = 0;
    for (std::uint32_t i = 0; i < _numGroups; ++i) {
        if (GroupTriangles(i) == 0) {
            numBad += HasPoint(*_particles, i) ? 0 : 1;
            continue;
        }
        ++_numTriangles;
        const Bounds bounds = GroupBounds(i);
        for (int axis = 0; axis < 3; ++axis) {
            _bounds.min[axis] = std::min(_bounds.min[axis], bounds.min[axis]);
            _bounds.max[axis] = std::max(_bounds.max[axis], bounds.max[axis]);
        }
    }
    const auto warn = [&](std::size_t count, const char* what) {
        if (count > 0) {
            _log.Warn(std::to_string(count) + " " + _name + " dropped: " + what);
        }
    };
    warn(numBad, "not finite or beyond 1e18");
    warn(_numGroups - numBad - _numTriangles, unseen);
    _numVertices = _numTriangles;
    const std::size_t vertexBytes =
        (numFloats + numFloatsLater * _particles->keys.size()) * sizeof(float);
    _boundBytes = SolidBytes(_values, 1.0, vertexBytes, NumPoses(), false);
    _meanBytes = SolidBytes(_values, 1.0, vertexBytes, NumPoses(), true);
}

Bounds ParticleSource::GroupBounds(std::uint32_t group) const {
    Bounds bounds;
    if (GroupTriangles(group) > 0) {
        for (std::size_t pose = 0; pose < NumPoses(); ++pose) {
            Extend(group, pose, &bounds);
        }
    }
    return bounds;
}

ChunkGeometry ParticleSource::Gather(const std::uint32_t* groups, std::size_t count) const {
    std::call_once(_isRead, [this] {
        for (const GeometryAttribute& attribute : _values) {
            WarnNotFinite(attribute, _log.PrimPath(), _log.Sink());
        }
    });
    ChunkGeometry chunk;
    chunk.primitives = _kind;
    chunk.attributes = _values;
    chunk.keys.resize(NumPoses() - 1);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t group = groups[i];
        if (GroupTriangles(group) == 0) {
            continue;
        }
        chunk.triangles.emplace_back(static_cast<std::uint32_t>(chunk.points.size()), 0U, 0U);
        chunk.points.push_back(group);
        AddShape(group, &chunk);
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

void ParticleSource::Add(std::uint32_t group, std::size_t pose, std::vector<glm::vec3>* positions,
                         std::vector<float>* values, std::vector<Bounds>* bounds) const {
    positions->push_back(*FindPointAt(*_particles, pose, group) - glm::vec3(_origin));
    values->push_back(ValueAt(pose, group));
    bounds->emplace_back();
    Extend(group, pose, &bounds->back());
}

} // namespace hds
