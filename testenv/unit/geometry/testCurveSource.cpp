// SPDX-License-Identifier: Apache-2.0
// Curves and points become the primitives that UsdGeomBasisCurves says: counts of every type, basis
// and wrap; boxes that hold all balls; values of primvars; one line for bad content.
#include "hdStream/accel/bvh.h"
#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/curveSource.h"
#include "hdStream/geometry/pointSource.h"
#include "kernels/shared/geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>

namespace hds::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Primvar MakePrimvar(const std::string& name, Interpolation interpolation, std::vector<float> values,
                    std::uint32_t numComponents = 1) {
    Primvar primvar;
    primvar.name = name;
    primvar.interpolation = interpolation;
    primvar.numComponents = numComponents;
    primvar.values = std::move(values);
    return primvar;
}

/// Curves of so many vertices each, their points random and within a factor 2 of each other.
GeometryDescription MakeCurves(const std::vector<std::int32_t>& counts, const CurveForm& form,
                               std::uint32_t seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> coordinate(-1.0F, 1.0F);
    std::size_t total = 0;
    for (const std::int32_t count : counts) {
        total += static_cast<std::size_t>(std::max(count, 0));
    }
    std::vector<float> points(3 * total);
    std::generate(points.begin(), points.end(), [&] { return coordinate(random); });
    GeometryDescription curves;
    curves.primitives = PrimitiveKind::Curves;
    curves.points = std::move(points);
    curves.faceVertexCounts = counts;
    curves.curves = form;
    curves.primvars.push_back(MakePrimvar("widths", Interpolation::Constant, {0.02F}));
    return curves;
}

struct Gathered {
    std::shared_ptr<const ChunkSource> source;
    ChunkGeometry all;
    std::vector<std::string> lines;
};

Gathered GatherAll(const GeometryDescription& description) {
    Warnings warnings;
    Gathered run;
    auto shared = std::make_shared<GeometryDescription>(description);
    run.source = description.primitives == PrimitiveKind::Curves
                     ? MakeCurveSource(shared, "/c", warnings)
                     : MakePointSource(shared, "/c", warnings);
    std::vector<std::uint32_t> groups(run.source->NumPrimitiveGroups());
    std::iota(groups.begin(), groups.end(), 0U);
    run.all = run.source->Gather(groups.data(), groups.size());
    run.lines = warnings.Lines();
    return run;
}

/// Pieces of whole segments: those whose number is 0.
std::size_t NumSegments(const ChunkGeometry& chunk) {
    return static_cast<std::size_t>(
        std::count_if(chunk.triangles.begin(), chunk.triangles.end(),
                      [](const glm::uvec3& triangle) { return (triangle.y & 127U) == 0; }));
}

TEST(CurveSource, SegmentsAreThoseOfTheSchema) {
    const struct {
        CurveForm form;
        std::int32_t numVertices;
        std::size_t numSegments;
    } cases[] = {
        {{"linear", "", "nonperiodic"}, 5, 4},
        {{"linear", "", "periodic"}, 5, 5},
        {{"linear", "", "pinned"}, 5, 4},
        {{"cubic", "bezier", "nonperiodic"}, 7, 2},
        {{"cubic", "bezier", "periodic"}, 6, 2},
        {{"cubic", "bezier", "pinned"}, 7, 2},
        {{"cubic", "bspline", "nonperiodic"}, 7, 4},
        {{"cubic", "bspline", "periodic"}, 7, 7},
        {{"cubic", "bspline", "pinned"}, 7, 6},
        {{"cubic", "catmullRom", "nonperiodic"}, 7, 4},
        {{"cubic", "catmullRom", "periodic"}, 7, 7},
        {{"cubic", "catmullRom", "pinned"}, 7, 6},
        {{"linear", "", "segmented"}, 6, 3},
    };
    for (const auto& one : cases) {
        const Gathered run = GatherAll(MakeCurves({one.numVertices, one.numVertices}, one.form));
        EXPECT_EQ(NumSegments(run.all), 2 * one.numSegments) << one.form.basis << one.form.wrap;
        EXPECT_EQ(run.all.triangles.size(), run.source->NumTriangles());
        EXPECT_TRUE(run.lines.empty());
        const std::set<std::uint32_t> primIds(run.all.primIds.begin(), run.all.primIds.end());
        EXPECT_EQ(primIds.size(), run.all.primIds.size());
    }
}

TEST(CurveSource, AChunkDoesNotDependOnWhatWasGatheredBefore) {
    const GeometryDescription curves = MakeCurves({40, 5, 33}, {"cubic", "bspline", "pinned"});
    const Gathered run = GatherAll(curves);
    std::size_t first = 0;
    for (std::uint32_t group = 0; group < run.source->NumPrimitiveGroups(); ++group) {
        const ChunkGeometry one = run.source->Gather(&group, 1);
        ASSERT_EQ(one.triangles.size(), run.source->GroupTriangles(group));
        for (std::size_t i = 0; i < one.triangles.size(); ++i) {
            EXPECT_EQ(one.primIds[i], run.all.primIds[first + i]);
            const glm::vec3 here = one.positions[one.triangles[i].x];
            EXPECT_EQ(here, run.all.positions[run.all.triangles[first + i].x]);
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_GE(one.primitiveBounds[i].min[axis],
                          run.source->GroupBounds(group).min[axis] - 1e-6F);
                EXPECT_LE(one.primitiveBounds[i].max[axis],
                          run.source->GroupBounds(group).max[axis] + 1e-6F);
            }
        }
        first += one.triangles.size();
    }
}

TEST(CurveSource, BoxesHoldTheBalls) {
    for (const char* basis : {"linear", "bezier", "bspline", "catmullRom"}) {
        GeometryDescription curves = MakeCurves(
            {10, 7}, {std::string(basis) == "linear" ? "linear" : "cubic", basis, "nonperiodic"});
        std::vector<float> widths(17);
        std::iota(widths.begin(), widths.end(), 1.0F);
        curves.primvars[0] = MakePrimvar("widths", Interpolation::Vertex, widths);
        const Gathered run = GatherAll(curves);
        for (std::size_t i = 0; i < run.all.triangles.size(); ++i) {
            const glm::uvec3& piece = run.all.triangles[i];
            const double size = std::exp2(-double(piece.y >> 7U & 7U));
            for (int step = 0; step <= 10; ++step) {
                const double u = size * (double(piece.y & 127U) + step / 10.0);
                // Weights of the four vertices, from the textbook's matrices.
                double w[4] = {0.0, 1.0 - u, u, 0.0};
                if (std::string(basis) == "bezier") {
                    w[0] = (1 - u) * (1 - u) * (1 - u);
                    w[1] = 3 * u * (1 - u) * (1 - u);
                    w[2] = 3 * u * u * (1 - u);
                    w[3] = u * u * u;
                } else if (std::string(basis) == "bspline") {
                    w[0] = (1 - u) * (1 - u) * (1 - u) / 6;
                    w[1] = (3 * u * u * u - 6 * u * u + 4) / 6;
                    w[2] = (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6;
                    w[3] = u * u * u / 6;
                } else if (std::string(basis) == "catmullRom") {
                    w[0] = (-u + 2 * u * u - u * u * u) / 2;
                    w[1] = (2 - 5 * u * u + 3 * u * u * u) / 2;
                    w[2] = (u + 4 * u * u - 3 * u * u * u) / 2;
                    w[3] = (-u * u + u * u * u) / 2;
                }
                glm::dvec3 centre(0.0);
                double radius = 0.0;
                for (std::uint32_t k = 0; k < 4; ++k) {
                    centre += w[k] * glm::dvec3(run.all.positions[piece.x + k]);
                    radius += w[k] * double(run.all.radii[piece.x + k]);
                }
                for (int axis = 0; axis < 3; ++axis) {
                    EXPECT_LE(double(run.all.primitiveBounds[i].min[axis]),
                              centre[axis] - std::abs(radius));
                    EXPECT_GE(double(run.all.primitiveBounds[i].max[axis]),
                              centre[axis] + std::abs(radius));
                }
            }
        }
    }
}

TEST(CurveSource, PhantomsOfPinnedCurvesHaveValues) {
    GeometryDescription curves = MakeCurves({3, 4}, {"cubic", "bspline", "pinned"});
    curves.primvars.push_back(MakePrimvar("a", Interpolation::Vertex, {1, 2, 4, 10, 20, 40, 80}));
    const Gathered run = GatherAll(curves);
    const GeometryAttribute& attribute = run.all.attributes.at(0);
    std::vector<float> values;
    for (const std::uint32_t point : run.all.points) {
        values.push_back(attribute.values[point]);
    }
    EXPECT_EQ(values, (std::vector<float>{0, 1, 2, 4, 6, 0, 10, 20, 40, 80, 120}));
    EXPECT_FALSE(BuildAttributePage(run.all).empty());
}

TEST(CurveSource, ClosedCurvesReturnToTheirFirstVertex) {
    const CurveForm closed{"cubic", "bezier", "periodic"};
    GeometryDescription curves =
        MakeCurves({8}, closed); // two vertices more than two segments need
    const Gathered run = GatherAll(curves);
    EXPECT_EQ(run.lines, std::vector<std::string>{"/c: 2 vertices after the last segment ignored"});
    curves.points = std::vector<float>(curves.points.begin(), curves.points.begin() + 18);
    curves.faceVertexCounts = std::vector<std::int32_t>{6};
    const Gathered fewer = GatherAll(curves);
    EXPECT_EQ(run.all.positions, fewer.all.positions);
    EXPECT_EQ(run.all.triangles, fewer.all.triangles);
}

/// Ends are round where a neighbour is not drawn, across the seam of a closed curve too.
TEST(CurveSource, ClosedCurvesEndBesideDroppedSegments) {
    GeometryDescription curves = MakeCurves({6}, {"linear", "", "periodic"});
    std::vector<float> points(curves.points.begin(), curves.points.end());
    points[0] = kNan; // of the first segment and of the last one
    curves.points = points;
    const Gathered run = GatherAll(curves);
    ASSERT_EQ(run.all.triangles.size(), 4U);
    constexpr std::uint32_t kStart = HDS_PIECE_START >> HDS_PIECE_SHIFT;
    constexpr std::uint32_t kEnd = HDS_PIECE_END >> HDS_PIECE_SHIFT;
    EXPECT_NE(run.all.triangles.front().y & kStart, 0U);
    EXPECT_NE(run.all.triangles.back().y & kEnd, 0U);
    points[0] = 0.0F;
    points[3] = kNan; // of the first two segments
    curves.points = points;
    EXPECT_NE(GatherAll(curves).all.triangles.back().y & kEnd, 0U) << "across the seam";
}

TEST(CurveSource, PairsHaveTheUniformValueOfTheirCurve) {
    GeometryDescription curves = MakeCurves({6, 4}, {"linear", "", "segmented"});
    curves.primvars.push_back(MakePrimvar("a", Interpolation::Uniform, {1, 2}));
    const Gathered run = GatherAll(curves);
    EXPECT_EQ(run.all.faces, (std::vector<std::uint32_t>{0, 0, 0, 1, 1}));
    EXPECT_TRUE(run.lines.empty());
}

TEST(CurveSource, BadContentIsOneLineEach) {
    const auto lineOf = [](GeometryDescription curves) { return GatherAll(curves).lines; };
    const CurveForm linear{"linear", "", "nonperiodic"};
    const CurveForm spline{"cubic", "bspline", "nonperiodic"};
    const auto expectOne = [&](const GeometryDescription& curves, const std::string& text) {
        const std::vector<std::string> lines = lineOf(curves);
        ASSERT_FALSE(lines.empty()) << text;
        EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
            return line == "/c: " + text;
        })) << lines[0];
    };
    GeometryDescription curves = MakeCurves({4, 1}, linear);
    expectOne(curves, "1 curves dropped: too few vertices for linear curves");
    expectOne(MakeCurves({3, 5}, spline), "1 curves dropped: too few vertices for bspline curves");
    expectOne(MakeCurves({6}, {"cubic", "bezier", "nonperiodic"}),
              "2 vertices after the last segment ignored");
    expectOne(MakeCurves({4}, {"quintic", "", "nonperiodic"}),
              "unknown curve type \"quintic\", drawn as linear");
    curves = MakeCurves({4, 4}, linear);
    curves.faceVertexCounts = std::vector<std::int32_t>{4, -2, 9};
    expectOne(curves, "2 curves dropped: curveVertexCounts negative or beyond the points");
    curves = MakeCurves({4, 4}, linear);
    std::vector<float> points(curves.points.begin(), curves.points.end());
    points[3] = kNan;
    curves.points = points;
    expectOne(curves, "2 segments dropped: points missing or not finite, or no width");
    curves = MakeCurves({4}, linear);
    curves.primvars[0] = MakePrimvar("widths", Interpolation::Vertex, {-1, kNan, 0, 0.1F});
    expectOne(curves, "2 widths are negative or not finite, read as 0");
    curves = MakeCurves({4}, spline);
    curves.faceVertexIndices = std::vector<std::int32_t>{0, 1, -7, 99};
    expectOne(curves, "1 segments dropped: points missing or not finite, or no width");
    // Hostile, and nothing to draw: no crash.
    for (const std::vector<std::int32_t>& counts :
         {std::vector<std::int32_t>{}, {0}, {-5}, {1, 1, 1}, {2147483647}}) {
        GeometryDescription hostile = MakeCurves({4}, spline);
        hostile.faceVertexCounts = counts;
        EXPECT_EQ(GatherAll(hostile).all.triangles.size(), 0U);
    }
    curves = MakeCurves({5}, spline);
    curves.points = std::vector<float>(15, 0.25F); // all in one place: a ball
    EXPECT_EQ(GatherAll(curves).all.triangles.size(), 1U);
}

/// Segments whose points are one lie in the balls of their neighbours, which know each other past
/// them; a curve of nothing else is one ball.
TEST(CurveSource, SegmentsThatStandStillArePassedOver) {
    constexpr std::uint32_t kStart = HDS_PIECE_START >> HDS_PIECE_SHIFT;
    constexpr std::uint32_t kEnd = HDS_PIECE_END >> HDS_PIECE_SHIFT;
    constexpr std::uint32_t kStands = HDS_PIECE_STANDS >> HDS_PIECE_SHIFT;
    GeometryDescription curves = MakeCurves({6}, {"linear", "", "nonperiodic"});
    curves.points = std::vector<float>{0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 2, 1, 0, 2, 1, 0};
    curves.primvars.push_back(
        MakePrimvar("a", Interpolation::Vertex, {10, 11, 12, 13, 14, 15})); // a jump at the joint
    Gathered run = GatherAll(curves);
    EXPECT_TRUE(run.lines.empty());
    EXPECT_EQ(run.source->NumTriangles(), 2U);
    ASSERT_EQ(run.all.triangles.size(), 2U);
    const glm::uvec3 first = run.all.triangles[0];
    const glm::uvec3 second = run.all.triangles[1];
    EXPECT_EQ(first.y & (kStart | kEnd | kStands), kStart | kStands);
    EXPECT_EQ(second.y & (kStart | kEnd | kStands), kEnd);
    const std::vector<glm::vec3>& at = run.all.positions;
    EXPECT_EQ(at[first.x + 3] - at[first.x + 2], glm::vec3(1.0F, 1.0F, 0.0F)) << "past the joint";
    EXPECT_EQ(run.all.points[first.x + 2], 1U);
    EXPECT_EQ(run.all.points[second.x + 1], 3U) << "the jump stays";
    // Groups of 16 segments apart.
    std::vector<float> points(3 * 60, 1.0F);
    std::fill(points.begin(), points.begin() + 3, 0.0F);
    std::fill(points.end() - 3, points.end(), 5.0F);
    for (const char* basis : {"", "bezier", "bspline", "catmullRom"}) {
        curves = MakeCurves({58}, {*basis != 0 ? "cubic" : "linear", basis, "nonperiodic"});
        points.resize(3 * 58);
        std::fill(points.end() - 3, points.end(), 5.0F);
        curves.points = points;
        run = GatherAll(curves);
        ASSERT_FALSE(run.all.triangles.empty());
        EXPECT_EQ(NumSegments(run.all), run.source->NumPrimitiveGroups() == 0 ? 0U : 2U) << basis;
        EXPECT_NE(run.all.triangles.front().y & kStands, 0U) << basis;
        EXPECT_EQ(run.all.triangles.front().y & kEnd, 0U) << basis;
        EXPECT_EQ(run.all.triangles.back().y & (kStart | kEnd | kStands), kEnd) << basis;
    }
    for (const char* wrap : {"nonperiodic", "periodic"}) {
        curves = MakeCurves({40}, {"linear", "", wrap});
        curves.points = std::vector<float>(120, 0.5F);
        run = GatherAll(curves);
        EXPECT_EQ(run.all.triangles.size(), 1U) << wrap;
    }
}

/// Groups that draw one piece have the vertices of all their segments: the page is not larger than
/// was said.
TEST(CurveSource, BoundsHoldOfCurvesThatStandStill) {
    for (const char* basis : {"", "bezier", "bspline", "catmullRom"}) {
        const std::size_t numCurves = 30;
        GeometryDescription curves =
            MakeCurves(std::vector<std::int32_t>(numCurves, 49),
                       {*basis != 0 ? "cubic" : "linear", basis, "nonperiodic"});
        std::vector<float> points;
        for (std::size_t i = 0; i < numCurves; ++i) {
            points.insert(points.end(), 3 * 49, static_cast<float>(i));
        }
        curves.points = points;
        Gathered run = GatherAll(curves);
        ASSERT_EQ(run.all.triangles.size(), numCurves) << basis;
        const double bound = numCurves * run.source->BoundBytes().geometry + 1024.0;
        EXPECT_LE(static_cast<double>(BuildGeometryPage(run.all).bytes.size()), bound) << basis;
    }
}

/// Counts ask for what they like: memory is that of what there is.
TEST(CurveSource, CountsBeyondThePointsTakeNoMemory) {
    GeometryDescription curves = MakeCurves({4}, {"cubic", "bspline", "pinned"});
    curves.faceVertexCounts = std::vector<std::int32_t>{4, 2147483647, 2147483647, 2147483647};
    curves.primvars.push_back(MakePrimvar("a", Interpolation::Vertex, {1, 2, 3, 4}));
    const Gathered run = GatherAll(curves);
    EXPECT_EQ(NumSegments(run.all), 3U);
    ASSERT_EQ(run.all.attributes.size(), 1U);
    EXPECT_LT(run.all.attributes[0].values.size(), 16U);
    EXPECT_EQ(run.lines.front(),
              "/c: 3 curves dropped: curveVertexCounts negative or beyond the points");
}

TEST(PointSource, PointsAreSpheresAndBadOnesALine) {
    GeometryDescription points;
    points.primitives = PrimitiveKind::Points;
    points.points = std::vector<float>{0, 0, 0, 1, kNan, 0, 2, 0, 0, 3, 0, 0, 9};
    points.primvars = {MakePrimvar("widths", Interpolation::Vertex, {1, 1, -1, 2}),
                       MakePrimvar("a", Interpolation::Vertex, {5, 6, 7, 8})};
    const Gathered run = GatherAll(points);
    EXPECT_EQ(run.all.triangles.size(), 2U);
    EXPECT_EQ(run.all.radii, (std::vector<float>{0.5F, 1.0F}));
    EXPECT_EQ(run.all.points, (std::vector<std::uint32_t>{0, 3}));
    EXPECT_LE(run.source->AllBounds().min.x, -0.5F);
    EXPECT_GE(run.source->AllBounds().max.x, 4.0F);
    EXPECT_EQ(run.lines,
              (std::vector<std::string>{"/c: 1 points dropped: no width",
                                        "/c: 1 points dropped: not finite or beyond 1e18",
                                        "/c: 1 widths are negative or not finite, read as 0"}));
}

} // namespace
} // namespace hds::test
