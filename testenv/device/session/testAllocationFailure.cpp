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

    /// Renders while an allocation fails. \return whether there was that one.
    static bool FailsOnce(Session* session, const Settings& settings, std::int64_t index) {
        FailAllocation(index);
        bool hasFailed = false;
        try {
            session->Render(settings);
        } catch (const Error& error) {
            hasFailed = true;
            const std::string text = error.what();
            EXPECT_EQ(text.rfind("device memory for ", 0), 0U) << text;
            EXPECT_NE(text.find("CL_MEM_OBJECT_ALLOCATION_FAILURE"), std::string::npos) << text;
            EXPECT_EQ(text.find('\n'), std::string::npos) << text;
            EXPECT_FALSE(session->HasImage());
        }
        FailAllocation(-1);
        return hasFailed;
    }
};

TEST_P(AllocationFailure, IsAnErrorAndNoMore) {
    Session fresh;
    FillSession(&fresh);
    fresh.Render(MakeSettings());
    const std::vector<ImageLayer> expected = fresh.Layers();
    const Settings settings = MakeStreamSettings();
    int numFailed = 0;
    for (std::int64_t index = 0;; index += 1 + index / 4) { // of all that a first render allocates
        Session session;
        FillSession(&session);
        if (!FailsOnce(&session, settings, index)) {
            break; // there were not so many
        }
        ++numFailed;
        ASSERT_EQ(session.Render(settings), RenderResult::Complete) << index;
        ASSERT_TRUE(SameLayers(session.Layers(), expected)) << index;
    }
    EXPECT_GE(numFailed, 10); // buffers of a scene, a film and a wave, at least
    Session session;          // what is there already is kept: failures hit what an edit makes anew
    FillSession(&session);
    ASSERT_EQ(session.Render(settings), RenderResult::Complete);
    for (std::int64_t index = 0; index < 3; ++index) {
        GeometryPrim ball = session.Scene().geometry.at("/ball");
        ball.geometry = MakeGrid(12, 0.4F);
        session.SetGeometry("/ball", ball);
        EXPECT_TRUE(FailsOnce(&session, settings, index)) << index;
        ASSERT_EQ(session.Render(settings), RenderResult::Complete) << index;
        ASSERT_TRUE(SameLayers(session.Layers(), expected)) << index;
    }
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
