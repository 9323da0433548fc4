// SPDX-License-Identifier: Apache-2.0
// When a session dices anew: the first camera's rates stay, whatever a still or moving camera does;
// an interactive camera that moves is diced for once, all around; Redice takes the present one.
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
        MeshPrim prim;
        const auto mesh = std::make_shared<MeshDescription>(*MakeGrid(6, 0.5F));
        mesh->subdivisionScheme = "catmullClark";
        prim.mesh = mesh;
        session.SetMesh("/surface", prim);
        settings = MakeSettings();
        settings.camera = "/camera";
        settings.samples = 1;
    }

    /// Triangles after a render from a place on the z axis. \param isAway it looks away.
    std::uint64_t Triangles(double distance, bool isAway, bool showsPreviews) {
        CameraPrim camera;
        camera.worldFromCamera = glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, distance));
        if (isAway) {
            camera.worldFromCamera =
                glm::rotate(camera.worldFromCamera, 3.141592653589793, glm::dvec3(0, 1, 0));
        }
        session.SetCamera("/camera", camera);
        const ProgressCallback goOn = [](const Progress&) { return true; };
        EXPECT_EQ(session.Render(settings, goOn, showsPreviews), RenderResult::Complete);
        return nlohmann::json::parse(session.Statistics())["geometry"]["triangles"];
    }

    Session session;
    Settings settings;
};

TEST_F(SessionDicing, TheFirstCamerasRatesStay) {
    const std::uint64_t near = Triangles(4.0, false, false);
    EXPECT_GT(near, 2U * 36U);
    EXPECT_EQ(Triangles(400.0, false, false), near);
    EXPECT_EQ(Triangles(4.0, true, false), near);
    session.Redice();
    EXPECT_LT(Triangles(400.0, false, false), near);
    session.Redice();
    EXPECT_EQ(Triangles(4.0, false, false), near);
}

TEST_F(SessionDicing, AnInteractiveCameraIsDicedForOnceItMoves) {
    const std::uint64_t away = Triangles(4.0, true, true);
    EXPECT_EQ(Triangles(4.0, true, true), away); // it has not moved
    const std::uint64_t moved = Triangles(4.0, false, true);
    EXPECT_GT(moved, away);
    EXPECT_EQ(Triangles(4.0, true, true), moved); // and may turn back
    EXPECT_EQ(Triangles(400.0, false, true), moved);
}

} // namespace
} // namespace hds::test
