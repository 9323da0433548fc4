// SPDX-License-Identifier: Apache-2.0
// Rays meet round curves and points where the union of their balls begins and ends: against dense
// sampling in double precision, with bases of its own; and every path to a hit gives the same bits.
#include "hdStream/geometry/curveSource.h"
#include "hdStream/geometry/pointSource.h"
#include "testenv/device/accel/traversalProbe.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hds::test {
namespace {

using Hits = std::vector<shared::HdsHit>;
using Cubic = std::array<glm::dvec4, 4>; ///< position and radius by powers of u

std::size_t CountDifferentBits(const Hits& a, const Hits& b) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        count += std::memcmp(&a[i], &b[i], sizeof(a[i])) != 0 ? 1 : 0;
    }
    return count;
}

/// One curve of a basis, or points, with a width a point.
struct Solid {
    std::string basis; ///< linear, bezier, bspline, catmullRom, points
    std::vector<glm::vec4> points;

    std::shared_ptr<GeometryDescription> Describe() const {
        auto description = std::make_shared<GeometryDescription>();
        description->primitives = basis == "points" ? PrimitiveKind::Points : PrimitiveKind::Curves;
        std::vector<float> positions;
        std::vector<float> widths;
        for (const glm::vec4& point : points) {
            positions.insert(positions.end(), {point.x, point.y, point.z});
            widths.push_back(2.0F * point.w);
        }
        description->points = std::move(positions);
        description->faceVertexCounts =
            std::vector<std::int32_t>{static_cast<std::int32_t>(points.size())};
        description->curves =
            CurveForm{basis == "linear" ? "linear" : "cubic", basis, "nonperiodic"};
        Primvar primvar;
        primvar.name = "widths";
        primvar.interpolation = Interpolation::Vertex;
        primvar.values = std::move(widths);
        description->primvars.push_back(std::move(primvar));
        return description;
    }

    /// The textbook's matrices, by powers.
    std::vector<Cubic> Cubics() const {
        std::vector<Cubic> cubics;
        const auto at = [this](std::size_t i) { return glm::dvec4(points[i]); };
        if (basis == "points" || basis == "linear") {
            const std::size_t reach = basis == "linear" ? 1 : 0;
            for (std::size_t i = 0; i + reach < points.size(); ++i) {
                cubics.push_back({at(i), at(i + reach) - at(i), glm::dvec4(0.0), glm::dvec4(0.0)});
            }
            return cubics;
        }
        const std::size_t step = basis == "bezier" ? 3 : 1;
        for (std::size_t i = 0; i + 3 < points.size(); i += step) {
            const glm::dvec4 a = at(i);
            const glm::dvec4 b = at(i + 1);
            const glm::dvec4 c = at(i + 2);
            const glm::dvec4 d = at(i + 3);
            if (basis == "bezier") {
                cubics.push_back(
                    {a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - 3.0 * c + 3.0 * b - a});
            } else if (basis == "bspline") {
                cubics.push_back({(a + 4.0 * b + c) / 6.0, (c - a) / 2.0, (a - 2.0 * b + c) / 2.0,
                                  (d - 3.0 * c + 3.0 * b - a) / 6.0});
            } else {
                cubics.push_back({b, (c - a) / 2.0, (2.0 * a - 5.0 * b + 4.0 * c - d) / 2.0,
                                  (d - 3.0 * c + 3.0 * b - a) / 2.0});
            }
        }
        return cubics;
    }
};

/// Where a ray is inside a solid, and by how much a slightly different ray would not be.
struct Crossing {
    double begin, end;
};

/// Intervals of t inside the union of the balls, merged, in order.
std::vector<Crossing> HostCrossings(const std::vector<Cubic>& cubics, const glm::dvec3& origin,
                                    const glm::dvec3& direction) {
    constexpr int kSteps = 2000;
    const double length = glm::length(direction);
    const glm::dvec3 unit = direction / length;
    std::vector<Crossing> crossings;
    for (const Cubic& cubic : cubics) {
        for (int i = 0; i <= kSteps; ++i) {
            const double u = double(i) / kSteps;
            const glm::dvec4 ball = cubic[0] + u * (cubic[1] + u * (cubic[2] + u * cubic[3]));
            const glm::dvec3 offset = glm::dvec3(ball) - origin;
            const double z = glm::dot(offset, unit);
            const glm::dvec3 across = offset - z * unit;
            const double squared = ball.w * ball.w - glm::dot(across, across);
            if (squared >= 0.0) {
                const double half = std::sqrt(squared);
                crossings.push_back({(z - half) / length, (z + half) / length});
            }
        }
    }
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& a, const Crossing& b) { return a.begin < b.begin; });
    std::vector<Crossing> merged;
    for (const Crossing& one : crossings) {
        if (merged.empty() || one.begin > merged.back().end) {
            merged.push_back(one);
        }
        merged.back().end = std::max(merged.back().end, one.end);
    }
    return merged;
}

std::vector<glm::vec4> RandomWalk(std::uint32_t seed, std::size_t count, float radius) {
    UniformSource uniform(seed);
    std::vector<glm::vec4> points;
    glm::vec3 position = 0.5F * uniform.Vector();
    glm::vec3 direction = uniform.Vector();
    for (std::size_t i = 0; i < count; ++i) {
        points.emplace_back(position, radius * (1.2F + 0.8F * uniform()));
        direction = glm::normalize(direction + 0.5F * uniform.Vector());
        position += 0.4F * direction;
    }
    return points;
}

/// The points of a random walk, each as often as told.
std::vector<glm::vec4> Repeated(std::uint32_t seed, const std::vector<int>& times, float radius) {
    const std::vector<glm::vec4> walk = RandomWalk(seed, times.size(), radius);
    std::vector<glm::vec4> points;
    for (std::size_t i = 0; i < times.size(); ++i) {
        points.insert(points.end(), static_cast<std::size_t>(times[i]), walk[i]);
    }
    return points;
}

/// Of curves whose derivative is 0 at joints and ends: points repeated, handles on their points.
/// They are thin, since tubes that turn sharply have walls inside themselves.
std::vector<Solid> StandingSolids() {
    return {{"linear", Repeated(11, {2, 1, 2, 4, 1, 3}, 0.02F)},
            {"bezier", Repeated(12, {2, 3, 3, 3, 2}, 0.02F)},
            {"bezier", Repeated(13, {1, 1, 1, 9, 1, 1, 1, 1, 1, 5}, 0.02F)},
            {"bezier", Repeated(16, {2, 1, 2, 2, 1, 2}, 0.02F)},
            {"bspline", Repeated(14, {3, 1, 1, 3, 1, 1, 3}, 0.02F)},
            {"bspline", Repeated(15, {4, 1, 1, 6, 1, 4}, 0.02F)}};
}

struct SolidScene {
    std::vector<Solid> solids;
    std::vector<glm::dmat4> matrices;
    AccelScene scene;

    explicit SolidScene(std::vector<Solid> given = {{"linear", RandomWalk(1, 6, 0.05F)},
                                                    {"bezier", RandomWalk(2, 7, 0.04F)},
                                                    {"bspline", RandomWalk(3, 9, 0.06F)},
                                                    {"catmullRom", RandomWalk(4, 8, 0.01F)},
                                                    {"points", RandomWalk(5, 20, 0.1F)}})
        : solids(std::move(given)) {
        UniformSource uniform(17);
        Warnings warnings;
        std::vector<AccelPlacement> placements;
        for (const Solid& solid : solids) {
            const auto source = solid.basis == "points"
                                    ? MakePointSource(solid.Describe(), "/p", warnings)
                                    : MakeCurveSource(solid.Describe(), "/c", warnings);
            const std::uint32_t object = scene.AddSource(*source, 6);
            glm::dmat4 matrix(1.0);
            for (int column = 0; column < 3; ++column) {
                matrix[column] += 0.3 * glm::dvec4(uniform(), uniform(), uniform(), 0.0);
            }
            matrix[3] = glm::dvec4(0.7 * glm::dvec3(uniform.Vector()), 1.0);
            matrices.push_back(matrix);
            placements.push_back({object, matrix, HDS_INSTANCE_SEEN | HDS_INSTANCE_CUTOUT});
        }
        scene.SetRoot(placements);
        EXPECT_TRUE(warnings.Lines().empty());
    }

    std::vector<Crossing> Crossings(std::size_t solid, const ProbeRay& ray) const {
        const glm::dmat4 inverse = glm::inverse(matrices[solid]);
        const glm::dvec3 origin(inverse *
                                glm::dvec4(ray.origin[0], ray.origin[1], ray.origin[2], 1.0));
        const glm::dvec3 direction(
            inverse * glm::dvec4(ray.direction[0], ray.direction[1], ray.direction[2], 0.0));
        return HostCrossings(solids[solid].Cubics(), origin, direction);
    }
};

/// From around the scene, aimed at places on the solids or a little beside them; some along an
/// axis.
std::vector<ProbeRay> AimedRays(const SolidScene& scene, std::size_t count) {
    UniformSource uniform(23);
    std::vector<ProbeRay> rays;
    while (rays.size() < count) {
        const std::size_t s = rays.size() % scene.solids.size();
        const std::vector<Cubic> cubics = scene.solids[s].Cubics();
        const auto pick =
            static_cast<std::size_t>((uniform() * 0.5F + 0.5F) * static_cast<float>(cubics.size()));
        const double u = 0.5 * double(uniform()) + 0.5;
        const Cubic& cubic = cubics[pick];
        const glm::dvec4 ball = cubic[0] + u * (cubic[1] + u * (cubic[2] + u * cubic[3]));
        const glm::dvec3 place = glm::dvec3(ball) + ball.w * glm::dvec3(uniform.Vector());
        const glm::vec3 target(scene.matrices[s] * glm::dvec4(place, 1.0));
        glm::vec3 origin = 8.0F * glm::normalize(uniform.Vector());
        if (rays.size() % 9 == 4) {
            origin = target + glm::vec3(0.0F, 0.0F, origin.z > 0.0F ? 8.0F : -8.0F);
        }
        rays.push_back(
            MakeProbeRay(origin, (target - origin) * (rays.size() % 3 == 0 ? 0.01F : 1.0F)));
    }
    return rays;
}

/// Hits of all rays, one after the other, against the crossings that the host finds. \param scene
/// of `solid`. \param mostInside part of the rays that may meet borders inside, where tubes
/// overlap.
void ExpectBorders(const TraversalProbe& probe, const DeviceAccelScene& scene,
                   const SolidScene& solid, const std::vector<ProbeRay>& rays, double mostInside) {
    // Hits of a ray one after the other.
    std::vector<ProbeKey> after(rays.size());
    std::vector<std::vector<std::vector<double>>> found(
        rays.size(), std::vector<std::vector<double>>(solid.solids.size()));
    bool isAny = true;
    for (int pass = 0; pass < 60 && isAny; ++pass) {
        const Hits hits = probe.Closest(scene, rays, 0, after);
        isAny = false;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!IsHit(hits[i])) {
                continue;
            }
            isAny = true;
            found[i][PathOf(hits[i])].push_back(hits[i].t);
            std::memcpy(&after[i].word[0], &hits[i].t, 4);
            after[i].word[1] = hits[i].pathIndex[0];
            after[i].word[2] = hits[i].pathIndex[1];
            after[i].word[3] =
                PageView(solid.scene.pages[hits[i].chunk].bytes.data()).primIds[hits[i].triangle];
        }
    }
    EXPECT_FALSE(isAny) << "hits without end";
    std::size_t numJudged = 0;
    std::size_t numInside = 0;
    std::size_t numGrazing = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const double reach =
            10.0 / glm::length(
                       glm::vec3(rays[i].direction[0], rays[i].direction[1], rays[i].direction[2]));
        for (std::size_t s = 0; s < solid.solids.size(); ++s) {
            if (solid.solids[s].basis == "points") {
                continue; // overlapping balls have borders inside others
            }
            const std::vector<Crossing> crossings = solid.Crossings(s, rays[i]);
            std::vector<double> expected;
            bool isGrazing = false;
            for (const Crossing& crossing : crossings) {
                isGrazing = isGrazing || crossing.end - crossing.begin < 1e-3 * reach;
                expected.push_back(crossing.begin);
                expected.push_back(crossing.end);
            }
            if (isGrazing || (expected.empty() && found[i][s].size() == 2 &&
                              found[i][s][1] - found[i][s][0] < 1e-3 * reach)) {
                ++numGrazing;
                continue;
            }
            // A tube that bends more sharply than it is simd8 has borders inside.
            const std::vector<double>& hits = found[i][s];
            if (hits.size() > expected.size()) {
                ++numInside;
                continue;
            }
            ASSERT_EQ(hits.size(), expected.size()) << "ray " << i << ", " << solid.solids[s].basis;
            for (std::size_t k = 0; k < hits.size(); ++k) {
                EXPECT_NEAR(hits[k], expected[k], 1e-5 * reach)
                    << "ray " << i << ", " << s << " " << solid.solids[s].basis << ", hit " << k;
            }
            numJudged += hits.empty() ? 0 : 1;
        }
    }
    testing::Test::RecordProperty("judged", static_cast<int>(numJudged));
    EXPECT_GT(numJudged, rays.size() / 2);
    EXPECT_LT(static_cast<double>(numInside), mostInside * static_cast<double>(numJudged));
    EXPECT_LT(numGrazing, numJudged / 10);
}

/// The programs take longer to build than to run: one of each form.
class Curves : public DeviceFixture {
protected:
    const TraversalProbe& Probe(bool simd8) {
        std::unique_ptr<TraversalProbe>& probe = simd8 ? _simd8 : _scalar;
        if (!probe) {
            probe = std::make_unique<TraversalProbe>(device, simd8,
                                                     ProgramDefines{{"HDS_FEATURE_CURVES", "1"}});
        }
        return *probe;
    }
    static void TearDownTestSuite() {
        _simd8.reset();
        _scalar.reset();
    }

private:
    static std::unique_ptr<TraversalProbe> _simd8;
    static std::unique_ptr<TraversalProbe> _scalar;
};

std::unique_ptr<TraversalProbe> Curves::_simd8;
std::unique_ptr<TraversalProbe> Curves::_scalar;

TEST_F(Curves, AllPathsToAHitGiveTheSameBits) {
    const SolidScene solid;
    const DeviceAccelScene scene(device, solid.scene);
    const std::vector<ProbeRay> rays = AimedRays(solid, 3000);
    const TraversalProbe& scalar = Probe(false);
    const TraversalProbe& simd8 = Probe(true);
    const Hits expected = scalar.BruteForce(scene, rays);
    EXPECT_EQ(CountDifferentBits(scalar.Closest(scene, rays), expected), 0U);
    EXPECT_EQ(CountDifferentBits(simd8.Closest(scene, rays), expected), 0U);
    EXPECT_EQ(CountDifferentBits(simd8.BruteForce(scene, rays), expected), 0U);
}

TEST_F(Curves, EveryHitIsABorderOfTheUnionOfBalls) {
    const SolidScene solid;
    const DeviceAccelScene scene(device, solid.scene);
    ExpectBorders(Probe(true), scene, solid, AimedRays(solid, 700), 1.0 / 40);
}

TEST_F(Curves, CurvesThatStandStillHaveTheBordersOfTheirBalls) {
    const SolidScene solid(StandingSolids());
    const DeviceAccelScene scene(device, solid.scene);
    const std::vector<ProbeRay> rays = AimedRays(solid, 1400);
    ExpectBorders(Probe(true), scene, solid, rays, 1.0 / 20); // all their joints are corners
    const Hits expected = Probe(false).BruteForce(scene, rays);
    EXPECT_EQ(CountDifferentBits(Probe(true).Closest(scene, rays), expected), 0U);
}

TEST_F(Curves, PointsAreSpheres) {
    const SolidScene solid;
    const DeviceAccelScene scene(device, solid.scene);
    const std::vector<ProbeRay> rays = AimedRays(solid, 700);
    const Hits hits = Probe(true).Closest(scene, rays);
    std::size_t numPoints = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        double nearest = INFINITY;
        double margin = INFINITY;
        for (std::size_t s = 0; s < solid.solids.size(); ++s) {
            for (const Crossing& crossing : solid.Crossings(s, rays[i])) {
                margin = crossing.begin < nearest ? crossing.end - crossing.begin : margin;
                nearest = std::min(nearest, crossing.begin);
            }
        }
        const double reach =
            10.0 / glm::length(
                       glm::vec3(rays[i].direction[0], rays[i].direction[1], rays[i].direction[2]));
        if (margin < 1e-3 * reach) {
            continue;
        }
        ASSERT_EQ(IsHit(hits[i]), nearest < INFINITY) << "ray " << i;
        if (IsHit(hits[i])) {
            EXPECT_NEAR(hits[i].t, nearest, 1e-5 * reach) << "ray " << i;
            numPoints += PathOf(hits[i]) == 4 ? 1 : 0;
        }
    }
    EXPECT_GT(numPoints, 50U);
}

TEST_F(Curves, ShadowRaysSeeWhatOthersSee) {
    const SolidScene solid;
    AccelScene opaque = solid.scene;
    for (shared::HdsInstance& instance : opaque.instances) {
        instance.flags = HDS_INSTANCE_SEEN;
    }
    const DeviceAccelScene scene(device, opaque);
    const std::vector<ProbeRay> rays = AimedRays(solid, 2000);
    const TraversalProbe& probe = Probe(true);
    const Hits hits = probe.Closest(scene, rays);
    const Hits blocked = probe.Occluded(scene, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(blocked[i].triangle == kBlocked, IsHit(hits[i])) << "ray " << i;
    }
}

} // namespace
} // namespace hds::test
