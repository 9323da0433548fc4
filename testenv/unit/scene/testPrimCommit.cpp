// SPDX-License-Identifier: Apache-2.0
// Commits that keep what earlier ones have made of prims, against first commits of the same scene.
#include "hdStream/base/error.h"
#include "hdStream/scene/primCommit.h"
#include "hdStream/scene/primEdits.h"
#include "testenv/support/sessionScene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

namespace hds {
namespace {

using test::Move;

template <typename Values>
std::string BytesOf(const Values& values) {
    return {reinterpret_cast<const char*>(values.data()),
            values.size() * sizeof(typename Values::value_type)};
}

/// Placed meshes of two materials, one that emits, instances, and two lights.
SceneDescription MakeScene() {
    SceneDescription scene;
    int primId = 0;
    const auto add = [&](const char* path, const char* material, double x) {
        GeometryPrim prim;
        prim.geometry = test::MakeGrid(3, 0.2F);
        prim.materialPath = material;
        prim.placement.worldFromObject = Move(x, 0.0, 0.0);
        prim.primId = ++primId;
        scene.geometry[path] = prim;
    };
    scene.materials["/red"] = test::MakeMaterial(0.8F, 0.1F, 0.1F);
    scene.materials["/blue"] = test::MakeMaterial(0.1F, 0.1F, 0.8F);
    scene.materials["/glow"] = test::MakeMaterial(0.1F, 0.1F, 0.1F, 4.0F);
    add("/a", "/red", -2.0);
    add("/b", "/red", 0.0);
    add("/c", "/blue", 2.0);
    add("/lamp", "/glow", 4.0);
    add("/none", "/red", 6.0);
    scene.geometry["/none"].placement.visible = false;
    add("/many/leaf", "/red", 0.0);
    test::AddInstancesAndSun("/many", scene.geometry["/many/leaf"], &scene);
    return scene;
}

class PrimCommitTest : public ::testing::Test {
protected:
    void SetUp() override {
        options.purposes = {"default"};
        options.subdivision = Subdivision::Cage;
        cache.contentVersion = 1;
        Commit();
    }

    std::unique_ptr<CommittedScene> Commit() {
        auto result = CommitScene(scene, options, &cache, warnings);
        EXPECT_NE(result, nullptr);
        return result;
    }

    /// Commits the scene as it is now, by the cache and as the first of another one.
    /// \return whether the prims of before were kept.
    bool CommitBoth() {
        const std::shared_ptr<PrimCommit> before = cache.prims; // lives on: no other has its place
        kept = Commit();
        first = CommitScene(scene, options, &other, warnings);
        return before != nullptr && cache.prims == before;
    }

    /// All that reaches the device, but for pages.
    void ExpectSameTables() const {
        EXPECT_EQ(BytesOf(kept->topNodes), BytesOf(first->topNodes));
        EXPECT_EQ(BytesOf(kept->objects), BytesOf(first->objects));
        EXPECT_EQ(BytesOf(kept->prims), BytesOf(first->prims));
        EXPECT_EQ(BytesOf(kept->primMaterials), BytesOf(first->primMaterials));
        EXPECT_EQ(BytesOf(kept->materials), BytesOf(first->materials));
        EXPECT_EQ(BytesOf(kept->programs), BytesOf(first->programs));
        EXPECT_EQ(BytesOf(kept->instances), BytesOf(first->instances));
        EXPECT_EQ(BytesOf(kept->instancesByPath), BytesOf(first->instancesByPath));
        EXPECT_EQ(BytesOf(kept->motionKeys), BytesOf(first->motionKeys));
        EXPECT_EQ(BytesOf(kept->lightByEntry), BytesOf(first->lightByEntry));
        EXPECT_EQ(BytesOf(kept->lights->lights), BytesOf(first->lights->lights));
        EXPECT_EQ(BytesOf(kept->lights->nodes), BytesOf(first->lights->nodes));
        ExpectSameDescription();
    }

    /// What is said of the whole scene.
    void ExpectSameDescription() const {
        EXPECT_EQ(kept->centre, first->centre);
        EXPECT_EQ(kept->hasCutouts, first->hasCutouts);
        EXPECT_EQ(kept->hasMotion, first->hasMotion);
        EXPECT_EQ(kept->hasCatchers, first->hasCatchers);
        EXPECT_EQ(kept->hasRayVisibility, first->hasRayVisibility);
        EXPECT_EQ(kept->hasCurves, first->hasCurves);
        EXPECT_EQ(kept->lobes, first->lobes);
        EXPECT_EQ(kept->counts.meshes, first->counts.meshes);
        EXPECT_EQ(kept->counts.instances, first->counts.instances);
        EXPECT_EQ(kept->counts.triangles, first->counts.triangles);
        EXPECT_EQ(kept->counts.emissiveTriangles, first->counts.emissiveTriangles);
        EXPECT_EQ(kept->lights->lights.size(), first->lights->lights.size());
    }

    Warnings warnings;
    SceneDescription scene = MakeScene();
    CommitOptions options;
    CommitCache cache{warnings};
    CommitCache other{warnings};
    std::unique_ptr<CommittedScene> kept;  ///< by the cache
    std::unique_ptr<CommittedScene> first; ///< by one that counts no edits
};

TEST_F(PrimCommitTest, NumbersOfMaterialsLeaveIt) {
    const auto give = [&](const char* path, std::shared_ptr<const MaterialNetwork> network) {
        scene.materials[path] = std::move(network);
        cache.prims->recoloured.insert(path);
        return CommitBoth();
    };
    EXPECT_TRUE(give("/red", test::MakeMaterial(0.7F, 0.2F, 0.1F)));
    ExpectSameTables();
    EXPECT_TRUE(give("/blue", test::MakeMaterial(0.2F, 0.2F, 0.9F)));
    ExpectSameTables();
    EXPECT_FALSE(give("/glow", test::MakeMaterial(0.2F, 0.2F, 0.9F, 2.0F))) << "lights";
    ExpectSameTables();
    EXPECT_FALSE(give("/red", test::MakeMaterial(0.7F, 0.2F, 0.1F, 1.0F))) << "begins to glow";
    ExpectSameTables();
    EXPECT_FALSE(give("/red", test::MakeMaterial(0.7F, 0.2F, 0.1F)));
    EXPECT_TRUE(give("/red", test::MakeMaterial(0.6F, 0.2F, 0.1F)));
    EXPECT_FALSE(give("/red", test::MakeAmountReader())) << "reads a primvar";
    ExpectSameTables();
    EXPECT_FALSE(give("/red", scene.materials["/blue"]));
    ExpectSameTables();
    EXPECT_FALSE(give("/red", test::MakeMaterial(0.6F, 0.2F, 0.1F))) << "has blue's record";
    ExpectSameTables();
    scene.volumes["/smoke"];
    EXPECT_FALSE(give("/red", test::MakeMaterial(0.5F, 0.2F, 0.1F))) << "what fills a volume";
}

TEST_F(PrimCommitTest, PlacesAndLightsLeaveIt) {
    const std::vector<std::function<void()>> edits = {
        [] {},
        [&] { scene.geometry["/a"].placement.worldFromObject = Move(-2.0, 3.0, 1.0); },
        [&] { scene.geometry["/lamp"].placement.worldFromObject = Move(1.0, 3.0, 1.0); },
        [&] { scene.geometry["/b"].placement.worldFromObject = glm::dmat4(0.0); }, // singular
        [&] { scene.geometry["/b"].placement.worldFromObject = Move(1e6, 0.0, 0.0); },
        [&] { scene.instancers["/many"].placement.worldFromObject = Move(0.0, 0.0, 2.0); },
        [&] {
            scene.instancers["/many"].instanceTransforms.translations =
                std::vector<float>{0, 5, 0, 0, 6, 0, 0, 7, 0};
        },
        [&] { scene.instancers["/many"].placement.visible = false; },
        [&] { scene.instancers["/many"].placement.visible = true; },
        [&] { scene.lights["/sun"].light.intensity = 9.0F; },
        [&] { scene.lights["/sun"].placement.worldFromObject = Move(1.0, 2.0, 3.0); },
    };
    for (std::size_t i = 0; i < edits.size(); ++i) {
        edits[i]();
        EXPECT_TRUE(CommitBoth()) << i;
        ExpectSameTables();
        EXPECT_EQ(kept->pages, Commit()->pages) << i;
    }
}

std::shared_ptr<GeometryDescription> Copy(const GeometryPrim& prim) {
    return std::make_shared<GeometryDescription>(*prim.geometry);
}

TEST_F(PrimCommitTest, ShapesLeaveAllOthers) {
    const auto reshape = [&](const char* path, int size, float bump) {
        scene.geometry[path].geometry = test::MakeGrid(size, bump);
        cache.reshaped.insert(path);
    };
    const std::vector<std::function<void()>> edits = {
        [&] { reshape("/a", 3, 0.7F); },
        [&] { reshape("/lamp", 3, 0.5F); },
        [&] { reshape("/many/leaf", 3, 0.4F); },
        [&] {
            reshape("/b", 3, -0.3F);
            reshape("/c", 3, 0.9F);
            scene.geometry["/c"].placement.worldFromObject = Move(2.0, 1.0, 0.0);
        },
    };
    for (std::size_t i = 0; i < edits.size(); ++i) {
        const auto pages = Commit()->pages;
        edits[i]();
        EXPECT_TRUE(CommitBoth()) << i;
        ExpectSameTables();
        EXPECT_TRUE(cache.reshaped.empty());
        EXPECT_NE(kept->pages, pages) << i;
        std::size_t numOthers = 0;
        for (std::uint32_t page = 0; page < pages->NumPages(); ++page) {
            numOthers += kept->pages->PageId(page) != pages->PageId(page) ? 1 : 0;
        }
        EXPECT_EQ(numOthers, ChunkPages::kNumPages * (i == 3 ? 2 : 1)) << i;
    }
}

TEST_F(PrimCommitTest, ShapesOfSeveralChunksLeaveAllOthers) {
    scene.geometry["/a"].geometry = test::MakeGrid(40, 0.2F);
    options.chunkBytes = 4096;
    ++cache.contentVersion;
    CommitBoth();
    EXPECT_GT(kept->counts.chunks, scene.geometry.size());
    const auto lifted = Copy(scene.geometry["/a"]);
    std::vector<float> points(lifted->points.begin(), lifted->points.end());
    for (std::size_t i = 1; i < points.size(); i += 3) {
        points[i] += 0.5F;
    }
    lifted->points = std::move(points);
    scene.geometry["/a"].geometry = lifted;
    cache.reshaped = {"/a"};
    EXPECT_TRUE(CommitBoth()); // it is cut into as many chunks
    ExpectSameTables();
}

/// A surface and a medium that fills meshes.
std::shared_ptr<const MaterialNetwork> MakeMist() {
    auto network = std::make_shared<MaterialNetwork>(*test::MakeMaterial(0.5F, 0.5F, 0.5F));
    network->nodes.push_back({"/vdf", "ND_absorption_vdf", {}, {}});
    network->nodes.back().parameters["absorption"] = std::vector<float>{1, 2, 3};
    network->nodes.push_back({"/volume", "ND_volume", {}, {}});
    network->nodes.back().connections["vdf"] = {"/vdf", "out"};
    network->terminals["volume"] = {"/volume", "out"};
    return network;
}

TEST_F(PrimCommitTest, ValuesOfPrimvarsThatAreReadLeaveAllOthers) {
    scene.materials["/reads"] = test::MakeAmountReader();
    scene.geometry["/b"].materialPath = "/reads";
    scene.geometry["/b"].geometry = test::MakeGridOfAmounts(3, 0.2F, 1);
    ++cache.contentVersion;
    CommitBoth();
    const auto pages = kept->pages;
    scene.geometry["/b"].geometry = test::MakeGridOfAmounts(3, 0.3F, 1);
    cache.reshaped = {"/b"};
    EXPECT_TRUE(CommitBoth());
    ExpectSameTables();
    EXPECT_NE(kept->pages, pages);
}

/// A shape on which other tables depend; each is undone before the next.
TEST_F(PrimCommitTest, ShapesThatOthersDependOnMakeItAnew) {
    struct Case {
        const char* name;
        std::function<void(GeometryPrim*)> prepare;
        std::function<void(GeometryPrim*)> edit;
    };
    const auto bend = [](GeometryPrim* prim) { prim->geometry = test::MakeGrid(3, 0.6F); };
    const auto nothing = [](GeometryPrim*) {};
    const std::vector<Case> cases = {
        {"other chunks", nothing,
         [](GeometryPrim* prim) { prim->geometry = test::MakeGrid(40, 0.6F); }},
        {"nothing is left", nothing,
         [](GeometryPrim* prim) {
             const auto flat = Copy(*prim);
             flat->points = std::vector<float>(flat->points.size(), std::nanf(""));
             prim->geometry = flat;
         }},
        {"hidden", [](GeometryPrim* prim) { prim->placement.visible = false; }, bend},
        {"hidden now", nothing,
         [&](GeometryPrim* prim) {
             prim->placement.visible = false;
             bend(prim);
         }},
        {"far away", nothing,
         [](GeometryPrim* prim) { // positions are relative to another point
             const auto far = Copy(*prim);
             std::vector<float> points(far->points.begin(), far->points.end());
             for (float& value : points) {
                 value += 1e5F;
             }
             far->points = std::move(points);
             prim->geometry = far;
         }},
        {"another attribute",
         [this](GeometryPrim* prim) {
             scene.materials["/reads"] = test::MakeAmountReader();
             prim->materialPath = "/reads";
             prim->geometry = test::MakeGridOfAmounts(3, 0.2F, 1);
         },
         [](GeometryPrim* prim) { prim->geometry = test::MakeGridOfAmounts(3, 0.2F, 3); }},
        {"deforms",
         [this](GeometryPrim* prim) {
             options.shutter = {0.0, 1.0};
             const auto moving = Copy(*prim);
             moving->samples = {{0.0, moving->points}, {1.0, test::MakeGrid(3, 0.4F)->points}};
             prim->geometry = moving;
         },
         [](GeometryPrim* prim) {
             const auto moving = Copy(*prim);
             moving->points = test::MakeGrid(3, 0.3F)->points;
             prim->geometry = moving;
         }},
        {"splats",
         [](GeometryPrim* prim) {
             const auto splats = Copy(*prim);
             splats->primitives = PrimitiveKind::Splats;
             splats->faceVertexCounts = splats->faceVertexIndices = {};
             prim->geometry = splats;
         },
         [](GeometryPrim* prim) {
             const auto splats = Copy(*prim);
             splats->points = test::MakeGrid(3, 0.3F)->points;
             prim->geometry = splats;
         }},
        {"a medium",
         [this](GeometryPrim* prim) {
             scene.materials["/mist"] = MakeMist();
             prim->materialPath = "/mist";
         },
         bend},
    };
    for (const Case& one : cases) {
        scene = MakeScene();
        options = CommitOptions();
        options.purposes = {"default"};
        options.chunkBytes = 4096;
        ++cache.contentVersion;
        one.prepare(&scene.geometry["/b"]);
        Commit();
        EXPECT_TRUE(CommitBoth()) << one.name;
        one.edit(&scene.geometry["/b"]);
        cache.reshaped = {"/b"};
        EXPECT_FALSE(CommitBoth()) << one.name;
        ExpectSameTables();
        EXPECT_TRUE(cache.reshaped.empty());
    }
}

/// Arrays that were written into, say: a commit tells of them.
TEST_F(PrimCommitTest, ShapesThatCannotBeReadAgainAreOthers) {
    const GeometryPrim& after = scene.geometry["/a"];
    const SharedSpan<std::int32_t>& indices = after.geometry->faceVertexIndices;
    const auto isLeft = [&](const ArraySource::Reader& read) {
        const auto away = Copy(after);
        away->points = std::vector<float>(away->points.size(), 0.5F);
        away->faceVertexIndices = SharedSpan<std::int32_t>(
            std::make_shared<const ArraySource>("/a.faceVertexIndices", read(), read, 0));
        away->faceVertexIndices.Source()->Drop();
        GeometryPrim before = after;
        before.geometry = away;
        return LeavesAllButShape(before, after);
    };
    bool isGone = false;
    const ArraySource::Reader read = [&]() -> ArrayBytes {
        if (isGone) {
            throw Error("has been written into");
        }
        auto values =
            std::make_shared<const std::vector<std::int32_t>>(indices.begin(), indices.end());
        return {values, values->data(), values->size() * sizeof(std::int32_t)};
    };
    EXPECT_TRUE(isLeft(read));
    int numReads = 0;
    EXPECT_FALSE(isLeft([&] {
        isGone = numReads++ > 0;
        return read();
    }));
}

TEST_F(PrimCommitTest, KernelsHaveWhatMediaOfMeshesWithoutFacesNeed) {
    scene.materials["/mist"] = MakeMist();
    GeometryPrim& prim = scene.geometry["/b"];
    prim.materialPath = "/mist";
    const auto nothing = Copy(prim);
    nothing->points = std::vector<float>(nothing->points.size(), std::nanf(""));
    prim.geometry = nothing;
    ++cache.contentVersion;
    CommitBoth();
    EXPECT_TRUE(kept->hasMedia && kept->hasCutouts);
    ExpectSameDescription();
}

/// Meshes are looked at for holes while their arrays are in memory anyhow.
TEST_F(PrimCommitTest, HolesOfWhatIsFilledCostNoReading) {
    int numReads = 0;
    const auto away = std::make_shared<GeometryDescription>(*test::MakeGrid(3, 0.2F));
    const std::vector<float> points(away->points.begin(), away->points.end());
    const ArraySource::Reader read = [&]() -> ArrayBytes {
        ++numReads;
        auto values = std::make_shared<const std::vector<float>>(points);
        return {values, values->data(), values->size() * sizeof(float)};
    };
    const auto source = [&](std::uint64_t mostKeptBytes) {
        return SharedSpan<float>(
            std::make_shared<const ArraySource>("/a.points", read(), read, mostKeptBytes));
    };
    scene.materials["/mist"] = MakeMist();
    for (const bool isKept : {true, false}) { // else it is read for its first use
        away->points = source(isKept ? ArraySource::kMostKeptBytes : 0);
        away->primvars.push_back({"st", Interpolation::Vertex, 3, source(0), {}});
        const auto geometry = std::make_shared<const GeometryDescription>(*away);
        away->primvars.clear();
        for (const char* path : {"/a", "/b"}) {
            scene.geometry[path].geometry = geometry;
            scene.geometry[path].materialPath = "/red";
        }
        const auto numReadsOf = [&] {
            numReads = 0;
            ++cache.contentVersion;
            Commit();
            return numReads;
        };
        const int plain = numReadsOf();
        scene.geometry["/a"].materialPath = scene.geometry["/b"].materialPath = "/mist";
        EXPECT_LE(numReadsOf(), 1) << "of the points, once for both, and of no primvar";
        EXPECT_EQ(numReadsOf(), 0);
        // Filled from the first.
        auto again = std::make_shared<GeometryDescription>(*geometry);
        again->points = source(isKept ? ArraySource::kMostKeptBytes : 0);
        scene.geometry["/a"].geometry = scene.geometry["/b"].geometry = again;
        EXPECT_LE(numReadsOf(), plain);
    }
    const std::vector<std::string> lines = warnings.Lines();
    EXPECT_EQ(std::count_if(lines.begin(), lines.end(),
                            [](const std::string& line) {
                                return line.find("is not closed") != std::string::npos;
                            }),
              2);
}

TEST_F(PrimCommitTest, AShapeThatIsCancelledComesLater) {
    scene.geometry["/a"].geometry = test::MakeGrid(3, 0.7F);
    cache.reshaped = {"/a"};
    EXPECT_EQ(CommitScene(scene, options, &cache, warnings, [] { return true; }), nullptr);
    EXPECT_EQ(cache.reshaped.size(), 1U);
    EXPECT_TRUE(CommitBoth());
    ExpectSameTables();
}

TEST_F(PrimCommitTest, MovingInstancersLeaveIt) {
    options.shutter = {0.0, 1.0};
    CommitBoth();
    InstancerPrim& many = scene.instancers["/many"];
    many.placement.samples = {{0.0, glm::dmat4(1.0)}, {1.0, Move(0.0, 1.0, 0.0)}};
    EXPECT_TRUE(CommitBoth());
    EXPECT_TRUE(kept->hasMotion);
    ExpectSameTables();
}

TEST_F(PrimCommitTest, WhatIsHiddenAndShownAgainHasTheSamePages) {
    Placement& placement = scene.geometry["/b"].placement;
    const auto pages = Commit()->pages;
    placement.visible = false;
    EXPECT_TRUE(CommitBoth());
    ExpectSameDescription();
    EXPECT_EQ(kept->instances.size(), first->instances.size());
    EXPECT_EQ(kept->pages, pages);
    placement.worldFromObject = Move(0.0, 2.0, 0.0);
    EXPECT_TRUE(CommitBoth());
    ExpectSameDescription();
    placement.visible = true;
    EXPECT_TRUE(CommitBoth());
    EXPECT_EQ(kept->pages, pages);
    ExpectSameTables();
}

TEST_F(PrimCommitTest, ALampThatIsHiddenIsNoLight) {
    const std::uint64_t emissive = Commit()->counts.emissiveTriangles;
    EXPECT_GT(emissive, 0U);
    GeometryPrim second = scene.geometry["/lamp"]; // of the same material
    second.placement.worldFromObject = Move(0.0, 7.0, 0.0);
    second.primId = 20;
    scene.geometry["/lamp2"] = second;
    ++cache.contentVersion;
    EXPECT_FALSE(CommitBoth());
    scene.geometry["/lamp"].placement.visible = false;
    EXPECT_TRUE(CommitBoth());
    EXPECT_EQ(kept->counts.emissiveTriangles, emissive);
    ExpectSameDescription();
}

TEST_F(PrimCommitTest, WhatHiddenPrimsAloneSayIsNotSaid) {
    auto catcher = std::make_shared<GeometryDescription>(*scene.geometry["/b"].geometry);
    catcher->primvars = {
        {"hdstream:shadowCatcher", Interpolation::Constant, 1, std::vector<float>{1.0F}, {}}};
    scene.geometry["/b"].geometry = catcher;
    scene.geometry["/b"].cullStyle = CullStyle::Back; // rays may pass
    ++cache.contentVersion;
    EXPECT_FALSE(CommitBoth());
    EXPECT_TRUE(kept->hasCatchers && kept->hasCutouts);
    scene.geometry["/b"].placement.visible = false;
    EXPECT_TRUE(CommitBoth());
    EXPECT_FALSE(kept->hasCatchers || kept->hasCutouts);
    ExpectSameDescription();
}

/// What makes the prims anew; each is undone before the next.
TEST_F(PrimCommitTest, IsMadeAnewWhereItWouldNotBeTheSame) {
    struct Case {
        const char* name;
        std::function<void()> edit;
    };
    const auto setVisible = [&](const char* path, bool isVisible) {
        scene.geometry[path].placement.visible = isVisible;
    };
    const std::vector<Case> cases = {
        {"another edit", [&] { ++cache.contentVersion; }},
        {"another option", [&] { options.cullStyle = CullStyle::Back; }},
        {"what was never visible", [&] { setVisible("/none", true); }},
        {"the last prim of a material", [&] { setVisible("/c", false); }},
        {"numbers by order",
         [&] {
             scene.geometry["/a"].primId = -1;
             ++cache.contentVersion;
             Commit();
             setVisible("/b", false);
         }},
        {"names", // of a Cryptomatte
         [&] {
             options.keepsNames = true;
             Commit();
             setVisible("/b", false);
         }},
    };
    for (const Case& one : cases) {
        scene = MakeScene();
        options = CommitOptions();
        options.purposes = {"default"};
        ++cache.contentVersion;
        Commit();
        EXPECT_TRUE(CommitBoth()) << one.name;
        one.edit();
        EXPECT_FALSE(CommitBoth()) << one.name;
        ExpectSameDescription();
        EXPECT_EQ(BytesOf(kept->prims), BytesOf(first->prims)) << one.name;
    }
}

TEST_F(PrimCommitTest, SubdividedMeshesThatComeNearerAreFiner) {
    auto ball = std::make_shared<GeometryDescription>(*scene.geometry["/b"].geometry);
    ball->subdivisionScheme = "catmullClark";
    scene.geometry["/b"].geometry = ball;
    options.subdivision = Subdivision::Adaptive;
    DicingCamera& camera = options.dicingCamera.emplace();
    camera.worldFromCamera = Move(0.0, 0.0, 30.0);
    camera.imageSize = glm::dvec2(64.0);
    ++cache.contentVersion;
    CommitBoth();
    scene.geometry["/a"].placement.worldFromObject = Move(0.0, 0.0, 25.0); // has no scheme
    EXPECT_TRUE(CommitBoth());
    ExpectSameTables();
    const std::uint64_t before = kept->counts.triangles;
    scene.geometry["/b"].placement.worldFromObject = Move(0.0, 0.0, 27.0);
    EXPECT_FALSE(CommitBoth());
    EXPECT_GT(kept->counts.triangles, before);
    ExpectSameTables();
}

TEST_F(PrimCommitTest, LinksAreNumberedAnew) {
    scene.lights["/sun"].links.lightLink = "lit";
    scene.geometry["/a"].categories = {"lit"};
    ++cache.contentVersion;
    CommitBoth();
    EXPECT_EQ(cache.prims, nullptr);
    scene.geometry["/a"].placement.worldFromObject = Move(0.0, 0.0, 2.0);
    EXPECT_FALSE(CommitBoth());
    ExpectSameTables();
}

TEST_F(PrimCommitTest, IsNotKeptWhereNobodyCountsEdits) {
    cache.contentVersion = 0;
    EXPECT_FALSE(CommitBoth());
    EXPECT_EQ(cache.prims, nullptr);
    EXPECT_FALSE(CommitBoth());
}

TEST_F(PrimCommitTest, ACommitThatWasCancelledLeavesNothingHalfMade) {
    ++cache.contentVersion;
    EXPECT_EQ(CommitScene(scene, options, &cache, warnings, [] { return true; }), nullptr);
    EXPECT_FALSE(CommitBoth());
    ExpectSameTables();
    scene.geometry["/a"].placement.worldFromObject = Move(0.0, 3.0, 1.0);
    EXPECT_EQ(CommitScene(scene, options, &cache, warnings, [] { return true; }), nullptr);
    EXPECT_TRUE(CommitBoth());
    ExpectSameTables();
}

} // namespace
} // namespace hds
