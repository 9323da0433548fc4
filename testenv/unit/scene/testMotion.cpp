// SPDX-License-Identifier: Apache-2.0
// Transforms over the shutter: what is between samples, keys that are fine enough, and boxes that
// hold every pose, by brute force.
#include "hdStream/scene/geometryMotion.h"
#include "hdStream/scene/hierarchy.h"
#include "hdStream/scene/motion.h"
#include "hdStream/scene/transforms.h"
#include "kernels/shared/frame.h"
#include "kernels/shared/geometry.h"
#include "kernels/shared/motionKeys.h"
#include "testenv/support/drawnLeaves.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <random>
#include <utility>

namespace hds::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
const Shutter kShutter{-0.25, 0.25};

glm::dmat4 Turned(double degrees) {
    const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), glm::dvec3(3.0, 1.0, 0.0));
    return glm::rotate(moved, degrees * kPi / 180.0, glm::dvec3(0.0, 0.0, 1.0));
}

TEST(Motion, RotationsKeepTheirSize) {
    const std::vector<TransformSample> samples{{-0.25, Turned(0.0)}, {0.25, Turned(120.0)}};
    for (const double part : {0.0, 0.2, 0.5, 0.9, 1.0}) {
        const glm::dmat4 pose = InterpolateTransform(samples, -0.25 + 0.5 * part);
        const glm::dmat4 expected = Turned(120.0 * part);
        for (int column = 0; column < 4; ++column) {
            EXPECT_LT(glm::distance(pose[column], expected[column]), 1e-9) << part;
        }
    }
}

TEST(Motion, MirroredAndStretchedTransformsStaySo) {
    const glm::dmat4 stretched = glm::scale(Turned(20.0), glm::dvec3(-2.0, 0.5, 1.0));
    const glm::dmat4 turned = glm::scale(Turned(80.0), glm::dvec3(-2.0, 0.5, 1.0));
    const std::vector<TransformSample> samples{{0.0, stretched}, {1.0, turned}};
    for (const double time : {0.25, 0.5, 0.75}) {
        const glm::dmat3 linear(InterpolateTransform(samples, time));
        EXPECT_NEAR(glm::determinant(linear), -1.0, 1e-9);
        EXPECT_NEAR(glm::length(linear[0]), 2.0, 1e-9);
    }
}

/// Scales of 0 take away extent, not the way that what is left of it turns.
TEST(Motion, FlatTransformsTurnAsOthersDo) {
    for (const glm::dvec3& scale :
         {glm::dvec3(2.0, 1.0, 0.0), glm::dvec3(0.0, 2.0, 1.0), glm::dvec3(-2.0, 0.0, 1.0)}) {
        const std::vector<TransformSample> samples{{0.0, glm::scale(Turned(10.0), scale)},
                                                   {1.0, glm::scale(Turned(130.0), scale)}};
        for (const double time : {0.25, 0.5, 0.75}) {
            const glm::dmat4 pose = InterpolateTransform(samples, time);
            const glm::dmat4 expected = glm::scale(Turned(10.0 + 120.0 * time), scale);
            for (int column = 0; column < 4; ++column) {
                EXPECT_LT(glm::distance(pose[column], expected[column]), 1e-9) << time;
            }
        }
    }
    // A mirror image that is flat at its end stays one on the way.
    const std::vector<TransformSample> mirrored{
        {0.0, glm::scale(Turned(0.0), glm::dvec3(-1.0, 1.0, 1.0))},
        {1.0, glm::scale(Turned(60.0), glm::dvec3(-1.0, 1.0, 0.0))}};
    const glm::dmat4 half = InterpolateTransform(mirrored, 0.5);
    const glm::dmat4 expected = glm::scale(Turned(30.0), glm::dvec3(-1.0, 1.0, 0.5));
    for (int column = 0; column < 4; ++column) {
        EXPECT_LT(glm::distance(half[column], expected[column]), 1e-9);
    }
    // What is nothing at first, and what is nothing in the middle, have the rotation beside.
    const glm::dmat4 nothing = glm::scale(Turned(0.0), glm::dvec3(0.0));
    for (const std::vector<TransformSample>& samples :
         {std::vector<TransformSample>{{0.0, nothing}, {1.0, Turned(50.0)}, {2.0, Turned(150.0)}},
          std::vector<TransformSample>{
              {1.0, Turned(50.0)}, {2.0, Turned(150.0)}, {3.0, nothing}}}) {
        const glm::dmat4 pose = InterpolateTransform(samples, 1.5);
        EXPECT_LT(glm::distance(pose[0], Turned(100.0)[0]), 1e-9);
        const bool isFirst = samples[0].time < 1.0;
        const glm::dmat4 small = InterpolateTransform(samples, isFirst ? 0.5 : 2.5);
        EXPECT_LT(glm::distance(small[0], 0.5 * Turned(isFirst ? 50.0 : 150.0)[0]), 1e-9);
    }
}

TEST(Motion, SamplesAreCutToTheShutter) {
    const glm::dmat4 one(1.0);
    const glm::dmat4 moved = glm::translate(one, glm::dvec3(4.0, 0.0, 0.0));
    EXPECT_TRUE(SamplesWithin({{-1.0, one}, {1.0, one}}, kShutter).empty());
    EXPECT_TRUE(SamplesWithin({{-1.0, one}, {1.0, moved}}, Shutter()).empty());
    const auto within = SamplesWithin({{-1.0, one}, {0.0, one}, {1.0, moved}}, kShutter);
    ASSERT_EQ(within.size(), 3U);
    EXPECT_EQ(within[0].time, -0.25);
    EXPECT_EQ(within[1].time, 0.0);
    EXPECT_EQ(within[2].matrix[3].x, 1.0);
}

TEST(Motion, LightsMoveRigidlyFromWhereTheFrameHasThem) {
    const auto pose = [](double degrees, double scale, double x) {
        const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), glm::dvec3(x, 2.0, -1.0));
        return glm::scale(
            glm::rotate(moved, glm::radians(degrees), glm::dvec3(1.0, 2.0, 2.0) / 3.0),
            glm::dvec3(scale));
    };
    const Shutter shutter{-0.5, 0.5};
    const glm::dmat4 frame = pose(20.0, 3.0, 4.0);
    bool isRigid = false;
    const auto keys = MakeLightKeys(
        MovingTransform(frame, {{-0.5, pose(-60.0, 3.0, 1.0)}, {0.5, pose(100.0, 3.0, 7.0)}},
                        shutter),
        &isRigid);
    EXPECT_TRUE(isRigid);
    ASSERT_GE(keys.size(), 9U);
    const std::size_t last = keys.size() - 1;
    for (std::size_t i = 0; i <= last; ++i) {
        const double time = double(i) / double(last);
        const glm::dvec4& q = keys[i].turn;
        const double half = glm::radians(0.5 * (-80.0 + 160.0 * time)); // from the frame
        const glm::dvec3 axis = std::sin(half) * glm::dvec3(1.0, 2.0, 2.0) / 3.0;
        EXPECT_NEAR(glm::length(glm::dvec3(q) - axis * (q.w < 0.0 ? -1.0 : 1.0)), 0.0, 1e-9);
        EXPECT_NEAR(glm::length(keys[i].offset - glm::dvec3(-3.0 + 6.0 * time, 0.0, 0.0)), 0.0,
                    1e-9);
        EXPECT_TRUE(i == 0 || glm::dot(q, keys[i - 1].turn) > 0.0);
    }
    MakeLightKeys(MovingTransform(frame, {{-0.5, frame}, {0.5, pose(20.0, 4.0, 4.0)}}, shutter),
                  &isRigid);
    EXPECT_FALSE(isRigid);
    EXPECT_TRUE(MakeLightKeys(MovingTransform(frame), &isRigid).empty());
    EXPECT_TRUE(isRigid);
}

TEST(Motion, KeysAreAsFineAsTheWayIsCurved) {
    const Bounds box{glm::vec3(-1.0F), glm::vec3(1.0F)};
    const glm::dmat4 one(1.0);
    const MovingTransform straight(
        one, {{-0.25, one}, {0.25, glm::translate(one, glm::dvec3(5.0))}}, kShutter);
    EXPECT_EQ(MakeMotionKeys(straight, box).size(), 2U);
    const MovingTransform turning(Turned(0.0), {{-0.25, Turned(0.0)}, {0.25, Turned(150.0)}},
                                  kShutter);
    const std::vector<glm::dmat4> keys = MakeMotionKeys(turning, box);
    ASSERT_GT(keys.size(), 2U);
    ASSERT_LE(keys.size(), std::size_t{HDS_MAX_MOTION_SEGMENTS + 1});
    for (double time = 0.0; time < 1.0; time += 0.013) {
        const double scaled = time * double(keys.size() - 1);
        const auto i = static_cast<std::size_t>(scaled);
        const double part = scaled - double(i);
        const glm::dmat4 between = (1.0 - part) * keys[i] + part * keys[i + 1];
        const glm::dvec4 corner(1.0, 1.0, 1.0, 1.0);
        EXPECT_LT(glm::distance(between * corner, turning.At(time) * corner), 5.0 / 256.0);
    }
}

/// Random poses of a leaf, alone and below an instancer that moves as well.
class RandomMotion {
public:
    explicit RandomMotion(unsigned seed) : _random(seed) {
        GeometryPrim mesh;
        mesh.placement = Moving();
        scene.geometry["/A"] = mesh;
        InstancerPrim instancer;
        instancer.placement = Moving();
        for (const double time : {-0.25, 0.25}) {
            instancer.samples.push_back({time, Transforms()});
        }
        instancer.instanceTransforms = instancer.samples[0].transforms;
        scene.instancers["/I"] = instancer;
        mesh.placement = Moving();
        mesh.placement.instancerPath = "/I";
        mesh.placement.instances = std::vector<std::int32_t>{0, 1, 2};
        scene.geometry["/I/B"] = mesh;
        leaf.bounds = {glm::vec3(-0.5F, -1.0F, -0.2F), glm::vec3(1.0F, 0.5F, 0.7F)};
        leaf.origin = glm::dvec3(0.3, 0.0, 0.1);
        leaf.object = 1;
    }

    SceneDescription scene;
    LeafObject leaf;

    double Number() { return std::uniform_real_distribution<double>(-1.0, 1.0)(_random); }
    glm::dmat4 Pose() {
        const glm::dvec3 axis(Number(), Number(), Number() + 1.1);
        glm::dmat4 pose =
            glm::translate(glm::dmat4(1.0), 5.0 * glm::dvec3(Number(), Number(), Number()));
        pose = glm::rotate(pose, 2.0 * Number(), axis);
        return glm::scale(pose, glm::dvec3(1.0 + 0.5 * Number()));
    }

private:
    Placement Moving() {
        Placement placement;
        placement.samples = {{-0.5, Pose()}, {0.1, Pose()}, {0.5, Pose()}};
        placement.worldFromObject = InterpolateTransform(placement.samples, 0.0);
        return placement;
    }
    SharedSpan<double> Transforms() {
        std::vector<double> values;
        for (int i = 0; i < 3; ++i) {
            const glm::dmat4 pose = Pose();
            values.insert(values.end(), &pose[0][0], &pose[0][0] + 16);
        }
        return values;
    }
    std::mt19937 _random;
};

TEST(Motion, BoxesHoldEveryPose) {
    for (unsigned seed = 0; seed < 40; ++seed) {
        const RandomMotion motion(seed);
        Warnings warnings;
        LightLinks links(motion.scene);
        const Hierarchy tables = BuildHierarchy(
            motion.scene,
            test::DrawnLeaves(motion.scene, {{"/A", motion.leaf}, {"/I/B", motion.leaf}}),
            glm::dvec3(0.0), 2, &links, kShutter, warnings);
        ASSERT_EQ(tables.instances.size(), 4U);
        for (const shared::HdsInstance& instance : tables.instances) {
            ASSERT_NE(instance.flags & HDS_INSTANCE_MOVES, 0U);
            std::uint32_t first = 0;
            std::uint32_t segments = 0;
            std::memcpy(&first, &instance.objectFromParent[HDS_MOTION_FIRST_KEY], sizeof(first));
            std::memcpy(&segments, &instance.objectFromParent[HDS_MOTION_SEGMENTS],
                        sizeof(segments));
            segments &= ~HDS_MOTION_FORMS;
            for (int step = 0; step <= 200; ++step) {
                const float scaled = static_cast<float>(step) / 200.0F * float(segments);
                const std::uint32_t i = std::min(static_cast<std::uint32_t>(scaled), segments - 1);
                const float part = scaled - float(i);
                for (int corner = 0; corner < 8; ++corner) {
                    const Bounds& box = motion.leaf.bounds;
                    const float point[4] = {(corner & 1) != 0 ? box.max.x : box.min.x,
                                            (corner & 2) != 0 ? box.max.y : box.min.y,
                                            (corner & 4) != 0 ? box.max.z : box.min.z, 1.0F};
                    for (int axis = 0; axis < 3; ++axis) {
                        float value = 0.0F;
                        for (int k = 0; k < 4; ++k) {
                            const std::size_t entry = 4U * unsigned(axis) + unsigned(k);
                            const float a = tables.motionKeys[first + i][entry];
                            const float b = tables.motionKeys[first + i + 1][entry];
                            value += (a + part * (b - a)) * point[k];
                        }
                        ASSERT_GE(value, tables.bounds.min[axis]) << "seed " << seed;
                        ASSERT_LE(value, tables.bounds.max[axis]) << "seed " << seed;
                    }
                }
            }
        }
    }
}

// The box between the ends holds the box in every pose between the keys.
TEST(Motion, BoxesBetweenTheEndsHoldEveryPose) {
    const Bounds box{glm::vec3(-0.5F, -1.0F, -0.2F), glm::vec3(1.0F, 0.5F, 0.7F)};
    for (unsigned seed = 0; seed < 100; ++seed) {
        RandomMotion motion(seed);
        std::vector<glm::dmat4> keys;
        for (unsigned i = 0; i < 2 + seed % 5; ++i) {
            keys.push_back(motion.Pose());
        }
        const std::array<Bounds, 2> ends = TransformEnds(keys, box);
        for (int step = 0; step <= 60; ++step) {
            const double time = step / 60.0;
            const double scaled = time * double(keys.size() - 1);
            const auto i = std::min(static_cast<std::size_t>(scaled), keys.size() - 2);
            const double part = scaled - double(i);
            const glm::dmat4 pose = (1.0 - part) * keys[i] + part * keys[i + 1];
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec4 point((corner & 1) != 0 ? box.max.x : box.min.x,
                                       (corner & 2) != 0 ? box.max.y : box.min.y,
                                       (corner & 4) != 0 ? box.max.z : box.min.z, 1.0);
                const glm::dvec3 moved(pose * point);
                for (int axis = 0; axis < 3; ++axis) {
                    ASSERT_GE(moved[axis],
                              (1.0 - time) * ends[0].min[axis] + time * ends[1].min[axis]);
                    ASSERT_LE(moved[axis],
                              (1.0 - time) * ends[0].max[axis] + time * ends[1].max[axis]);
                }
            }
        }
    }
}

/// The words of an instance's record and its first key, of a leaf that goes from pose to pose.
TEST(Motion, InstancesThatSlideBringTheirInverse) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        RandomMotion motion(seed);
        motion.scene.instancers.clear();
        const glm::dmat4 pose = motion.Pose();
        const bool turns = seed % 4 == 3;
        for (auto& [path, prim] : motion.scene.geometry) {
            glm::dmat4 last = turns ? motion.Pose() : pose;
            last[3] = motion.Pose()[3];
            prim.placement.samples = {{-0.7, pose}, {0.9, last}};
            prim.placement.worldFromObject = pose;
        }
        Warnings warnings;
        LightLinks links(motion.scene);
        const Hierarchy tables =
            BuildHierarchy(motion.scene, test::DrawnLeaves(motion.scene, {{"/A", motion.leaf}}),
                           glm::dvec3(0.0), 2, &links, kShutter, warnings);
        ASSERT_EQ(tables.instances.size(), 1U);
        const float* words = tables.instances[0].objectFromParent;
        std::uint32_t first = 0;
        std::uint32_t segments = 0;
        std::memcpy(&first, &words[HDS_MOTION_FIRST_KEY], sizeof(first));
        std::memcpy(&segments, &words[HDS_MOTION_SEGMENTS], sizeof(segments));
        EXPECT_EQ((segments & HDS_MOTION_SLIDES) == 0U, turns) << "seed " << seed;
        if (turns) {
            continue;
        }
        EXPECT_EQ(segments, HDS_MOTION_SLIDES | 1U);
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                double product = 0.0;
                for (int k = 0; k < 3; ++k) {
                    product += double(words[HDS_MOTION_INVERSE + 3 * row + k]) *
                               double(tables.motionKeys[first][std::size_t(4 * k + column)]);
                }
                EXPECT_NEAR(product, row == column ? 1.0 : 0.0, 1e-6);
            }
        }
    }
}

// What turns and grows may be inverted in few operations; what becomes sheared or huge not.
TEST(Motion, OrdinaryMapsAreInvertedInFewOperations) {
    const glm::dvec3 axis = glm::normalize(glm::dvec3(0.3, 1.0, -0.5));
    const auto turned = [&](double angle, const glm::dvec3& size) {
        return glm::scale(glm::rotate(glm::dmat4(1.0), angle, axis), size);
    };
    glm::dmat4 sheared(1.0);
    sheared[1][0] = 9.0;
    const glm::dmat4 rest = turned(0.2, {1.0, 1.5, 0.4});
    const std::pair<glm::dmat4, bool> cases[] = {
        {turned(1.9, {1.0, 1.5, 0.4}), true},   {turned(0.2, {3.0, 0.1, 1.0}), true},
        {turned(0.9, {1e6, 1e6, 1e6}), true},   {rest * sheared, false},
        {turned(0.2, {1e11, 1.0, 1.0}), false},
    };
    for (const auto& [last, isPlain] : cases) {
        RandomMotion motion(3);
        motion.scene.instancers.clear();
        for (auto& [path, prim] : motion.scene.geometry) {
            prim.placement.samples = {{kShutter.open, rest}, {kShutter.close, last}};
            prim.placement.worldFromObject = rest;
        }
        Warnings warnings;
        LightLinks links(motion.scene);
        const Hierarchy tables =
            BuildHierarchy(motion.scene, test::DrawnLeaves(motion.scene, {{"/A", motion.leaf}}),
                           glm::dvec3(0.0), 2, &links, kShutter, warnings);
        ASSERT_EQ(tables.instances.size(), 1U);
        std::uint32_t segments = 0;
        std::memcpy(&segments, &tables.instances[0].objectFromParent[HDS_MOTION_SEGMENTS],
                    sizeof(segments));
        EXPECT_EQ(segments & HDS_MOTION_FORMS, isPlain ? HDS_MOTION_PLAIN : 0U) << last[0][0];
    }
}

// A scale of 0 at some keys, also at the frame: drawn as very small there, and as it is elsewhere.
TEST(Motion, WhatGrowsFromNothingMoves) {
    const auto sized = [](double x, double y, double z) {
        return glm::scale(glm::translate(glm::dmat4(1.0), {1.0, 2.0, 3.0}), glm::dvec3(x, y, z));
    };
    const Bounds bounds{glm::vec3(-1.0F), glm::vec3(1.0F)};
    for (const glm::dvec3& least : {glm::dvec3(0.0), glm::dvec3(0.0, 0.0, 1.0)}) {
        const glm::dmat4 small = sized(least.x, least.y, least.z);
        const std::vector<std::vector<TransformSample>> ways = {
            {{kShutter.open, small}, {kShutter.close, sized(1, 1, 1)}},
            {{kShutter.open, sized(1, 1, 1)}, {kShutter.close, small}},
            {{kShutter.open, small}, {0.0, small}, {kShutter.close, sized(1, 1, 1)}}};
        for (const auto& samples : ways) {
            LeafObject leaf;
            leaf.bounds = bounds;
            leaf.numPrimitives = 1.0F;
            const MovingTransform way(small, samples, kShutter);
            const std::vector<glm::dmat4> keys = KeysFromDevice(way, leaf);
            ASSERT_GE(keys.size(), 2U);
            for (std::size_t i = 0; i < keys.size(); ++i) {
                const glm::dmat4 wanted = way.At(double(i) / double(keys.size() - 1));
                EXPECT_TRUE(IsUsableTransform(keys[i]));
                for (int column = 0; column < 4; ++column) {
                    EXPECT_LT(glm::length(keys[i][column] - wanted[column]), 1e-4);
                }
            }
            GroupRecords records(kShutter);
            ASSERT_NE(records.Add({&leaf, way, 0, 0, 0, HDS_NONE}), nullptr);
            shared::HdsInstance place{};
            std::vector<AffineRows> motionKeys;
            records.Write({0}, &place, &motionKeys);
            EXPECT_NE(place.flags & HDS_INSTANCE_MOVES, 0U);
            EXPECT_EQ(motionKeys.size(), keys.size());
            EXPECT_TRUE(std::all_of(std::begin(place.objectFromParent),
                                    std::end(place.objectFromParent),
                                    [](float value) { return std::isfinite(value); }));
        }
        // Nothing is left of what has no size at any time.
        GroupRecords records(kShutter);
        LeafObject leaf;
        leaf.bounds = bounds;
        const std::vector<TransformSample> samples{{kShutter.open, sized(0, 0, 0)},
                                                   {kShutter.close, sized(0, 0, 1)}};
        const MovingTransform never(sized(0, 0, 0), samples, kShutter);
        EXPECT_EQ(records.Add({&leaf, never, 0, 0, 0, HDS_NONE}), nullptr);
    }
}

TEST(Motion, WhatRestsHasNoKeys) {
    RandomMotion motion(1);
    for (auto& [path, prim] : motion.scene.geometry) {
        prim.placement.samples = {{-0.5, glm::dmat4(1.0)}, {0.5, glm::dmat4(1.0)}};
    }
    motion.scene.instancers.clear();
    Warnings warnings;
    LightLinks links(motion.scene);
    const Hierarchy tables =
        BuildHierarchy(motion.scene, test::DrawnLeaves(motion.scene, {{"/A", motion.leaf}}),
                       glm::dvec3(0.0), 2, &links, kShutter, warnings);
    EXPECT_TRUE(tables.motionKeys.empty());
    EXPECT_EQ(tables.instances[0].flags & HDS_INSTANCE_MOVES, 0U);
}

TEST(Motion, PointsAreThoseOfTheShuttersEnds) {
    GeometryDescription mesh;
    mesh.points = std::vector<float>{0.0F, 0.0F, 0.0F};
    mesh.samples = {{-1.0, std::vector<float>{-4.0F, 0.0F, 0.0F}},
                    {0.0, mesh.points},
                    {1.0, std::vector<float>{0.0F, 8.0F, 0.0F}}};
    EXPECT_FALSE(Deforms(mesh, Shutter()));
    ASSERT_TRUE(Deforms(mesh, kShutter));
    const auto moved = AtShutter(mesh, kShutter);
    EXPECT_EQ(moved->points[0], -1.0F);
    ASSERT_EQ(moved->keys.size(), 2U) << "one at the sample between";
    EXPECT_EQ(moved->keys[0].points[0], 0.0F);
    EXPECT_EQ(moved->keys[1].points[1], 2.0F);
    mesh.samples[2].points = std::vector<float>{0.0F};
    EXPECT_FALSE(Deforms(mesh, kShutter)) << "of another length";
}

/// A point with x at some times; y follows a straight line.
GeometryDescription PointAlong(const std::vector<std::pair<double, float>>& samples) {
    GeometryDescription mesh;
    mesh.points = std::vector<float>{0.0F, 0.0F, 0.0F};
    for (const auto& [time, x] : samples) {
        mesh.samples.push_back({time, std::vector<float>{x, 0.0F, 0.0F}});
    }
    return mesh;
}

TEST(Motion, PointsThatReturnMove) {
    const GeometryDescription mesh = PointAlong({{-0.25, 1.0F}, {0.0, 5.0F}, {0.25, 1.0F}});
    ASSERT_TRUE(Deforms(mesh, kShutter));
    EXPECT_EQ(AtShutter(mesh, kShutter)->keys.size(), 2U);
    EXPECT_FALSE(
        Deforms(PointAlong({{-0.25, 1.0F}, {0.0, 1.0F}, {0.25, 1.0F}, {0.5, 7.0F}}), kShutter))
        << "only after it";
}

TEST(Motion, KeysAreAsFewAsHoldTheSamples) {
    const auto numKeys = [](const GeometryDescription& mesh) {
        return AtShutter(mesh, kShutter)->keys.size();
    };
    EXPECT_EQ(numKeys(PointAlong({{-0.25, 0.0F}, {-0.1, 0.3F}, {0.1, 0.7F}, {0.25, 1.0F}})), 1U)
        << "on a line";
    EXPECT_EQ(numKeys(PointAlong({{-0.25, 0.0F}, {-0.15, 4.0F}, {0.25, 1.0F}})), 5U)
        << "a fifth of the way";
    std::vector<std::pair<double, float>> many;
    for (int i = 0; i <= 40; ++i) {
        many.emplace_back(-0.25 + 0.5 * i / 40.0, i % 2 == 0 ? 0.0F : 1.0F);
    }
    EXPECT_EQ(numKeys(PointAlong(many)), std::size_t{HDS_MAX_DEFORMATION_SEGMENTS});
}

// Between keys points go straight: at every time they are near where the samples have them.
TEST(Motion, KeysAreWhereTheSamplesAre) {
    const GeometryDescription mesh =
        PointAlong({{-0.3, -1.0F}, {-0.21, 2.0F}, {-0.02, 2.5F}, {0.17, 0.0F}, {0.4, 1.0F}});
    const auto posed = AtShutter(mesh, kShutter);
    const auto numSegments = static_cast<double>(posed->keys.size());
    const auto keyAt = [&](std::size_t i) {
        return double{i == 0 ? posed->points[0] : posed->keys[i - 1].points[0]};
    };
    for (double time = 0.0; time < 1.0; time += 0.01) {
        const double at = -0.25 + 0.5 * time;
        std::size_t i = 1;
        while (mesh.samples[i].time < at) {
            ++i;
        }
        const double part =
            (at - mesh.samples[i - 1].time) / (mesh.samples[i].time - mesh.samples[i - 1].time);
        const double exact = (1.0 - part) * double{mesh.samples[i - 1].points[0]} +
                             part * double{mesh.samples[i].points[0]};
        const auto segment = static_cast<std::size_t>(time * numSegments);
        const double within = time * numSegments - double(segment);
        // In between a corner is cut, by no more than a step is long.
        EXPECT_NEAR((1.0 - within) * keyAt(segment) + within * keyAt(segment + 1), exact, 0.25)
            << time;
    }
}

TEST(Motion, TimesThatMakeNoSenseSayNothing) {
    GeometryDescription mesh = PointAlong({{-0.25, 0.0F}, {0.25, 1.0F}});
    const auto expected = AtShutter(mesh, kShutter);
    mesh.samples.push_back({std::nan(""), std::vector<float>{9.0F, 9.0F, 9.0F}});
    mesh.samples.push_back({-0.1, std::vector<float>{9.0F, 9.0F, 9.0F}});
    const auto found = AtShutter(mesh, kShutter);
    ASSERT_EQ(found->keys.size(), 1U);
    EXPECT_EQ(found->keys[0].points, expected->keys[0].points);
    EXPECT_FALSE(Deforms(PointAlong({{std::nan(""), 0.0F}, {0.0, 1.0F}}), kShutter));
}

GeometryDescription Splat() {
    GeometryDescription splat;
    splat.primitives = PrimitiveKind::Splats;
    splat.points = std::vector<float>{0.0F, 0.0F, 0.0F};
    splat.primvars = {
        {"orientations", Interpolation::Vertex, 4, std::vector<float>{0, 0, 0, 1}, {}},
        {"opacities", Interpolation::Vertex, 1, std::vector<float>{0.5F}, {}}};
    return splat;
}

/// Keys lie on the arc, are enough for chords to be near it, and are on one side of it whatever the
/// signs of the samples.
TEST(Motion, ShapesOfSplatsMove) {
    constexpr double kAngle = 2.4; // the half of what it turns by is 1.2 in half of the shutter
    GeometryDescription splat = Splat();
    const auto turn = [](double angle, float scale) {
        return std::vector<float>{0.0F, 0.0F, scale * static_cast<float>(std::sin(angle / 2)),
                                  scale * static_cast<float>(std::cos(angle / 2))};
    };
    splat.splatSamples.Edit().orientations = {
        {-0.25, turn(0.0, 1.0F)}, {0.0, turn(kAngle, -1.0F)}, {0.25, turn(2 * kAngle, 1.0F)}};
    splat.splatSamples.Edit().opacities = {{-0.25, std::vector<float>{0.0F}},
                                           {0.25, std::vector<float>{1.0F}}};
    ASSERT_TRUE(Deforms(splat, kShutter));
    const auto posed = AtShutter(splat, kShutter);
    ASSERT_EQ(posed->keys.size(), 5U) << "2 * 1.2 / 0.49 at least";
    EXPECT_EQ(posed->primvars[1].values[0], 0.0F);
    EXPECT_FLOAT_EQ(posed->keys[2].opacities[0], 0.6F);
    for (int i = 0; i < 5; ++i) {
        const std::vector<float> expected = turn(2.0 * kAngle * (i + 1) / 5.0, 1.0F);
        for (int k = 0; k < 4; ++k) {
            EXPECT_NEAR(posed->keys[i].orientations[k], expected[k], 1e-6) << i;
        }
    }
    EXPECT_FALSE(posed->splatSamples.IsApart());
    splat.splatSamples.Edit().orientations.clear();
    EXPECT_EQ(AtShutter(splat, kShutter)->keys.size(), 1U);
    splat.splatSamples.Edit().opacities[1].values = std::vector<float>{1.0F, 1.0F};
    EXPECT_FALSE(Deforms(splat, kShutter)) << "of another length";
}

TEST(Motion, WidthsMoveWithoutPoints) {
    GeometryDescription dust;
    dust.primitives = PrimitiveKind::Points;
    dust.points = std::vector<float>{0.0F, 0.0F, 0.0F};
    Primvar widths;
    widths.name = "widths";
    widths.values = std::vector<float>{1.0F};
    dust.primvars = {widths};
    dust.widthSamples = {{-0.25, std::vector<float>{2.0F}}, {0.25, std::vector<float>{4.0F}}};
    ASSERT_TRUE(Deforms(dust, kShutter));
    const auto posed = AtShutter(dust, kShutter);
    EXPECT_EQ(posed->primvars[0].values[0], 2.0F);
    ASSERT_EQ(posed->keys.size(), 1U);
    EXPECT_EQ(posed->keys[0].widths[0], 4.0F);
    EXPECT_EQ(posed->keys[0].points, dust.points);
    dust.widthSamples[1].values = std::vector<float>{4.0F, 4.0F};
    EXPECT_FALSE(Deforms(dust, kShutter)) << "of another length";
}

} // namespace
} // namespace hds::test
