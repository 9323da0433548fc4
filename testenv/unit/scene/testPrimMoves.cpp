// SPDX-License-Identifier: Apache-2.0
// Tables that are mended where prims move, go and come back, and where materials and lights get
// other numbers, against first commits of the same scene.
#include "hdStream/scene/primCommit.h"
#include "kernels/shared/instanceChunk.h"
#include "testenv/support/sessionScene.h"
#include "testenv/unit/accel/bvhCheck.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <random>

namespace hds {
namespace {

using test::Move;

/// But for the numbers of prims and objects, which differ where some are hidden.
bool AreSame(shared::HdsInstance a, shared::HdsInstance b) {
    a.prim = a.object = b.prim = b.object = 0;
    return std::memcmp(&a, &b, sizeof(a)) == 0;
}

std::string Path(int index) {
    return "/grid/mesh" + std::to_string(100 + index);
}

/// Meshes of two materials side by side, with an instancer among them in the order of paths.
SceneDescription MakeScene(int numMeshes) {
    SceneDescription scene;
    scene.materials["/red"] = test::MakeMaterial(0.8F, 0.1F, 0.1F);
    scene.materials["/blue"] = test::MakeMaterial(0.1F, 0.1F, 0.8F);
    GeometryPrim prim;
    prim.geometry = test::MakeGrid(3, 0.2F);
    for (int i = 0; i < numMeshes; ++i) {
        prim.materialPath = i % 2 == 0 ? "/red" : "/blue";
        prim.placement.worldFromObject = Move(3.0 * (i % 10), 0.0, 3.0 * (i / 10)); // NOLINT: rows
        prim.primId = i;
        scene.geometry[Path(i)] = prim;
    }
    prim.primId = numMeshes;
    test::AddInstancesAndSun("/grid/mesh110/many", prim, &scene);
    return scene;
}

class PrimMoves : public ::testing::Test {
protected:
    void SetUp() override {
        options.purposes = {"default"};
        options.subdivision = Subdivision::Cage;
        cache.contentVersion = 1;
        Commit();
    }

    void Commit() {
        mended = CommitScene(scene, options, &cache, warnings);
        TakeAll();
    }

    /// As the device has it.
    void TakeAll() {
        nodes = mended->topNodes;
        instances = mended->instances;
        byPath = mended->instancesByPath;
        objects = mended->objects;
        materials = mended->materials;
        lights = mended->lights;
    }

    void Recolour(const std::string& path, int shade) {
        scene.materials[path] = test::MakeMaterial(0.1F * float(shade), 0.4F, 0.2F);
        cache.prims->recoloured.insert(path);
    }

    void Brighten(float intensity) {
        scene.lights["/sun"].light.intensity = intensity;
        edits.areLights = true;
    }

    void Reshape(const std::string& path, float bump) {
        Edit(path).geometry = test::MakeGrid(3, bump);
        cache.reshaped.insert(path);
    }

    GeometryPrim& Edit(const std::string& path) {
        edits.prims.insert(path);
        return scene.geometry.at(path);
    }

    /// \return whether the tables could be mended; else the scene is committed.
    bool Mend() {
        PlaceChanges changes;
        const bool isMended =
            cache.prims->Mend(edits, mended.get(), &changes, {}) == PrimCommit::Reshaped::Done;
        edits = {};
        if (!isMended) {
            Commit();
            return false;
        }
        for (const std::uint32_t node : changes.nodes) {
            nodes[node] = mended->topNodes[node];
        }
        if (changes.areOthers) {
            instances = mended->instances;
            byPath = mended->instancesByPath;
            objects = mended->objects;
        }
        for (const std::uint32_t record : changes.instances) {
            instances[record] = mended->instances[record];
        }
        for (const std::uint32_t record : changes.materials) {
            materials[record] = mended->materials[record];
        }
        lights = changes.areLights ? mended->lights : lights;
        return true;
    }

    /// The material of a prim.
    static const shared::HdsMaterial& MaterialOf(const CommittedScene& committed,
                                                 const std::vector<shared::HdsMaterial>& records,
                                                 std::uint32_t prim) {
        const shared::HdsPrim& one = committed.prims[prim];
        return records[(one.flags & HDS_PRIM_ONE_MATERIAL) != 0
                           ? one.flags >> HDS_PRIM_MATERIAL_SHIFT
                           : committed.primMaterials[one.materialBase]];
    }

    void ExpectLooksAsCommitted(const CommittedScene& first) const {
        std::map<std::int32_t, std::vector<std::uint32_t>> primsOfId;
        for (std::uint32_t prim = 0; prim < first.prims.size(); ++prim) {
            primsOfId[first.prims[prim].primId].push_back(prim);
        }
        for (std::uint32_t prim = 0; prim < mended->prims.size(); ++prim) {
            const std::vector<std::uint32_t>& others = primsOfId[mended->prims[prim].primId];
            if (others.size() != 1) {
                continue; // hidden, or numbered by their order
            }
            EXPECT_EQ(std::memcmp(&MaterialOf(*mended, materials, prim),
                                  &MaterialOf(first, first.materials, others[0]),
                                  sizeof(shared::HdsMaterial)),
                      0)
                << prim;
        }
        ASSERT_EQ(lights->lights.size(), first.lights->lights.size());
        EXPECT_EQ(std::memcmp(lights->lights.data(), first.lights->lights.data(),
                              lights->lights.size() * sizeof(shared::HdsLight)),
                  0);
    }

    void ExpectAsCommitted() {
        const auto first = CommitScene(scene, options, &other, warnings);
        ExpectLooksAsCommitted(*first);
        EXPECT_EQ(mended->centre, first->centre);
        EXPECT_EQ(mended->counts.meshes, first->counts.meshes);
        EXPECT_EQ(mended->counts.triangles, first->counts.triangles);
        EXPECT_EQ(mended->counts.instances, first->counts.instances);
        EXPECT_EQ(mended->hasCutouts, first->hasCutouts);
        const shared::HdsObject& tlas = objects[0];
        ASSERT_EQ(tlas.numItems, first->objects[0].numItems);
        std::vector<Bounds> boxes(instances.size() - tlas.itemBase); // of what is shown
        for (std::uint32_t rank = 0; rank < tlas.numItems; ++rank) {
            const std::uint32_t place = byPath[tlas.itemBase + rank];
            const shared::HdsInstance& record = instances[place];
            const std::uint32_t wanted = first->instancesByPath[first->objects[0].itemBase + rank];
            EXPECT_TRUE(AreSame(record, first->instances[wanted])) << rank;
            EXPECT_EQ(mended->prims[record.prim].primId,
                      first->prims[first->instances[wanted].prim].primId);
            boxes[place - tlas.itemBase] = BoxOf(record);
        }
        if (!mended->motionKeys.empty()) {
            return; // records hold keys
        }
        const std::vector<shared::HdsBvhNode> ofTlas(nodes.begin() + tlas.nodeBase, nodes.end());
        const test::BvhFacts facts = test::BvhWalker(ofTlas, boxes).Walk();
        EXPECT_EQ(facts.numMalformed, 0U);
        EXPECT_EQ(facts.numOutside, 0U);
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            EXPECT_EQ(facts.timesSeen[i], boxes[i].min.x <= boxes[i].max.x ? 1U : 0U) << i;
        }
    }

    const GeometryDescription& GeometryOf(const shared::HdsInstance& record) const {
        const std::int32_t primId = mended->prims[record.prim].primId;
        const auto found =
            std::find_if(scene.geometry.begin(), scene.geometry.end(),
                         [&](const auto& entry) { return entry.second.primId == primId; });
        return *(found == scene.geometry.end() ? scene.geometry.begin() : found)->second.geometry;
    }

    /// Of the points where the record has them.
    Bounds BoxOf(const shared::HdsInstance& record) const {
        glm::dmat4 objectFromWorld(1.0);
        for (int i = 0; i < 12; ++i) {
            objectFromWorld[i % 4][i / 4] = double{record.objectFromParent[i]};
        }
        const glm::dmat4 worldFromObject = glm::inverse(objectFromWorld);
        const SharedSpan<float>& points = GeometryOf(record).points;
        Bounds box;
        for (std::size_t i = 0; i < points.size(); i += 3) {
            const glm::dvec4 at(points[i], points[i + 1], points[i + 2], 1.0);
            const auto world = glm::vec3(worldFromObject * at);
            box.min = glm::min(box.min, world);
            box.max = glm::max(box.max, world);
        }
        return box;
    }

    Warnings warnings;
    SceneDescription scene = MakeScene(60);
    CommitOptions options;
    CommitCache cache{warnings};
    CommitCache other{warnings};
    std::unique_ptr<CommittedScene> mended;
    PrimCommit::Edits edits;
    HugeVector<shared::HdsBvhNode> nodes;
    HugeVector<shared::HdsInstance> instances;
    HugeVector<std::uint32_t> byPath;
    std::vector<shared::HdsObject> objects;
    std::vector<shared::HdsMaterial> materials;
    std::shared_ptr<const LightTable> lights;
};

TEST_F(PrimMoves, RandomChainsAreAsCommitted) {
    std::mt19937 random(3);
    const auto below = [&](int count) { return static_cast<int>(random() % unsigned(count)); };
    int numMended = 0;
    constexpr int kNumEdits = 200;
    for (int edit = 0; edit < kNumEdits; ++edit) {
        for (int k = 0; k <= below(3); ++k) {
            const std::string path = Path(below(60));
            GeometryPrim& prim = Edit(path);
            const int kind = below(5);
            if (kind == 0 && prim.placement.visible) {
                Reshape(path, 0.1F * float(below(9)));
            } else if (kind < 3) {
                prim.placement.visible = !prim.placement.visible;
            } else {
                prim.placement.worldFromObject =
                    glm::rotate(Move(0.3 * below(100), 0.1 * below(20), 0.3 * below(60)),
                                0.1 * below(60), glm::dvec3(1.0, 2.0, 0.5));
            }
        }
        if (below(4) == 0) {
            Recolour(below(2) == 0 ? "/red" : "/blue", below(12));
        }
        if (below(4) == 0) {
            Brighten(float(1 + below(9)));
        }
        numMended += Mend() ? 1 : 0;
        ExpectAsCommitted();
    }
    EXPECT_GT(numMended, kNumEdits / 3);
    EXPECT_LT(numMended, kNumEdits) << "a TLAS that has become too wide is built anew";
}

TEST_F(PrimMoves, WhatDoesNotGoThisWayIsCommitted) {
    struct Case {
        const char* name;
        std::function<void()> prepare;
        std::function<void()> edit;
    };
    const auto hide = [this](int index) { Edit(Path(index)).placement.visible = false; };
    const std::vector<Case> cases = {
        {"singular", [] {}, [&] { Edit(Path(7)).placement.worldFromObject = glm::dmat4(0.0); }},
        {"far away", [] {}, [&] { Edit(Path(7)).placement.worldFromObject = Move(0, 0, 1e5); }},
        {"the centre",
         [&] {
             for (int i = 0; i < 60; ++i) {
                 scene.geometry[Path(i)].placement.worldFromObject = Move(2e4, 3.0 * i, 0.0);
             }
             scene.geometry[Path(20)].placement.worldFromObject = Move(3.0, 0.0, 3.0);
             scene.instancers.begin()->second.placement.visible = false;
         },
         [&] { hide(20); }},
        {"was hidden", [&] { scene.geometry[Path(7)].placement.visible = false; },
         [&] { Edit(Path(7)).placement.visible = true; }},
        {"below an instancer", [] {},
         [&] { Edit("/grid/mesh110/many/leaf").placement.worldFromObject = Move(0.0, 1.0, 0.0); }},
        {"the last of a material",
         [&] {
             scene.materials["/green"] = test::MakeMaterial(0.1F, 0.8F, 0.1F);
             scene.geometry[Path(7)].materialPath = "/green";
         },
         [&] { hide(7); }},
        {"the last that rays may pass",
         [&] { scene.geometry[Path(7)].cullStyle = CullStyle::Back; }, [&] { hide(7); }},
        {"by number", [&] { scene.geometry[Path(9)].primId = -1; }, [&] { hide(7); }},
        {"beside a lamp",
         [&] {
             scene.materials["/glow"] = test::MakeMaterial(0.1F, 0.1F, 0.1F, 4.0F);
             scene.geometry[Path(9)].materialPath = "/glow";
         },
         [&] { hide(7); }},
        {"a lamp",
         [&] {
             scene.materials["/glow"] = test::MakeMaterial(0.1F, 0.1F, 0.1F, 4.0F);
             scene.geometry[Path(7)].materialPath = "/glow";
         },
         [&] { Edit(Path(7)).placement.worldFromObject = Move(1.0, 1.0, 0.0); }},
        {"moves while the shutter is open",
         [&] {
             options.shutter = {0.0, 1.0};
         },
         [&] {
             Edit(Path(7)).placement.samples = {{0.0, glm::dmat4(1.0)}, {1.0, Move(0, 1, 0)}};
         }},
        {"many", [] {},
         [&] {
             for (int i = 0; i < 9; ++i) {
                 Edit(Path(i)).placement.worldFromObject = Move(0.5, 0.5, 3.0 * i);
             }
         }},
        {"begins to glow", [] {},
         [&] {
             Recolour("/red", 3);
             scene.materials["/red"] = test::MakeMaterial(0.1F, 0.1F, 0.1F, 4.0F);
         }},
        {"a record of two materials", [&] { scene.materials["/blue"] = scene.materials["/red"]; },
         [&] { Recolour("/red", 3); }},
    };
    for (const Case& one : cases) {
        scene = MakeScene(60);
        options.shutter = Shutter();
        one.prepare();
        ++cache.contentVersion;
        Commit();
        Edit(Path(20)).placement.worldFromObject = Move(4.0, 0.5, 3.0); // which goes
        EXPECT_TRUE(Mend()) << one.name;
        one.edit();
        EXPECT_FALSE(Mend()) << one.name;
        ExpectAsCommitted();
    }
}

TEST_F(PrimMoves, LooksAreMendedWhereverInstancesLie) {
    options.instanceChunks = 1;
    ++cache.contentVersion;
    Commit();
    ASSERT_TRUE(mended->hasInstanceChunks);
    for (int shade = 0; shade < 5; ++shade) {
        Recolour("/red", shade);
        Brighten(2.0F + float(shade));
        EXPECT_TRUE(Mend());
        const auto first = CommitScene(scene, options, &other, warnings);
        ExpectLooksAsCommitted(*first);
        // Most prims lie in pages, which name materials by their numbers.
        ASSERT_EQ(materials.size(), first->materials.size());
        EXPECT_EQ(std::memcmp(materials.data(), first->materials.data(),
                              materials.size() * sizeof(shared::HdsMaterial)),
                  0);
    }
    Edit(Path(7)).placement.worldFromObject = Move(1.0, 1.0, 0.0);
    EXPECT_FALSE(Mend()) << "of places alone";
}

TEST_F(PrimMoves, WhoCancelsLeavesAllAsItWas) {
    Reshape(Path(7), 0.5F);
    Edit(Path(9)).placement.visible = false;
    Recolour("/red", 5);
    PlaceChanges changes;
    const std::uint64_t numTriangles = mended->counts.triangles;
    EXPECT_EQ(cache.prims->Mend(edits, mended.get(), &changes, [] { return true; }),
              PrimCommit::Reshaped::Cancelled);
    EXPECT_EQ(mended->counts.triangles, numTriangles);
    EXPECT_TRUE(changes.materials.empty());
    EXPECT_TRUE(Mend());
    ExpectAsCommitted();
}

TEST_F(PrimMoves, WhatComesBackInAnotherShapeIsCountedOnce) {
    Edit(Path(8)).placement.visible = false;
    ASSERT_TRUE(Mend());
    // Of as many points fewer triangles: a face without area has none.
    GeometryPrim& prim = Edit(Path(8));
    const auto pinched = std::make_shared<GeometryDescription>(*prim.geometry);
    std::vector<float> points(prim.geometry->points.begin(), prim.geometry->points.end());
    for (std::size_t corner = 1; corner < 4; ++corner) {
        const auto [to, from] =
            std::pair{pinched->faceVertexIndices[corner], pinched->faceVertexIndices[0]};
        std::copy_n(points.begin() + std::ptrdiff_t{3} * from, 3,
                    points.begin() + std::ptrdiff_t{3} * to);
    }
    pinched->points = std::move(points);
    prim.geometry = pinched;
    prim.placement.visible = true;
    cache.reshaped.insert(Path(8));
    EXPECT_TRUE(Mend());
    ExpectAsCommitted();
}

TEST_F(PrimMoves, WhatIsNotDrawnMayBeMoved) {
    scene.geometry[Path(7)].purpose = "guide";
    scene.geometry[Path(8)].placement.visible = false;
    ++cache.contentVersion;
    Commit();
    Edit(Path(7)).placement.worldFromObject = Move(1.0, 1.0, 0.0);
    Edit(Path(8)).placement.worldFromObject = Move(1.0, 1.0, 0.0);
    EXPECT_TRUE(Mend());
    ExpectAsCommitted();
}

TEST_F(PrimMoves, OneThatLooksFromAnotherCommitIsForgotten) {
    Edit(Path(7)).placement.visible = false;
    EXPECT_TRUE(Mend());
    const auto prims = cache.prims;
    Commit(); // without it
    EXPECT_EQ(cache.prims, prims);
    ExpectAsCommitted();
    Edit(Path(8)).placement.visible = false;
    EXPECT_TRUE(Mend());
    ExpectAsCommitted();
    Edit(Path(7)).placement.visible = true;
    EXPECT_FALSE(Mend());
    ExpectAsCommitted();
}

} // namespace
} // namespace hds
