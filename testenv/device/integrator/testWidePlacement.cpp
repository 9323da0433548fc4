// SPDX-License-Identifier: Apache-2.0
// Points of triangles, hits that are carried to world space, footprints of ray cones, and bounds of
// lights: 8 paths at once against one.
#include "testenv/device/math/lanesFixture.h"

#include "hdStream/integrator/kernelFeatures.h"

#include <algorithm>

namespace hds::test {
namespace {

const char* const kText = R"(
HdsAffine takeMap(const Real* in) {
    HdsAffine map;
    for (uint i = 0u; i < 3u; ++i) {
        map.rows[i] = take3(in + 3u * i);
    }
    map.translation = take3(in + 9);
    return map;
}
void inverse(const HdsTestContext* context, const Real* in, Real* out) {
    const HdsAffine map = takeMap(in);
    const HdsAffine back = affine_inverse(&map);
    for (uint i = 0u; i < 3u; ++i) {
        out = put3(out, back.rows[i]);
    }
    out = put3(out, back.translation);
    out = put3(out, affine_point(&map, take3(in + 12)));
    out = put3(out, affine_vector(&map, take3(in + 12)));
    out = put3(out, affine_normal(&map, take3(in + 12)));
}
#define HDS_TEST_FIELDS_Placement(R1, R2, R3, U)                                  \
    R3(position) R3(normal) R3(shadingNormal) R3(e1) R3(e2) R1(planeError)        \
    R1(curvature) R1(objectArea)
HDS_TEST_STRUCT(Placement)
#define HDS_TEST_FIELDS_Affine(R1, R2, R3, U) R3(rows[0]) R3(rows[1]) R3(rows[2]) R3(translation)
HDS_TEST_STRUCT(Affine)
void placement(const HdsTestContext* context, const Real* in, Real* out) {
    HdsPlacement hit;
    Placement_make(&hit, in);
    const HdsAffine first = takeMap(in + 18);
    const HdsAffine second = takeMap(in + 30);
    placement_begin(&hit);
    placement_toParent(&first, &hit);
    placement_toParent(&second, &hit);
    placement_end(&hit);
    Placement_store(&hit, out);
}
/* in: corners and their normals, weights of two of them, whether normals count. */
void triangle(const HdsTestContext* context, const Real* in, Real* out) {
    HdsTrianglePoint t;
    t.p0 = take3(in);
    t.p1 = take3(in + 3);
    t.p2 = take3(in + 6);
    t.n0 = take3(in + 9);
    t.n1 = take3(in + 12);
    t.n2 = take3(in + 15);
    t.u = in[18];
    t.v = in[19];
    t.hasNormals = in[20] > 0.0f;
    HdsPlacement hit;
    trianglePoint_place(&t, &hit);
    hit.objectArea = in[18];
    Placement_store(&hit, out);
}
void footprint(const HdsTestContext* context, const Real* in, Real* out) {
    const HdsFootprint ellipse = cones_meet(in[0], take3(in + 1), take3(in + 4), take3(in + 7));
    out = put2(out, ellipse.first);
    out = put2(out, ellipse.second);
}
void bound(const HdsTestContext* context, const Real* in, Real* out) {
    out = putFlag(out, light_passes(take3(in), in[3], take3(in + 4), take3(in + 7)));
}
)";

constexpr std::size_t kInverseResults = 21;
constexpr std::size_t kPlacementResults = 18;
constexpr std::size_t kFootprintResults = 4;

const char* const kKernels = R"(
HDS_TEST_FORMS(inverse, 15, 21)
HDS_TEST_FORMS(placement, 42, 18)
HDS_TEST_FORMS(triangle, 21, 18)
HDS_TEST_FORMS(footprint, 10, 4)
HDS_TEST_FORMS(bound, 10, 1)
HDS_TEST_LANES(Placement, 18)
HDS_TEST_LANES(Affine, 12)
)";

/// Maps with shear and scales of any size; some are flat, some the identity.
void AddMap(LaneRandom& r, LaneCase& one) {
    const unsigned kind = r.Kind(6);
    const float size = kind == 1 ? r.Sized(-12.0F, 12.0F) : 1.0F;
    for (int i = 0; i < 9; ++i) {
        const float entry = kind == 0 ? (i % 4 == 0 ? 1.0F : 0.0F) : r.Signed(size * r.Unit());
        one.push_back(kind == 2 && i < 3 ? 0.0F : entry);
    }
    for (int i = 0; i < 3; ++i) {
        one.push_back(kind == 0 ? 0.0F : r.Signed(r.Sized(-3.0F, 4.0F)));
    }
}

/// Three numbers of one size; some are zero or as small as any.
void AddVector(LaneRandom& r, LaneCase& one) {
    const unsigned kind = r.Kind(8);
    const float size = kind == 0 ? 0.0F : kind == 1 ? 1e-40F : r.Sized(-3.0F, 3.0F);
    one.Add({r.Signed(size * r.Unit()), r.Signed(size * r.Unit()), r.Signed(size * r.Unit())});
}

class WidePlacement : public LanesFixture {
protected:
    void SetUp() override {
        LanesFixture::SetUp();
        if (!device || IsSkipped()) {
            return;
        }
        KernelFeatures features;
        features.textures = true;
        _program = BuildForms("integrator/shade.cl", "integrator/shadeScatter.clh", kText, kKernels,
                              features.WithNeeds().Defines());
    }
    /// Every result differs between cases, and all have the same bits in both forms.
    void Expect(const char* kernel, std::size_t numOut,
                const std::function<void(LaneRandom&, LaneCase&)>& make) {
        const auto results = ExpectSameBits(*_program, kernel, 40000, numOut, make, Arguments{});
        EXPECT_EQ(CountConstant(results, numOut), 0U);
    }
    std::unique_ptr<Program> _program;
};

TEST_F(WidePlacement, InversesHaveTheSameBits) {
    Expect("inverseForms", kInverseResults, [](LaneRandom& r, LaneCase& one) {
        AddMap(r, one);
        AddVector(r, one);
    });
}

TEST_F(WidePlacement, PlacementsHaveTheSameBits) {
    Expect("placementForms", kPlacementResults, [](LaneRandom& r, LaneCase& one) {
        for (int i = 0; i < 5; ++i) {
            AddVector(r, one);
        }
        one.Add({r.Sized(-8.0F, -3.0F), r.Signed(r.Unit()), r.Unit()});
        AddMap(r, one);
        AddMap(r, one);
    });
}

TEST_F(WidePlacement, TrianglesHaveTheSameBits) {
    Expect("triangleForms", kPlacementResults, [](LaneRandom& r, LaneCase& one) {
        for (int i = 0; i < 6; ++i) {
            AddVector(r, one);
        }
        one.Add({r.Unit(), 0.5F * r.Unit(), r.Is(3) ? 0.0F : 1.0F});
    });
}

TEST_F(WidePlacement, FootprintsHaveTheSameBits) {
    Expect("footprintForms", kFootprintResults, [](LaneRandom& r, LaneCase& one) {
        one.push_back(r.Is(8) ? 0.0F : r.Sized(-6.0F, 2.0F));
        AddVector(r, one);
        AddVector(r, one);
        if (r.Is(8)) { // along the normal of edges in a plane
            std::fill(one.end() - 6, one.end(), 0.0F);
            one[1] = one[5] = r.Unit();
            one.Add({0.0F, 0.0F, 1.0F});
        } else {
            one.AddDirection(r, -1.0F);
        }
    });
}

TEST_F(WidePlacement, BoundsOfLightsHaveTheSameBits) {
    Expect("boundForms", 1, [](LaneRandom& r, LaneCase& one) {
        AddVector(r, one);
        one.push_back(r.Sized(-3.0F, 3.0F));
        AddVector(r, one);
        one.AddDirection(r, -1.0F);
    });
}

TEST_F(WidePlacement, LanesHoldWhatIsPutThere) {
    ExpectLanes(*_program, "Placement", kPlacementResults);
    ExpectLanes(*_program, "Affine", 12);
}

} // namespace
} // namespace hds::test
