// SPDX-License-Identifier: Apache-2.0
// The attribute page of a chunk: slot words, then one block of values per slot, each aligned to 16
// bytes. Layout: kernels/shared/geometry.h; reader: kernels/shading/attributes.clh.
#include "hdStream/geometry/attributePage.h"
#include "hdStream/base/error.h"
#include "hdStream/geometry/primvars.h"
#include "kernels/shared/geometry.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hds {
namespace {

constexpr std::size_t kUnit = HDS_POOL_UNIT_BYTES;
std::size_t RoundUp(std::size_t bytes) {
    return (bytes + kUnit - 1) / kUnit * kUnit;
}

/// HDS_ATTR_* of an interpolation.
std::uint32_t PageInterpolation(Interpolation interpolation) {
    switch (interpolation) {
    case Interpolation::Uniform:
        return HDS_ATTR_TRIANGLE;
    case Interpolation::Varying:
        return HDS_ATTR_LINEAR;
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

/// Values a triangle adds to a block of this interpolation.
double ValuesPerTriangle(std::uint32_t interpolation, double verticesPerTriangle) {
    switch (interpolation) {
    case HDS_ATTR_TRIANGLE:
        return 1.0;
    case HDS_ATTR_VERTEX:
    case HDS_ATTR_LINEAR:
        return verticesPerTriangle;
    case HDS_ATTR_CORNER:
        return 3.0;
    default:
        return 0.0;
    }
}

/// Bytes of a chunk's BVH per triangle: no build is emptier on average; measured on dense meshes
/// (docs/accel.md).
constexpr double kMostNodeBytes = 32.0;
constexpr double kMeanNodeBytes = 22.0;

TriangleBytes EstimateTriangle(const std::vector<GeometryAttribute>& attributes,
                               std::optional<Interpolation> normals, bool hasMaterials,
                               double verticesPerTriangle, double nodeBytes,
                               std::size_t vertexBytes = sizeof(glm::vec3), int numNormals = 1) {
    const auto blockBytes = [&](Interpolation interpolation, std::uint32_t numFloats) {
        return ValuesPerTriangle(PageInterpolation(interpolation), verticesPerTriangle) *
               numFloats * sizeof(float);
    };
    double bytes = sizeof(std::uint32_t); // authored face
    bytes += hasMaterials ? sizeof(std::uint32_t) : 0.0;
    bytes += normals ? numNormals * blockBytes(*normals, 3) : 0.0;
    for (const GeometryAttribute& attribute : attributes) {
        bytes += blockBytes(attribute.interpolation, attribute.NumFloats());
    }
    const double geometry = nodeBytes + sizeof(shared::HdsTriangle) +
                            sizeof(std::uint32_t) + // primId
                            verticesPerTriangle * static_cast<double>(vertexBytes);
    return {static_cast<std::uint32_t>(std::ceil(geometry)),
            static_cast<std::uint32_t>(std::ceil(bytes))};
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
    explicit PageBuilder(const ChunkGeometry& chunk)
        : _chunk(chunk),
          _bytes(RoundUp((HDS_SLOT_USER + chunk.attributes.size() + chunk.keys.size()) *
                         sizeof(std::uint32_t))) {}

    std::vector<std::uint8_t> Build() {
        AddArray(HDS_SLOT_FACE, HDS_ATTR_TRIANGLE, 1, _chunk.faces);
        AddMaterials();
        if (!_chunk.normals.values.empty()) {
            AddValues(HDS_SLOT_NORMAL, _chunk.normals,
                      [](const float* from, float* to) { CopyUnit(from, to); });
        }
        for (std::size_t i = 0; i < _chunk.attributes.size(); ++i) {
            const GeometryAttribute& attribute = _chunk.attributes[i];
            AddValues(
                static_cast<std::uint32_t>(HDS_SLOT_USER + i), attribute,
                [&](const float* from, float* to) { CopyFinite(from, attribute.NumFloats(), to); });
        }
        for (std::size_t i = 0; i < _chunk.keys.size(); ++i) {
            if (_chunk.keys[i].normals.empty()) {
                continue;
            }
            GeometryAttribute normals = _chunk.normals;
            normals.values = _chunk.keys[i].normals;
            AddValues(static_cast<std::uint32_t>(HDS_SLOT_USER + _chunk.attributes.size() + i),
                      normals, [](const float* from, float* to) { CopyUnit(from, to); });
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

    /// Absent when every triangle has entry 0, one value when all agree.
    void AddMaterials() {
        const std::vector<std::uint32_t>& entries = _chunk.materialEntries;
        if (entries.empty()) {
            return;
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
    void AddValues(std::uint32_t slot, const GeometryAttribute& attribute, CopyTuple copyTuple) {
        const std::uint32_t interpolation = PageInterpolation(attribute.interpolation);
        const std::uint32_t numComponents = attribute.numComponents;
        const std::size_t numTriangles = _chunk.primIds.size();
        const std::size_t numValues = interpolation == HDS_ATTR_CONSTANT   ? 1
                                      : interpolation == HDS_ATTR_VERTEX   ? _chunk.points.size()
                                      : interpolation == HDS_ATTR_LINEAR   ? _chunk.joints.size()
                                      : interpolation == HDS_ATTR_TRIANGLE ? numTriangles
                                                                           : 3 * numTriangles;
        std::vector<float> values(numValues * attribute.NumFloats());
        float* to = values.data();
        const auto add = [&](std::size_t element) {
            copyTuple(ValueOf(attribute, element), to);
            to += attribute.NumFloats();
        };
        if (interpolation == HDS_ATTR_CONSTANT) {
            add(0);
        } else if (interpolation == HDS_ATTR_VERTEX) {
            std::for_each(_chunk.points.begin(), _chunk.points.end(), add);
        } else if (interpolation == HDS_ATTR_LINEAR) {
            std::for_each(_chunk.joints.begin(), _chunk.joints.end(), add);
        } else if (interpolation == HDS_ATTR_TRIANGLE) {
            std::for_each(_chunk.faces.begin(), _chunk.faces.end(), add);
        } else {
            for (const glm::uvec3& corners : _chunk.corners) {
                for (int k = 0; k < 3; ++k) {
                    add(corners[k]);
                }
            }
        }
        AddArray(slot, interpolation, numComponents, values);
    }

    const ChunkGeometry& _chunk;
    std::vector<std::uint8_t> _bytes;
};

} // namespace

std::vector<std::uint8_t> BuildAttributePage(const ChunkGeometry& chunk) {
    return PageBuilder(chunk).Build();
}

double VerticesPerTriangle(std::size_t numPoints, std::size_t numTriangles) {
    constexpr double kBorder = 1.25;
    return std::min(3.0, kBorder * static_cast<double>(numPoints) /
                             static_cast<double>(std::max<std::size_t>(1, numTriangles)));
}

TriangleBytes MeanTriangleBytes(const std::vector<GeometryAttribute>& attributes,
                                std::optional<Interpolation> normals, bool hasMaterials,
                                std::size_t numPoses, double verticesPerTriangle) {
    return EstimateTriangle(attributes, normals, hasMaterials, verticesPerTriangle,
                            static_cast<double>(numPoses) * kMeanNodeBytes,
                            numPoses * sizeof(glm::vec3), static_cast<int>(numPoses));
}

TriangleBytes BoundTriangleBytes(const std::vector<GeometryAttribute>& attributes,
                                 std::optional<Interpolation> normals, bool hasMaterials,
                                 std::size_t numPoses) {
    return EstimateTriangle(attributes, normals, hasMaterials, 3.0,
                            static_cast<double>(numPoses) * kMostNodeBytes,
                            numPoses * sizeof(glm::vec3), static_cast<int>(numPoses));
}

TriangleBytes SolidBytes(const std::vector<GeometryAttribute>& attributes,
                         double verticesPerPrimitive, std::size_t vertexBytes, std::size_t numPoses,
                         bool mean) {
    const double nodeBytes =
        static_cast<double>(numPoses) * (mean ? kMeanNodeBytes : kMostNodeBytes);
    return EstimateTriangle(attributes, std::nullopt, false, verticesPerPrimitive, nodeBytes,
                            vertexBytes);
}

} // namespace hds
