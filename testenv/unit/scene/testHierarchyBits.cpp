// SPDX-License-Identifier: Apache-2.0
// The tables of the hierarchy have the bits that they always had: pictures, path indices and caches
// rest on them. The hashes are of commit 86315db, which kept a record of each instance on the way.
// Who changes the format or the builder on purpose writes the new ones here.
#include "hdStream/scene/hierarchy.h"
#include "testenv/support/drawnLeaves.h"

#include <gtest/gtest.h>

#include <random>

namespace hds {
namespace {

constexpr int kNumPrims = 3;

/// Integers only, and matrices without sines: the same bits on every machine.
class Numbers {
public:
    int Pick(int count) { return static_cast<int>(_random() % static_cast<unsigned>(count)); }
    double Real() { return static_cast<double>(_random() % 4096U) / 64.0 - 32.0; }
    glm::dmat4 Matrix(double scale) {
        glm::dmat4 matrix(1.0);
        for (int column = 0; column < 3; ++column) {
            for (int row = 0; row < 3; ++row) {
                matrix[column][row] = (column == row ? 1.0 : 0.0) + Real() / 128.0;
            }
        }
        matrix[3] = glm::dvec4(scale * Real(), scale * Real(), scale * Real(), 1.0);
        return matrix;
    }

private:
    std::mt19937 _random{11};
};

void Append(const glm::dmat4& matrix, std::vector<double>* out) {
    for (int i = 0; i < 16; ++i) {
        out->push_back(matrix[i / 4][i % 4]);
    }
}

/// Two levels of instancers: /a places two prims together and one alone, /b places /a and a prim.
SceneDescription MakeScene(int numInstances, bool moves) {
    Numbers numbers;
    SceneDescription scene;
    for (const char* path : {"/a", "/b"}) {
        InstancerPrim instancer;
        std::vector<double> transforms;
        std::vector<double> later;
        for (int i = 0; i < numInstances; ++i) {
            glm::dmat4 matrix = numbers.Matrix(4.0);
            if (i % 97 == 5) {
                matrix = glm::dmat4(0.0); // dropped
            }
            Append(matrix, &transforms);
            matrix[3] += glm::dvec4(0.125 * (i % 3), 0.25, 0.0, 0.0);
            Append(matrix, &later);
        }
        instancer.placement.worldFromObject = numbers.Matrix(1.0);
        if (moves) {
            instancer.samples = {{0.0, transforms}, {1.0, later}};
        }
        instancer.instanceTransforms = std::move(transforms);
        scene.instancers[path] = std::move(instancer);
    }
    std::vector<std::int32_t> all(static_cast<std::size_t>(numInstances));
    std::vector<std::int32_t> some;
    for (int i = 0; i < numInstances; ++i) {
        all[static_cast<std::size_t>(i)] = i;
        if (i % 3 != 1) {
            some.push_back(i % 50 == 7 ? -1 : i);
        }
    }
    const auto place = [&](Placement* placement, const char* instancer, bool takesAll) {
        placement->worldFromObject = numbers.Matrix(0.0625);
        placement->instancerPath = instancer;
        placement->instances = takesAll ? all : some;
    };
    place(&scene.geometry["/m0"].placement, "/a", true);
    place(&scene.geometry["/m1"].placement, "/a", true);
    place(&scene.geometry["/m2"].placement, "/a", false);
    place(&scene.geometry["/m3"].placement, "/b", false);
    scene.geometry["/m4"].placement.worldFromObject = numbers.Matrix(1.0);
    scene.geometry["/m5"].placement.worldFromObject = numbers.Matrix(1.0);
    scene.instancers["/a"].placement.instancerPath = "/b";
    scene.instancers["/a"].placement.instances = std::vector<std::int32_t>{0, 3, 8};
    return scene;
}

/// FNV-1a.
template <typename Values>
void Hash(const Values& values, std::uint64_t* hash) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    for (std::size_t i = 0; i < values.size() * sizeof(values[0]); ++i) {
        *hash = (*hash ^ bytes[i]) * 0x100000001b3U;
    }
}

std::uint64_t HashOf(const SceneDescription& scene) {
    std::map<std::string, LeafObject> leaves;
    for (const auto& [path, prim] : scene.geometry) {
        LeafObject leaf;
        leaf.prim = static_cast<std::uint32_t>(leaves.size());
        leaf.object = 1 + leaf.prim % kNumPrims;
        leaf.flags = leaf.prim % 2 == 0 ? HDS_INSTANCE_SEEN : HDS_INSTANCE_CAMERA;
        leaf.origin = glm::dvec3(0.5, 0.0, -0.25);
        leaf.bounds.min = glm::vec3(-0.5F, -1.0F, -0.25F);
        leaf.bounds.max = glm::vec3(0.5F, 1.0F, 0.5F);
        leaf.worldInstance = path == "/m5" || path == "/m3";
        leaves[path] = leaf;
    }
    LightLinks links(scene);
    Warnings warnings;
    const Shutter shutter{0.0, 1.0};
    const Hierarchy tables =
        BuildHierarchy(scene, test::DrawnLeaves(scene, leaves), glm::dvec3(1.0, 2.0, 3.0),
                       1 + kNumPrims, &links, shutter, warnings);
    std::uint64_t hash = 0xcbf29ce484222325U;
    Hash(tables.nodes, &hash);
    Hash(tables.groups, &hash);
    Hash(tables.instances, &hash);
    Hash(tables.instancesByPath, &hash);
    Hash(tables.motionKeys, &hash);
    for (const WorldInstance& world : tables.worldInstances) {
        Hash(std::vector<std::uint64_t>{world.pathIndex, world.instance, world.prim}, &hash);
    }
    Hash(std::vector<std::uint64_t>{tables.numLeaves, tables.depth}, &hash);
    Hash(std::vector<Bounds>{tables.bounds}, &hash);
    return hash;
}

TEST(HierarchyBits, OfFewInstances) {
    EXPECT_EQ(HashOf(MakeScene(200, false)), 451623558951046743U);
}

// So many that several tasks cut and write them.
TEST(HierarchyBits, OfManyInstances) {
    EXPECT_EQ(HashOf(MakeScene(150'000, false)), 3471489985378702306U);
}

TEST(HierarchyBits, OfInstancesThatMove) {
    EXPECT_EQ(HashOf(MakeScene(20'000, true)), 7453121217876500612U);
}

} // namespace
} // namespace hds
