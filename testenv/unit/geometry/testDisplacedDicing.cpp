// SPDX-License-Identifier: Apache-2.0
// Adaptive rates of what displacement moves far: rates follow from where the surface is then, and
// from all places that a view has, against shapes in closed form.
#include "testenv/unit/geometry/subdivFixtures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hds::test {
namespace {

/// Waves around a distance: a height whose normals have a closed form, or none around it.
class Waves final : public DisplacementAmount {
public:
    Waves(double distance, double height) : _distance(distance), _height(height) {}
    const std::vector<AmountPrimvar>& Primvars() const override { return _none; }
    bool ReadsPosition() const override { return true; }
    double At(const AmountPoint& p) const override {
        return _distance +
               _height * std::sin(kFrequency * p.position.x) * std::sin(kFrequency * p.position.y);
    }
    AmountRange Over(const AmountBox& /*box*/) const override {
        return {_distance - _height, _distance + _height};
    }
    /// Of the triangles of a sheet in the plane z = 0: the mean angle between their own normal and
    /// the closed form in their middle, in degrees.
    double MeanError(const ChunkGeometry& chunk) const {
        double sum = 0.0;
        for (const glm::uvec3& v : chunk.triangles) {
            const glm::dvec3 a(chunk.positions[v.x]);
            const glm::dvec3 b(chunk.positions[v.y]);
            const glm::dvec3 c(chunk.positions[v.z]);
            const glm::dvec3 middle = (a + b + c) / 3.0;
            const double slope = _height * kFrequency;
            const double x = kFrequency * middle.x;
            const double y = kFrequency * middle.y;
            const glm::dvec3 expected = glm::normalize(glm::dvec3(
                -slope * std::cos(x) * std::sin(y), -slope * std::sin(x) * std::cos(y), 1.0));
            const glm::dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
            sum += std::acos(std::min(glm::dot(normal, expected), 1.0));
        }
        return sum / double(chunk.triangles.size()) * 180.0 / 3.14159265358979323846;
    }

private:
    static constexpr double kFrequency = 12.0;
    std::vector<AmountPrimvar> _none;
    double _distance;
    double _height;
};

GeometryDescription MakeSheet(const char* scheme) {
    GeometryDescription sheet = MakeFlatGrid(2);
    sheet.subdivisionScheme = scheme;
    if (sheet.subdivisionScheme == "loop") {
        std::vector<int> indices;
        for (int quad = 0; quad < 4; ++quad) {
            const int* v = sheet.faceVertexIndices.data() + 4 * std::ptrdiff_t(quad);
            indices.insert(indices.end(), {v[0], v[1], v[2], v[0], v[2], v[3]});
        }
        sheet.faceVertexIndices = indices;
        sheet.faceVertexCounts = std::vector<int>(8, 3);
    }
    return sheet;
}

TEST(DisplacedDicing, WhatIsMovedIntoTheImageIsFine) {
    // The sheet is looked at along its y: displacement moves it up in the image.
    glm::dmat4 turned(1.0);
    turned[1] = {0.0, 0.0, -1.0, 0.0};
    turned[2] = {0.0, 1.0, 0.0, 0.0};
    for (const char* scheme : {"catmullClark", "loop"}) {
        SCOPED_TRACE(scheme);
        const GeometryDescription sheet = MakeSheet(scheme);
        const auto dice = [&](double below, double distance) {
            DicingOptions options = MakeOptions({});
            options.view.cameraFromObject = turned;
            options.view.cameraFromObject[3] = {-0.5, -below, -2.0, 1.0};
            const auto waves = std::make_shared<Waves>(distance, 0.02);
            const ChunkGeometry chunk = DiceAll(sheet, options, {waves}).chunk;
            return std::make_pair(chunk.triangles.size(), waves->MeanError(chunk));
        };
        const auto inside = dice(0.0, 0.0);
        const auto moved = dice(6.0, 6.0);
        EXPECT_GE(moved.first, inside.first);
        EXPECT_LT(moved.second, 1.05 * inside.second);
        EXPECT_LT(inside.second, 2.0);
        // What stays beside the image stays coarse.
        EXPECT_LE(dice(6.0, 0.0).first, 8U * 4U);
        EXPECT_LE(dice(6.0, 0.5).first, 8U * 4U);
        EXPECT_LE(dice(-6.0, 1.0).first, 8U * 4U);
    }
}

TEST(DisplacedDicing, WhatIsMovedTowardsTheEyeIsFine) {
    for (const char* scheme : {"catmullClark", "loop", "bilinear"}) {
        SCOPED_TRACE(scheme);
        const GeometryDescription sheet = MakeSheet(scheme);
        const auto dice = [&](double depth, double distance) {
            const auto waves = std::make_shared<Waves>(distance, 0.02);
            const ChunkGeometry chunk =
                DiceAll(sheet, MakeOptions({-0.5, -0.5, -depth}), {waves}).chunk;
            return std::make_pair(chunk.triangles.size(), waves->MeanError(chunk));
        };
        const auto near = dice(2.0, 0.0);
        const auto moved = dice(50.0, 48.0);
        EXPECT_GE(moved.first, near.first);
        EXPECT_LT(moved.second, 1.05 * near.second);
        EXPECT_LT(near.second, 2.0);
        // And what is moved away needs as little as what is there.
        EXPECT_LE(dice(2.0, -98.0).first, 2 * dice(100.0, 0.0).first);
    }
}

TEST(DisplacedDicing, WhatIsBlownUpEvenlyIsMeasuredAsItIsThen) {
    // A speck that becomes a ball: all points are within its size of distance 1 from the centre.
    GeometryDescription speck = MakeCube();
    std::vector<float> points(speck.points.data(), speck.points.data() + speck.points.size());
    std::for_each(points.begin(), points.end(), [](float& value) { value *= 1e-3F; });
    speck.points = points;
    const DicingOptions options = MakeOptions({0, 0, -3});
    const ChunkGeometry chunk = DiceAll(speck, options, {MakeConstantAmount(1.0)}).chunk;
    double worst = 0.0;
    for (const glm::uvec3& v : chunk.triangles) {
        const glm::dvec3 middle =
            (glm::dvec3(chunk.positions[v.x]) + glm::dvec3(chunk.positions[v.y]) +
             glm::dvec3(chunk.positions[v.z])) /
            3.0;
        worst = std::max(worst, 1.0 - glm::length(middle));
    }
    EXPECT_LT(worst * 640.0 / 2.0, 0.75); // pixels, at the nearest point
    EXPECT_LT(chunk.triangles.size(), DiceUniform(speck, kAdaptiveLevel).chunk.triangles.size());
}

} // namespace
} // namespace hds::test
