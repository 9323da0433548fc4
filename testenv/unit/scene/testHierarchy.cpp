// SPDX-License-Identifier: Apache-2.0
// The hierarchy places the same leaves as a plain flattening of the instancers, and every leaf has
// a path index of its own.
#include "hdStream/scene/hierarchy.h"
#include "hdStream/scene/placements.h"

#include "hdStream/scene/transforms.h"
#include "testenv/support/drawnLeaves.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace hds {
namespace {

/// A leaf as found by walking the device tables.
struct Leaf {
    std::uint32_t prim;
    std::uint64_t pathIndex;
    std::uint32_t instanceId;
    glm::dvec3 position; ///< of the object's origin
};

glm::dmat4 MatrixOf(const float* rows) {
    glm::dmat4 matrix(1.0);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
            matrix[column][row] = rows[4 * row + column];
        }
    }
    return matrix;
}

void Walk(const Hierarchy& tables, std::uint32_t firstGroup, std::uint32_t group,
          const glm::dmat4& world, std::uint64_t offset, std::uint32_t id,
          std::vector<Leaf>* leaves) {
    const shared::HdsObject& object = tables.groups[group];
    ASSERT_EQ(object.kind & HDS_OBJECT_KIND, HDS_OBJECT_GROUP);
    std::uint64_t previous = 0;
    for (std::uint32_t i = 0; i < object.numItems; ++i) {
        const shared::HdsInstance& record =
            tables.instances[tables.instancesByPath[object.itemBase + i]];
        const std::uint64_t before =
            (std::uint64_t{record.pathOffset[1]} << 32U) | record.pathOffset[0];
        EXPECT_TRUE(i == 0 ? before == 0 : before > previous); // instancesByPath is in path order
        previous = before;
        const glm::dmat4 child = world * glm::inverse(MatrixOf(record.objectFromParent));
        const std::uint32_t childId =
            record.instanceCount == 0 ? id : id * record.instanceCount + record.instanceRank;
        if (record.prim != HDS_NONE) {
            leaves->push_back({record.prim, offset + before, childId, glm::dvec3(child[3])});
        } else {
            Walk(tables, firstGroup, record.object - firstGroup + 1, child, offset + before,
                 childId, leaves);
        }
    }
}

LeafObject UnitLeaf(std::uint32_t prim) {
    LeafObject leaf;
    leaf.object = 1 + prim;
    leaf.prim = prim;
    leaf.bounds.min = glm::vec3(-1.0F);
    leaf.bounds.max = glm::vec3(1.0F);
    return leaf;
}

/// Random stages: a few instancers, some below others, and meshes below them or free.
class RandomStage {
public:
    explicit RandomStage(unsigned seed) : _random(seed) {
        const int numInstancers = 1 + Pick(4);
        for (int i = 0; i < numInstancers; ++i) {
            InstancerPrim instancer;
            instancer.placement = RandomPlacement(i);
            std::vector<double> transforms;
            for (int k = 0; k < 1 + Pick(4); ++k) {
                const glm::dmat4 matrix = RandomTransform();
                transforms.insert(transforms.end(), glm::value_ptr(matrix),
                                  glm::value_ptr(matrix) + 16);
            }
            instancer.instanceTransforms = std::move(transforms);
            scene.instancers["/I" + std::to_string(i)] = std::move(instancer);
        }
        for (int m = 0; m < 1 + Pick(5); ++m) {
            const std::string path = "/M" + std::to_string(m);
            scene.geometry[path].placement = RandomPlacement(numInstancers);
            leaves[path] = UnitLeaf(static_cast<std::uint32_t>(m));
        }
        for (auto& [path, prim] : scene.geometry) {
            Place(&prim.placement);
        }
        for (auto& [path, prim] : scene.instancers) {
            Place(&prim.placement);
        }
    }

    SceneDescription scene;
    std::map<std::string, LeafObject> leaves;

private:
    int Pick(int count) { return static_cast<int>(_random() % static_cast<unsigned>(count)); }
    double Real() { return static_cast<double>(_random() % 2001U) / 100.0 - 10.0; }

    glm::dmat4 RandomTransform() {
        const glm::dmat4 moved =
            glm::translate(glm::dmat4(1.0), glm::dvec3(Real(), Real(), Real()));
        return glm::rotate(moved, Real(), glm::normalize(glm::dvec3(1.0, 0.5, 11.0 + Real())));
    }
    /// Below one of the instancers 0 .. limit-1, or free.
    Placement RandomPlacement(int limit) {
        Placement placement;
        placement.worldFromObject = RandomTransform();
        const int parent = Pick(limit + 1);
        if (parent < limit) {
            placement.instancerPath = "/I" + std::to_string(parent);
        }
        return placement;
    }
    void Place(Placement* placement) {
        if (placement->instancerPath.empty()) {
            return;
        }
        const InstancerPrim& instancer = scene.instancers[placement->instancerPath];
        std::vector<std::int32_t> all(instancer.instanceTransforms.Size());
        std::iota(all.begin(), all.end(), 0);
        if (Pick(2) == 0 && all.size() > 1) {
            all.erase(all.begin() + Pick(static_cast<int>(all.size()))); // a list of its own
        }
        placement->instances = std::move(all);
    }

    std::mt19937 _random;
};

Hierarchy Build(const SceneDescription& scene, const std::map<std::string, LeafObject>& leaves,
                std::uint32_t firstGroup, Warnings& warnings) {
    LightLinks links(scene);
    return BuildHierarchy(scene, test::DrawnLeaves(scene, leaves), glm::dvec3(0.0), firstGroup,
                          &links, Shutter(), warnings);
}

TEST(Hierarchy, EqualsAFlattening) {
    constexpr std::uint32_t kFirstGroup = 100;
    for (unsigned seed = 0; seed < 200; ++seed) {
        const RandomStage stage(seed);
        Warnings warnings;
        const Hierarchy tables = Build(stage.scene, stage.leaves, kFirstGroup, warnings);
        std::vector<Leaf> found;
        Walk(tables, kFirstGroup, 0, glm::dmat4(1.0), 0, 0, &found);
        ASSERT_EQ(found.size(), tables.numLeaves);
        for (std::size_t i = 0; i < found.size(); ++i) {
            EXPECT_EQ(found[i].pathIndex, i)
                << "seed " << seed; // unique, and in the order of the walk
        }
        for (const auto& [path, leaf] : stage.leaves) {
            std::vector<glm::dvec3> expected;
            ForEachPlacement(
                stage.scene, stage.scene.geometry.at(path).placement,
                [&](const glm::dmat4& world) { expected.push_back(glm::dvec3(world[3])); });
            std::vector<Leaf> ours;
            std::copy_if(
                found.begin(), found.end(), std::back_inserter(ours),
                [prim = leaf.prim](const Leaf& candidate) { return candidate.prim == prim; });
            ASSERT_EQ(ours.size(), expected.size()) << path << " seed " << seed;
            std::sort(ours.begin(), ours.end(),
                      [](const Leaf& a, const Leaf& b) { return a.instanceId < b.instanceId; });
            for (std::size_t i = 0; i < ours.size(); ++i) {
                EXPECT_EQ(ours[i].instanceId, i); // parent-major, without gaps
                EXPECT_LT(glm::length(ours[i].position - expected[i]), 1e-4)
                    << path << " seed " << seed;
            }
        }
        EXPECT_TRUE(warnings.Lines().empty());
    }
}

// In a group's space, whatever places the group.
TEST(Hierarchy, MarksWhatLiesInPlace) {
    SceneDescription scene;
    scene.geometry["/here"];
    scene.geometry["/there"].placement.worldFromObject[3][1] = 1e-3;
    InstancerPrim& instancer = scene.instancers["/I"];
    const glm::dmat4 away = glm::translate(glm::dmat4(1.0), glm::dvec3(5.0, 0.0, 0.0));
    instancer.instanceTransforms =
        std::vector<double>(glm::value_ptr(away), glm::value_ptr(away) + 16);
    for (const char* path : {"/I/here", "/I/there"}) {
        Placement& placement = scene.geometry[path].placement;
        placement.instancerPath = "/I";
        placement.instances = std::vector<std::int32_t>{0};
        placement.worldFromObject[0][0] = path[3] == 'h' ? 1.0 : -1.0;
    }
    std::map<std::string, LeafObject> leaves;
    std::vector<std::string> paths;
    for (const auto& [path, prim] : scene.geometry) {
        leaves[path] = UnitLeaf(static_cast<std::uint32_t>(paths.size()));
        paths.push_back(path);
    }
    Warnings warnings;
    const Hierarchy tables = Build(scene, leaves, 9, warnings);
    ASSERT_EQ(tables.instances.size(), 5U);
    for (const shared::HdsInstance& record : tables.instances) {
        const bool isInPlace = (record.flags & HDS_INSTANCE_IN_PLACE) != 0;
        if (record.prim == HDS_NONE) {
            EXPECT_FALSE(isInPlace);
        } else {
            EXPECT_EQ(isInPlace, paths[record.prim].find("there") == std::string::npos)
                << paths[record.prim];
        }
    }
}

TEST(Hierarchy, AMillionInstancesCostRecordsOnly) {
    SceneDescription scene;
    scene.geometry["/M"].placement.instancerPath = "/I";
    InstancerPrim& instancer = scene.instancers["/I"];
    constexpr std::size_t kCount = 1000000;
    std::vector<double> transforms(16 * kCount, 0.0);
    std::vector<std::int32_t> all(kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
        for (int k = 0; k < 4; ++k) {
            transforms[16 * i + 5 * static_cast<std::size_t>(k)] = 1.0;
        }
        transforms[16 * i + 12] = static_cast<double>(i % 1000);
        transforms[16 * i + 14] = static_cast<double>(i / 1000);
        all[i] = static_cast<std::int32_t>(i);
    }
    instancer.instanceTransforms = std::move(transforms);
    scene.geometry["/M"].placement.instances = std::move(all);
    Warnings warnings;
    const Hierarchy tables = Build(scene, {{"/M", UnitLeaf(0)}}, 2, warnings);
    EXPECT_EQ(tables.groups.size(), 1U);
    EXPECT_EQ(tables.instances.size(), kCount);
    EXPECT_LE(tables.nodes.size() * sizeof(shared::HdsBvhNode) +
                  tables.instances.size() * sizeof(shared::HdsInstance) +
                  tables.instancesByPath.size() * sizeof(std::uint32_t),
              100 * kCount);
}

TEST(Hierarchy, BadPlacementsAreDroppedAndNamed) {
    SceneDescription scene;
    scene.geometry["/singular"].placement.worldFromObject =
        glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 0.0, 0.0));
    scene.geometry["/nan"].placement.worldFromObject[3][0] = std::nan("");
    scene.geometry["/far"].placement.worldFromObject[3][1] = 1e39; // infinite as a float
    scene.geometry["/good"];
    scene.geometry["/long"].placement.worldFromObject[0][0] = 1e36;
    scene.geometry["/orphan"].placement.instancerPath = "/missing";
    std::map<std::string, LeafObject> leaves;
    std::uint32_t index = 0;
    for (const auto& [path, prim] : scene.geometry) {
        leaves[path] = UnitLeaf(index++);
    }
    Warnings warnings;
    const Hierarchy tables = Build(scene, leaves, 9, warnings);
    EXPECT_EQ(tables.numLeaves, 1U);
    std::vector<std::string> paths;
    for (const std::string& line : warnings.Lines()) {
        paths.push_back(line.substr(0, line.find(':')));
    }
    EXPECT_EQ(paths, (std::vector<std::string>{"/far", "/long", "/nan", "/orphan", "/singular"}));
}

TEST(Hierarchy, CyclesEnd) {
    SceneDescription scene;
    for (const char* path : {"/A", "/B"}) {
        InstancerPrim& instancer = scene.instancers[path];
        instancer.instanceTransforms = std::vector<double>(glm::value_ptr(glm::dmat4(1.0)),
                                                           glm::value_ptr(glm::dmat4(1.0)) + 16);
        instancer.placement.instancerPath = path[1] == 'A' ? "/B" : "/A";
        instancer.placement.instances = std::vector<std::int32_t>{0};
    }
    Warnings warnings;
    const Hierarchy tables = Build(scene, {}, 1, warnings);
    EXPECT_EQ(tables.numLeaves, 0U);
}

TEST(Transforms, WhatIsFlatBecomesAThinSheet) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> real(-1.0, 1.0);
    const auto direction = [&] {
        return glm::normalize(glm::dvec3(real(random), real(random), real(random)));
    };
    for (int i = 0; i < 2000; ++i) {
        // Any map, behind a projection along a direction.
        const double size = std::pow(10.0, 3.0 * real(random));
        const glm::dvec3 lost = direction();
        glm::dmat3 linear;
        for (int column = 0; column < 3; ++column) {
            linear[column] = size * direction();
        }
        if (std::abs(glm::determinant(linear)) < 0.01 * size * size * size) {
            continue;
        }
        const glm::dmat3 flat = linear * (glm::dmat3(1.0) - glm::outerProduct(lost, lost));
        const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), glm::dvec3(3.0, -2.0, 1.0));
        ASSERT_FALSE(IsUsableTransform(moved * glm::dmat4(flat)));
        const glm::dmat4 thick = ThickenFlat(moved * glm::dmat4(flat));
        EXPECT_TRUE(IsUsableTransform(thick));
        EXPECT_GT(glm::determinant(glm::dmat3(thick)), 0.0);
        EXPECT_EQ(thick[3], moved[3]);
        // What is not lost goes where it went; what is lost goes along the normal.
        const glm::dmat3 added = glm::dmat3(thick) - flat;
        const glm::dvec3 kept = glm::cross(lost, direction());
        EXPECT_LT(glm::length(added * kept), 1e-12 * size);
        const glm::dvec3 along = added * lost;
        EXPECT_NEAR(glm::dot(glm::normalize(along), glm::normalize(flat * kept)), 0.0, 1e-6);
        EXPECT_GT(glm::length(along), 1e-6 * size);
        EXPECT_LT(glm::length(along), 1e-4 * size);
    }
    glm::dmat4 scale(1.0);
    EXPECT_EQ(ThickenFlat(scale), scale);
    scale[1][1] = 1e-7; // thin, but no plane
    EXPECT_EQ(ThickenFlat(scale), scale);
    scale[1][1] = 1e-40; // its inverse is no float
    EXPECT_NEAR(ThickenFlat(scale)[1][1], std::ldexp(1.0, -16), 1e-12);
    scale[1][1] = scale[2][2] = 0.0; // a line
    EXPECT_EQ(ThickenFlat(scale), scale);
    scale[0][0] = 0.0; // a point
    EXPECT_EQ(ThickenFlat(scale), scale);
    scale[0][0] = std::nan("");
    EXPECT_FALSE(IsUsableTransform(ThickenFlat(scale)));
}

TEST(Transforms, BoundsHoldEveryTransformedPoint) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> real(-1.0, 1.0);
    for (int i = 0; i < 2000; ++i) {
        glm::dmat4 matrix(1.0);
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 3; ++row) {
                matrix[column][row] = real(random) * std::pow(10.0, 3.0 * real(random));
            }
        }
        Bounds box;
        box.min = glm::vec3(-1.0F, 0.0F, 3.0F);
        box.max = glm::vec3(2.0F, 0.0F, 4.0F); // flat along y
        const Bounds result = TransformBounds(matrix, box);
        for (int k = 0; k < 8; ++k) {
            const glm::dvec4 corner(k & 1 ? 2.0 : -1.0, 0.0, k & 2 ? 4.0 : 3.0, 1.0);
            const glm::dvec3 p(matrix * corner);
            for (int axis = 0; axis < 3; ++axis) {
                EXPECT_LE(result.min[axis], p[axis]);
                EXPECT_GE(result.max[axis], p[axis]);
            }
        }
    }
    EXPECT_FALSE(IsValidBounds(TransformBounds(glm::dmat4(1.0), Bounds())));
}

} // namespace
} // namespace hds
