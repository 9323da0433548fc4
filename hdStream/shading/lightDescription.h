// SPDX-License-Identifier: Apache-2.0
// A UsdLux light as the front ends translate it: authored values, units as UsdLux states them.
#pragma once

#include "hdStream/shading/materialNetwork.h"

#include <array>
#include <string>

namespace hds {

/// The UsdLux types the core renders.
enum class LightType { Distant, Sphere, Rect, Disk, Cylinder, Dome };

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
    bool visibleToCamera = true;
};

} // namespace hds
