// SPDX-License-Identifier: Apache-2.0
// Interactive sessions keep what commits make of prims while edits only move, hide, show or reshape
// them: the bits are those of a fresh session that keeps nothing.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"

#include <nlohmann/json.hpp>

#include <functional>

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
