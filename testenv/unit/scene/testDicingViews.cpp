// SPDX-License-Identifier: Apache-2.0
// The view of a mesh's finest instance, against a search over all placements that measures a step
// in pixels.
#include "hdStream/geometry/subdivSource.h"
#include "hdStream/scene/dicingViews.h"
#include "hdStream/scene/motion.h"
#include "hdStream/scene/placements.h"
#include "testenv/unit/geometry/subdivFixtures.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hds {
namespace {

using Entry = GeometryEntry;

GeometryPrim MakeMeshPrim(float size) {
    auto mesh = std::make_shared<GeometryDescription>();
    mesh->points = std::vector<float>{-size, -size, 0, size, -size, 0, 0, size, size};
    mesh->faceVertexCounts = std::vector<std::int32_t>{3};
    mesh->faceVertexIndices = std::vector<std::int32_t>{0, 1, 2};
    mesh->subdivisionScheme = "catmullClark";
    GeometryPrim prim;
    prim.geometry = mesh;
    return prim;
}

DicingCamera MakeCamera() {
    DicingCamera camera;
    camera.worldFromCamera = glm::translate(glm::dmat4(1.0), {0.0, 0.0, 10.0});
    camera.windowMin = {-0.5, -0.4};
    camera.windowMax = {0.5, 0.4};
    camera.imageSize = {500.0, 400.0};
    camera.nearClip = 0.1;
    return camera;
}

std::vector<const Entry*> All(const SceneDescription& scene) {
    std::vector<const Entry*> meshes;
    for (const Entry& entry : scene.geometry) {
        meshes.push_back(&entry);
    }
    return meshes;
}

void ExpectNear(const glm::dmat4& a, const glm::dmat4& b) {
    for (int column = 0; column < 4; ++column) {
        EXPECT_LT(glm::length(a[column] - b[column]), 1e-9);
    }
}

TEST(DicingViews, AMeshHasItsOwnPlace) {
    SceneDescription scene;
    scene.geometry["/a"] = MakeMeshPrim(1.0F);
    scene.geometry["/a"].placement.worldFromObject = glm::translate(glm::dmat4(1.0), {1, 2, 3});
    scene.geometry["/polygons"] = MakeMeshPrim(1.0F);
    auto polygons = std::make_shared<GeometryDescription>(*scene.geometry["/a"].geometry);
    polygons->subdivisionScheme = "none";
    scene.geometry["/polygons"].geometry = polygons;
    const auto views = FindDicingViews(scene, All(scene), MakeCamera());
    ASSERT_EQ(views.size(), 1U);
    const DicingView& view = views.at("/a");
    ExpectNear(view.cameraFromObject, glm::translate(glm::dmat4(1.0), {1, 2, -7}));
    EXPECT_TRUE(view.isOnlyInstance);
    EXPECT_EQ(view.windowMax, glm::dvec2(0.5, 0.4));
    EXPECT_EQ(view.imageSize, glm::dvec2(500.0, 400.0));
}

/// Pixels of a small step at the object's origin; negative when that is not in the image.
double PixelsAt(const glm::dmat4& cameraFromObject, const DicingCamera& camera) {
    const auto p = glm::dvec3(cameraFromObject[3]);
    const double scale = std::max({glm::length(glm::dvec3(cameraFromObject[0])),
                                   glm::length(glm::dvec3(cameraFromObject[1])),
                                   glm::length(glm::dvec3(cameraFromObject[2]))});
    const double x = p.x / -p.z;
    const double y = p.y / -p.z;
    const bool isInside = p.z < 0.0 && x > camera.windowMin.x && x < camera.windowMax.x &&
                          y > camera.windowMin.y && y < camera.windowMax.y;
    return isInside ? scale / std::max(-p.z, camera.nearClip) : -1.0;
}

TEST(DicingViews, TheFinestInstanceIsFound) {
    // Tiny meshes, so that a point stands for all of one; two levels of instancers.
    std::mt19937 random(5);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * double(random() % 10000) / 10000.0;
    };
    const auto makeInstancer = [&](std::size_t count, double spread) {
        InstancerPrim instancer;
        std::vector<double> values;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::dmat4 matrix = glm::scale(
                glm::translate(glm::dmat4(1.0), {uniform(-spread, spread), uniform(-spread, spread),
                                                 uniform(-spread, spread)}),
                glm::dvec3(uniform(0.5, 2.0)));
            values.insert(values.end(), glm::value_ptr(matrix), glm::value_ptr(matrix) + 16);
        }
        instancer.instanceTransforms = values;
        return instancer;
    };
    for (int round = 0; round < 20; ++round) {
        SceneDescription scene;
        scene.instancers["/outer"] = makeInstancer(7, 8.0);
        scene.instancers["/inner"] = makeInstancer(30, 3.0);
        scene.instancers["/inner"].placement.instancerPath = "/outer";
        scene.instancers["/inner"].placement.instances =
            std::vector<std::int32_t>{0, 1, 2, 3, 4, 5, 6};
        GeometryPrim prim = MakeMeshPrim(1e-9F);
        prim.placement.instancerPath = "/inner";
        std::vector<std::int32_t> instances;
        for (int i = 0; i < 30; ++i) {
            instances.push_back(i % 5 == 4 ? -1 : i);
        }
        prim.placement.instances = instances;
        scene.geometry["/a"] = prim;
        const DicingCamera camera = MakeCamera();
        const glm::dmat4 cameraFromWorld = glm::inverse(camera.worldFromCamera);
        double best = -1.0;
        int numInside = 0;
        ForEachPlacement(scene, prim.placement, [&](const glm::dmat4& worldFromObject) {
            const double pixels = PixelsAt(cameraFromWorld * worldFromObject, camera);
            numInside += pixels > 0.0 ? 1 : 0;
            best = std::max(best, pixels);
        });
        const auto views = FindDicingViews(scene, All(scene), camera);
        EXPECT_NEAR(PixelsAt(views.at("/a").cameraFromObject, camera), best, 1e-6);
        EXPECT_EQ(views.at("/a").isOnlyInstance, numInside <= 1);
    }
}

TEST(DicingViews, InstancersInACircleEnd) {
    SceneDescription scene;
    InstancerPrim loop;
    loop.placement.instancerPath = "/loop";
    loop.placement.instances = std::vector<std::int32_t>{0};
    loop.instanceTransforms = std::vector<double>(16, 1.0);
    scene.instancers["/loop"] = loop;
    scene.geometry["/a"] = MakeMeshPrim(1.0F);
    scene.geometry["/a"].placement.instancerPath = "/loop";
    scene.geometry["/a"].placement.instances = std::vector<std::int32_t>{0};
    EXPECT_EQ(FindDicingViews(scene, All(scene), MakeCamera()).size(), 1U);
}

/// Distance of the object's origin from the eye in the nearest of a view's places.
double NearestPlace(const DicingView& view) {
    double nearest = glm::length(glm::dvec3(view.cameraFromObject[3]));
    for (const glm::dmat4& place : view.otherPlaces) {
        nearest = std::min(nearest, glm::length(glm::dvec3(place[3])));
    }
    return nearest;
}

InstancerPrim PlacesAt(const std::vector<glm::dvec3>& positions) {
    InstancerPrim instancer;
    std::vector<double> values;
    for (const glm::dvec3& position : positions) {
        const glm::dmat4 matrix = glm::translate(glm::dmat4(1.0), position);
        values.insert(values.end(), glm::value_ptr(matrix), glm::value_ptr(matrix) + 16);
    }
    instancer.instanceTransforms = values;
    return instancer;
}

TEST(DicingViews, EachPrimOfAPrototypeHasItsOwnInstance) {
    // Two prims 400 apart: the eye is among all instances, but each prim is near in one of them.
    for (const bool isReversed : {false, true}) {
        SceneDescription scene;
        std::vector<glm::dvec3> positions{{0, 0, 0}, {-400, 0, 0}, {3, 0, -2000}};
        if (isReversed) {
            std::reverse(positions.begin(), positions.end());
        }
        scene.instancers["/i"] = PlacesAt(positions);
        for (const char* path : {"/a", "/b"}) {
            GeometryPrim prim = MakeMeshPrim(1.0F);
            const bool isFirst = std::string(path) == "/a";
            prim.placement.worldFromObject =
                glm::translate(glm::dmat4(1.0), {isFirst ? 0.0 : 400.0, isFirst ? 1.0 : 2.0, 0.0});
            prim.placement.instancerPath = "/i";
            prim.placement.instances = std::vector<std::int32_t>{0, 1, 2};
            scene.geometry[path] = prim;
        }
        scene.geometry["/b"].placement.instances = scene.geometry["/a"].placement.instances;
        const auto views = FindDicingViews(scene, All(scene), MakeCamera());
        EXPECT_NEAR(NearestPlace(views.at("/a")), std::hypot(10.0, 1.0), 1e-9);
        EXPECT_NEAR(NearestPlace(views.at("/b")), std::hypot(10.0, 2.0), 1e-9);
    }
}

TEST(DicingViews, InstancesAroundTheEyeAllCount) {
    // A mesh so large that the eye is in the sphere of each of its instances.
    std::vector<glm::dvec3> positions{{0, 0, -1}, {90, 3, 9}, {-80, 1, 5}};
    for (int order = 0; order < 3; ++order) {
        SceneDescription scene;
        scene.instancers["/i"] = PlacesAt(positions);
        GeometryPrim prim = MakeMeshPrim(100.0F);
        prim.placement.instancerPath = "/i";
        prim.placement.instances = std::vector<std::int32_t>{0, 1, 2};
        scene.geometry["/a"] = prim;
        const DicingView view = FindDicingViews(scene, All(scene), MakeCamera()).at("/a");
        ASSERT_EQ(view.otherPlaces.size(), 2U);
        ExpectNear(view.cameraFromObject, glm::translate(glm::dmat4(1.0), {0, 0, -11}));
        EXPECT_FALSE(view.isOnlyInstance);
        // What is far from all of them has one place.
        DicingCamera far = MakeCamera();
        far.worldFromCamera = glm::translate(glm::dmat4(1.0), {0.0, 0.0, 3000.0});
        EXPECT_TRUE(FindDicingViews(scene, All(scene), far).at("/a").otherPlaces.empty());
        std::rotate(positions.begin(), positions.begin() + 1, positions.end());
    }
}

TEST(DicingViews, DisplacementMakesSpheresLarger) {
    SceneDescription scene;
    scene.instancers["/i"] = PlacesAt({{0, 0, 0}, {0, -30, 0}});
    GeometryPrim prim = MakeMeshPrim(1.0F);
    prim.placement.instancerPath = "/i";
    prim.placement.instances = std::vector<std::int32_t>{0, 1};
    scene.geometry["/a"] = prim;
    EXPECT_TRUE(FindDicingViews(scene, All(scene), MakeCamera()).at("/a").isOnlyInstance);
    const auto reachOf = [](const GeometryEntry& /*entry*/) { return 29.0; };
    const auto views = FindDicingViews(scene, All(scene), MakeCamera(), {}, reachOf);
    EXPECT_FALSE(views.at("/a").isOnlyInstance);
}

/// Triangles' share of the finest levels: how many of the edges of a cube are cut.
std::uint32_t LevelOfCube(const DicingView& view) {
    DicingOptions options;
    options.isAdaptive = true;
    options.level = kAdaptiveLevel;
    options.view = view;
    Warnings warnings;
    const auto source = MakeSubdivSource(std::make_shared<GeometryDescription>(test::MakeCube()),
                                         "/a", options, {}, warnings);
    return *std::max_element(source->EdgeLevels().begin(), source->EdgeLevels().end());
}

class MovingViews : public ::testing::Test {
protected:
    /// A cube that moves, below an instancer that moves, or a camera that does the opposite.
    enum class What { Prim, Instances, Instancer, Camera };

    DicingView ViewOver(What what, const std::vector<TransformSample>& samples) {
        SceneDescription scene;
        GeometryPrim prim = MakeMeshPrim(1.0F);
        prim.geometry = std::make_shared<GeometryDescription>(test::MakeCube());
        const Shutter shutter{0.0, 1.0};
        DicingCamera camera = MakeCamera();
        const glm::dmat4 atFrame = samples.front().matrix;
        const std::vector<double> identity(glm::value_ptr(glm::dmat4(1.0)),
                                           glm::value_ptr(glm::dmat4(1.0)) + 16);
        const bool isInstanced = what == What::Instances || what == What::Instancer;
        if (isInstanced) {
            InstancerPrim instancer;
            instancer.instanceTransforms = identity;
            prim.placement.instancerPath = "/i";
            prim.placement.instances = std::vector<std::int32_t>{0};
            if (what == What::Instancer) {
                instancer.placement.worldFromObject = atFrame;
                instancer.placement.samples = samples;
            }
            for (std::size_t i = 0; what == What::Instances && i < samples.size(); ++i) {
                const double* values = glm::value_ptr(samples[i].matrix);
                const std::vector<double> matrix(values, values + 16);
                instancer.samples.push_back({samples[i].time, matrix});
                if (i == 0) {
                    instancer.instanceTransforms = matrix;
                }
            }
            scene.instancers["/i"] = instancer;
        } else if (what == What::Prim) {
            prim.placement.worldFromObject = atFrame;
            prim.placement.samples = samples;
        } else {
            const glm::dmat4 rest = camera.worldFromCamera;
            const MovingTransform way(atFrame, samples, shutter);
            camera.worldFromCamera = glm::inverse(atFrame) * rest;
            for (std::size_t i = 0; i <= kDicingSteps; ++i) {
                const double time = double(i) / double(kDicingSteps);
                camera.path.push_back(glm::inverse(way.At(time)) * rest);
            }
        }
        scene.geometry["/a"] = prim;
        return FindDicingViews(scene, All(scene), camera, shutter).at("/a");
    }
};

TransformSample SampleAt(double time, double x, double z = 0.0) {
    return {time, glm::translate(glm::dmat4(1.0), {x, 0.0, z})};
}

TEST_F(MovingViews, WhatComesIntoTheImageIsFine) {
    SceneDescription still;
    still.geometry["/a"] = MakeMeshPrim(1.0F);
    const std::uint32_t wanted =
        LevelOfCube(FindDicingViews(still, All(still), MakeCamera()).at("/a"));
    ASSERT_GT(wanted, 2U);
    for (const What what : {What::Prim, What::Instances, What::Instancer, What::Camera}) {
        SCOPED_TRACE(int(what));
        const auto levelOver = [&](const std::vector<TransformSample>& samples) {
            return LevelOfCube(ViewOver(what, samples));
        };
        EXPECT_GE(levelOver({SampleAt(0, 50), SampleAt(0.125, 0), SampleAt(1, 0)}), wanted);
        EXPECT_GE(levelOver({SampleAt(0, 0), SampleAt(1, 50)}), wanted);
        // It passes the image between two looks.
        EXPECT_GE(levelOver({SampleAt(0, -450), SampleAt(1, 550)}), wanted);
        // It comes nearer.
        EXPECT_GT(levelOver({SampleAt(0, 0, -90), SampleAt(1, 0, 5)}), wanted);
        // It stays on one side of the image, or rests.
        EXPECT_LE(levelOver({SampleAt(0, 50), SampleAt(1, 20)}), 1U);
        EXPECT_EQ(levelOver({SampleAt(0, 0), SampleAt(1, 0)}), wanted);
    }
}

TEST_F(MovingViews, AStraightWayIsItsEndsAndABentOneAllOfIt) {
    const DicingView straight = ViewOver(What::Prim, {SampleAt(0, 4), SampleAt(1, -4)});
    EXPECT_LE(straight.otherPlaces.size(), 2U);
    EXPECT_TRUE(straight.isOnlyInstance);
    const DicingView bent =
        ViewOver(What::Prim, {SampleAt(0, 4), SampleAt(0.5, 0, 4), SampleAt(1, -4)});
    EXPECT_EQ(bent.otherPlaces.size(), kDicingSteps);
    EXPECT_TRUE(ViewOver(What::Prim, {SampleAt(0, 4), SampleAt(1, 4)}).otherPlaces.empty());
}

} // namespace
} // namespace hds
