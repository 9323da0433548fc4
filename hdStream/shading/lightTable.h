// SPDX-License-Identifier: Apache-2.0
// Lights of a scene as the tables of kernels/light: UsdLux lights, and emissive meshes as lights.
// Deterministic; called by commit, any thread. Explained in docs/lights.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/emissiveMesh.h"
#include "hdStream/shading/iesProfile.h"
#include "hdStream/shading/lightImage.h"
#include "kernels/shared/light.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Which link sets are in which categories.
struct LinkTable {
    std::uint32_t numSets = 1;
    std::vector<std::vector<bool>> categories; ///< [category][link set]

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LinkTable, numSets), HDS_FIELD(LinkTable, categories));
    }
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
    LoadFilterImage loadFilterImage = {};
};

/// Device tables of all lights.
struct LightTable {
    std::vector<shared::HdsLight> lights;    ///< those at infinity first
    std::vector<shared::HdsLightNode> nodes; ///< the light tree
    std::vector<shared::HdsLightTriangle> triangles;
    std::vector<float> cdf;           ///< lightCdf
    std::uint32_t numImages = 0;      ///< of the lights, so many have an image
    std::uint64_t numCells = 0;       ///< records of parts of the shutter, of lights that change
    bool hasShaping = false;          ///< some light is shaped
    bool hasControls = false;         ///< some is linked, or has multipliers or shadow controls
    bool hasMotion = false;           ///< some light moves while the shutter is open
    bool hasFilters = false;          ///< some light has a filter of what passes it
    bool hasPortals = false;          ///< some is a dome with portals
    bool hasMeshes = false;           ///< some is a mesh
    std::vector<std::string> groups;  ///< of lights, by the number that lights have: from 1 on
    bool hasTexturedEmission = false; ///< some is a mesh with HDS_LIGHT_TEXTURED_EMISSION
    /// For each emissive mesh of the input where its HDS_MESH_LIGHT begins in `cdf`, or HDS_NONE
    /// (black or no area).
    std::vector<std::uint32_t> tableByMesh;
};

/// Builds the tables. Lights that are black are left out; lights that cannot be rendered (singular
/// transform, size 0, values not finite) are left out with a warning.
LightTable BuildLightTable(const std::vector<PlacedLight>& lights,
                           const std::vector<EmissiveMesh>& meshes, const LightTableInput& input,
                           Warnings& warnings);

} // namespace hds
