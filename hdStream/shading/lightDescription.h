// SPDX-License-Identifier: Apache-2.0
// A UsdLux light as the front ends translate it: authored values, units as UsdLux states them.
#pragma once

#include "hdStream/shading/materialNetwork.h"

#include <glm/mat4x4.hpp>

#include <array>
#include <string>

namespace hds {

/// The UsdLux types the core renders. Mesh: a mesh with UsdLuxMeshLightAPI.
enum class LightType { Distant, Sphere, Rect, Disk, Cylinder, Dome, Mesh };

/// How a mesh light and the material of its mesh go together (UsdLuxLightAPI's materialSyncMode).
enum class MaterialSyncMode {
    GlowTintsLight,     ///< what the material emits is a factor on the light
    Independent,        ///< the light does not ask the material
    NoMaterialResponse, ///< there is no material: black, and seen as it lights
};

/// How a light's radiance depends on the direction in which it leaves (UsdLuxShapingAPI). As it is,
/// on none; UsdLux's fallback of coneAngle is 90, where the schema is applied.
struct LightShaping {
    float focus = 0.0F; ///< exponent of the cosine off the axis
    std::array<float, 3> focusTint{0.0F, 0.0F, 0.0F};
    float coneAngle = 180.0F; ///< degrees off the axis
    float coneSoftness = 0.0F;
    AssetReference iesFile; ///< authoredPath empty when there is none
    float iesAngleScale = 0.0F;
    bool iesNormalize = false;
};

/// What shadows a light casts (UsdLuxShadowAPI).
struct LightShadow {
    bool enable = true;
    std::array<float, 3> color{0.0F, 0.0F, 0.0F};
    float distance = -1.0F;    ///< of occluders from what they shade; negative: any
    float falloff = -1.0F;     ///< length, up to the distance, over which the shadow fades
    float falloffGamma = 1.0F; ///< exponent of what is left of the shadow
};

/// A rect in the xy plane of its space through which the light of a dome comes, towards -z
/// (UsdLuxPortalLight).
struct LightPortal {
    glm::dmat4 worldFromPortal{1.0};
    float width = 1.0F;
    float height = 1.0F;
};

/// Authored inputs of a light; defaults are UsdLux's.
struct LightDescription {
    LightType type = LightType::Distant;
    float intensity =
        1.0F; ///< nits (distant: 50000 is UsdLux's own default; the front end fills it)
    float exposure = 0.0F;
    float diffuse = 1.0F;  ///< multiplier on what diffuse lobes receive
    float specular = 1.0F; ///< multiplier on what specular lobes receive
    bool normalize = false;
    std::array<float, 3> color{1.0F, 1.0F, 1.0F};
    bool enableColorTemperature = false;
    float colorTemperature = 6500.0F;        ///< kelvin
    float angle = 0.53F;                     ///< distant: degrees, full cone
    float radius = 0.5F;                     ///< sphere, disk, cylinder: scene units
    float width = 1.0F;                      ///< rect
    float height = 1.0F;                     ///< rect
    float length = 1.0F;                     ///< cylinder
    bool treatAsPoint = false;               ///< sphere
    bool treatAsLine = false;                ///< cylinder
    std::string textureFormat = "automatic"; ///< dome: automatic, latlong
    AssetReference textureFile;              ///< dome, rect: authoredPath empty when there is none
    LightShaping shaping;
    LightShadow shadow;
    bool visibleToCamera = true;
};

/// An input that multiplies light: what is negative or not finite counts as 0.
float LightFactor(float value);

/// Whether shadows are weaker the farther away is what casts them.
bool IsFading(const LightShadow& shadow);

/// Whether the light shines alike in all directions.
bool IsUnshaped(const LightDescription& light);

} // namespace hds
