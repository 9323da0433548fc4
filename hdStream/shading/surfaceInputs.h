// SPDX-License-Identifier: Apache-2.0
// The inputs of MaterialX's surface shaders that layeredMaterial.cpp reads, with the defaults of
// their definitions (testenv/python/test_surfaceInputs.py compares them). Normals and tangents,
// which have no default, are not here.
#pragma once

#include <cstdint>
#include <string_view>

namespace hds {

struct SurfaceInput {
    std::string_view name;
    std::uint32_t numComponents;
    float fallback; ///< of each component
};

constexpr SurfaceInput kStandardSurfaceInputs[] = {
    {"base", 1, 1.0F},
    {"base_color", 3, 0.8F},
    {"diffuse_roughness", 1, 0.0F},
    {"metalness", 1, 0.0F},
    {"specular", 1, 1.0F},
    {"specular_color", 3, 1.0F},
    {"specular_roughness", 1, 0.2F},
    {"specular_IOR", 1, 1.5F},
    {"specular_anisotropy", 1, 0.0F},
    {"specular_rotation", 1, 0.0F},
    {"transmission", 1, 0.0F},
    {"transmission_color", 3, 1.0F},
    {"transmission_depth", 1, 0.0F},
    {"transmission_scatter", 3, 0.0F},
    {"transmission_dispersion", 1, 0.0F},
    {"transmission_extra_roughness", 1, 0.0F},
    {"subsurface", 1, 0.0F},
    {"subsurface_color", 3, 1.0F},
    {"sheen", 1, 0.0F},
    {"sheen_color", 3, 1.0F},
    {"sheen_roughness", 1, 0.3F},
    {"coat", 1, 0.0F},
    {"coat_color", 3, 1.0F},
    {"coat_roughness", 1, 0.1F},
    {"coat_anisotropy", 1, 0.0F},
    {"coat_IOR", 1, 1.5F},
    {"coat_affect_color", 1, 0.0F},
    {"coat_affect_roughness", 1, 0.0F},
    {"thin_film_thickness", 1, 0.0F},
    {"thin_film_IOR", 1, 1.5F},
    {"emission", 1, 0.0F},
    {"emission_color", 3, 1.0F},
    {"opacity", 3, 1.0F},
    {"thin_walled", 1, 0.0F},
};

constexpr SurfaceInput kOpenPbrInputs[] = {
    {"base_weight", 1, 1.0F},
    {"base_color", 3, 0.8F},
    {"base_diffuse_roughness", 1, 0.0F},
    {"base_metalness", 1, 0.0F},
    {"specular_weight", 1, 1.0F},
    {"specular_color", 3, 1.0F},
    {"specular_roughness", 1, 0.3F},
    {"specular_ior", 1, 1.5F},
    {"specular_roughness_anisotropy", 1, 0.0F},
    {"transmission_weight", 1, 0.0F},
    {"transmission_color", 3, 1.0F},
    {"transmission_depth", 1, 0.0F},
    {"transmission_scatter", 3, 0.0F},
    {"transmission_dispersion_scale", 1, 0.0F},
    {"subsurface_weight", 1, 0.0F},
    {"subsurface_color", 3, 0.8F},
    {"fuzz_weight", 1, 0.0F},
    {"fuzz_color", 3, 1.0F},
    {"fuzz_roughness", 1, 0.5F},
    {"coat_weight", 1, 0.0F},
    {"coat_color", 3, 1.0F},
    {"coat_roughness", 1, 0.0F},
    {"coat_roughness_anisotropy", 1, 0.0F},
    {"coat_ior", 1, 1.6F},
    {"coat_darkening", 1, 1.0F},
    {"thin_film_weight", 1, 0.0F},
    {"thin_film_thickness", 1, 0.5F},
    {"thin_film_ior", 1, 1.4F},
    {"emission_luminance", 1, 0.0F},
    {"emission_color", 3, 1.0F},
    {"geometry_opacity", 1, 1.0F},
    {"geometry_thin_walled", 1, 0.0F},
};

constexpr SurfaceInput kGltfInputs[] = {
    {"base_color", 3, 1.0F},
    {"metallic", 1, 1.0F},
    {"roughness", 1, 1.0F},
    {"transmission", 1, 0.0F},
    {"specular", 1, 1.0F},
    {"specular_color", 3, 1.0F},
    {"ior", 1, 1.5F},
    {"alpha", 1, 1.0F},
    {"alpha_mode", 1, 0.0F},
    {"alpha_cutoff", 1, 0.5F},
    {"iridescence", 1, 0.0F},
    {"iridescence_ior", 1, 1.3F},
    {"iridescence_thickness", 1, 100.0F},
    {"sheen_color", 3, 0.0F},
    {"sheen_roughness", 1, 0.0F},
    {"clearcoat", 1, 0.0F},
    {"clearcoat_roughness", 1, 0.0F},
    {"emissive", 3, 0.0F},
    {"emissive_strength", 1, 1.0F},
    {"thickness", 1, 0.0F},
    {"attenuation_distance", 1, 0.0F},
    {"attenuation_color", 3, 1.0F},
    {"anisotropy_strength", 1, 0.0F},
    {"dispersion", 1, 0.0F},
};

constexpr SurfaceInput kUnlitInputs[] = {
    {"emission", 1, 1.0F},
    {"emission_color", 3, 1.0F},
    {"transmission", 1, 0.0F},
    {"opacity", 1, 1.0F},
};

} // namespace hds
