// SPDX-License-Identifier: Apache-2.0
// The scene as front ends hand it over: Hydra's prims without Hydra's types, keyed by prim path.
// Matrices are glm::dmat4 that act on column vectors; their memory equals GfMatrix4d's.
// Explained in docs/architecture.md.
#pragma once

#include "hdStream/geometry/meshDescription.h"
#include "hdStream/shading/lightDescription.h"
#include "hdStream/shading/materialNetwork.h"

#include <glm/mat4x4.hpp>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hds {

/// Common part of everything that is placed in space.
struct Placement {
    glm::dmat4 worldFromObject{1.0}; ///< below an instancer: prototype space from object
    std::string instancerPath;       ///< empty: not instanced
    bool visible = true;
};

/// A mesh prim.
struct MeshPrim {
    Placement placement;
    std::string purpose = "default"; ///< default, render, proxy, guide
    MeshDescription mesh;
    std::string materialPath; ///< empty: no material bound, displayColor Lambert
    int primId = -1;          ///< the front end's id for the AOV; -1: order of path
};

/// An instancer: places its prototypes (meshes, lights or instancers that name it as
/// instancerPath). worldFromPrototype(i) = parent instance * worldFromInstancer *
/// instanceTransforms[i].
struct InstancerPrim {
    Placement placement; ///< of the instancer itself (maybe below another instancer)
    SharedSpan<double> instanceTransforms; ///< [numInstances][16], memory as glm::dmat4
    /// Instances that place a prototype, by the path of the prototype (prim that names this
    /// instancer).
    std::map<std::string, SharedSpan<std::int32_t>> instancesByPrototype;
};

/// A light prim.
struct LightPrim {
    Placement placement;
    LightDescription light;
};

/// A camera. Lengths of the film back and the focal length are in tenths of a scene unit (as
/// UsdGeom).
struct CameraPrim {
    glm::dmat4 worldFromCamera{1.0};
    bool orthographic = false;
    double horizontalAperture = 20.955;
    double verticalAperture = 15.2908;
    double horizontalApertureOffset = 0.0;
    double verticalApertureOffset = 0.0;
    double focalLength = 50.0;
    double nearClip = 1.0;      ///< scene units
    double farClip = 1000000.0; ///< scene units
    double fStop = 0.0;         ///< 0: pinhole
    double focusDistance = 0.0; ///< scene units; 0: pinhole
    double exposureScale =
        1.0; ///< linear factor on radiance, 2^exposure and the photographic terms
};

/// Everything, by prim path. std::map keeps the order of paths, which is the order of identity.
struct SceneDescription {
    std::map<std::string, MeshPrim> meshes;
    std::map<std::string, InstancerPrim> instancers;
    std::map<std::string, LightPrim> lights;
    std::map<std::string, MaterialNetwork> materials;
    std::map<std::string, CameraPrim> cameras;
    double metersPerUnit = 0.01;
    std::string upAxis = "Y"; ///< "Y" or "Z"
};

} // namespace hds
