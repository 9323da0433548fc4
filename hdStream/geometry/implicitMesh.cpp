// SPDX-License-Identifier: Apache-2.0
// The numbers below (10 sides, 10 or 4 rings, order of points, where rings are doubled) and the
// precision of every step are those of OpenUSD 25.02's pxr/imaging/geomUtil, so that a gprim that
// Hydra turned into a mesh and one that we did are the same bits.
#include "hdStream/geometry/implicitMesh.h"

#include "hdStream/base/error.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace hds {
namespace {

constexpr int kSides = 10;          ///< around the axis
constexpr int kSphereRings = 10;    ///< from pole to pole
constexpr int kCapsuleCapRings = 4; ///< per hemisphere
constexpr double kPi = 3.14159265358979323846;

/// How a tube of quads ends.
enum class Cap {
    None,     ///< open
    Shared,   ///< a fan about a pole that shares the tube's last ring: smooth
    Separate, ///< a fan with a ring of its own: a crease
};

/// Collects points, about the z axis, and faces.
class MeshBuilder {
public:
    void AddPoint(float x, float y, float z) { _points.insert(_points.end(), {x, y, z}); }
    void AddFace(std::initializer_list<int> points) {
        _counts.push_back(static_cast<std::int32_t>(points.size()));
        _indices.insert(_indices.end(), points.begin(), points.end());
    }

    /// Ring of points (x, y) scaled by `scale` at height z.
    void AddRing(const std::array<glm::vec2, kSides>& ring, float scale, float z) {
        for (const glm::vec2& p : ring) {
            AddPoint(scale * p.x, scale * p.y, z);
        }
    }

    /// Faces of a fan, `numStrips` rings of quads and a fan; points are expected in that order.
    void AddTube(int numStrips, Cap bottom, Cap top) {
        int ring = 0;
        if (bottom != Cap::None) {
            const int pole = ring++;
            for (int i = 0; i < kSides; ++i) {
                AddFace({ring + (i + 1) % kSides, ring + i, pole});
            }
            ring += bottom == Cap::Separate ? kSides : 0;
        }
        for (int strip = 0; strip < numStrips; ++strip, ring += kSides) {
            for (int i = 0; i < kSides; ++i) {
                const int j = (i + 1) % kSides;
                AddFace({ring + i, ring + j, ring + j + kSides, ring + i + kSides});
            }
        }
        if (top != Cap::None) {
            ring += top == Cap::Separate ? kSides : 0;
            for (int i = 0; i < kSides; ++i) {
                AddFace({ring + i, ring + (i + 1) % kSides, ring + kSides});
            }
        }
    }

    /// Turns z into the given axis by a cyclic exchange of coordinates. As OpenUSD's matrix product
    /// does, it turns -0 into +0.
    void Orient(const std::string& axis) {
        const int shift = axis == "X" ? 1 : (axis == "Y" ? 2 : 0);
        for (std::size_t i = 0; i < _points.size(); i += 3) {
            const std::array<float, 3> p{_points[i], _points[i + 1], _points[i + 2]};
            for (int k = 0; k < 3; ++k) {
                _points[i + (k + shift) % 3] = p[k] + 0.0F;
            }
        }
    }

    GeometryDescription Finish(const std::string& scheme) {
        GeometryDescription mesh;
        mesh.points = std::move(_points);
        mesh.faceVertexCounts = std::move(_counts);
        mesh.faceVertexIndices = std::move(_indices);
        mesh.subdivisionScheme = scheme;
        return mesh;
    }

private:
    std::vector<float> _points;
    std::vector<std::int32_t> _counts;
    std::vector<std::int32_t> _indices;
};

/// Points of the unit circle, counter-clockwise from the x axis.
std::array<glm::vec2, kSides> MakeRing() {
    std::array<glm::vec2, kSides> ring;
    for (int i = 0; i < kSides; ++i) {
        const float angle = (float(i) / float(kSides)) * static_cast<float>(2.0 * kPi);
        ring[i] = glm::vec2(std::cos(angle), std::sin(angle));
    }
    return ring;
}

GeometryDescription MakeSphere(const ImplicitShape& shape) {
    const auto radius = static_cast<float>(shape.radius);
    const auto ring = MakeRing();
    MeshBuilder builder;
    builder.AddPoint(0.0F, 0.0F, -radius);
    for (int i = 1; i < kSphereRings; ++i) {
        const auto latitude = static_cast<float>(((float(i) / float(kSphereRings)) - 0.5) * kPi);
        builder.AddRing(ring, radius * std::cos(latitude), radius * std::sin(latitude));
    }
    builder.AddPoint(0.0F, 0.0F, radius);
    builder.AddTube(kSphereRings - 2, Cap::Shared, Cap::Shared);
    return builder.Finish("catmullClark");
}

GeometryDescription MakeCylinder(const ImplicitShape& shape) {
    const auto radius = static_cast<float>(shape.radius);
    const auto radiusTop = static_cast<float>(shape.radiusTop.value_or(shape.radius));
    const auto top = static_cast<float>(0.5 * static_cast<float>(shape.height));
    const auto ring = MakeRing();
    MeshBuilder builder;
    builder.AddPoint(0.0F, 0.0F, -top);
    builder.AddRing(ring, radius, -top);
    builder.AddRing(ring, radius, -top);
    builder.AddRing(ring, radiusTop, top);
    builder.AddRing(ring, radiusTop, top);
    builder.AddPoint(0.0F, 0.0F, top);
    builder.AddTube(1, Cap::Separate, Cap::Separate);
    builder.Orient(shape.axis);
    return builder.Finish("catmullClark");
}

GeometryDescription MakeCone(const ImplicitShape& shape) {
    const auto top = static_cast<float>(0.5 * static_cast<float>(shape.height));
    const auto radius = static_cast<float>(shape.radius);
    const auto ring = MakeRing();
    MeshBuilder builder;
    builder.AddPoint(0.0F, 0.0F, -top);
    builder.AddRing(ring, radius, -top);
    builder.AddRing(ring, radius, -top);
    builder.AddRing(ring, 0.0F, top); // the tip, once per side: no smoothing across it
    builder.AddTube(1, Cap::Separate, Cap::None);
    builder.Orient(shape.axis);
    return builder.Finish("catmullClark");
}

float Lerp(double part, float a, float b) {
    return static_cast<float>((1.0 - part) * a + part * b);
}

/// Parts of two spheres and the cone, or the cylinder, that touches both.
GeometryDescription MakeCapsule(const ImplicitShape& shape) {
    const auto bottom = static_cast<float>(shape.radius);
    const auto top = static_cast<float>(shape.radiusTop.value_or(shape.radius));
    const auto height = static_cast<float>(shape.height);
    const auto quarter = static_cast<float>(0.5 * kPi);
    float latitudeOfSeam = 0.0F; // where the spheres end, on both
    std::array<float, 2> radii{bottom, top};
    std::array<float, 2> centres{0.0F, 0.0F};
    if (bottom != top && height != 0.0F) {
        const float slope = (bottom - top) / height;
        centres = {-(slope * bottom), -(slope * top)};
        for (std::size_t i = 0; i < 2; ++i) {
            radii[i] = static_cast<float>(
                std::sqrt(double{radii[i] * radii[i]} + double{centres[i] * centres[i]}));
        }
        latitudeOfSeam = std::atan(slope);
    }
    centres[0] = static_cast<float>(centres[0] - 0.5 * height);
    centres[1] = static_cast<float>(centres[1] + 0.5 * height);
    constexpr int kRings = 2 * kCapsuleCapRings;
    const int numBottom = std::clamp(
        static_cast<int>(std::rint(kRings * (0.5 * kPi + latitudeOfSeam) / kPi)), 1, kRings - 1);

    const auto ring = MakeRing();
    MeshBuilder builder;
    const auto addRing = [&](std::size_t end, float latitude) {
        builder.AddRing(ring, radii[end] * std::cos(latitude),
                        centres[end] + radii[end] * std::sin(latitude));
    };
    builder.AddPoint(0.0F, 0.0F, centres[0] - radii[0]);
    for (int i = 1; i <= numBottom; ++i) {
        addRing(0, Lerp(double(i) / numBottom, -quarter, latitudeOfSeam));
    }
    for (int i = 0; i < kRings - numBottom; ++i) {
        addRing(1, Lerp(double(i) / (kRings - numBottom), latitudeOfSeam, quarter));
    }
    builder.AddPoint(0.0F, 0.0F, centres[1] + radii[1]);
    builder.AddTube(kRings - 1, Cap::Shared, Cap::Shared);
    builder.Orient(shape.axis);
    return builder.Finish("catmullClark");
}

GeometryDescription MakeCube(const ImplicitShape& shape) {
    const auto half = static_cast<float>(0.5 * static_cast<float>(shape.size));
    MeshBuilder builder;
    for (const auto& [x, y] :
         {std::pair{half, half}, {-half, half}, {-half, -half}, {half, -half}}) {
        builder.AddPoint(x, y, half);
    }
    for (const auto& [x, y] :
         {std::pair{-half, -half}, {-half, half}, {half, half}, {half, -half}}) {
        builder.AddPoint(x, y, -half);
    }
    builder.AddFace({0, 1, 2, 3});
    builder.AddFace({4, 5, 6, 7});
    builder.AddFace({0, 6, 5, 1});
    builder.AddFace({4, 7, 3, 2});
    builder.AddFace({0, 3, 7, 6});
    builder.AddFace({4, 2, 1, 5});
    return builder.Finish("bilinear");
}

/// A quad about the origin, facing along +axis. USD: planes are double-sided by default.
GeometryDescription MakePlane(const ImplicitShape& shape) {
    const auto x = static_cast<float>(0.5F * shape.width);
    const auto y = static_cast<float>(0.5F * shape.length);
    MeshBuilder builder;
    if (shape.axis == "X") {
        builder.AddPoint(0.0F, y, x);
        builder.AddPoint(0.0F, -y, x);
        builder.AddPoint(0.0F, -y, -x);
        builder.AddPoint(0.0F, y, -x);
    } else if (shape.axis == "Y") {
        builder.AddPoint(-x, 0.0F, y);
        builder.AddPoint(x, 0.0F, y);
        builder.AddPoint(x, 0.0F, -y);
        builder.AddPoint(-x, 0.0F, -y);
    } else {
        builder.AddPoint(x, y, 0.0F);
        builder.AddPoint(-x, y, 0.0F);
        builder.AddPoint(-x, -y, 0.0F);
        builder.AddPoint(x, -y, 0.0F);
    }
    builder.AddFace({0, 1, 2, 3});
    GeometryDescription mesh = builder.Finish("bilinear");
    return mesh;
}

} // namespace

GeometryDescription MakeImplicitMesh(const ImplicitShape& shape) {
    using Maker = GeometryDescription (*)(const ImplicitShape&);
    static constexpr std::pair<const char*, Maker> kMakers[] = {
        {"Sphere", MakeSphere}, {"Cube", MakeCube},       {"Cylinder", MakeCylinder},
        {"Cone", MakeCone},     {"Capsule", MakeCapsule}, {"Plane", MakePlane},
    };
    for (const auto& [type, make] : kMakers) {
        if (shape.type == type) {
            return make(shape);
        }
    }
    throw Error("unknown implicit gprim type \"" + shape.type + "\"");
}

} // namespace hds
