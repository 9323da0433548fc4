// SPDX-License-Identifier: Apache-2.0
// A session that was edited gives the bits of a fresh session with the same scene, whatever it kept
// from the renders before; edits that leave geometry alone build none.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include <functional>

namespace hds::test {
namespace {

using Edit = std::function<void(Session&)>;

std::vector<ImageLayer> RenderOf(Session* session, const Settings& settings) {
    EXPECT_EQ(session->Render(settings), RenderResult::Complete);
    return session->Layers();
}

GeometryPrim MeshOf(const Session& session, const std::string& path) {
    return session.Scene().geometry.at(path);
}

/// In the last render: built, or found in the persistent cache, where an earlier run of the test
/// may have left them.
std::uint64_t ChunksPrepared(const Session& session) {
    const auto statistics = nlohmann::json::parse(session.Statistics());
    return statistics["geometry"]["chunksBuilt"].get<std::uint64_t>() +
           statistics["geometry"]["chunksFromCache"].get<std::uint64_t>();
}

struct NamedEdit {
    const char* name;
    bool buildsGeometry;
    bool changesImage;
    Edit apply;
};

std::vector<NamedEdit> MakeEdits() {
    const auto mesh = [](const char* path, auto change) {
        return [path, change](Session& session) {
            GeometryPrim prim = MeshOf(session, path);
            change(&prim);
            session.SetGeometry(path, prim);
        };
    };
    return {
        {"transform", false, true,
         mesh("/ball",
              [](GeometryPrim* p) { p->placement.worldFromObject = Move(-0.5, 1.2, 0.5); })},
        {"material", false, true, mesh("/ball", [](GeometryPrim* p) { p->materialPath = "/red"; })},
        {"material edit", false, true,
         [](Session& s) { s.SetMaterial("/red", MakeMaterial(0.1F, 0.7F, 0.2F)); }},
        {"hide", false, true, mesh("/wall", [](GeometryPrim* p) { p->placement.visible = false; })},
        {"emissive", false, true,
         mesh("/ball", [](GeometryPrim* p) { p->materialPath = "/glow"; })},
        {"show", false, true, mesh("/wall", [](GeometryPrim* p) { p->placement.visible = true; })},
        {"purpose", false, true, mesh("/ball", [](GeometryPrim* p) { p->purpose = "guide"; })},
        {"purpose back", false, true,
         mesh("/ball", [](GeometryPrim* p) { p->purpose = "default"; })},
        {"light", false, true,
         [](Session& s) {
             LightPrim light = s.Scene().lights.at("/lamp");
             light.light.intensity = 40.0F;
             light.placement.worldFromObject = Move(-1.0, 3.0, 1.0);
             s.SetLight("/lamp", light);
         }},
        {"light off", false, true, [](Session& s) { s.Remove("/sun"); }},
        {"camera", false, true,
         [](Session& s) {
             CameraPrim camera = s.Scene().cameras.at("/camera");
             camera.worldFromCamera = Move(0.0, 1.5, 7.0);
             s.SetCamera("/camera", camera);
         }},
        {"instances", false, true,
         mesh("/many/leaf",
              [](GeometryPrim* p) {
                  p->placement.instances = std::vector<std::int32_t>{2, 4};
              })},
        {"cull", false, true,
         mesh("/ground", [](GeometryPrim* p) { p->cullStyle = CullStyle::Front; })},
        {"cull back", false, true,
         mesh("/ground", [](GeometryPrim* p) { p->cullStyle = CullStyle::DontCare; })},
        {"primId", false, true, mesh("/ground", [](GeometryPrim* p) { p->primId = 77; })},
        {"points", true, true,
         mesh("/ball", [](GeometryPrim* p) { p->geometry = MakeGrid(12, 0.1F); })},
        {"topology", true, true,
         mesh("/ball", [](GeometryPrim* p) { p->geometry = MakeGrid(40, 0.3F); })},
        {"add", true, true,
         [](Session& s) {
             GeometryPrim prim;
             prim.geometry = MakeQuad();
             prim.placement.worldFromObject = Move(0.7, 0.6, 2.0);
             s.SetGeometry("/added", prim);
         }},
        {"remove", false, true, [](Session& s) { s.Remove("/ground"); }},
        {"nothing", false, false, [](Session&) {}},
    };
}

class SessionEdits : public DeviceFixture {};

TEST_F(SessionEdits, GiveTheBitsOfAFreshSession) {
    const Settings settings = MakeSettings();
    const std::vector<NamedEdit> edits = MakeEdits();
    Session edited;
    FillSession(&edited);
    std::vector<ImageLayer> before = RenderOf(&edited, settings);
    for (std::size_t i = 0; i < edits.size(); ++i) {
        edits[i].apply(edited);
        const std::vector<ImageLayer> after = RenderOf(&edited, settings);
        Session fresh;
        FillSession(&fresh);
        for (std::size_t k = 0; k <= i; ++k) {
            edits[k].apply(fresh);
        }
        EXPECT_TRUE(SameLayers(after, RenderOf(&fresh, settings))) << edits[i].name;
        EXPECT_EQ(!SameLayers(after, before), edits[i].changesImage) << edits[i].name;
        EXPECT_EQ(ChunksPrepared(edited) > 0, edits[i].buildsGeometry) << edits[i].name;
        before = after;
    }
}

// CPU devices read large tables in the memory of the scene, which goes with it: a table of another
// size must not be written there.
TEST_F(SessionEdits, ManyInstancesBecomeFewerAndMore) {
    const auto place = [](int count, Session* session) {
        InstancerPrim many = session->Scene().instancers.at("/many");
        std::vector<float> translations;
        std::vector<std::int32_t> all;
        for (int i = 0; i < count; ++i) {
            for (const int at : {i % 100, i / 100 % 20, i / 2000}) {
                translations.push_back(0.05F * static_cast<float>(at) - 2.0F);
            }
            all.push_back(i);
        }
        many.instanceTransforms = {};
        many.instanceTransforms.translations = std::move(translations);
        many.instanceTransforms.scales =
            std::vector<float>(3 * static_cast<std::size_t>(count), 0.05F);
        session->SetInstancer("/many", many);
        GeometryPrim leaf = MeshOf(*session, "/many/leaf");
        leaf.placement.instances = std::move(all);
        session->SetGeometry("/many/leaf", leaf);
    };
    Session edited;
    FillSession(&edited);
    // Records begin to be large between 50 000 and 60 000.
    for (const int count : {60'000, 50'000, 70'000, 3, 61'000, 62'000}) {
        place(count, &edited);
        const std::vector<ImageLayer> after = RenderOf(&edited, MakeSettings());
        Session fresh;
        FillSession(&fresh);
        place(count, &fresh);
        EXPECT_TRUE(SameLayers(after, RenderOf(&fresh, MakeSettings()))) << count;
    }
}

TEST_F(SessionEdits, SettingsChangeWithoutTouchingTheScene) {
    Session session;
    FillSession(&session);
    Settings settings = MakeSettings();
    const std::vector<ImageLayer> first = RenderOf(&session, settings);
    EXPECT_GT(ChunksPrepared(session), 0U);
    settings.imageWidth = 37;
    settings.seed = 5;
    settings.aovs = {"color", "normal", "primvars:nothing"};
    const std::vector<ImageLayer> other = RenderOf(&session, settings);
    EXPECT_EQ(other[0].width, 37U);
    EXPECT_EQ(other.size(), 3U);
    EXPECT_TRUE(SameLayers(RenderOf(&session, MakeSettings()), first));
    EXPECT_EQ(ChunksPrepared(session), 0U);
}

TEST_F(SessionEdits, ACropHasTheBitsOfTheFullImage) {
    Session session;
    FillSession(&session);
    Settings settings = MakeSettings();
    const std::vector<ImageLayer> full = RenderOf(&session, settings);
    settings.displayWindow = {0.0, 0.0, 48.0, 32.0};
    settings.dataWindowMin = {11, 5};
    settings.imageWidth = 20;
    settings.imageHeight = 13;
    const std::vector<ImageLayer> crop = RenderOf(&session, settings);
    for (std::size_t layer = 0; layer < full.size(); ++layer) {
        for (std::uint32_t y = 0; y < 13; ++y) {
            for (std::uint32_t x = 0; x < 20; ++x) {
                const std::size_t from = std::size_t{y + 5} * 48 + (x + 11);
                const std::size_t to = std::size_t{y} * 20 + x;
                if (full[layer].isInteger) {
                    ASSERT_EQ(crop[layer].ids[to], full[layer].ids[from]);
                    continue;
                }
                const std::size_t channels = full[layer].channels.size();
                for (std::size_t c = 0; c < channels; ++c) {
                    ASSERT_EQ(crop[layer].values[to * channels + c],
                              full[layer].values[from * channels + c])
                        << full[layer].name << " at " << x << ", " << y;
                }
            }
        }
    }
}

TEST_F(SessionEdits, ClippingPlanesCutCameraRaysOnly) {
    Session session;
    FillSession(&session);
    Settings settings = MakeSettings();
    settings.aovs = {"cameraDepth", "color"};
    const std::vector<ImageLayer> whole = RenderOf(&session, settings);
    CameraPrim camera = session.Scene().cameras.at("/camera");
    camera.clippingPlanes = {glm::dvec4(0.0, 0.0, -1.0, -5.5)}; // seen: z <= -5.5
    session.SetCamera("/camera", camera);
    const std::vector<ImageLayer> cut = RenderOf(&session, settings);
    int numCut = 0;
    for (std::size_t i = 0; i < whole[0].values.size(); ++i) {
        const float depth = whole[0].values[i];
        if (depth > 5.5F * 1.0001F) {
            EXPECT_EQ(cut[0].values[i], depth);
        } else {
            EXPECT_GT(cut[0].values[i], 5.5F * 0.9999F);
            ++numCut;
        }
    }
    EXPECT_GT(numCut, 20);
    EXPECT_LT(numCut, static_cast<int>(whole[0].values.size()) - 20);
}

TEST_F(SessionEdits, CancelledWhilePreparingThenComplete) {
    Session session;
    FillSession(&session);
    const auto refuse = [](const Progress&) { return false; };
    EXPECT_EQ(session.Render(MakeSettings(), refuse), RenderResult::Stopped);
    const std::vector<ImageLayer> layers = RenderOf(&session, MakeSettings());
    Session fresh;
    FillSession(&fresh);
    EXPECT_TRUE(SameLayers(layers, RenderOf(&fresh, MakeSettings())));
}

} // namespace
} // namespace hds::test
