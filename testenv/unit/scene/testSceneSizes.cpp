// SPDX-License-Identifier: Apache-2.0
// What is counted edit by edit is what a count of the scene that is left gives.
#include "hdStream/scene/sceneSizes.h"

#include <gtest/gtest.h>

#include <random>

namespace hds {
namespace {

/// A prim of random size, or one without geometry.
GeometryPrim RandomMesh(std::mt19937* random) {
    const auto number = [&](unsigned most) { return (*random)() % most; };
    GeometryPrim prim;
    if (number(8) == 0) {
        return prim; // nothing to draw
    }
    auto mesh = std::make_shared<GeometryDescription>();
    mesh->points = std::vector<float>(3 * number(50));
    for (unsigned i = number(4); i > 0; --i) {
        mesh->primvars.push_back(
            {std::string(number(40), 'p'), Interpolation::Constant, 3, std::vector<float>(3), {}});
    }
    prim.geometry = std::move(mesh);
    prim.materialPath = std::string(number(60), 'm');
    prim.placement.instances = std::vector<std::int32_t>(number(20));
    return prim;
}

InstancerPrim RandomInstancer(std::mt19937* random) {
    InstancerPrim prim;
    prim.instanceTransforms = std::vector<double>(16 * ((*random)() % 10));
    prim.placement.instancerPath = std::string((*random)() % 50, 'i');
    return prim;
}

/// Of the maps as they are: texts that were assigned to may have more room than their copies.
void ExpectRecounted(const SceneSizes& sizes, const SceneDescription& scene) {
    std::uint64_t described = 0;
    KeptArrays arrays;
    const auto count = [&](const auto& prims) {
        for (const auto& [path, prim] : prims) {
            described += DescribedBytes(path, prim);
            arrays.geometryBytes += KeptArraysOf(prim).geometryBytes;
            arrays.instanceBytes += KeptArraysOf(prim).instanceBytes;
        }
    };
    count(scene.geometry);
    count(scene.instancers);
    EXPECT_EQ(sizes.DescribedBytes(), described);
    EXPECT_EQ(sizes.Arrays().geometryBytes, arrays.geometryBytes);
    EXPECT_EQ(sizes.Arrays().instanceBytes, arrays.instanceBytes);
}

TEST(SceneSizes, OfAnEditedSceneAreThoseOfWhatIsLeft) {
    std::mt19937 random(7);
    SceneDescription scene;
    SceneSizes sizes;
    for (int edit = 0; edit < 2000; ++edit) {
        const std::string path = "/World/" + std::to_string(random() % 40);
        switch (random() % 6) {
        case 0:
            sizes.Erase(&scene.geometry, path);
            sizes.Erase(&scene.instancers, path);
            break;
        case 1:
            sizes.Set(&scene.instancers, path, RandomInstancer(&random));
            break;
        default:
            sizes.Set(&scene.geometry, path, RandomMesh(&random));
        }
        if (edit % 50 == 0) {
            ExpectRecounted(sizes, scene);
        }
    }
    ExpectRecounted(sizes, scene);
    EXPECT_GT(sizes.DescribedBytes(), 0U);
    while (!scene.geometry.empty()) {
        sizes.Erase(&scene.geometry, std::string(scene.geometry.begin()->first));
    }
    while (!scene.instancers.empty()) {
        sizes.Erase(&scene.instancers, std::string(scene.instancers.begin()->first));
    }
    ExpectRecounted(sizes, scene);
    EXPECT_EQ(sizes.DescribedBytes(), 0U);
}

TEST(SceneSizes, CountTheArraysOfAPrimByWhatTheyAreFor) {
    SceneDescription scene;
    SceneSizes sizes;
    auto mesh = std::make_shared<GeometryDescription>();
    mesh->points = std::vector<float>(30);
    GeometryPrim prim;
    prim.geometry = std::move(mesh);
    prim.placement.instances = std::vector<std::int32_t>(5);
    sizes.Set(&scene.geometry, "/a", prim);
    EXPECT_EQ(sizes.Arrays().geometryBytes, 120U);
    EXPECT_EQ(sizes.Arrays().instanceBytes, 20U);
    InstancerPrim instancer;
    instancer.instanceTransforms = std::vector<double>(32);
    sizes.Set(&scene.instancers, "/b", instancer);
    EXPECT_EQ(sizes.Arrays().geometryBytes, 120U);
    EXPECT_EQ(sizes.Arrays().instanceBytes, 276U);
}

} // namespace
} // namespace hds
