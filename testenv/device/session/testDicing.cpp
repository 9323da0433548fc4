// SPDX-License-Identifier: Apache-2.0
// When a session dices anew: for each picture's camera, as a fresh session; one that is said to
// move is diced once, for all around, until Redice takes the present one.
#include "hdStream/session/session.h"
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"

#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

namespace hds::test {
namespace {

class SessionDicing : public DeviceFixture {
protected:
    void SetUp() override {
        DeviceFixture::SetUp();
        GeometryPrim prim;
        const auto mesh = std::make_shared<GeometryDescription>(*MakeGrid(6, 0.5F));
        mesh->subdivisionScheme = "catmullClark";
        prim.geometry = mesh;
        session.SetGeometry("/surface", prim);
        settings = MakeSettings();
        settings.camera = "/camera";
        settings.samples = 1;
    }

    /// Triangles after a render from a place on the z axis. \param isAway it looks away.
    std::uint64_t Triangles(double distance, bool isAway) {
        CameraPrim camera;
        camera.worldFromCamera = glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, distance));
        if (isAway) {
            camera.worldFromCamera =
                glm::rotate(camera.worldFromCamera, 3.141592653589793, glm::dvec3(0, 1, 0));
        }
        session.SetCamera("/camera", camera);
        EXPECT_EQ(session.Render(settings), RenderResult::Complete);
        return nlohmann::json::parse(session.Statistics())["geometry"]["triangles"];
    }

    Session session;
    Settings settings;
};

TEST_F(SessionDicing, RatesAreThoseOfTheCameraOfThePicture) {
    const std::uint64_t near = Triangles(4.0, false);
    const std::vector<ImageLayer> layers = session.Layers();
    EXPECT_GT(near, 2U * 36U);
    EXPECT_LT(Triangles(400.0, false), near);
    EXPECT_LT(Triangles(4.0, true), near);
    EXPECT_EQ(Triangles(4.0, false), near);
    EXPECT_TRUE(SameLayers(session.Layers(), layers));
}

TEST_F(SessionDicing, AMovingCameraIsDicedForAllAround) {
    const std::uint64_t away = Triangles(4.0, true);
    settings.cameraMoves = true;
    const std::uint64_t allAround = Triangles(4.0, true);
    EXPECT_GT(allAround, away);
    EXPECT_EQ(Triangles(4.0, false), allAround);
    EXPECT_EQ(Triangles(400.0, false), allAround);
    session.Redice();
    EXPECT_LT(Triangles(400.0, false), allAround);
}

} // namespace
} // namespace hds::test
