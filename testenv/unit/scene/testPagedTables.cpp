// SPDX-License-Identifier: Apache-2.0
// What instance chunks say of prims and of what records place is what tables say, and tables do not
// grow with the number of prims then.
#include "hdStream/scene/commit.h"
#include "kernels/shared/instanceChunk.h"
#include "testenv/support/sessionScene.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace hds {
namespace {

using test::Move;

constexpr std::uint64_t kChunkBytes = 4096;
constexpr std::uint32_t kInstances = 600;

void Add(SceneDescription* scene, const std::string& path,
         std::shared_ptr<GeometryDescription> mesh, const char* material, double x) {
    GeometryPrim prim;
    prim.geometry = std::move(mesh);
    prim.materialPath = material;
    prim.placement.worldFromObject = Move(x, 0.5 * x, 0.25 * x); // small in a large scene
    prim.primId = static_cast<std::int32_t>(7 * scene->geometry.size() + 5);
    scene->geometry[path] = prim;
}

std::shared_ptr<GeometryDescription> MakeMesh(int size) {
    return std::make_shared<GeometryDescription>(*test::MakeGrid(size, 0.2F));
}

/// `numSingles` prims that none places; of these every third is left-handed, every fifth sheds back
/// faces, and with `areVaried` every seventh has two more materials and every eleventh several
/// chunks. Two prims that /I places, one of them with a subset, a large one, and one that glows.
SceneDescription MakeScene(std::uint32_t numSingles, bool areVaried) {
    SceneDescription scene;
    scene.materials["/red"] = test::MakeMaterial(0.8F, 0.1F, 0.1F);
    scene.materials["/blue"] = test::MakeMaterial(0.1F, 0.1F, 0.8F);
    scene.materials["/green"] = test::MakeMaterial(0.1F, 0.7F, 0.1F);
    scene.materials["/glow"] = test::MakeMaterial(0.1F, 0.1F, 0.1F, 4.0F);
    const auto addSubsets = [&](const std::string& path) {
        auto mesh = std::make_shared<GeometryDescription>(*scene.geometry[path].geometry);
        mesh->subsets = {{path + "/one", std::vector<std::int32_t>{0, 2}},
                         {path + "/two", std::vector<std::int32_t>{1}}};
        scene.geometry[path].geometry = mesh;
        scene.geometry[path].subsetMaterialPaths = {"/blue", "/green"};
    };
    InstancerPrim& instancer = scene.instancers["/I"];
    std::vector<float> translations;
    std::map<std::string, std::vector<std::int32_t>> placed;
    for (std::uint32_t i = 0; i < kInstances; ++i) {
        translations.insert(translations.end(),
                            {0.3F * static_cast<float>(i), 5.0F, 0.1F * static_cast<float>(i)});
        placed[i % 2 == 0 ? "/I/a" : "/I/b"].push_back(static_cast<std::int32_t>(i));
    }
    instancer.instanceTransforms.translations = std::move(translations);
    for (auto& [path, instances] : placed) {
        Add(&scene, path, MakeMesh(3), "/red", 0.0);
        scene.geometry[path].placement.instancerPath = "/I";
        scene.geometry[path].placement.instances = std::move(instances);
    }
    addSubsets("/I/b");
    Add(&scene, "/a lamp", MakeMesh(3), "/glow", 1.0);
    Add(&scene, "/large", MakeMesh(3), "/green", 0.0);
    scene.geometry["/large"].placement.worldFromObject[0][0] = 400.0;
    for (std::uint32_t i = 0; i < numSingles; ++i) {
        const std::string path = "/single" + std::to_string(i);
        const auto mesh = MakeMesh(areVaried && i % 11 == 3 ? 30 : 2 + static_cast<int>(i % 3));
        mesh->leftHanded = i % 3 == 0;
        Add(&scene, path, mesh, i % 2 == 0 ? "/red" : "/blue", 0.3 * i);
        scene.geometry[path].cullStyle = i % 5 == 0 ? CullStyle::Back : CullStyle::DontCare;
        if (areVaried && i % 7 == 1) {
            addSubsets(path);
        }
    }
    return scene;
}

struct Committed {
    SceneDescription description;
    Warnings warnings;
    CommitCache cache{warnings};
    std::unique_ptr<CommittedScene> scene;

    Committed(SceneDescription made, std::uint32_t instanceChunks) : description(std::move(made)) {
        CommitOptions options;
        options.purposes = {"default"};
        options.subdivision = Subdivision::Cage;
        options.chunkBytes = kChunkBytes;
        options.instanceChunks = instanceChunks;
        options.keepsNames = true;
        scene = CommitScene(description, options, &cache, warnings);
    }
};

/// What is said of a leaf record: of its object, its prim, and the prim's materials, by their
/// order.
using Said = std::tuple<std::string, std::int32_t, std::uint32_t, std::uint32_t, std::uint32_t,
                        std::uint32_t, std::uint32_t, std::vector<std::string>, std::string>;

/// As kernels read it. \param record of a leaf. \param ofPage the prims of its page; null: it is in
/// the table.
Said WhatIsSaid(const CommittedScene& scene, const shared::HdsInstance& record,
                const shared::HdsPrim* ofPage) {
    const std::uint32_t kind = record.object >> HDS_OBJECT_NUMBER_SHIFT;
    const std::uint32_t chunk = record.object & ((1U << HDS_OBJECT_NUMBER_SHIFT) - 1U);
    const shared::HdsObject object =
        kind >= HDS_OBJECT_CHUNK ? shared::HdsObject{kind, 0, chunk, 1} : scene.objects[chunk];
    const shared::HdsPrim& prim =
        ofPage != nullptr ? ofPage[record.lightBase] : scene.prims.at(record.prim);
    const std::string& path = scene.primPaths.at(scene.AuthoredPrim(record.prim));
    const bool hasSubsets =
        path == "/I/b" || (path.rfind("/single", 0) == 0 && std::stoi(path.substr(7)) % 7 == 1);
    std::vector<std::string> materials;
    for (std::uint32_t entry = 0; entry < (hasSubsets ? 3U : 1U); ++entry) {
        const std::uint32_t material = (prim.flags & HDS_PRIM_ONE_MATERIAL) != 0
                                           ? prim.flags >> HDS_PRIM_MATERIAL_SHIFT
                                           : scene.primMaterials.at(prim.materialBase + entry);
        const shared::HdsMaterial& found = scene.materials.at(material);
        materials.emplace_back(reinterpret_cast<const char*>(&found), sizeof(found));
        materials.push_back(
            scene.entryMaterials.at(scene.AuthoredEntry(prim.materialBase + entry)));
    }
    std::string attributes;
    for (const AttributeName& name : *scene.primAttributes.at(record.prim)) {
        attributes += name.name + " ";
    }
    return {path,
            prim.primId,
            prim.flags & (HDS_PRIM_ONE_MATERIAL - 1U),
            prim.numPrimvars,
            object.kind,
            object.itemBase - scene.pages->NumOuterPages() / 2,
            object.numItems,
            materials,
            attributes};
}

/// By path offset. All groups are the TLAS here.
std::map<std::uint64_t, Said> AllThatIsSaid(const CommittedScene& scene) {
    std::map<std::uint64_t, Said> all;
    const auto add = [&](const shared::HdsInstance& record, const shared::HdsPrim* ofPage) {
        const std::uint64_t path =
            std::uint64_t{record.pathOffset[1]} << 32U | record.pathOffset[0];
        EXPECT_TRUE(all.emplace(path, WhatIsSaid(scene, record, ofPage)).second);
    };
    for (const shared::HdsInstance& record : scene.instances) {
        if (record.prim != HDS_NONE) {
            add(record, nullptr);
            continue;
        }
        // A stand-in: the TLAS places no groups.
        EXPECT_EQ(record.object >> HDS_OBJECT_NUMBER_SHIFT, HDS_OBJECT_INSTANCES);
        const std::uint32_t page = 2 * (record.object & ((1U << HDS_OBJECT_NUMBER_SHIFT) - 1U));
        EXPECT_LT(page, scene.pages->NumOuterPages());
        const std::uint64_t bound = scene.pages->PageBytes(page);
        scene.pages->Prepare({page});
        EXPECT_LE(scene.pages->PageBytes(page), bound);
        const std::uint8_t* bytes = scene.pages->Page(page);
        shared::HdsPageHeader header{};
        std::memcpy(&header, bytes, sizeof(header));
        const auto at = [bytes](std::uint32_t offset) {
            return bytes + std::size_t{offset} * HDS_POOL_UNIT_BYTES;
        };
        const auto* prims = reinterpret_cast<const shared::HdsPrim*>(at(header.vertices));
        const auto* records = reinterpret_cast<const shared::HdsInstance*>(at(header.triangles));
        const std::uint32_t count = header.numTriangles & ((1U << HDS_PRIMITIVE_SHIFT) - 1U);
        EXPECT_GT(count, 0U);
        EXPECT_EQ(header.primIds, 0U) << "the TLAS";
        for (std::uint32_t i = 0; i < count; ++i) {
            add(records[i], prims);
        }
    }
    return all;
}

TEST(PagedTables, SayWhatTablesSaid) {
    const Committed tables(MakeScene(200, true), 0);
    const Committed chunks(MakeScene(200, true), 100);
    ASSERT_FALSE(tables.scene->hasInstanceChunks);
    ASSERT_TRUE(chunks.scene->hasInstanceChunks);
    ASSERT_GT(chunks.scene->pages->NumOuterPages(), 20U);
    const auto wanted = AllThatIsSaid(*tables.scene);
    const auto said = AllThatIsSaid(*chunks.scene);
    EXPECT_EQ(wanted.size(), kInstances + 200 + 2);
    EXPECT_TRUE(said == wanted);
    EXPECT_EQ(chunks.scene->prims.size(), 2U) << "what glows, and what is large";
    EXPECT_EQ(chunks.scene->lightByEntry, tables.scene->lightByEntry);
    for (const shared::HdsInstance& record : chunks.scene->instances) {
        const bool glows =
            record.prim != HDS_NONE &&
            chunks.scene->primPaths[chunks.scene->AuthoredPrim(record.prim)] == "/a lamp";
        EXPECT_EQ(record.lightBase != HDS_NONE, glows);
    }
}

TEST(PagedTables, DoNotGrowWithThePrims) {
    const Committed few(MakeScene(200, false), 100);
    const Committed many(MakeScene(2000, false), 100);
    EXPECT_EQ(many.scene->objects.size(), few.scene->objects.size());
    EXPECT_EQ(many.scene->prims.size(), few.scene->prims.size());
    EXPECT_EQ(many.scene->primMaterials.size(), few.scene->primMaterials.size());
    // Of what does, the table of pages has 8 bytes a prim; what stands in for chunks of 30 more
    // has 80, 4 and about 14 of nodes.
    const std::uint64_t grown =
        many.scene->counts.alwaysResidentBytes - few.scene->counts.alwaysResidentBytes;
    EXPECT_LE(grown, 1800 * (8 + 6));
}

} // namespace
} // namespace hds
