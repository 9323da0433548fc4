// SPDX-License-Identifier: Apache-2.0
// Rect and sphere lights, panels, lights at infinity and the choice of a light: 8 paths at once
// against one.
#include "hdStream/integrator/kernelFeatures.h"
#include "testenv/device/math/lanesFixture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hds::test {
namespace {

const char* const kText = R"(
#define HDS_TEST_FIELDS_ShapeLight(R1, R2, R3, U)                                            \
    R3(worldFromLight[0]) R3(worldFromLight[1]) R3(worldFromLight[2])                       \
    R3(lightFromWorld[0]) R3(lightFromWorld[1]) R3(lightFromWorld[2])                       \
    R3(origin) R3(radiance) R1(width) R1(height)
HDS_TEST_STRUCT(ShapeLight)
/* in: a light, a point, two numbers, the point in the light's space. */
void rects(const HdsTestContext* context, const Real* in, Real* out) {
    HdsShapeLight rect;
    ShapeLight_make(&rect, in);
    const Real3 position = take3(in + 26);
    const Real2 u = take2(in + 29);
    const Real3 q = take3(in + 31);
    const HdsSphericalRect r = rect_spherical(rect.width, rect.height, q);
    const Bool isSeen = q.z < 0.0f;
    out = put1(out, r.x0);
    out = put1(out, r.x1);
    out = put1(out, r.y0);
    out = put1(out, r.y1);
    out = put1(out, r.z0);
    out = put2(out, r.left);
    out = put1(out, r.solidAngle);
    out = put3(out, only(isSeen, sphericalRect_sample(&r, u)));
    HdsShapeSample shape;
    const Bool isSampled = rect_sample(rect.width, rect.height, q, u, &shape);
    out = putFlag(out, isSampled);
    out = put3(out, only(isSampled, shape.direction));
    out = put1(out, only1(isSampled, shape.distance));
    out = put1(out, only1(isSampled, shape.pdf));
    out = put1(out, rect_pdf(rect.width, rect.height, q, only(isSampled, shape.direction)));
    HdsLightSample light;
    const Bool isLit = rect_sampleWorld(&rect, position, u, &light);
    out = putFlag(out, isLit);
    out = put3(out, only(isLit, light.direction));
    out = put3(out, only(isLit, light.radiance));
    out = put1(out, only1(isLit, light.distance));
    out = put1(out, only1(isLit, light.pdf));
}
/* As rects; the light's width is the sphere's radius. */
void spheres(const HdsTestContext* context, const Real* in, Real* out) {
    HdsShapeLight sphere;
    ShapeLight_make(&sphere, in);
    HdsLightSample light;
    const Bool isLit = sphere_sampleWorld(&sphere, take3(in + 26), take2(in + 29), &light);
    out = put1(out, sphere_oneMinusCos(sphere.width, take3(in + 31)));
    out = putFlag(out, isLit);
    out = put3(out, only(isLit, light.direction));
    out = put3(out, only(isLit, light.radiance));
    out = put1(out, only1(isLit, light.distance));
    out = put1(out, only1(isLit, light.pdf));
}
/* in: a point, its normal, its link set, a number. out: the estimates of the first lights too. */
void choices(const HdsTestContext* context, const Real* in, Real* out) {
    HdsLightView view;
    view.lights = context->lights;
    view.nodes = 0;
    view.triangles = 0;
    view.cdf = context->table;
    view.numLights = context->numLights;
    HdsLitPoint at;
    at.position = take3(in);
    at.normal = take3(in + 3);
    at.linkSet = as_Uint(in[6]);
    Real u = in[7];
    Real pmf;
    out = putBits(out, light_selectFromLoop(&view, &at, &u, &pmf));
    out = put1(out, u);
    out = put1(out, pmf);
    for (uint i = 0u; i < view.numLights; ++i) {
        out = put1(out, light_estimate(&view, i, &at));
    }
}
)";

const char* const kPanelText = R"(
#define HDS_TEST_FIELDS_Panel(R1, R2, R3, U)                                                \
    R3(p0[0]) R3(p0[1]) R3(e1[0]) R3(e1[1]) R3(e2[0]) R3(e2[1]) R3(radiance)                \
    R1(error[0]) R1(error[1]) R1(firstShare) R1(area) U(isTwoSided)
HDS_TEST_STRUCT(Panel)
/* in: a light, a point, two numbers. */
void panels(const HdsTestContext* context, const Real* in, Real* out) {
    HdsPanel panel;
    Panel_make(&panel, in);
    const Real3 position = take3(in + 26);
    HdsSphericalTriangle first;
    HdsSphericalTriangle second;
    out = put1(out, panel_look(&panel, position, &first, &second));
    HdsLightSample light;
    const Bool isLit = panel_sampleWorld(&panel, position, take2(in + 29), &light);
    out = putFlag(out, isLit);
    out = put3(out, only(isLit, light.direction));
    out = put3(out, only(isLit, light.radiance));
    out = put1(out, only1(isLit, light.distance));
    out = put1(out, only1(isLit, light.pdf));
}
)";

constexpr std::size_t kPanelResults = 10;

const char* const kPanelKernels = R"(
HDS_TEST_FORMS(panels, 31, 10)
HDS_TEST_LANES(Panel, 26)
)";

const char* const kFarText = R"(
/* in: a normal or zero, two numbers, a direction. out: a sample of each light, and where the
 * direction meets the image of the first light. */
void farLights(const HdsTestContext* context, const Real* in, Real* out) {
    for (uint i = 0u; i < context->numLights; ++i) {
        global const HdsLight* light = context->lights + i;
        HdsLightSample s;
        s.image = take2(in + 3);
        s.color = vec_splat((Real)(0.0f));
        far_sample(light, context->table, take3(in), take3(in), take2(in + 3), &s);
        out = put3(out, s.direction);
        out = put3(out, s.radiance);
        out = put3(out, s.color);
        out = put2(out, s.image);
        out = put1(out, s.distance);
        out = put1(out, s.pdf);
    }
    const HdsImagePlace place = dome_placeOf(context->lights, context->table, take3(in + 5));
    out = put3(out, place.color);
    out = put2(out, place.image);
    out = put1(out, place.x);
    out = put1(out, place.y);
    out = put1(out, place.pdf);
    out = put1(out, place.inCell);
}
)";

constexpr std::size_t kSampleResults = 13;
constexpr std::size_t kFarLights = 4;
constexpr std::size_t kFarResults = kFarLights * kSampleResults + 9;

const char* const kFarKernels = R"(
HDS_TEST_FORMS(farLights, 8, 61)
)";

constexpr std::size_t kRectResults = 26;
constexpr std::size_t kSphereResults = 10;
constexpr std::size_t kChoiceResults = 3 + HDS_LIGHT_LOOP_MAX;

const char* const kKernels = R"(
HDS_TEST_FORMS(rects, 34, 26)
HDS_TEST_FORMS(spheres, 34, 10)
HDS_TEST_FORMS(choices, 8, 35)
HDS_TEST_LANES(ShapeLight, 26)
)";

using Vec = std::array<float, 3>;

/// Coordinates of a point seen from a rect of that size: near, far, beside it, behind it, in its
/// plane.
Vec PointBefore(LaneRandom& r, float width, float height) {
    const unsigned kind = r.Kind(8);
    const float distance = kind == 1   ? r.Sized(-6.0F, -2.0F)
                           : kind == 2 ? r.Sized(1.0F, 5.0F)
                           : kind == 3 ? r.Sized(-8.0F, -4.0F)
                                       : r.Sized(-1.0F, 1.0F);
    const float spread = kind == 3 ? 20.0F : 2.0F;
    const float z = kind == 4 ? distance : kind == 5 ? r.Signed(0.0F) : -distance;
    return {r.Signed(spread * width * r.Unit()), r.Signed(spread * height * r.Unit()), z};
}

/// A rotation from random angles, its rows.
std::array<Vec, 3> Rotation(LaneRandom& r) {
    const float a = 6.2831853F * r.Unit();
    const float b = 6.2831853F * r.Unit();
    const Vec z = {std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)};
    const Vec x = {-std::sin(a), std::cos(a), 0.0F};
    const Vec y = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
    return {x, y, z};
}

void AddRect(LaneRandom& r, LaneCase& one) {
    const std::array<Vec, 3> lightFromWorld = Rotation(r); // and its transpose back
    for (std::size_t row = 0; row < 3; ++row) {
        one.Add({lightFromWorld[0][row], lightFromWorld[1][row], lightFromWorld[2][row]});
    }
    for (const Vec& row : lightFromWorld) {
        one.Add({row[0], row[1], row[2]});
    }
    const float scale = r.Is(4) ? 100.0F : 1.0F;
    const Vec origin = {scale * r.Unit(), -scale * r.Unit(), scale * r.Unit()};
    one.Add({origin[0], origin[1], origin[2]});
    one.AddColor(r, 30.0F);
    const float width = r.Sized(-3.0F, 2.0F);
    const float height = r.Is(2) ? width : r.Sized(-3.0F, 2.0F);
    one.Add({width, height});
    const Vec q = PointBefore(r, width, height);
    for (std::size_t k = 0; k < 3; ++k) {
        one.push_back(lightFromWorld[0][k] * q[0] + lightFromWorld[1][k] * q[1] +
                      lightFromWorld[2][k] * q[2] + origin[k]);
    }
    one.Add({r.Unit(), r.Unit()});
    one.Add({q[0], q[1], q[2]});
}

/// A quad, or a triangle alone, at any place; a point near it, far away, or in its plane; two
/// numbers.
void AddPanel(LaneRandom& r, LaneCase& one) {
    const auto add = [&](const Vec& v) { one.Add({v[0], v[1], v[2]}); };
    const auto along = [](const Vec& p, float s, const Vec& e, float t, const Vec& f) {
        return Vec{p[0] + s * e[0] + t * f[0], p[1] + s * e[1] + t * f[1],
                   p[2] + s * e[2] + t * f[2]};
    };
    const std::array<Vec, 3> axes = Rotation(r);
    const float scale = r.Is(4) ? 100.0F : 1.0F;
    const Vec origin = {scale * r.Unit(), -scale * r.Unit(), scale * r.Unit()};
    const Vec zero = {0.0F, 0.0F, 0.0F};
    const float width = r.Sized(-3.0F, 2.0F);
    const float height = r.Is(2) ? width : r.Sized(-3.0F, 2.0F);
    const Vec e1 = along(zero, width, axes[0], 0.0F, zero);
    const Vec e2 = along(zero, height, axes[1], 0.3F * width * r.Unit(), axes[0]);
    const bool isAlone = r.Is(4);
    add(origin);
    add(isAlone ? origin : along(origin, 1.0F, e1, 1.0F, e2));
    add(e1);
    add(isAlone ? zero : along(zero, -1.0F, e1, 0.0F, zero));
    add(e2);
    add(isAlone ? zero : along(zero, -1.0F, e2, 0.0F, zero));
    one.AddColor(r, 30.0F);
    one.Add({1e-6F * scale, 2e-6F * scale, isAlone ? 1.0F : 0.5F});
    one.Add({width * height, OfBits(r.Is(3) ? HDS_LIGHT_TWO_SIDED : 0U)});
    const Vec q = PointBefore(r, width, height);
    add(along(along(origin, q[0], axes[0], q[1], axes[1]), q[2], axes[2], 0.0F, zero));
    one.Add({r.Unit(), r.Unit()});
}

/// A point's normal, or that it has none; two numbers; a direction, at times a pole's.
void AddFar(LaneRandom& r, LaneCase& one) {
    if (r.Is(4)) {
        one.Add({0.0F, 0.0F, 0.0F});
    } else {
        one.AddDirection(r, -1.0F);
    }
    one.Add({r.Unit(), r.Unit()});
    if (r.Is(8)) {
        one.Add({0.0F, r.Signed(1.0F), 0.0F});
    } else {
        one.AddDirection(r, -1.0F);
    }
}

/// Where the portals of domes lie in the table.
constexpr std::uint32_t kPortalBase = 3;
constexpr unsigned kNumPortals = 2;

shared::HdsLight Finite(LaneRandom& r, std::uint32_t type) {
    shared::HdsLight light{};
    light.type = type;
    for (float& entry : light.worldFromLight) {
        entry = r.Signed(r.Unit());
    }
    for (float& entry : light.lightFromWorld) {
        entry = r.Signed(r.Unit());
    }
    const Vec axis = Rotation(r)[2];
    for (std::size_t row = 0; row < 3; ++row) { // the unit normal of its planes
        light.lightFromWorld[4 * row + 3] = axis[row];
        light.center[row] = r.Signed(5.0F * r.Unit());
    }
    if (type == HDS_LIGHT_MESH) {
        std::copy(axis.begin(), axis.end(), light.worldFromLight);
    }
    light.params[0] = r.Unit();
    light.boundRadius = r.Is(6) ? 0.0F : r.Sized(-3.0F, 0.5F);
    light.strength = r.Is(5) ? 0.0F : r.Sized(-3.0F, 3.0F);
    light.flags = r.Bits() & (HDS_LIGHT_TWO_SIDED | HDS_LIGHT_SAMPLED | HDS_LIGHT_TEXTURED);
    light.treePlace = light.shapingBase = light.controlBase = HDS_NONE;
    light.lightLink = light.shadowLink = HDS_NONE;
    return light;
}

/// Lights at infinity come first.
std::vector<shared::HdsLight> Lights(LaneRandom& r, std::size_t count) {
    const std::uint32_t types[] = {HDS_LIGHT_SPHERE, HDS_LIGHT_RECT, HDS_LIGHT_DISK,
                                   HDS_LIGHT_CYLINDER, HDS_LIGHT_MESH};
    const unsigned numFar = r.Kind(std::min<unsigned>(unsigned(count), 4) + 1);
    std::vector<shared::HdsLight> lights;
    for (unsigned i = 0; i < count; ++i) {
        shared::HdsLight light = Finite(r, types[r.Kind(5)]);
        if (i < numFar) {
            light.type = r.Is(2) ? HDS_LIGHT_DISTANT : HDS_LIGHT_DOME;
            light.boundRadius = HDS_LIGHT_FAR;
            light.params[0] = r.Is(3) ? 0.0F : 2.0F * r.Unit();
            light.treePlace = r.Is(2) ? kPortalBase : HDS_NONE;
        }
        lights.push_back(light);
    }
    return lights;
}

/// A dome with an image, one without, and distant lights with an angle and without. \param[out]
/// table with the dome's distribution and texels, as random as such may be: some rows and cells are
/// empty.
std::vector<shared::HdsLight> FarLights(LaneRandom& r, std::vector<float>* table) {
    std::vector<shared::HdsLight> lights;
    for (std::size_t i = 0; i < kFarLights; ++i) {
        lights.push_back(Finite(r, i < 2 ? HDS_LIGHT_DOME : HDS_LIGHT_DISTANT));
        lights[i].boundRadius = HDS_LIGHT_FAR;
        lights[i].flags = i == 0 ? HDS_LIGHT_TEXTURED : i == 3 ? HDS_LIGHT_POINT : 0U;
        lights[i].params[0] = 2.0F * r.Unit() + 0x1p-20F;
        for (float& channel : lights[i].radiance) {
            channel = 5.0F * r.Unit();
        }
    }
    const std::uint32_t width = 1U + r.Kind(r.Is(2) ? 8 : 300);
    const std::uint32_t numRows = 2U + r.Kind(r.Is(2) ? 4 : 200);
    lights[0].dataSize[0] = width;
    lights[0].dataSize[1] = numRows;
    lights[0].cdfBase = 1U + r.Kind(50);
    table->assign(lights[0].cdfBase, float(NAN)); // of other lights
    const auto addCdf = [&](std::uint32_t count) {
        std::vector<float> cdf(count + 1, 0.0F);
        for (std::uint32_t i = 0; i < count; ++i) {
            const bool isEmpty = r.Bits() % 5 == 0 && (i + 1 < count || cdf[i] > 0.0F);
            cdf[i + 1] = cdf[i] + (isEmpty ? 0.0F : 0.01F + r.Unit());
        }
        for (float& entry : cdf) {
            entry = cdf.back() > 0.0F ? entry / cdf.back() : entry;
        }
        table->insert(table->end(), cdf.begin(), cdf.end());
    };
    for (std::uint32_t row = 0; row <= numRows; ++row) {
        addCdf(row == 0 ? numRows : width);
    }
    for (std::uint32_t texel = 0; texel < width * (numRows - 1); ++texel) {
        table->push_back(OfBits(r.Bits()));
        table->push_back(OfBits((90U + r.Bits() % 60) << 16U | (r.Bits() & 0xffffU)));
    }
    return lights;
}

/// The table of lights with a dome's portals in it.
std::vector<float> PortalTable(LaneRandom& r) {
    std::vector<float> table(kPortalBase + HDS_DOME_PORTALS);
    table[kPortalBase] = OfBits(kNumPortals);
    for (unsigned i = 0; i < kNumPortals; ++i) {
        const shared::HdsLight portal = Finite(r, HDS_LIGHT_RECT);
        const auto* words = reinterpret_cast<const float*>(&portal);
        table.insert(table.end(), words, words + sizeof(portal) / sizeof(float));
    }
    return table;
}

void AddPoint(LaneRandom& r, const shared::HdsLight& light, LaneCase& one) {
    if (r.Is(6)) { // in the middle of a light
        one.Add({light.center[0], light.center[1], light.center[2]});
    } else {
        const float size = r.Is(4) ? 500.0F : 6.0F;
        one.Add({r.Signed(size * r.Unit()), r.Signed(size * r.Unit()), r.Signed(size * r.Unit())});
    }
    if (r.Is(4)) {
        one.Add({0.0F, 0.0F, 0.0F});
    } else {
        one.AddDirection(r, -1.0F);
    }
    one.Add({OfBits(r.Kind(90)), r.Unit()});
}

class WideLights : public LanesFixture {
protected:
    void Build(KernelFeatures features) {
        _program = BuildForms("integrator/shade.cl", "integrator/shadeScatter.clh", kText, kKernels,
                              features.WithNeeds().Defines());
    }
    /// \return how many points find no light.
    std::size_t ExpectSameChoices(std::size_t numLights, unsigned seed) {
        LaneRandom random(seed);
        Arguments arguments;
        arguments.table = PortalTable(random);
        arguments.lights = Lights(random, numLights);
        const auto results = ExpectSameBits(
            *_program, "choicesForms", 800, kChoiceResults,
            [&](LaneRandom& r, LaneCase& one) {
                AddPoint(r, arguments.lights[r.Kind(unsigned(numLights))], one);
            },
            arguments, seed);
        std::size_t numNone = 0;
        for (std::size_t i = 0; i < results.size(); i += kChoiceResults) {
            numNone += results[i] == HDS_NONE ? 1 : 0;
            _chosen.push_back(results[i]);
        }
        return numNone;
    }
    std::unique_ptr<Program> _program;
    std::vector<std::uint32_t> _chosen;
};

TEST_F(WideLights, RectsHaveTheSameBits) {
    Build({});
    const auto results =
        ExpectSameBits(*_program, "rectsForms", 80000, kRectResults, AddRect, {}, 7);
    EXPECT_EQ(CountConstant(results, kRectResults), 0U);
    ExpectLanes(*_program, "ShapeLight", 26);
}

TEST_F(WideLights, SpheresHaveTheSameBits) {
    Build({});
    const auto results =
        ExpectSameBits(*_program, "spheresForms", 80000, kSphereResults, AddRect, {}, 11);
    EXPECT_EQ(CountConstant(results, kSphereResults), 0U);
    std::size_t numLit = 0;
    for (std::size_t i = 0; i < results.size(); i += kSphereResults) {
        numLit += OfBits(results[i + 1]) > 0.0F ? 1 : 0;
    }
    EXPECT_GT(numLit, 10000U);
    EXPECT_LT(numLit, results.size() / kSphereResults - 1000U); // others are inside
}

TEST_F(WideLights, PanelsHaveTheSameBits) {
    KernelFeatures features;
    features.meshLights = true;
    const auto program = BuildForms("integrator/shade.cl", "integrator/shadeScatter.clh",
                                    kPanelText, kPanelKernels, features.WithNeeds().Defines());
    const auto results =
        ExpectSameBits(*program, "panelsForms", 80000, kPanelResults, AddPanel, {}, 9);
    EXPECT_EQ(CountConstant(results, kPanelResults), 0U);
    std::size_t numSubtended = 0;
    std::size_t numByArea = 0;
    for (std::size_t i = 0; i < results.size(); i += kPanelResults) {
        const bool isLit = OfBits(results[i + 1]) > 0.0F;
        (OfBits(results[i]) > 0.0F ? numSubtended : numByArea) += isLit ? 1 : 0;
    }
    EXPECT_GT(numSubtended, 7500U);
    EXPECT_GT(numByArea, 10000U);
    ExpectLanes(*program, "Panel", 26);
}

TEST_F(WideLights, LightsAtInfinityHaveTheSameBits) {
    KernelFeatures features;
    features.textures = true;
    const auto program = BuildForms("integrator/shade.cl", "integrator/shadeScatter.clh", kFarText,
                                    kFarKernels, features.WithNeeds().Defines());
    std::size_t leastConstant = kFarResults;
    for (unsigned seed = 0; seed < 40; ++seed) {
        LaneRandom random(seed);
        Arguments arguments;
        arguments.lights = FarLights(random, &arguments.table);
        const auto results = ExpectSameBits(*program, "farLightsForms", 2000, kFarResults, AddFar,
                                            arguments, 8 + seed);
        for (std::size_t i = 0; i < results.size(); i += kFarResults) { // no empty cell is chosen
            ASSERT_GT(OfBits(results[i + kSampleResults - 1]), 0.0F) << seed << " " << i;
        }
        leastConstant = std::min(leastConstant, CountConstant(results, kFarResults));
    }
    // Of each light the radiance and the distance, of three no colour, the density of two, and a
    // direction. Images of few texels have more.
    EXPECT_EQ(leastConstant, 30U);
}

TEST_F(WideLights, ChoicesHaveTheSameBits) {
    KernelFeatures all;
    all.meshLights = true;
    all.lightPortals = true;
    for (const KernelFeatures& features : {KernelFeatures{}, all}) {
        Build(features);
        std::size_t numNone = 0;
        for (unsigned numLights = 2; numLights <= HDS_LIGHT_LOOP_MAX; ++numLights) {
            for (unsigned seed = 0; seed < 4; ++seed) {
                numNone += ExpectSameChoices(numLights, 4 * numLights + seed);
            }
        }
        EXPECT_GT(numNone, 100U);
        for (std::uint32_t light = 0; light < HDS_LIGHT_LOOP_MAX; ++light) {
            EXPECT_NE(std::count(_chosen.begin(), _chosen.end(), light), 0) << light;
        }
    }
}

} // namespace
} // namespace hds::test
