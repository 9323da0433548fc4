// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/closureParts.h"

#include "hdStream/shading/shaderMath.h"

#include <algorithm>
#include <array>

namespace hds {

namespace {

struct InputRow {
    std::uint32_t numComponents;
    std::array<float, 4> fallback;
};

/// By HDS_INPUT_*.
constexpr InputRow kInputs[] = {
#define HDS_PREVIEW_INPUT(NAME, name, components, x, y, z, w) {components, {x, y, z, w}},
#define HDS_LAYERED_INPUT(NAME, name, components, x, y, z, w) {components, {x, y, z, w}},
#include "kernels/shared/materialInputs.def"
};

} // namespace

bool Has(const LayeredMaterial& layered, std::uint32_t input) {
    return layered.values[input] && !IsAll(layered.values[input], 0.0F);
}

bool HasNone(const LayeredMaterial& layered, std::initializer_list<std::uint32_t> inputs) {
    return std::none_of(inputs.begin(), inputs.end(),
                        [&](std::uint32_t input) { return Has(layered, input); });
}

ShaderValue ValueOf(const LayeredMaterial& layered, std::uint32_t input) {
    return layered.values[input]
               ? layered.values[input]
               : MakeConstant(kInputs[input].fallback, kInputs[input].numComponents);
}

std::uint32_t NumComponentsOf(std::uint32_t input) {
    return kInputs[input].numComponents;
}

bool AreSame(const LayeredMaterial& a, const LayeredMaterial& b, std::uint32_t input) {
    return AreSame(a.values[input], b.values[input]);
}

bool AreSame(const LayeredMaterial& a, const LayeredMaterial& b) {
    return a.flags == b.flags && a.lobes == b.lobes &&
           std::equal(a.values.begin(), a.values.end(), b.values.begin(),
                      [](const ShaderValue& x, const ShaderValue& y) { return AreSame(x, y); });
}

bool AreSame(const LayerStack& a, const LayerStack& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const auto& x, const auto& y) { return x == y || AreSame(*x, *y); });
}

bool IsNothing(const LayeredMaterial& layered) {
    return HasNone(layered, {HDS_INPUT_DIFFUSE_COLOR, HDS_INPUT_TRANSLUCENCY, HDS_INPUT_METALLIC,
                             HDS_INPUT_TRANSMISSION, HDS_INPUT_SHEEN, HDS_INPUT_SPECULAR_WEIGHT,
                             HDS_INPUT_CLEARCOAT, HDS_INPUT_SUBSURFACE, HDS_INPUT_HAIR});
}

bool IsDiffuse(const LayeredMaterial& layered) {
    return HasNone(layered, {HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_METALLIC, HDS_INPUT_TRANSMISSION,
                             HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT, HDS_INPUT_SUBSURFACE});
}

bool IsSeeThrough(const LayeredMaterial& layered) {
    return !IsNothing(layered) &&
           HasNone(layered, {HDS_INPUT_DIFFUSE_COLOR, HDS_INPUT_TRANSLUCENCY, HDS_INPUT_METALLIC,
                             HDS_INPUT_TRANSMISSION, HDS_INPUT_SUBSURFACE, HDS_INPUT_HAIR});
}

bool IsReflection(const LayeredMaterial& layered) {
    return IsSeeThrough(layered) && HasNone(layered, {HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT});
}

bool IsSheen(const LayeredMaterial& layered) {
    return IsSeeThrough(layered) &&
           HasNone(layered, {HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_CLEARCOAT});
}

bool IsMetal(const LayeredMaterial& layered) {
    return IsAll(ValueOf(layered, HDS_INPUT_METALLIC), 1.0F) &&
           IsAll(ValueOf(layered, HDS_INPUT_DIELECTRIC), 0.0F) &&
           HasNone(layered, {HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT});
}

bool IsSchlickMetal(const LayeredMaterial& layered) {
    return Has(layered, HDS_INPUT_METALLIC) && (layered.lobes & HDS_LOBE_CONDUCTOR) == 0 &&
           IsAll(ValueOf(layered, HDS_INPUT_DIELECTRIC), 0.0F);
}

bool IsWhiteMetal(const LayeredMaterial& layered) {
    return IsAll(ValueOf(layered, HDS_INPUT_METAL_COLOR), 1.0F) &&
           IsAll(ValueOf(layered, HDS_INPUT_EDGE_COLOR), 1.0F);
}

void FoldFactor(ClosureSlab* slab) {
    for (const std::uint32_t input :
         {HDS_INPUT_DIFFUSE_COLOR, HDS_INPUT_TRANSLUCENCY, HDS_INPUT_TRANSMISSION_COLOR,
          HDS_INPUT_METAL_COLOR, HDS_INPUT_SHEEN_COLOR, HDS_INPUT_SPECULAR_COLOR,
          HDS_INPUT_SUBSURFACE_COLOR}) {
        ShaderValue& value = slab->layered.values[input];
        if (value) {
            value = Multiply(value, slab->factor, 3);
        }
    }
    if (Has(slab->layered, HDS_INPUT_HAIR)) {
        for (const std::uint32_t input :
             {HDS_INPUT_HAIR_TINT_R, HDS_INPUT_HAIR_TINT_TT, HDS_INPUT_HAIR_TINT_TRT}) {
            slab->layered.values[input] = Multiply(ValueOf(slab->layered, input), slab->factor, 3);
        }
    }
    slab->factor = MakeScalar(1.0F);
}

bool IsFoldable(const ClosureSlab& slab) {
    if (Has(slab.layered, HDS_INPUT_HAIR)) {
        return true;
    }
    if (!IsConstant(slab.factor) ||
        !HasNone(slab.layered, {HDS_INPUT_METALLIC, HDS_INPUT_CLEARCOAT, HDS_INPUT_SUBSURFACE})) {
        return false;
    }
    const std::array<float, 4>& factor = ConstantOf(slab.factor);
    return std::all_of(factor.begin(), factor.begin() + 3, [](float x) { return x <= 1.0F; });
}

} // namespace hds
