// SPDX-License-Identifier: Apache-2.0
// Surfaces, what they send on, and the copies of both to and from lanes: 8 paths at once against
// one.
#include "hdStream/integrator/kernelFeatures.h"
#include "testenv/device/math/lanesFixture.h"

#include <algorithm>
#include <limits>

namespace hds::test {
namespace {

const char* const kText = R"(
#define HDS_TEST_FIELDS_Surface(R1, R2, R3, U)                                              \
    R3(diffuse) R3(specularF0) R3(specularF90) R3(emission) R3(geomNormal)                  \
    R1(specularAlpha) R1(clearcoat) R1(clearcoatF0) R1(clearcoatAlpha) R1(opacity)          \
    R1(presence) U(isCutOut)
HDS_TEST_STRUCT(Surface)
#if (HDS_LOBES & HDS_LOBE_COAT_FRAME) != 0u
#define HDS_TEST_BASE(R3) R3(base.x) R3(base.y) R3(base.z)
#define HDS_TEST_COAT(R2) R2(coatStretch)
#define HDS_TEST_FROST(R1) R1(frost) R1(retro)
#define HDS_TEST_NUM_SPACE 27
#define HDS_TEST_NUM_LAYERED (66 + 3 * HDS_FEATURE_CLOSURES)
#else
#define HDS_TEST_BASE(R3)
#define HDS_TEST_COAT(R2)
#define HDS_TEST_FROST(R1)
#define HDS_TEST_NUM_SPACE 18
#define HDS_TEST_NUM_LAYERED 53
#endif
#define HDS_TEST_FIELDS_ShadingPoint(R1, R2, R3, U) \
    R3(frame.x) R3(frame.y) R3(frame.z) R3(geomNormal) R3(geomLocal) R3(wo) HDS_TEST_BASE(R3)
HDS_TEST_STRUCT(ShadingPoint)
#define HDS_TEST_FIELDS_SurfacePoint(R1, R2, R3, U) R3(position) R3(normal) R1(planeError)
HDS_TEST_STRUCT(SurfacePoint)
#define HDS_TEST_FIELDS_LightSample(R1, R2, R3, U)                                          \
    R3(direction) R3(radiance) R1(distance) R1(pdf) U(light) U(isDelta) U(isAlone) U(primId)
HDS_TEST_STRUCT(LightSample)
#define HDS_TEST_FIELDS_ScatteredRay(R1, R2, R3, U)                                         \
    R3(origin) R3(direction) R3(throughput) R3(normal) R3(wi) R3(weight) R1(pdf) R1(lightPdf)
HDS_TEST_STRUCT(ScatteredRay)
#if HDS_FEATURE_CLOSURES
#define HDS_TEST_COLOR(R3) R3(coatColor)
#else
#define HDS_TEST_COLOR(R3)
#endif
#if HDS_LOBES
#define HDS_TEST_FIELDS_LayeredSurface(R1, R2, R3, U)                                       \
    R3(dielectric) R3(metal) R3(metalColor) R3(metalEdge) R3(diffuseColor) R3(diffuse)      \
    R3(sheen) R3(transmitted) R3(translucent) R3(passed) R3(absorption) R3(emission)        \
    R3(geomNormal) R2(alpha) R1(eta) R1(specularWeight) R1(diffuseRoughness)                \
    R1(sheenRoughness) R1(coat) R1(coatEta) R1(coatAlpha) R1(cosineShare)                   \
    R1(specularShare) R1(coatShare) R1(refractedShare) R1(translucentShare)                 \
    HDS_TEST_COAT(R2) HDS_TEST_BASE(R3) HDS_TEST_FROST(R1) HDS_TEST_COLOR(R3)
HDS_TEST_STRUCT(LayeredSurface)
#endif
/* in: wo, wi, a normal, alphas, two numbers, eta. */
#if HDS_LOBES
void powers(const HdsTestContext* context, const Real* in, Real* out) {
    out = put1(out, power_exp(in[0]));
    out = put1(out, power_expm1(in[0]));
    out = put1(out, power_tanh(in[0]));
    out = put1(out, power_log(fabs(in[1])));
    out = put1(out, power_pow(in[1], in[2]));
    out = put1(out, power_pow(in[1], rint(in[2])));
    out = put3(out, power_expOfEach(take3(in)));
    out = put3(out, power_expm1OfEach(take3(in)));
}
#endif
void microfacets(const HdsTestContext* context, const Real* in, Real* out) {
    const Real3 wo = take3(in);
    const Real3 wi = take3(in + 3);
    const Real3 h = take3(in + 6);
    const Real2 u = take2(in + 11);
    out = put1(out, ggx_distribution(h, in[9]));
    out = put1(out, ggx_smithTerm(wo, in[9]));
    out = put1(out, ggx_masking(wo, in[9]));
    out = put1(out, ggx_visibility(wo, wi, in[9]));
    out = put3(out, ggx_sampleVisibleNormal(wo, in[9], u));
    out = put1(out, surface_schlick(h.z));
#if HDS_LOBES
    const Real2 alpha = take2(in + 9);
    const Real eta = in[13];
    out = put1(out, ggxStretched_distribution(h, alpha));
    out = put1(out, ggxStretched_smithTerm(wo, alpha));
    out = put1(out, ggxStretched_visibility(wo, wi, alpha));
    out = put1(out, ggxStretched_masking(wo, alpha));
    out = put3(out, ggxStretched_sampleVisibleNormal(wo, alpha, u));
    out = put3(out, ggxStretched_refractingNormal(wo, wi, eta));
    out = put1(out, ggxStretched_refractionJacobian(wo.z, wi.z, eta));
    Real3 refracted;
    const Bool isRefracted = ggxStretched_refract(wo, h, eta, &refracted);
    out = putFlag(out, isRefracted);
    out = put3(out, only(isRefracted, refracted));
    out = put1(out, dielectric_fresnel(wo.z, eta));
    out = put3(out, metal_fresnel(wo, vec_abs(h), fabs(wi.z)));
    out = put3(out, diffuse_evaluate(vec_abs(h), fmax(u.x - 0.25f, 0.0f), wo, wi));
    out = put1(out, sheen_evaluate(in[9], wo, wi, h));
#endif
}
/* in: a surface of each kind, which one it is, its place, a light sample. */
void scatters(const HdsTestContext* context, const Real* in, Real* out) {
    HdsScatter at;
#if HDS_FEATURE_TERMINATOR
    at.lift = vec_splat((Real)(0.0f));
#endif
    Surface_make(&at.bsdf.preview, in);
    in += 22;
#if HDS_LOBES
    LayeredSurface_make(&at.bsdf.layered, in);
    at.bsdf.isLayered = as_Uint(in[69]);
#if (HDS_LOBES & HDS_LOBE_COAT_FRAME) != 0u
    at.bsdf.layered.base = frame_fromNormal(at.bsdf.layered.base.x);
    at.shading.base = at.bsdf.layered.base;
#endif
#endif
    in += 70;
    at.shading.frame = frame_fromNormal(take3(in));
    at.shading.geomNormal = take3(in + 3);
    at.shading.geomLocal = frame_toLocal(&at.shading.frame, at.shading.geomNormal);
    at.shading.wo = take3(in + 6);
    const Real3 wi = take3(in + 9);
    SurfacePoint_make(&at.point, in + 12);
    at.throughput = take3(in + 19);
    at.sampler = pixel_sampler(context->frame, as_Uint(in[22]), as_Uint(in[23]));
    at.depth = as_Uint(in[24]);
    at.linkSet = as_Uint(in[25]);
    const Real2 u = take2(in + 26);
    HdsLightSample light;
    LightSample_make(&light, in + 28);

    at.lobes = bsdf_lobeProbabilities(&at.bsdf, at.shading.wo.z);
#if HDS_LOBES
    at.lobes = only(at.bsdf.isLayered == 0u, at.lobes); /* layered surfaces keep their own */
#endif
    out = put3(out, at.lobes);
    Real pdf;
    out = put3(out, bsdf_evaluate(&at.bsdf, at.lobes, at.shading.wo, wi, &pdf));
    out = put1(out, pdf);
    Real3 sampled;
    out = put3(out, bsdf_sample(&at.bsdf, at.lobes, at.shading.wo, u, u.x, &sampled, &pdf));
    out = put1(out, pdf);
    out = put3(out, only(pdf > 0.0f, sampled));
    Real side = 1.0f;
#if HDS_BSDF_TRANSMITS
    side = choices_side(&at.bsdf, at.sampler, at.depth);
    light.pdf *= bsdf_lightShare(&at.bsdf, side);
#endif
    out = put1(out, side);
    const HdsLitPoint point = scatter_litPoint(&at, side);
    out = put3(out, point.position);
    out = put3(out, point.normal);
    Real weight;
    const Real3 reflected = scatter_reflect(&at, &light, &pdf, &weight);
    out = put3(out, reflected);
    out = put1(out, pdf);
    out = put1(out, weight);
    out = put3(out, scatter_contribution(&at, reflected, &light, weight));
    Real3 throughput = at.throughput;
    out = putFlag(out, choices_survives(context->frame, at.sampler, at.depth, &throughput));
    out = put3(out, throughput);
    HdsScatteredRay next;
    const Bool goesOn = scatter_next(context->frame, &at, &next);
    out = putFlag(out, goesOn);
    out = put3(out, only(goesOn, next.origin));
    out = put3(out, only(goesOn, next.direction));
    out = put3(out, only(goesOn, next.throughput));
    out = put3(out, only(goesOn, next.normal));
    out = put3(out, only(goesOn, next.wi));
    out = put3(out, only(goesOn, next.weight));
    out = put1(out, only1(goesOn, next.pdf));
    out = put1(out, only1(goesOn, next.lightPdf));
}
)";

const char* const kKernels = R"(
#if HDS_LOBES
HDS_TEST_FORMS(powers, 3, 12)
#endif
HDS_TEST_FORMS(microfacets, 14, 31)
HDS_TEST_FORMS(scatters, 132, 54)
HDS_TEST_LANES(Surface, 22)
HDS_TEST_LANES(ShadingPoint, HDS_TEST_NUM_SPACE)
HDS_TEST_LANES(SurfacePoint, 7)
HDS_TEST_LANES(LightSample, 12)
HDS_TEST_LANES(ScatteredRay, 20)
#if HDS_LOBES
HDS_TEST_LANES(LayeredSurface, HDS_TEST_NUM_LAYERED)
#endif
)";

void AddMicrofacets(LaneRandom& r, LaneCase& one) {
    one.AddDirection(r, r.Is(6) ? 1.0F : r.Is(4) ? -1.0F : 0.0F);
    one.AddDirection(r, -1.0F);
    one.AddDirection(r, r.Is(6) ? 1.0F : -0.2F);
    one.Add({r.Is(4) ? 1e-4F : r.Sized(-4.0F, 0.0F), r.Is(4) ? 1.0F : r.Sized(-4.0F, 0.0F)});
    one.Add({r.Unit(), r.Unit()});
    one.Add({r.Is(2) ? r.Between(1.0005F, 4.0F) : 1.0F / r.Between(1.0005F, 4.0F)});
}

/// A normal near +z, or any on that side, or exactly +z.
void AddLocalNormal(LaneRandom& r, LaneCase& one) {
    one.AddDirection(r, r.Is(3) ? 1.0F : r.Is(2) ? 0.9F : 0.0F);
}

float Alpha(LaneRandom& r) {
    return r.Is(4) ? 1e-4F : r.Is(4) ? 1.0F : r.Sized(-4.0F, 0.0F);
}

void AddPreview(LaneRandom& r, LaneCase& one) {
    const unsigned kind = r.Kind(6); // diffuse, glossy, metal, coat alone, cut-out, all
    const bool isBlack = kind == 2 || kind == 4 || r.Is(8);
    const bool isGlossy = kind == 1 || kind == 2 || kind == 5;
    one.AddColor(r, isBlack ? 0.0F : 1.0F);
    one.AddColor(r, isGlossy ? 1.0F : 0.0F);
    one.AddColor(r, isGlossy ? 1.0F : 0.0F);
    one.AddColor(r, 5.0F);
    AddLocalNormal(r, one);
    one.Add({Alpha(r), kind == 3 || kind == 5 ? r.Unit() : 0.0F});
    one.Add({kind == 3 || kind == 5 ? 0.3F * r.Unit() : 0.0F, Alpha(r)});
    one.Add({kind == 4 ? 0.0F : r.Unit(), r.Is(3) ? r.Unit() : 1.0F, OfBits(kind == 4 ? 1U : 0U)});
}

void AddLayered(LaneRandom& r, LaneCase& one) {
    const unsigned kinds = r.Kind(128); // which lobes there are
    const auto has = [&](unsigned bit) { return (kinds >> bit & 1U) != 0 ? 1.0F : 0.0F; };
    one.AddColor(r, has(0)); // dielectric
    one.AddColor(r, has(1)); // metal
    one.AddColor(r, 0.99F);
    one.AddColor(r, r.Is(3) ? -9.0F : r.Is(2) ? 1.0F : 0.0F); // minus the index of conductors
    one.AddColor(r);
    one.AddColor(r, has(2)); // diffuse
    one.AddColor(r, has(3)); // sheen
    one.AddColor(r, has(4)); // transmitted
    one.AddColor(r, has(5)); // translucent
    for (int k = 0; k < 3; ++k) {
        one.AddColor(r);
    }
    AddLocalNormal(r, one);
    const float alpha = Alpha(r);
    one.Add({alpha, r.Is(2) ? alpha : Alpha(r)});
    one.Add({r.Is(2) ? r.Between(1.0005F, 4.0F) : 1.0F / r.Between(1.0005F, 4.0F)});
    one.Add({r.Unit(), r.Is(2) ? 0.0F : r.Unit(), r.Between(0.07F, 1.0F)});
    one.Add({has(6) * r.Unit(), r.Between(1.0005F, 4.0F), Alpha(r)});
    const float shares[5] = {std::max(has(2), has(3)) * r.Unit(),
                             std::max(has(0), has(1)) * r.Unit(), has(6) * r.Unit(),
                             has(4) * r.Unit(), has(5) * r.Unit()};
    float sum = 0.0F;
    for (const float share : shares) {
        sum += share;
    }
    for (const float share : shares) {
        one.push_back(sum > 0.0F ? share / sum : 0.0F);
    }
    one.Add({Alpha(r), Alpha(r)}); // of the coat
    AddLocalNormal(r, one);        // of the base; two more directions that are not used
    AddLocalNormal(r, one);
    AddLocalNormal(r, one);
    one.Add({r.Is(3) ? 1.0F : 0.0F}); // frosted
    one.Add({r.Is(3) ? 1.0F : 0.0F}); // it sends light back
    one.AddColor(r);                  // of the coat, where it is one of several closures
}

void AddScatter(LaneRandom& r, LaneCase& one) {
    AddPreview(r, one);
    AddLayered(r, one);
    one.Add({OfBits(r.Is(2) ? 1U : 0U)});
    one.AddDirection(r, -1.0F);
    one.AddDirection(r, -1.0F);
    one.AddDirection(r, r.Is(8) ? -1.0F : r.Is(4) ? 1.0F : 0.0F);
    one.AddDirection(r, r.Is(2) ? -1.0F : 0.0F);
    one.Add({r.Between(-9.0F, 9.0F), r.Between(-9.0F, 9.0F), r.Between(-9.0F, 9.0F)});
    one.AddDirection(r, -1.0F);
    one.Add({r.Sized(-8.0F, -3.0F)});
    one.AddColor(r, r.Is(16) ? 0.0F : r.Sized(-2.0F, 1.0F));
    one.Add({OfBits(r.Kind(100000)), OfBits(r.Kind(4096)), OfBits(r.Kind(8)), OfBits(r.Kind(90))});
    one.Add({r.Unit(), r.Unit()});
    one.AddDirection(r, -1.0F);
    one.AddColor(r, 20.0F);
    one.Add({r.Sized(-2.0F, 3.0F), r.Is(8) ? 1e-30F : r.Sized(-3.0F, 3.0F)});
    one.Add({OfBits(r.Kind(9)), 0.0F, OfBits(r.Kind(2)), OfBits(r.Kind(9))});
}

/// By the lobes that are compiled; HDS_LOBES_ALONE have one form alone.
class WideSurfaces : public LanesFixture, public ::testing::WithParamInterface<std::uint32_t> {
protected:
    void SetUp() override {
        LanesFixture::SetUp();
        if (!device || IsSkipped()) {
            return;
        }
        KernelFeatures features;
        features.lobes = GetParam();
        features.closures = HasClosures();
        _program = BuildForms("integrator/shade.cl", "integrator/shadeScatter.clh", kText, kKernels,
                              features.WithNeeds().Defines());
        _arguments.frame.imageWidth = 300;
        _arguments.frame.seed = 77;
        _arguments.frame.exposureScale = 1.5F;
    }
    static bool HasClosures() { return (GetParam() & HDS_LOBE_COVERED) != 0; }

    std::unique_ptr<Program> _program;
    Arguments _arguments;
};

TEST_P(WideSurfaces, MicrofacetsHaveTheSameBits) {
    const auto results =
        ExpectSameBits(*_program, "microfacetsForms", 80000, 31, AddMicrofacets, _arguments);
    EXPECT_EQ(CountConstant(results, 31), GetParam() != 0 ? 0U : 23U);
}

TEST_P(WideSurfaces, PowersHaveTheSameBits) {
    if (GetParam() == 0) {
        GTEST_SKIP() << "no lobe computes powers";
    }
    const auto add = [](LaneRandom& r, LaneCase& one) {
        const float infinity = std::numeric_limits<float>::infinity();
        one.Add({r.Is(16) ? infinity : r.Between(-110.0F, 95.0F)});
        one.Add({r.Is(16) ? 0.0F : (r.Is(4) ? -1.0F : 1.0F) * r.Sized(-140.0F, 120.0F)});
        one.Add({r.Is(16) ? -infinity : r.Between(-4.0F, 4.0F)});
    };
    const auto results = ExpectSameBits(*_program, "powersForms", 80000, 12, add, _arguments);
    EXPECT_EQ(CountConstant(results, 12), 0U);
}

TEST_P(WideSurfaces, ScatteringHasTheSameBits) {
    for (const std::uint32_t flags : {0U, HDS_FRAME_ROULETTE}) {
        _arguments.frame.flags = flags;
        const auto results = ExpectSameBits(*_program, "scattersForms", 80000, 54, AddScatter,
                                            _arguments, 3 + flags);
        const bool transmits = (GetParam() & (HDS_LOBE_TRANSMISSION | HDS_LOBE_TRANSLUCENCY)) != 0;
        EXPECT_EQ(CountConstant(results, 54), (transmits ? 0U : 1U) + (flags != 0 ? 0U : 1U));
    }
}

TEST_P(WideSurfaces, StructsLieInTheirLane) {
    ExpectLanes(*_program, "Surface", 22);
    const bool isFramed = (GetParam() & HDS_LOBE_COAT_FRAME) != 0;
    ExpectLanes(*_program, "ShadingPoint", isFramed ? 27 : 18);
    ExpectLanes(*_program, "SurfacePoint", 7);
    ExpectLanes(*_program, "LightSample", 12);
    ExpectLanes(*_program, "ScatteredRay", 20);
    if (GetParam() != 0) {
        ExpectLanes(*_program, "LayeredSurface", isFramed ? 69 : 53);
    }
}

INSTANTIATE_TEST_SUITE_P(Lobes, WideSurfaces,
                         ::testing::Values(0U, HDS_LOBE_BASE, HDS_LOBES_ALL & ~HDS_LOBES_ALONE));

} // namespace
} // namespace hds::test
