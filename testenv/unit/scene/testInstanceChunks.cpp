// SPDX-License-Identifier: Apache-2.0
// Instance chunks hold the records that the tables would hold, bit for bit, whatever becomes of the
// scene that they were made from.
#include "hdStream/scene/hierarchy.h"
#include "testenv/support/drawnLeaves.h"
#include "testenv/unit/accel/bvhCheck.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <string>

namespace hds {
namespace {

constexpr std::uint32_t kCount = 5000;
constexpr std::uint64_t kChunkBytes = 8192;

/// Objects before those of groups.
std::uint32_t FirstGroup(const SceneDescription& scene) {
    return 1 + static_cast<std::uint32_t>(scene.geometry.size());
}

/// /I places /a and /b, each by a list of its own, some of which cannot be placed, and /world in
/// records of its own; by none are placed /large and `numSingles` small prims.
SceneDescription MakeScene(unsigned seed, std::uint32_t numSingles = 1) {
    std::mt19937 random(seed);
    const auto real = [&random] { return static_cast<double>(random() % 4096U) / 64.0 - 32.0; };
    SceneDescription scene;
    std::vector<float> translations;
    for (std::uint32_t i = 0; i < 3 * kCount; ++i) {
        translations.push_back(static_cast<float>(real()));
    }
    std::vector<float> scales(3 * std::size_t{kCount}, 1.0F);
    std::vector<std::int32_t> even;
    std::vector<std::int32_t> odd;
    for (std::uint32_t i = 0; i < kCount; ++i) {
        (i % 2 == 0 ? even : odd).push_back(static_cast<std::int32_t>(i));
        if (i % 97 == 5) {
            scales[3 * std::size_t{i}] = 0.0F; // a line: dropped
            scales[3 * std::size_t{i} + 1] = 0.0F;
        }
    }
    InstancerPrim& instancer = scene.instancers["/I"];
    instancer.instanceTransforms.translations = std::move(translations);
    instancer.instanceTransforms.scales = std::move(scales);
    instancer.placement.worldFromObject[3] = glm::dvec4(real(), real(), real(), 1.0);
    const auto place = [&scene](const char* path, std::vector<std::int32_t> instances) {
        scene.geometry[path].placement.instancerPath = "/I";
        scene.geometry[path].placement.instances = std::move(instances);
    };
    place("/a", std::move(even));
    place("/b", std::move(odd));
    place("/world", {3, 7, 4});
    scene.geometry["/large"].placement.worldFromObject[3][0] = real();
    for (std::uint32_t i = 0; i < numSingles; ++i) {
        glm::dmat4& matrix =
            scene.geometry["/single" + std::to_string(i)].placement.worldFromObject;
        matrix[3] = glm::dvec4(real(), real(), real(), 1.0);
    }
    return scene;
}

/// All that by /I and by none is placed in MakeScene, in two groups, of which /Sea places the first
/// `numPlacements` times and the second, which has half of /I's instances, twice; /world as often
/// in records of its own. A third group places two prims in the first.
SceneDescription MakeNested(unsigned seed, std::uint32_t numPlacements) {
    SceneDescription scene = MakeScene(seed, 50);
    std::vector<std::int32_t> all(numPlacements);
    std::iota(all.begin(), all.end(), 0);
    InstancerPrim& sea = scene.instancers["/Sea"];
    sea.instanceTransforms.translations = std::vector<float>(3 * std::size_t{numPlacements}, 2.5F);
    const auto place = [](Placement* placement, const char* path,
                          std::vector<std::int32_t> instances) {
        placement->instancerPath = path;
        placement->instances = std::move(instances);
    };
    for (auto& [path, prim] : scene.geometry) {
        if (prim.placement.instancerPath.empty()) {
            place(&prim.placement, "/Sea", all);
        }
    }
    InstancerPrim& copy = scene.instancers["/J"];
    copy = scene.instancers["/I"];
    place(&copy.placement, "/Sea", {1, 0});
    scene.geometry["/c"].placement = scene.geometry["/a"].placement;
    scene.geometry["/c"].placement.instancerPath = "/J";
    place(&scene.instancers["/I"].placement, "/Sea", all);
    scene.instancers["/K"].instanceTransforms.translations =
        std::vector<float>{-0.5F, 0.0F, 0.25F, -0.5F, 0.0F, 0.25F}; // origins lie in the middle
    place(&scene.instancers["/K"].placement, "/I", {5, 9, 11});
    place(&scene.geometry["/d"].placement, "/K", {0, 1});
    place(&scene.geometry["/e"].placement, "/K", {0, 1});
    return scene;
}

Hierarchy Build(const SceneDescription& scene, std::uint32_t leastInstances,
                const Shutter& shutter = {}) {
    std::map<std::string, LeafObject> leaves;
    for (const auto& [path, prim] : scene.geometry) {
        LeafObject leaf;
        leaf.prim = static_cast<std::uint32_t>(leaves.size());
        leaf.object = 1 + leaf.prim;
        leaf.flags = HDS_INSTANCE_SEEN;
        leaf.origin = glm::dvec3(0.5, 0.0, -0.25);
        leaf.bounds.max = glm::vec3(path == "/large" ? 8.0F : 0.5F);
        leaf.bounds.min = -leaf.bounds.max;
        leaf.worldInstance = path == "/world";
        leaves[path] = leaf;
    }
    LightLinks links(scene);
    Warnings warnings;
    InstanceChunkOptions options;
    options.leastInstances = leastInstances;
    options.chunkBytes = kChunkBytes;
    return BuildHierarchy(scene, test::DrawnLeaves(scene, leaves), glm::dvec3(1.0, 2.0, 3.0),
                          FirstGroup(scene), &links, shutter, warnings, options);
}

std::uint64_t PathOffset(const shared::HdsInstance& record) {
    return std::uint64_t{record.pathOffset[1]} << 32U | record.pathOffset[0];
}

bool IsSame(const shared::HdsInstance& a, const shared::HdsInstance& b) {
    return std::memcmp(&a, &b, sizeof(a)) == 0;
}

bool IsBefore(const shared::HdsInstance& a, const shared::HdsInstance& b) {
    return PathOffset(a) < PathOffset(b);
}

/// All that kernels read of the hierarchy.
void ExpectSameTables(const Hierarchy& a, const Hierarchy& b) {
    const auto areSame = [](const auto& one, const auto& other) {
        return one.size() == other.size() &&
               std::memcmp(one.data(), other.data(), one.size() * sizeof(one[0])) == 0;
    };
    EXPECT_TRUE(areSame(a.nodes, b.nodes));
    EXPECT_TRUE(areSame(a.instances, b.instances));
    EXPECT_TRUE(areSame(a.instancesByPath, b.instancesByPath));
    EXPECT_TRUE(areSame(a.motionKeys, b.motionKeys));
}

/// Of a group's records those in the table that stand in for no chunk, in the order of paths.
std::vector<shared::HdsInstance> RecordsInTable(const Hierarchy& hierarchy, std::uint32_t group,
                                                std::uint32_t firstGroup,
                                                std::uint32_t* numStandIns) {
    std::vector<shared::HdsInstance> records;
    *numStandIns = 0;
    const shared::HdsObject& object = hierarchy.groups[group];
    std::uint64_t before = 0;
    for (std::uint32_t item = 0; item < object.numItems; ++item) {
        const shared::HdsInstance& record =
            hierarchy.instances[hierarchy.instancesByPath[object.itemBase + item]];
        EXPECT_LE(before, PathOffset(record));
        before = PathOffset(record);
        if (record.object >= firstGroup &&
            hierarchy.groups[record.object - firstGroup + 1].kind == HDS_OBJECT_INSTANCES) {
            EXPECT_EQ(before, ~std::uint64_t{0}) << "nobody looks for it by its path";
            ++*numStandIns;
        } else {
            records.push_back(record);
        }
    }
    return records;
}

/// The records of a page; checks its tree. \param group that they belong to.
std::vector<shared::HdsInstance> RecordsOf(const std::vector<std::uint8_t>& page,
                                           std::uint32_t group) {
    shared::HdsPageHeader header{};
    std::memcpy(&header, page.data(), sizeof(header));
    EXPECT_EQ(header.numTriangles >> HDS_PRIMITIVE_SHIFT, HDS_PRIMITIVE_INSTANCES);
    EXPECT_EQ(header.primIds, group);
    const std::size_t recordsAt = std::size_t{header.triangles} * HDS_POOL_UNIT_BYTES;
    const std::size_t count = header.numTriangles & ((1U << HDS_PRIMITIVE_SHIFT) - 1U);
    EXPECT_EQ(recordsAt + count * sizeof(shared::HdsInstance), page.size());
    std::vector<shared::HdsBvhNode> nodes((recordsAt - sizeof(header)) /
                                          sizeof(shared::HdsBvhNode));
    std::memcpy(nodes.data(), page.data() + sizeof(header), recordsAt - sizeof(header));
    std::vector<shared::HdsInstance> records(count);
    std::memcpy(records.data(), page.data() + recordsAt, count * sizeof(records[0]));
    std::vector<Bounds> boxes; // of objects of unit size that are moved only
    for (const shared::HdsInstance& record : records) {
        const float* rows = record.objectFromParent;
        const glm::vec3 centre(-rows[3], -rows[7], -rows[11]);
        boxes.push_back({centre - 0.5F, centre + 0.5F});
    }
    const test::BvhFacts facts = test::BvhWalker(nodes, boxes).Walk();
    EXPECT_EQ(facts.numMalformed, 0U);
    EXPECT_EQ(facts.numOutside, 0U);
    EXPECT_TRUE(std::all_of(facts.timesSeen.begin(), facts.timesSeen.end(),
                            [](std::uint32_t times) { return times == 1; }));
    return records;
}

TEST(InstanceChunks, HoldTheRecordsOfTheTables) {
    Hierarchy chunked;
    Hierarchy tables;
    std::uint32_t firstGroup = 0;
    {
        const SceneDescription scene = MakeScene(1, 100);
        firstGroup = FirstGroup(scene);
        tables = Build(scene, 0);
        chunked = Build(scene, kCount - 100);
    }
    const SceneDescription other = MakeScene(2); // perhaps where the first one was
    ASSERT_TRUE(tables.instanceChunks.empty());
    ASSERT_EQ(chunked.instanceChunks.size(), 1U);
    const InstanceChunks& chunks = *chunked.instanceChunks[0];
    std::uint32_t numStandIns = 0;
    std::vector<shared::HdsInstance> records = RecordsInTable(chunked, 0, firstGroup, &numStandIns);
    EXPECT_EQ(records.size(), 4U) << "world instances and what is large stay in the table";
    EXPECT_EQ(numStandIns, chunks.NumChunks());
    EXPECT_GT(chunks.NumChunks(), kCount * 80 / kChunkBytes);
    for (std::uint32_t chunk = 0; chunk < chunks.NumChunks(); ++chunk) {
        const ChunkBytes pages = chunks.Make(chunk);
        EXPECT_TRUE(pages[HDS_PAGE_ATTRIBUTES].empty());
        EXPECT_LE(pages[HDS_PAGE_GEOMETRY].size(), chunks.BoundBytes(chunk)[HDS_PAGE_GEOMETRY]);
        EXPECT_EQ(pages, chunks.Make(chunk)) << "the same whenever it is made";
        const std::vector<shared::HdsInstance> held = RecordsOf(pages[HDS_PAGE_GEOMETRY], 0);
        EXPECT_LE(held.size(), HDS_MAX_CHUNK_RECORDS);
        records.insert(records.end(), held.begin(), held.end());
    }
    std::sort(records.begin(), records.end(), IsBefore);
    std::sort(tables.instances.begin(), tables.instances.end(), IsBefore);
    ASSERT_EQ(records.size(), tables.instances.size());
    EXPECT_TRUE(std::equal(records.begin(), records.end(), tables.instances.begin(), IsSame));
    EXPECT_EQ(chunked.numLeaves, tables.numLeaves);
    EXPECT_EQ(chunked.bounds.min, tables.bounds.min);
    EXPECT_EQ(chunked.bounds.max, tables.bounds.max);
}

TEST(InstanceChunks, WorldInstancesAreFoundInTheTable) {
    const SceneDescription scene = MakeScene(3);
    const Hierarchy tables = Build(scene, 0);
    const Hierarchy chunked = Build(scene, 1);
    ASSERT_EQ(chunked.worldInstances.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(chunked.worldInstances[i].pathIndex, tables.worldInstances[i].pathIndex);
        EXPECT_TRUE(IsSame(chunked.instances[chunked.worldInstances[i].instance],
                           tables.instances[tables.worldInstances[i].instance]));
    }
}

/// Groups below the TLAS hold the records that they have in tables. \param[out] numInTable of each
/// with chunks the records beside these. \return the numbers of their objects.
std::vector<std::uint32_t> ExpectRecordsOfGroups(const Hierarchy& chunked, const Hierarchy& tables,
                                                 std::uint32_t firstGroup,
                                                 std::vector<std::size_t>* numInTable = nullptr) {
    std::uint32_t number = 0; // of the chunk among all
    std::uint32_t tablesGroup = 0;
    std::vector<std::uint32_t> owners;
    for (std::uint32_t group = 1; group < chunked.groups.size(); ++group) {
        const shared::HdsObject& object = chunked.groups[group];
        if (object.kind == HDS_OBJECT_INSTANCES) {
            EXPECT_EQ(object.itemBase, number++);
            continue;
        }
        std::uint32_t numStandIns = 0;
        std::vector<shared::HdsInstance> records =
            RecordsInTable(chunked, group, firstGroup, &numStandIns);
        const shared::HdsObject& wanted = tables.groups[++tablesGroup];
        if (numStandIns > 0) {
            if (numInTable != nullptr) {
                numInTable->push_back(records.size());
            }
            const InstanceChunks& chunks = *chunked.instanceChunks.at(owners.size());
            owners.push_back(firstGroup + group - 1);
            EXPECT_EQ(numStandIns, chunks.NumChunks());
            for (std::uint32_t chunk = 0; chunk < chunks.NumChunks(); ++chunk) {
                const auto held = RecordsOf(chunks.Make(chunk)[HDS_PAGE_GEOMETRY], owners.back());
                records.insert(records.end(), held.begin(), held.end());
            }
        }
        std::sort(records.begin(), records.end(), IsBefore);
        EXPECT_EQ(records.size(), wanted.numItems);
        for (std::uint32_t item = 0; item < std::min<std::size_t>(records.size(), wanted.numItems);
             ++item) {
            shared::HdsInstance expected =
                tables.instances[tables.instancesByPath[wanted.itemBase + item]];
            if (expected.object >= firstGroup) { // groups have other numbers
                EXPECT_GE(records[item].object, firstGroup);
                expected.object = records[item].object;
            }
            EXPECT_TRUE(IsSame(records[item], expected)) << group << " " << item;
        }
    }
    EXPECT_EQ(tablesGroup + 1, tables.groups.size());
    return owners;
}

TEST(InstanceChunks, OfGroupsHoldTheirRecords) {
    const SceneDescription scene = MakeNested(6, 4);
    const std::uint32_t firstGroup = FirstGroup(scene);
    const Hierarchy tables = Build(scene, 0);
    const Hierarchy chunked = Build(scene, 1000);
    ASSERT_EQ(chunked.instanceChunks.size(), 2U);
    EXPECT_EQ(chunked.depth, tables.depth);
    EXPECT_EQ(chunked.numLeaves, tables.numLeaves);
    ASSERT_EQ(chunked.worldInstances.size(), 12U);
    std::uint32_t numStandIns = 0;
    EXPECT_EQ(RecordsInTable(chunked, 0, firstGroup, &numStandIns).size(), 12U + 4U + 2U);
    EXPECT_EQ(numStandIns, 0U) << "the TLAS places groups that have chunks";
    std::vector<std::size_t> numInTable;
    EXPECT_EQ(ExpectRecordsOfGroups(chunked, tables, firstGroup, &numInTable).size(), 2U);
    std::sort(numInTable.begin(), numInTable.end());
    EXPECT_EQ(numInTable, (std::vector<std::size_t>{0, 1})) << "what is large";
}

/// The objects of the groups whose records lie in chunks.
std::set<std::uint32_t> OwnersOf(const Hierarchy& hierarchy) {
    std::set<std::uint32_t> owners;
    for (const std::shared_ptr<const InstanceChunks>& chunks : hierarchy.instanceChunks) {
        shared::HdsPageHeader header{};
        const ChunkBytes pages = chunks->Make(0);
        std::memcpy(&header, pages[HDS_PAGE_GEOMETRY].data(), sizeof(header));
        owners.insert(header.primIds);
    }
    return owners;
}

/// Makes an instancer's instances move while the shutter is open.
void Move(InstancerPrim* instancer) {
    std::vector<double> later;
    for (std::size_t i = 0; i < instancer->instanceTransforms.Size(); ++i) {
        glm::dmat4 matrix = instancer->instanceTransforms.At(i);
        matrix[3][0] += 1.0;
        for (int k = 0; k < 16; ++k) {
            later.push_back(matrix[k / 4][k % 4]);
        }
    }
    instancer->samples = {{0.0, instancer->instanceTransforms.Matrices()}, {1.0, std::move(later)}};
}

// By counts alone the TLAS has chunks, or else what it places.
TEST(InstanceChunks, WhatMovesGivesItsPlaceToOthers) {
    const Shutter open{0.0, 1.0};
    SceneDescription scene = MakeNested(8, 2 * kCount);
    scene.geometry.erase("/world");
    const std::uint32_t firstGroup = FirstGroup(scene);
    ASSERT_EQ(Build(scene, 1, open).instanceChunks.size(), 1U);
    Move(&scene.instancers["/Sea"]);
    const Hierarchy below = Build(scene, 1, open);
    EXPECT_EQ(ExpectRecordsOfGroups(below, Build(scene, 0, open), firstGroup).size(), 2U);
    EXPECT_EQ(below.instanceChunks.size(), 2U);
    EXPECT_GT(below.motionKeys.size(), 2 * kCount);

    // Of the two groups, which have 5000 and 2500 instances, the larger one moves.
    constexpr std::uint32_t kInRoot = 3000;
    SceneDescription other = MakeNested(8, kInRoot);
    other.geometry.erase("/world");
    const std::set<std::uint32_t> groups = OwnersOf(Build(other, kInRoot / 2, open));
    EXPECT_EQ(groups.size(), 2U);
    EXPECT_EQ(groups.count(0), 0U);
    Move(&other.instancers["/I"]);
    EXPECT_EQ(OwnersOf(Build(other, kInRoot / 2, open)), std::set<std::uint32_t>{0});
}

TEST(InstanceChunks, WhatHasTooFewAfterAllGivesItsPlaceToOthers) {
    SceneDescription scene = MakeNested(9, 2 * kCount);
    scene.geometry.erase("/world");
    const std::uint32_t firstGroup = FirstGroup(scene);
    constexpr std::uint32_t kLeast = 4000;
    std::vector<float> scales(6 * std::size_t{kCount}, 0.0F); // cannot be placed
    std::fill_n(scales.begin(), 3 * (kLeast - 3), 1.0F);      // the first two are placed twice
    scene.instancers["/Sea"].instanceTransforms.scales = std::move(scales);
    const Hierarchy below = Build(scene, kLeast);
    EXPECT_EQ(ExpectRecordsOfGroups(below, Build(scene, 0), firstGroup).size(), 1U);
    EXPECT_EQ(below.instanceChunks.size(), 1U);
}

TEST(InstanceChunks, OfNestedGroupsTheLargestHaveThem) {
    EXPECT_EQ(OwnersOf(Build(MakeNested(7, 2 * kCount), 1)), std::set<std::uint32_t>{0})
        << "the TLAS alone";
    const Hierarchy few = Build(MakeNested(7, 40), 1);
    EXPECT_EQ(few.instanceChunks.size(), 2U) << "not the TLAS, not the small group inside";
    const Hierarchy one = Build(MakeNested(7, 40), 3 * kCount / 4);
    ASSERT_EQ(one.instanceChunks.size(), 1U);
    EXPECT_GE(*OwnersOf(one).begin(), FirstGroup(MakeNested(7, 40)));
}

TEST(InstanceChunks, FewOrMovingInstancesStayInTheTable) {
    SceneDescription scene = MakeScene(4);
    const Hierarchy few = Build(scene, kCount);
    EXPECT_TRUE(few.instanceChunks.empty()) << "some of them cannot be placed";
    ExpectSameTables(few, Build(scene, 0)); // though boxes were not kept until that was known
    Move(&scene.instancers["/I"]);
    const Hierarchy moving = Build(scene, 1, Shutter{0.0, 1.0});
    EXPECT_TRUE(moving.instanceChunks.empty());
    EXPECT_GT(moving.motionKeys.size(), kCount);
    ExpectSameTables(moving, Build(scene, 0, Shutter{0.0, 1.0}));
}

TEST(InstanceChunks, TakeFourBytesAnInstanceOfTheDevice) {
    const SceneDescription scene = MakeScene(5, kCount);
    const Hierarchy chunked = Build(scene, 1);
    const std::size_t bytes = chunked.nodes.size() * sizeof(shared::HdsBvhNode) +
                              chunked.instances.size() * sizeof(shared::HdsInstance) +
                              chunked.groups.size() * sizeof(shared::HdsObject);
    EXPECT_LE(bytes, 4 * 2 * kCount) << "though chunks are small here"; // half are single prims
}

} // namespace
} // namespace hds
