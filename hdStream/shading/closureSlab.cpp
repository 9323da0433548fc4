// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/closureSlab.h"

#include "hdStream/shading/closureParts.h"
#include "hdStream/shading/closureReflectance.h"
#include "hdStream/shading/patternNode.h"
#include "hdStream/shading/shaderMath.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace hds {

namespace {

ShaderValue One() {
    return MakeScalar(1.0F);
}
ShaderValue Zero() {
    return MakeScalar(0.0F);
}

/// Of sheens that lie on more than the diffuse part.
constexpr std::uint32_t kOnTop = HDS_MATERIAL_FUZZ | HDS_MATERIAL_SHEEN_OVER;

/// Whether both have one roughness where it shows.
bool HaveOneRoughness(const LayeredMaterial& metal, const LayeredMaterial& other) {
    return AreSame(metal, other, HDS_INPUT_STRETCH) && AreSame(metal, other, HDS_INPUT_FILM) &&
           AreSame(metal, other, HDS_INPUT_RETRO) &&
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
    slab->isScaled = false;
    return true;
}

/// Of metal and something else, which lie beside each other in a layered surface.
bool TryMergeMetal(const ClosureSlab& metal, const ClosureSlab& other, ClosureSlab* merged) {
    if (!IsMetal(metal.layered) || Has(other.layered, HDS_INPUT_METALLIC) ||
        Has(other.layered, HDS_INPUT_CLEARCOAT) || !IsAll(metal.factor, 1.0F) ||
        !IsAll(other.factor, 1.0F) || (other.layered.flags & kOnTop) != 0 ||
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
        (b.flags & kOnTop) != 0 || !IsAll(glass.factor, 1.0F) || !IsAll(other.factor, 1.0F) ||
        !AreSame(a, b, HDS_INPUT_NORMAL)) {
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
    if (!AreSame(slab->layered, other.layered) || !AreSame(slab->factor, other.factor) ||
        !AreSame(slab->scale, other.scale) || slab->isScaled != other.isScaled ||
        slab->hasBase != other.hasBase || !AreSame(slab->isCovered, other.isCovered) ||
        !AreSame(slab->covers, other.covers)) {
        return false;
    }
    slab->share = Add(slab->share, other.share, 1);
    return true;
}

/// Whether it is chosen apart from what lies on it or below it, or is hair.
bool StaysAlone(const ClosureSlab& slab) {
    return slab.hasBase || !slab.covers.empty() || Has(slab.layered, HDS_INPUT_HAIR);
}

/// Makes one of a slab and another, where one layered surface has both.
bool TryMerge(const ClosureSlab& other, ClosureSlab* slab) {
    if (StaysAlone(other) || StaysAlone(*slab)) {
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
          HDS_INPUT_SCHLICK_EDGE, HDS_INPUT_RETRO}) {
        layered.values[input] = top.layered.values[input];
    }
    // Glass below Schlick's term, which has no index, refracts by its own.
    if (!top.layered.values[HDS_INPUT_SCHLICK_EXPONENT] || !Has(layered, HDS_INPUT_TRANSMISSION)) {
        layered.values[HDS_INPUT_IOR] = top.layered.values[HDS_INPUT_IOR];
    }
    layered.values[HDS_INPUT_SPECULAR_COLOR] =
        Multiply(ValueOf(top.layered, HDS_INPUT_SPECULAR_COLOR), top.factor, 3);
}

void SetSheen(const ClosureSlab& top, ClosureSlab* slab) {
    FoldFactor(slab);
    LayeredMaterial& layered = slab->layered;
    for (const std::uint32_t input : {HDS_INPUT_SHEEN, HDS_INPUT_SHEEN_ROUGHNESS}) {
        layered.values[input] = top.layered.values[input];
    }
    layered.values[HDS_INPUT_SHEEN_COLOR] =
        Multiply(ValueOf(top.layered, HDS_INPUT_SHEEN_COLOR), top.factor, 3);
    layered.flags |= top.layered.flags & HDS_MATERIAL_FUZZ;
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
           !values[HDS_INPUT_RETRO] &&
           IsAll(ValueOf(reflection.layered, HDS_INPUT_SPECULAR_COLOR), 1.0F) &&
           IsAll(reflection.factor, 1.0F);
}

/// Metal by Schlick's term as a reflection that lets through what it does not reflect.
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

/// Puts a reflection or a sheen into the base, where a layered surface has a place for it. \return
/// whether it has one.
bool TryPutOn(const ClosureSlab& top, ClosureSlab* base) {
    const LayeredMaterial& below = base->layered;
    const bool isOverall = (top.layered.flags & HDS_MATERIAL_FUZZ) != 0 ||
                           HasNone(below, {HDS_INPUT_SPECULAR_WEIGHT, HDS_INPUT_METALLIC,
                                           HDS_INPUT_TRANSMISSION, HDS_INPUT_CLEARCOAT});
    if (top.isScaled || base->isScaled || Has(below, HDS_INPUT_HAIR)) {
        return false;
    }
    if (IsSheen(top.layered)) {
        if (Has(below, HDS_INPUT_SHEEN) || !isOverall || !ShareNormal(top, base)) {
            return false;
        }
        SetSheen(top, base);
        return true;
    }
    if (!IsReflection(top.layered)) {
        return false;
    }
    if (HasPlaceFor(top.layered, below) && ShareNormal(top, base)) {
        SetReflection(top, base);
        return true;
    }
    if (!IsPlain(top) || Has(below, HDS_INPUT_CLEARCOAT) ||
        (below.flags & HDS_MATERIAL_FUZZ) != 0) {
        return false;
    }
    SetCoat(top, base);
    return true;
}

/// How often what lies on top of `numBelow` slabs is chosen: about as much as it reflects of light
/// from all sides, and often enough for what it reflects at the rims. Not what it reflects towards
/// the viewer: shares of constants are constants, and programs stay short however many layers there
/// are. Nor by an index that varies, as hardly any reflects more than the least share of hits; nor
/// by colours that vary on many slabs: each share would be computed again in all below it.
ShaderValue CoverShare(const LayeredMaterial& top, std::size_t numBelow) {
    const ShaderValue least = MakeScalar(std::min(0.25F, 1.0F / static_cast<float>(numBelow + 1)));
    const ShaderValue most = MakeScalar(0.9F);
    if (!Has(top, HDS_INPUT_SPECULAR_WEIGHT)) {
        return least;
    }
    const ShaderValue third = MakeConstant({1.0F / 3.0F, 1.0F / 3.0F, 1.0F / 3.0F}, 3);
    const ShaderValue index = ValueOf(top, HDS_INPUT_IOR);
    const ShaderValue root = Divide(Subtract(index, One(), 1),
                                    MakeMath(HDS_MATH_MAX, {Add(index, One(), 1), One()}, 1), 1);
    const ShaderValue front =
        top.values[HDS_INPUT_SCHLICK_EXPONENT]
            ? MakeMath(HDS_MATH_DOT, {ValueOf(top, HDS_INPUT_SCHLICK_COLOR), third}, 1)
            : Multiply(root, root, 1);
    const ShaderValue reflected = Mix(front, One(), MakeScalar(1.0F / 21.0F), 1); // of (1 - cos)^5
    constexpr std::size_t kMaxVarying = 3;
    if (!IsConstant(reflected) &&
        (!top.values[HDS_INPUT_SCHLICK_EXPONENT] || numBelow > kMaxVarying)) {
        return least;
    }
    return MakeMath(HDS_MATH_MIN, {MakeMath(HDS_MATH_MAX, {reflected, least}, 1), most}, 1);
}

/// Whether from its inside nothing is seen of what lies on it.
bool HasInside(const ClosureSlab& base) {
    return base.isCovered || Has(base.layered, HDS_INPUT_TRANSMISSION);
}

/// 0 inside of glass, as layered_setup has it, else 1. \pre HasInside
ShaderValue IsSeenFromOutside(const ClosureSlab& base) {
    if (base.isCovered) {
        return base.isCovered;
    }
    ShaderValue inside = MakeGeometry(ShaderExpression::Kind::Inside, 0);
    inside.numComponents = 1;
    const ShaderValue isGlass =
        MakeMath(HDS_MATH_GREATER, {ValueOf(base.layered, HDS_INPUT_TRANSMISSION), Zero()}, 1);
    return OneMinus(Multiply(inside, isGlass, 1), 1);
}

/// Both, of which each hit takes one: what is chosen below gets what is left there by what lies on
/// it (HDS_INPUT_COVER).
ClosureSlabs CoverOne(ClosureSlab top, ClosureSlab base, std::size_t numBelow) {
    if (IsNothing(base.layered)) {
        top.share = base.share;
        return {top};
    }
    ShaderValue part = CoverShare(top.layered, numBelow);
    if (HasInside(base)) {
        base.isCovered = IsSeenFromOutside(base);
        part = Multiply(part, base.isCovered, 1);
    }
    const ShaderValue rest = OneMinus(part, 1);
    base.covers.push_back(std::make_shared<const LayeredMaterial>(top.layered));
    base.covers.insert(base.covers.end(), top.covers.begin(), top.covers.end());
    const ShaderValue scale = top.scale;
    top.share = Multiply(base.share, part, 1);
    top.factor = Divide(top.factor, part, 3);
    top.scale = Divide(top.scale, part, 1);
    base.share = Multiply(base.share, rest, 1);
    base.factor = Divide(Multiply(base.factor, scale, 3), rest, 3);
    base.scale = Divide(Multiply(base.scale, scale, 1), rest, 1);
    top.isScaled = base.isScaled = top.hasBase = true;
    return {top, base};
}

/// Whether what lies below is met too: LayerOne takes it into account.
bool LetsThrough(const LayeredMaterial& top) {
    return IsNothing(top) || IsSeeThrough(top) || IsSchlickMetal(top) ||
           (!IsMetal(top) && Has(top, HDS_INPUT_METALLIC));
}

/// What lies on others of the top, which `below` shows through: on each of `below`, as from the
/// inside of glass the glass alone is met.
ClosureSlabs SpreadOver(const ClosureSlab& upper, const ClosureSlabs& below) {
    if (std::none_of(below.begin(), below.end(), HasInside)) {
        return {upper};
    }
    ClosureSlabs spread;
    for (const ClosureSlab& lower : below) {
        ClosureSlab copy = upper;
        copy.share = Multiply(copy.share, lower.share, 1);
        if (HasInside(lower)) {
            copy.isCovered = IsSeenFromOutside(lower);
            copy.factor = Multiply(copy.factor, copy.isCovered, 3);
        }
        spread.push_back(std::move(copy));
    }
    return spread;
}

/// One slab on another, which is one of `numBelow`.
ClosureSlabs LayerOne(const ClosureSlab& top, ClosureSlab base, std::size_t numBelow) {
    if (IsNothing(top.layered)) {
        return {base};
    }
    if (IsSchlickMetal(top.layered) && !IsNothing(base.layered)) {
        const ClosureSlab reflection = AsReflection(top);
        ClosureSlab both = base;
        if (HasPlaceFor(reflection.layered, base.layered) && TryPutOn(reflection, &both)) {
            return {both};
        }
        if (!IsWhiteMetal(top.layered)) {
            return CoverOne(reflection, std::move(base), numBelow);
        }
    }
    if (IsSeeThrough(top.layered)) {
        return TryPutOn(top, &base) ? ClosureSlabs{base} : CoverOne(top, std::move(base), numBelow);
    }
    // Whatever else lies on top lets nothing through where it is.
    ClosureSlab opaque = top;
    opaque.share = base.share;
    if (!IsMetal(top.layered) && Has(top.layered, HDS_INPUT_METALLIC)) {
        opaque.layered.values[HDS_INPUT_METALLIC] = One();
        if (!top.covers.empty()) { // they lie on all of it, and on what is beside the metal
            if (HasInside(base)) {
                base.isCovered = IsSeenFromOutside(base);
            }
            base.covers.insert(base.covers.end(), top.covers.begin(), top.covers.end());
            base.factor = Multiply(base.factor, top.scale, 3);
            base.scale = Multiply(base.scale, top.scale, 1);
            base.isScaled = true;
        }
        return MixSlabs({base}, {opaque}, ValueOf(top.layered, HDS_INPUT_METALLIC));
    }
    return {opaque};
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
    for (ClosureSlab& slab : all) {
        slab.isScaled = true;
    }
    return Merge(std::move(all));
}

ClosureSlabs MultiplySlabs(ClosureSlabs slabs, const ShaderValue& factor) {
    for (ClosureSlab& slab : slabs) {
        slab.factor = Multiply(slab.factor, factor, 3);
    }
    return slabs;
}

ClosureSlabs LayerSlabs(const ClosureSlabs& top, const ClosureSlabs& base) {
    if (top.empty()) {
        return base;
    }
    const ClosureSlabs below = base.empty() ? ClosureSlabs{BlackSlab()} : base;
    const bool isBaseMet = std::any_of(top.begin(), top.end(), [](const ClosureSlab& upper) {
        return !upper.hasBase && LetsThrough(upper.layered);
    });
    ClosureSlabs all;
    for (const ClosureSlab& upper : top) {
        if (upper.hasBase) { // others of `top` are below it, and so is the base
            const ClosureSlabs spread = isBaseMet ? SpreadOver(upper, below) : ClosureSlabs{upper};
            all.insert(all.end(), spread.begin(), spread.end());
            continue;
        }
        for (const ClosureSlab& lower : below) {
            Append(LayerOne(upper, lower, below.size()), upper.share, &all);
        }
    }
    return Merge(std::move(all));
}

} // namespace hds
