// SPDX-License-Identifier: Apache-2.0
// The attribute page of a chunk: slot words, then one block of values per slot, each aligned to 16
// bytes. Layout: kernels/shared/geometry.h; reader: kernels/shading/attributes.clh.
#include "hdStream/base/error.h"
#include "hdStream/geometry/primvars.h"
#include "hdStream/geometry/triangleMesh.h"
#include "kernels/shared/geometry.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hds {
namespace {

constexpr std::size_t kUnit = HDS_POOL_UNIT_BYTES;
/// Bytes of a BVH of a chunk per triangle that planning allows for: no leaf of PlanChunks' builds
/// is emptier on average (docs/accel.md has the measured figures, about 20).
constexpr std::size_t kNodeBytesPerTriangle = 32;

std::size_t RoundUp(std::size_t bytes) {
    return (bytes + kUnit - 1) / kUnit * kUnit;
}

/// HDS_ATTR_* of an interpolation.
std::uint32_t PageInterpolation(Interpolation interpolation) {
    switch (interpolation) {
    case Interpolation::Uniform:
        return HDS_ATTR_TRIANGLE;
    case Interpolation::Varying:
    case Interpolation::Vertex:
        return HDS_ATTR_VERTEX;
    case Interpolation::FaceVarying:
        return HDS_ATTR_CORNER;
    case Interpolation::Constant:
    case Interpolation::Instance:
        break;
    }
    return HDS_ATTR_CONSTANT;
}

/// Most values a triangle can add to a block of this interpolation.
std::size_t MaxValuesPerTriangle(std::uint32_t interpolation) {
    switch (interpolation) {
    case HDS_ATTR_TRIANGLE:
        return 1;
    case HDS_ATTR_VERTEX:
    case HDS_ATTR_CORNER:
        return 3;
    default:
        return 0;
    }
}

/// Values that are not finite read as 0 (Triangulate has warned).
void CopyFinite(const float* from, std::uint32_t count, float* to) {
    for (std::uint32_t i = 0; i < count; ++i) {
        to[i] = std::isfinite(from[i]) ? from[i] : 0.0F;
    }
}

/// Normals are stored with unit length. Those that no triangle uses may be zero and stay so.
void CopyUnit(const float* from, float* to) {
    const glm::dvec3 normal(from[0], from[1], from[2]);
    const double length = glm::length(normal);
    const glm::vec3 unit(length > 0.0 && std::isfinite(length) ? normal / length : glm::dvec3(0.0));
    std::copy(&unit.x, &unit.x + 3, to);
}

/// Writes the page slot by slot.
class PageBuilder {
public:
    PageBuilder(const TriangleMesh& mesh, const ChunkGeometry& chunk)
        : _mesh(mesh), _chunk(chunk),
          _bytes(RoundUp((HDS_SLOT_USER + mesh.attributes.size()) * sizeof(std::uint32_t))) {}

    std::vector<std::uint8_t> Build() {
        AddFaces();
        AddMaterials();
        if (!_mesh.normals.values.empty()) {
            AddValues(HDS_SLOT_NORMAL, _mesh.normals,
                      [](const float* from, float* to) { CopyUnit(from, to); });
        }
        for (std::size_t i = 0; i < _mesh.attributes.size(); ++i) {
            const MeshAttribute& attribute = _mesh.attributes[i];
            AddValues(static_cast<std::uint32_t>(HDS_SLOT_USER + i), attribute,
                      [&](const float* from, float* to) {
                          CopyFinite(from, attribute.numComponents, to);
                      });
        }
        return std::move(_bytes);
    }

private:
    /// Appends a block and writes its slot word. \return the block; valid until the next one.
    std::uint8_t* AddBlock(std::uint32_t slot, std::uint32_t interpolation,
                           std::uint32_t numComponents, std::size_t numValues) {
        const std::size_t offset = _bytes.size() / kUnit;
        HDS_VERIFY(offset < (std::size_t(1) << HDS_POOL_BUFFER_SHIFT),
                   "attribute page of " + std::to_string(_bytes.size()) + " bytes");
        _bytes.resize(_bytes.size() + RoundUp(numValues * numComponents * sizeof(std::uint32_t)));
        const std::uint32_t word =
            HDS_ATTR_SLOT(interpolation, numComponents, static_cast<std::uint32_t>(offset));
        std::memcpy(_bytes.data() + slot * sizeof(word), &word, sizeof(word));
        return _bytes.data() + offset * kUnit;
    }

    template <typename T>
    void AddArray(std::uint32_t slot, std::uint32_t interpolation, std::uint32_t numComponents,
                  const std::vector<T>& values) {
        static_assert(sizeof(T) == sizeof(std::uint32_t));
        std::uint8_t* block =
            AddBlock(slot, interpolation, numComponents, values.size() / numComponents);
        if (!values.empty()) { // a chunk may be empty, and memcpy wants pointers
            std::memcpy(block, values.data(), values.size() * sizeof(T));
        }
    }

    void AddFaces() {
        std::vector<std::uint32_t> faces;
        faces.reserve(_chunk.primIds.size());
        for (const std::uint32_t primId : _chunk.primIds) {
            faces.push_back(_mesh.faces[primId]);
        }
        AddArray(HDS_SLOT_FACE, HDS_ATTR_TRIANGLE, 1, faces);
    }

    /// Absent when every triangle has entry 0, one value when all agree.
    void AddMaterials() {
        if (_mesh.materialEntries.empty() || _chunk.primIds.empty()) {
            return;
        }
        std::vector<std::uint32_t> entries;
        entries.reserve(_chunk.primIds.size());
        for (const std::uint32_t primId : _chunk.primIds) {
            entries.push_back(_mesh.materialEntries[primId]);
        }
        const bool isSame = std::all_of(entries.begin(), entries.end(), [&](std::uint32_t entry) {
            return entry == entries.front();
        });
        if (!isSame) {
            AddArray(HDS_SLOT_MATERIAL, HDS_ATTR_TRIANGLE, 1, entries);
        } else if (entries.front() != 0) {
            AddArray<std::uint32_t>(HDS_SLOT_MATERIAL, HDS_ATTR_CONSTANT, 1, {entries.front()});
        }
    }

    template <typename CopyTuple>
    void AddValues(std::uint32_t slot, const MeshAttribute& attribute, CopyTuple copyTuple) {
        const std::uint32_t interpolation = PageInterpolation(attribute.interpolation);
        const std::uint32_t numComponents = attribute.numComponents;
        const std::size_t numTriangles = _chunk.primIds.size();
        const std::size_t numValues = interpolation == HDS_ATTR_CONSTANT ? 1
                                      : interpolation == HDS_ATTR_VERTEX
                                          ? _chunk.points.size()
                                          : numTriangles * MaxValuesPerTriangle(interpolation);
        std::vector<float> values(numValues * numComponents);
        float* to = values.data();
        const auto add = [&](std::size_t element) {
            copyTuple(ValueOf(attribute, element), to);
            to += numComponents;
        };
        if (interpolation == HDS_ATTR_CONSTANT) {
            add(0);
        } else if (interpolation == HDS_ATTR_VERTEX) {
            std::for_each(_chunk.points.begin(), _chunk.points.end(), add);
        } else if (interpolation == HDS_ATTR_TRIANGLE) {
            for (const std::uint32_t primId : _chunk.primIds) {
                add(_mesh.faces[primId]);
            }
        } else {
            for (const std::uint32_t primId : _chunk.primIds) {
                for (int k = 0; k < 3; ++k) {
                    add(_mesh.corners[primId][k]);
                }
            }
        }
        AddArray(slot, interpolation, numComponents, values);
    }

    const TriangleMesh& _mesh;
    const ChunkGeometry& _chunk;
    std::vector<std::uint8_t> _bytes;
};

/// The page's corner blocks rely on chunks that keep the order of a triangle's vertices.
void VerifyOrder(const TriangleMesh& mesh, const ChunkGeometry& chunk) {
    for (std::size_t i = 0; i < chunk.primIds.size(); ++i) {
        const glm::uvec3 local = chunk.triangles[i];
        const glm::uvec3 points(chunk.points[local.x], chunk.points[local.y],
                                chunk.points[local.z]);
        HDS_VERIFY(points == mesh.triangles[chunk.primIds[i]],
                   "chunk triangle " + std::to_string(i) + " is not the mesh's triangle " +
                       std::to_string(chunk.primIds[i]));
    }
}

} // namespace

std::vector<std::uint8_t> BuildAttributePage(const TriangleMesh& mesh, const ChunkGeometry& chunk) {
    VerifyOrder(mesh, chunk);
    return PageBuilder(mesh, chunk).Build();
}

std::size_t EstimateBytesPerTriangle(const TriangleMesh& mesh) {
    const auto blockBytes = [](const MeshAttribute& attribute) {
        return MaxValuesPerTriangle(PageInterpolation(attribute.interpolation)) *
               attribute.numComponents * sizeof(float);
    };
    std::size_t bytes = kNodeBytesPerTriangle + sizeof(shared::HdsTriangle) + sizeof(std::uint32_t);
    bytes += 9 * sizeof(float);     // positions, three vertices of its own
    bytes += sizeof(std::uint32_t); // authored face
    bytes += mesh.materialEntries.empty() ? 0 : sizeof(std::uint32_t);
    bytes += mesh.normals.values.empty() ? 0 : blockBytes(mesh.normals);
    for (const MeshAttribute& attribute : mesh.attributes) {
        bytes += blockBytes(attribute);
    }
    return bytes;
}

} // namespace hds
