// SPDX-License-Identifier: Apache-2.0
// A UsdLux light as the front ends translate it: authored values, units as UsdLux states them.
#pragma once

#include "hdStream/base/enumTable.h"
#include "hdStream/shading/materialNetwork.h"

#include <glm/mat4x4.hpp>

#include <array>
#include <string>

namespace hds {

/// The UsdLux types the core renders. Mesh: a mesh with UsdLuxMeshLightAPI.
enum class LightType { Distant, Sphere, Rect, Disk, Cylinder, Dome, Mesh };

constexpr EnumTable<LightType, 7> NamesOf(LightType) {
    return {{{LightType::Distant, "Distant", "distant"},
             {LightType::Sphere, "Sphere", "sphere"},
             {LightType::Rect, "Rect", "rect"},
             {LightType::Disk, "Disk", "disk"},
             {LightType::Cylinder, "Cylinder", "cylinder"},
             {LightType::Dome, "Dome", "dome"},
             {LightType::Mesh, "Mesh", "mesh"}}};
}

/// How a mesh light and the material of its mesh go together (UsdLuxLightAPI's materialSyncMode).
enum class MaterialSyncMode {
    GlowTintsLight,     ///< what the material emits is a factor on the light
    Independent,        ///< the light does not ask the material
    NoMaterialResponse, ///< there is no material: black, and seen as it lights
};

constexpr EnumTable<MaterialSyncMode, 3> NamesOf(MaterialSyncMode) {
    return {{{MaterialSyncMode::GlowTintsLight, "GlowTintsLight", "materialGlowTintsLight"},
             {MaterialSyncMode::Independent, "Independent", "independent"},
             {MaterialSyncMode::NoMaterialResponse, "NoMaterialResponse", "noMaterialResponse"}}};
}

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

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LightShaping, focus), HDS_FIELD(LightShaping, focusTint),
                         HDS_FIELD(LightShaping, coneAngle), HDS_FIELD(LightShaping, coneSoftness),
                         HDS_FIELD(LightShaping, iesFile), HDS_FIELD(LightShaping, iesAngleScale),
                         HDS_FIELD(LightShaping, iesNormalize));
    }
};

/// What shadows a light casts (UsdLuxShadowAPI).
struct LightShadow {
    bool enable = true;
    std::array<float, 3> color{0.0F, 0.0F, 0.0F};
    float distance = -1.0F;    ///< of occluders from what they shade; negative: any
    float falloff = -1.0F;     ///< length, up to the distance, over which the shadow fades
    float falloffGamma = 1.0F; ///< exponent of what is left of the shadow

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LightShadow, enable), HDS_FIELD(LightShadow, color),
                         HDS_FIELD(LightShadow, distance), HDS_FIELD(LightShadow, falloff),
                         HDS_FIELD(LightShadow, falloffGamma));
    }
};

/// A rect in the xy plane of its space through which the light of a dome comes, towards -z
/// (UsdLuxPortalLight).
struct LightPortal {
    glm::dmat4 worldFromPortal{1.0};
    float width = 1.0F;
    float height = 1.0F;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LightPortal, worldFromPortal), HDS_FIELD(LightPortal, width),
                         HDS_FIELD(LightPortal, height));
    }
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
    std::string colorSpace; ///< of color, focusTint and the shadow's color; empty: none is said
    bool enableColorTemperature = false;
    float colorTemperature = 6500.0F; ///< kelvin
    float angle = 0.53F;              ///< degrees, full cone
    float radius = 0.5F;              ///< scene units
    float width = 1.0F;
    float height = 1.0F;
    float length = 1.0F;
    bool treatAsPoint = false;
    bool treatAsLine = false;
    std::string textureFormat = "automatic"; ///< automatic, latlong
    AssetReference textureFile;              ///< dome, rect: authoredPath empty when there is none
    LightShaping shaping;
    LightShadow shadow;
    bool visibleToCamera = true;
    std::string group; ///< that light path expressions know it by; empty: of none

    /// In the order of the dump, and which lights have what.
    static constexpr auto Fields() {
        using Light = LightDescription;
        using T = LightType;
        return FieldList(
            HDS_FIELD(Light, type), HDS_FIELD(Light, intensity), HDS_FIELD(Light, exposure),
            HDS_FIELD(Light, diffuse), HDS_FIELD(Light, specular), HDS_FIELD(Light, normalize),
            HDS_FIELD(Light, color), HDS_FIELD(Light, colorSpace),
            HDS_FIELD(Light, enableColorTemperature), HDS_FIELD(Light, colorTemperature),
            HDS_FIELD(Light, visibleToCamera), HDS_FIELD(Light, group),
            HDS_FIELD(Light, angle).For(T::Distant),
            HDS_FIELD(Light, radius).For(T::Sphere, T::Disk, T::Cylinder),
            HDS_FIELD(Light, width).For(T::Rect), HDS_FIELD(Light, height).For(T::Rect),
            HDS_FIELD(Light, length).For(T::Cylinder),
            HDS_FIELD(Light, treatAsPoint).For(T::Sphere),
            HDS_FIELD(Light, treatAsLine).For(T::Cylinder),
            HDS_FIELD(Light, textureFormat).For(T::Dome), HDS_FIELD(Light, textureFile),
            HDS_FIELD(Light, shaping), HDS_FIELD(Light, shadow));
    }
};

/// What of a light changes over the shutter, at a time in frames from the frame; members are those
/// of LightDescription.
struct LightSample {
    double time = 0.0;
    float intensity = 1.0F;
    float exposure = 0.0F;
    std::array<float, 3> color{1.0F, 1.0F, 1.0F};
    float colorTemperature = 6500.0F;
    float angle = 0.53F;
    float radius = 0.5F;
    float width = 1.0F;
    float height = 1.0F;
    float length = 1.0F;

    static constexpr auto Fields() {
        return FieldList(HDS_FIELD(LightSample, time), HDS_FIELD(LightSample, intensity),
                         HDS_FIELD(LightSample, exposure), HDS_FIELD(LightSample, color),
                         HDS_FIELD(LightSample, colorTemperature), HDS_FIELD(LightSample, angle),
                         HDS_FIELD(LightSample, radius), HDS_FIELD(LightSample, width),
                         HDS_FIELD(LightSample, height), HDS_FIELD(LightSample, length));
    }
};

/// The light as it is for the frame, as a sample.
LightSample SampleOf(const LightDescription& light);

/// The light at a time between samples, which are not empty: linear, as OpenUSD has its inputs.
LightDescription LightAt(const LightDescription& light, const std::vector<LightSample>& samples,
                         double time);

/// Attributes of lights that name their group, ours and those of hosts, the first that counts
/// first.
constexpr std::array<const char*, 6> kLightGroupAttributes{
    "hdstream:light:group",       "inputs:karma:light:lpetag", "karma:light:lpetag",
    "inputs:ri:light:lightGroup", "ri:light:lightGroup",       "primvars:arnold:aov"};

/// An input that multiplies light: what is negative or not finite counts as 0.
float LightFactor(float value);

/// Whether shadows are weaker the farther away is what casts them.
bool IsFading(const LightShadow& shadow);

/// Whether the light shines alike in all directions.
bool IsUnshaped(const LightDescription& light);

} // namespace hds
