// SPDX-License-Identifier: Apache-2.0
// Emissive meshes as lights: their triangles, and how these are cut into clusters, each of which is
// a light of its own. Pure functions; any thread. Explained in docs/lights.md, "Emissive meshes".
#pragma once

#include "hdStream/shading/lightFilter.h"
#include "kernels/shared/compat.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Where a light is at a time in the shutter's interval: turned about the origin of its space, then
/// moved.
struct LightKey {
    glm::dvec4 turn{0.0, 0.0, 0.0, 1.0}; ///< unit quaternion: x, y, z, w
    glm::dvec3 offset{0.0};

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LightKey, turn), HDS_FIELD(LightKey, offset));
    }
};

/// A light whose size or emission changes, as it is in one of equal parts of the shutter's
/// interval.
struct LightCell {
    LightDescription light;
    glm::dmat4 worldFromLight{1.0}; ///< without its keys' motion, relative to the scene centre

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LightCell, light), HDS_FIELD(LightCell, worldFromLight));
    }
};

/// A light in its place.
struct PlacedLight {
    std::string name; ///< prim path, for warnings
    LightDescription light;
    glm::dmat4 worldFromLight{1.0};      ///< relative to the scene centre
    std::uint32_t lightLink = HDS_NONE;  ///< index into LinkTable::categories
    std::uint32_t shadowLink = HDS_NONE; ///< index into LinkTable::categories
    std::vector<LightPortal> portals;    ///< dome: relative to the scene centre
    std::vector<LightFilter> filters;    ///< relative to the scene centre
    std::vector<LightKey> keys;   ///< at equal distances in time, at least two; empty: it rests
    std::vector<LightCell> cells; ///< in the order of time; empty: it is `light` at all times

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(PlacedLight, name), HDS_FIELD(PlacedLight, light),
                         HDS_FIELD(PlacedLight, worldFromLight), HDS_FIELD(PlacedLight, lightLink),
                         HDS_FIELD(PlacedLight, shadowLink), HDS_FIELD(PlacedLight, portals),
                         HDS_FIELD(PlacedLight, filters), HDS_FIELD(PlacedLight, keys),
                         HDS_FIELD(PlacedLight, cells));
    }
};

/// The emissive triangles of one mesh instance with one material.
struct EmissiveMesh {
    struct Triangle {
        glm::dvec3 p[3]; ///< world, relative to the scene centre, in winding order: emits to the
                         ///< side of cross(p1 - p0, p2 - p0)
        std::uint32_t primId = 0;
        double meanEmission =
            1.0; ///< about the mean luminance of what the material emits, of hasTexturedEmission

        static constexpr auto Fields() {
            return FieldList(HDS_FIELD(Triangle, p), HDS_FIELD(Triangle, primId),
                             HDS_FIELD(Triangle, meanEmission));
        }
    };
    /// The same triangle in object space, when its vertices are at a key.
    struct Shape {
        glm::vec3 p[3];

        static constexpr auto Fields() { return FieldList(HDS_FIELD(Shape, p)); }
    };
    std::string name;
    std::vector<Triangle> triangles; ///< at rest: the instance at the frame, vertices when the
                                     ///< shutter opens
    glm::dvec3 radiance{1.0};
    bool twoSided = false;
    /// The radiance is a factor on what the material emits at each point.
    bool hasTexturedEmission = false;
    /// Of a mesh with UsdLuxMeshLightAPI: its inputs, of which `radiance` is a further factor.
    std::optional<PlacedLight> lux;
    double wholeArea = 0.0; ///< of lux: of the mesh with all its materials, for `normalize`
    /// Bound on the distance between these positions and where rays meet the triangles, besides the
    /// rounding of the positions themselves: about 2^-21 (|worldFromObject| |p| + |translation|).
    double positionError = 0.0;
    /// At equal steps in time, as the device has them, relative to the scene centre; one where the
    /// instance rests; empty: the mesh rests.
    std::vector<glm::dmat4> worldFromObject;
    std::vector<glm::dvec4> turns; ///< of these against rest, as LightKey; empty: not turned
    /// [key][triangle] at equal steps in time; one where vertices rest; empty: the mesh rests.
    std::vector<std::vector<Shape>> shapes;

    bool Moves() const { return !worldFromObject.empty(); }

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(EmissiveMesh, name), HDS_FIELD(EmissiveMesh, triangles),
                         HDS_FIELD(EmissiveMesh, radiance), HDS_FIELD(EmissiveMesh, twoSided),
                         HDS_FIELD(EmissiveMesh, hasTexturedEmission), HDS_FIELD(EmissiveMesh, lux),
                         HDS_FIELD(EmissiveMesh, wholeArea), HDS_FIELD(EmissiveMesh, positionError),
                         HDS_FIELD(EmissiveMesh, worldFromObject), HDS_FIELD(EmissiveMesh, turns),
                         HDS_FIELD(EmissiveMesh, shapes));
    }
};

/// A triangle that can be sampled.
struct EmissiveTriangle {
    glm::dvec3 p[3];
    std::uint32_t primId = 0;
    double area = 0.0;
    double weight = 0.0;    ///< area * meanEmission
    std::size_t source = 0; ///< in EmissiveMesh::triangles
};

/// What the estimate of a cluster's light is made of.
struct EmissiveCluster {
    std::size_t begin = 0; ///< of its triangles
    std::size_t end = 0;
    glm::dvec3 low{0.0}; ///< box
    glm::dvec3 high{0.0};
    double area = 0.0;
    double weight = 0.0;
    glm::dvec3 axis{0.0};  ///< unit; zero: normals cancel out
    double flatness = 0.0; ///< 1 when all normals are the axis, 0 when they cancel out
};

struct EmissiveClusters {
    std::vector<EmissiveTriangle> triangles; ///< cluster by cluster
    std::vector<EmissiveCluster> clusters;
    double area = 0.0;
    double weight = 0.0;
    bool isWeighed = false; ///< triangles differ in their emission
};

/// Leaves out triangles without area and cuts the rest where that makes lights that are better to
/// tell apart: into compact parts of at most half the mesh's size. Deterministic.
EmissiveClusters ClusterTriangles(const EmissiveMesh& mesh);

} // namespace hds
