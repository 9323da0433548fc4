// SPDX-License-Identifier: Apache-2.0
// Lights of a scene as the tables of kernels/light: UsdLux lights, and emissive meshes as lights.
// Deterministic; called by commit, any thread. Explained in docs/lights.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/iesProfile.h"
#include "hdStream/shading/lightDescription.h"
#include "hdStream/shading/lightImage.h"
#include "kernels/shared/light.h"

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// A light in its place.
struct PlacedLight {
    std::string name; ///< prim path, for warnings
    LightDescription light;
    glm::dmat4 worldFromLight{1.0};      ///< relative to the scene centre
    std::uint32_t lightLink = HDS_NONE;  ///< index into LinkTable::categories
    std::uint32_t shadowLink = HDS_NONE; ///< likewise
};

/// Which link sets are in which categories.
struct LinkTable {
    std::uint32_t numSets = 1;
    std::vector<std::vector<bool>> categories; ///< [category][link set]
};

/// The emissive triangles of one mesh instance with one radiance.
struct EmissiveMesh {
    struct Triangle {
        glm::dvec3 p[3]; ///< world, relative to the scene centre, in winding order: emits to the
                         ///< side of cross(p1 - p0, p2 - p0)
        std::uint32_t primId = 0;
    };
    std::string name;
    std::vector<Triangle> triangles;
    glm::dvec3 radiance{0.0};
    bool twoSided = false;
    /// Bound on the distance between these positions and where rays meet the triangles, besides the
    /// rounding of the positions themselves: about 2^-21 (|worldFromObject| |p| + |translation|).
    double positionError = 0.0;
};

/// Reads an image that a light names. May be empty.
using LoadLightImage = std::function<LightTexture(const AssetReference&)>;

/// Reads a profile that a light names; null, after a warning, when it cannot be used. May be empty.
using LoadIesProfile = std::function<std::shared_ptr<const IesProfile>(const AssetReference&)>;

/// What else the tables are made of.
struct LightTableInput {
    LoadLightImage loadImage;
    LoadIesProfile loadProfile;
    LinkTable links;
};

/// Device tables of all lights.
struct LightTable {
    std::vector<shared::HdsLight> lights;    ///< those at infinity first
    std::vector<shared::HdsLightNode> nodes; ///< the light tree
    std::vector<shared::HdsLightTriangle> triangles;
    std::vector<float> cdf;      ///< lightCdf
    std::uint32_t numImages = 0; ///< of the lights, so many have an image
    bool hasShaping = false;     ///< some light is shaped
    bool hasControls = false;    ///< some is linked, or has multipliers or shadow controls
    /// For each emissive mesh of the input its index in `lights`, or HDS_NONE (black or no area).
    std::vector<std::uint32_t> lightByMesh;
};

/// Builds the tables. Lights that are black are left out; lights that cannot be rendered (singular
/// transform, size 0, values not finite) are left out with a warning.
LightTable BuildLightTable(const std::vector<PlacedLight>& lights,
                           const std::vector<EmissiveMesh>& meshes, const LightTableInput& input,
                           Warnings& warnings);

} // namespace hds
