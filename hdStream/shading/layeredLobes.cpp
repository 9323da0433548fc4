// SPDX-License-Identifier: Apache-2.0
// What layered surfaces of all models and closures have in common: their lobes, coats with normals
// of their own, conductors, dispersion. Explained in docs/materials.md.
#include "hdStream/shading/layeredMaterial.h"
#include "hdStream/shading/shaderMath.h"
#include "kernels/shared/dispersion.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>

namespace hds {

void SetOwnNormal(const ShaderValue& normal, LayeredMaterial* material) {
    if (!AreSame(normal, material->values[HDS_INPUT_NORMAL])) {
        const ShaderValue smooth = MakeConstant({0.0F, 0.0F, 1.0F, 1.0F}, 3);
        const ShaderValue own = normal ? normal : smooth;
        const bool isMap = own.expression->kind == ShaderExpression::Kind::Texture; // never 0
        const ShaderValue squared = MakeMath(HDS_MATH_DOT, {own, own}, 1);
        const ShaderValue isOne = MakeMath(HDS_MATH_GREATER, {squared, MakeScalar(0.0F)}, 1);
        material->values[HDS_INPUT_COAT_NORMAL] =
            isMap ? own : MakeMath(HDS_MATH_SELECT, {isOne, own, smooth}, 3);
    }
}

void SetConductor(const ShaderValue& color, const ShaderValue& edge, LayeredMaterial* material) {
    material->values[HDS_INPUT_METAL_COLOR] = color;
    material->values[HDS_INPUT_EDGE_COLOR] = Subtract(MakeScalar(-1.0F), edge, 3);
    material->lobes |= HDS_LOBE_CONDUCTOR;
}

std::uint32_t DispersionFlags(const LayeredMaterial& material) {
    constexpr float kLeast = 1.0F / (1U << 14U);
    constexpr float kMost = 2.0F - 1.0F / (1U << 10U);
    if ((material.lobes & HDS_LOBE_TRANSMISSION) == 0 || !(material.dispersion > kLeast)) {
        return 0;
    }
    const float limited = std::min(material.dispersion, kMost);
    std::uint32_t bits = 0;
    std::memcpy(&bits, &limited, sizeof(bits));
    constexpr std::uint32_t kHalf = 1U << (HDS_DISPERSION_CUT - 1U); // it is rounded
    const std::uint32_t kept = (bits - HDS_DISPERSION_FIRST + kHalf) >> HDS_DISPERSION_CUT;
    return kept << HDS_MATERIAL_DISPERSION_SHIFT;
}

void FinishLayered(LayeredMaterial* material) {
    std::array<ShaderValue, HDS_NUM_LAYERED_INPUTS>& values = material->values;
    const auto has = [&](std::uint32_t input) {
        return values[input] && !IsAll(values[input], 0.0F);
    };
    const std::uint32_t conductor =
        has(HDS_INPUT_METALLIC) ? material->lobes & HDS_LOBE_CONDUCTOR : 0U;
    const bool isSchlicks = has(HDS_INPUT_SPECULAR_WEIGHT) && values[HDS_INPUT_SCHLICK_EXPONENT];
    material->lobes = HDS_LOBE_BASE | conductor | (has(HDS_INPUT_CLEARCOAT) ? HDS_LOBE_COAT : 0U) |
                      (has(HDS_INPUT_SHEEN) ? HDS_LOBE_SHEEN : 0U) |
                      (values[HDS_INPUT_STRETCH] ? HDS_LOBE_ANISOTROPY : 0U) |
                      (values[HDS_INPUT_FILM] ? HDS_LOBE_FILM : 0U) |
                      (isSchlicks ? HDS_LOBE_SCHLICK : 0U) |
                      (has(HDS_INPUT_RETRO) ? HDS_LOBE_RETRO : 0U) |
                      (has(HDS_INPUT_COVER) ? HDS_LOBE_COVERED : 0U) |
                      (has(HDS_INPUT_CLEARCOAT) &&
                               (values[HDS_INPUT_COAT_NORMAL] || values[HDS_INPUT_COAT_STRETCH])
                           ? HDS_LOBE_COAT_FRAME
                           : 0U) |
                      (has(HDS_INPUT_TRANSMISSION) ? HDS_LOBE_TRANSMISSION : 0U) |
                      (has(HDS_INPUT_TRANSLUCENCY) || (material->flags & HDS_MATERIAL_MEDIUM) != 0
                           ? HDS_LOBE_TRANSLUCENCY
                           : 0U);
    constexpr std::uint32_t kFrosted = HDS_MATERIAL_THIN_WALLED | HDS_MATERIAL_FROSTED;
    if ((material->lobes & HDS_LOBE_TRANSMISSION) != 0 &&
        (material->flags & kFrosted) == kFrosted) {
        material->lobes |= HDS_LOBE_FROST;
    }
    if (values[HDS_INPUT_HAIR] && IsAll(values[HDS_INPUT_HAIR], 1.0F)) {
        material->lobes = 0; // nothing else, whatever is chosen
    }
    // What belongs to lobes that are not there would only make programs longer.
    const auto drop = [&](std::uint32_t lobe, std::initializer_list<std::uint32_t> inputs) {
        for (const std::uint32_t input : inputs) {
            values[input] = (material->lobes & lobe) != 0 ? values[input] : ShaderValue{};
        }
    };
    drop(HDS_LOBE_COAT, {HDS_INPUT_CLEARCOAT, HDS_INPUT_CLEARCOAT_ROUGHNESS, HDS_INPUT_COAT_IOR,
                         HDS_INPUT_COAT_TINT, HDS_INPUT_COAT_NORMAL, HDS_INPUT_COAT_STRETCH});
    drop(HDS_LOBE_SCHLICK, {HDS_INPUT_SCHLICK_EXPONENT, HDS_INPUT_SCHLICK_COLOR,
                            HDS_INPUT_SCHLICK_GRAZING, HDS_INPUT_SCHLICK_EDGE});
    drop(HDS_LOBE_SHEEN, {HDS_INPUT_SHEEN, HDS_INPUT_SHEEN_COLOR, HDS_INPUT_SHEEN_ROUGHNESS});
    drop(HDS_LOBE_TRANSMISSION, {HDS_INPUT_TRANSMISSION, HDS_INPUT_TRANSMISSION_COLOR,
                                 HDS_INPUT_ABSORPTION, HDS_INPUT_SCATTERING});
    if (!has(HDS_INPUT_METALLIC)) {
        values[HDS_INPUT_METAL_COLOR] = {};
        values[HDS_INPUT_EDGE_COLOR] = {};
    }
}

} // namespace hds
