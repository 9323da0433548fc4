// SPDX-License-Identifier: Apache-2.0
// Interactive sessions keep what commits make of prims while edits only move, hide, show or reshape
// them: the bits are those of a fresh session that keeps nothing.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"

#include <nlohmann/json.hpp>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <functional>
#include <random>

namespace hds::test {
namespace {

using Edit = std::function<void(Session&)>;

Edit OfMesh(const char* path, const std::function<void(Placement*)>& change) {
    return [path, change](Session& session) {
        GeometryPrim prim = session.Scene().geometry.at(path);
        change(&prim.placement);
        session.SetGeometry(path, prim);
    };
}

Edit Reshape(const char* path, int size, float bump) {
    return [=](Session& session) {
        GeometryPrim prim = session.Scene().geometry.at(path);
        prim.geometry = MakeGrid(size, bump);
        session.SetGeometry(path, prim);
    };
}

Edit Hide(const char* path, bool isHidden) {
    return OfMesh(path, [isHidden](Placement* place) { place->visible = !isHidden; });
}

/// FillSession with numbered prims, a mesh that glows and one beside it.
void Fill(Session* session) {
    FillSession(session);
    GeometryPrim lamp = session->Scene().geometry.at("/ball");
    lamp.materialPath = "/glow";
    lamp.placement.worldFromObject = Move(2.0, 1.5, -0.5);
    session->SetGeometry("/lamp", lamp);
    GeometryPrim other = session->Scene().geometry.at("/wall");
    other.placement.worldFromObject = Move(-2.5, 0.5, 1.0);
    session->SetGeometry("/otherWall", other);
    int primId = 10;
    const auto geometry = session->Scene().geometry; // a copy: it is edited meanwhile
    for (const auto& [path, prim] : geometry) {
        GeometryPrim numbered = prim;
        numbered.primId = primId++;
        session->SetGeometry(path, numbered);
    }
}

std::vector<Edit> MakeEdits() {
    return {
        OfMesh("/ball", [](Placement* p) { p->worldFromObject = Move(-0.5, 1.2, 0.5); }),
        OfMesh("/lamp", [](Placement* p) { p->worldFromObject = Move(-2.0, 2.0, 0.0); }),
        Hide("/wall", true),
        OfMesh("/ball", [](Placement* p) { p->worldFromObject = Move(0.5, 0.7, 1.5); }),
        Hide("/wall", false),
        Hide("/lamp", true), // the last one of its material
        [](Session& s) {
            LightPrim light = s.Scene().lights.at("/lamp");
            light.light.intensity = 40.0F;
            light.placement.worldFromObject = Move(-1.0, 3.0, 1.0);
            s.SetLight("/lamp", light);
        },
        Hide("/lamp", false),
        [](Session& s) {
            InstancerPrim many = s.Scene().instancers.at("/many");
            many.placement.worldFromObject = Move(-1.5, 0.4, 0.3);
            s.SetInstancer("/many", many);
        },
        [](Session& s) {
            InstancerPrim many = s.Scene().instancers.at("/many");
            many.placement.visible = false;
            s.SetInstancer("/many", many);
        },
        [](Session& s) { s.SetMaterial("/red", MakeMaterial(0.1F, 0.7F, 0.2F)); },
        OfMesh("/otherWall", [](Placement* p) { p->worldFromObject = Move(-2.0, 0.9, 1.0); }),
        Reshape("/ball", 12, 0.2F),
        Reshape("/ball", 12, 0.1F), // as many points as before
        Reshape("/lamp", 12, 0.3F),
        [](Session& s) {
            OfMesh("/ball", [](Placement* p) { p->worldFromObject = Move(0.2, 0.9, 1.2); })(s);
            Reshape("/ball", 12, 0.6F)(s);
            Hide("/otherWall", true)(s);
        },
        OfMesh("/ball", [](Placement* p) { p->worldFromObject = Move(0.4, 0.9, 1.2); }),
        [](Session& s) {
            s.SetMaterial("/reads", MakeAmountReader());
            GeometryPrim prim = s.Scene().geometry.at("/ball");
            prim.geometry = MakeGridOfAmounts(12, 0.1F, 1);
            prim.materialPath = "/reads";
            s.SetGeometry("/ball", prim);
        },
        [](Session& s) { // values that the material reads, of the same points
            GeometryPrim prim = s.Scene().geometry.at("/ball");
            const auto bright = std::make_shared<GeometryDescription>(*prim.geometry);
            bright->primvars = MakeGridOfAmounts(12, 0.5F, 1)->primvars;
            prim.geometry = bright;
            s.SetGeometry("/ball", prim);
        },
    };
}

class PlaceEdits : public DeviceFixture {
protected:
    static Settings Interactive() {
        Settings settings = MakeSettings();
        settings.interactive = true;
        return settings;
    }

    static std::vector<ImageLayer> RenderOf(Session* session, const Settings& settings) {
        EXPECT_EQ(session->Render(settings), RenderResult::Complete);
        return session->Layers();
    }

    /// Each edit in turn, rendered by a session that lives on and by one that does not.
    static void ExpectTheBitsOfFreshSessions(const Settings& settings) {
        const std::vector<Edit> edits = MakeEdits();
        Settings fresh = settings;
        fresh.interactive = false;
        Session edited;
        Fill(&edited);
        std::vector<ImageLayer> before = RenderOf(&edited, settings);
        for (std::size_t i = 0; i < edits.size(); ++i) {
            edits[i](edited);
            const std::vector<ImageLayer> after = RenderOf(&edited, settings);
            Session other;
            Fill(&other);
            for (std::size_t k = 0; k <= i; ++k) {
                edits[k](other);
            }
            EXPECT_TRUE(SameLayers(after, RenderOf(&other, fresh))) << i;
            EXPECT_FALSE(SameLayers(after, before)) << i;
            before = after;
        }
    }
};

TEST_F(PlaceEdits, OfResidentGeometryHaveTheBitsOfAFreshSession) {
    ExpectTheBitsOfFreshSessions(Interactive());
}

TEST_F(PlaceEdits, OfStreamedGeometryHaveTheBitsOfAFreshSession) {
    Settings settings = Interactive();
    settings.residency = "stream";
    settings.chunkBytes = 4096;
    settings.geometryMemory = "48K"; // less than all: pages come and go
    ExpectTheBitsOfFreshSessions(settings);
}

/// Many small meshes beside FillSession's.
void FillWithMany(Session* session, int count) {
    Fill(session);
    session->Remove("/lamp"); // beside meshes that glow none is hidden this way
    for (int i = 0; i < count; ++i) {
        GeometryPrim prim;
        prim.geometry = MakeGrid(4, 0.2F);
        prim.materialPath = i % 3 == 0 ? "/red" : "";
        prim.placement.worldFromObject = glm::scale(
            Move(0.5 * (i % 8) - 2.0, 0.2 + 0.3 * (i / 8), 1.5), glm::dvec3(0.2)); // NOLINT: rows
        prim.primId = 100 + i;
        session->SetGeometry("/small/mesh" + std::to_string(100 + i), prim);
    }
}

/// Moves, hides, shows or reshapes a few of them, and gives a material or a light other numbers.
Edit RandomEdit(std::mt19937* random, int count) {
    return [=](Session& session) {
        const auto below = [&](int end) { return static_cast<int>((*random)() % unsigned(end)); };
        for (int k = 0; k <= below(3); ++k) {
            const std::string path = "/small/mesh" + std::to_string(100 + below(count));
            GeometryPrim prim = session.Scene().geometry.at(path);
            const int kind = below(4);
            if (kind == 0 && prim.placement.visible) {
                prim.geometry = MakeGrid(4, 0.1F * float(1 + below(9)));
            } else if (kind == 1) {
                prim.placement.visible = !prim.placement.visible;
            } else {
                prim.placement.worldFromObject =
                    glm::scale(glm::rotate(Move(0.1 * below(40) - 2.0, 0.1 * below(20), 1.5),
                                           0.1 * below(60), glm::dvec3(1.0, 2.0, 0.5)),
                               glm::dvec3(0.2));
            }
            session.SetGeometry(path, prim);
        }
        if (below(3) == 0) {
            session.SetMaterial("/red", MakeMaterial(0.1F * float(below(9)), 0.3F, 0.2F));
        }
        if (below(3) == 0) {
            LightPrim sun = session.Scene().lights.at("/sun");
            sun.light.intensity = 0.3F * float(1 + below(9));
            sun.placement.worldFromObject = glm::rotate(sun.placement.worldFromObject,
                                                        0.1 * below(6), glm::dvec3(0.0, 1.0, 0.0));
            session.SetLight("/sun", sun);
        }
    };
}

/// Two instancers below one another, whose prototypes of two prims are groups, and a lone one that
/// places one of FillWithMany's prims.
void AddGroups(Session* session) {
    const auto rows = [](int count, double step) {
        std::vector<double> transforms;
        for (int i = 0; i < count; ++i) {
            const glm::dmat4 matrix = Move(step * i, 0.1 * i, 0.05 * i);
            transforms.insert(transforms.end(), glm::value_ptr(matrix),
                              glm::value_ptr(matrix) + 16);
        }
        return transforms;
    };
    InstancerPrim outer;
    outer.placement.worldFromObject = Move(-2.0, 0.3, 0.5);
    outer.instanceTransforms = rows(4, 1.0);
    session->SetInstancer("/groups", outer);
    InstancerPrim inner;
    inner.placement.instancerPath = "/groups";
    inner.placement.instances = std::vector<std::int32_t>{0, 1, 3};
    inner.instanceTransforms = rows(3, 0.3);
    session->SetInstancer("/groups/inner", inner);
    for (int i = 0; i < 4; ++i) {
        GeometryPrim member;
        member.geometry = MakeGrid(4, 0.3F);
        member.materialPath = i % 2 == 0 ? "/red" : "";
        const bool isInner = i < 2;
        member.placement.instancerPath = isInner ? "/groups/inner" : "/groups";
        member.placement.instances =
            isInner ? std::vector<std::int32_t>{0, 2} : std::vector<std::int32_t>{0, 1, 2};
        member.placement.worldFromObject =
            glm::scale(Move(0.0, 0.2 * i, 0.2 * (i % 2)), glm::dvec3(0.12));
        member.primId = 200 + i;
        session->SetGeometry((isInner ? "/groups/inner/m" : "/groups/m") + std::to_string(i),
                             member);
    }
}

/// Moves, hides, shows or reshapes what groups hold, or moves, hides, shows or thins out what
/// places them.
void EditGroups(Session* session, std::mt19937* random) {
    const auto below = [&](int end) { return static_cast<int>((*random)() % unsigned(end)); };
    if (below(2) == 0) {
        const std::string path = below(2) == 0 ? "/groups" : "/groups/inner";
        InstancerPrim prim = session->Scene().instancers.at(path);
        const int kind = below(3);
        if (kind == 0) {
            prim.placement.visible = !prim.placement.visible;
        } else if (kind == 1) {
            prim.placement.worldFromObject = Move(0.2 * below(8) - 2.0, 0.1 * below(5), 0.5);
        } else if (path != "/groups") {
            prim.placement.instances = below(2) == 0 ? std::vector<std::int32_t>{1, 2}
                                                     : std::vector<std::int32_t>{0, 1, 3};
        }
        session->SetInstancer(path, prim);
        return;
    }
    const int member = below(4);
    const std::string path =
        (member < 2 ? "/groups/inner/m" : "/groups/m") + std::to_string(member);
    GeometryPrim prim = session->Scene().geometry.at(path);
    const int kind = below(3);
    if (kind == 0) {
        prim.geometry = MakeGrid(4, 0.1F * float(1 + below(9)));
    } else if (kind == 1) {
        prim.placement.visible = !prim.placement.visible;
    } else {
        prim.placement.worldFromObject =
            glm::scale(Move(0.1 * below(6), 0.1 * below(8), 0.0), glm::dvec3(0.12));
    }
    session->SetGeometry(path, prim);
}

/// A fresh one of what another has become by edits.
void FillAs(const Session& edited, Session* session) {
    for (const auto& [path, instancer] : edited.Scene().instancers) {
        session->SetInstancer(path, instancer);
    }
    for (const auto& [path, network] : edited.Scene().materials) {
        session->SetMaterial(path, network);
    }
    for (const auto& [path, light] : edited.Scene().lights) {
        session->SetLight(path, light);
    }
    for (const auto& [path, prim] : edited.Scene().geometry) {
        session->SetGeometry(path, prim);
    }
}

/// A chain of edits, rendered by a session that mends its tables and by ones that are fresh.
/// \return how many were mended.
int CountMended(const Settings& settings, const Settings& fresh, int numEdits) {
    constexpr int kNumMeshes = 48;
    std::mt19937 random(11);
    Session edited;
    FillWithMany(&edited, kNumMeshes);
    EXPECT_EQ(edited.Render(settings), RenderResult::Complete);
    int numMended = 0;
    for (int i = 0; i < numEdits; ++i) {
        RandomEdit(&random, kNumMeshes)(edited);
        EXPECT_EQ(edited.Render(settings), RenderResult::Complete);
        const auto geometry = nlohmann::json::parse(edited.Statistics())["geometry"];
        numMended += geometry["primsMended"].get<int>() > 0 ? 1 : 0;
        Session other;
        FillWithMany(&other, kNumMeshes);
        FillAs(edited, &other);
        EXPECT_EQ(other.Render(fresh), RenderResult::Complete);
        EXPECT_TRUE(SameLayers(edited.Layers(), other.Layers())) << i;
    }
    // The flat hierarchy, say, knows nothing of records that are hidden.
    EXPECT_EQ(edited.Render(fresh), RenderResult::Complete);
    Session other;
    FillWithMany(&other, kNumMeshes);
    FillAs(edited, &other);
    EXPECT_EQ(other.Render(fresh), RenderResult::Complete);
    EXPECT_TRUE(SameLayers(edited.Layers(), other.Layers()));
    return numMended;
}

TEST_F(PlaceEdits, ChainsThatAreMendedHaveTheBitsOfFreshSessions) {
    constexpr int kNumEdits = 24;
    const int numMended = CountMended(Interactive(), MakeSettings(), kNumEdits);
    EXPECT_GT(numMended, kNumEdits / 2);
}

TEST_F(PlaceEdits, MendedTablesOfStreamedGeometryHaveTheBitsOfFreshSessions) {
    Settings settings = Interactive();
    settings.residency = "stream";
    settings.geometryMemory = "48K";
    settings.chunkBytes = 4096;
    settings.traversal = "scalar";
    Settings fresh = settings;
    fresh.interactive = false;
    constexpr int kNumEdits = 8;
    EXPECT_GT(CountMended(settings, fresh, kNumEdits), kNumEdits / 3);
}

/// Below an instancer, and in chunks, prims are committed and the rest is mended.
TEST_F(PlaceEdits, OfInstancesInChunksHaveTheBitsOfFreshSessions) {
    Settings settings = Interactive();
    settings.instanceChunks = 1;
    settings.traversal = "scalar";
    Settings fresh = settings;
    fresh.interactive = false;
    constexpr int kNumEdits = 8;
    EXPECT_EQ(CountMended(settings, fresh, kNumEdits), 0);
    Session edited;
    Fill(&edited);
    RenderOf(&edited, settings);
    std::vector<ImageLayer> before = edited.Layers();
    for (const float shade : {0.2F, 0.6F}) {
        edited.SetMaterial("/red", MakeMaterial(shade, 0.3F, 0.2F));
        const std::vector<ImageLayer> after = RenderOf(&edited, settings);
        EXPECT_FALSE(SameLayers(after, before));
        Session other;
        Fill(&other);
        FillAs(edited, &other);
        EXPECT_TRUE(SameLayers(after, RenderOf(&other, fresh)));
        before = after;
    }
}

/// Chains of edits of all kinds in a scene with groups.
void ExpectChainsOfGroups(const Settings& settings, unsigned int seed) {
    constexpr int kNumMeshes = 24;
    constexpr int kNumEdits = 12;
    Settings fresh = settings;
    fresh.interactive = false;
    std::mt19937 random(seed);
    Session edited;
    FillWithMany(&edited, kNumMeshes);
    AddGroups(&edited);
    EXPECT_EQ(edited.Render(settings), RenderResult::Complete);
    int numOthers = 0;
    for (int i = 0; i < kNumEdits; ++i) {
        const std::vector<ImageLayer> before = edited.Layers();
        if (random() % 2 == 0) {
            EditGroups(&edited, &random);
        } else {
            RandomEdit(&random, kNumMeshes)(edited);
        }
        EXPECT_EQ(edited.Render(settings), RenderResult::Complete);
        Session other;
        FillWithMany(&other, kNumMeshes);
        FillAs(edited, &other);
        EXPECT_EQ(other.Render(fresh), RenderResult::Complete);
        EXPECT_TRUE(SameLayers(edited.Layers(), other.Layers())) << seed << " " << i;
        numOthers += SameLayers(edited.Layers(), before) ? 0 : 1;
    }
    EXPECT_GT(numOthers, kNumEdits / 3) << "the others are of what is hidden";
}

TEST_F(PlaceEdits, ChainsInScenesWithGroupsHaveTheBitsOfFreshSessions) {
    ExpectChainsOfGroups(Interactive(), 3);
    Settings streamed = Interactive();
    streamed.residency = "stream";
    streamed.geometryMemory = "64K";
    streamed.chunkBytes = 4096;
    ExpectChainsOfGroups(streamed, 4);
}

TEST_F(PlaceEdits, ChainsInScenesWithGroupsInChunksHaveTheBitsOfFreshSessions) {
    Settings settings = Interactive();
    settings.instanceChunks = 1;
    settings.traversal = "scalar";
    ExpectChainsOfGroups(settings, 5);
}

TEST_F(PlaceEdits, AShapeIsAllThatIsLoaded) {
    Session session;
    Fill(&session);
    Reshape("/ball", 12, 0.4F)(session);
    RenderOf(&session, Interactive());
    for (const float bump : {0.1F, 0.5F}) {
        Reshape("/ball", 12, bump)(session);
        RenderOf(&session, Interactive());
        const auto geometry = nlohmann::json::parse(session.Statistics())["geometry"];
        EXPECT_EQ(geometry["uploads"], 2) << "both pages of a chunk";
    }
}

TEST_F(PlaceEdits, PagesStayWhereTheyAre) {
    Session session;
    Fill(&session);
    RenderOf(&session, Interactive());
    for (const Edit& edit : {MakeEdits()[0], MakeEdits()[2], MakeEdits()[4]}) {
        edit(session);
        RenderOf(&session, Interactive());
        const auto geometry = nlohmann::json::parse(session.Statistics())["geometry"];
        EXPECT_EQ(geometry["uploads"], 0);
        EXPECT_EQ(geometry["chunksBuilt"], 0);
        EXPECT_GT(geometry["peakBytes"], 0) << "they are there";
    }
}

} // namespace
} // namespace hds::test
