// SPDX-License-Identifier: Apache-2.0
// Edits of lights with images: a session that was edited gives the bits of a fresh one with the
// same scene, in every residency; unused images are forgotten, and so are those of a flush.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"
#include "testenv/support/temporaryFolder.h"

#include <nlohmann/json.hpp>

#include <functional>

namespace hds::test {
namespace {

using Edit = std::function<void(Session&)>;

class LightEdits : public DeviceFixture {
protected:
    /// Colours of 8 bits without any order, as a portable pixmap.
    std::string WriteImage(const std::string& name, int width, int height, unsigned seed) const {
        std::string bytes =
            "P6\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
        for (int i = 0; i < width * height * 3; ++i) {
            seed = seed * 1664525U + 1013904223U;
            bytes.push_back(static_cast<char>(seed >> 24U));
        }
        WriteFile(folder.File(name), bytes);
        return folder.File(name);
    }

    static Edit Light(const std::string& path, LightType type, const std::string& image,
                      float intensity = 1.0F) {
        return [=](Session& session) {
            LightPrim prim;
            prim.light.type = type;
            prim.light.intensity = intensity;
            prim.light.width = 2.0F;
            prim.light.textureFile = {image, image, 0, 0};
            prim.placement.worldFromObject = Move(0.0, 1.5, 3.0);
            session.SetLight(path, prim);
        };
    }

    static Edit Visible(const std::string& path, bool isVisible) {
        return [=](Session& session) {
            LightPrim prim = session.Scene().lights.at(path);
            prim.placement.visible = isVisible;
            session.SetLight(path, prim);
        };
    }

    /// The ball's material reads an image, which takes a place among the scene's textures.
    static Edit TexturedBall(const std::string& image) {
        return [=](Session& session) {
            auto network = std::make_shared<MaterialNetwork>(*MakeMaterial(0.5F, 0.5F, 0.5F));
            MaterialNode texture;
            texture.path = "/texture";
            texture.identifier = "UsdUVTexture";
            texture.parameters["file"] = AssetReference{image, image, 0, 0};
            network->nodes.push_back(texture);
            network->nodes[0].connections["diffuseColor"] = {"/texture", "rgb"};
            session.SetMaterial("/textured", network);
            GeometryPrim ball = session.Scene().geometry.at("/ball");
            ball.materialPath = "/textured";
            session.SetGeometry("/ball", ball);
        };
    }

    std::vector<Edit> MakeEdits() const {
        const std::string a = WriteImage("a.ppm", 70, 35, 1);
        const std::string b = WriteImage("b.ppm", 129, 64, 2);
        const std::string c = WriteImage("c.ppm", 33, 50, 3);
        return {
            Light("/dome", LightType::Dome, a),
            Light("/panel", LightType::Rect, b, 3.0F),
            Light("/dome", LightType::Dome, b),
            TexturedBall(b),
            Light("/another", LightType::Dome, c, 0.5F),
            Visible("/dome", false),
            TexturedBall(c),
            Visible("/dome", true),
            Light("/panel", LightType::Rect, a),
            Light("/dome", LightType::Dome, folder.File("absent.ppm")),
            [](Session& session) { session.Remove("/panel"); },
            [](Session& session) { session.Remove("/another"); },
        };
    }

    static std::vector<ImageLayer> RenderOf(Session* session, const Settings& settings) {
        EXPECT_EQ(session->Render(settings), RenderResult::Complete);
        return session->Layers();
    }

    TemporaryFolder folder;
};

TEST_F(LightEdits, GiveTheBitsOfAFreshSession) {
    const std::vector<Edit> edits = MakeEdits();
    Settings resident = MakeSettings();
    resident.residency = "resident";
    Settings streamed = MakeSettings();
    streamed.residency = "stream";
    streamed.textureMemory = "64K";
    Session edited;
    FillSession(&edited);
    std::vector<ImageLayer> before = RenderOf(&edited, streamed);
    for (std::size_t i = 0; i < edits.size(); ++i) {
        edits[i](edited);
        const std::vector<ImageLayer> after = RenderOf(&edited, streamed);
        Session fresh;
        FillSession(&fresh);
        for (std::size_t k = 0; k <= i; ++k) {
            edits[k](fresh);
        }
        EXPECT_TRUE(SameLayers(after, RenderOf(&fresh, resident))) << "edit " << i;
        EXPECT_FALSE(SameLayers(after, before)) << "edit " << i;
        before = after;
    }
    EXPECT_TRUE(SameLayers(before, RenderOf(&edited, resident)));
}

TEST_F(LightEdits, FlushedImagesAreReadAgain) {
    const std::string image = WriteImage("a.ppm", 64, 32, 1);
    const auto fill = [&](Session* session) {
        FillSession(session);
        Light("/dome", LightType::Dome, image)(*session);
    };
    Settings settings = MakeSettings();
    settings.residency = "stream";
    Session session;
    fill(&session);
    const std::vector<ImageLayer> before = RenderOf(&session, settings);
    WriteImage("a.ppm", 64, 32, 2);
    EXPECT_TRUE(SameLayers(RenderOf(&session, settings), before)) << "nobody has said so";
    session.FlushTextures();
    const std::vector<ImageLayer> after = RenderOf(&session, settings);
    EXPECT_FALSE(SameLayers(after, before));
    Session fresh;
    fill(&fresh);
    EXPECT_TRUE(SameLayers(after, RenderOf(&fresh, settings)));
}

TEST_F(LightEdits, ImagesOfLightsCountAsTextures) {
    Session session;
    FillSession(&session);
    Settings settings = MakeSettings();
    settings.residency = "stream";
    const auto statisticsOf = [&] {
        RenderOf(&session, settings);
        return nlohmann::json::parse(session.Statistics())["texture"];
    };
    EXPECT_EQ(statisticsOf()["linesTotal"], 0);
    Light("/dome", LightType::Dome, WriteImage("b.ppm", 64, 32, 1))(session);
    EXPECT_EQ(statisticsOf()["lookups"], 0) << "the image is beside its distribution";
    session.Remove("/dome");
    Light("/rect", LightType::Rect, WriteImage("a.ppm", 640, 320, 1))(session);
    const nlohmann::json texture = statisticsOf();
    EXPECT_EQ(texture["textures"], 1);
    EXPECT_EQ(texture["mode"], "stream");
    // 16 x 16 texels a line, and the smaller mips.
    EXPECT_GT(texture["linesTotal"], 40 * 20);
    EXPECT_LT(texture["linesTotal"], 40 * 20 * 3 / 2);
    EXPECT_GT(texture["linesLoaded"], 0);
    EXPECT_GT(texture["lookups"], 0);
    EXPECT_GT(texture["misses"], 0);
}

} // namespace
} // namespace hds::test
