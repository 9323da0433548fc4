// SPDX-License-Identifier: Apache-2.0
// From the inputs of materials to shading frames and BSDFs: 8 paths at once against one.
#include "hdStream/integrator/kernelFeatures.h"
#include "kernels/shared/material.h"
#include "testenv/device/math/lanesFixture.h"

#include <algorithm>
#include <iterator>

namespace hds::test {
namespace {

constexpr std::size_t kMaxInputs = 49;
constexpr std::size_t kNumbers = 3 * kMaxInputs + 17;
constexpr std::size_t kResults = 120;

const char* const kText = R"(
Real* putSpace(Real* out, const HdsShadingPoint* s) {
    out = put3(out, s->frame.x);
    out = put3(out, s->frame.y);
    out = put3(out, s->frame.z);
    out = put3(out, s->geomNormal);
    out = put3(out, s->geomLocal);
#if (HDS_LOBES & HDS_LOBE_COAT_FRAME) != 0u
    out = put3(out, s->base.x);
    out = put3(out, s->base.y);
    out = put3(out, s->base.z);
#else
    for (uint k = 0u; k < 9u; ++k) out = put1(out, (Real)(0.0f));
#endif
    return put3(out, s->wo);
}
Real* putPreview(Real* out, Bool isIt, const HdsSurface* s) {
    const Real cut = s->isCutOut != 0u ? (Real)(1.0f) : (Real)(2.0f);
    out = put3(out, only(isIt, s->diffuse));
    out = put3(out, only(isIt, s->specularF0));
    out = put3(out, only(isIt, s->specularF90));
    out = put3(out, only(isIt, s->emission));
    out = put3(out, only(isIt, s->geomNormal));
    out = put1(out, only1(isIt, s->specularAlpha));
    out = put1(out, only1(isIt, s->clearcoat));
    out = put1(out, only1(isIt, s->clearcoatF0));
    out = put1(out, only1(isIt, s->clearcoatAlpha));
    out = put1(out, only1(isIt, s->opacity));
    out = put1(out, only1(isIt, s->presence));
    return put1(out, only1(isIt, cut));
}
#if HDS_LOBES
Real* putLayered(Real* out, Bool isIt, const HdsLayeredSurface* s) {
    out = put3(out, only(isIt, s->dielectric));
    out = put3(out, only(isIt, s->metal));
    out = put3(out, only(isIt, s->metalColor));
    out = put3(out, only(isIt, s->metalEdge));
    out = put3(out, only(isIt, s->diffuseColor));
    out = put3(out, only(isIt, s->diffuse));
    out = put3(out, only(isIt, s->sheen));
    out = put3(out, only(isIt, s->transmitted));
    out = put3(out, only(isIt, s->translucent));
    out = put3(out, only(isIt, s->passed));
    out = put3(out, only(isIt, s->absorption));
    out = put3(out, only(isIt, s->emission));
    out = put3(out, only(isIt, s->geomNormal));
    out = put1(out, only1(isIt, s->alpha.x));
    out = put1(out, only1(isIt, s->alpha.y));
    out = put1(out, only1(isIt, s->eta));
    out = put1(out, only1(isIt, s->specularWeight));
    out = put1(out, only1(isIt, s->diffuseRoughness));
    out = put1(out, only1(isIt, s->sheenRoughness));
    out = put1(out, only1(isIt, s->coat));
    out = put1(out, only1(isIt, s->coatEta));
    out = put1(out, only1(isIt, s->coatAlpha));
    out = put1(out, only1(isIt, s->cosineShare));
    out = put1(out, only1(isIt, s->specularShare));
    out = put1(out, only1(isIt, s->coatShare));
    out = put1(out, only1(isIt, s->refractedShare));
    out = put1(out, only1(isIt, s->translucentShare));
#if (HDS_LOBES & HDS_LOBE_COAT_FRAME) != 0u
    out = put1(out, only1(isIt, s->coatStretch.x));
    out = put1(out, only1(isIt, s->coatStretch.y));
#else
    out = put1(out, (Real)(0.0f));
    out = put1(out, (Real)(0.0f));
#endif
#if (HDS_LOBES & HDS_LOBE_FROST) != 0u
    out = put1(out, only1(isIt, s->frost));
#else
    out = put1(out, (Real)(0.0f));
#endif
#if (HDS_LOBES & HDS_LOBE_RETRO) != 0u
    out = put1(out, only1(isIt, s->retro));
#else
    out = put1(out, (Real)(0.0f));
#endif
#if HDS_FEATURE_CLOSURES
    out = put3(out, only(isIt, s->coatColor));
#else
    out = put3(out, vec_splat((Real)(0.0f)));
#endif
#if HDS_FEATURE_MEDIA
    out = put1(out, only1(isIt, s->farShare));
#else
    out = put1(out, only1(isIt, (Real)(0.0f)));
#endif
    return out;
}
#endif
/* in: values of 49 inputs; two normals, two tangents, the viewer; lobes and flags. */
void materials(const HdsTestContext* context, const Real* in, Real* out) {
    HdsMaterialPoint m;
    for (uint i = 0u; i < HDS_NUM_BSDF_INPUTS; ++i) {
        m.values[i].x = in[3u * i];
        m.values[i].y = in[3u * i + 1u];
        m.values[i].z = in[3u * i + 2u];
    }
    const Real* at = in + 147;
    m.normal = take3(at);
    m.shadingNormal = take3(at + 3);
    m.alongS = take3(at + 6);
    m.alongT = take3(at + 9);
    m.viewer = take3(at + 12);
    m.lobes = as_Uint(at[15]);
    m.flags = as_Uint(at[16]);
    HdsShadingPoint shading;
    materialPoint_frame(&m, &shading);
    HdsBsdf bsdf;
    materialPoint_bsdf(&m, &shading, &bsdf);
    out = putSpace(out, &shading);
    out = put3(out, bsdf_emission(&bsdf));
    out = put3(out, bsdf_passThrough(&bsdf, shading.wo.z));
#if HDS_LOBES
    out = putPreview(out, bsdf.isLayered == 0u, &bsdf.preview);
    out = putLayered(out, bsdf.isLayered != 0u, &bsdf.layered);
    out = put1(out, as_Real(bsdf.isLayered));
#if HDS_BSDF_TRANSMITS
    out = put3(out, bsdf_absorption(&bsdf));
#endif
#else
    out = putPreview(out, lanes_true(in[0]), &bsdf.preview);
#endif
}
)";

const char* const kKernels = R"(
HDS_TEST_FORMS(materials, 164, 120)
)";

/// The value of an input: mostly in its range, at times out of it, and not a number.
float InputValue(LaneRandom& r) {
    const float values[] = {0.0F, 1.0F, -0.5F, 2.5F, float(NAN), INFINITY};
    return r.Is(6) ? values[r.Kind(r.Is(8) ? 6 : 4)] : r.Unit();
}

void AddDirectionOrZero(LaneRandom& r, unsigned zeroOneIn, LaneCase& one) {
    if (r.Is(zeroOneIn)) {
        one.Add({0.0F, 0.0F, 0.0F});
    } else {
        one.AddDirection(r, -1.0F);
    }
}

void AddMaterial(LaneRandom& r, std::uint32_t lobes, LaneCase& one) {
    for (std::size_t i = 0; i < kMaxInputs; ++i) {
        one.Add({InputValue(r), InputValue(r), InputValue(r)});
    }
    if (r.Is(2)) { // no bump
        const float flat[] = {0.0F, 0.0F, 1.0F};
        std::copy(std::begin(flat), std::end(flat), &one[std::size_t{3} * HDS_INPUT_NORMAL]);
    }
    if (r.Is(2)) { // a coat with the surface's normal
        std::fill_n(&one[std::size_t{3} * HDS_INPUT_COAT_NORMAL], 3, 0.0F);
    }
    if (r.Is(3)) { // a conductor
        for (std::size_t i = 0; i < 3; ++i) {
            one[3 * HDS_INPUT_EDGE_COLOR + i] = -1.0F - r.Unit();
        }
    }
    one[std::size_t{3} * HDS_INPUT_IOR] = r.Is(4) ? InputValue(r) : r.Between(0.5F, 3.0F);
    one[std::size_t{3} * HDS_INPUT_IOR + 1] = r.Is(2) ? 1.0F : r.Between(0.0F, 3.0F);
    one.AddDirection(r, -1.0F);
    AddDirectionOrZero(r, 3, one);
    AddDirectionOrZero(r, 4, one);
    AddDirectionOrZero(r, 4, one);
    one.AddDirection(r, r.Is(6) ? 1.0F : -1.0F);
    const std::uint32_t all = HDS_MATERIAL_SPECULAR_WORKFLOW | HDS_MATERIAL_LAMBERT |
                              HDS_MATERIAL_THIN_WALLED | HDS_MATERIAL_FUZZ | HDS_MATERIAL_PRESENCE |
                              HDS_MATERIAL_MEDIUM;
    const std::uint32_t some = lobes == 0 || r.Is(4) ? 0U : r.Is(2) ? lobes : lobes & r.Bits();
    one.Add({OfBits(some), OfBits(r.Is(3) ? 0U : r.Bits() & all)});
}

class WideMaterials : public LanesFixture {
protected:
    /// \return numbers of the results that are the same in all cases.
    std::size_t ExpectSame(KernelFeatures features, std::uint32_t lobes) {
        features.lobes = lobes;
        const auto program = BuildForms("integrator/shade.cl", "integrator/shadeScatter.clh", kText,
                                        kKernels, features.WithNeeds().Defines());
        const auto results = ExpectSameBits(
            *program, "materialsForms", 80000, kResults,
            [&](LaneRandom& r, LaneCase& one) { AddMaterial(r, lobes, one); }, {}, 11);
        return CountConstant(results, kResults);
    }
};

TEST_F(WideMaterials, OfPreviewSurfacesHaveTheSameBits) {
    EXPECT_EQ(ExpectSame({}, 0), 74U) << "those of layered surfaces";
}

TEST_F(WideMaterials, OfLayeredSurfacesHaveTheSameBits) {
    const std::size_t numBare = ExpectSame({}, HDS_LOBE_BASE);
    const std::size_t numWhole = ExpectSame({}, HDS_LOBES_ALL & ~HDS_LOBES_ALONE);
    EXPECT_LT(numWhole, numBare);
    EXPECT_LE(numWhole, 4U) << "the share of the other side, the colour of the coat";
}

TEST_F(WideMaterials, WithMediaAndClosuresHaveTheSameBits) {
    KernelFeatures features;
    features.media = features.mediaStack = features.closures = true;
    EXPECT_EQ(ExpectSame(features, HDS_LOBES_ALL & ~HDS_LOBES_ALONE), 0U);
}

} // namespace
} // namespace hds::test
