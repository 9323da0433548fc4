// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/closureSlab.h"

#include "hdStream/shading/closureReflectance.h"
#include "hdStream/shading/shaderMath.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <utility>

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

ShaderValue One() {
    return MakeScalar(1.0F);
}
ShaderValue Zero() {
    return MakeScalar(0.0F);
}

bool Has(const LayeredMaterial& layered, std::uint32_t input) {
    return layered.values[input] && !IsAll(layered.values[input], 0.0F);
}

bool AreSame(const LayeredMaterial& a, const LayeredMaterial& b, std::uint32_t input) {
    return AreSame(a.values[input], b.values[input]);
}

ShaderValue ValueOf(const LayeredMaterial& layered, std::uint32_t input) {
    return layered.values[input]
               ? layered.values[input]
               : MakeConstant(kInputs[input].fallback, kInputs[input].numComponents);
}

/// Whether it has none of these.
bool HasNone(const LayeredMaterial& layered, std::initializer_list<std::uint32_t> inputs) {
    return std::none_of(inputs.begin(), inputs.end(),
                        [&](std::uint32_t input) { return Has(layered, input); });
}

/// Whether no light comes from it, as of closures of weight 0.
bool IsNothing(const LayeredMaterial& layered) {
    return HasNone(layered, {HDS_INPUT_DIFFUSE_COLOR, HDS_INPUT_TRANSLUCENCY, HDS_INPUT_METALLIC,
                             HDS_INPUT_TRANSMISSION, HDS_INPUT_SHEEN, HDS_INPUT_SPECULAR_WEIGHT,
                             HDS_INPUT_CLEARCOAT, HDS_INPUT_SUBSURFACE, HDS_INPUT_HAIR});
}

/// Diffuse reflection and transmission, and nothing else.
bool IsDiffuse(const LayeredMaterial& layered) {
    return HasNone(layered, {HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_METALLIC, HDS_INPUT_TRANSMISSION,
                             HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT, HDS_INPUT_SUBSURFACE});
}

/// A reflection that lets through what it does not reflect.
bool IsReflection(const LayeredMaterial& layered) {
    return Has(layered, HDS_INPUT_SPECULAR_WEIGHT) &&
           HasNone(layered, {HDS_INPUT_DIFFUSE_COLOR, HDS_INPUT_TRANSLUCENCY, HDS_INPUT_METALLIC,
                             HDS_INPUT_TRANSMISSION, HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT,
                             HDS_INPUT_SUBSURFACE});
}

bool IsSheen(const LayeredMaterial& layered) {
    return Has(layered, HDS_INPUT_SHEEN) &&
           HasNone(layered, {HDS_INPUT_DIFFUSE_COLOR, HDS_INPUT_TRANSLUCENCY, HDS_INPUT_METALLIC,
                             HDS_INPUT_TRANSMISSION, HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_CLEARCOAT,
                             HDS_INPUT_SUBSURFACE});
}

/// Metal, and nothing beside it or above it.
bool IsMetal(const LayeredMaterial& layered) {
    return IsAll(ValueOf(layered, HDS_INPUT_METALLIC), 1.0F) &&
           IsAll(ValueOf(layered, HDS_INPUT_DIELECTRIC), 0.0F) &&
           HasNone(layered, {HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT});
}

/// Whether both have one roughness where it shows.
bool HaveOneRoughness(const LayeredMaterial& metal, const LayeredMaterial& other) {
    return AreSame(metal, other, HDS_INPUT_STRETCH) && AreSame(metal, other, HDS_INPUT_FILM) &&
           (IsDiffuse(other) || AreSame(metal, other, HDS_INPUT_ROUGHNESS));
}

/// Of two slabs of one roughness, whose colours are weighed by their shares.
bool TryMergeDiffuse(const ClosureSlab& other, ClosureSlab* slab) {
    LayeredMaterial& layered = slab->layered;
    if (!IsDiffuse(layered) || !IsDiffuse(other.layered) ||
        !AreSame(layered, other.layered, HDS_INPUT_NORMAL) ||
        !AreSame(layered, other.layered, HDS_INPUT_DIFFUSE_ROUGHNESS)) {
        return false;
    }
    const ShaderValue share = Add(slab->share, other.share, 1);
    for (const std::uint32_t input : {HDS_INPUT_DIFFUSE_COLOR, HDS_INPUT_TRANSLUCENCY}) {
        if (!Has(layered, input) && !Has(other.layered, input)) {
            continue;
        }
        const auto weighed = [&](const ClosureSlab& one) {
            return Multiply(one.share, Multiply(one.factor, ValueOf(one.layered, input), 3), 3);
        };
        layered.values[input] = Divide(Add(weighed(*slab), weighed(other), 3), share, 3);
    }
    slab->share = share;
    slab->factor = One();
    return true;
}

/// Of metal and something else, which lie beside each other in a layered surface.
bool TryMergeMetal(const ClosureSlab& metal, const ClosureSlab& other, ClosureSlab* merged) {
    if (!IsMetal(metal.layered) || Has(other.layered, HDS_INPUT_METALLIC) ||
        Has(other.layered, HDS_INPUT_CLEARCOAT) || !IsAll(metal.factor, 1.0F) ||
        !IsAll(other.factor, 1.0F) || (other.layered.flags & HDS_MATERIAL_FUZZ) != 0 ||
        !AreSame(metal.layered, other.layered, HDS_INPUT_NORMAL) ||
        !HaveOneRoughness(metal.layered, other.layered)) {
        return false;
    }
    ClosureSlab both = other;
    both.share = Add(metal.share, other.share, 1);
    const ShaderValue part = Divide(metal.share, both.share, 1);
    both.layered.values[HDS_INPUT_METALLIC] = part;
    both.layered.values[HDS_INPUT_DIELECTRIC] = OneMinus(part, 1);
    for (const std::uint32_t input :
         {HDS_INPUT_METAL_COLOR, HDS_INPUT_EDGE_COLOR, HDS_INPUT_ROUGHNESS}) {
        both.layered.values[input] = metal.layered.values[input];
    }
    both.layered.lobes |= metal.layered.lobes;
    *merged = std::move(both);
    return true;
}

/// Of subsurface scattering and diffuse reflection, which a layered surface has side by side.
bool TryMergeSubsurface(const ClosureSlab& walk, const ClosureSlab& other, ClosureSlab* merged) {
    const LayeredMaterial& a = walk.layered;
    const LayeredMaterial& b = other.layered;
    if (!Has(a, HDS_INPUT_SUBSURFACE) || !IsDiffuse(b) || Has(b, HDS_INPUT_TRANSLUCENCY) ||
        !HasNone(a, {HDS_INPUT_DIFFUSE_COLOR, HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_METALLIC,
                     HDS_INPUT_TRANSMISSION, HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT}) ||
        !IsAll(walk.factor, 1.0F) || !IsAll(other.factor, 1.0F) ||
        !AreSame(a, b, HDS_INPUT_NORMAL)) {
        return false;
    }
    ClosureSlab both = walk;
    both.share = Add(walk.share, other.share, 1);
    const ShaderValue part = Divide(walk.share, both.share, 1);
    const ShaderValue walks = a.values[HDS_INPUT_SUBSURFACE];
    both.layered.values[HDS_INPUT_SUBSURFACE] =
        MakeMath(HDS_MATH_COMBINE,
                 {Multiply(part, SelectChannel(walks, 0), 1), SelectChannel(walks, 1),
                  SelectChannel(walks, 2), Zero()},
                 4);
    both.layered.values[HDS_INPUT_DIFFUSE_COLOR] =
        Multiply(ValueOf(b, HDS_INPUT_DIFFUSE_COLOR), OneMinus(part, 1), 3);
    both.layered.values[HDS_INPUT_DIFFUSE_ROUGHNESS] = b.values[HDS_INPUT_DIFFUSE_ROUGHNESS];
    *merged = std::move(both);
    return true;
}

/// Whether the reflections of both are by the same index, or by the same Schlick's term.
bool HaveOneFresnel(const LayeredMaterial& a, const LayeredMaterial& b) {
    return (AreSame(a, b, HDS_INPUT_IOR) || a.values[HDS_INPUT_SCHLICK_EXPONENT]) &&
           AreSame(a, b, HDS_INPUT_SCHLICK_EXPONENT) && AreSame(a, b, HDS_INPUT_SCHLICK_COLOR) &&
           AreSame(a, b, HDS_INPUT_SCHLICK_GRAZING) && AreSame(a, b, HDS_INPUT_SCHLICK_EDGE);
}

/// Of glass and what lies beside it below one reflection, or below none.
bool TryMergeGlass(const ClosureSlab& glass, const ClosureSlab& other, ClosureSlab* merged) {
    const LayeredMaterial& a = glass.layered;
    const LayeredMaterial& b = other.layered;
    const bool haveOneTop =
        AreSame(a, b, HDS_INPUT_SPECULAR_WEIGHT) &&
        (!Has(b, HDS_INPUT_SPECULAR_WEIGHT) || (HaveOneFresnel(a, b) && HaveOneRoughness(a, b) &&
                                                AreSame(a, b, HDS_INPUT_SPECULAR_COLOR)));
    if (!haveOneTop || !IsAll(ValueOf(a, HDS_INPUT_TRANSMISSION), 1.0F) ||
        !HasNone(a, {HDS_INPUT_METALLIC, HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT}) ||
        !HasNone(b, {HDS_INPUT_METALLIC, HDS_INPUT_TRANSMISSION, HDS_INPUT_CLEARCOAT}) ||
        (b.flags & HDS_MATERIAL_FUZZ) != 0 || !IsAll(glass.factor, 1.0F) ||
        !IsAll(other.factor, 1.0F) || !AreSame(a, b, HDS_INPUT_NORMAL)) {
        return false;
    }
    ClosureSlab both = other;
    both.share = Add(glass.share, other.share, 1);
    both.layered.values[HDS_INPUT_TRANSMISSION] = Divide(glass.share, both.share, 1);
    for (const std::uint32_t input :
         {HDS_INPUT_TRANSMISSION_COLOR, HDS_INPUT_ABSORPTION, HDS_INPUT_SCATTERING,
          HDS_INPUT_ROUGHNESS, HDS_INPUT_STRETCH, HDS_INPUT_FILM, HDS_INPUT_IOR}) {
        both.layered.values[input] = a.values[input];
    }
    if (a.values[HDS_INPUT_SUBSURFACE]) { // it has the asymmetry inside of the glass
        const ShaderValue walks = ValueOf(b, HDS_INPUT_SUBSURFACE);
        both.layered.values[HDS_INPUT_SUBSURFACE] =
            MakeMath(HDS_MATH_COMBINE,
                     {SelectChannel(walks, 0), SelectChannel(walks, 1),
                      SelectChannel(a.values[HDS_INPUT_SUBSURFACE], 2), Zero()},
                     4);
    }
    both.layered.flags |= a.flags & (HDS_MATERIAL_MEDIUM | HDS_MATERIAL_FROSTED);
    *merged = std::move(both);
    return true;
}

/// Of two that differ in nothing but their shares.
bool TryMergeEqual(const ClosureSlab& other, ClosureSlab* slab) {
    const LayeredMaterial& a = slab->layered;
    const LayeredMaterial& b = other.layered;
    if (a.flags != b.flags || a.lobes != b.lobes || !AreSame(slab->factor, other.factor) ||
        !std::equal(a.values.begin(), a.values.end(), b.values.begin(),
                    [](const ShaderValue& x, const ShaderValue& y) { return AreSame(x, y); })) {
        return false;
    }
    slab->share = Add(slab->share, other.share, 1);
    return true;
}

/// Makes one of a slab and another, where one layered surface has both.
bool TryMerge(const ClosureSlab& other, ClosureSlab* slab) {
    if (Has(other.layered, HDS_INPUT_HAIR) || Has(slab->layered, HDS_INPUT_HAIR)) {
        return TryMergeEqual(other, slab);
    }
    return TryMergeDiffuse(other, slab) || TryMergeMetal(*slab, other, slab) ||
           TryMergeMetal(other, *slab, slab) || TryMergeGlass(*slab, other, slab) ||
           TryMergeGlass(other, *slab, slab) || TryMergeSubsurface(*slab, other, slab) ||
           TryMergeSubsurface(other, *slab, slab) || TryMergeEqual(other, slab);
}

ClosureSlabs Merge(ClosureSlabs slabs) {
    ClosureSlabs merged;
    for (ClosureSlab& slab : slabs) {
        if (IsAll(slab.share, 0.0F)) {
            continue;
        }
        if (std::none_of(merged.begin(), merged.end(),
                         [&](ClosureSlab& one) { return TryMerge(slab, &one); })) {
            merged.push_back(std::move(slab));
        }
    }
    return merged;
}

void Append(ClosureSlabs slabs, const ShaderValue& share, ClosureSlabs* all) {
    for (ClosureSlab& slab : slabs) {
        slab.share = Multiply(slab.share, share, 1);
        all->push_back(std::move(slab));
    }
}

/// Puts the factor of a slab into the colours of its lobes, since what comes to lie on top of it
/// does not have it. Of metal the colours of the front and of the edge have it, of subsurface
/// scattering its colour.
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
    slab->factor = One();
}

/// Whether FoldFactor leaves the slab as it is.
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

/// The coat's inputs as those of a reflection.
void SetCoat(const ClosureSlab& top, ClosureSlab* slab) {
    LayeredMaterial& layered = slab->layered;
    layered.values[HDS_INPUT_CLEARCOAT] = ValueOf(top.layered, HDS_INPUT_SPECULAR_WEIGHT);
    layered.values[HDS_INPUT_CLEARCOAT_ROUGHNESS] = ValueOf(top.layered, HDS_INPUT_ROUGHNESS);
    layered.values[HDS_INPUT_COAT_IOR] = ValueOf(top.layered, HDS_INPUT_IOR);
    layered.values[HDS_INPUT_COAT_STRETCH] = top.layered.values[HDS_INPUT_STRETCH];
    SetOwnNormal(top.layered.values[HDS_INPUT_NORMAL], &layered);
    layered.values[HDS_INPUT_COAT_TINT] = slab->factor; // of what is below the coat
    slab->factor = One();
}

void SetReflection(const ClosureSlab& top, ClosureSlab* slab) {
    FoldFactor(slab);
    LayeredMaterial& layered = slab->layered;
    for (const std::uint32_t input :
         {HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_ROUGHNESS, HDS_INPUT_STRETCH, HDS_INPUT_FILM,
          HDS_INPUT_SCHLICK_EXPONENT, HDS_INPUT_SCHLICK_COLOR, HDS_INPUT_SCHLICK_GRAZING,
          HDS_INPUT_SCHLICK_EDGE}) {
        layered.values[input] = top.layered.values[input];
    }
    // Glass below Schlick's term, which has no index, refracts by its own.
    if (!top.layered.values[HDS_INPUT_SCHLICK_EXPONENT] || !Has(layered, HDS_INPUT_TRANSMISSION)) {
        layered.values[HDS_INPUT_IOR] = top.layered.values[HDS_INPUT_IOR];
    }
    layered.values[HDS_INPUT_SPECULAR_COLOR] =
        Multiply(ValueOf(top.layered, HDS_INPUT_SPECULAR_COLOR), top.factor, 3);
}

void SetSheen(const ClosureSlab& top, bool isOverAll, ClosureSlab* slab) {
    FoldFactor(slab);
    LayeredMaterial& layered = slab->layered;
    for (const std::uint32_t input : {HDS_INPUT_SHEEN, HDS_INPUT_SHEEN_ROUGHNESS}) {
        layered.values[input] = top.layered.values[input];
    }
    layered.values[HDS_INPUT_SHEEN_COLOR] =
        Multiply(ValueOf(top.layered, HDS_INPUT_SHEEN_COLOR), top.factor, 3);
    layered.flags |= isOverAll ? HDS_MATERIAL_FUZZ : top.layered.flags & HDS_MATERIAL_FUZZ;
}

/// Whether a layered surface has a place for a reflection but the coat.
bool HasPlaceFor(const LayeredMaterial& reflection, const LayeredMaterial& below) {
    const bool isGlass =
        Has(below, HDS_INPUT_TRANSMISSION) && AreSame(reflection, below, HDS_INPUT_ROUGHNESS);
    return HasNone(below, {HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_METALLIC, HDS_INPUT_CLEARCOAT}) &&
           (isGlass || !Has(below, HDS_INPUT_TRANSMISSION)) &&
           (below.flags & HDS_MATERIAL_FUZZ) == 0;
}

/// A reflection by an index alone, which a coat is too.
bool IsPlain(const ClosureSlab& reflection) {
    const auto& values = reflection.layered.values;
    return !values[HDS_INPUT_SCHLICK_EXPONENT] && !values[HDS_INPUT_FILM] &&
           IsAll(ValueOf(reflection.layered, HDS_INPUT_SPECULAR_COLOR), 1.0F) &&
           IsAll(reflection.factor, 1.0F);
}

/// A reflection as a coat.
ClosureSlabs CoatOne(const ClosureSlab& top, ClosureSlab base, const ClosureWarning& warn) {
    if (Has(base.layered, HDS_INPUT_CLEARCOAT)) {
        warn("a reflection above a coat is left out");
        return {base};
    }
    if (top.layered.values[HDS_INPUT_SCHLICK_EXPONENT]) {
        warn("above another reflection it has that of its index, without its colours");
    } else if (!IsPlain(top)) {
        warn("above another reflection it has neither a colour nor a film of its own");
    }
    SetCoat(top, &base);
    return {base};
}

/// Metal by Schlick's term, and nothing else.
bool IsSchlickMetal(const LayeredMaterial& layered) {
    return Has(layered, HDS_INPUT_METALLIC) && (layered.lobes & HDS_LOBE_CONDUCTOR) == 0 &&
           IsAll(ValueOf(layered, HDS_INPUT_DIELECTRIC), 0.0F) &&
           HasNone(layered, {HDS_INPUT_SHEEN, HDS_INPUT_CLEARCOAT});
}

/// Metal by Schlick's term that reflects all, so that it has nothing to let through.
bool IsWhiteMetal(const LayeredMaterial& layered) {
    return IsAll(ValueOf(layered, HDS_INPUT_METAL_COLOR), 1.0F) &&
           IsAll(ValueOf(layered, HDS_INPUT_EDGE_COLOR), 1.0F);
}

/// The same as a reflection that lets through what it does not reflect.
ClosureSlab AsReflection(ClosureSlab metal) {
    auto& values = metal.layered.values;
    values[HDS_INPUT_SPECULAR_WEIGHT] = std::exchange(values[HDS_INPUT_METALLIC], {});
    values[HDS_INPUT_IOR] = IndexOfReflectance(values[HDS_INPUT_METAL_COLOR]);
    values[HDS_INPUT_SCHLICK_COLOR] = std::exchange(values[HDS_INPUT_METAL_COLOR], {});
    values[HDS_INPUT_SCHLICK_EDGE] = std::exchange(values[HDS_INPUT_EDGE_COLOR], {});
    values[HDS_INPUT_SCHLICK_EXPONENT] = MakeScalar(5.0F);
    values[HDS_INPUT_DIELECTRIC] = {};
    return metal;
}

/// Whether the normal of what lies on top is that of the base, which takes it where nothing else
/// comes from the base.
bool ShareNormal(const ClosureSlab& top, ClosureSlab* base) {
    ShaderValue& below = base->layered.values[HDS_INPUT_NORMAL];
    if (IsNothing(base->layered)) {
        below = top.layered.values[HDS_INPUT_NORMAL];
    }
    return AreSame(top.layered.values[HDS_INPUT_NORMAL], below);
}

/// One slab on another. What has no place in a layered surface is left out.
ClosureSlabs LayerOne(const ClosureSlab& top, ClosureSlab base, const ClosureWarning& warn) {
    const LayeredMaterial& below = base.layered;
    if (IsNothing(top.layered)) {
        return {base};
    }
    if (IsSchlickMetal(top.layered) && !IsNothing(below)) {
        const ClosureSlab reflection = AsReflection(top);
        if (HasPlaceFor(reflection.layered, below)) {
            return LayerOne(reflection, std::move(base), warn);
        }
        if (!IsWhiteMetal(top.layered)) {
            warn("above another reflection, a fuzz, or glass of another roughness its metal lets "
                 "nothing through");
        }
    }
    if (Has(below, HDS_INPUT_HAIR)) {
        warn("what lies on hair is left out");
        return {base};
    }
    if (IsReflection(top.layered) && !HasPlaceFor(top.layered, below)) {
        return CoatOne(top, std::move(base), warn);
    }
    if (IsReflection(top.layered)) {
        if (!ShareNormal(top, &base)) {
            if (IsPlain(top)) {
                SetCoat(top, &base);
                return {base};
            }
            warn("a reflection with a colour or a film of its own and what lies below it share one "
                 "normal");
            ShaderValue& normal = base.layered.values[HDS_INPUT_NORMAL];
            normal = normal ? normal : top.layered.values[HDS_INPUT_NORMAL];
        }
        SetReflection(top, &base);
        return {base};
    }
    if (IsSheen(top.layered)) {
        if (Has(below, HDS_INPUT_SHEEN)) {
            warn("a sheen above another is left out");
            return {base};
        }
        if (!ShareNormal(top, &base)) {
            warn("a sheen has the normal of what lies below");
        }
        SetSheen(top, !IsDiffuse(base.layered), &base);
        return {base};
    }
    // Whatever else lies on top lets nothing through where it is.
    ClosureSlab opaque = top;
    opaque.share = base.share;
    if (!IsMetal(top.layered) && Has(top.layered, HDS_INPUT_METALLIC)) {
        opaque.layered.values[HDS_INPUT_METALLIC] = One();
        return MixSlabs({base}, {opaque}, ValueOf(top.layered, HDS_INPUT_METALLIC));
    }
    return {opaque};
}

/// A value that is `values[k]` where slab k is chosen. \param below share of those up to each slab
ShaderValue ChooseValue(const std::vector<ShaderValue>& values,
                        const std::vector<ShaderValue>& isChosen, std::uint32_t numComponents) {
    ShaderValue result = values.back();
    for (std::size_t k = values.size() - 1; k > 0; --k) {
        if (!AreSame(values[k - 1], result)) {
            result =
                MakeMath(HDS_MATH_SELECT, {isChosen[k - 1], values[k - 1], result}, numComponents);
        }
    }
    return result;
}

ShaderValue MakeChance() {
    auto expression = std::make_shared<ShaderExpression>();
    expression->kind = ShaderExpression::Kind::Chance;
    return {std::move(expression), HDS_CHANNEL_ALL, 1};
}

} // namespace

ClosureSlab BlackSlab() {
    ClosureSlab slab;
    slab.share = One();
    slab.factor = One();
    slab.layered.values[HDS_INPUT_DIFFUSE_COLOR] = MakeConstant({0.0F, 0.0F, 0.0F, 1.0F}, 3);
    slab.layered.values[HDS_INPUT_SPECULAR_WEIGHT] = Zero();
    slab.layered.values[HDS_INPUT_SPECULAR_COLOR] = MakeConstant({1.0F, 1.0F, 1.0F, 1.0F}, 3);
    return slab;
}

ClosureSlabs MixSlabs(ClosureSlabs background, ClosureSlabs foreground, const ShaderValue& mix) {
    ClosureSlabs all;
    const ShaderValue share =
        MakeMath(HDS_MATH_MAX, {MakeMath(HDS_MATH_MIN, {mix, One()}, 1), Zero()}, 1);
    const auto orBlack = [](ClosureSlabs slabs) {
        return slabs.empty() ? ClosureSlabs{BlackSlab()} : std::move(slabs);
    };
    Append(orBlack(std::move(background)), OneMinus(share, 1), &all);
    Append(orBlack(std::move(foreground)), share, &all);
    return Merge(std::move(all));
}

ClosureSlabs AddSlabs(ClosureSlabs a, ClosureSlabs b) {
    if (a.empty() || b.empty()) {
        return a.empty() ? std::move(b) : std::move(a);
    }
    ClosureSlabs all;
    const ShaderValue half = MakeScalar(0.5F);
    const ShaderValue two = MakeScalar(2.0F);
    Append(MultiplySlabs(std::move(a), two), half, &all);
    Append(MultiplySlabs(std::move(b), two), half, &all);
    return Merge(std::move(all));
}

ClosureSlabs MultiplySlabs(ClosureSlabs slabs, const ShaderValue& factor) {
    for (ClosureSlab& slab : slabs) {
        slab.factor = Multiply(slab.factor, factor, 3);
    }
    return slabs;
}

ClosureSlabs LayerSlabs(const ClosureSlabs& top, const ClosureSlabs& base,
                        const ClosureWarning& warn) {
    if (top.empty()) {
        return base;
    }
    const ClosureSlabs below = base.empty() ? ClosureSlabs{BlackSlab()} : base;
    ClosureSlabs all;
    for (const ClosureSlab& upper : top) {
        for (const ClosureSlab& lower : below) {
            Append(LayerOne(upper, lower, warn), upper.share, &all);
        }
    }
    return Merge(std::move(all));
}

LayeredMaterial ChooseSlab(ClosureSlabs slabs) {
    for (ClosureSlab& slab : slabs) {
        if (IsFoldable(slab)) {
            FoldFactor(&slab);
        }
    }
    LayeredMaterial result = slabs.empty() ? BlackSlab().layered : slabs[0].layered;
    std::vector<ShaderValue> isChosen; // or one of those before it
    const ShaderValue chance = MakeChance();
    ShaderValue below = Zero();
    for (const ClosureSlab& slab : slabs) {
        result.flags |= slab.layered.flags;
        result.lobes |= slab.layered.lobes;
        result.dispersion = std::max(result.dispersion, slab.layered.dispersion);
        below = Add(below, slab.share, 1);
        isChosen.push_back(MakeMath(HDS_MATH_GREATER, {below, chance}, 1));
    }
    for (std::uint32_t input = 0; input < HDS_NUM_LAYERED_INPUTS && slabs.size() > 1; ++input) {
        std::vector<ShaderValue> values;
        std::transform(slabs.begin(), slabs.end(), std::back_inserter(values),
                       [&](const ClosureSlab& slab) { return ValueOf(slab.layered, input); });
        if (std::any_of(slabs.begin(), slabs.end(),
                        [&](const auto& slab) { return bool(slab.layered.values[input]); })) {
            result.values[input] = ChooseValue(values, isChosen, kInputs[input].numComponents);
        }
    }
    std::vector<ShaderValue> factors;
    std::transform(slabs.begin(), slabs.end(), std::back_inserter(factors),
                   [](const ClosureSlab& slab) { return slab.factor; });
    if (!factors.empty()) {
        result.values[HDS_INPUT_WEIGHT] = ChooseValue(factors, isChosen, 3);
    }
    return result;
}

} // namespace hds
