// SPDX-License-Identifier: Apache-2.0
#include "testenv/support/dicedSource.h"

#include "hdStream/geometry/subdivSource.h"

#include <glm/geometric.hpp>

#include <map>
#include <random>
#include <tuple>

namespace hds::test {
namespace {

constexpr int kSize = 4; ///< faces along a side of the cube that becomes the cage

/// A cube of kSize^2 quads a side, blown up to the unit sphere.
class CageBuilder {
public:
    explicit CageBuilder(bool isTriangles) : _isTriangles(isTriangles) {}

    GeometryDescription Build(const std::string& scheme) {
        for (int side = 0; side < 6; ++side) {
            for (int b = 0; b < kSize; ++b) {
                for (int a = 0; a < kSize; ++a) {
                    AddFace(side, a, b);
                }
            }
        }
        GeometryDescription mesh;
        mesh.subdivisionScheme = scheme;
        mesh.points = _points;
        mesh.faceVertexCounts = _counts;
        mesh.faceVertexIndices = _indices;
        mesh.subdivTags.Edit().creaseIndices = _creases;
        mesh.subdivTags.Edit().creaseLengths = std::vector<std::int32_t>(_sharpnesses.size(), 2);
        mesh.subdivTags.Edit().creaseSharpnesses = _sharpnesses;
        Primvar bumps;
        bumps.name = "bumps";
        bumps.interpolation = Interpolation::Vertex;
        std::vector<float> amounts;
        for (std::size_t i = 0; i < _points.size() / 3; ++i) {
            amounts.push_back(0.12F * float(_random() % 1000) / 1000.0F);
        }
        bumps.values = amounts;
        mesh.primvars = {bumps};
        return mesh;
    }

private:
    std::int32_t Point(int x, int y, int z) {
        const auto [found, isNew] =
            _pointAt.emplace(std::make_tuple(x, y, z), std::int32_t(_points.size() / 3));
        if (isNew) {
            const glm::vec3 p = glm::normalize(glm::vec3(x, y, z) - 0.5F * kSize);
            _points.insert(_points.end(), {p.x, p.y, p.z});
        }
        return found->second;
    }

    void AddFace(int side, int a, int b) {
        const int axis = side / 2;
        const auto at = [&](int da, int db) {
            int p[3];
            p[axis] = side % 2 * kSize;
            p[(axis + 1) % 3] = a + da;
            p[(axis + 2) % 3] = b + db;
            return Point(p[0], p[1], p[2]);
        };
        std::int32_t quad[] = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
        if (side % 2 == 0) {
            std::swap(quad[1], quad[3]);
        }
        if (_isTriangles || (a + b + side) % 5 == 0) {
            _counts.insert(_counts.end(), {3, 3});
            _indices.insert(_indices.end(), {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]});
        } else {
            _counts.push_back(4);
            _indices.insert(_indices.end(), quad, quad + 4);
        }
        if (_random() % 3 == 0) {
            _creases.insert(_creases.end(), {quad[0], quad[1]});
            _sharpnesses.push_back(_random() % 2 == 0 ? 10.0F : 2.5F);
        }
    }

    bool _isTriangles;
    std::mt19937 _random{7};
    std::map<std::tuple<int, int, int>, std::int32_t> _pointAt;
    std::vector<float> _points;
    std::vector<std::int32_t> _counts;
    std::vector<std::int32_t> _indices;
    std::vector<std::int32_t> _creases;
    std::vector<float> _sharpnesses;
};

} // namespace

std::shared_ptr<const ChunkSource> MakeDicedSource(const std::string& scheme) {
    // From close by: levels from 1, beside the image, to 6.
    DicingOptions options;
    options.isAdaptive = true;
    options.level = 6;
    options.maxBumpPixels = 8.0;
    options.view.imageSize = {256.0, 256.0};
    options.view.windowMin = glm::dvec2(-0.4);
    options.view.windowMax = glm::dvec2(0.4);
    options.view.cameraFromObject[3] = glm::dvec4(0.3, 0.2, -1.6, 1.0);
    Warnings warnings;
    const auto mesh =
        std::make_shared<const GeometryDescription>(CageBuilder(scheme == "loop").Build(scheme));
    return MakeSubdivSource(mesh, "/diced", options, {MakePrimvarAmount("bumps", 0.0)}, warnings);
}

TriangleMesh GatherMesh(const ChunkSource& source) {
    TriangleMesh mesh;
    for (std::uint32_t group = 0; group < source.NumPrimitiveGroups(); ++group) {
        const ChunkGeometry chunk = source.Gather(&group, 1);
        const auto base = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), chunk.positions.begin(), chunk.positions.end());
        for (const glm::uvec3& triangle : chunk.triangles) {
            mesh.triangles.push_back(triangle + base);
        }
    }
    return mesh;
}

} // namespace hds::test
