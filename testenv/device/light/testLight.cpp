// SPDX-License-Identifier: Apache-2.0
// kernels/light: samples hit the light they aim at, with the density of that hit; intersections
// equal double precision; selection is a probability that is zero only where light cannot reach.
#include "testenv/device/light/lightFixture.h"

#include <glm/gtc/matrix_access.hpp>

#include <algorithm>
#include <cmath>
#include <random>

namespace hds::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

glm::dvec3 RandomUnit(std::mt19937& generator) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(generator), normal(generator), normal(generator)));
}

glm::dmat4 RandomTransform(std::mt19937& generator, bool isSheared) {
    std::uniform_real_distribution<double> uniform;
    glm::dmat4 m = glm::translate(glm::dmat4(1.0), 5.0 * RandomUnit(generator));
    m = glm::rotate(m, 3.0 * uniform(generator), RandomUnit(generator));
    m = glm::scale(m, glm::dvec3(0.5) +
                          glm::dvec3(uniform(generator), uniform(generator), uniform(generator)));
    if (isSheared) {
        m[1] += 0.4 * m[0];
    }
    return m;
}

/// The nearest hit of the emitting side in light space, or 0.
double ReferenceHit(const LightDescription& light, const glm::dvec3& o, const glm::dvec3& d) {
    const double radius = light.radius;
    if (light.type == LightType::Rect || light.type == LightType::Disk) {
        const glm::dvec3 p = o - d * (o.z / d.z);
        const bool isInside =
            light.type == LightType::Disk
                ? p.x * p.x + p.y * p.y <= radius * radius
                : std::abs(p.x) <= 0.5 * light.width && std::abs(p.y) <= 0.5 * light.height;
        return o.z < 0.0 && d.z > 0.0 && isInside ? -o.z / d.z : 0.0;
    }
    const glm::dvec3 across(light.type == LightType::Cylinder ? 0.0 : 1.0, 1.0, 1.0);
    const double a = glm::dot(d * across, d);
    const double b = glm::dot(o * across, d);
    const double c = glm::dot(o * across, o) - radius * radius;
    const double discriminant = b * b - a * c;
    if (c <= 0.0 || discriminant < 0.0 || b >= 0.0) {
        return 0.0;
    }
    const double t = (-b - std::sqrt(discriminant)) / a;
    const bool isInside =
        light.type == LightType::Sphere || std::abs(o.x + t * d.x) <= 0.5 * light.length;
    return isInside ? t : 0.0;
}

class LightTest : public LightFixture {
protected:
    /// Densities of sample and hit agree: within 1e-5 for half of them, 1 % for 99 %. Grazing
    /// hits of curved lights amplify the direction's rounding without bound.
    static void ExpectEqualDensities(const std::vector<LightSampleResult>& results,
                                     LightType type) {
        std::vector<double> errors;
        for (const LightSampleResult& r : results) {
            if (r.isValid && r.isHit) {
                errors.push_back(std::abs(r.hitPdf - r.pdf) / r.pdf);
            }
        }
        std::sort(errors.begin(), errors.end());
        ASSERT_FALSE(errors.empty());
        EXPECT_LT(errors[errors.size() / 2], 1e-5) << int(type);
        EXPECT_LT(errors[errors.size() * 99 / 100], 1e-2) << int(type);
    }
};

const LightType kShapes[] = {LightType::Sphere, LightType::Rect, LightType::Disk,
                             LightType::Cylinder};

TEST_F(LightTest, SamplesHitTheirLightWithTheirDensity) {
    std::mt19937 generator(41);
    constexpr std::size_t kCount = 20000;
    for (const LightType type : {LightType::Sphere, LightType::Rect, LightType::Disk,
                                 LightType::Cylinder, LightType::Distant, LightType::Dome}) {
        for (int trial = 0; trial < 6; ++trial) {
            PlacedLight light = MakeLight(type);
            light.worldFromLight = RandomTransform(generator, trial % 2 == 1);
            const glm::dvec3 origin(light.worldFromLight[3]);
            const bool isFlat = type == LightType::Rect || type == LightType::Disk;
            const glm::dmat3 inverse = glm::inverse(glm::dmat3(light.worldFromLight));
            const glm::dvec3 normal = glm::normalize(glm::row(inverse, 2));
            SetLights({light});
            std::vector<float> points;
            std::vector<float> normals;
            for (std::size_t i = 0; i < kCount; ++i) {
                const double distance = std::exp(6.0 * double(generator()) / 4294967296.0 - 1.0);
                Append(points, origin + distance * RandomUnit(generator));
                Append(normals, RandomUnit(generator));
            }
            const auto results = Sample(points, normals, RandomUnits(generator, kCount * 4));
            std::size_t numValid = 0;
            std::size_t numMissed = 0;
            for (const LightSampleResult& r : results) {
                if (!r.isValid) {
                    continue;
                }
                ++numValid;
                ASSERT_NEAR(glm::length(r.direction), 1.0, 1e-6);
                ASSERT_GT(r.pdf, 0.0);
                ASSERT_EQ(r.light, 0U);
                if (!r.isHit) {
                    ++numMissed; // a sample on the summary, rounded to the other side
                    continue;
                }
                if (r.distance < 1e30) {
                    // Seen edge-on, a flat light's distance is as uncertain as the cosine.
                    const double cosine = std::abs(glm::dot(glm::dvec3(r.direction), normal));
                    const double relative = isFlat ? 1e-5 + 1e-6 / cosine : 2e-3;
                    ASSERT_NEAR(r.hitDistance, r.distance, relative * r.distance + 1e-4)
                        << int(type);
                }
            }
            EXPECT_GT(numValid, kCount / 20) << int(type);
            EXPECT_LT(numMissed, numValid / 500 + 2) << int(type);
            ExpectEqualDensities(results, type);
        }
    }
}

TEST_F(LightTest, IntersectionsEqualDoublePrecision) {
    std::mt19937 generator(42);
    constexpr std::size_t kCount = 50000;
    for (const LightType type : kShapes) {
        PlacedLight light = MakeLight(type);
        light.light.radius = 0.7F;
        light.light.length = 2.0F;
        light.light.width = 1.5F;
        light.worldFromLight = RandomTransform(generator, true);
        SetLights({light});
        const glm::dmat4 inverse = glm::inverse(light.worldFromLight);
        std::vector<float> points;
        std::vector<float> directions;
        for (std::size_t i = 0; i < kCount; ++i) {
            const glm::dvec3 p = glm::dvec3(light.worldFromLight[3]) + 6.0 * RandomUnit(generator);
            const glm::dvec3 target =
                glm::dvec3(light.worldFromLight[3]) + 1.5 * RandomUnit(generator);
            Append(points, p);
            Append(directions, glm::normalize(target - p));
        }
        const std::vector<float> hits = Intersect(0, points, points, directions);
        std::size_t numHits = 0;
        std::size_t numDifferent = 0;
        for (std::size_t i = 0; i < kCount; ++i) {
            const glm::dvec3 o(
                inverse * glm::dvec4(points[3 * i], points[3 * i + 1], points[3 * i + 2], 1.0));
            const glm::dvec3 d(inverse * glm::dvec4(directions[3 * i], directions[3 * i + 1],
                                                    directions[3 * i + 2], 0.0));
            const double expected = ReferenceHit(light.light, o, d);
            const double found = hits[3 * i];
            if ((expected > 0.0) != (found > 0.0)) {
                ++numDifferent; // the summary, within rounding
            } else if (expected > 0.0) {
                ++numHits;
                ASSERT_NEAR(found, expected, 5e-4 * expected) << int(type);
            }
        }
        EXPECT_GT(numHits, kCount / 200) << int(type);
        EXPECT_LT(numDifferent, numHits / 1000 + 2) << int(type);
    }
}

TEST_F(LightTest, LightsAreOneSided) {
    for (const LightType type : kShapes) {
        PlacedLight light = MakeLight(type);
        light.light.radius = 1.0F;
        SetLights({light});
        // From inside a sphere or cylinder, from +z of a flat light: nothing.
        const bool isFlat = type == LightType::Rect || type == LightType::Disk;
        const std::vector<float> point = {0.0F, 0.1F, isFlat ? 2.0F : 0.2F};
        const std::vector<float> direction = {0.0F, 0.0F, -1.0F};
        EXPECT_LT(Intersect(0, point, point, direction)[0], 0.0F) << int(type);
        EXPECT_FALSE(Sample(point, {0, 0, 0}, {0.1F, 0, 0.3F, 0.4F})[0].isValid) << int(type);
    }
}

TEST_F(LightTest, DeltaLightsAreSampledAndNeverHit) {
    PlacedLight point = MakeLight(LightType::Sphere);
    point.light.treatAsPoint = true;
    SetLights({point});
    const auto result = Sample({0, 0, -3}, {0, 0, 1}, {0.5F, 0, 0.5F, 0.5F})[0];
    EXPECT_TRUE(result.isValid && result.isDelta && !result.isHit);
    EXPECT_NEAR(result.distance, 3.0, 1e-6);
    EXPECT_NEAR(result.radiance.x, kPi * 0.25 / 9.0, 1e-6);
    EXPECT_EQ(result.pdf, 1.0);
}

/// Of a triangle as the origin sees it. Source: Van Oosterom and Strackee 1983.
double SolidAngle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double la = glm::length(a);
    const double lb = glm::length(b);
    const double lc = glm::length(c);
    return 2.0 * std::atan2(std::abs(glm::dot(a, glm::cross(b, c))),
                            la * lb * lc + glm::dot(a, b) * lc + glm::dot(a, c) * lb +
                                glm::dot(b, c) * la);
}

TEST_F(LightTest, MeshSamplesEndInFrontOfTheirTriangle) {
    EmissiveMesh mesh;
    mesh.radiance = glm::dvec3(1.0);
    const glm::dvec3 p[3] = {
        {1000.1, 2000.3, 500.7}, {1001.7, 2000.1, 500.2}, {1000.9, 2001.8, 501.0}};
    mesh.triangles.push_back({{p[0], p[1], p[2]}, 0});
    mesh.twoSided = true;
    Warnings warnings;
    SetTable(BuildLightTable({}, {mesh}, {}, warnings));
    const glm::dvec3 n = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
    std::mt19937 generator(43);
    constexpr std::size_t kCount = 20000;
    std::vector<float> points;
    for (std::size_t i = 0; i < kCount; ++i) {
        const double distance = std::exp(8.0 * double(generator()) / 4294967296.0 - 3.0);
        Append(points, p[0] + distance * RandomUnit(generator));
    }
    const std::vector<float> normals(points.size(), 0.0F);
    const auto results = Sample(points, normals, RandomUnits(generator, kCount * 4));
    const double area = 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
    std::size_t numValid = 0;
    std::size_t numSubtended = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        const LightSampleResult& r = results[i];
        if (!r.isValid) {
            continue; // the point lies in the triangle's plane, within its error
        }
        ++numValid;
        const glm::dvec3 from(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
        const double side = glm::dot(n, from - p[0]);
        const double endSide = glm::dot(n, from + r.direction * r.distance - p[0]);
        ASSERT_GT(endSide * side, 0.0) << "the shadow ray crosses its light";
        const double cosine = std::abs(glm::dot(n, r.direction));
        const double solidAngle = SolidAngle(p[0] - from, p[1] - from, p[2] - from);
        const double expected =
            solidAngle > 0.01 ? 1.0 / solidAngle : r.distance * r.distance / (area * cosine);
        ASSERT_NEAR(r.pdf, expected, 2e-2 * r.pdf + 1e-6);
        numSubtended += solidAngle > 0.01 ? 1 : 0;
    }
    EXPECT_GT(numValid, kCount * 9 / 10);
    EXPECT_GT(numSubtended, kCount / 4);
}

TEST_F(LightTest, SelectionIsAProbabilityThatMatchesItsChoices) {
    std::mt19937 generator(44);
    for (const std::size_t numLights : {std::size_t(7), std::size_t(50), std::size_t(300)}) {
        std::vector<PlacedLight> lights;
        for (std::size_t i = 0; i < numLights; ++i) {
            PlacedLight light = MakeLight(kShapes[i % 4]);
            light.light.intensity = float(i + 1);
            light.worldFromLight = RandomTransform(generator, false);
            lights.push_back(light);
        }
        lights.back() = MakeLight(LightType::Distant);
        lights.back().light.intensity = 100.0F;
        SetLights(lights);
        const glm::dvec3 point(0.3, 0.2, -0.4);
        const glm::dvec3 normal(0.0); // with a normal a descent may end without a light
        std::vector<float> points;
        std::vector<float> normals;
        constexpr std::size_t kCount = 200000;
        for (std::size_t i = 0; i < kCount; ++i) {
            Append(points, point);
            Append(normals, normal);
        }
        const std::vector<float> pmf =
            Selections({points[0], points[1], points[2]}, {normals[0], normals[1], normals[2]});
        double sum = 0.0;
        for (const float p : pmf) {
            sum += p;
        }
        // A descent ends without a light where a node's bound promised what no light of it keeps
        // (flat lights that face away): that mass is missing, and only in the tree.
        EXPECT_NEAR(sum, 1.0, numLights > 32 ? 0.05 : 1e-5);
        EXPECT_LT(sum, 1.0 + 1e-5);
        std::vector<double> chosen(numLights, 0.0);
        double none = 0.0;
        for (const LightSampleResult& r :
             Sample(points, normals, RandomUnits(generator, kCount * 4))) {
            (r.light == HDS_NONE ? none : chosen[r.light]) += 1.0;
        }
        const double lost = (1.0 - sum) * kCount;
        EXPECT_NEAR(none, lost, 5.0 * std::sqrt(std::max(lost, 0.0)) + 3.0);
        for (std::size_t i = 0; i < numLights; ++i) {
            const double expected = double(pmf[i]) * kCount;
            EXPECT_NEAR(chosen[i], expected, 5.0 * std::sqrt(expected) + 1.0) << "light " << i;
        }
    }
}

TEST_F(LightTest, ManyLightsAreChosenByWhatTheyContribute) {
    // A street of 1000 equal spheres: the nearest is worth most, whatever its power's share.
    std::vector<PlacedLight> lights;
    for (int i = 0; i < 1000; ++i) {
        PlacedLight light = MakeLight(LightType::Sphere);
        light.light.radius = 0.05F;
        light.worldFromLight = glm::translate(glm::dmat4(1.0), {double(i), 0.0, 0.0});
        lights.push_back(light);
    }
    const LightTable table = SetLights(lights);
    for (const int nearest : {0, 333, 999}) {
        const std::vector<float> pmf =
            Selections({float(nearest), 0.0F, 1.0F}, {0.0F, 0.0F, -1.0F});
        double sum = 0.0;
        for (const float p : pmf) {
            sum += p;
        }
        EXPECT_NEAR(sum, 1.0, 1e-4);
        // Irradiance of light i is in proportion to 1 / (1 + i^2)^(3/2); its share of all is about
        // one half: the cut through the tree is fine where the lights are near.
        EXPECT_GT(pmf[std::size_t(nearest)], 0.4) << nearest;
    }
}

/// Over a hall: lamps at random below a ceiling of panels, and panels that stand back to back.
std::vector<PlacedLight> HallOfLights(std::size_t count) {
    std::mt19937 generator(47);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<PlacedLight> lights;
    for (std::size_t i = 0; i < count; ++i) {
        const bool isLamp = i % 3 == 0;
        PlacedLight light = MakeLight(isLamp ? LightType::Sphere : LightType::Rect);
        light.light.radius = 0.01F;
        light.light.width = light.light.height = 0.02F;
        light.light.intensity = float(1U << (2U * (i % 4)));
        const double x = 10.0 * unit(generator);
        const double y = 10.0 * unit(generator);
        const double high = 2.5 + 2.5 * unit(generator);
        // Rects emit towards -z: as they are from the ceiling, or turned to the side.
        const double turn = i % 6 < 3 ? 0.5 * kPi : -0.5 * kPi;
        light.worldFromLight =
            i % 3 == 1
                ? glm::translate(glm::dmat4(1.0), {x, y, 6.0})
                : glm::rotate(glm::translate(glm::dmat4(1.0),
                                             {isLamp ? x : (turn > 0.0 ? -5.0 : 5.0), y, high}),
                              turn, glm::dvec3(0.0, 1.0, 0.0));
        lights.push_back(light);
    }
    return lights;
}

/// What a small light sends to a point, by its own formula: strength cos cos / d^2.
double Contribution(const PlacedLight& light, const glm::dvec3& point, const glm::dvec3& normal) {
    const glm::dvec3 to = glm::dvec3(light.worldFromLight[3]) - point;
    const double squared = glm::dot(to, to);
    const glm::dvec3 direction = to / std::sqrt(squared);
    const double isLamp = light.light.type == LightType::Sphere ? 1.0 : 0.0;
    const double size = isLamp > 0.0 ? kPi * light.light.radius * light.light.radius
                                     : double(light.light.width) * light.light.height;
    const double facing = glm::dot(glm::normalize(glm::dvec3(light.worldFromLight[2])), direction);
    return light.light.intensity * size * std::max(glm::dot(normal, direction), 0.0) *
           (isLamp > 0.0 ? 1.0 : std::max(facing, 0.0)) / squared;
}

/// The relative variance of one sample without shadows, which is 0 where lights are chosen in
/// proportion to what they contribute, does not grow with their number.
TEST_F(LightTest, TheNoiseOfManyLightsDoesNotGrowWithTheirNumber) {
    for (const std::size_t count : {std::size_t(60), std::size_t(400), std::size_t(2000)}) {
        const std::vector<PlacedLight> lights = HallOfLights(count);
        SetLights(lights);
        std::mt19937 generator(48);
        std::uniform_real_distribution<double> unit(-8.0, 8.0);
        double variance = 0.0;
        constexpr int kPoints = 20;
        for (int k = 0; k < kPoints; ++k) {
            const glm::dvec3 point(unit(generator), unit(generator), 0.0);
            std::vector<float> points;
            std::vector<float> normals;
            Append(points, point);
            Append(normals, {0.0, 0.0, 1.0});
            const std::vector<float> pmf = Selections(points, normals);
            double sum = 0.0;
            double second = 0.0;
            for (std::size_t i = 0; i < count; ++i) {
                const double value = Contribution(lights[i], point, {0.0, 0.0, 1.0});
                sum += value;
                second += value > 0.0 ? value * value / double(pmf[i]) : 0.0;
            }
            variance += (second / (sum * sum) - 1.0) / kPoints;
        }
        EXPECT_LT(variance, 0.4) << count << " lights";
    }
}

/// Numbers in ascending order choose lights in the order of the tree, so that numbers that are well
/// spread choose lights that are well spread.
TEST_F(LightTest, ManyLightsAreChosenInTheOrderOfTheTree) {
    const LightTable table = SetLights(HallOfLights(500));
    constexpr std::size_t kCount = 4000;
    std::vector<float> points;
    std::vector<float> normals;
    std::vector<float> us;
    for (std::size_t i = 0; i < kCount; ++i) {
        Append(points, {0.5, 1.0, 0.0});
        Append(normals, {0.0, 0.0, 1.0});
        us.insert(us.end(), {(float(i) + 0.5F) / kCount, 0.0F, 0.5F, 0.5F});
    }
    // The slots from the root down to the light.
    const auto place = [&](std::uint32_t light) {
        std::vector<std::uint32_t> slots;
        for (std::uint32_t p = table.lights[light].treePlace; p != HDS_NONE;
             p = table.nodes[p / 8].place) {
            slots.insert(slots.begin(), p % 8);
        }
        return slots;
    };
    std::vector<std::uint32_t> last;
    std::size_t numChanges = 0;
    for (const LightSampleResult& result : Sample(points, normals, us)) {
        if (result.light != HDS_NONE) {
            ASSERT_GE(place(result.light), last);
            numChanges += place(result.light) > last ? 1 : 0;
            last = place(result.light);
        }
    }
    EXPECT_GT(numChanges, 50U);
}

TEST_F(LightTest, WalksMeetTheLightsThatRaysCross) {
    std::mt19937 generator(45);
    for (const std::size_t numLights : {std::size_t(20), std::size_t(33), std::size_t(700)}) {
        std::vector<PlacedLight> lights;
        for (std::size_t i = 0; i < numLights; ++i) {
            lights.push_back(MakeLight(kShapes[i % 4]));
            lights.back().worldFromLight = RandomTransform(generator, false);
        }
        lights[5] = MakeLight(LightType::Dome);
        SetLights(lights);
        constexpr std::size_t kCount = 20000;
        const std::vector<float> units = RandomUnits(generator, kCount * 6);
        std::vector<float> points;
        std::vector<float> directions;
        for (std::size_t i = 0; i < kCount; ++i) {
            const float* u = &units[6 * i];
            Append(points, glm::dvec3(u[0], u[1], u[2]) * 8.0 - 4.0);
            Append(directions, glm::normalize(glm::dvec3(u[3], u[4], u[5]) - 0.5));
        }
        std::size_t numMet = 0;
        for (const float tMax : {1.5F, HDS_LIGHT_FAR}) {
            const std::vector<std::uint32_t> found = Meetings(points, directions, tMax);
            for (std::size_t i = 0; i < kCount; ++i) {
                const std::uint32_t* f = &found[4 * i];
                ASSERT_EQ(f[0], f[2]) << "ray " << i;
                ASSERT_EQ(f[1], f[3]) << "ray " << i;
                numMet += f[0];
            }
        }
        EXPECT_GT(numMet, kCount);
    }
}

/// Beside another light, which is there for the choice: wherever a ray finds a shaped light
/// shining, light samples may choose it.
TEST_F(LightTest, EstimatesOfShapedLightsAreNeverZeroWhereTheyShine) {
    std::mt19937 generator(46);
    for (std::size_t i = 0; i < 24; ++i) {
        PlacedLight light = MakeLight(kShapes[i % 4]);
        const std::vector<float> units = RandomUnits(generator, 4);
        light.light.shaping.coneAngle = i % 3 == 0 ? 180.0F : 5.0F + 90.0F * units[0];
        light.light.shaping.coneSoftness = i % 2 == 0 ? 0.0F : units[1];
        light.light.shaping.focus = i % 3 == 1 ? 0.0F : 40.0F * units[2];
        light.worldFromLight = RandomTransform(generator, false);
        PlacedLight other = MakeLight(LightType::Sphere);
        other.worldFromLight = glm::translate(glm::dmat4(1.0), {0.0, 0.0, 1e4});
        SetLights({light, other});
        constexpr std::size_t kCount = 20000;
        const std::vector<float> places = RandomUnits(generator, kCount * 6);
        std::vector<float> points;
        std::vector<float> normals;
        std::vector<float> directions;
        const glm::dvec3 center(light.worldFromLight[3]);
        for (std::size_t k = 0; k < kCount; ++k) {
            const float* u = &places[6 * k];
            const glm::dvec3 point = center + (glm::dvec3(u[0], u[1], u[2]) - 0.5) * 8.0;
            const glm::dvec3 target = center + glm::dvec3(u[3], u[4], u[5]) - 0.5;
            Append(points, point);
            Append(normals, glm::dvec3(0.0));
            Append(directions, glm::normalize(target - point));
        }
        const std::vector<float> found = Intersect(0, points, normals, directions);
        std::size_t numShining = 0;
        for (std::size_t k = 0; k < kCount; ++k) {
            if (found[3 * k] >= 0.0F && found[3 * k + 2] > 0.0F) {
                ++numShining;
                ASSERT_GT(found[3 * k + 1], 0.0F) << "light " << i << ", ray " << k;
            }
        }
        EXPECT_GT(numShining, 0U) << i;
    }
}

TEST_F(LightTest, ChancesAddUpToAtMostOneNearTheHorizon) {
    // Spheres of very different power near the horizon of points above them: estimates go down to
    // zero, and a light must not be looked into as if it were a node.
    std::vector<PlacedLight> lights;
    std::mt19937 generator(3);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int i = 0; i < 60; ++i) {
        PlacedLight light = MakeLight(LightType::Sphere);
        light.light.radius = 1e-3F;
        light.light.exposure = static_cast<float>(20.0 * unit(generator));
        light.worldFromLight = glm::translate(
            glm::dmat4(1.0), {unit(generator), unit(generator), unit(generator) - 1.0});
        lights.push_back(light);
    }
    SetLights(lights);
    for (int i = 0; i < 200; ++i) {
        const auto height = static_cast<float>(0.5 * unit(generator) + 0.4);
        const std::vector<float> pmf =
            Selections({static_cast<float>(unit(generator)), 0.0F, height}, {0.0F, 0.0F, 1.0F});
        double sum = 0.0;
        for (const float p : pmf) {
            ASSERT_GE(p, 0.0F);
            sum += p;
        }
        EXPECT_LE(sum, 1.001) << i;
    }
}

/// Flat meshes that emit on both sides, more than are weighed one by one, in a plane: points on
/// either side see all of them, and nothing of those beside whose edges they are.
TEST_F(LightTest, MeshesThatEmitOnBothSidesAreChosenFromBoth) {
    constexpr std::size_t kCount = 60;
    std::vector<EmissiveMesh> meshes(kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
        const glm::dvec3 corner(double(i % 10), double(i / 10), 0.0);
        meshes[i].twoSided = true;
        meshes[i].triangles.push_back(
            {{corner, corner + glm::dvec3(0.5, 0, 0), corner + glm::dvec3(0, 0.5, 0)}, 0});
    }
    Warnings warnings;
    const LightTable table = BuildLightTable({}, meshes, {}, warnings);
    ASSERT_EQ(table.lights.size(), kCount);
    SetTable(table);
    for (const float height : {3.0F, -3.0F}) {
        const std::vector<float> pmf = Selections({4.0F, 3.0F, height}, {0, 0, 0});
        double variance = -1.0;
        double sum = 0.0;
        std::vector<double> values;
        for (std::size_t i = 0; i < kCount; ++i) {
            ASSERT_GT(pmf[i], 0.0F) << "light " << i << " from " << height;
            const double x = double(i % 10) + 1.0 / 6 - 4.0;
            const double y = double(i / 10) + 1.0 / 6 - 3.0;
            const double squared = x * x + y * y + 9.0;
            values.push_back(3.0 / (squared * std::sqrt(squared))); // cosine / distance^2
            sum += values.back();
        }
        for (std::size_t i = 0; i < kCount; ++i) {
            variance += values[i] * values[i] / (sum * sum * double(pmf[i]));
        }
        EXPECT_LT(variance, 0.05) << "from " << height;
    }
}

TEST_F(LightTest, SelectionIsZeroOnlyWhereNoLightArrives) {
    PlacedLight rect = MakeLight(LightType::Rect); // emits towards -z
    PlacedLight sphere = MakeLight(LightType::Sphere);
    sphere.worldFromLight = glm::translate(glm::dmat4(1.0), {0.0, 0.0, 5.0});
    SetLights({rect, sphere});
    const std::vector<float> behind = Selections({0, 0, 1}, {0, 0, 1});
    EXPECT_EQ(behind[0], 0.0F); // behind the rect
    EXPECT_EQ(behind[1], 1.0F);
    const std::vector<float> below = Selections({0, 0, 1}, {0, 0, -1});
    EXPECT_EQ(below[1], 0.0F); // the sphere is under the horizon
    // A sphere whose centre is below the horizon, but not all of it.
    const std::vector<float> edge = Selections({0, 0, 4.2F}, {0.96F, 0, -0.28F});
    EXPECT_GT(edge[1], 0.0F);
}

} // namespace
} // namespace hds::test
