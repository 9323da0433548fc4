// SPDX-License-Identifier: Apache-2.0
// Memory that runs out anywhere in a render is an error that says so; the session renders right
// afterwards.
#include "testenv/support/deviceFixture.h"
#include "testenv/support/sessionScene.h"

#include <string>

namespace hds::test {
namespace {

struct Mode {
    const char* residency;
    const char* geometryMemory;
    const char* geometryEviction;
};

class AllocationFailure : public DeviceFixture, public ::testing::WithParamInterface<Mode> {
protected:
    void TearDown() override { FailAllocation(-1); }

    static Settings MakeStreamSettings() {
        Settings settings = MakeSettings();
        settings.residency = GetParam().residency;
        settings.geometryMemory = GetParam().geometryMemory;
        settings.geometryEviction = GetParam().geometryEviction;
        settings.chunkBytes = 4096;
        return settings;
    }
};

TEST_P(AllocationFailure, IsAnErrorAndNoMore) {
    Session fresh;
    FillSession(&fresh);
    fresh.Render(MakeSettings());
    const std::vector<ImageLayer> expected = fresh.Layers();
    const Settings settings = MakeStreamSettings();
    Session session;
    FillSession(&session);
    int numFailed = 0;
    for (std::int64_t index = 0;; index += 1 + index / 4) {
        FailAllocation(index);
        try {
            session.Render(settings);
            break; // there were not so many
        } catch (const Error& error) {
            const std::string text = error.what();
            EXPECT_EQ(text.rfind("device memory for ", 0), 0U) << text;
            EXPECT_NE(text.find("CL_MEM_OBJECT_ALLOCATION_FAILURE"), std::string::npos) << text;
            EXPECT_EQ(text.find('\n'), std::string::npos) << text;
            EXPECT_FALSE(session.HasImage());
        }
        ++numFailed;
        FailAllocation(-1);
        ASSERT_EQ(session.Render(settings), RenderResult::Complete) << index;
        ASSERT_TRUE(SameLayers(session.Layers(), expected)) << index;
        // What is there already is kept: make the next failure hit an edited scene.
        GeometryPrim ball = session.Scene().geometry.at("/ball");
        ball.geometry = MakeGrid(12, 0.4F);
        session.SetGeometry("/ball", ball);
    }
    EXPECT_GE(numFailed, 5); // buffers of a scene, at least
    FailAllocation(-1);
    ASSERT_EQ(session.Render(settings), RenderResult::Complete);
    EXPECT_TRUE(SameLayers(session.Layers(), expected));
}

INSTANTIATE_TEST_SUITE_P(Modes, AllocationFailure,
                         ::testing::Values(Mode{"resident", "", "lru"},
                                           Mode{"stream", "24K", "lru"},
                                           Mode{"stream", "24K", "flush"}),
                         [](const auto& mode) {
                             return std::string(mode.param.residency) + mode.param.geometryEviction;
                         });

} // namespace
} // namespace hds::test
