// SPDX-License-Identifier: Apache-2.0
// Vectors, angles, numbers of samples and camera rays: 8 paths at once against one.
#include "testenv/device/math/lanesFixture.h"

#include <algorithm>
#include <cmath>

namespace hds::test {
namespace {

const char* const kText = R"(
void vectors(const HdsTestContext* context, const Real* in, Real* out) {
    const Real3 a = take3(in);
    const Real3 b = take3(in + 3);
    const Real s = in[6];
    const Real t = in[7];
    const Bool isLess = s < t;
    HdsTransform m;
    m.row0 = vload4(0, context->frame->worldFromCamera);
    m.row1 = vload4(1, context->frame->worldFromCamera);
    m.row2 = vload4(2, context->frame->worldFromCamera);
    out = put3(out, vec_add(a, b));
    out = put3(out, vec_subtract(a, b));
    out = put3(out, vec_multiply(a, b));
    out = put3(out, vec_scale(a, s));
    out = put3(out, vec_divide(a, s));
    out = put3(out, vec_complement(a));
    out = put3(out, vec_quotient(a, b));
    out = put3(out, vec_positive(a));
    out = put3(out, vec_negate(a));
    out = put3(out, vec_abs(a));
    out = put3(out, vec_mulAdd(s, a, b));
    out = put3(out, vec_lerp(a, b, t));
    out = put3(out, vec_select(isLess, a, b));
    out = put3(out, vec_cross(a, b));
    out = put3(out, vec_normalize(a));
    out = put2(out, real_select2(isLess, real_make2(s, t), real_make2(t, a.x)));
    out = put1(out, vec_dot(a, b));
    out = put1(out, vec_lengthSquared(a));
    out = put1(out, vec_length(a));
    out = put1(out, vec_maxComponent(a));
    out = put1(out, vec_minComponent(a));
    out = put1(out, vec_luminance(a));
    out = put1(out, vec_differenceOfProducts(a.x, a.y, b.x, s));
    HdsFrame frame = frame_fromNormal(vec_normalize(a));
    out = put3(out, frame.x);
    out = put3(out, frame.y);
    out = put3(out, frame.z);
    out = put3(out, frame_toLocal(&frame, b));
    out = put3(out, frame_toWorld(&frame, b));
    out = put3(out, transform_vector(&m, a));
    out = put3(out, transform_point(&m, a));
    out = put1(out, fma(2.0f, s, t));
    out = put1(out, fma(s, 2.0f, t));
    out = put1(out, fma(s, t, 2.0f));
    out = put1(out, fma(s, 2.0f, 3.0f));
    out = put1(out, fma(2.0f, s, 3.0f));
    out = put1(out, fma(2.0f, 3.0f, s));
    out = put1(out, fmax(0.0f, s));
    out = put1(out, fmax(s, 0.0f));
    out = put1(out, fmin(1.0f, s));
    out = put1(out, fmin(s, t));
    out = put1(out, fmax(s, t));
    out = put1(out, copysign(1.0f, s));
    out = put1(out, copysign(s, t));
    out = put1(out, clamp(s, -1.0f, 1.0f));
    out = put1(out, rint(s));
    out = put1(out, sqrt(fabs(s)));
    out = putFlag(out, isLess);
}
void angles(const HdsTestContext* context, const Real* in, Real* out) {
    out = put2(out, trig_rotate(in[0], as_Int(in[1])));
    out = put2(out, trig_turns(in[2]));
    out = put2(out, trig_radians(in[3]));
    out = put1(out, trig_atan2(in[4], in[5]));
    out = put2(out, warp_disk(take2(in + 6)));
    out = put3(out, warp_cosineHemisphere(take2(in + 6)));
    out = put3(out, warp_cone(take2(in + 6), in[8]));
    out = put1(out, warp_conePdf(in[8]));
    out = put1(out, warp_cosineHemispherePdf(in[9]));
}
Real* putSampler(Real* out, HdsSampler sampler) {
    out = putBits(out, sampler.pixelHash);
    out = putBits(out, sampler.sample);
    return putBits(out, sampler.seed);
}
void numbers(const HdsTestContext* context, const Real* in, Real* out) {
    const Uint x = as_Uint(in[0]);
    const Uint y = as_Uint(in[1]);
    const Uint dimension = as_Uint(in[3]);
    const HdsSampler sampler = sampler_init(x, y, as_Uint(in[2]), context->frame->seed);
    out = putBits(out, sampler_hash(x));
    out = putBits(out, sampler_hashCombine(x, y));
    out = putBits(out, sampler_reverseBits(x));
    out = putBits(out, sampler_laineKarras(x, y));
    out = putBits(out, sampler_sobolSecondReversed(x));
    out = put1(out, sampler_toUnit(x));
    out = putSampler(out, sampler);
    out = put2(out, sampler_get2(sampler, dimension));
    out = put1(out, sampler_get1(sampler, dimension));
    out = put1(out, sampler_get1(sampler, (Uint)(HDS_DIM_LENS)));
    out = putSampler(out, sampler_fork(sampler, y));
    out = putSampler(out, pixel_sampler(context->frame, x, y));
    out = putBits(out, as_Uint(pixel_column(context->frame, x)));
    out = putBits(out, as_Uint(pixel_row(context->frame, x)));
    out = put2(out, filter_sample2(context->table, take2(in + 4)));
}
Real* putRay(Real* out, HdsCameraRay ray) {
    out = put3(out, ray.origin);
    out = put3(out, ray.direction);
    out = put1(out, ray.tMin);
    out = put1(out, ray.tMax);
    return put2(out, ray.cone);
}
void rays(const HdsTestContext* context, const Real* in, Real* out) {
    constant const HdsFrameParams* frame = context->frame;
    const Uint pixel = as_Uint(in[0]);
    const HdsSampler sampler = pixel_sampler(frame, pixel, as_Uint(in[1]));
    const HdsTransform pose = camera_pose(frame, 0.0f);
    const HdsLens lens = camera_lens(frame, 0.0f);
    out = putRay(out, generate_ray(frame, &pose, &lens, pixel, sampler, context->table));
    out = putRay(out, camera_generate(frame, &pose, &lens, take2(in + 2),
                                 camera_aperture(frame, take2(in + 4))));
}
#define HDS_TEST_FIELDS_Frame(R1, R2, R3, U) R3(x) R3(y) R3(z)
HDS_TEST_STRUCT(Frame)
)";

constexpr std::size_t kVectorResults = 92;
constexpr std::size_t kRayResults = 20;

const char* const kKernels = R"(
HDS_TEST_FORMS(vectors, 8, 92)
HDS_TEST_FORMS(angles, 10, 17)
HDS_TEST_FORMS(numbers, 6, 22)
HDS_TEST_FORMS(rays, 6, 20)
HDS_TEST_LANES(Frame, 9)
)";

/// A camera of one of all kinds.
shared::HdsFrameParams Camera(LaneRandom& r) {
    shared::HdsFrameParams frame{};
    for (float& entry : frame.worldFromCamera) {
        entry = r.Signed(r.Unit());
    }
    if (r.Is(8)) { // flat: directions without a length
        std::fill(frame.worldFromCamera, frame.worldFromCamera + 12, 0.0F);
    }
    frame.filmOrigin[0] = -r.Unit();
    frame.filmOrigin[1] = r.Unit();
    frame.filmStep[0] = r.Sized(-4.0F, -1.0F);
    frame.filmStep[1] = -r.Sized(-4.0F, -1.0F);
    frame.nearClip = r.Sized(-3.0F, 0.0F);
    frame.farClip = r.Sized(0.0F, 6.0F);
    frame.lensRadius = r.Is(2) ? r.Sized(-4.0F, 0.0F) : 0.0F;
    frame.focusDistance = r.Sized(-1.0F, 2.0F);
    frame.flags = (r.Is(3) ? HDS_FRAME_ORTHOGRAPHIC : 0U) | (r.Is(4) ? HDS_FRAME_CAMERA_MOVES : 0U);
    frame.apertureWidth = 1.0F;
    frame.imageWidth = 1 + r.Kind(700);
    frame.imageHeight = 400;
    frame.seed = r.Bits();
    frame.dataWindowMin[0] = int(r.Kind(40)) - 20;
    frame.dataWindowMin[1] = int(r.Kind(40)) - 20;
    frame.numClipPlanes = r.Is(2) ? r.Kind(HDS_MAX_CLIP_PLANES + 1) : 0;
    for (auto& plane : frame.clipPlanes) {
        for (float& number : plane) {
            number = r.Is(4) ? 0.0F : r.Signed(r.Unit());
        }
    }
    return frame;
}

std::vector<float> FilterTable() {
    std::vector<float> table(513);
    for (std::size_t i = 0; i < table.size(); ++i) {
        table[i] = -1.5F * std::cos(float(i) / 512.0F * 1.5707963F);
    }
    return table;
}

class Lanes : public LanesFixture {
protected:
    void SetUp() override {
        LanesFixture::SetUp();
        if (device && !IsSkipped()) {
            _program =
                BuildForms("integrator/generate.cl", "integrator/generateRay.clh", kText, kKernels);
            LaneRandom random(5);
            _arguments.frame = Camera(random);
            _arguments.table = FilterTable();
        }
    }
    std::unique_ptr<Program> _program;
    Arguments _arguments;
};

TEST_F(Lanes, VectorsHaveTheSameBits) {
    const auto results = ExpectSameBits(
        *_program, "vectorsForms", 80000, kVectorResults,
        [](LaneRandom& r, LaneCase& one) {
            const unsigned kind = r.Kind(8);
            const float scale = kind == 0 ? 1e-40F : kind == 1 ? 1e38F : 1.0F;
            for (int k = 0; k < 8; ++k) {
                one.push_back(kind < 4 ? r.Signed(scale * r.Unit()) : r.Any());
            }
            if (r.Is(16)) {
                std::fill(one.begin(), one.begin() + 3, r.Signed(0.0F));
            }
        },
        _arguments);
    EXPECT_EQ(CountConstant(results, kVectorResults), 0U);
}

TEST_F(Lanes, AnglesAndWarpsHaveTheSameBits) {
    const auto results = ExpectSameBits(
        *_program, "anglesForms", 80000, 17,
        [](LaneRandom& r, LaneCase& one) {
            one.Add({r.Signed(0.7853982F * r.Unit()), OfBits(r.Kind(9) - 4U)});
            one.Add({r.Signed(r.Is(2) ? r.Unit() : r.Sized(0.0F, 6.0F))});
            one.Add({r.Signed(1000.0F * r.Unit())});
            for (int k = 0; k < 2; ++k) {
                const float special[] = {0.0F, 1e-40F, 1.0F, 1e38F};
                one.Add({r.Signed(r.Is(3)   ? special[r.Kind(4)]
                                  : r.Is(2) ? r.Unit()
                                            : r.Sized(-37.0F, 37.0F))});
            }
            const float u = r.Unit();
            one.Add({u, r.Is(8) ? u : r.Is(8) ? 1.0F - u : r.Unit()}); // the disk's diagonals
            one.Add({r.Is(8) ? 2.0F : r.Sized(-8.0F, 0.3F), r.Signed(r.Unit())});
        },
        _arguments);
    EXPECT_EQ(CountConstant(results, 17), 0U);
}

TEST_F(Lanes, NumbersOfSamplesHaveTheSameBits) {
    const auto results = ExpectSameBits(
        *_program, "numbersForms", 40000, 22,
        [](LaneRandom& r, LaneCase& one) {
            one.Add({OfBits(r.Bits()), OfBits(r.Bits()), OfBits(r.Bits()), OfBits(r.Kind(60))});
            one.Add({r.Unit(), r.Unit()});
        },
        _arguments);
    EXPECT_EQ(CountConstant(results, 22), 3U); // the seed
}

TEST_F(Lanes, CameraRaysHaveTheSameBits) {
    LaneRandom cameras(6);
    std::size_t numLenses = 0;
    std::size_t numOrthographic = 0;
    std::size_t numClipped = 0;
    for (unsigned i = 0; i < 200; ++i) {
        _arguments.frame = Camera(cameras);
        numLenses += _arguments.frame.lensRadius > 0.0F ? 1 : 0;
        numOrthographic += _arguments.frame.flags & HDS_FRAME_ORTHOGRAPHIC;
        numClipped += _arguments.frame.numClipPlanes > 0 ? 1 : 0;
        ExpectSameBits(
            *_program, "raysForms", 256, kRayResults,
            [&](LaneRandom& r, LaneCase& one) {
                one.Add({OfBits(r.Kind(_arguments.frame.imageWidth * 400)), OfBits(r.Kind(1000))});
                one.Add({r.Between(-30.0F, 700.0F), r.Between(-30.0F, 400.0F), r.Unit(), r.Unit()});
            },
            _arguments, 10 + i);
    }
    EXPECT_GT(std::min({numLenses, numOrthographic, numClipped}), 40U);
}

TEST_F(Lanes, StructsLieInTheirLane) {
    ExpectLanes(*_program, "Frame", 9);
}

} // namespace
} // namespace hds::test
