// SPDX-License-Identifier: Apache-2.0
// Adaptive rates: triangles stay within the promised distance of the limit surface on screen, what
// is far or beside the image stays coarse, and rates do not depend on threads.
#include "hdStream/geometry/subdivDice.h"
#include "testenv/unit/geometry/subdivFixtures.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

namespace hds::test {
namespace {

/// Distance of a point from a triangle.
double Distance(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                const glm::dvec3& c) {
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const glm::dvec3 corners[] = {a, b, c};
    double distance = 1e300;
    bool isInside = glm::length(normal) > 0.0;
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 from = corners[k];
        const glm::dvec3 edge = corners[(k + 1) % 3] - from;
        isInside = isInside && glm::dot(glm::cross(edge, p - from), normal) >= 0.0;
        const double t = glm::clamp(glm::dot(p - from, edge) / glm::dot(edge, edge), 0.0, 1.0);
        distance = std::min(distance, glm::length(p - from - t * edge));
    }
    return isInside ? std::min(distance, std::fabs(glm::dot(p - a, glm::normalize(normal))))
                    : distance;
}

TEST(Dicing, TrianglesAreNearTheLimitOnScreen) {
    // Points of a much finer level of OpenSubdiv's refinement, each against the triangles of its
    // face: at most half a pixel away, the bar that is asked for.
    std::mt19937 random(31);
    for (int round = 0; round < 6; ++round) {
        SCOPED_TRACE(round);
        GeometryDescription mesh = MakeRandomCage(random, round % 3 == 2);
        if (round >= 3) {
            AddRandomTags(mesh, random);
            mesh.subdivTags.Edit().interpolateBoundary = "edgeAndCorner";
        }
        const glm::dvec3 eye(0.3, 0.2, -6.0);
        const DicingOptions options = MakeOptions(eye);
        const Diced diced = DiceAll(mesh, options);
        const LimitLevel limit = RefineToLimit(mesh, 5);
        std::vector<std::vector<std::size_t>> byFace(mesh.faceVertexCounts.size());
        for (std::size_t t = 0; t < diced.chunk.triangles.size(); ++t) {
            byFace[diced.chunk.faces[t]].push_back(t);
        }
        double worst = 0.0;
        for (std::size_t f = 0; f < limit.faces.size(); f += 7) {
            const glm::dvec3 p = limit.points[std::size_t(limit.faces[f][0])];
            double distance = 1e300;
            for (const std::size_t t : byFace[std::size_t(limit.cageFaces[f])]) {
                const glm::uvec3 v = diced.chunk.triangles[t];
                distance = std::min(distance, Distance(p, glm::dvec3(diced.chunk.positions[v.x]),
                                                       glm::dvec3(diced.chunk.positions[v.y]),
                                                       glm::dvec3(diced.chunk.positions[v.z])));
            }
            worst = std::max(worst, distance * 640.0 / -(p.z + eye.z));
        }
        EXPECT_LT(worst, 0.5);
        // Far fewer triangles than the uniform level; semi-sharp edges turn within a few pixels.
        EXPECT_LT(diced.chunk.triangles.size(),
                  DiceUniform(mesh, kAdaptiveLevel).source->NumTriangles() / (round < 3 ? 10 : 1));
    }
}

TEST(Dicing, WhatIsFarOrUnseenStaysCoarse) {
    const GeometryDescription cube = MakeCube();
    const auto numTriangles = [&](const glm::dvec3& at) {
        return DiceAll(cube, MakeOptions(at)).chunk.triangles.size();
    };
    const std::size_t near = numTriangles({0, 0, -3});
    const std::size_t farther = numTriangles({0, 0, -30});
    EXPECT_GT(near, 3 * farther);
    EXPECT_GT(farther, 12U);
    EXPECT_EQ(numTriangles({0, 0, -30000}), 12U);
    EXPECT_LE(numTriangles({30, 0, -3}), 48U);
    EXPECT_LE(numTriangles({0, 0, 30}), 48U);
    // Another instance may show what this one has beside the image.
    DicingOptions shared = MakeOptions({30, 0, -3});
    shared.view.isOnlyInstance = false;
    EXPECT_GT(DiceAll(cube, shared).chunk.triangles.size(), 48U);
    // From within, the level is the bound.
    DicingOptions inside = MakeOptions({0, 0, 0});
    inside.view.windowMin = glm::dvec2(-1e9);
    inside.view.windowMax = glm::dvec2(1e9);
    inside.view.imageSize = glm::dvec2(1e15);
    inside.level = 3;
    inside.view.isOnlyInstance = false;
    EXPECT_EQ(DiceAll(cube, inside).chunk.triangles.size(), 12U << 6U);
}

TEST(Dicing, FlatFacesNeedNoTriangles) {
    GeometryDescription sheet = MakeFlatGrid(3);
    sheet.subdivisionScheme = "bilinear";
    EXPECT_EQ(DiceAll(sheet, MakeOptions({-0.5, -0.5, -30})).chunk.triangles.size(), 18U);
}

/// Ripples along x and y: a height whose normals have a closed form.
class Ripples final : public DisplacementAmount {
public:
    Ripples(double height, double frequency) : _height(height), _frequency(frequency) {}
    const std::vector<AmountPrimvar>& Primvars() const override { return _none; }
    bool ReadsPosition() const override { return true; }
    double At(const AmountPoint& p) const override {
        return _height * std::sin(_frequency * p.position.x) * std::sin(_frequency * p.position.y);
    }
    AmountRange Over(const AmountBox& /*box*/) const override { return {-_height, _height}; }
    glm::dvec3 NormalAt(double x, double y) const {
        const double slope = _height * _frequency;
        return glm::normalize(
            glm::dvec3(-slope * std::cos(_frequency * x) * std::sin(_frequency * y),
                       -slope * std::sin(_frequency * x) * std::cos(_frequency * y), 1.0));
    }

private:
    std::vector<AmountPrimvar> _none;
    double _height;
    double _frequency;
};

/// The mean angle, in degrees, between the closed form and the shading normal in the middle of each
/// triangle.
double MeanNormalError(const ChunkGeometry& chunk, const Ripples& ripples) {
    double sum = 0.0;
    for (const glm::uvec3& v : chunk.triangles) {
        glm::dvec3 normal(0.0);
        glm::dvec3 middle(0.0);
        for (int k = 0; k < 3; ++k) {
            const float* corner = chunk.normals.values.data() + 3 * std::size_t(v[k]);
            normal += glm::dvec3(corner[0], corner[1], corner[2]);
            middle += glm::dvec3(chunk.positions[v[k]]) / 3.0;
        }
        const glm::dvec3 expected = ripples.NormalAt(middle.x, middle.y);
        sum += std::acos(std::min(glm::dot(glm::normalize(normal), expected), 1.0));
    }
    return sum / double(chunk.triangles.size()) * 180.0 / 3.14159265358979323846;
}

TEST(Dicing, RatesFollowWhatDisplaces) {
    // 64 faces of 40 pixels. Displacement alone asks for segments below 4 pixels, level 4.
    for (const bool areQuads : {true, false}) {
        SCOPED_TRACE(areQuads);
        GeometryDescription sheet = MakeFlatGrid(8);
        sheet.subdivisionScheme = "catmullClark";
        if (!areQuads) {
            std::vector<int> indices;
            for (int quad = 0; quad < 64; ++quad) {
                const int* v = sheet.faceVertexIndices.data() + 4 * std::ptrdiff_t(quad);
                indices.insert(indices.end(), {v[0], v[1], v[2], v[0], v[2], v[3]});
            }
            sheet.faceVertexIndices = indices;
            sheet.faceVertexCounts = std::vector<int>(128, 3);
            sheet.subdivisionScheme = "loop";
        }
        const DicingOptions options = MakeOptions({-0.5, -0.5, -2});
        const auto dice = [&](const std::shared_ptr<const Ripples>& ripples) {
            return DiceAll(sheet, options, {ripples}).chunk;
        };
        const std::size_t level4 = DiceUniform(sheet, 4).chunk.triangles.size();
        const auto slow = std::make_shared<Ripples>(0.02, 12.0);
        const ChunkGeometry smooth = dice(slow);
        // Of triangles the medians count, which are longer than some sides.
        EXPECT_LT(smooth.triangles.size(), areQuads ? level4 + 1 : level4 * 5 / 4);
        EXPECT_LT(MeanNormalError(smooth, *slow), 1.0);
        // Normals are those of the place where they stand, whatever the shape of the face.
        EXPECT_LT(MeanNormalError(DiceUniform(sheet, kAdaptiveLevel, {slow}).chunk, *slow), 0.02);
        // Waves of 8 pixels, of which level 4 has three points each.
        const auto fast = std::make_shared<Ripples>(0.003, 250.0);
        const ChunkGeometry fine = dice(fast);
        const double finest =
            MeanNormalError(DiceUniform(sheet, kAdaptiveLevel, {fast}).chunk, *fast);
        EXPECT_LT(finest, 2.5);
        EXPECT_LT(MeanNormalError(fine, *fast), 1.1 * finest);
        EXPECT_GT(MeanNormalError(DiceUniform(sheet, 4, {fast}).chunk, *fast), 7.0);
        // Ripples that are farther away are cut less finely: segments of a pixel are enough.
        const DicingOptions far = MakeOptions({-0.5, -0.5, -8});
        EXPECT_LT(DiceAll(sheet, far, {fast}).chunk.triangles.size(), level4 + 1);
    }
}

TEST(Dicing, ResultsDoNotDependOnThreads) {
    std::mt19937 random(33);
    GeometryDescription mesh = MakeRandomCage(random, false);
    AddRandomTags(mesh, random);
    const DicingOptions options = MakeOptions({0.3, 0.2, -6.0});
    const Diced many = DiceAll(mesh, options);
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
    const Diced one = DiceAll(mesh, options);
    EXPECT_EQ(many.chunk.positions, one.chunk.positions);
    EXPECT_EQ(many.chunk.triangles, one.chunk.triangles);
    EXPECT_EQ(many.chunk.primIds, one.chunk.primIds);
    EXPECT_EQ(many.source->EdgeLevels(), one.source->EdgeLevels());
}

TEST(Dicing, LevelsFallUntilTrianglesCanBeCounted) {
    std::mt19937 random(34);
    Warnings warnings;
    SubdivDice dice;
    dice.model = SubdivModel::Make(
        std::make_shared<GeometryDescription>(MakeGrid(256, [](float, float) { return 0.0F; })),
        "/World/mesh", warnings);
    dice.edgeLevels.assign(std::size_t(dice.model->Level().GetNumEdges()), kMaxDicingLevel);
    EXPECT_EQ(dice.NumberGroups().triangles, std::uint64_t(65536) * 2 * 128 * 128);
    EXPECT_EQ(dice.edgeLevels[0], 7);
}

} // namespace
} // namespace hds::test
