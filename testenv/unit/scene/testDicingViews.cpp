// SPDX-License-Identifier: Apache-2.0
// The view of a mesh's finest instance, against a search over all placements that measures a step
// in pixels.
#include "hdStream/scene/dicingViews.h"
#include "hdStream/scene/placements.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace hds {
namespace {

using Entry = std::pair<const std::string, GeometryPrim>;

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

} // namespace
} // namespace hds
